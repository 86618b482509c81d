//! One vehicle of a batch: its step, and its state as the batch keeps it.

use std::sync::Arc;

use popsteer_core::tracker::{Answer, Model, Reported, TrackerState, Tracking};
use popsteer_core::vehicle::{Estimator, InFlight, Past};
use popsteer_core::{Command, InputError, LateralLaw, Path, Status, Tracker, VehicleState};

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

/// What an input that is refused leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnError {
    /// An error; no vehicle has moved then.
    Raise,
    /// No angle, and no numbers, for its vehicle, which keeps its state but for the time that
    /// passes; the others go on. A `dt` that is not finite is an error.
    Mark,
    /// The last command of its vehicle, as [`Tracker::step_or_hold`] with this limit; the others
    /// go on. A `dt` that is not finite holds all of them.
    Hold(usize),
}

/// A member as a batch keeps it: 10,000,000 of them are to fit the memory.
#[derive(Clone, Debug)]
pub(super) struct Kept<L: LateralLaw> {
    /// Shared by copies: their memory is what a large batch waits for.
    pub(super) tracker: Arc<Tracker<L>>,
    pub(super) path: Arc<Path>,
    pub(super) tracking: Tracking<L::State>,
    /// None where nothing is modelled.
    pub(super) model: Option<Box<Packed>>,
}

/// For how many more angles than there are is made room.
const SPARE: usize = 8;

/// A [`Model`] without the room for what is not in flight, which is most of it.
#[derive(Clone, Debug)]
pub(super) struct Packed {
    /// As the model's.
    estimator: Estimator,
    /// How many of `timed` are commands in flight, and the wheels' angle; None if there are none.
    in_flight: Option<(usize, f64)>,
    /// Of the past the angle now and the time since a pose; None if there is none.
    past: Option<(f64, f64)>,
    /// The commands in flight, then the past angles, oldest first.
    pub(super) timed: Vec<(f64, f64)>,
}

impl Packed {
    fn of(model: &Model) -> Self {
        let mut packed = Self {
            estimator: model.estimator,
            in_flight: None,
            past: None,
            timed: Vec::new(),
        };
        packed.pack(model);
        packed
    }

    /// Becomes a model.
    #[inline]
    fn pack(&mut self, model: &Model) {
        let commands = model.in_flight.iter().flat_map(InFlight::commands);
        let angles = model.past.iter().flat_map(Past::angles);
        self.timed.clear();
        let count = model.in_flight.as_ref().map(|in_flight| {
            self.fill(commands);
            (self.timed.len(), in_flight.wheel())
        });
        self.in_flight = count;
        self.fill(angles);
        self.past = model.past.as_ref().map(|past| (past.wheel(), past.since()));
        self.estimator = model.estimator;
    }

    /// Takes in more, with little room to spare: there may be 100,000 vehicles.
    #[inline]
    fn fill(&mut self, timed: impl Iterator<Item = (f64, f64)>) {
        for each in timed {
            if self.timed.len() == self.timed.capacity() {
                self.timed.reserve_exact(SPARE);
            }
            self.timed.push(each);
        }
    }

    /// Puts it into a model, whatever that was.
    #[inline]
    fn unpack(&self, model: &mut Model) {
        let commands = self.in_flight.map_or(0, |(count, _)| count);
        let (commands, angles) = self.timed.split_at(commands.min(self.timed.len()));
        match self.in_flight {
            Some((_, wheel)) => model
                .in_flight
                .get_or_insert_with(InFlight::empty)
                .refill(commands, wheel),
            None => model.in_flight = None,
        }
        match self.past {
            Some((wheel, since)) => model
                .past
                .get_or_insert_with(|| Past::settled(0.0))
                .refill(angles, wheel, since),
            None => model.past = None,
        }
        model.estimator = self.estimator;
    }
}

/// Models for the steps of a thread.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Of nothing, before a step and after it.
    empty: Model,
    /// Of the vehicle that steps, where it has one.
    full: Model,
}

impl<L: LateralLaw> Kept<L> {
    pub(super) fn new(member: Member<L>) -> Self {
        Self {
            tracker: Arc::new(member.tracker),
            path: member.path,
            model: boxed(&member.state.model),
            tracking: member.state.tracking,
        }
    }

    pub(super) fn state(&self) -> TrackerState<L::State> {
        let mut model = Model::default();
        if let Some(packed) = &self.model {
            packed.unpack(&mut model);
        }
        TrackerState {
            tracking: self.tracking.clone(),
            model,
        }
    }

    pub(super) fn set_state(&mut self, state: TrackerState<L::State>) {
        self.tracking = state.tracking;
        self.model = boxed(&state.model);
    }

    /// One step.
    #[inline]
    fn advance(
        &mut self,
        scratch: &mut Scratch,
        input: VehicleState,
        dt: f64,
        reported: Reported,
    ) -> Result<Status, InputError> {
        let Scratch { empty, full } = scratch;
        let (view, state) = (self.path.view(), &mut self.tracking);
        let Some(packed) = &mut self.model else {
            let outcome = self
                .tracker
                .advance(&view, state, empty, input, dt, reported);
            if !empty.is_empty() {
                self.model = boxed(&std::mem::take(empty));
            }
            return outcome;
        };
        packed.unpack(full);
        let outcome = self
            .tracker
            .advance(&view, state, full, input, dt, reported);
        packed.pack(full);
        outcome
    }

    /// The command of a step. That of a refused input has no numbers, and the direction of the last
    /// one.
    #[inline]
    pub(super) fn step(
        &mut self,
        scratch: &mut Scratch,
        input: VehicleState,
        dt: f64,
        on_error: OnError,
        reported: Reported,
    ) -> Command {
        match (self.advance(scratch, input, dt, reported), on_error) {
            (outcome, OnError::Hold(limit)) => self.tracking.or_hold(outcome, dt, limit),
            (Ok(status), _) => self.tracking.command(status),
            (Err(_), _) => {
                self.tracking.hold(dt);
                marked(self.tracking.answer)
            }
        }
    }

    /// The angle of [`step`](Self::step).
    #[inline]
    pub(super) fn steer(
        &mut self,
        scratch: &mut Scratch,
        input: VehicleState,
        dt: f64,
        on_error: OnError,
        reported: Reported,
    ) -> f64 {
        let outcome = self.advance(scratch, input, dt, reported);
        if outcome.is_ok() {
            return self.tracking.steer;
        }
        self.tracking.hold(dt);
        match on_error {
            OnError::Hold(_) => self.tracking.steer,
            _ => f64::NAN,
        }
    }
}

/// A model of its own, for a vehicle that has one, or a state that brought estimates along.
#[cold]
fn boxed(model: &Model) -> Option<Box<Packed>> {
    (*model != Model::default()).then(|| Box::new(Packed::of(model)))
}

/// The command of a refused input after this answer.
fn marked(last: Option<Answer>) -> Command {
    Command {
        reverse: last.is_some_and(|answer| answer.reverse),
        status: Status::INPUT_HELD,
        ..Command::NONE
    }
}
