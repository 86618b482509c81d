//! A point of the vehicle, followed along the path: forwards, backwards, and through the places
//! where it turns round.
//!
//! A vehicle that backs up is, for a kinematic bicycle exactly, one that drives forward with its
//! heading turned by half a circle, its axles mirrored about the rear axle and its steering
//! negated. So the laws are written for driving forward only: [`Follow::locate`] hands them the
//! mirrored vehicle where the path is driven backwards, and they negate what they answer.

use super::locate::{Foot, locate};
use super::relocalise::relocalise;
use super::view::PathView;
use crate::Point;
use crate::math::{PI, cos, sin, sqrt};
use crate::vehicle::VehicleState;

/// Which point of the vehicle is followed, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follow {
    /// How far ahead of the pose's point the vehicle is mirrored where it drives backwards [m]: the
    /// rear axle, or the point that does not slip.
    pub base: f64,
    /// How far ahead of `base` the followed point lies, in the direction of driving [m].
    pub reference_offset: f64,
    /// How far along the path from its last place the point is looked for [m], beside what the
    /// vehicle travels in a step.
    pub search_distance: f64,
    /// Farther than this from its place on the path the vehicle is lost, and looked for on the
    /// whole of it [m].
    pub lost_distance: f64,
    /// `base` has come to where the vehicle turns round when it is this near [m].
    pub arrival_distance: f64,
}

/// Where the followed point is, with the vehicle as one that drives forward.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each says one thing of one step"
)]
pub struct Located {
    /// The followed point [m].
    pub position: Point,
    /// Its foot on the path.
    pub foot: Foot,
    /// The vehicle, turned round where the path is driven backwards: speed positive along it.
    pub vehicle: VehicleState,
    /// The unit vector along the turned vehicle's heading.
    pub heading: Point,
    /// Control period [s].
    pub dt: f64,
    /// Whether the path is driven backwards here.
    pub reverse: bool,
    /// Whether the direction is another than at the last step.
    pub turned: bool,
    /// Whether the vehicle was lost, or is.
    pub off_path: bool,
    /// Whether the point is past the last waypoint of an open path.
    pub past_end: bool,
}

impl Follow {
    /// Finds the point of a checked vehicle that was last at `waypoint`, on the whole path where
    /// that is none.
    #[inline]
    pub fn locate(
        &self,
        path: &PathView<'_>,
        waypoint: Option<usize>,
        vehicle: VehicleState,
        dt: f64,
    ) -> Located {
        let start = match waypoint {
            Some(waypoint) => path.segment_at(waypoint),
            None => find_anew(path, vehicle.ahead(self.base)),
        };
        let mut at = self.locate_from(path, start, vehicle, dt);
        if path.reverse().is_some()
            && let Some(next) = self.next_section(path, &at.foot, vehicle)
        {
            at = self.locate_from(path, next, vehicle, dt);
        }
        if at.foot.squared_distance > self.lost_distance * self.lost_distance {
            let anew = find_anew(path, vehicle.ahead(self.base));
            let anew = self.locate_from(path, anew, vehicle, dt);
            if anew.foot.squared_distance < at.foot.squared_distance {
                at = anew;
            }
            at.off_path = true;
        }
        at.turned = waypoint.is_some() && at.reverse != path.is_reverse(start);
        at
    }

    #[inline]
    fn locate_from(
        &self,
        path: &PathView<'_>,
        segment: usize,
        vehicle: VehicleState,
        dt: f64,
    ) -> Located {
        let reverse = path.is_reverse(segment);
        let vehicle = if reverse {
            VehicleState {
                yaw: vehicle.yaw + PI,
                speed: -vehicle.speed,
                ..vehicle
            }
        } else {
            vehicle
        };
        let heading = Point::new(cos(vehicle.yaw), sin(vehicle.yaw));
        let base = if reverse { -self.base } else { self.base };
        let ahead = self.reference_offset + base;
        let position = Point::new(vehicle.x + ahead * heading.x, vehicle.y + ahead * heading.y);
        let reach = self.search_distance + vehicle.speed.abs() * dt;
        let foot = locate(path, segment, position, heading, reach);
        Located {
            position,
            foot,
            vehicle,
            heading,
            dt,
            reverse,
            turned: false,
            off_path: false,
            past_end: foot.fraction > 1.0 && path.next_segment(foot.segment).is_none(),
        }
    }

    /// The segment to go on with where the vehicle turns round, once its `base` is there.
    ///
    /// That is one event for all that follow the vehicle, wherever their own point is: the foot
    /// of each only has to be near enough to tell which end is meant.
    fn next_section(
        &self,
        path: &PathView<'_>,
        foot: &Foot,
        vehicle: VehicleState,
    ) -> Option<usize> {
        let behind = if self.reference_offset < 0.0 {
            -self.reference_offset
        } else {
            0.0
        };
        let near = behind + 4.0 * self.arrival_distance;
        let mut last = foot.segment;
        let mut rest = (1.0 - foot.fraction) * path.segment_length(last);
        for _ in 0..path.segments() {
            let Some(following) = path.following(last) else {
                return self.turn_round(path, last, vehicle);
            };
            rest += path.segment_length(following);
            if rest > near {
                break;
            }
            last = following;
        }
        None
    }

    /// The segment after `last`, at whose end the vehicle turns round, once its `base` is there.
    fn turn_round(&self, path: &PathView<'_>, last: usize, vehicle: VehicleState) -> Option<usize> {
        let next = path.next_segment(last)?;
        let (start, end) = path.segment(last);
        let along = end - start;
        let to = end - vehicle.point_ahead(self.base);
        let length = sqrt(along.x * along.x + along.y * along.y);
        let left = (to.x * along.x + to.y * along.y) / length;
        (left <= self.arrival_distance).then_some(next)
    }
}

/// The segment where a vehicle is found after a jump, by the pose of its `base`.
#[cold]
pub fn find_anew(path: &PathView<'_>, vehicle: VehicleState) -> usize {
    relocalise(path, Point::new(vehicle.x, vehicle.y), vehicle.yaw)
}

impl Located {
    /// The law's answer for the turned vehicle as the angle of the vehicle itself, and the other
    /// way round [rad].
    #[inline]
    pub fn turn(&self, steer: f64) -> f64 {
        if self.reverse { -steer } else { steer }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use alloc::vec;
    use alloc::vec::Vec;

    const FOLLOW: Follow = Follow {
        base: 0.0,
        reference_offset: 3.0,
        search_distance: 6.0,
        lost_distance: 30.0,
        arrival_distance: 0.15,
    };

    /// 20 m forward along x, 10 m back, 20 m forward again.
    fn shuttle() -> Path {
        let x: [f64; 6] = [0.0, 10.0, 20.0, 10.0, 20.0, 30.0];
        let path = Path::new(&x, &[0.0; 6], None, false).unwrap();
        path.with_reverse(&[false, false, true, false, false, false])
            .unwrap()
    }

    fn at(x: f64, y: f64, speed: f64) -> VehicleState {
        VehicleState {
            x,
            y,
            yaw: 0.0,
            speed,
        }
    }

    #[test]
    fn test_follow_turns_round_when_the_rear_axle_has_come() {
        let path = shuttle();
        let view = path.view();
        let forward = FOLLOW.locate(&view, Some(1), at(19.0, 0.5, 1.0), 0.05);
        assert!(!forward.reverse && !forward.turned && forward.foot.segment == 1);
        assert_eq!(forward.foot.point, Point::new(22.0, 0.0));
        assert_eq!(forward.foot.cross_track_error(), 0.5);

        let back = FOLLOW.locate(&view, Some(1), at(19.9, 0.5, 0.3), 0.05);
        assert!(back.reverse && back.turned && back.foot.segment == 2);
        assert!((back.position.x - 16.9).abs() < 1e-12);
        assert_eq!(back.vehicle.speed, -0.3);
        // The path leads the other way: its left is the vehicle's right.
        assert!((back.foot.cross_track_error() + 0.5).abs() < 1e-12);

        let again = FOLLOW.locate(&view, Some(2), at(10.1, 0.0, -0.3), 0.05);
        assert!(!again.reverse && again.turned && again.foot.segment == 3);
    }

    #[test]
    fn test_follow_goes_by_the_base_whichever_point_the_pose_is_of() {
        let shuttle = shuttle();
        // There, and back 3 m beside.
        let x = [-30.0, -10.0, 10.0, 30.0, 30.0, 10.0, -10.0, -30.0];
        let y = [0.0, 0.0, 0.0, 0.0, 3.0, 3.0, 3.0, 3.0];
        let beside = Path::new(&x, &y, None, false).unwrap();
        for base in [0.0, -1.35, -3.0, 0.8] {
            let follow = Follow { base, ..FOLLOW };
            let turned = |x: f64| {
                let pose = at(x, 0.5, 0.3).ahead(-base);
                let found = follow.locate(&shuttle.view(), Some(1), pose, 0.05);
                found.turned
            };
            assert!(!turned(19.8) && turned(19.9));
            // Across both, nearer to the first.
            let across = VehicleState {
                yaw: 0.5 * PI,
                ..at(0.0, 1.0, 0.3)
            };
            let found = follow.locate(&beside.view(), None, across.ahead(-base), 0.05);
            assert_eq!(found.foot.segment, 1);
        }
    }

    #[test]
    fn test_follow_turns_round_at_one_place_whatever_point_is_followed() {
        // 4 m forward and back in steps of 0.1 m: what is near lies on several segments.
        let there: Vec<f64> = (0..=40).map(|k| 0.1 * f64::from(k)).collect();
        let x: Vec<f64> = there
            .iter()
            .chain(there.iter().rev().skip(1))
            .copied()
            .collect();
        let back: Vec<bool> = (0..x.len()).map(|k| k >= 40).collect();
        let path = Path::new(&x, &vec![0.0; x.len()], None, false).unwrap();
        let path = path.with_reverse(&back).unwrap();
        for reference_offset in [3.0, 0.0, -1.5] {
            let follow = Follow {
                reference_offset,
                ..FOLLOW
            };
            for (x, turned) in [(3.7, false), (3.84, false), (3.86, true), (4.1, true)] {
                let last = crate::math::to_count((x + reference_offset).clamp(0.0, 3.9) / 0.1);
                let found = follow.locate(&path.view(), Some(last), at(x, 0.2, 0.3), 0.05);
                assert_eq!(found.turned, turned, "{reference_offset} {x}");
            }
        }
    }

    #[test]
    fn test_follow_round_a_path_driven_backwards_never_turns_round() {
        let (x, y) = ([0.0, 1e-8, 1e-8, 0.0], [0.0, 0.0, 1e-8, 1e-8]);
        let path = Path::new(&x, &y, None, true).unwrap();
        let path = path.with_reverse(&[true; 4]).unwrap();
        let found = FOLLOW.locate(&path.view(), Some(1), at(0.0, 0.1, -1.0), 0.05);
        assert!(found.reverse && !found.turned);
    }

    #[test]
    fn test_follow_round_a_tiny_path_driven_backwards_comes_to_an_end() {
        let (x, y) = ([0.0, 2e-9, 0.0], [0.0, 0.0, 2e-9]);
        let path = Path::new(&x, &y, None, true).unwrap();
        let path = path.with_reverse(&[true; 3]).unwrap();
        let follow = Follow {
            reference_offset: -1e3,
            ..FOLLOW
        };
        let found = follow.locate(&path.view(), Some(0), at(0.0, 0.0, -1.0), 0.05);
        assert!(found.reverse && !found.turned);
    }

    #[test]
    fn test_follow_lost_is_found_anew_and_said_so() {
        let x = [0.0, 100.0, 200.0, 300.0];
        let path = Path::new(&x, &[0.0; 4], None, false).unwrap();
        let near = FOLLOW.locate(&path.view(), Some(0), at(20.0, 29.0, 5.0), 0.05);
        assert!(!near.off_path);
        let found = FOLLOW.locate(&path.view(), Some(0), at(240.0, 2.0, 5.0), 0.05);
        assert!(found.off_path && found.foot.segment == 2);
        let lost = FOLLOW.locate(&path.view(), Some(0), at(40.0, 31.0, 5.0), 0.05);
        assert!(lost.off_path && lost.foot.segment == 0);
    }
}
