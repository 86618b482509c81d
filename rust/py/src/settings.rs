//! How runs go, and how far off controllers see the vehicle in them.

use popsteer_sim::{Noise, Settings};
use pyo3::prelude::*;

use crate::params::params;

popsteer_sim::Settings! { params {
    /// How a run goes.
    PySettings(Settings) named "Settings" in "popsteer.sim";
} }

popsteer_sim::Noise! { params {
    /// Noise of pose and speed as a controller gets them: standard deviations of normal noise.
    ///
    /// Drawn anew at every control step, independent of one another. The vehicle itself, and what
    /// is measured of it, are without noise.
    PyNoise(Noise) named "Noise" in "popsteer.sim";
} }
