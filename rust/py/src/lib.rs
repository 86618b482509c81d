//! `popsteer._core`: the Rust core under Python names.
//!
//! This crate converts and nothing else. What it exposes is documented for Python users in the
//! doc comments of its classes; their types are in `python/popsteer/_core.pyi`.
#![expect(
    clippy::doc_markdown,
    clippy::needless_pass_by_value,
    clippy::too_many_arguments,
    reason = "doc comments are numpydoc for Python users, and signatures are Python's"
)]

mod arrays;
mod batch;
mod batch_inputs;
mod choice;
mod driver;
mod driving;
mod empty_call;
mod episodes;
mod errors;
mod laws;
mod logged;
mod many;
mod metrics;
mod params;
mod path;
mod plants;
mod pool;
mod projection;
mod python_driver;
mod python_plant;
mod record;
mod sim;
mod speed;
mod tracker;
mod vehicle;
mod vehicles;
mod waypoints;

use pyo3::prelude::*;

#[pymodule]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::{
        batch::PyBatch,
        driver::{PyDrive, PyDriver, PyDriverParams},
        empty_call::PyEmptyCall,
        episodes::PyEpisodes,
        laws::{
            PyPid, PyPidParams, PyPop, PyPopParams, PyPreviewPop, PyPreviewPopParams,
            PyPurePursuit, PyPurePursuitParams, PyStanley, PyStanleyParams,
        },
        logged::{PyWheels, lagged, recursion},
        many::run_many,
        path::{PyPath, path_headings},
        plants::{PyCarlaIdentified, PyKinematicBicycle},
        projection::{PyLookahead, PyProjection},
        sim::{PyNoise, PySettings, PySimulation},
        speed::controllers::{
            PyCoupledLongitudinal, PyCoupledLongitudinalParams, PySpeedPid, PySpeedPidParams,
        },
        speed::planning::{path_curvature, path_cusps, plan_speeds, with_speed},
        speed::tracker::{PySpeedCommand, PySpeedTracker, PySpeedTrackerParams},
        tracker::command::PyCommand,
        tracker::commands::PyCommandBatch,
        tracker::monitor::PyMonitorParams,
        tracker::prediction::PyInFlight,
        vehicle::{PyAdaptParams, PyEstimate, PyVehicle},
    };

    /// Names the version and the profile that this module was built with.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add(
            "_speed_defaults",
            crate::speed::planning::speed_defaults(module.py())?,
        )?;
        let profile = if cfg!(debug_assertions) {
            "debug"
        } else {
            "release"
        };
        module.add("build_profile", profile)
    }
}
