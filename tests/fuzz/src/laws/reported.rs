//! Steps that report more than a pose: the applied command, the measured angle, how old the pose is, the roll.

use super::{Life, same};
use crate::bytes::Bytes;
use crate::scene::{dt, symmetric, vehicle};
use crate::subject::Subject;
use popsteer_core::bounds::MIN_DT;
use popsteer_core::status::HOLD_LIMIT;
use popsteer_core::tracker::Reported;
use popsteer_core::vehicle::past::MAX_POSE_AGE;
use popsteer_core::vehicle::state::checked_dt;
use std::f64::consts::FRAC_PI_2;

impl<L: Subject> Life<L> {
    /// Steps the state and steers its twin, with reports good and bad.
    pub(super) fn step_reported(&mut self, bytes: &mut Bytes) {
        let (seen, dt) = (vehicle(bytes, &self.path.view()), dt(bytes));
        let kind = bytes.byte();
        let reported = Reported {
            applied_steer: (kind & 1 == 1).then(|| symmetric(bytes, 0.6, 2.0)),
            measured_steer: (kind & 2 == 2).then(|| symmetric(bytes, 0.6, 2.0)),
            pose_age: bytes.number([0.0, 0.2], [0.0, MAX_POSE_AGE]),
            roll: if kind & 4 == 4 {
                symmetric(bytes, 0.3, 2.0)
            } else {
                0.0
            },
        };
        let angles = [
            reported.applied_steer,
            reported.measured_steer,
            Some(reported.roll),
        ];
        let good = seen.checked().is_ok()
            && dt.is_finite()
            && angles
                .iter()
                .flatten()
                .all(|angle| angle.abs() <= FRAC_PI_2)
            // The rounding of two stamps makes an age of 0 negative.
            && reported.pose_age > -MIN_DT
            && reported.pose_age <= MAX_POSE_AGE;

        let path = self.path.view();
        let before = self.state.clone();
        let tracker = &self.tracker;
        let stepped = tracker.step(&path, &mut self.state, seen, dt, reported);
        let steered = tracker.steer(&path, &mut self.twin, seen, dt, reported);
        assert_eq!(stepped.is_ok(), good, "{stepped:?} {reported:?}");
        match (stepped, steered) {
            (Ok(command), Ok(steer)) => {
                assert_eq!(command.steer.to_bits(), steer.to_bits());
                if checked_dt(dt).is_err() {
                    assert!(same::<L>(&self.state, &self.twin));
                    return self.check_held(before, &command, dt, HOLD_LIMIT);
                }
                self.check_command(&command);
                assert_eq!(self.tracker.check_state(&path, &self.state), Ok(()));
            }
            (Err(stepped), Err(steered)) => {
                assert!(same::<L>(&self.state, &before));
                assert_eq!(stepped.to_string(), steered.to_string());
            }
            mixed => panic!("step and steer disagree: {mixed:?}"),
        }
    }
}
