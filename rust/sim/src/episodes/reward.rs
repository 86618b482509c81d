//! What an episode rewards.

popsteer_core::params! {
    /// Weights of the reward of a control step.
    ///
    /// ```text
    /// reward = progress ds - dt (cross_track_error e^2 + heading_error psi^2 + steer_rate rate^2)
    /// ```
    ///
    /// less `off_path` at the step that leaves the path. `ds` is the distance gained along the path
    /// [m], `e` [m] and `psi` [rad] are the errors of the rear axle after the step, `rate` [rad/s]
    /// is the change of the commanded angle over `dt` [s]. By default 10 m of the path are worth a
    /// second 1 m beside it.
    pub struct Weights {
        /// Of the distance gained along the path [1/m].
        progress: f64 = 0.1, in [0.0, 1e6];
        /// Of the squared cross-track error [1/(m^2 s)].
        cross_track_error: f64 = 1.0, in [0.0, 1e6];
        /// Of the squared heading error [1/(rad^2 s)].
        heading_error: f64 = 1.0, in [0.0, 1e6];
        /// Of the squared rate of the command [s/rad^2].
        steer_rate: f64 = 0.1, in [0.0, 1e6];
        /// What leaving the path costs, once.
        off_path: f64 = 10.0, in [0.0, 1e9];
    }
}
