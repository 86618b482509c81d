//! Where a vehicle is on its path: one place, from which everything else is an offset.
//!
//! The place is that of the measured vehicle. The predicted vehicle, the axles and the point that
//! stops are projected from it, on the same leg, so that they agree on leg, lap and direction of
//! driving. The place moves with the vehicle, and the path is searched for it only where it is not
//! known:
//!
//! - On a first step, on the whole path. A path of several laps passes a vehicle more than once; of
//!   the places that are as good within the noise of waypoints and poses, the first is taken.
//! - After a jump of the localisation, about the last place, as far as the jump is long; on the whole
//!   path only where that is nearer by more than the jump.
//! - Farther off than `lost_distance`, on the whole path.

use super::follow::{Follow, Located};
use super::index::{Found, STEP_BUDGET};
use super::relocalise::{first_as_good, relocalise_within};
use super::view::PathView;
use crate::error::{InputError, input_within};
use crate::geometry::{Point, get_distance};
use crate::math::{cos, sin, smaller, sqrt};
use crate::vehicle::VehicleState;

/// Where a vehicle is on its path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "Option<Data>", into = "Option<Data>"))]
pub enum Place {
    /// Not yet known: before the first step.
    #[default]
    Unknown,
    /// Where the last step projected it to.
    Known(Spot),
    /// It was there before its localisation jumped, or was sent there by a search: the vehicle is as
    /// far from there as its pose says.
    Lost(Spot),
}

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The segment.
    pub segment: usize,
    /// The point on it [m].
    pub point: Point,
}

/// A [`Place`] as data; none where it is not yet known.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Place")]
struct Data {
    segment: usize,
    point: Point,
    lost: bool,
}

#[cfg(feature = "serde")]
impl From<Option<Data>> for Place {
    fn from(data: Option<Data>) -> Self {
        let Some(data) = data else {
            return Self::Unknown;
        };
        let Data { segment, point, .. } = data;
        let spot = Spot { segment, point };
        if data.lost {
            Self::Lost(spot)
        } else {
            Self::Known(spot)
        }
    }
}

#[cfg(feature = "serde")]
impl From<Place> for Option<Data> {
    fn from(place: Place) -> Self {
        let Spot { segment, point } = place.spot()?;
        let lost = matches!(place, Place::Lost(_));
        Some(Data {
            segment,
            point,
            lost,
        })
    }
}

impl Place {
    /// The place of a vehicle that has been located.
    #[inline]
    pub fn of(at: &Located) -> Self {
        Self::Known(Spot {
            segment: at.closest.segment,
            point: at.closest.point,
        })
    }

    /// That at the start of a segment.
    #[inline]
    pub fn at(path: &PathView<'_>, segment: usize) -> Self {
        let point = path.waypoint(segment);
        Self::Known(Spot { segment, point })
    }

    /// Where it is, or was; None where that is not yet known.
    #[inline]
    pub fn spot(&self) -> Option<Spot> {
        match *self {
            Self::Unknown => None,
            Self::Known(spot) | Self::Lost(spot) => Some(spot),
        }
    }

    /// The segment of that.
    #[inline]
    pub fn segment(&self) -> Option<usize> {
        self.spot().map(|spot| spot.segment)
    }

    /// The same after a jump of the localisation.
    #[inline]
    pub fn lost(self) -> Self {
        self.spot().map_or(Self::Unknown, Self::Lost)
    }

    /// The same moved to another spot.
    pub fn moved(self, spot: Spot) -> Self {
        match self {
            Self::Lost(_) => Self::Lost(spot),
            _ => Self::Known(spot),
        }
    }

    /// The same, where it can be on `path`.
    ///
    /// # Errors
    ///
    /// [`InputError`] where it cannot.
    pub fn checked(self, path: &PathView<'_>) -> Result<Self, InputError> {
        if let Some(Spot { segment, point }) = self.spot() {
            path.check_waypoint("place.segment", Some(segment))?;
            let most = 4.0 * crate::bounds::MAX_COORDINATE;
            input_within("place.point", point.x, most)?;
            input_within("place.point", point.y, most)?;
        }
        Ok(self)
    }
}

/// How much farther one place may be than another, and still be as good, in `opposite_distance`s: a
/// quarter of a wheelbase, which is several standard deviations of the noise in which a vehicle drives.
/// Larger: a first step takes an earlier branch that runs so near beside the vehicle's. Smaller: it
/// takes a later lap.
const AS_GOOD: f64 = 0.075;

impl Follow {
    /// How much farther a place may be, and still be as good as the nearest [m].
    #[inline]
    pub fn noise(&self) -> f64 {
        AS_GOOD * self.opposite_distance
    }

    /// Projects the tracked point of a checked vehicle, which was at `place` and can have `travelled`
    /// so far [m] since, in the period `dt` [s].
    ///
    /// The search of the whole path may run out of [`STEP_BUDGET`] and then gives the best place so
    /// far. A first step takes that place. A lost vehicle takes it only if it is no longer lost
    /// there, and else keeps its last place.
    #[inline]
    pub fn find(
        &self,
        path: &PathView<'_>,
        place: &Place,
        vehicle: VehicleState,
        dt: f64,
        travelled: f64,
    ) -> Located {
        let near = |segment, travelled| self.locate_from(path, segment, vehicle, dt, travelled);
        let is_first = matches!(place, Place::Unknown);
        let (start, reach) = match *place {
            Place::Known(spot) => (path.segment_at(spot.segment), travelled),
            Place::Unknown => (self.first_segment(path, vehicle), travelled),
            Place::Lost(spot) => self.after_jump(path, spot, vehicle, dt, travelled),
        };
        let mut at = near(start, reach);
        if path.reverse().is_some()
            && let Some(next) = self.next_section(path, &at, vehicle)
        {
            at = near(next, travelled);
        }
        let squared_lost = self.lost_distance * self.lost_distance;
        if at.closest.squared_distance > squared_lost {
            let found = self.find_anew(path, vehicle);
            let anew = near(found.segment, travelled);
            let is_found = found.is_exact || anew.closest.squared_distance <= squared_lost;
            if is_found && anew.closest.squared_distance < at.closest.squared_distance {
                at = anew;
            }
            at.off_path = true;
        }
        at.direction_changed = !is_first && at.reverse != path.is_reverse(start);
        at
    }

    /// Projects the tracked point of a checked vehicle near segment `waypoint`, from which it can
    /// have `travelled` so far [m] in the period `dt` [s]; on the whole path if that is none. As
    /// [`find`](Self::find).
    #[inline]
    pub fn locate_within(
        &self,
        path: &PathView<'_>,
        waypoint: Option<usize>,
        vehicle: VehicleState,
        dt: f64,
        travelled: f64,
    ) -> Located {
        let place = waypoint.map_or(Place::Unknown, |segment| Place::at(path, segment));
        self.find(path, &place, vehicle, dt, travelled)
    }

    /// The same of a vehicle that has travelled at its present speed.
    #[inline]
    pub fn locate(
        &self,
        path: &PathView<'_>,
        waypoint: Option<usize>,
        vehicle: VehicleState,
        dt: f64,
    ) -> Located {
        let travelled = vehicle.speed.abs() * dt;
        self.locate_within(path, waypoint, vehicle, dt, travelled)
    }

    /// Projects the tracked point of the same vehicle elsewhere, as it is predicted to be or by another
    /// pose: as an offset from where it is located, `at`, on the same leg.
    #[inline]
    pub fn offset(
        &self,
        path: &PathView<'_>,
        at: &Located,
        vehicle: VehicleState,
        travelled: f64,
    ) -> Located {
        let along = at.closest.along();
        let moved = Point::new(vehicle.x - at.vehicle.x, vehicle.y - at.vehicle.y).dot(&along);
        let arc = at.closest.arc_length(path) + moved / sqrt(along.dot(&along));
        let segment = on_leg(path, at.closest.segment, arc);
        Located {
            direction_changed: at.direction_changed,
            off_path: at.off_path,
            ..self.locate_from(path, segment, vehicle, at.dt, travelled)
        }
    }

    /// Where to start from, and how far it can be from there [m], for a vehicle whose localisation has
    /// jumped.
    #[cold]
    fn after_jump(
        &self,
        path: &PathView<'_>,
        spot: Spot,
        vehicle: VehicleState,
        dt: f64,
        travelled: f64,
    ) -> (usize, f64) {
        let near = |segment, travelled| self.locate_from(path, segment, vehicle, dt, travelled);
        let start = path.segment_at(spot.segment);
        let jump = get_distance(spot.point, near(start, travelled).position);
        let reach = travelled + jump;
        let found = self.find_anew(path, vehicle).segment;
        let distance = |at: Located| sqrt(at.closest.squared_distance);
        let explained = smaller(jump, self.opposite_distance);
        if distance(near(start, reach)) <= distance(near(found, travelled)) + explained {
            (start, reach)
        } else {
            (found, travelled)
        }
    }

    /// The segment of a vehicle that was on no path before.
    #[cold]
    fn first_segment(&self, path: &PathView<'_>, vehicle: VehicleState) -> usize {
        let found = self.find_anew(path, vehicle).segment;
        if path.is_closed() {
            return found;
        }
        let base = vehicle.ahead(self.base);
        let position = Point::new(base.x, base.y);
        if self.is_before_lap(path, found, position, vehicle.yaw) {
            return 0;
        }
        let (opposite, noise) = (self.opposite_distance, self.noise());
        first_as_good(
            path,
            position,
            vehicle.yaw,
            opposite,
            (found, noise),
            STEP_BUDGET,
        )
    }

    /// Whether a vehicle beside the last stretch, on segment `found`, of an open path that ends where it
    /// began stands before its start: laps are driven from their beginning.
    fn is_before_lap(&self, path: &PathView<'_>, found: usize, position: Point, yaw: f64) -> bool {
        let reach = self.search_distance;
        let (first, next) = path.segment(0);
        let last = path.waypoint(path.len() - 1);
        let forward = (next.x - first.x) * cos(yaw) + (next.y - first.y) * sin(yaw) > 0.0;
        let is_lap = path.length() > 4.0 * reach && get_distance(first, last) <= 0.5 * reach;
        let is_near = get_distance(first, position) <= reach;
        let at_end = path.arc(found) >= path.length() - 2.0 * reach;
        is_lap && at_end && is_near && forward && !path.is_reverse(0)
    }

    /// Searches the whole path for the vehicle's `base`.
    #[cold]
    pub(super) fn find_anew(&self, path: &PathView<'_>, vehicle: VehicleState) -> Found {
        let base = vehicle.ahead(self.base);
        let position = Point::new(base.x, base.y);
        let opposite_distance = self.opposite_distance;
        relocalise_within(path, position, vehicle.yaw, opposite_distance, STEP_BUDGET)
    }
}

/// The segment at `arc` [m] of the leg that segment `from` is on; the nearer end of that leg beyond it.
#[inline]
fn on_leg(path: &PathView<'_>, from: usize, arc: f64) -> usize {
    let length = path.length();
    let around = if arc < 0.0 { length } else { -length };
    let beyond = path.is_closed() && !(0.0..length).contains(&arc);
    let segment = path.segment_by_arc(if beyond { arc + around } else { arc }, from);
    if path.reverse().is_none() || path.section(from) == path.section(segment) {
        return segment;
    }
    let ahead = arc > path.arc(from);
    path.section(from)
        .map_or(segment, |(first, last)| if ahead { last } else { first })
}
