//! One vehicle of a batch: its step, and its state as the batch keeps it.

use std::sync::Arc;

use popsteer_core::tracker::{Answer, Model, Reported, TrackerState, Tracking};
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
    /// passes; the others go on. A bad `dt` is an error.
    Mark,
    /// The last command of its vehicle, as [`Tracker::step_or_hold`] with this limit; the others
    /// go on. A bad `dt` holds all of them.
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
    model: Option<Box<Model>>,
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
        TrackerState {
            tracking: self.tracking.clone(),
            model: self.model.as_deref().copied().unwrap_or_default(),
        }
    }

    pub(super) fn set_state(&mut self, state: TrackerState<L::State>) {
        self.tracking = state.tracking;
        self.model = boxed(&state.model);
    }

    /// One step; `empty` is a model of nothing, which it is afterwards, too.
    #[inline]
    fn advance(
        &mut self,
        empty: &mut Model,
        input: VehicleState,
        dt: f64,
        reported: Reported,
    ) -> Result<Status, InputError> {
        let model = self.model.as_deref_mut();
        let is_short = model.is_none();
        let (state, model) = (&mut self.tracking, model.unwrap_or(&mut *empty));
        let view = self.path.view();
        let outcome = self
            .tracker
            .advance(&view, state, model, input, dt, reported);
        if is_short && !empty.is_empty() {
            self.model = boxed(&core::mem::take(empty));
        }
        outcome
    }

    /// The command of a step. That of a refused input has no numbers, and the direction of the last
    /// one.
    #[inline]
    pub(super) fn step(
        &mut self,
        empty: &mut Model,
        input: VehicleState,
        dt: f64,
        on_error: OnError,
        reported: Reported,
    ) -> Command {
        match (self.advance(empty, input, dt, reported), on_error) {
            (Ok(status), _) => self.tracking.command(status),
            (Err(_), OnError::Hold(limit)) => self.tracking.hold(dt, limit),
            (Err(_), _) => {
                self.tracking.miss(dt);
                marked(self.tracking.answer)
            }
        }
    }

    /// The angle of [`step`](Self::step).
    #[inline]
    pub(super) fn steer(
        &mut self,
        empty: &mut Model,
        input: VehicleState,
        dt: f64,
        on_error: OnError,
        reported: Reported,
    ) -> f64 {
        match (self.advance(empty, input, dt, reported), on_error) {
            (Ok(_), _) => self.tracking.steer,
            (Err(_), OnError::Hold(limit)) => self.tracking.hold(dt, limit).steer,
            (Err(_), _) => {
                self.tracking.miss(dt);
                f64::NAN
            }
        }
    }
}

/// A model of its own, for a vehicle that has one, or a state that brought estimates along.
#[cold]
fn boxed(model: &Model) -> Option<Box<Model>> {
    (*model != Model::default()).then(|| Box::new(*model))
}

/// The command of a refused input after this answer.
fn marked(last: Option<Answer>) -> Command {
    Command {
        reverse: last.is_some_and(|answer| answer.reverse),
        status: Status::INPUT_HELD,
        ..Command::NONE
    }
}
