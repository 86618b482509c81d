//! The plants of the core, and what stands for one.

use std::sync::Arc;

use popsteer_sim::Plant;
use popsteer_sim::plant::{self, CarlaIdentified, KinematicBicycle};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::errors::{OrRaise, unknown};
use crate::python_plant::PythonPlant;
use crate::vehicle::PyVehicle;

/// A plant class of the core: a vehicle, and parameters of its own.
macro_rules! plant {
    (
        $(#[doc = $about:literal])+
        $class:ident($core:ident) named $name:literal, vehicle $vehicle:literal,
        $($field:ident, $words:literal, $text:literal;)+
    ) => {
        $(#[doc = $about])+
        ///
        /// Parameters
        /// ----------
        /// vehicle : Vehicle, optional
        #[doc = concat!("    What it is; by default ", $vehicle, ".")]
        $(
            #[doc = concat!(stringify!($field), " : ", $words)]
            #[doc = concat!("    ", $text)]
        )+
        ///
        /// Raises
        /// ------
        /// ConfigError
        ///     If a parameter is out of its range; names it and its value.
        #[pyclass(frozen, eq, hash, name = $name, module = "popsteer.sim")]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) struct $class(pub(crate) $core);

        impl std::hash::Hash for $class {
            fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
                PyVehicle(self.0.vehicle).hash(state);
                $((self.0.$field + 0.0).to_bits().hash(state);)+
            }
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (vehicle=None, *, $($field = $core::DEFAULT.$field),+))]
            fn new(
                py: Python<'_>,
                vehicle: Option<Py<PyVehicle>>,
                $($field: f64),+
            ) -> PyResult<Self> {
                let vehicle = vehicle.map_or($core::VEHICLE, |vehicle| vehicle.get().0);
                let plant = $core { vehicle, $($field),+ };
                plant.checked().map(Self).or_raise(py)
            }

            /// What it is.
            #[getter]
            fn vehicle(&self) -> PyVehicle {
                PyVehicle(self.0.vehicle)
            }

            $(
                #[doc = $text]
                #[getter]
                fn $field(&self) -> f64 {
                    self.0.$field
                }
            )+

            /// The vehicle and the parameters by name, as a new ``dict``.
            fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
                let fields = PyDict::new(py);
                fields.set_item("vehicle", self.vehicle())?;
                $(fields.set_item(stringify!($field), self.0.$field)?;)+
                Ok(fields)
            }

            /// The same plant but for what is given by name.
            #[pyo3(signature = (**changes))]
            fn replace<'py>(
                &self,
                py: Python<'py>,
                changes: Option<&Bound<'py, PyDict>>,
            ) -> PyResult<Bound<'py, PyAny>> {
                let fields = self.as_dict(py)?;
                if let Some(changes) = changes {
                    fields.update(changes.as_mapping())?;
                }
                py.get_type::<Self>().call((), Some(&fields))
            }

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                $crate::params::repr($name, &self.as_dict(py)?)
            }

            fn __getnewargs_ex__<'py>(
                &self,
                py: Python<'py>,
            ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
                Ok((PyTuple::empty(py), self.as_dict(py)?))
            }
        }
    };
}

plant! {
    /// The vehicle identified from the paper authors' CARLA run.
    ///
    /// Single-track steady-state yaw response with a lag, and a longitudinal model with throttle
    /// lag, drag and loss in bends. The vehicle's `steer_lag` acts on the yaw rate here. The
    /// recorded run holds no braking: `braking` is an assumption.
    PyCarlaIdentified(CarlaIdentified) named "CarlaIdentified",
    vehicle "``popsteer.vehicles.get('carla-identified')``",
    throttle_lag, "float, default 0.25",
        "Time constant of the throttle [s].";
    drive, "float, default 6.0",
        "Acceleration at full throttle [m/s²].";
    drag, "float, default 0.28",
        "Drag linear in speed [1/s].";
    air_drag, "float, default 0.001",
        "Drag quadratic in speed [1/m].";
    bend_loss, "float, default 0.11",
        "Loss in bends.";
    braking, "float, default 9.0",
        "Deceleration at full brake [m/s²].";
}

plant! {
    /// The kinematic bicycle of a vehicle, with an engine, brakes and linear drag.
    ///
    /// It does what its vehicle says: dead time, lag, rate, largest angle and offset of the wheels,
    /// turning wheelbase and understeer, the point that does not slip, `drive_lag` and `max_speed`.
    PyKinematicBicycle(KinematicBicycle) named "KinematicBicycle",
    vehicle "``popsteer.vehicles.get('kinematic-bicycle')``, whose wheels turn at once",
    drive, "float, default 6.0",
        "Acceleration at full throttle [m/s²].";
    drag, "float, default 0.28",
        "Drag linear in speed [1/s].";
    braking, "float, default 9.0",
        "Deceleration at full brake [m/s²].";
}

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

/// A plant, and the same once more where it is one in Python.
pub(crate) type AnyPlant = (Arc<dyn Plant>, Option<Arc<PythonPlant>>);

/// A plant of the core, or one in Python.
pub(crate) fn any_plant(object: &Bound<'_, PyAny>) -> PyResult<AnyPlant> {
    if let Some(plant) = PythonPlant::of(object)? {
        let plant = Arc::new(plant);
        return Ok((Arc::clone(&plant) as Arc<dyn Plant>, Some(plant)));
    }
    Ok((plant_of(object)?, None))
}

/// The names of the plants, and what they are.
///
/// Returns
/// -------
/// dict
///     For each name its `Vehicle`.
#[pyfunction]
pub(crate) fn plants(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let named = PyDict::new(py);
    for plant in plant::NAMES.iter().filter_map(|name| plant::by_name(name)) {
        named.set_item(plant.name(), PyVehicle(*plant.vehicle()))?;
    }
    Ok(named)
}
