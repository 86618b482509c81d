//! A plant written in Python, driven by the same closed loop as the core's.

use std::sync::{Mutex, MutexGuard, PoisonError};

use popsteer_core::{Vehicle, VehicleState};
use popsteer_sim::plant::PedalMap;
use popsteer_sim::{Control, Plant, PlantState};
use pyo3::PyVisit;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::errors::{Raises, module};
use crate::vehicle::PyVehicle;

/// An object with `name`, `vehicle`, `reset` and `advance`; `popsteer.plants` says what they do.
#[derive(Debug)]
pub(crate) struct PythonPlant {
    /// None once the garbage collector has broken a cycle.
    object: Mutex<Option<Py<PyAny>>>,
    name: String,
    vehicle: Vehicle,
    reverses: bool,
    pedals: Option<PedalMap>,
    /// What the object raised, until the closed loop takes it: the plant stands still from then on.
    fault: Mutex<Option<PyErr>>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl PythonPlant {
    /// The object as a plant; None where it is not like one.
    pub(crate) fn of(object: &Bound<'_, PyAny>) -> PyResult<Option<Self>> {
        for method in ["reset", "advance"] {
            if !object.hasattr(method)? {
                return Ok(None);
            }
        }
        let vehicle = object.getattr("vehicle")?;
        let vehicle = vehicle.cast::<PyVehicle>()?.get().0;
        let reverses = object.getattr_opt("reverses")?;
        let reverses = reverses.map(|reverses| reverses.extract()).transpose()?;
        Ok(Some(Self {
            object: Mutex::new(Some(object.clone().unbind())),
            name: object.getattr("name")?.extract()?,
            vehicle,
            reverses: reverses.unwrap_or(false),
            pedals: pedals_of(object)?,
            fault: Mutex::new(None),
        }))
    }

    /// The object.
    pub(crate) fn object(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        match &*locked(&self.object) {
            Some(object) => Ok(object.clone_ref(py)),
            None => Err(PyRuntimeError::new_err("the plant is gone")),
        }
    }

    /// Puts the vehicle where a run begins.
    pub(crate) fn reset(&self, py: Python<'_>, start: VehicleState) -> PyResult<()> {
        let VehicleState { x, y, yaw, speed } = start;
        self.object(py)?
            .call_method1(py, "reset", (x, y, yaw, speed))
            .map(drop)
    }

    /// What the object raised since this was last asked.
    pub(crate) fn take_fault(&self) -> Option<PyErr> {
        locked(&self.fault).take()
    }

    /// Shows the object to the garbage collector.
    pub(crate) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), pyo3::PyTraverseError> {
        match self.object.try_lock() {
            Ok(object) => visit.call(&*object),
            Err(_) => Ok(()),
        }
    }

    /// Lets go of the object.
    pub(crate) fn clear(&self) {
        let object = locked(&self.object).take();
        drop(object);
    }

    fn moved(&self, control: Control, dt: f64, substeps: usize) -> Raises<PlantState> {
        Python::attach(|py| {
            let arguments = (
                control.steer,
                control.throttle,
                control.brake,
                dt,
                substeps,
                control.reverse,
            );
            let state = self.object(py)?.call_method1(py, "advance", arguments)?;
            let (x, y, yaw, speed, yaw_rate, wheel): (f64, f64, f64, f64, f64, f64) =
                state.extract(py)?;
            let vehicle = VehicleState { x, y, yaw, speed };
            Ok(PlantState {
                vehicle: vehicle.checked()?,
                yaw_rate,
                wheel,
                road_wheel: wheel,
                throttle: control.throttle,
            })
        })
    }
}

impl Plant for PythonPlant {
    fn name(&self) -> &str {
        &self.name
    }

    fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    fn reverses(&self) -> bool {
        self.reverses
    }

    fn pedals(&self) -> Option<PedalMap> {
        self.pedals
    }

    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize) {
        if locked(&self.fault).is_some() {
            return;
        }
        match self.moved(control, dt, substeps) {
            Ok(moved) => *state = moved,
            Err(error) => *locked(&self.fault) = Some(error.into()),
        }
    }
}

/// The map of a plant whose parameters, or those that it has as `params`, name `drive`, `braking` and
/// `drag`.
fn pedals_of(object: &Bound<'_, PyAny>) -> PyResult<Option<PedalMap>> {
    let params = object.getattr_opt("params")?;
    let params = params.as_ref().unwrap_or(object);
    let number = |name: &str| -> PyResult<Option<f64>> {
        Ok(params
            .getattr_opt(name)?
            .and_then(|value| value.extract().ok()))
    };
    let (drive, braking, drag) = (number("drive")?, number("braking")?, number("drag")?);
    let (Some(drive), Some(braking), Some(drag)) = (drive, braking, drag) else {
        return Ok(None);
    };
    Ok(Some(PedalMap {
        drive,
        braking,
        drag,
        air_drag: number("air_drag")?.unwrap_or(0.0),
    }))
}

/// What a plant's limit says where the error is one, as `popsteer.errors.PlantLimit` is.
pub(crate) fn limit_of(py: Python<'_>, error: &PyErr) -> PyResult<Option<String>> {
    let class = module(py)?.getattr("PlantLimit")?;
    if error.is_instance(py, &class) {
        return error.value(py).str()?.extract().map(Some);
    }
    Ok(None)
}
