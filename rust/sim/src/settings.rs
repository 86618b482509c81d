//! How a run goes.

popsteer_core::params! {
    /// How a run goes: by default with the paper's control period, and the rest to suit.
    pub struct Settings {
        /// Control period [s].
        dt: f64 = 0.05, in [1e-6, 1.0];
        /// Plant steps in a control period.
        substeps: usize = 10, in [1, 1_000_000];
        /// The end is reached when the front axle has at most this much path ahead [m]; the rear
        /// axle where the path is driven in both directions.
        stop_distance: f64 = 1.0, in [0.0, 1e6];
        /// The run ends unfinished after this time [s].
        time_limit: f64 = 1000.0, in [dt, 1e6];
        /// The run ends unfinished this far from the path [m].
        give_up_distance: f64 = 50.0, in [1e-3, 1e9];
        /// Errors from this time on count as settled [s].
        settling_time: f64 = 5.0, in [0.0, 1e6];
        /// Whether the records are kept; the metrics come either way.
        keep_records: bool = true;
    }
}
