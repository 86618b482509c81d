//! A path driven backwards against the same driven forwards.

use crate::bytes::Bytes;
use crate::scene::{dt, vehicle};
use crate::subject::Subject;
use popsteer_core::lateral::LateralState;
use popsteer_core::{Command, Path};
use std::f64::consts::PI;

/// Backing up is driving forward with the heading turned round and the wheels to the other side.
pub(crate) fn check_backwards<L: Subject>(law: &L, path: &Path, bytes: &mut Bytes) {
    let view = path.view();
    let all = vec![true; view.len()];
    let turned = path.clone().with_reverse(&all);
    let turned = turned.expect("an entry for each waypoint");
    let (mut ahead, mut back) = (law.initial_state(), law.initial_state());
    let start = Some(bytes.below(view.len()));
    ahead.set_waypoint(start);
    back.set_waypoint(start);
    for _ in 0..8 {
        let (mut vehicle, dt) = (vehicle(bytes, &view), dt(bytes));
        let backed = law.step(&turned.view(), &mut back, vehicle, dt);
        vehicle.yaw += PI;
        vehicle.speed = -vehicle.speed;
        let driven = law.step(&view, &mut ahead, vehicle, dt);
        // Of two places as good after a jump, rounding decides.
        let same_place = L::waypoint(&ahead) == L::waypoint(&back);
        let (true, Ok(driven), Ok(backed)) = (same_place, driven, backed) else {
            return;
        };
        assert!(!L::MIRRORED || (backed.steer + driven.steer).abs() <= 0.0);
        let mirrored = Command {
            steer: backed.steer,
            status: backed.status,
            reverse: true,
            ..driven
        };
        assert_eq!(backed, mirrored);
        if bytes.is_empty() {
            break;
        }
    }
}
