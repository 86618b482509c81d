//! Where am I? The exact foot on the path, looked for along the arc around the last one.
//!
//! [`locate_by_scan`] looks at every segment of a bounded stretch and is the definition;
//! [`locate`] looks at those beside the last foot, and past the rest where none of them can
//! matter.

use super::view::{PathView, squared_distance};
use crate::Point;
use crate::math::{atan2, saturate, sqrt};

/// How much farther off a foot counts where the path leads the opposite way [m].
pub const OPPOSITE: f64 = 10.0;

/// The foot of a position on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The segment that carries the foot.
    pub segment: usize,
    /// Where on the segment: 0 at its start, 1 at its end; beyond both on the extensions.
    pub fraction: f64,
    /// The foot [m].
    pub point: Point,
    /// Arc length at the foot [m].
    pub arc_length: f64,
    /// Signed distance to the foot [m], positive left of the path.
    pub cross_track_error: f64,
    /// Direction of the segment [rad].
    pub path_yaw: f64,
}

/// The waypoint nearest to `position` of all; the first of several. Visits every waypoint.
pub fn nearest_waypoint(path: &PathView<'_>, position: Point) -> usize {
    let mut nearest = 0;
    let mut least = f64::INFINITY;
    for (index, (&x, &y)) in path.x().iter().zip(path.y()).enumerate() {
        let distance = squared_distance(position, Point::new(x, y));
        if distance < least {
            least = distance;
            nearest = index;
        }
    }
    nearest
}

/// Projects `position` exactly onto the two segments at waypoint `nearest`; the nearer foot
/// counts, the segment ahead where both are as near.
///
/// Before the first and beyond the last waypoint of an open path the end segments go on as
/// straight lines, so the cross-track error stays the offset to the side.
#[inline]
pub fn project(path: &PathView<'_>, nearest: usize, position: Point) -> Projection {
    let incoming = path.previous(nearest);
    let outgoing = path.next(nearest).map(|_| nearest);
    let foot = match (incoming, outgoing) {
        (Some(incoming), Some(outgoing)) => {
            let behind = Foot::new(path, incoming, position);
            let ahead = Foot::new(path, outgoing, position);
            if behind.squared_distance < ahead.squared_distance {
                behind
            } else {
                ahead
            }
        }
        (Some(only), None) | (None, Some(only)) => Foot::new(path, only, position),
        (None, None) => Foot::new(path, nearest, position),
    };
    foot.projection(path)
}

/// The foot of a position on one segment: what is needed to choose between several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The segment that carries the foot.
    pub segment: usize,
    /// Where on the segment: 0 at its start, 1 at its end; beyond both on the extensions.
    pub fraction: f64,
    /// The foot [m].
    pub point: Point,
    /// Square of the distance to the foot [m^2].
    pub squared_distance: f64,
    along: Point,
    squared_length: f64,
    side: f64,
}

impl Foot {
    /// The foot of `position` on segment `segment`. Where the path ends, or turns round for the
    /// vehicle to go on the other way, the segment goes on as a straight line.
    #[inline]
    pub fn new(path: &PathView<'_>, segment: usize, position: Point) -> Self {
        let low = match path.preceding(segment) {
            Some(_) => 0.0,
            None => f64::NEG_INFINITY,
        };
        let high = match path.following(segment) {
            Some(_) => 1.0,
            None => f64::INFINITY,
        };
        Self::between(path, segment, position, low, high)
    }

    /// The foot of `position` on what lies between both ends of the segment.
    #[inline]
    pub(super) fn within(path: &PathView<'_>, segment: usize, position: Point) -> Self {
        Self::between(path, segment, position, 0.0, 1.0)
    }

    #[inline]
    fn between(path: &PathView<'_>, segment: usize, position: Point, low: f64, high: f64) -> Self {
        let (start, end) = path.segment(segment);
        let along = end - start;
        let to = position - start;
        let squared_length = along.x * along.x + along.y * along.y;
        let fraction = saturate(
            (to.x * along.x + to.y * along.y) / squared_length,
            low,
            high,
        );
        let point = Point::new(start.x + fraction * along.x, start.y + fraction * along.y);
        Self {
            segment,
            fraction,
            point,
            along,
            squared_length,
            squared_distance: squared_distance(position, point),
            side: along.x * to.y - along.y * to.x,
        }
    }

    /// All about the foot.
    #[inline]
    pub fn projection(&self, path: &PathView<'_>) -> Projection {
        Projection {
            segment: self.segment,
            fraction: self.fraction,
            point: self.point,
            arc_length: self.arc_length(path),
            cross_track_error: self.cross_track_error(),
            path_yaw: self.path_yaw(),
        }
    }

    /// Arc length at the foot [m].
    #[inline]
    pub fn arc_length(&self, path: &PathView<'_>) -> f64 {
        path.arc(self.segment) + self.fraction * sqrt(self.squared_length)
    }

    /// Signed distance to the foot [m], positive left of the path.
    #[inline]
    pub fn cross_track_error(&self) -> f64 {
        sqrt(self.squared_distance).copysign(self.side)
    }

    /// Direction of the segment [rad].
    #[inline]
    pub fn path_yaw(&self) -> f64 {
        atan2(self.along.y, self.along.x)
    }

    /// From the start of the segment to its end [m].
    #[inline]
    pub fn along(&self) -> Point {
        self.along
    }

    /// The end of the segment that is nearer to the foot; its start where both are as near.
    #[inline]
    pub fn nearest_waypoint(&self, path: &PathView<'_>) -> usize {
        if self.fraction > 0.5 {
            path.next(self.segment).unwrap_or(self.segment)
        } else {
            self.segment
        }
    }

    /// Distance [m], and up to [`OPPOSITE`] more the less the path leads along the unit vector
    /// `heading`.
    #[inline]
    pub(super) fn cost(&self, heading: Point) -> f64 {
        let along =
            (heading.x * self.along.x + heading.y * self.along.y) / sqrt(self.squared_length);
        sqrt(self.squared_distance) + 0.5 * OPPOSITE * (1.0 - along)
    }
}

/// The foot of `position` within `reach` [m] of arc before and behind the segment at `waypoint`,
/// for a vehicle that drives along the unit vector `heading`; see [`locate_by_scan`], whose
/// answer this is.
#[inline]
pub fn locate(
    path: &PathView<'_>,
    waypoint: usize,
    position: Point,
    heading: Point,
    reach: f64,
) -> Foot {
    locate_nearby(path, waypoint, position, heading, reach)
        .unwrap_or_else(|| locate_by_scan(path, waypoint, position, heading, reach))
}

/// The foot of `position` by the definition: of the segments from the one at `waypoint` until
/// more than `reach` [m] of arc before and behind it, each segment that is no farther off than
/// the one before it and nearer than the one after it is a candidate. The candidate of least
/// distance counts, each distance with up to [`OPPOSITE`] more the less the path leads along
/// `heading`; of several the first.
///
/// The stretch ends where an open path does, where the vehicle has to change its direction, and
/// once around a closed path. So the foot cannot leap to another branch: farther along the path
/// than `reach` it does not look, and within it the heading tells branches apart.
#[cold]
pub fn locate_by_scan(
    path: &PathView<'_>,
    waypoint: usize,
    position: Point,
    heading: Point,
    reach: f64,
) -> Foot {
    let (first, last) = stretch(path, path.segment_at(waypoint), reach);
    let mut here = Foot::new(path, first, position);
    let mut behind = f64::INFINITY;
    let (mut best, mut least) = (here, f64::INFINITY);
    for _ in 0..path.segments() {
        let next = if here.segment == last {
            None
        } else {
            path.following(here.segment)
                .map(|next| Foot::new(path, next, position))
        };
        let ahead = next.map_or(f64::INFINITY, |next| next.squared_distance);
        if here.squared_distance <= behind && here.squared_distance < ahead {
            let cost = here.cost(heading);
            if cost < least {
                (best, least) = (here, cost);
            }
        }
        behind = here.squared_distance;
        match next {
            Some(next) => here = next,
            None => break,
        }
    }
    best
}

/// The first and the last segment of the stretch around `segment`.
fn stretch(path: &PathView<'_>, segment: usize, reach: f64) -> (usize, usize) {
    let (mut first, mut last) = (segment, segment);
    let (mut behind, mut ahead) = (0.0, 0.0);
    let mut left = path.segments() - 1;
    while left > 0 && behind <= reach {
        let Some(previous) = path.preceding(first) else {
            break;
        };
        behind += path.segment_length(previous);
        first = previous;
        left -= 1;
    }
    while left > 0 && ahead <= reach {
        let Some(next) = path.following(last) else {
            break;
        };
        ahead += path.segment_length(next);
        last = next;
        left -= 1;
    }
    (first, last)
}

/// More than rounding can move a foot or a waypoint within the bounds of coordinates [m].
const MARGIN: f64 = 1e-6;

/// What the scan finds, where that is certain from the feet beside the last one; none where a
/// place farther along could be as good.
#[inline]
fn locate_nearby(
    path: &PathView<'_>,
    waypoint: usize,
    position: Point,
    heading: Point,
    reach: f64,
) -> Option<Foot> {
    // Around a path this short both ways meet.
    if path.is_closed() && path.length() <= 2.0 * reach + 4.0 * path.longest() {
        return None;
    }
    let start = path.segment_at(waypoint);
    let mut foot = Foot::new(path, start, position);
    let mut ahead = Way::new(path, start, &foot, true, reach);
    let mut behind = Way::new(path, start, &foot, false, reach);
    // Downhill to the candidate; ahead first, as the scan takes the last of several as near.
    while let Some(next) = ahead.foot(position) {
        if next.squared_distance > foot.squared_distance {
            break;
        }
        foot = next;
    }
    if foot.segment == start {
        while let Some(previous) = behind.foot(position) {
            if previous.squared_distance >= foot.squared_distance {
                break;
            }
            foot = previous;
        }
    }
    let limit = foot.cost(heading) + MARGIN;
    (ahead.clears(position, limit) && behind.clears(position, limit)).then_some(foot)
}

/// The segments on one side of the last foot, outwards, as far as the stretch goes.
struct Way<'a> {
    path: &'a PathView<'a>,
    segment: usize,
    /// Squared distance to the last segment, as the scan has it; infinite where that is not known.
    inner: f64,
    /// Arc passed, the segment included [m].
    arc: f64,
    reach: f64,
    ahead: bool,
}

impl<'a> Way<'a> {
    #[inline]
    fn new(path: &'a PathView<'a>, segment: usize, foot: &Foot, ahead: bool, reach: f64) -> Self {
        Self {
            path,
            segment,
            inner: foot.squared_distance,
            arc: 0.0,
            reach,
            ahead,
        }
    }

    /// The next segment outwards, while the stretch goes on.
    #[inline]
    fn advance(&mut self) -> Option<usize> {
        if self.arc > self.reach {
            return None;
        }
        let next = self.beyond(self.segment)?;
        self.arc += self.path.segment_length(next);
        self.segment = next;
        Some(next)
    }

    #[inline]
    fn beyond(&self, segment: usize) -> Option<usize> {
        if self.ahead {
            self.path.following(segment)
        } else {
            self.path.preceding(segment)
        }
    }

    /// The foot on the next segment.
    #[inline]
    fn foot(&mut self, position: Point) -> Option<Foot> {
        let foot = Foot::new(self.path, self.advance()?, position);
        self.inner = foot.squared_distance;
        Some(foot)
    }

    /// Whether no segment farther out can be a candidate of the scan at a cost up to `limit`.
    #[inline]
    fn clears(mut self, position: Point, limit: f64) -> bool {
        loop {
            let passed = self.arc;
            let Some(segment) = self.advance() else {
                return true;
            };
            let (start, end) = self.path.segment(segment);
            let (along, to) = (end - start, position - start);
            let squared_length = along.x * along.x + along.y * along.y;
            let along_it = to.x * along.x + to.y * along.y;
            // The inner end, and whether it is the foot: the same bits as the scan's.
            let (near, is_foot) = if self.ahead {
                (start, along_it <= 0.0)
            } else {
                (start + along, along_it >= squared_length)
            };
            let distance = squared_distance(position, near);
            // From here to the end of the stretch the distance falls by less than the arc grows.
            let rest = self.reach - passed + self.path.longest();
            let within = limit + rest + MARGIN;
            if distance > within * within && !self.comes_to_an_end(segment, rest) {
                return true;
            }
            let rises = if self.ahead {
                distance > self.inner
            } else {
                distance >= self.inner
            };
            if is_foot && (rises || distance > limit * limit) {
                self.inner = distance;
                continue;
            }
            let ends = self.beyond(segment).is_none();
            if ends || distance <= 2.0 * (limit * limit + squared_length) + MARGIN {
                return false;
            }
            self.inner = f64::INFINITY;
        }
    }

    /// Whether the path may end, or turn round, within `rest` [m] of arc from `segment`: its last
    /// segment goes on without an end.
    #[inline]
    fn comes_to_an_end(&self, segment: usize, rest: f64) -> bool {
        let path = self.path;
        let room = if self.ahead {
            path.length() - path.arc(segment)
        } else {
            path.arc(segment)
        };
        path.reverse().is_some() || !path.is_closed() && room <= rest + 2.0 * path.longest()
    }
}

/// Direction of the segment that leads to waypoint `nearest` [rad], of the one that leaves it
/// where none does: the path's heading as the published code takes it, up to a waypoint and a
/// half behind the foot.
pub fn path_yaw_behind(path: &PathView<'_>, nearest: usize) -> f64 {
    let (start, end) = path.segment(path.previous(nearest).unwrap_or(nearest));
    atan2(end.y - start.y, end.x - start.x)
}

/// The reference speed at a projection [m/s], negative where the path is driven backwards; the
/// magnitudes are taken linearly between the waypoints'. None where the path has no speeds.
pub fn reference_speed(path: &PathView<'_>, projection: &Projection) -> Option<f64> {
    let speed = path.speed()?;
    let here = speed.get(projection.segment)?.abs();
    let next = speed.get(path.next(projection.segment)?)?.abs();
    let magnitude = here + saturate(projection.fraction, 0.0, 1.0) * (next - here);
    Some(if path.is_reverse(projection.segment) {
        -magnitude
    } else {
        magnitude
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use crate::math::{cos, sin};
    use alloc::vec::Vec;
    use proptest::prelude::*;

    fn bent() -> Path {
        Path::new(
            &[0.0, 10.0, 10.0],
            &[0.0, 0.0, 10.0],
            Some(&[1.0, 2.0, 4.0]),
            false,
        )
        .unwrap()
    }

    #[test]
    fn test_project_either_side_signs_the_error() {
        let path = bent();
        let left = project(&path.view(), 0, Point::new(4.0, 1.5));
        assert_eq!((left.segment, left.cross_track_error), (0, 1.5));
        assert!((left.fraction - 0.4).abs() < 1e-15);
        let right = project(&path.view(), 1, Point::new(12.0, 5.0));
        assert_eq!((right.segment, right.cross_track_error), (1, -2.0));
        assert_eq!(reference_speed(&path.view(), &right), Some(3.0));
    }

    #[test]
    fn test_project_beyond_the_end_measures_to_the_side() {
        let path = bent();
        let beyond = project(&path.view(), 2, Point::new(9.0, 14.0));
        assert_eq!(beyond.cross_track_error, 1.0);
        assert_eq!(reference_speed(&path.view(), &beyond), Some(4.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

        #[test]
        fn test_locate_is_what_the_scan_finds(
            steps in proptest::collection::vec(
                (prop_oneof![Just(1.0), 0.01..3.0, Just(20.0)], -3.0..3.0_f64), 2..60),
            bend in prop_oneof![Just(0.0), Just(0.05), Just(0.4), Just(1.0)],
            origin in prop_oneof![Just(0.0), -1e3..1e3, Just(1e7), Just(-1e9)],
            lattice in any::<bool>(),
            turns in proptest::collection::vec(any::<bool>(), 60),
            closed in any::<bool>(),
            reversing in any::<bool>(),
            at in 0_usize..60,
            aside in (prop_oneof![Just(0.0), -12.0..12.0], prop_oneof![Just(0.0), -12.0..12.0]),
            yaw in -3.2..3.2_f64,
            aligned in any::<bool>(),
            reach in prop_oneof![Just(6.0), 0.0..30.0],
            last in 0_usize..60,
            near in any::<bool>(),
        ) {
            let (mut x, mut y, mut heading) = (origin, -origin, 0.3);
            let (mut xs, mut ys) = (Vec::new(), Vec::new());
            for (length, turn) in steps {
                xs.push(x);
                ys.push(y);
                heading += bend * turn;
                let (dx, dy) = (length * cos(heading), length * sin(heading));
                if lattice {
                    x += crate::math::from_count(crate::math::to_count(dx.abs())).copysign(dx);
                    y += 1.0 + crate::math::from_count(crate::math::to_count(dy.abs()));
                } else {
                    x += dx;
                    y += dy;
                }
            }
            let Ok(path) = Path::new(&xs, &ys, None, closed && xs.len() > 2) else {
                return Ok(());
            };
            let path = if reversing {
                path.with_reverse(turns.get(..xs.len()).unwrap()).unwrap()
            } else {
                path
            };
            let view = path.view();
            let at = view.segment_at(at % view.len());
            let (start, end) = view.segment(at);
            let middle = 0.5 * (start + end);
            let position = Point::new(middle.x + aside.0, middle.y + aside.1);
            let yaw = if aligned {
                atan2(end.y - start.y, end.x - start.x) + 0.1 * yaw
            } else {
                yaw
            };
            let heading = Point::new(cos(yaw), sin(yaw));
            let last = if near { (at + last % 5) % view.len() } else { last % view.len() };
            let scanned = locate_by_scan(&view, last, position, heading, reach);
            prop_assert_eq!(locate(&view, last, position, heading, reach), scanned);
        }
    }

    #[test]
    fn test_locate_decides_without_the_scan_in_plain_driving() {
        let x: Vec<f64> = (0..400).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| 5.0 * sin(x / 20.0)).collect();
        let path = Path::new(&x, &y, None, false).unwrap();
        let heading = |at: f64| {
            let slope = 0.25 * cos(at / 20.0);
            Point::new(1.0, slope) / sqrt(1.0 + slope * slope)
        };
        let decided = (0..3900).filter(|&k| {
            let at = 0.1 * f64::from(k);
            let position = Point::new(at, 5.0 * sin(at / 20.0) + 0.3);
            let last = crate::math::to_count(at);
            locate_nearby(&path.view(), last, position, heading(at), 6.0).is_some()
        });
        assert!(decided.count() > 3890);
    }

    #[test]
    fn test_locate_out_and_back_keeps_to_the_branch_of_the_heading() {
        let x: Vec<f64> = (0..100).chain((0..100).rev()).map(f64::from).collect();
        let y: Vec<f64> = (0..200).map(|k| if k < 100 { 0.0 } else { 0.5 }).collect();
        let path = Path::new(&x, &y, None, false).unwrap();
        // Nearer to the other branch all the way, and near the turn.
        for (at, last) in [(50.2, 50), (95.7, 95), (97.5, 97)] {
            let position = Point::new(at, 0.4);
            let there = locate(&path.view(), last, position, Point::new(1.0, 0.0), 6.0);
            assert_eq!(there.segment, last);
            let turned = locate(&path.view(), last, position, Point::new(-1.0, 0.0), 6.0);
            assert_eq!(turned.segment > 99, at > 95.0);
        }
    }
}
