//! What is estimated of a vehicle, and how fast a controller adapts to it.

use super::{Vehicle, VehicleState};
use crate::bounds::MAX_SPEED;
use crate::math::{larger, saturate, smaller};
use crate::params;

params! {
    /// How fast a controller adapts to its vehicle: by default within 10 s to its turning, which is
    /// a few bends, within 5 s to its slip, and within 20 s to the scale of its speed.
    pub struct AdaptParams {
        /// Time constant of the estimates of turning gain, understeer, steering offset and dead time
        /// [s]; 0 switches them off. Shorter: a change is learnt sooner, and more noise of the
        /// heading is in the estimates.
        turn_time: f64 = 10.0, in [0.0, 1e6];
        /// Time constant of the estimated slip [s]; 0 switches it off. Shorter: faster, and more
        /// noise of the position in the estimate.
        slip_time: f64 = 5.0, in [0.0, 1e6];
        /// Time constant of the estimated scale of the speed signal [s]; 0 switches it off. Shorter:
        /// wheels that begin to slip are seen sooner, and a signal that stands still while the
        /// vehicle slows is taken for a scale.
        speed_time: f64 = 20.0, in [0.0, 1e6];
    }
}

/// The estimates: corrections to the vehicle's parameters, its slip and its acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Estimate {
    /// Ratio of the measured turning to that of the vehicle's parameters, at the present speed: an
    /// understeer that nobody gave is in it.
    pub gain: f64,
    /// Steering offset, in addition to the vehicle's `steer_offset` [rad].
    pub steer_offset: f64,
    /// Dead time, in addition to the vehicle's `dead_time` [s]; may be negative. What is less than none
    /// shortens the vehicle's `steer_lag`.
    pub longer_dead_time: f64,
    /// Slip of the no-slip point on a straight: direction of its motion less the heading [rad].
    pub slip: f64,
    /// Change of the slip per curvature [m].
    pub slip_length: f64,
    /// Acceleration [m/s^2].
    pub acceleration: f64,
    /// Ratio of the vehicle's speed to what its speed signal says.
    pub speed_scale: f64,
}

impl Estimate {
    /// No corrections: the vehicle is as its parameters say, and keeps its speed.
    pub const DEFAULT: Self = Self {
        gain: 1.0,
        steer_offset: 0.0,
        longer_dead_time: 0.0,
        slip: 0.0,
        slip_length: 0.0,
        acceleration: 0.0,
        speed_scale: 1.0,
    };

    /// The speed [m/s] where the signal says `told`.
    #[inline]
    pub fn speed_of(&self, told: f64) -> f64 {
        saturate(self.speed_scale * told, -MAX_SPEED, MAX_SPEED)
    }

    /// The vehicle with the speed that its signal would say.
    #[inline]
    pub fn told(&self, vehicle: VehicleState) -> VehicleState {
        let speed = saturate(vehicle.speed / self.speed_scale, -MAX_SPEED, MAX_SPEED);
        VehicleState { speed, ..vehicle }
    }

    /// The dead time of `vehicle` [s]; below 0 its wheels lag less than told.
    #[inline]
    fn delay(&self, vehicle: &Vehicle) -> f64 {
        vehicle.dead_time + self.longer_dead_time
    }

    /// Whether commands reach the wheels of `vehicle` later than they are given.
    #[inline]
    pub fn delays(&self, vehicle: &Vehicle) -> bool {
        self.delay(vehicle) > 0.0
    }

    /// The dead time of `vehicle` [s].
    #[inline]
    pub fn dead_time(&self, vehicle: &Vehicle) -> f64 {
        larger(self.delay(vehicle), 0.0)
    }

    /// The lag of the wheels of `vehicle` [s].
    #[inline]
    pub fn steer_lag(&self, vehicle: &Vehicle) -> f64 {
        larger(vehicle.steer_lag + smaller(self.delay(vehicle), 0.0), 0.0)
    }

    /// The vehicle whose wheels lag less than those of `vehicle`; None if they do not.
    #[inline]
    pub(crate) fn quicker(&self, vehicle: &Vehicle) -> Option<Vehicle> {
        if self.delay(vehicle) < 0.0 {
            Some(self.hurried(vehicle))
        } else {
            None
        }
    }

    #[cold]
    #[inline(never)]
    fn hurried(&self, vehicle: &Vehicle) -> Vehicle {
        Vehicle {
            steer_lag: self.steer_lag(vehicle),
            ..*vehicle
        }
    }

    /// The speed [m/s] after `time` [s] at the estimated acceleration; a braking vehicle stops at
    /// 0.
    #[inline]
    pub fn speed_after(&self, speed: f64, time: f64) -> f64 {
        let next = speed + self.acceleration * time;
        if speed >= 0.0 {
            saturate(next, 0.0, MAX_SPEED)
        } else {
            saturate(next, -MAX_SPEED, 0.0)
        }
    }
}

/// A vehicle as it is known: its parameters, corrected by an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// As [`Estimate::gain`].
    pub gain: f64,
    /// Angle of the wheels at the command 0 [rad].
    pub steer_offset: f64,
    /// Time from a command to its first effect on the wheels [s].
    pub dead_time: f64,
    /// Time constant of the wheels' response [s].
    pub steer_lag: f64,
    /// As [`Estimate::slip`] [rad].
    pub slip: f64,
    /// As [`Estimate::slip_length`] [m].
    pub slip_length: f64,
    /// As [`Estimate::acceleration`] [m/s^2].
    pub acceleration: f64,
    /// As [`Estimate::speed_scale`].
    pub speed_scale: f64,
}

impl Known {
    /// What is known of `vehicle` by `estimate`.
    pub fn of(vehicle: &Vehicle, estimate: &Estimate) -> Self {
        Self {
            gain: estimate.gain,
            steer_offset: vehicle.steer_offset + estimate.steer_offset,
            dead_time: estimate.dead_time(vehicle),
            steer_lag: estimate.steer_lag(vehicle),
            slip: estimate.slip,
            slip_length: estimate.slip_length,
            acceleration: estimate.acceleration,
            speed_scale: estimate.speed_scale,
        }
    }
}

impl Default for Estimate {
    fn default() -> Self {
        Self::DEFAULT
    }
}
