//! How runs go, and how far off controllers see the vehicle in them.

use popsteer_sim::{Noise, Settings};
use pyo3::prelude::*;

use crate::params::params;

params! {
    /// How a run goes.
    PySettings(Settings) named "Settings" in "popsteer.sim",
    defaults Settings::DEFAULT, checked by Settings::checked,
    dt: f64, "float, default 0.05",
        "Control period [s].";
    substeps: usize, "int, default 10",
        "Plant steps in a control period.";
    stop_distance: f64, "float, default 1.0",
        "The end is reached when the front axle has at most this much path ahead [m]; the rear axle where the path is driven in both directions.";
    time_limit: f64, "float, default 1000.0",
        "The run ends unfinished after this time [s].";
    give_up_distance: f64, "float, default 50.0",
        "The run ends unfinished this far from the path [m].";
    settling_time: f64, "float, default 5.0",
        "Errors from this time on count as settled [s].";
    keep_records: bool, "bool, default True",
        "Whether the records are kept; the metrics come either way.";
}

params! {
    /// Noise of pose and speed as a controller gets them: standard deviations of normal noise.
    ///
    /// Drawn anew at every control step, independent of one another. The vehicle itself, and what
    /// is measured of it, are without noise.
    PyNoise(Noise) named "Noise" in "popsteer.sim",
    defaults Noise::DEFAULT, checked by Noise::checked,
    position: f64, "float, default 0.0",
        "Of x, and of y [m].";
    yaw: f64, "float, default 0.0",
        "Of the heading [rad].";
    speed: f64, "float, default 0.0",
        "Of the speed [m/s].";
}
