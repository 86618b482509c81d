//! A plant written in Python, driven by the same closed loop as the core's.

use std::sync::{Mutex, PoisonError};

use popsteer_core::VehicleState;
use popsteer_sim::{Control, Geometry, Plant, PlantState};
use pyo3::prelude::*;

use crate::errors::{OrRaise, module};

/// An object with `name`, `geometry`, `reset` and `advance`; `popsteer.plants` says what they do.
#[derive(Debug)]
pub(crate) struct PythonPlant {
    object: Py<PyAny>,
    name: String,
    geometry: Geometry,
    /// What the object raised, until the closed loop takes it: the plant stands still from then on.
    fault: Mutex<Option<PyErr>>,
}

impl PythonPlant {
    /// The object as a plant; None where it is not like one.
    pub(crate) fn of(object: &Bound<'_, PyAny>) -> PyResult<Option<Self>> {
        for method in ["reset", "advance"] {
            if !object.hasattr(method)? {
                return Ok(None);
            }
        }
        let (front_offset, rear_offset, wheelbase) = object.getattr("geometry")?.extract()?;
        Ok(Some(Self {
            object: object.clone().unbind(),
            name: object.getattr("name")?.extract()?,
            geometry: Geometry {
                front_offset,
                rear_offset,
                wheelbase,
            },
            fault: Mutex::new(None),
        }))
    }

    /// Puts the vehicle where a run begins.
    pub(crate) fn reset(&self, py: Python<'_>, start: VehicleState) -> PyResult<()> {
        let VehicleState { x, y, yaw, speed } = start;
        self.object
            .call_method1(py, "reset", (x, y, yaw, speed))
            .map(drop)
    }

    /// What the object raised since this was last asked.
    pub(crate) fn take_fault(&self) -> Option<PyErr> {
        let mut fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        fault.take()
    }

    fn moved(
        &self,
        control: Control,
        dt: f64,
        substeps: usize,
    ) -> PyResult<(VehicleState, f64, f64)> {
        Python::attach(|py| {
            let pedals = (control.throttle, control.brake);
            let arguments = (control.steer, pedals.0, pedals.1, dt, substeps);
            let state = self.object.call_method1(py, "advance", arguments)?;
            let (x, y, yaw, speed, yaw_rate, _wheel): (f64, f64, f64, f64, f64, f64) =
                state.extract(py)?;
            let vehicle = VehicleState { x, y, yaw, speed };
            Ok((vehicle.checked().or_raise(py)?, yaw_rate, control.throttle))
        })
    }
}

impl Plant for PythonPlant {
    fn name(&self) -> &str {
        &self.name
    }

    fn geometry(&self) -> Geometry {
        self.geometry
    }

    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize) {
        match self.moved(control, dt, substeps) {
            Ok((vehicle, yaw_rate, throttle)) => {
                *state = PlantState {
                    vehicle,
                    yaw_rate,
                    throttle,
                };
            }
            Err(error) => {
                let mut fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
                *fault = Some(error);
            }
        }
    }
}

/// What a plant's limit says where the error is one, as `popsteer.errors.PlantLimit` is.
pub(crate) fn limit_of(py: Python<'_>, error: &PyErr) -> PyResult<Option<String>> {
    let class = module(py)?.getattr("PlantLimit")?;
    if error.is_instance(py, &class) {
        return error.value(py).str()?.extract().map(Some);
    }
    Ok(None)
}
