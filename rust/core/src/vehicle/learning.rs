//! What the way of a vehicle teaches about the model that predicts it.
//!
//! A model's wheelbase that is wrong turns it too much or too little, by the same factor always; a
//! dead time that is wrong turns it too early or too late. Both are found by least squares: how
//! much of the turns that the model expects is measured, and how much of the change of these turns
//! is left over.

use super::VehicleState;
use super::state::MAX_YAW;
use crate::error::{InputError, input_in_range};
use crate::math::{exp, saturate, wrap};
use crate::path::view::MAX_SPEED;

/// What a prediction has learnt, and what it needs to learn on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Learnt {
    /// Heading [rad] and speed [m/s] at the last step; none before the first.
    pub seen: Option<(f64, f64)>,
    /// Acceleration [m/s^2].
    pub acceleration: f64,
    /// Squares of the turns that the model expected, the old ones forgotten [rad^2].
    pub expected: f64,
    /// The same turns times those that were measured [rad^2].
    pub measured: f64,
    /// The turn expected for the last step [rad].
    pub turn: f64,
    /// Squares of the rates at which such turns changed, the old ones forgotten [rad^2/s^2].
    pub change: f64,
    /// How much longer the dead time is than the actuator says [s].
    pub delay: f64,
}

impl Learnt {
    /// Time over which the acceleration is taken [s].
    const ACCELERATION_TIME: f64 = 0.1;
    /// The largest acceleration that is believed [m/s^2].
    pub const MAX_ACCELERATION: f64 = 20.0;
    /// Evidence as sure as the model is of itself: squares of turns [rad^2].
    const OF_TURNS: f64 = 1e-3;
    /// The same of the rates of their change [rad^2/s^2].
    const OF_CHANGES: f64 = 1e-2;
    /// More than the sums come to within the bounds of the input.
    const MAX_SUM: f64 = 1e100;
    /// More than a turn comes to, and little enough that the squares of its changes keep to that.
    const MAX_TURN: f64 = 1e30;

    /// How many times more the vehicle turns than the model says, a half to twice.
    #[inline]
    pub fn gain(&self) -> f64 {
        saturate(
            (self.measured + Self::OF_TURNS) / (self.expected + Self::OF_TURNS),
            0.5,
            2.0,
        )
    }

    /// The speed `time` [s] on from `speed` [m/s]; a vehicle that brakes stops.
    #[inline]
    pub fn speed_after(&self, speed: f64, time: f64) -> f64 {
        let next = speed + self.acceleration * time;
        if speed >= 0.0 {
            saturate(next, 0.0, MAX_SPEED)
        } else {
            saturate(next, -MAX_SPEED, 0.0)
        }
    }

    /// What is known when `vehicle` is seen `dt` [s] after the last step, for which the model
    /// expected `turn` [rad]. The old counts for less by `exp(-dt / time)`; the delay stays within
    /// `most_delay` [s], and moves by no more than `dt`.
    ///
    /// No sample counts for more than a turn thrice as large as expected, or the longest delay: a
    /// jump of the localisation is no lesson.
    #[inline]
    pub fn after(
        &self,
        vehicle: VehicleState,
        turn: f64,
        dt: f64,
        time: f64,
        most_delay: f64,
    ) -> Self {
        let mut next = Self {
            seen: Some((vehicle.yaw, vehicle.speed)),
            turn,
            ..*self
        };
        let Some((yaw, speed)) = self.seen else {
            return next;
        };
        let kept = exp(-dt / time);
        let error = wrap(vehicle.yaw - yaw) - turn;
        let most = 2.0 * turn.abs();
        next.expected = self.expected * kept + turn * turn;
        next.measured = self.measured * kept + turn * (turn + saturate(error, -most, most));

        let change = (self.turn - turn) / dt;
        let left = error + (1.0 - next.gain()) * turn;
        let most = change.abs() * most_delay;
        next.change = self.change * kept + change * change;
        let late = saturate(left, -most, most) * change / (next.change + Self::OF_CHANGES);
        let late = saturate(late, -dt, dt);
        next.delay = saturate(self.delay + late, -most_delay, most_delay);

        let weight = 1.0 - exp(-dt / Self::ACCELERATION_TIME);
        let gained = (vehicle.speed - speed) / dt - self.acceleration;
        let most = Self::MAX_ACCELERATION;
        next.acceleration = saturate(self.acceleration + weight * gained, -most, most);
        next
    }

    /// What was learnt, where it could be so with delays of up to `most_delay` [s].
    ///
    /// # Errors
    ///
    /// [`InputError`], naming `seen` or `learnt`.
    pub fn checked(self, most_delay: f64) -> Result<Self, InputError> {
        if let Some((yaw, speed)) = self.seen {
            input_in_range("seen", yaw, -MAX_YAW, MAX_YAW)?;
            input_in_range("seen", speed, -MAX_SPEED, MAX_SPEED)?;
        }
        let most = Self::MAX_ACCELERATION;
        input_in_range("learnt", self.acceleration, -most, most)?;
        input_in_range("learnt", self.expected, 0.0, Self::MAX_SUM)?;
        input_in_range("learnt", self.measured, -Self::MAX_SUM, Self::MAX_SUM)?;
        input_in_range("learnt", self.turn, -Self::MAX_TURN, Self::MAX_TURN)?;
        input_in_range("learnt", self.change, 0.0, Self::MAX_SUM)?;
        input_in_range("learnt", self.delay, -most_delay, most_delay)?;
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sin;
    use crate::vehicle::predict::kinematic_bicycle;
    use crate::vehicle::{Actuator, ActuatorParams};

    /// What an actuator that is said to be `told` has learnt from 60 s of bends of a vehicle with
    /// a wheelbase of 3 m, 0.2 s of dead time and a lag of 0.1 s, at 10 m/s and more.
    fn taught(told: ActuatorParams, acceleration: f64, jump: f64) -> Learnt {
        let real = Actuator::new(ActuatorParams {
            dead_time: 0.2,
            lag: 0.1,
            ..ActuatorParams::DEFAULT
        })
        .unwrap();
        let model = Actuator::new(told).unwrap();
        let (mut there, mut known) = (real.settled(0.0), model.settled(0.0));
        let mut vehicle = VehicleState {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
            speed: 10.0,
        };
        for step in 0..1200 {
            let command = 0.1 * sin(0.05 * f64::from(step));
            for _ in 0..10 {
                let wheel = real.elapse(&mut there, command, 0.005);
                vehicle = kinematic_bicycle(vehicle, wheel, acceleration, 3.0, 0.005);
            }
            if step == 900 {
                vehicle.yaw += jump;
            }
            let learnt = model.learn(&known, command, vehicle, 0.05);
            model.elapse_learning(&mut known, command, 0.05, learnt);
        }
        *known.learnt()
    }

    fn told(wheelbase: f64, dead_time: f64) -> ActuatorParams {
        ActuatorParams {
            dead_time,
            lag: 0.1,
            max_rate: None,
            wheelbase,
            understeer: 0.0,
            learning_time: 10.0,
        }
    }

    #[test]
    fn test_learnt_finds_wheelbase_dead_time_and_acceleration() {
        for (wheelbase, dead_time) in [(3.0, 0.2), (2.55, 0.2), (3.45, 0.15), (3.0, 0.25)] {
            let learnt = taught(told(wheelbase, dead_time), 0.2, 0.0);
            assert!((learnt.gain() - wheelbase / 3.0).abs() < 0.01, "{learnt:?}");
            assert!((dead_time + learnt.delay - 0.2).abs() < 0.01, "{learnt:?}");
            assert!((learnt.acceleration - 0.2).abs() < 1e-6, "{learnt:?}");
        }
    }

    #[test]
    fn test_learnt_of_a_jump_of_the_heading_is_little() {
        let (calm, jumped) = (
            taught(told(2.55, 0.25), 0.0, 0.0),
            taught(told(2.55, 0.25), 0.0, 2.0),
        );
        assert!((calm.gain() - jumped.gain()).abs() < 0.02);
        assert!((calm.delay - jumped.delay).abs() < 0.02);
    }

    #[test]
    fn test_learnt_keeps_within_its_bounds() {
        assert_eq!(taught(told(7.0, 0.2), 0.0, 0.0).gain(), 2.0);
        assert_eq!(taught(told(1.0, 0.2), 0.0, 0.0).gain(), 0.5);
        let learnt = taught(told(3.0, 0.1), 0.0, 0.0);
        assert_eq!(learnt.delay, 0.05);
        assert!(learnt.checked(0.05).is_ok());
        assert_eq!(learnt.checked(0.04).unwrap_err().field, "learnt");
        let turned = Learnt {
            turn: 1e31,
            ..learnt
        };
        assert_eq!(turned.checked(0.05).unwrap_err().value, 1e31);
        let unseen = Learnt {
            seen: Some((f64::NAN, 0.0)),
            ..learnt
        };
        assert_eq!(unseen.checked(0.05).unwrap_err().field, "seen");
    }

    #[test]
    fn test_speed_after_braking_stops() {
        let braking = |acceleration| Learnt {
            acceleration,
            ..Learnt::default()
        };
        assert_eq!(braking(-5.0).speed_after(1.0, 0.1), 0.5);
        assert_eq!(braking(-5.0).speed_after(1.0, 0.3), 0.0);
        assert_eq!(braking(5.0).speed_after(-1.0, 0.3), 0.0);
        assert_eq!(braking(-5.0).speed_after(-1.0, 0.2), -2.0);
        assert_eq!(braking(5.0).speed_after(MAX_SPEED, 1.0), MAX_SPEED);
        assert_eq!(braking(-5.0).speed_after(-MAX_SPEED, 1.0), -MAX_SPEED);
    }
}
