//! Plants, settings and the simulation.

use std::sync::Arc;

use numpy::{PyArray1, PyArrayMethods};
use popsteer_core::vehicle::Actuator;
use popsteer_core::{InputError, Point, Status, VehicleState};
use popsteer_sim::plant::{self, CarlaIdentified, KinematicBicycle};
use popsteer_sim::{Control, Drive, Plant, Record, Settings, Simulation, closed_loop};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyTuple};

use crate::actuator::PyActuator;
use crate::command::status_code;
use crate::errors::{OrRaise, argument_error, unknown};
use crate::lateral::law_of;
use crate::longitudinal::drive_of;
use crate::metrics::figures;
use crate::params::params;
use crate::path::PyPath;
use crate::python_plant::{PythonPlant, limit_of};

params! {
    /// The vehicle identified from the paper authors' CARLA run.
    ///
    /// Single-track steady-state yaw response with a lag, and a longitudinal model with throttle
    /// lag, drag and loss in bends. The recorded run holds no braking: `braking` is an assumption.
    PyCarlaIdentified(CarlaIdentified) named "CarlaIdentified" in "popsteer.sim",
    defaults CarlaIdentified::DEFAULT, checked by CarlaIdentified::checked,
    wheelbase: f64, "float, default 3.553",
        "Effective wheelbase [m].";
    understeer: f64, "float, default 2.9e-4",
        "Understeer coefficient [s^2/m].";
    yaw_lag: f64, "float, default 0.1",
        "Time constant of the yaw rate [s].";
    throttle_lag: f64, "float, default 0.25",
        "Time constant of the throttle [s].";
    drive: f64, "float, default 6.0",
        "Acceleration at full throttle [m/s^2].";
    drag: f64, "float, default 0.28",
        "Drag linear in speed [1/s].";
    air_drag: f64, "float, default 0.001",
        "Drag quadratic in speed [1/m].";
    bend_loss: f64, "float, default 0.11",
        "Loss in bends.";
    braking: f64, "float, default 9.0",
        "Deceleration at full brake [m/s^2].";
}

params! {
    /// The plain kinematic bicycle about its rear axle, with an engine, brakes and linear drag.
    PyKinematicBicycle(KinematicBicycle) named "KinematicBicycle" in "popsteer.sim",
    defaults KinematicBicycle::DEFAULT, checked by KinematicBicycle::checked,
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles [m].";
    drive: f64, "float, default 6.0",
        "Acceleration at full throttle [m/s^2].";
    drag: f64, "float, default 0.28",
        "Drag linear in speed [1/s].";
    braking: f64, "float, default 9.0",
        "Deceleration at full brake [m/s^2].";
}

params! {
    /// How a run goes.
    PySettings(Settings) named "Settings" in "popsteer.sim",
    defaults Settings::DEFAULT, checked by Settings::checked,
    dt: f64, "float, default 0.05",
        "Control period [s].";
    substeps: usize, "int, default 10",
        "Plant steps in a control period.";
    stop_distance: f64, "float, default 1.0",
        "The end is reached when the front axle has at most this much path ahead [m]; the rear axle where the path is driven in both directions.";
    time_limit: f64, "float, default 1000.0",
        "The run ends unfinished after this time [s].";
    give_up_distance: f64, "float, default 50.0",
        "The run ends unfinished this far from the path [m].";
    settling_time: f64, "float, default 5.0",
        "Errors from this time on count as settled [s].";
    keep_records: bool, "bool, default True",
        "Whether the records are kept; the metrics come either way.";
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
type AnyPlant = (Arc<dyn Plant>, Option<Arc<PythonPlant>>);

/// A plant of the core, or one in Python.
fn any_plant(object: &Bound<'_, PyAny>) -> PyResult<AnyPlant> {
    if let Some(plant) = PythonPlant::of(object)? {
        let plant = Arc::new(plant);
        return Ok((Arc::clone(&plant) as Arc<dyn Plant>, Some(plant)));
    }
    Ok((plant_of(object)?, None))
}

/// A vehicle on a path, moved one control step at a time and measured.
///
/// Parameters
/// ----------
/// path : Path
///     The path.
/// plant : str or CarlaIdentified or KinematicBicycle, default "carla-identified"
///     What moves; or a plant in Python, as `popsteer.plants` has them, which is reset to the start.
/// start : tuple of float
///     Pose of the front axle at the start, (x, y, yaw) [m, m, rad].
/// speed : float, default 0.0
///     Speed at the start [m/s].
/// reference_offset : float, optional
///     Where errors are measured, ahead of the point whose pose `vehicle` gives [m]; by default
///     the plant's front axle. They are measured at the rear axle besides.
/// settings : Settings, optional
///     How the run goes.
/// steering : Actuator, optional
///     What lies between the commands and the plant's wheels; nothing by default.
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
/// A law of your own, here one that always steers straight ahead:
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
    /// What kept the plant from going on.
    limit: Option<String>,
}

#[pymethods]
impl PySimulation {
    #[new]
    #[pyo3(signature = (
        path, plant=None, *, start, speed=0.0, reference_offset=None, settings=None, steering=None
    ))]
    fn new(
        path: Py<PyPath>,
        plant: Option<&Bound<'_, PyAny>>,
        start: (f64, f64, f64),
        speed: f64,
        reference_offset: Option<f64>,
        settings: Option<Py<PySettings>>,
        steering: Option<Py<PyActuator>>,
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
        let offset = reference_offset.unwrap_or(plant.geometry().front_offset);
        let settings = settings.map_or(Settings::DEFAULT, |settings| settings.get().0);
        let simulation = Simulation::new(Arc::clone(&path.get().0), plant, start, offset, settings)
            .or_raise(py)?;
        let steering = match steering {
            None => None,
            Some(steering) => Some(Actuator::new(steering.get().0).or_raise(py)?),
        };
        if let Some(plant) = &python_plant {
            plant.reset(py, simulation.vehicle())?;
        }
        Ok(Self {
            simulation: simulation.with_steering(steering),
            owner: path,
            python_plant,
            limit: None,
        })
    }

    /// The pose that a law is given, and the speed: (x, y, yaw, speed) [m, m, rad, m/s].
    #[getter]
    fn vehicle(&self) -> (f64, f64, f64, f64) {
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
    /// None while it goes on.
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
            .step(control, nowhere, Status::Ok)
            .or_raise(py)?;
        self.look_at_plant(py)
    }

    /// Let a law drive until the run is over.
    ///
    /// Parameters
    /// ----------
    /// law : Pop or PreviewPop or Pid or PurePursuit or Stanley or BangBang
    ///     Its parameters drive, from a fresh state; the object's own state is left alone.
    /// longitudinal : CoupledLongitudinal or SpeedPid, optional
    ///     The pedals; by default the paper's law.
    /// progress : callable, optional
    ///     Called now and then with the share of the path done, 0 to 1.
    #[pyo3(signature = (law, longitudinal=None, progress=None))]
    fn drive(
        &mut self,
        py: Python<'_>,
        law: &Bound<'_, PyAny>,
        longitudinal: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let (law, _) = law_of(law).ok_or_else(|| {
            PyTypeError::new_err("law must be a controller of popsteer; use step for your own")
        })?;
        let drive = match longitudinal {
            None => Drive::default(),
            Some(longitudinal) => drive_of(longitudinal).ok_or_else(|| {
                PyTypeError::new_err("longitudinal must be a CoupledLongitudinal or a SpeedPid")
            })?,
        };
        if self.limit.is_some() {
            return Ok(());
        }
        let python_plant = self.python_plant.clone();
        let mut fault = None;
        let progress = progress.map(|progress| progress.clone().unbind());
        let simulation = &mut self.simulation;
        let mut interrupted: PyResult<()> = Ok(());
        let outcome: Result<(), InputError> = py.detach(|| {
            let mut steps = 0_usize;
            closed_loop::run(simulation, &law, &drive, |simulation| {
                steps += 1;
                fault = python_plant.as_ref().and_then(|plant| plant.take_fault());
                if fault.is_some() {
                    return false;
                }
                if !steps.is_multiple_of(Self::STEPS_PER_LOOK) {
                    return true;
                }
                interrupted = Python::attach(|py| {
                    py.check_signals()?;
                    if let Some(progress) = &progress {
                        progress.call1(py, (simulation.progress(),))?;
                    }
                    Ok(())
                });
                interrupted.is_ok()
            })
        });
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
        Ok(fields)
    }

    /// What was measured step by step: an array of shape (steps,) for each column.
    ///
    /// Columns: time [s]; x, y, yaw, speed of the pose that the laws are given; steer [rad],
    /// throttle, brake; reference_x, reference_y of the law's reference point [m];
    /// cross_track_error [m] and heading_error [rad] there, as the paper measured;
    /// rear_cross_track_error and rear_heading_error at the rear axle; target_x, target_y [m];
    /// status (0 ok, 1 lookahead lost, 2 saturated, 3 end of path, 4 off path).
    fn records<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let records = self.simulation.records();
        let columns = PyDict::new(py);
        for (name, column) in COLUMNS {
            columns.set_item(name, PyArray1::from_iter(py, records.iter().map(*column)))?;
        }
        let status = PyArray1::<u8>::zeros(py, records.len(), false);
        {
            let mut codes = status.try_readwrite()?;
            for (code, record) in codes.as_slice_mut()?.iter_mut().zip(records) {
                *code = status_code(record.status);
            }
        }
        columns.set_item("status", status)?;
        Ok(columns)
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
    /// How many steps run between two looks at signals and progress: about a millisecond.
    const STEPS_PER_LOOK: usize = 256;

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

type Column = (&'static str, fn(&Record) -> f64);

const COLUMNS: &[Column] = &[
    ("time", |record| record.time),
    ("x", |record| record.x),
    ("y", |record| record.y),
    ("yaw", |record| record.yaw),
    ("speed", |record| record.speed),
    ("steer", |record| record.steer),
    ("throttle", |record| record.throttle),
    ("brake", |record| record.brake),
    ("reference_x", |record| record.reference.x),
    ("reference_y", |record| record.reference.y),
    ("cross_track_error", |record| record.cross_track_error),
    ("heading_error", |record| record.heading_error),
    ("rear_cross_track_error", |record| {
        record.rear_cross_track_error
    }),
    ("rear_heading_error", |record| record.rear_heading_error),
    ("target_x", |record| record.target.x),
    ("target_y", |record| record.target.y),
];

/// The names of the plants, and where their axles lie.
///
/// Returns
/// -------
/// dict
///     For each name (front_offset, rear_offset, wheelbase) [m]: how far ahead of the point whose
///     pose the laws are given the axles lie, and what the laws take for their distance.
#[pyfunction]
pub(crate) fn plants(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let named = PyDict::new(py);
    for plant in plant::NAMES.iter().filter_map(|name| plant::by_name(name)) {
        let geometry = plant.geometry();
        let offsets = (
            geometry.front_offset,
            geometry.rear_offset,
            geometry.wheelbase,
        );
        named.set_item(plant.name(), offsets)?;
    }
    Ok(named)
}
