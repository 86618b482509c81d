//! A controller written in Python, driven by the same closed loop as the core's.

use popsteer_core::{Command, InputError, PathView, Status, VehicleState};
use popsteer_sim::Driver;
use pyo3::exceptions::PyTypeError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict, PyFloat, PyInt};

use crate::params::Field;

/// An object with `step(x, y, yaw, speed, dt)`, which may take `reverse` as well.
#[derive(Debug)]
pub(crate) struct PythonDriver {
    object: Py<PyAny>,
    /// Whether `step` takes the direction of the path.
    takes_reverse: bool,
    /// What the object raised, which ends the run.
    fault: Option<PyErr>,
    /// The acceleration of its last answer [m/s^2], where that has one.
    acceleration: Option<f64>,
}

impl PythonDriver {
    /// The object as a driver.
    pub(crate) fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let step = object.getattr_opt("step")?.ok_or_else(|| {
            let kind = object.get_type();
            PyTypeError::new_err(format!("a controller must have a method step, got {kind}"))
        })?;
        Ok(Self {
            object: object.clone().unbind(),
            takes_reverse: takes_reverse(&step)?,
            fault: None,
            acceleration: None,
        })
    }

    /// What the object raised.
    pub(crate) fn take_fault(&mut self) -> Option<PyErr> {
        self.fault.take()
    }

    fn asked(&mut self, vehicle: VehicleState, dt: f64, reverse: bool) -> PyResult<Command> {
        Python::attach(|py| {
            let VehicleState { x, y, yaw, speed } = vehicle;
            let options = PyDict::new(py);
            if self.takes_reverse {
                options.set_item(intern!(py, "reverse"), reverse)?;
            }
            let answer = self.object.bind(py).call_method(
                intern!(py, "step"),
                (x, y, yaw, speed, dt),
                Some(&options),
            )?;
            let wanted = answer.getattr_opt(intern!(py, "acceleration"))?;
            let wanted = wanted.filter(|wanted| !wanted.is_none());
            self.acceleration = wanted.map(|wanted| wanted.extract()).transpose()?;
            read(&answer, reverse)
        })
    }
}

impl Driver for PythonDriver {
    fn answer(
        &mut self,
        _path: &PathView<'_>,
        vehicle: VehicleState,
        dt: f64,
        reverse: bool,
    ) -> Result<Option<Command>, InputError> {
        match self.asked(vehicle, dt, reverse) {
            Ok(answer) => Ok(Some(answer)),
            Err(error) => {
                self.fault = Some(error);
                Ok(None)
            }
        }
    }

    fn acceleration(&self) -> Option<f64> {
        self.acceleration
    }
}

/// Whether a method has a parameter `reverse`, or takes any by name.
fn takes_reverse(step: &Bound<'_, PyAny>) -> PyResult<bool> {
    let py = step.py();
    let Ok(signature) = py.import("inspect")?.call_method1("signature", (step,)) else {
        // A method written in C need not tell.
        return Ok(false);
    };
    let reverse = [("reverse", false)].into_py_dict(py)?;
    let bound = signature.call_method("bind_partial", (), Some(&reverse));
    Ok(bound.is_ok())
}

/// An angle, or an object that has one and may have target, status and direction.
fn read(answer: &Bound<'_, PyAny>, reverse: bool) -> PyResult<Command> {
    let py = answer.py();
    if answer.is_instance_of::<PyFloat>() || answer.is_instance_of::<PyInt>() {
        return Ok(Command {
            steer: answer.extract()?,
            reverse,
            ..Command::NONE
        });
    }
    let given = |name| -> PyResult<Option<Bound<'_, PyAny>>> {
        let value = answer.getattr_opt(name)?;
        Ok(value.filter(|value| !value.is_none()))
    };
    let steer = given(intern!(py, "steer"))?.and_then(|steer| steer.extract().ok());
    let steer = match steer {
        Some(steer) => steer,
        // What numpy calls a number counts as one.
        None => answer.extract().map_err(|_| {
            let kind = answer.get_type();
            let name = kind
                .name()
                .map_or_else(|_| kind.to_string(), |name| name.to_string());
            let text =
                format!("a controller's step must return an angle or have .steer, got {name}");
            PyTypeError::new_err(text)
        })?,
    };
    let target = given(intern!(py, "target"))?.map(|target| target.extract());
    let target = target
        .transpose()?
        .map_or(Command::NONE.target, Field::from_argument);
    let status = match given(intern!(py, "status"))? {
        None => Status::OK,
        Some(status) => Status::from_bits(status.extract()?).ok_or_else(|| {
            PyTypeError::new_err("a controller's status must be a popsteer.Status")
        })?,
    };
    let turned = given(intern!(py, "reverse"))?.map(|reverse| reverse.extract());
    Ok(Command {
        steer,
        reverse: turned.transpose()?.unwrap_or(reverse),
        target,
        status,
        ..Command::NONE
    })
}
