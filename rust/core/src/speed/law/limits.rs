//! The law of a vehicle: its parameters, its accelerations, and how exactly it stops.

use crate::error::ConfigError;
use crate::params;
use crate::speed::defaults;
use crate::vehicle::Vehicle;

/// Below this speed the vehicle is at rest [m/s]: a step of a speed sensor. Less: it is not seen to
/// stand. More: its gear changes while it rolls.
pub const REST: f64 = 0.03;
/// Below this speed one that was told to stop, and came to rest, still is [m/s]: a speed that is found by the
/// positions has their noise. Less: it is held and let go in turn. More: it is held though it is pushed on.
pub(super) const MOVES: f64 = 10.0 * REST;
/// How far before a stop it may stand [m], and in wheelbases besides. More: it stops less exactly. Less:
/// it creeps up in noise.
const ARRIVED: (f64, f64) = (0.002, 1.0 / 600.0);
/// It leaves its stop where that is farther ahead than this [m], and in wheelbases besides. Less: noise of
/// the position lets it go.
const LEAVES: (f64, f64) = (0.06, 1.0 / 60.0);
/// How far beyond its stop it may come to rest before it says so [m], and in wheelbases besides.
const OVERRUN: (f64, f64) = (0.05, 1.0 / 30.0);
/// Slowest plan, in wheelbases a second: beside a start.
pub(in crate::speed) const CREEP: f64 = 0.1;

params! {
    /// Parameters of [`SpeedTracker`](crate::speed::SpeedTracker).
    pub struct SpeedTrackerParams<Scaled> of Vehicle(wheelbase, drive_delay) {
        /// Share of an error of the speed that is corrected in a second [1/s].
        kp: f64 = 1.5, in [0.0, 1e3];
        /// Time constant of the estimate of slope and drag [s]. Shorter: they are known sooner, and a
        /// drive that responds later than the vehicle says is taken for one.
        disturbance_time: f64 = 1.0, in [1e-3, 1e3];
        /// Largest change of the acceleration, of plans and of stops, too [m/s^3].
        max_jerk: Scaled = 60.0 / wheelbase, in [1e-3, 1e6];
        /// Acceleration beyond that of the plan that may correct an error [m/s^2].
        reserve: f64 = 0.4, in [0.0, 1e3];
        /// Delay of the drive in place of the vehicle's, to try another [s].
        drive_delay: Scaled = drive_delay, in [0.0, 10.0];
    }
}

/// The law of a vehicle; its equations are those of the [module](crate::speed::law).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLaw {
    pub(in crate::speed) car: Vehicle,
    pub(in crate::speed) params: SpeedTrackerParams<f64>,
    /// Largest driving acceleration, and deceleration of a plan [m/s²].
    pub(in crate::speed) accelerations: (f64, f64),
    /// What the brakes can do [m/s²].
    pub(super) brakes: f64,
}

impl SpeedLaw {
    /// The law of a vehicle.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field or the parameter that is out of its range.
    pub fn new(car: Vehicle, params: SpeedTrackerParams) -> Result<Self, ConfigError> {
        let params = params.checked()?.resolved(&car.checked()?);
        let car = Vehicle {
            drive_delay: params.drive_delay,
            ..car
        };
        let driving = car.max_acceleration.unwrap_or(defaults::MAX_ACCELERATION);
        Ok(Self {
            car,
            params,
            accelerations: (driving, car.comfort_braking()),
            brakes: car.strongest_braking(),
        })
    }

    /// How far before its stop the vehicle may stand [m].
    pub(super) fn arrived(&self) -> f64 {
        ARRIVED.0 + ARRIVED.1 * self.car.wheelbase
    }

    /// How far ahead a stop is that the vehicle leaves it for [m].
    pub(super) fn leaves(&self) -> f64 {
        LEAVES.0 + LEAVES.1 * self.car.wheelbase
    }

    /// How far beyond its stop the vehicle may come to rest [m].
    pub(super) fn overrun(&self) -> f64 {
        OVERRUN.0 + OVERRUN.1 * self.car.wheelbase
    }
}
