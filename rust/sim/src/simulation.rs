//! A vehicle on a path, moved one control step at a time and measured.

use std::sync::Arc;

use popsteer_core::error::{ConfigError, InputError, input_in_range};
use popsteer_core::geometry::get_distance;
use popsteer_core::math::{from_count, sqrt, wrap};
use popsteer_core::path::projection::path_yaw_behind;
use popsteer_core::path::{Ahead, Follow, Located};
use popsteer_core::speed::defaults;
use popsteer_core::{Path, Point, Status, VehicleState};

use crate::delay::Delay;
use crate::metrics::{Gatherer, Metrics};
use crate::plant::{Control, Plant, PlantState};
use crate::record::Record;

popsteer_core::params! {
    /// How a run goes: by default with the paper's control period, and the rest to suit.
    pub struct Settings {
        /// Control period [s].
        dt: f64 = 0.05, in [1e-6, 1.0];
        /// Plant steps in a control period.
        substeps: usize = 10, in [1, 1_000_000];
        /// The end is reached when the front axle has at most this much path ahead [m]; the rear
        /// axle where the path is driven in both directions.
        stop_distance: f64 = 1.0, in [0.0, 1e6];
        /// The run ends unfinished after this time [s].
        time_limit: f64 = 1000.0, in [dt, 1e6];
        /// The run ends unfinished this far from the path [m].
        give_up_distance: f64 = 50.0, in [1e-3, 1e9];
        /// Errors from this time on count as settled [s].
        settling_time: f64 = 5.0, in [0.0, 1e6];
        /// Whether the records are kept; the metrics come either way.
        keep_records: bool = true;
    }
}

/// A vehicle on a path, moved one control step at a time and measured.
#[derive(Clone, Debug)]
pub struct Simulation {
    path: Arc<Path>,
    plant: Arc<dyn Plant>,
    settings: Settings,
    /// The point where errors are measured.
    tracked: Follow,
    pub(crate) rear: Follow,
    leading: Follow,
    pub(crate) run: RunState,
}

impl Simulation {
    /// A vehicle at rest or rolling at `start`, the pose of its point; errors are measured at the
    /// point that `tracked` follows, and at the rear axle.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] for a setting out of its range, [`InputError`] for a bad start.
    pub fn new(
        path: Arc<Path>,
        plant: Arc<dyn Plant>,
        start: VehicleState,
        tracked: Follow,
        settings: Settings,
    ) -> Result<Self, SimulationError> {
        let settings = settings.checked()?;
        let start = start.checked()?;
        let vehicle = plant.vehicle().checked()?;
        let reverses = path.view().reverse().is_some();
        if reverses && !plant.reverses() {
            return Err(SimulationError::NoReverse {
                plant: plant.name().to_owned(),
            });
        }
        // Where the vehicle changes its direction no axle leads all the way; the rear one is at
        // the path's.
        let lead = if reverses { 0.0 } else { vehicle.wheelbase };
        let leading = unlost(Follow::of(&vehicle, vehicle.rear_axle, lead));
        let rear = unlost(Follow::of(&vehicle, vehicle.rear_axle, 0.0));
        let view = path.view();
        let closest = leading.locate(&view, None, start, settings.dt).closest;
        let behind = rear.locate(&view, None, start, settings.dt);
        let run = RunState {
            plant: PlantState::settled(&vehicle, start),
            reference: None,
            rear: Some(behind.closest.segment),
            leading: Some(closest.segment),
            reverse: behind.reverse,
            leading_arc: closest.arc_length(&view),
            delay: Delay::new(vehicle.dead_time),
            travelled: 0.0,
            steps: 0,
            finished: false,
            lost: false,
            gatherer: Gatherer::default(),
            records: Vec::new(),
        };
        Ok(Self {
            path,
            plant,
            settings,
            tracked: unlost(tracked),
            rear,
            leading,
            run,
        })
    }

    /// The pose of the vehicle's point, and the speed.
    pub fn vehicle(&self) -> VehicleState {
        self.run.plant.vehicle
    }

    /// Whether the path is driven backwards where the rear axle is.
    pub fn reverse(&self) -> bool {
        self.run.reverse
    }

    /// The path driven.
    pub fn path(&self) -> &Arc<Path> {
        &self.path
    }

    /// Measures errors at the point that `tracked` follows from now on.
    pub fn track(&mut self, tracked: Follow) {
        self.tracked = unlost(tracked);
    }

    /// The plant that moves.
    pub fn plant(&self) -> &Arc<dyn Plant> {
        &self.plant
    }

    /// How the run goes.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Time since the start [s].
    pub fn time(&self) -> f64 {
        from_count(self.run.steps) * self.settings.dt
    }

    /// Share of the path behind the front axle, or behind the rear axle where the path is driven
    /// in both directions, 0 to 1.
    pub fn progress(&self) -> f64 {
        let length = self.path.view().length();
        let done = if self.path.view().is_closed() {
            self.run.travelled
        } else {
            self.run.leading_arc
        };
        (done / length).clamp(0.0, 1.0)
    }

    /// Whether the end of the path was reached: of an open one, or once around a closed one.
    pub fn is_finished(&self) -> bool {
        self.run.finished
    }

    /// Whether the run is over: finished, out of time, or too far from the path.
    pub fn is_over(&self) -> bool {
        self.run.finished || self.run.lost || self.time() >= self.settings.time_limit
    }

    /// All that the simulation remembers beside its path, its plant and its settings.
    pub fn save(&self) -> RunState {
        self.run.clone()
    }

    /// This simulation as it was when it was saved.
    #[must_use]
    pub fn restored(mut self, mut run: RunState) -> Self {
        let segments = self.path.view().segments();
        for place in [&mut run.reference, &mut run.rear, &mut run.leading] {
            // A place that the path does not have is none.
            *place = place.filter(|&segment| segment < segments);
        }
        self.run = run;
        self
    }

    /// What was measured so far, a record a step, where the settings keep them.
    pub fn records(&self) -> &[Record] {
        &self.run.records
    }

    /// What the run came to so far.
    pub fn metrics(&self) -> Metrics {
        self.run.gatherer.metrics(self.time(), self.run.finished)
    }

    /// Where a point of the vehicle is now, if it was last projected to the segment `place`.
    pub(crate) fn locate(&self, follow: &Follow, place: Option<usize>) -> Located {
        let (path, vehicle) = (self.path.view(), self.run.plant.vehicle);
        follow.locate(&path, place, vehicle, self.settings.dt)
    }

    /// What the path says beside the axle that leads, by the numbers of a controller's command.
    fn ahead(&self) -> Ahead {
        let at = self.locate(&self.leading, self.run.leading);
        Ahead::behind(&self.path.view(), &self.leading, &at, 0.0)
    }

    /// The vehicle as it is measured: its pose at the antenna, on level ground.
    pub fn measured(&self) -> VehicleState {
        let car = self.plant.vehicle();
        self.vehicle().left(car.antenna_offset(0.0))
    }

    /// Reference speed of the path beside the axle that leads [m/s], where it has one; negative
    /// where the path is driven backwards.
    pub fn reference_speed(&self) -> Option<f64> {
        self.ahead().reference_speed
    }

    /// The same, slow enough to brake for the next cusp and the end where the path is driven in
    /// both directions: at the vehicle's `max_deceleration`, 2 m/s^2 where that is not known.
    pub(crate) fn stopping_speed(&self) -> Option<f64> {
        let ahead = self.ahead();
        let speed = ahead.reference_speed?;
        if self.path.view().reverse().is_none() {
            return Some(speed);
        }
        let deceleration = self
            .plant
            .vehicle()
            .max_deceleration
            .unwrap_or(defaults::STOP_DECELERATION);
        let remaining = ahead.distance_to_stop.max(0.0);
        let most = sqrt(2.0 * deceleration * remaining).max(Ahead::creep(&self.leading));
        Some(speed.abs().min(most).copysign(speed))
    }

    /// Measures the vehicle, then moves it on by one control step under `control`.
    ///
    /// `target` and `status` go into the record as they are.
    ///
    /// # Errors
    ///
    /// [`InputError`] for a control that is not finite or beyond its bound, and for `reverse` of a
    /// plant that does not, named with the value 1; nothing moves then.
    pub fn step(
        &mut self,
        control: Control,
        target: Point,
        status: Status,
    ) -> Result<(), InputError> {
        input_in_range("steer", control.steer, -1.57, 1.57)?;
        input_in_range("throttle", control.throttle, 0.0, 1.0)?;
        input_in_range("brake", control.brake, 0.0, 1.0)?;
        if control.reverse && !self.plant.reverses() {
            input_in_range("reverse", 1.0, 0.0, 0.0)?;
        }

        let record = self.measure(control, target, status);
        let (run, settings) = (&mut self.run, &self.settings);
        (run.gatherer).push(&record, settings.settling_time, settings.dt);
        if settings.keep_records {
            run.records.push(record);
        }
        let substeps = settings.substeps;
        let dt = settings.dt / from_count(substeps);
        let offset = self.plant.vehicle().steer_offset;
        (run.delay).pass(control.steer, dt, substeps, |command, substeps| {
            let steer = command + offset;
            (self.plant).advance(&mut run.plant, Control { steer, ..control }, dt, substeps);
        });
        run.steps += 1;
        self.look_ahead();
        Ok(())
    }

    fn measure(&mut self, control: Control, target: Point, status: Status) -> Record {
        let (vehicle, path) = (self.run.plant.vehicle, self.path.view());
        let at = self.locate(&self.tracked, self.run.reference);
        let published_yaw = path_yaw_behind(&path, at.closest.nearest_waypoint(&path));
        let rear = self.locate(&self.rear, self.run.rear);
        self.run.reference = Some(at.closest.segment);
        self.run.rear = Some(rear.closest.segment);
        Record {
            time: self.time(),
            reference: at.position,
            x: vehicle.x,
            y: vehicle.y,
            yaw: vehicle.yaw,
            speed: vehicle.speed,
            steer: control.steer,
            throttle: control.throttle,
            brake: control.brake,
            cross_track_error: at.closest.cross_track_error(),
            heading_error: wrap(at.vehicle.yaw - published_yaw),
            rear_cross_track_error: rear.closest.cross_track_error(),
            rear_heading_error: wrap(rear.vehicle.yaw - rear.closest.path_yaw()),
            target,
            status,
        }
    }

    /// Follows the axle that leads: how far the vehicle has come, and whether the run is over.
    fn look_ahead(&mut self) {
        let at = self.locate(&self.leading, self.run.leading);
        let rear = self.locate(&self.rear, self.run.rear);
        let (path, run) = (self.path.view(), &mut self.run);
        run.leading = Some(at.closest.segment);
        run.rear = Some(rear.closest.segment);
        run.reverse = rear.reverse;
        let length = path.length();
        let arc = at.closest.arc_length(&path);
        let mut moved = arc - run.leading_arc;
        if path.is_closed() {
            // The short way round: a step across the seam is not a lap back.
            moved -= length * (moved / length).round();
        }
        run.leading_arc = arc;
        run.travelled += moved;
        let done = if path.is_closed() { run.travelled } else { arc };
        run.finished |= length - done <= self.settings.stop_distance;
        run.lost |= get_distance(at.position, at.closest.point) > self.settings.give_up_distance;
    }
}

/// All that a simulation remembers beside its path, its plant and its settings.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RunState {
    pub(crate) plant: PlantState,
    /// The segments that points of the vehicle were last projected to; None before.
    pub(crate) reference: Option<usize>,
    pub(crate) rear: Option<usize>,
    pub(crate) leading: Option<usize>,
    /// Whether the path is driven backwards where the rear axle is.
    pub(crate) reverse: bool,
    pub(crate) leading_arc: f64,
    pub(crate) delay: Delay,
    pub(crate) travelled: f64,
    pub(crate) steps: usize,
    pub(crate) finished: bool,
    pub(crate) lost: bool,
    pub(crate) gatherer: Gatherer,
    pub(crate) records: Vec<Record>,
}

/// The same without a search of the whole path: a simulated point does not jump.
fn unlost(follow: Follow) -> Follow {
    Follow {
        lost_distance: f64::INFINITY,
        ..follow
    }
}

/// What a simulation is refused for.
#[derive(Clone, Debug, PartialEq)]
pub enum SimulationError {
    /// A setting.
    Config(ConfigError),
    /// The start.
    Input(InputError),
    /// The path is driven backwards in places, and the plant does not reverse.
    NoReverse {
        /// Its name.
        plant: String,
    },
}

impl From<ConfigError> for SimulationError {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

impl From<InputError> for SimulationError {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl std::fmt::Display for SimulationError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Config(error) => error.fmt(f),
            Self::Input(error) => error.fmt(f),
            Self::NoReverse { plant } => {
                write!(
                    f,
                    "the path is driven backwards in places, and {plant} does not reverse"
                )
            }
        }
    }
}

impl std::error::Error for SimulationError {}
