//! What lies between commands and wheels.

use popsteer_core::vehicle::{Actuator, ActuatorParams};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::params::params;

params! {
    /// What lies between a command and the wheels: dead time, a first-order lag, a rate limit.
    ///
    /// A law with an actuator is shown the vehicle as it will be when its command reaches the
    /// wheels: rolled forward, at its present speed, through the commands still under way, by a
    /// kinematic bicycle whose wheels follow them with the lag. The errors of its commands are
    /// those of that vehicle. What it commands keeps the rate. With a `learning_time` the way of the
    /// vehicle teaches how wrong wheelbase and dead time are, and how the speed changes.
    PyActuator(ActuatorParams) named "Actuator" in "popsteer",
    defaults ActuatorParams::DEFAULT, checked by Actuator::new,
    dead_time: f64, "float, default 0.0",
        "Time from a command to its first effect on the wheels [s].";
    lag: f64, "float, default 0.0",
        "Time constant with which the wheels then follow it [s]; a lag of the yaw rate counts here as well.";
    max_rate: Option<f64>, "float, optional",
        "Fastest move of the wheels [rad/s]; None for no limit.";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles of the vehicle that is predicted [m].";
    understeer: f64, "float, default 0.0",
        "Understeer of the vehicle that is predicted [s^2/m]: yaw rate = speed tan(steer) / (wheelbase + understeer speed^2).";
    learning_time: f64, "float, default 0.0",
        "Time over which is learnt how much more the vehicle turns than the model says (a half to twice), how much longer the dead time is (by up to a half), and how its speed changes [s]; 0 never.";
}
