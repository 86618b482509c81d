//! How a run goes.

use popsteer_core::error::{ConfigError, Requirement, config_in_range};
use popsteer_core::math::from_count;

/// How a run goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Control period [s].
    pub dt: f64,
    /// Plant steps in a control period.
    pub substeps: usize,
    /// The end is reached when the front axle has at most this much path ahead [m]; the rear axle
    /// where the path is driven in both directions.
    pub stop_distance: f64,
    /// The run ends unfinished after this time [s].
    pub time_limit: f64,
    /// The run ends unfinished this far from the path [m].
    pub give_up_distance: f64,
    /// Errors from this time on count as settled [s].
    pub settling_time: f64,
    /// Whether the records are kept; the metrics come either way.
    pub keep_records: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The largest number of plant steps in a control period.
const MAX_SUBSTEPS: usize = 1_000_000;

impl Settings {
    /// The paper's control period, and the rest to suit.
    pub const DEFAULT: Self = Self {
        dt: 0.05,
        substeps: 10,
        stop_distance: 1.0,
        time_limit: 1000.0,
        give_up_distance: 50.0,
        settling_time: 5.0,
        keep_records: true,
    };

    /// The settings themselves where each is within its range.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the one that is not.
    pub fn checked(self) -> Result<Self, ConfigError> {
        config_in_range("dt", self.dt, 1e-6, 1.0)?;
        if !(1..=MAX_SUBSTEPS).contains(&self.substeps) {
            return Err(ConfigError {
                field: "substeps",
                value: from_count(self.substeps),
                requirement: Requirement::CountInRange(1, MAX_SUBSTEPS),
            });
        }
        config_in_range("stop_distance", self.stop_distance, 0.0, 1e6)?;
        config_in_range("time_limit", self.time_limit, self.dt, 1e6)?;
        config_in_range("give_up_distance", self.give_up_distance, 1e-3, 1e9)?;
        config_in_range("settling_time", self.settling_time, 0.0, 1e6)?;
        Ok(self)
    }
}
