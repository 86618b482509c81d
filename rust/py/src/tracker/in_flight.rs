//! The commands in flight of a controller written in Python.

use popsteer_core::vehicle::state::checked_dt;
use popsteer_core::vehicle::{Estimate, InFlight, Vehicle, VehicleState};
use pyo3::prelude::*;

use crate::errors::OrRaise;
use crate::vehicle::PyVehicle;

/// The commands that are given to a vehicle but have not reached its wheels, and the wheels.
#[pyclass(name = "_InFlight", module = "popsteer._core")]
pub(crate) struct PyInFlight {
    vehicle: Vehicle,
    in_flight: InFlight,
}

#[pymethods]
impl PyInFlight {
    /// The command 0 in flight, and the wheels at rest under it.
    #[new]
    fn new(vehicle: &PyVehicle) -> Self {
        Self {
            vehicle: vehicle.0,
            in_flight: InFlight::settled(&vehicle.0, 0.0),
        }
    }

    /// Lets `dt` [s] pass since the angle `last` [rad] was commanded, and predicts: x, y [m], yaw
    /// [rad] and speed [m/s] of the no-slip point, and the angle of the wheels [rad], when a
    /// command given now reaches them. The pose given is that of the vehicle's point, now.
    fn advance(
        &mut self,
        py: Python<'_>,
        last: f64,
        dt: f64,
        x: f64,
        y: f64,
        yaw: f64,
        speed: f64,
    ) -> PyResult<(f64, f64, f64, f64, f64)> {
        let now = VehicleState { x, y, yaw, speed }.checked().or_raise(py)?;
        let dt = checked_dt(dt).or_raise(py)?;
        let Self { vehicle, in_flight } = self;
        in_flight.elapse(vehicle, last, dt, 0.0);
        let now = now.ahead(vehicle.no_slip());
        let (then, wheel) = in_flight.predict(vehicle, now, in_flight.wheel(), &Estimate::DEFAULT);
        Ok((then.x, then.y, then.yaw, then.speed, wheel))
    }
}
