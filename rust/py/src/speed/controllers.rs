//! The longitudinal controllers.

use std::sync::Arc;

use popsteer_core::speed::{
    CoupledLongitudinal, CoupledLongitudinalParams, SpeedPid, SpeedPidParams, SpeedPidState,
};
use popsteer_sim::plant::PedalMap;
use popsteer_sim::{Longitudinal, Plant};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::errors::{Raises, argument_error};
use crate::params::params;
use crate::speed::tracker::PySpeedTracker;
use crate::tracker::state;

popsteer_core::CoupledLongitudinalParams! { params {
    /// Parameters of `CoupledLongitudinal`; the paper's Table 2 by default.
    PyCoupledLongitudinalParams(CoupledLongitudinalParams) named "CoupledLongitudinalParams" in "popsteer";
} }

popsteer_core::SpeedPidParams! { params {
    /// Parameters of `SpeedPid`.
    PySpeedPidParams(SpeedPidParams) named "SpeedPidParams" in "popsteer";
} }

/// The paper's pedals (Equation 7), which drive towards ``speed_limit``: 69.44 m/s by default.
///
/// They know nothing of the path's speeds or of its end; to drive a car, take a `SpeedTracker`.
/// ``command = cutoff + ((speed_limit - speed) / speed_limit - |steer| / steer_limit)
/// (1 - cutoff)``; throttle where it is positive, brake where it is negative. It has no memory.
///
/// Parameters
/// ----------
/// params : CoupledLongitudinalParams, optional
///     By default the paper's.
///
/// Examples
/// --------
/// >>> popsteer.CoupledLongitudinal().step(0.0, 0.0)
/// (1.0, 0.0)
#[pyclass(frozen, name = "CoupledLongitudinal", module = "popsteer")]
#[derive(Debug)]
pub(crate) struct PyCoupledLongitudinal {
    law: CoupledLongitudinal,
    /// The parameters.
    #[pyo3(get)]
    params: Py<PyCoupledLongitudinalParams>,
}

#[pymethods]
impl PyCoupledLongitudinal {
    #[new]
    #[pyo3(signature = (params=None))]
    fn new(py: Python<'_>, params: Option<Py<PyCoupledLongitudinalParams>>) -> Raises<Self> {
        let usual = PyCoupledLongitudinalParams(CoupledLongitudinalParams::DEFAULT);
        let params = params.map_or_else(|| Py::new(py, usual), Ok)?;
        let law = CoupledLongitudinal::new(params.get().0)?;
        Ok(Self { law, params })
    }

    /// Take one control step.
    ///
    /// Parameters
    /// ----------
    /// speed : float
    ///     Speed [m/s].
    /// steer : float
    ///     Commanded angle [rad].
    ///
    /// Returns
    /// -------
    /// tuple of float
    ///     (throttle, brake), each in 0 to 1.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If a number is not finite or beyond its bound.
    fn step(&self, speed: f64, steer: f64) -> Raises<(f64, f64)> {
        let pedals = self.law.step(speed, steer)?;
        Ok((pedals.throttle, pedals.brake))
    }

    fn __getnewargs__(&self, py: Python<'_>) -> (Py<PyCoupledLongitudinalParams>,) {
        (self.params.clone_ref(py),)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let params = self.params.bind(py).repr()?;
        Ok(format!("CoupledLongitudinal({params})"))
    }
}

/// PID that tracks a reference speed.
///
/// ``command = kp e + ki integral(e) + kd de/dt`` on ``e = target_speed - speed``; throttle where
/// it is positive, brake where it is negative. The integral's share is held within -1 to 1.
///
/// Parameters
/// ----------
/// params : SpeedPidParams, optional
///     Gains.
///
/// Examples
/// --------
/// >>> popsteer.SpeedPid().step(10.0, 9.0, 0.05)
/// (0.0, 0.505)
#[pyclass(name = "SpeedPid", module = "popsteer")]
#[derive(Debug)]
pub(crate) struct PySpeedPid {
    law: SpeedPid,
    state: SpeedPidState,
    /// The parameters.
    #[pyo3(get)]
    params: Py<PySpeedPidParams>,
}

#[pymethods]
impl PySpeedPid {
    #[new]
    #[pyo3(signature = (params=None))]
    fn new(py: Python<'_>, params: Option<Py<PySpeedPidParams>>) -> Raises<Self> {
        let usual = PySpeedPidParams(SpeedPidParams::DEFAULT);
        let params = params.map_or_else(|| Py::new(py, usual), Ok)?;
        let law = SpeedPid::new(params.get().0)?;
        Ok(Self {
            law,
            state: SpeedPidState::default(),
            params,
        })
    }

    /// Take one control step.
    ///
    /// Parameters
    /// ----------
    /// speed : float
    ///     Speed [m/s].
    /// target_speed : float
    ///     The speed to hold [m/s].
    /// dt : float
    ///     Time since the last step [s], 1e-6 to 1e3. Any other finite number, of a clock that was set or
    ///     repeats a stamp, counts as no time: the integral stays, and there is no derivative.
    ///
    /// Returns
    /// -------
    /// tuple of float
    ///     (throttle, brake), each in 0 to 1.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If a number is not finite or, but for `dt`, beyond its bound; the state is then unchanged.
    fn step(&mut self, speed: f64, target_speed: f64, dt: f64) -> Raises<(f64, f64)> {
        let pedals = self.law.step(&mut self.state, speed, target_speed, dt)?;
        Ok((pedals.throttle, pedals.brake))
    }

    /// Forget all steps taken so far.
    fn reset(&mut self) {
        self.state = SpeedPidState::default();
    }

    /// What the controller remembers; a copy, which can be compared, saved and set again.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        state::shown(py, "SpeedPid", &self.state)
    }

    #[setter]
    fn set_state(&mut self, state: &Bound<'_, PyAny>) -> Raises<()> {
        let restored = state::restored("SpeedPid", state)?;
        self.law.check_state(&restored)?;
        self.state = restored;
        Ok(())
    }

    fn __getnewargs__(&self, py: Python<'_>) -> (Py<PySpeedPidParams>,) {
        (self.params.clone_ref(py),)
    }

    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.state(py)
    }

    fn __setstate__(&mut self, state: &Bound<'_, PyAny>) -> Raises<()> {
        self.set_state(state)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("SpeedPid({})", self.params.bind(py).repr()?))
    }
}

/// Either of the longitudinal controllers that need no plan, as the closed loop takes it.
pub(crate) fn longitudinal_of(object: &Bound<'_, PyAny>) -> Option<Longitudinal> {
    if let Ok(law) = object.cast_exact::<PyCoupledLongitudinal>() {
        return Some(Longitudinal::Coupled(law.get().law));
    }
    object
        .cast_exact::<PySpeedPid>()
        .ok()?
        .try_borrow()
        .ok()
        .map(|law| Longitudinal::Speed(law.law))
}

/// The numbers of a `popsteer.sim.PedalMap`.
#[derive(Clone, Copy, Debug, FromPyObject)]
pub(crate) struct GivenPedals {
    drive: f64,
    braking: f64,
    drag: f64,
    air_drag: f64,
}

/// Any of the longitudinal controllers, for a plant; its pedals are those of `given`, or its own.
/// Without a controller, the paper's.
pub(crate) fn longitudinal_for(
    object: Option<&Bound<'_, PyAny>>,
    plant: &dyn Plant,
    given: Option<GivenPedals>,
) -> PyResult<Longitudinal> {
    let Some(object) = object else {
        return Ok(Longitudinal::default());
    };
    let Ok(tracker) = object.cast_exact::<PySpeedTracker>() else {
        return longitudinal_of(object).ok_or_else(|| {
            PyTypeError::new_err(
                "longitudinal must be a CoupledLongitudinal, a SpeedPid or a SpeedTracker",
            )
        });
    };
    let given = given.map(|given| PedalMap {
        drive: given.drive,
        braking: given.braking,
        drag: given.drag,
        air_drag: given.air_drag,
    });
    let Some(map) = given.or_else(|| plant.pedals()) else {
        let required = format!("given, as {} has no drive, braking and drag", plant.name());
        let py = object.py();
        let none = py.None().into_bound(py);
        return Err(argument_error(py, "pedals", none, &required));
    };
    Ok(Longitudinal::Tracked(Arc::new(
        tracker.try_borrow()?.tracked(map),
    )))
}
