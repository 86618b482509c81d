//! The plants of the core, and what stands for one.

use std::any::Any;
use std::sync::Arc;

use popsteer_sim::plant::{self, CarlaIdentified, KinematicBicycle};
use popsteer_sim::{Plant, Simulation};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::errors::unknown;
use crate::params::params;
use crate::python_plant::PythonPlant;
use crate::vehicle::PyVehicle;

popsteer_sim::CarlaIdentified! { params {
    /// The vehicle identified from the paper authors' CARLA run.
    ///
    /// Single-track steady-state yaw response with a lag, and a longitudinal model with throttle
    /// lag, drag and loss in bends. The vehicle's `steer_lag` acts on the yaw rate here. The
    /// recorded run holds no braking: `braking` is an assumption.
    PyCarlaIdentified(CarlaIdentified) named "CarlaIdentified" in "popsteer.sim";
    @of vehicle: PyVehicle by default CarlaIdentified::VEHICLE, "``popsteer.vehicles.get('carla-identified')``";
} }

popsteer_sim::KinematicBicycle! { params {
    /// The kinematic bicycle of a vehicle, with an engine, brakes and linear drag.
    ///
    /// It does what its vehicle says: dead time, lag, rate, largest angle and offset of the wheels,
    /// turning wheelbase and understeer, the no-slip point, `drive_lag` and `max_speed`.
    PyKinematicBicycle(KinematicBicycle) named "KinematicBicycle" in "popsteer.sim";
    @of vehicle: PyVehicle by default KinematicBicycle::VEHICLE, "``popsteer.vehicles.get('kinematic-bicycle')``, whose wheels turn at once";
} }

/// A plant from its name or its object.
pub(crate) fn plant_of(object: &Bound<'_, PyAny>) -> PyResult<Arc<dyn Plant>> {
    let py = object.py();
    if let Ok(plant) = object.cast_exact::<PyCarlaIdentified>() {
        return Ok(Arc::new(plant.get().0));
    }
    if let Ok(plant) = object.cast_exact::<PyKinematicBicycle>() {
        return Ok(Arc::new(plant.get().0));
    }
    let name: String = object.extract().map_err(|_| {
        PyTypeError::new_err("plant must be a name or an object of a plant class of popsteer.sim")
    })?;
    plant::by_name(&name).ok_or_else(|| unknown(py, "plant", &name, &plant::NAMES))
}

/// A plant of the core, or one in Python.
pub(crate) fn any_plant(object: &Bound<'_, PyAny>) -> PyResult<Arc<dyn Plant>> {
    match PythonPlant::of(object)? {
        Some(plant) => Ok(Arc::new(plant)),
        None => plant_of(object),
    }
}

/// The plant of a simulation where it is one in Python.
pub(crate) fn python_plant(simulation: &Simulation) -> Option<&PythonPlant> {
    let plant: &dyn Any = simulation.plant().as_ref();
    plant.downcast_ref()
}

/// A plant as Python knows it.
pub(crate) fn plant_object(py: Python<'_>, plant: &dyn Plant) -> PyResult<Py<PyAny>> {
    let plant: &dyn Any = plant;
    if let Some(plant) = plant.downcast_ref::<PythonPlant>() {
        return plant.object(py);
    }
    if let Some(plant) = plant.downcast_ref::<CarlaIdentified>() {
        return Ok(Py::new(py, PyCarlaIdentified(*plant))?.into_any());
    }
    if let Some(plant) = plant.downcast_ref::<KinematicBicycle>() {
        return Ok(Py::new(py, PyKinematicBicycle(*plant))?.into_any());
    }
    Err(PyTypeError::new_err(
        "the plant is of no class of popsteer.sim",
    ))
}
