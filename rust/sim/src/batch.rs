//! Many vehicles, one step at a time, on all cores.

use std::sync::Arc;

use popsteer_core::lateral::{Answer, Handover, Place, Reported, TrackerState};
use popsteer_core::vehicle::Estimator;
use popsteer_core::vehicle::state::checked_dt;
use popsteer_core::{Command, InputError, LateralLaw, Path, Point, Status, Tracker, VehicleState};
use rayon::prelude::*;

/// Vehicles a thread takes at a time: enough to outweigh handing them over. A batch of no more is
/// stepped on the thread that asks for it.
pub const CHUNK: usize = 256;

/// Vehicles under controllers of one kind, each with vehicle, parameters, path and state of its
/// own.
#[derive(Clone, Debug)]
pub struct Batch<L: LateralLaw> {
    members: Vec<Kept<L>>,
}

/// One vehicle of a batch: who steers it, along which path, and what is remembered of it.
#[derive(Clone, Debug)]
pub struct Member<L: LateralLaw> {
    /// Who steers.
    pub tracker: Tracker<L>,
    /// Along which path.
    pub path: Arc<Path>,
    /// What is remembered; a state that [`Tracker::check_state`] accepts.
    pub state: TrackerState<L::State>,
}

/// A member as a batch keeps it: 10,000,000 of them are to fit the memory.
#[derive(Clone, Debug)]
struct Kept<L: LateralLaw> {
    tracker: Tracker<L>,
    path: Arc<Path>,
    state: KeptState<L::State>,
}

/// A state, without the 5 kB for commands in flight and the past where there is neither.
#[expect(
    clippy::large_enum_variant,
    reason = "most are short, and there are many"
)]
#[derive(Clone, Debug)]
enum KeptState<S> {
    Whole(Box<TrackerState<S>>),
    Short(Short<S>),
}

/// A state without commands in flight and without a past.
#[derive(Clone, Debug)]
struct Short<S> {
    law: S,
    waypoint: Option<usize>,
    measured_waypoint: Option<usize>,
    place: Option<Place>,
    steer: f64,
    handover: Option<Handover>,
    held: usize,
    held_time: f64,
    period: f64,
    answer: Option<Answer>,
    estimator: Estimator,
}

/// A larger state of a law costs more to be moved at each step than it saves [bytes].
const SHORT: usize = 256;

impl<S: Clone> KeptState<S> {
    fn new(state: TrackerState<S>) -> Self {
        if state.in_flight.is_some() || state.past.is_some() || size_of::<S>() > SHORT {
            Self::Whole(Box::new(state))
        } else {
            Self::Short(Short::of(&state))
        }
    }

    /// What `change` comes to with the state.
    #[inline]
    fn with<T>(&mut self, change: impl FnOnce(&mut TrackerState<S>) -> T) -> T {
        match self {
            Self::Whole(state) => change(state),
            Self::Short(short) => {
                let mut state = short.whole();
                let answer = change(&mut state);
                if state.past.is_some() {
                    *self = Self::Whole(Box::new(state));
                } else {
                    *short = Short::of(&state);
                }
                answer
            }
        }
    }

    fn whole(&self) -> TrackerState<S> {
        match self {
            Self::Whole(state) => TrackerState::clone(state),
            Self::Short(short) => short.whole(),
        }
    }
}

impl<S: Clone> Short<S> {
    #[inline]
    fn of(state: &TrackerState<S>) -> Self {
        Self {
            law: state.law.clone(),
            waypoint: state.waypoint,
            measured_waypoint: state.measured_waypoint,
            place: state.place,
            steer: state.steer,
            handover: state.handover,
            held: state.held,
            held_time: state.held_time,
            period: state.period,
            answer: state.answer,
            estimator: state.estimator,
        }
    }

    #[inline]
    fn whole(&self) -> TrackerState<S> {
        TrackerState {
            law: self.law.clone(),
            waypoint: self.waypoint,
            measured_waypoint: self.measured_waypoint,
            place: self.place,
            steer: self.steer,
            handover: self.handover,
            held: self.held,
            held_time: self.held_time,
            period: self.period,
            answer: self.answer,
            in_flight: None,
            past: None,
            estimator: self.estimator,
        }
    }
}

/// What an input that is refused leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnError {
    /// An error; no vehicle has moved then.
    Raise,
    /// No angle, and no numbers, for its vehicle, which keeps its state but for the time that
    /// passes; the others go on. A bad `dt` is an error.
    Mark,
    /// The last command of its vehicle, as [`Tracker::step_or_hold`] with this limit; the others
    /// go on. A bad `dt` holds all of them.
    Hold(usize),
}

/// A vehicle whose input is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchError {
    /// Its place in the batch; none where `dt` is refused.
    pub vehicle: Option<usize>,
    /// Why.
    pub error: InputError,
}

impl<L: LateralLaw> Kept<L> {
    fn new(member: Member<L>) -> Self {
        let Member {
            tracker,
            path,
            state,
        } = member;
        let state = KeptState::new(state);
        Self {
            tracker,
            path,
            state,
        }
    }

    /// One step. The command of a refused input has no numbers, and the direction of the last one.
    fn step(
        &mut self,
        input: VehicleState,
        dt: f64,
        on_error: OnError,
        reported: Reported,
    ) -> Command {
        let (tracker, path) = (&self.tracker, self.path.view());
        if let OnError::Hold(limit) = on_error {
            return self.state.with(|state| {
                tracker.step_or_hold_reported(&path, state, input, dt, limit, reported)
            });
        }
        self.state.with(|state| {
            let answer = tracker.step_reported(&path, state, input, dt, reported);
            answer.unwrap_or_else(|_| {
                state.miss(dt);
                marked(state.answer)
            })
        })
    }

    /// The angle of [`step`](Self::step).
    fn steer(
        &mut self,
        input: VehicleState,
        dt: f64,
        on_error: OnError,
        reported: Reported,
    ) -> f64 {
        if matches!(on_error, OnError::Hold(_)) {
            return self.step(input, dt, on_error, reported).steer;
        }
        let (tracker, path) = (&self.tracker, self.path.view());
        self.state.with(|state| {
            let answer = tracker.steer_reported(&path, state, input, dt, reported);
            answer.unwrap_or_else(|_| {
                state.miss(dt);
                f64::NAN
            })
        })
    }
}

/// The command of a refused input after this answer.
fn marked(last: Option<Answer>) -> Command {
    let nan = f64::NAN;
    Command {
        steer: nan,
        cross_track_error: nan,
        heading_error: nan,
        predicted_cross_track_error: nan,
        predicted_heading_error: nan,
        target: Point::new(nan, nan),
        reverse: last.is_some_and(|answer| answer.reverse),
        reference_speed: None,
        distance_to_stop: nan,
        status: Status::INPUT_HELD,
    }
}
impl<L> Batch<L>
where
    L: LateralLaw + Clone + Send + Sync,
    L::State: Send + Sync,
{
    /// One vehicle for each of these.
    pub fn new(members: impl IntoIterator<Item = Member<L>>) -> Self {
        Self {
            members: members.into_iter().map(Kept::new).collect(),
        }
    }

    /// Takes in so many more vehicles that are like `member`.
    pub fn add(&mut self, member: Member<L>, count: usize) {
        let kept = Kept::new(member);
        self.members.extend(std::iter::repeat_n(kept, count));
    }

    /// How many vehicles.
    pub fn len(&self) -> usize {
        self.members.len()
    }

    /// Whether there is no vehicle.
    pub fn is_empty(&self) -> bool {
        self.members.is_empty()
    }

    /// The vehicles, in order, as they are now.
    pub fn members(&self) -> impl ExactSizeIterator<Item = Member<L>> {
        self.members.iter().map(|member| Member {
            tracker: member.tracker.clone(),
            path: Arc::clone(&member.path),
            state: member.state.whole(),
        })
    }

    /// Takes every vehicle back to its initial state.
    pub fn reset(&mut self) {
        for member in &mut self.members {
            member.state = KeptState::new(member.tracker.initial_state());
        }
    }

    /// Has a vehicle follow another path from its next step on, as [`Tracker::set_path`]. A place
    /// beyond the batch changes nothing.
    pub fn set_path(&mut self, vehicle: usize, path: Arc<Path>) {
        if let Some(member) = self.members.get_mut(vehicle) {
            let (tracker, old) = (&member.tracker, member.path.view());
            member
                .state
                .with(|state| tracker.set_path(state, &old, &path.view()));
            member.path = path;
        }
    }

    /// The states, in order.
    pub fn states(&self) -> impl ExactSizeIterator<Item = TrackerState<L::State>> {
        self.members.iter().map(|member| member.state.whole())
    }

    /// Puts the states, in order; each is one that [`Tracker::check_state`] accepts.
    pub fn set_states(&mut self, states: impl IntoIterator<Item = TrackerState<L::State>>) {
        for (member, state) in self.members.iter_mut().zip(states) {
            member.state = KeptState::new(state);
        }
    }

    /// Steps every vehicle, which report what is `reported`, nothing where that is empty: `write` is
    /// given each place in `out`, and the command for it, that of [`Tracker::step_reported`]. Where an input is refused under [`OnError::Mark`] the command has no
    /// numbers, the direction of the last one, and [`Status::INPUT_HELD`].
    ///
    /// # Errors
    ///
    /// [`BatchError`] for a bad `dt`, and for the first vehicle whose input is refused, as
    /// `on_error` says.
    ///
    /// # Panics
    ///
    /// Where `inputs`, `out` or `reported`, unless it is empty, is not as long as the batch.
    pub fn step<T: Send>(
        &mut self,
        inputs: &[VehicleState],
        dt: f64,
        on_error: OnError,
        reported: &[Reported],
        out: &mut [T],
        write: impl Fn(&mut T, Command) + Sync,
    ) -> Result<(), BatchError> {
        let one = |member: &mut Kept<L>, input, reported, place: &mut T| {
            write(place, member.step(input, dt, on_error, reported));
        };
        self.drive(inputs, dt, on_error, reported, out, one)
    }

    /// Steps every vehicle for the angle alone, as [`step`](Self::step).
    ///
    /// # Errors
    ///
    /// As [`step`](Self::step).
    ///
    /// # Panics
    ///
    /// As [`step`](Self::step).
    pub fn steer(
        &mut self,
        inputs: &[VehicleState],
        dt: f64,
        on_error: OnError,
        reported: &[Reported],
        out: &mut [f64],
    ) -> Result<(), BatchError> {
        let one = |member: &mut Kept<L>, input, reported, angle: &mut f64| {
            *angle = member.steer(input, dt, on_error, reported);
        };
        self.drive(inputs, dt, on_error, reported, out, one)
    }

    fn drive<T: Send>(
        &mut self,
        inputs: &[VehicleState],
        dt: f64,
        on_error: OnError,
        reported: &[Reported],
        out: &mut [T],
        one: impl Fn(&mut Kept<L>, VehicleState, Reported, &mut T) + Sync,
    ) -> Result<(), BatchError> {
        let reported_of = |vehicle: usize| reported.get(vehicle).copied().unwrap_or_default();
        let given = reported.is_empty() || reported.len() == self.len();
        assert!(given, "one report for each vehicle, or none");
        assert_eq!(inputs.len(), self.len(), "one input for each vehicle");
        assert_eq!(out.len(), self.len(), "one place for each vehicle");
        if !matches!(on_error, OnError::Hold(_)) {
            checked_dt(dt).map_err(|error| BatchError {
                vehicle: None,
                error,
            })?;
        }
        if on_error == OnError::Raise {
            let refused = inputs.iter().enumerate().find_map(|(vehicle, input)| {
                let car = self.members.get(vehicle)?.tracker.vehicle();
                let reported = || reported_of(vehicle).checked(car).err();
                let error = input.checked().err().or_else(reported)?;
                Some(BatchError {
                    vehicle: Some(vehicle),
                    error,
                })
            });
            refused.map_or(Ok(()), Err)?;
        }
        if self.len() <= CHUNK {
            let members = self.members.iter_mut().zip(inputs).zip(out);
            for (vehicle, ((member, &input), place)) in members.enumerate() {
                one(member, input, reported_of(vehicle), place);
            }
            return Ok(());
        }
        self.members
            .par_iter_mut()
            .zip(inputs.par_iter())
            .zip(out.par_iter_mut())
            .enumerate()
            .with_min_len(CHUNK)
            .for_each(|(vehicle, ((member, &input), place))| {
                one(member, input, reported_of(vehicle), place);
            });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use popsteer_core::Vehicle;
    use popsteer_core::lateral::{Pop, PopParams};

    fn batch(count: usize) -> (Batch<Pop>, Tracker<Pop>, Arc<Path>) {
        let x: Vec<f64> = (0..300).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| 5.0 * (x / 20.0).sin()).collect();
        let path = Path::new(&x, &y, None, false).unwrap();
        let reverse: Vec<bool> = (0..300).map(|k| k > 200).collect();
        let path = Arc::new(path.with_reverse(&reverse).unwrap());
        let tracker = Tracker::of(Pop::new(Vehicle::DEFAULT, PopParams::default()).unwrap());
        let member = || Member {
            tracker,
            path: Arc::clone(&path),
            state: tracker.initial_state(),
        };
        let batch = Batch::new(std::iter::repeat_with(member).take(count));
        (batch, tracker, path)
    }

    fn inputs(count: u32) -> Vec<VehicleState> {
        let vehicle = |k| VehicleState {
            x: f64::from(k % 250),
            y: f64::from(k % 7) - 3.0,
            yaw: 0.01 * f64::from(k % 40),
            speed: f64::from(k % 20),
        };
        (0..count).map(vehicle).collect()
    }

    #[test]
    fn test_batch_steps_are_single_steps_bit_for_bit() {
        let (mut batch, tracker, path) = batch(600);
        let inputs = inputs(600);
        let mut angles = vec![0.0; 600];
        let mut states: Vec<_> = (0..600).map(|_| tracker.initial_state()).collect();
        for _ in 0..5 {
            batch
                .steer(&inputs, 0.05, OnError::Raise, &[], &mut angles)
                .unwrap();
            for ((state, &input), angle) in states.iter_mut().zip(&inputs).zip(&angles) {
                let single = tracker.steer(&path.view(), state, input, 0.05).unwrap();
                assert_eq!(single.to_bits(), angle.to_bits());
            }
        }
        assert!(batch.states().eq(states));
    }

    #[test]
    fn test_batch_keeps_little_of_a_vehicle_that_is_not_modelled() {
        assert!(size_of::<Kept<Pop>>() < 1024, "{}", size_of::<Kept<Pop>>());
        let (mut batch, tracker, path) = batch(2);
        let late = Vehicle {
            dead_time: 0.1,
            ..Vehicle::DEFAULT
        };
        let late = Tracker::of(Pop::new(late, PopParams::default()).unwrap());
        let member = |tracker: Tracker<Pop>| Member {
            tracker,
            path: Arc::clone(&path),
            state: tracker.initial_state(),
        };
        let mut mixed = Batch::new([member(tracker), member(late)]);
        let (mut angles, mut others) = ([0.0_f64; 2], [0.0_f64; 2]);
        let step = |batch: &mut Batch<Pop>, angles: &mut [f64]| {
            batch
                .steer(&inputs(2), 0.05, OnError::Raise, &[], angles)
                .unwrap();
        };
        step(&mut mixed, &mut angles);
        step(&mut batch, &mut others);
        assert_eq!(angles[0].to_bits(), others[0].to_bits());
        let states: Vec<_> = mixed.states().collect();
        assert!(states[0].in_flight.is_none() && states[1].in_flight.is_some());
        step(&mut mixed, &mut angles);
        mixed.set_states(states.clone());
        assert!(mixed.states().eq(states.clone()));
        mixed.reset();
        assert!(!mixed.states().eq(states));
    }

    #[test]
    fn test_batch_one_bad_vehicle_refuses_all_or_is_marked() {
        let (mut batch, ..) = batch(5);
        let mut inputs = inputs(5);
        inputs[3].speed = f64::NAN;
        let mut angles = vec![0.0; 5];
        let before: Vec<_> = batch.states().collect();
        let refused = batch
            .steer(&inputs, 0.05, OnError::Raise, &[], &mut angles)
            .unwrap_err();
        assert_eq!((refused.vehicle, refused.error.field), (Some(3), "speed"));
        assert!(batch.states().eq(before));
        batch
            .steer(&inputs, 0.05, OnError::Mark, &[], &mut angles)
            .unwrap();
        let nan: Vec<bool> = angles.iter().map(|angle| angle.is_nan()).collect();
        assert_eq!(nan, [false, false, false, true, false]);
        let bad_dt = batch.steer(&inputs, -1.0, OnError::Mark, &[], &mut angles);
        assert!(bad_dt.is_err());
    }

    #[test]
    fn test_batch_refused_vehicle_keeps_its_direction_or_all_of_its_command() {
        let (mut batch, ..) = batch(2);
        let good = VehicleState {
            x: 230.0,
            y: -4.0,
            yaw: std::f64::consts::PI,
            speed: -3.0,
        };
        let bad = VehicleState {
            x: f64::NAN,
            ..good
        };
        let mut step = |input, on_error| {
            let mut out = [None; 2];
            let write = |place: &mut Option<Command>, command| *place = Some(command);
            batch
                .step(&[good, input], 0.05, on_error, &[], &mut out, write)
                .unwrap();
            out.map(Option::unwrap)
        };
        let [_, last] = step(good, OnError::Raise);
        assert!(last.reverse && last.status != Status::INPUT_HELD);
        let [other, marked] = step(bad, OnError::Mark);
        assert!(marked.steer.is_nan() && marked.reverse && !other.steer.is_nan());
        assert_eq!(marked.status, Status::INPUT_HELD);
        for status in [Status::INPUT_HELD, Status::INPUT_LOST] {
            let [_, held] = step(bad, OnError::Hold(1));
            assert_eq!(held, Command { status, ..last });
        }
    }
}
