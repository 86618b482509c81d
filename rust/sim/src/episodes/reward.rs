//! What an episode rewards.

use popsteer_core::error::{ConfigError, config_in_range};

/// Weights of the reward of a control step.
///
/// ```text
/// reward = progress ds - dt (cross_track_error e^2 + heading_error psi^2 + steer_rate rate^2)
/// ```
///
/// less `off_path` at the step that leaves the path. `ds` is the distance gained along the path [m],
/// `e` [m] and `psi` [rad] are the errors of the rear axle after the step, `rate` [rad/s] is the
/// change of the commanded angle over `dt` [s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Of the distance gained along the path [1/m].
    pub progress: f64,
    /// Of the squared cross-track error [1/(m^2 s)].
    pub cross_track_error: f64,
    /// Of the squared heading error [1/(rad^2 s)].
    pub heading_error: f64,
    /// Of the squared rate of the command [s/rad^2].
    pub steer_rate: f64,
    /// What leaving the path costs, once.
    pub off_path: f64,
}

impl Weights {
    /// 10 m of the path are worth a second 1 m beside it.
    pub const DEFAULT: Self = Self {
        progress: 0.1,
        cross_track_error: 1.0,
        heading_error: 1.0,
        steer_rate: 0.1,
        off_path: 10.0,
    };

    /// The weights themselves where each is within its range.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the one that is not.
    pub fn checked(self) -> Result<Self, ConfigError> {
        config_in_range("progress", self.progress, 0.0, 1e6)?;
        config_in_range("cross_track_error", self.cross_track_error, 0.0, 1e6)?;
        config_in_range("heading_error", self.heading_error, 0.0, 1e6)?;
        config_in_range("steer_rate", self.steer_rate, 0.0, 1e6)?;
        config_in_range("off_path", self.off_path, 0.0, 1e9)?;
        Ok(self)
    }
}

impl Default for Weights {
    fn default() -> Self {
        Self::DEFAULT
    }
}
