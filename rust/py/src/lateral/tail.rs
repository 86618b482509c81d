//! What the states of all controllers have in common, converted between Python and the core.

use popsteer_core::path::Ahead;
use popsteer_core::tracker::{
    Answer, Deviation, Handover, MonitorState, Place, Tracker, TrackerState,
};
use popsteer_core::vehicle::{Estimator, InFlight, Past, VehicleState};
use popsteer_core::{InputError, LateralLaw, Point};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::params::{Count, Field};

/// Four numbers: x, y [m], yaw [rad] and speed [m/s], or two points [m].
pub(super) type Motion = (f64, f64, f64, f64);
/// Cross-track error [m], yaw [rad], and along the path (x, y) [m].
type Deviations = (f64, f64, f64, f64);
/// The measured and the predicted vehicle, the target [m], whether it drove backwards, reference
/// speed [m/s] and distance to stop [m], and where the vehicle was.
pub(super) type Answered = (
    Deviations,
    Deviations,
    (f64, f64),
    bool,
    (Option<f64>, f64),
    Motion,
);

/// Of the wheels, the yaw and its residual [rad].
type LastStep = (f64, Option<f64>, Option<f64>);
/// Turns measured, expected, and of a slower response [rad], its rate [rad/s], the turns of a
/// radian of steering offset, and the excess of large angles [rad].
type Turns = (f64, f64, f64, f64, f64, f64);
/// Time [s] and variance [rad^2] of the noise, and the sums of the offset [1/s], [rad/s].
type Evidence = (f64, f64, f64, f64);
/// What the monitor remembers, how long its alarm lasts [s], and whether the deviation was within
/// its limit.
pub(super) type MonitorMemory = (LastStep, Turns, Evidence, f64, bool);

/// What all states remember beside the controller's own.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tail {
    pub(super) waypoint: Option<Count>,
    pub(super) measured_waypoint: Option<Count>,
    pub(super) place: Option<Motion>,
    pub(super) steer: f64,
    pub(super) handover_offset: Option<f64>,
    pub(super) handover_remaining: f64,
    pub(super) held: Count,
    pub(super) held_time: f64,
    pub(super) period: f64,
    pub(super) wheel: Option<f64>,
    pub(super) commands_in_flight: Row<(f64, f64)>,
    pub(super) past_angles: Row<(f64, f64)>,
    pub(super) past_wheel: Option<f64>,
    pub(super) past_since: f64,
    /// State of the no-slip point when last measured; kept here and not in `estimator`.
    pub(super) last_measured: Option<Motion>,
    pub(super) estimator: Estimator,
    pub(super) answer: Option<Answered>,
    pub(super) monitor: Option<MonitorMemory>,
}

fn from_vehicle(vehicle: VehicleState) -> Motion {
    (vehicle.x, vehicle.y, vehicle.yaw, vehicle.speed)
}

fn to_vehicle((x, y, yaw, speed): Motion) -> VehicleState {
    VehicleState { x, y, yaw, speed }
}

fn from_deviation(deviation: Deviation) -> Deviations {
    let along = deviation.along;
    (deviation.cross_track_error, deviation.yaw, along.x, along.y)
}

fn to_deviation((cross_track_error, yaw, x, y): Deviations) -> Deviation {
    Deviation {
        cross_track_error,
        yaw,
        along: Point::new(x, y),
    }
}

fn from_answer(answer: Answer) -> Answered {
    (
        from_deviation(answer.measured),
        from_deviation(answer.predicted),
        answer.target.argument(),
        answer.reverse,
        (answer.ahead.reference_speed, answer.ahead.distance_to_stop),
        from_vehicle(answer.vehicle),
    )
}

fn to_answer((measured, predicted, target, reverse, ahead, vehicle): Answered) -> Answer {
    let (reference_speed, distance_to_stop) = ahead;
    Answer {
        measured: to_deviation(measured),
        predicted: to_deviation(predicted),
        target: Field::from_argument(target),
        reverse,
        ahead: Ahead {
            reference_speed,
            distance_to_stop,
        },
        vehicle: to_vehicle(vehicle),
    }
}

fn from_monitor(state: MonitorState) -> MonitorMemory {
    (
        (state.wheel, state.yaw, state.residual),
        (
            state.measured,
            state.expected,
            state.delayed,
            state.rate,
            state.reach,
            state.excess,
        ),
        (
            state.time,
            state.noise,
            state.offset_square,
            state.offset_sum,
        ),
        state.alarm,
        state.within,
    )
}

fn to_monitor((last_step, turns, evidence, alarm, within): MonitorMemory) -> MonitorState {
    let (wheel, yaw, residual) = last_step;
    let (measured, expected, delayed, rate, reach, excess) = turns;
    let (time, noise, offset_square, offset_sum) = evidence;
    MonitorState {
        wheel,
        yaw,
        residual,
        measured,
        expected,
        delayed,
        rate,
        reach,
        excess,
        time,
        noise,
        offset_square,
        offset_sum,
        alarm,
        within,
    }
}

impl Tail {
    pub(super) fn of<S>(state: &TrackerState<S>) -> Self {
        let (in_flight, past) = (state.in_flight.as_ref(), state.past.as_ref());
        Self {
            waypoint: state.waypoint.argument(),
            measured_waypoint: state.measured_waypoint.argument(),
            place: state.place.map(
                |Place {
                     predicted,
                     measured,
                 }| { (predicted.x, predicted.y, measured.x, measured.y) },
            ),
            steer: state.steer,
            handover_offset: state.handover.and_then(|handover| handover.offset),
            handover_remaining: state.handover.map_or(0.0, |handover| handover.remaining),
            held: state.held.argument(),
            held_time: state.held_time,
            period: state.period,
            wheel: in_flight.map(InFlight::wheel),
            commands_in_flight: Row(
                in_flight.map_or_else(Vec::new, |line| line.commands().collect())
            ),
            past_angles: Row(past.map_or_else(Vec::new, |past| past.angles().collect())),
            past_wheel: past.map(Past::wheel),
            past_since: past.map_or(0.0, Past::since),
            last_measured: state.estimator.last_measured.map(from_vehicle),
            estimator: Estimator {
                last_measured: None,
                ..state.estimator
            },
            answer: state.answer.map(from_answer),
            monitor: state.monitor.map(from_monitor),
        }
    }

    pub(super) fn restore<L: LateralLaw>(
        self,
        law: L::State,
        tracker: &Tracker<L>,
    ) -> Result<TrackerState<L::State>, InputError> {
        let vehicle = tracker.vehicle();
        let models = tracker.initial_state().in_flight.is_some();
        let in_flight = match self.wheel {
            _ if !models => None,
            // Of a state that knows nothing of the wheels they are at rest under the last command.
            None => Some(InFlight::settled(vehicle, self.steer)),
            Some(wheel) => {
                let longer = self.estimator.estimate.longer_dead_time;
                let commands = self.commands_in_flight.0.into_iter();
                Some(InFlight::restore(vehicle, commands, wheel, longer)?)
            }
        };
        let past = match self.past_wheel {
            None => None,
            Some(wheel) => {
                let angles = self.past_angles.0.into_iter();
                Some(Past::restore(angles, wheel, self.past_since)?)
            }
        };
        let handover = Handover {
            offset: self.handover_offset,
            remaining: self.handover_remaining,
        };
        // -0.0 too: none is left.
        let none =
            handover.offset.is_none() && handover.remaining <= 0.0 && handover.remaining >= 0.0;
        Ok(TrackerState {
            law,
            waypoint: Field::from_argument(self.waypoint),
            measured_waypoint: Field::from_argument(self.measured_waypoint),
            place: self.place.map(|(x, y, measured_x, measured_y)| Place {
                predicted: Point::new(x, y),
                measured: Point::new(measured_x, measured_y),
            }),
            steer: self.steer,
            handover: (!none).then_some(handover),
            held: self.held.saturated(),
            held_time: self.held_time,
            period: self.period,
            answer: self.answer.map(to_answer),
            in_flight,
            past,
            estimator: Estimator {
                last_measured: self.last_measured.map(to_vehicle),
                ..self.estimator
            },
            monitor: self.monitor.map(to_monitor),
        })
    }
}

/// Entries that Python sees as a tuple.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Row<T>(pub(super) Vec<T>);

impl<'py, T: FromPyObjectOwned<'py>> FromPyObject<'_, 'py> for Row<T> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        object.extract().map(Self)
    }
}

impl<'py, T: IntoPyObject<'py>> IntoPyObject<'py> for Row<T> {
    type Target = PyTuple;
    type Output = Bound<'py, PyTuple>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        PyTuple::new(py, self.0)
    }
}
