//! What the sliders of the page say.

use popsteer_core::Vehicle;
use popsteer_core::error::{ConfigError, config_in_range};
use popsteer_sim::plant::KinematicBicycle;

/// The settings in the order in which a page writes them.
pub(crate) const NAMES: [&str; 8] = [
    "wheelbase",
    "steer_lag",
    "dead_time",
    "max_steer_rate",
    "speed",
    "slow_in_bends",
    "start_offset",
    "known",
];

/// Largest angle of the wheels of every vehicle of the playground [rad].
const MAX_STEER: f64 = 0.6;

/// What a run is driven with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Settings {
    /// What drives.
    pub(crate) plant: KinematicBicycle,
    /// What the controllers are given of it.
    pub(crate) believed: Vehicle,
    /// Speed to keep, or not to exceed where bends are taken slower [m/s].
    pub(crate) speed: f64,
    /// Whether bends are taken slower.
    pub(crate) slow_in_bends: bool,
    /// How far to the left of the first waypoint the front axle starts [m].
    pub(crate) start_offset: f64,
}

impl Settings {
    /// The settings of numbers in the order of [`NAMES`]; a missing one is not a number.
    ///
    /// `known` is 0 where the controllers are not given lag, dead time and rate: they then believe
    /// in wheels that turn at once.
    pub(crate) fn of(numbers: &[f64]) -> Result<Self, ConfigError> {
        let number = |index: usize| numbers.get(index).copied().unwrap_or(f64::NAN);
        let [
            wheelbase,
            steer_lag,
            dead_time,
            rate,
            speed,
            slow,
            start_offset,
            known,
        ] = std::array::from_fn(number);
        let vehicle = Vehicle {
            wheelbase,
            steer_lag,
            dead_time,
            max_steer: MAX_STEER,
            max_steer_rate: Some(rate),
            ..KinematicBicycle::VEHICLE
        }
        .checked()?;
        // A metre per second less and a lap takes a quarter of an hour.
        config_in_range("speed", speed, 0.1, 100.0)?;
        config_in_range("slow_in_bends", slow, 0.0, 1.0)?;
        config_in_range("start_offset", start_offset, -1e3, 1e3)?;
        config_in_range("known", known, 0.0, 1.0)?;
        let at_once = Vehicle {
            steer_lag: 0.0,
            dead_time: 0.0,
            max_steer_rate: None,
            ..vehicle
        };
        Ok(Self {
            plant: KinematicBicycle {
                vehicle,
                ..KinematicBicycle::DEFAULT
            },
            believed: if known > 0.5 { vehicle } else { at_once },
            speed,
            slow_in_bends: slow > 0.5,
            start_offset,
        })
    }
}
