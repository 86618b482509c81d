//! A path driven backwards against the same driven forwards.

use crate::bytes::Bytes;
use crate::scene::{dt, vehicle};
use crate::subject::Subject;
use popsteer_core::path::{Place, Spot};
use popsteer_core::{Command, Path, Point, Reported, Tracker, Vehicle};
use std::f64::consts::PI;

/// Backing up is driving forward with the heading turned round, the axles mirrored about the pose's
/// point and the wheels to the other side.
///
/// Without a dead time and an estimate, which round: the rest is the same, but for the last bits of
/// the angle past an end.
pub(crate) fn check_backwards<L: Subject>(
    car: &Vehicle,
    params: L::Params,
    path: &Path,
    bytes: &mut Bytes,
) {
    let car = Vehicle {
        dead_time: 0.0,
        // Beside a heading that is turned round it is rounded otherwise.
        antenna_left: 0.0,
        ..*car
    };
    let mirrored = Vehicle {
        rear_axle: -car.rear_axle,
        no_slip_point: Some(-car.no_slip()),
        steer_offset: -car.steer_offset,
        ..car
    };
    let tracker = |car: &Vehicle| {
        let law = L::make(car, params).expect("it was made before");
        let tracker = Tracker::new(law, None).expect("nothing to adapt by");
        // Rolled forward, a pose is rounded otherwise than its mirror image.
        tracker.monitored(None).expect("no thresholds")
    };
    let (backing, driving) = (tracker(&car), tracker(&mirrored));
    let view = path.view();
    let all = vec![true; view.len()];
    let turned = path.clone().with_reverse(&all);
    let turned = turned.expect("an entry for each waypoint");
    let (mut ahead, mut back) = (driving.initial_state(), backing.initial_state());
    let start = bytes.below(view.len());
    let point = Point::new(view.x()[start], view.y()[start]);
    let segment = start;
    ahead.place = Place::Known(Spot { segment, point });
    back.place = ahead.place;
    for _ in 0..8 {
        let (mut vehicle, dt) = (vehicle(bytes, &view), dt(bytes));
        let backed = backing.step(&turned.view(), &mut back, vehicle, dt, Reported::NOTHING);
        vehicle.yaw += PI;
        vehicle.speed = -vehicle.speed;
        let driven = driving.step(&view, &mut ahead, vehicle, dt, Reported::NOTHING);
        // Of two places as good after a jump, rounding decides.
        let same_place = ahead.place == back.place;
        let (true, Ok(driven), Ok(backed)) = (same_place, driven, backed) else {
            return;
        };
        if L::MIRRORED {
            // Past an end, a smoothed direction sums arc lengths in another order.
            let past = 1.0 + driven.distance_to_stop.abs();
            assert!((backed.steer + driven.steer).abs() <= 1e-13 * past);
            assert_eq!(backed.status, driven.status);
        }
        let mirrored = Command {
            steer: backed.steer,
            status: backed.status,
            // A command that is held before the first step has no direction.
            reverse: back.answer.is_some(),
            reference_speed: driven.reference_speed.map(|speed| -speed),
            ..driven
        };
        assert_eq!(backed, mirrored);
        if bytes.is_empty() {
            break;
        }
    }
}
