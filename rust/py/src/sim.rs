//! Plants, settings and the simulation.

use std::sync::Arc;
use std::time::{Duration, Instant};

use numpy::PyArray1;
use popsteer_core::path::Follow;
use popsteer_core::{InputError, Point, Status, VehicleState};
use popsteer_sim::plant::CarlaIdentified;
use popsteer_sim::{
    Control, Controller, Perception, Plant, Record, Saved, Settings, Simulation, closed_loop,
};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyTuple};
use pyo3::{PyTraverseError, PyVisit};

use crate::errors::{OrRaise, argument_error};
use crate::lateral::law_of;
use crate::longitudinal::{GivenPedals, drive_for};
use crate::metrics::figures;
use crate::path::PyPath;
use crate::plants::{any_plant, plant_object};
use crate::python_driver::PythonDriver;
use crate::python_plant::{PythonPlant, limit_of};
use crate::records::{Begin, SavedState, columns_of};
use crate::settings::{PyNoise, PySettings};
use crate::vehicle::PyVehicle;

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
    owner: Py<PyPath>,
    python_plant: Option<Arc<PythonPlant>>,
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
        let (plant, python_plant) = match plant {
            Some(plant) => any_plant(plant)?,
            None => (Arc::new(CarlaIdentified::DEFAULT) as Arc<dyn Plant>, None),
        };
        let start = VehicleState {
            x: start.0,
            y: start.1,
            yaw: start.2,
            speed,
        };
        let simulation = begun(py, &path, &plant, start, tracked_point, settings)?;
        if let Some(plant) = &python_plant {
            plant.reset(py, start)?;
        }
        let VehicleState { x, y, yaw, speed } = start;
        Ok(Self {
            simulation,
            owner: path,
            start: (x, y, yaw, speed),
            tracked_point: tracked_point.unwrap_or(plant.vehicle().front_axle()),
            python_plant,
            limit: None,
        })
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.owner)?;
        match &self.python_plant {
            Some(plant) => plant.traverse(&visit),
            None => Ok(()),
        }
    }

    fn __clear__(&mut self) {
        if let Some(plant) = &self.python_plant {
            plant.clear();
        }
    }

    /// The state of a copy, or of one that is restored from a file.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let this = slf.try_borrow()?;
        let plant = match &this.python_plant {
            Some(plant) => plant.object(py)?,
            None => plant_object(py, this.simulation.plant().as_ref())?,
        };
        let settings = PySettings(*this.simulation.settings());
        let saved = this.simulation.save();
        let records: Vec<f64> = saved.records.iter().flat_map(Record::numbers).collect();
        let state = (
            PyArray1::from_vec(py, saved.numbers),
            saved.commands,
            PyArray1::from_vec(py, records),
            this.limit.clone(),
        );
        let begin = (
            this.owner.clone_ref(py),
            plant,
            this.start,
            this.tracked_point,
            settings,
        );
        let restore = slf.get_type().getattr("_restored")?;
        (restore, (begin, state)).into_pyobject(py)
    }

    /// The simulation that `__reduce__` took apart. The plant goes on as it is.
    #[staticmethod]
    #[pyo3(name = "_restored")]
    fn restored(py: Python<'_>, begin: Begin<'_>, state: SavedState<'_>) -> PyResult<Self> {
        let (path, plant, start, tracked_point, settings) = begin;
        let (plant, python_plant) = any_plant(&plant)?;
        let (x, y, yaw, speed) = start;
        let beginning = VehicleState { x, y, yaw, speed };
        let simulation = begun(
            py,
            &path,
            &plant,
            beginning,
            Some(tracked_point),
            Some(settings),
        )?;
        let (numbers, commands, records, limit) = state;
        let (records, _) = records.as_slice()?.as_chunks();
        let saved = Saved {
            numbers: numbers.as_slice()?.to_vec(),
            commands,
            records: records.iter().copied().map(Record::of).collect(),
        };
        Ok(Self {
            simulation: simulation.restored(saved),
            owner: path,
            python_plant,
            start,
            tracked_point,
            limit,
        })
    }

    /// The pose of the vehicle's point, and the speed: (x, y, yaw, speed) [m, m, rad, m/s].
    #[getter]
    fn state(&self) -> (f64, f64, f64, f64) {
        let VehicleState { x, y, yaw, speed } = self.simulation.vehicle();
        (x, y, yaw, speed)
    }

    /// The path.
    #[getter]
    fn path(&self, py: Python<'_>) -> Py<PyPath> {
        self.owner.clone_ref(py)
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
    ) -> PyResult<()> {
        if reverse && !self.simulation.plant().reverses() {
            let required = format!("False, as {} does not reverse", self.plant());
            let given = PyBool::new(py, reverse).to_owned().into_any();
            return Err(argument_error(py, "reverse", given, &required));
        }
        let nowhere = Point::new(f64::NAN, f64::NAN);
        let control = Control {
            steer,
            throttle,
            brake,
            reverse,
        };
        self.simulation
            .step(control, nowhere, Status::OK)
            .or_raise(py)?;
        self.look_at_plant(py)
    }

    /// Let a controller drive until the run is over.
    ///
    /// Parameters
    /// ----------
    /// controller : Pop or PreviewPop or Pid or PurePursuit or Stanley or BangBang, or your own
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
    #[expect(
        clippy::too_many_arguments,
        reason = "each is one thing that a run may have"
    )]
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
        let drive = drive_for(longitudinal, self.simulation.plant().as_ref(), pedals)?;
        if self.limit.is_some() {
            return Ok(());
        }
        let noise = noise.map_or(popsteer_sim::Noise::DEFAULT, |noise| noise.get().0);
        let perception = Perception::new(noise, seed, 0);
        let python_plant = self.python_plant.clone();
        let mut fault = None;
        let progress = progress.map(|progress| progress.clone().unbind());
        let mut interrupted: PyResult<()> = Ok(());
        let mut looked = Instant::now();
        let go_on = |simulation: &Simulation| {
            fault = python_plant.as_ref().and_then(|plant| plant.take_fault());
            if fault.is_some() {
                return false;
            }
            if looked.elapsed() < Self::LOOK_EVERY {
                return true;
            }
            interrupted = Python::attach(|py| {
                py.check_signals()?;
                if let Some(progress) = &progress {
                    progress.call1(py, (simulation.progress(),))?;
                }
                Ok(())
            });
            looked = Instant::now();
            interrupted.is_ok()
        };
        let simulation = &mut self.simulation;
        let mut raised = None;
        let outcome: Result<(), InputError> = if let Some((tracker, _)) = law_of(controller) {
            py.detach(|| {
                simulation.track(*tracker.follow());
                let mut driver = Controller::new(&tracker);
                closed_loop::run(simulation, &mut driver, &drive, perception, go_on)
            })
        } else {
            let mut driver = PythonDriver::of(controller)?;
            let outcome =
                py.detach(|| closed_loop::run(simulation, &mut driver, &drive, perception, go_on));
            raised = driver.take_fault();
            outcome
        };
        if let Some(error) = raised {
            return Err(error);
        }
        interrupted?;
        outcome.or_raise(py)?;
        self.take_note(py, fault)
    }

    /// What the run came to so far, by name.
    fn metrics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let metrics = self.simulation.metrics();
        let fields = PyDict::new(py);
        for (name, figure) in figures() {
            fields.set_item(name, figure(&metrics))?;
        }
        fields.set_item("steps", metrics.steps)?;
        fields.set_item("finished", metrics.finished)?;
        fields.set_item("faults", metrics.faults.bits())?;
        Ok(fields)
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
    /// How often signals and progress are handled, however long a step takes.
    const LOOK_EVERY: Duration = Duration::from_millis(100);

    /// Raises what a plant in Python raised; a limit of it ends the run instead.
    fn look_at_plant(&mut self, py: Python<'_>) -> PyResult<()> {
        let fault = self
            .python_plant
            .as_ref()
            .and_then(|plant| plant.take_fault());
        self.take_note(py, fault)
    }

    fn take_note(&mut self, py: Python<'_>, fault: Option<PyErr>) -> PyResult<()> {
        let Some(error) = fault else { return Ok(()) };
        self.limit = limit_of(py, &error)?;
        if self.limit.is_some() {
            Ok(())
        } else {
            Err(error)
        }
    }
}

/// A simulation at its start.
fn begun(
    py: Python<'_>,
    path: &Py<PyPath>,
    plant: &Arc<dyn Plant>,
    start: VehicleState,
    tracked_point: Option<f64>,
    settings: Option<Py<PySettings>>,
) -> PyResult<Simulation> {
    let vehicle = plant.vehicle();
    let ahead = tracked_point.map_or(vehicle.wheelbase, |point| point - vehicle.rear_axle);
    let settings = settings.map_or(Settings::DEFAULT, |settings| settings.get().0);
    let (path, plant) = (Arc::clone(&path.get().0), Arc::clone(plant));
    let tracked = Follow::of(vehicle, vehicle.rear_axle, ahead);
    Simulation::new(path, plant, start, tracked, settings).or_raise(py)
}
