//! The simulation.

use std::sync::Arc;

use popsteer_core::path::Follow;
use popsteer_core::{Point, Status, VehicleState};
use popsteer_sim::plant::CarlaIdentified;
use popsteer_sim::{Control, Noise, Perception, Plant, Settings, Simulation};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyTuple};
use pyo3::{PyTraverseError, PyVisit};

use crate::driving::driven;
use crate::errors::{Raises, argument_error};
use crate::metrics::{by_name, columns_of};
use crate::params::params;
use crate::path::PyPath;
use crate::plants::{any_plant, plant_object, python_plant};
use crate::python_plant::{PythonPlant, limit_of};
use crate::speed::controllers::{GivenPedals, longitudinal_for};
use crate::tracker::state;
use crate::vehicle::PyVehicle;

popsteer_sim::Settings! { params {
    /// How a run goes.
    PySettings(Settings) named "Settings" in "popsteer.sim";
} }

popsteer_sim::Noise! { params {
    /// Noise of pose and speed as a controller gets them: standard deviations of normal noise.
    ///
    /// Drawn anew at every control step, independent of one another. The vehicle itself, and what
    /// is measured of it, are without noise.
    PyNoise(Noise) named "Noise" in "popsteer.sim";
} }

/// Path, plant, start, tracked point and settings of a simulation that was taken apart.
type Begin<'py> = (
    Py<PyPath>,
    Bound<'py, PyAny>,
    (f64, f64, f64, f64),
    f64,
    Py<PySettings>,
);

/// A vehicle on a path, moved one control step at a time and measured.
///
/// Parameters
/// ----------
/// path : Path
///     The path.
/// plant : str or CarlaIdentified or KinematicBicycle, default "carla-identified"
///     What moves; or a plant in Python, as `popsteer.plants` has them, which is reset to the
///     start.
/// start : tuple of float
///     Pose of the vehicle's point at the start, (x, y, yaw) [m, m, rad].
/// speed : float, default 0.0
///     Speed at the start [m/s].
/// tracked_point : float, optional
///     Where errors are measured, ahead of the vehicle's point [m]; by default the plant's front
///     axle. They are also measured at the rear axle.
/// settings : Settings, optional
///     How the run goes.
///
/// Notes
/// -----
/// Dead time and steering offset of the plant's vehicle lie between the commands and any plant;
/// lag, rate and limits are the plant's own.
///
/// Raises
/// ------
/// ConfigError
///     If the plant is not known.
/// InputError
///     If the start is not finite or beyond its bound.
///
/// Examples
/// --------
/// A controller of your own, here one that always steers straight ahead:
///
/// >>> import popsteer.sim
/// >>> path = popsteer.Path([(float(x), 0.0) for x in range(50)])
/// >>> simulation = popsteer.sim.Simulation(path, start=(0.0, 0.0, 0.0))
/// >>> while not simulation.is_over:
/// ...     simulation.step(steer=0.0, throttle=0.5)
/// >>> simulation.is_finished
/// True
#[pyclass(name = "Simulation", module = "popsteer.sim")]
#[derive(Debug)]
pub(crate) struct PySimulation {
    simulation: Simulation,
    /// The path.
    #[pyo3(get, name = "path")]
    owner: Py<PyPath>,
    start: (f64, f64, f64, f64),
    tracked_point: f64,
    /// What kept the plant from going on.
    limit: Option<String>,
}

#[pymethods]
impl PySimulation {
    #[new]
    #[pyo3(signature = (
        path, plant=None, *, start, speed=0.0, tracked_point=None, settings=None
    ))]
    fn new(
        path: Py<PyPath>,
        plant: Option<&Bound<'_, PyAny>>,
        start: (f64, f64, f64),
        speed: f64,
        tracked_point: Option<f64>,
        settings: Option<Py<PySettings>>,
        py: Python<'_>,
    ) -> PyResult<Self> {
        let plant = match plant {
            Some(plant) => any_plant(plant)?,
            None => Arc::new(CarlaIdentified::DEFAULT),
        };
        let (x, y, yaw) = start;
        let begun = Self::begun(path, plant, (x, y, yaw, speed), tracked_point, settings)?;
        if let Some(plant) = python_plant(&begun.simulation) {
            plant.reset(py, VehicleState { x, y, yaw, speed })?;
        }
        Ok(begun)
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.owner)?;
        python_plant(&self.simulation).map_or(Ok(()), |plant| plant.traverse(&visit))
    }

    fn __clear__(&mut self) {
        if let Some(plant) = python_plant(&self.simulation) {
            plant.clear();
        }
    }

    /// The state of a copy, or of one that is restored from a file.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let this = slf.try_borrow()?;
        let plant = plant_object(py, this.simulation.plant().as_ref())?;
        let (start, point) = (this.start, this.tracked_point);
        let begin = (&this.owner, plant, start, point, this.settings());
        let state = state::data(&this.simulation.save(), py)?;
        let restore = slf.get_type().getattr("_restored")?;
        (restore, (begin, state, &this.limit)).into_pyobject(py)
    }

    /// The simulation that `__reduce__` took apart. The plant goes on as it is.
    #[staticmethod]
    #[pyo3(name = "_restored")]
    fn restored(
        begin: Begin<'_>,
        state: Bound<'_, PyAny>,
        limit: Option<String>,
    ) -> PyResult<Self> {
        let (path, plant, start, tracked_point, settings) = begin;
        let (plant, tracked_point) = (any_plant(&plant)?, Some(tracked_point));
        let begun = Self::begun(path, plant, start, tracked_point, Some(settings))?;
        Ok(Self {
            simulation: begun.simulation.restored(state::of_data(state)?),
            limit,
            ..begun
        })
    }

    /// The pose of the vehicle's point, and the speed: (x, y, yaw, speed) [m, m, rad, m/s].
    #[getter]
    fn state(&self) -> (f64, f64, f64, f64) {
        let VehicleState { x, y, yaw, speed } = self.simulation.vehicle();
        (x, y, yaw, speed)
    }

    /// The name of the plant.
    #[getter]
    fn plant(&self) -> &str {
        self.simulation.plant().name()
    }

    /// How the run goes.
    #[getter]
    fn settings(&self) -> PySettings {
        PySettings(*self.simulation.settings())
    }

    /// Time since the start [s].
    #[getter]
    fn time(&self) -> f64 {
        self.simulation.time()
    }

    /// What moves is: the vehicle of the plant.
    #[getter]
    fn vehicle(&self) -> PyVehicle {
        PyVehicle(*self.simulation.plant().vehicle())
    }

    /// Whether the path is driven backwards where the rear axle is.
    #[getter]
    fn reverse(&self) -> bool {
        self.simulation.reverse()
    }

    /// Share of the path behind the front axle, or behind the rear axle where the path is driven
    /// in both directions, 0 to 1.
    #[getter]
    fn progress(&self) -> f64 {
        self.simulation.progress()
    }

    /// Whether the end of the path was reached; of a closed one, once around.
    #[getter]
    fn is_finished(&self) -> bool {
        self.simulation.is_finished()
    }

    /// Whether the run is over: finished, out of time, too far from the path, or at a limit of
    /// the plant.
    #[getter]
    fn is_over(&self) -> bool {
        self.limit.is_some() || self.simulation.is_over()
    }

    /// How the run ended: "finished", "time limit", "too far from the path", "plant limit: WHICH";
    /// None while it continues.
    #[getter]
    fn ending(&self) -> Option<String> {
        if let Some(limit) = &self.limit {
            return Some(format!("plant limit: {limit}"));
        }
        let simulation = &self.simulation;
        let ending = match (simulation.is_finished(), simulation.is_over()) {
            (true, _) => "finished",
            (false, false) => return None,
            _ if simulation.time() >= simulation.settings().time_limit => "time limit",
            _ => "too far from the path",
        };
        Some(ending.to_owned())
    }

    /// Reference speed of the path beside the axle that leads [m/s], negative where the path is
    /// driven backwards; None where it has none.
    #[getter]
    fn reference_speed(&self) -> Option<f64> {
        self.simulation.reference_speed()
    }

    /// Measure the vehicle, then move it on by one control step.
    ///
    /// Parameters
    /// ----------
    /// steer : float
    ///     Angle of the front wheels [rad].
    /// throttle, brake : float, default 0.0
    ///     Pedals, 0 to 1.
    /// reverse : bool, default False
    ///     Whether the throttle drives backwards.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If a number is not finite or beyond its bound, or the plant is to reverse and does not;
    ///     nothing moves then.
    ///
    /// Notes
    /// -----
    /// A plant in Python that comes to a limit of its model ends the run: `is_over` is true from
    /// then on, and `ending` says which limit it was. What else it raises reaches you.
    #[pyo3(signature = (steer, throttle=0.0, brake=0.0, reverse=false))]
    fn step(
        &mut self,
        py: Python<'_>,
        steer: f64,
        throttle: f64,
        brake: f64,
        reverse: bool,
    ) -> Raises<()> {
        if reverse && !self.simulation.plant().reverses() {
            let required = format!("False, as {} does not reverse", self.plant());
            let given = PyBool::new(py, reverse).to_owned().into_any();
            return Err(argument_error(py, "reverse", given, &required).into());
        }
        let nowhere = Point::new(f64::NAN, f64::NAN);
        let control = Control {
            steer,
            throttle,
            brake,
            reverse,
        };
        self.simulation.step(control, nowhere, Status::OK)?;
        let fault = python_plant(&self.simulation).and_then(PythonPlant::take_fault);
        Ok(self.take_note(py, fault)?)
    }

    /// Let a controller drive until the run is over.
    ///
    /// Parameters
    /// ----------
    /// controller : Pop or PreviewPop or Pid or PurePursuit or Stanley, or your own
    ///     One of popsteer drives from a fresh state; the object's own state is left alone. Your
    ///     own has a method ``step(x, y, yaw, speed, dt)``, which returns an angle [rad] or an
    ///     object with `steer` and, if it likes, `target`, `status` and `reverse`. If it has a
    ///     parameter `reverse`, it gets whether the path is driven backwards where the rear axle
    ///     is.
    /// longitudinal : CoupledLongitudinal or SpeedPid or SpeedTracker, optional
    ///     The pedals, from a fresh state, too; by default the paper's controller.
    /// progress : callable, optional
    ///     Called ten times a second with the share of the path done, 0 to 1.
    /// noise : Noise, optional
    ///     Noise of pose and speed as the controllers get them; none by default.
    /// seed : int, default 0
    ///     Where the noise comes from.
    /// pedals : PedalMap, optional
    ///     Which pedals give the accelerations of a `SpeedTracker`; by default the plant's.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If an angle is not finite or beyond its bound, or `pedals` is left out with a plant that
    ///     has no `drive`, `braking` and `drag`.
    /// TypeError
    ///     If the object has no `step`, or that returns no angle. What `step` raises reaches you.
    #[pyo3(signature = (
        controller, longitudinal=None, progress=None, *, noise=None, seed=0, pedals=None
    ))]
    fn drive(
        &mut self,
        py: Python<'_>,
        controller: &Bound<'_, PyAny>,
        longitudinal: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
        noise: Option<Py<PyNoise>>,
        seed: u64,
        pedals: Option<GivenPedals>,
    ) -> PyResult<()> {
        let longitudinal =
            longitudinal_for(longitudinal, self.simulation.plant().as_ref(), pedals)?;
        if self.limit.is_some() {
            return Ok(());
        }
        let noise = noise.map_or(Noise::DEFAULT, |noise| noise.get().0);
        let (simulation, seen) = (&mut self.simulation, Perception::new(noise, seed, 0));
        let fault = driven(py, simulation, controller, &longitudinal, seen, progress)?;
        self.take_note(py, fault)
    }

    /// What the run came to so far, by name.
    fn metrics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_name(py, &self.simulation.metrics())
    }

    /// What was measured step by step: an array of shape (steps,) for each column.
    ///
    /// Columns: time [s]; x, y, yaw, speed of the vehicle's point; steer [rad], throttle, brake;
    /// reference_x, reference_y of the tracked point [m]; cross_track_error [m] and heading_error
    /// [rad] there, as the paper measured; rear_cross_track_error and rear_heading_error at the
    /// rear axle; target_x, target_y [m]; status, the bits of `popsteer.Status` (uint32).
    fn records<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        columns_of(py, self.simulation.records())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!(
            "<Simulation of {} on {}, {:.2} s>",
            self.simulation.plant().name(),
            self.owner.bind(py).repr()?,
            self.simulation.time()
        ))
    }
}

impl PySimulation {
    /// A simulation at its start.
    fn begun(
        path: Py<PyPath>,
        plant: Arc<dyn Plant>,
        start: (f64, f64, f64, f64),
        tracked_point: Option<f64>,
        settings: Option<Py<PySettings>>,
    ) -> Raises<Self> {
        let (x, y, yaw, speed) = start;
        let vehicle = *plant.vehicle();
        let ahead = tracked_point.map_or(vehicle.wheelbase, |point| point - vehicle.rear_axle);
        let tracked = Follow::of(&vehicle, vehicle.rear_axle, ahead);
        let settings = settings.map_or(Settings::DEFAULT, |settings| settings.get().0);
        let (shared, at) = (Arc::clone(&path.get().0), VehicleState { x, y, yaw, speed });
        Ok(Self {
            simulation: Simulation::new(shared, plant, at, tracked, settings)?,
            owner: path,
            start,
            tracked_point: tracked_point.unwrap_or(vehicle.front_axle()),
            limit: None,
        })
    }

    /// Raises what a plant in Python raised; a limit of it ends the run instead.
    fn take_note(&mut self, py: Python<'_>, fault: Option<PyErr>) -> PyResult<()> {
        let Some(error) = fault else { return Ok(()) };
        match limit_of(py, &error)? {
            None => Err(error),
            limit => {
                self.limit = limit;
                Ok(())
            }
        }
    }
}
