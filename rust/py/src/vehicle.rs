//! The vehicle, how a controller adapts to it, and what it has found.

use std::path::PathBuf;

use popsteer_core::bounds::MAX_SPEED;
use popsteer_core::error::input_in_range;
use popsteer_core::vehicle::{AdaptParams, Known, Vehicle};
use pyo3::prelude::*;

use crate::choice::{Choice, Chosen};
use crate::errors::Raises;
use crate::params::{Number, hash, params};
use crate::record::record;

popsteer_core::Vehicle! { params {
    /// All parameters of a car-like vehicle, in one immutable value.
    ///
    /// A pose is always the pose of the vehicle's point, wherever it is measured; `rear_axle` says
    /// where the axles lie from there. One chain leads from a command to the motion, in prediction,
    /// in preview POP and in plants that are made from a vehicle: ``wheel' = clip((command(t -
    /// dead_time) + steer_offset - wheel) / steer_lag, +-max_steer_rate)`` with ``|wheel| <=
    /// max_steer``, and ``yaw' = speed tan(wheel) / (turning_wheelbase + understeer speed^2)``. The
    /// no-slip point moves along the vehicle's heading.
    PyVehicle(Vehicle) named "Vehicle" in "popsteer";
    @examples {
        /// A car whose pose is measured in the middle between its axles:
        ///
        /// >>> car = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, dead_time=0.15)
        /// >>> car.front_axle
        /// 1.35
        /// >>> car.replace(max_steer=0.6).max_steer
        /// 0.6
        /// >>> popsteer.Vehicle(wheelbase=-1.0)
        /// Traceback (most recent call last):
        /// popsteer.errors.ConfigError: wheelbase must be in [0.001, 1000], got -1.0
    }
    @extra {
        /// How far ahead of the pose's point the front axle lies [m].
        #[getter]
        fn front_axle(&self) -> f64 {
            self.0.front_axle()
        }

        /// The length that turns an angle of the wheels into a curvature.
        ///
        /// ``curvature = tan(wheel) / turning_length`` with ``turning_length = turning_wheelbase +
        /// understeer speed^2``.
        ///
        /// Parameters
        /// ----------
        /// speed : float
        ///     Speed [m/s].
        ///
        /// Returns
        /// -------
        /// float
        ///     The length [m].
        ///
        /// Raises
        /// ------
        /// InputError
        ///     If the speed is not finite or beyond 1e4 m/s.
        ///
        /// Examples
        /// --------
        /// >>> popsteer.Vehicle(understeer=0.01).turning_length(10.0)
        /// 4.0
        fn turning_length(&self, speed: Number) -> Raises<f64> {
            let speed = input_in_range("speed", speed.0, -MAX_SPEED, MAX_SPEED)?;
            Ok(self.0.turning_length(speed))
        }

        /// Read a vehicle from a TOML file, as `save` writes it.
        ///
        /// What the file leaves out has its default.
        ///
        /// Parameters
        /// ----------
        /// file : str or os.PathLike
        ///     The file.
        ///
        /// Returns
        /// -------
        /// Vehicle
        ///     What the file says.
        ///
        /// Raises
        /// ------
        /// ConfigError
        ///     If the file cannot be read or is no TOML, or if a key is unknown, or its value of
        ///     the wrong type or out of range; names file, key and value.
        ///
        /// Examples
        /// --------
        /// >>> import os, tempfile
        /// >>> car = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35)
        /// >>> with tempfile.TemporaryDirectory() as folder:
        /// ...     file = os.path.join(folder, "car.toml")
        /// ...     car.save(file)
        /// ...     popsteer.Vehicle.load(file) == car
        /// True
        #[staticmethod]
        fn load(py: Python<'_>, file: PathBuf) -> PyResult<Py<Self>> {
            let made = vehicle_file(py)?.call_method1("load", (file,))?;
            Ok(made.cast_into::<Self>()?.unbind())
        }

        /// Write the vehicle to a TOML file, each field with its meaning and its unit.
        ///
        /// The file is written whole or not at all. `load` gives an equal vehicle.
        ///
        /// Parameters
        /// ----------
        /// file : str or os.PathLike
        ///     The file to write; folders that are missing are made.
        ///
        /// Raises
        /// ------
        /// OSError
        ///     If the file cannot be written; what stood there before still does.
        fn save(slf: &Bound<'_, Self>, file: PathBuf) -> PyResult<()> {
            vehicle_file(slf.py())?.call_method1("save", (slf, file))?;
            Ok(())
        }

        fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
            hash(&self.as_dict(py)?)
        }
    }
} }

fn vehicle_file(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import("popsteer.vehicle_file")
}

popsteer_core::AdaptParams! { params {
    /// How fast a controller adapts to its vehicle.
    ///
    /// From commands and motion it estimates the ratio of the vehicle's turning to the given one,
    /// the offset of the steering, the dead time, the slip, the acceleration and the scale of the
    /// speed signal. The prediction through the dead time and preview POP use them.
    PyAdaptParams(AdaptParams) named "AdaptParams" in "popsteer";
    @examples {
        /// A controller that adapts at once to new tyres, and one that never does:
        ///
        /// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
        /// >>> quick = popsteer.AdaptParams(turn_time=3.0)
        /// >>> popsteer.PreviewPop(path, adapt=quick).adapt.turn_time
        /// 3.0
        /// >>> popsteer.PreviewPop(path, adapt=None).adapt is None
        /// True
    }
} }

impl Chosen for PyAdaptParams {
    const REQUIRED: &'static str = "adapt must be AdaptParams, None or 'auto'";
}

/// How a controller adapts.
pub(crate) type Adapt = Choice<PyAdaptParams>;

record! {
    /// The estimated vehicle: the given parameters, corrected by what its motion has shown.
    PyEstimate(Known) named "Estimate",
    gain: f64 = 1.0, "float, default 1.0",
        "Ratio of the measured turning to that of the given vehicle. Controllers use it where the vehicle has a dead time; elsewhere it is only shown, and left to the feedback.";
    steer_offset: f64 = 0.0, "float, default 0.0",
        "Angle of the wheels at the command 0 [rad].";
    dead_time: f64 = 0.0, "float, default 0.0",
        "Time from a command to its first effect on the wheels [s].";
    steer_lag: f64 = 0.0, "float, default 0.0",
        "Time constant of the wheels' response [s]: the given one, or less where they turn sooner than without a dead time. One that is longer than given is in the dead time.";
    slip: f64 = 0.0, "float, default 0.0",
        "Angle of the motion of the no-slip point to the heading, straight on [rad].";
    slip_length: f64 = 0.0, "float, default 0.0",
        "How much that angle grows with the curvature [m].";
    acceleration: f64 = 0.0, "float, default 0.0",
        "Acceleration [m/s^2].";
    speed_scale: f64 = 1.0, "float, default 1.0",
        "Ratio of the speed, by the poses, to what the speed signal says: wheels that slip, tyres of another size. What a step is given is multiplied by it.";
    @shown as "(*, gain=1.0, steer_offset=0.0, dead_time=0.0, steer_lag=0.0, slip=0.0, slip_length=0.0, acceleration=0.0, speed_scale=1.0)", with as_dict;
    @examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
        /// >>> car = popsteer.Vehicle(dead_time=0.2, steer_offset=0.01)
        /// >>> estimate = popsteer.Pop(path, car).estimate
        /// >>> estimate.dead_time, estimate.steer_offset, estimate.gain
        /// (0.2, 0.01, 1.0)
    }
}
