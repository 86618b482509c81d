//! One vehicle of a batch: its step, and its state as the batch keeps it.

use std::sync::Arc;

use popsteer_core::tracker::{Answer, Reported, ShortState, TrackerState};
use popsteer_core::{Command, LateralLaw, Path, Point, Status, Tracker, VehicleState};

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
    pub(super) state: KeptState<L::State>,
}

impl<L: LateralLaw> Kept<L> {
    pub(super) fn new(member: Member<L>) -> Self {
        let Member {
            tracker,
            path,
            state,
        } = member;
        Self {
            tracker: Arc::new(tracker),
            path,
            state: KeptState::new(state),
        }
    }

    /// A state to unpack others into.
    pub(super) fn room(&self) -> TrackerState<L::State> {
        self.tracker.initial_state()
    }

    /// One step, with the state unpacked into `room`. The command of a refused input has no numbers, and the direction of the last one.
    pub(super) fn step(
        &mut self,
        room: &mut TrackerState<L::State>,
        input: VehicleState,
        dt: f64,
        on_error: OnError,
        reported: Reported,
    ) -> Command {
        let (tracker, path) = (&self.tracker, self.path.view());
        if let OnError::Hold(limit) = on_error {
            return self.state.with(room, |state| {
                tracker.step_or_hold(&path, state, input, dt, limit, reported)
            });
        }
        self.state.with(room, |state| {
            let answer = tracker.step(&path, state, input, dt, reported);
            answer.unwrap_or_else(|_| {
                state.miss(dt);
                marked(state.answer)
            })
        })
    }

    /// The angle of [`step`](Self::step).
    pub(super) fn steer(
        &mut self,
        room: &mut TrackerState<L::State>,
        input: VehicleState,
        dt: f64,
        on_error: OnError,
        reported: Reported,
    ) -> f64 {
        if matches!(on_error, OnError::Hold(_)) {
            return self.step(room, input, dt, on_error, reported).steer;
        }
        let (tracker, path) = (&self.tracker, self.path.view());
        self.state.with(room, |state| {
            let answer = tracker.steer(&path, state, input, dt, reported);
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

/// A state, without the 5 kB for commands in flight and the past where there is neither.
#[expect(
    clippy::large_enum_variant,
    reason = "most are short, and there are many"
)]
#[derive(Clone, Debug)]
pub(super) enum KeptState<S> {
    Whole(Box<TrackerState<S>>),
    Short(ShortState<S>),
}

/// A larger state of a controller costs more to be moved at each step than it saves [bytes].
const SHORT: usize = 256;

impl<S: Clone> KeptState<S> {
    pub(super) fn new(state: TrackerState<S>) -> Self {
        match ShortState::of(&state) {
            Some(short) if size_of::<S>() <= SHORT => Self::Short(short),
            _ => Self::Whole(Box::new(state)),
        }
    }

    /// What `change` comes to with the state, unpacked into `room`: any state, which spares the move
    /// of one that is mostly empty.
    #[inline]
    pub(super) fn with<T>(
        &mut self,
        room: &mut TrackerState<S>,
        change: impl FnOnce(&mut TrackerState<S>) -> T,
    ) -> T {
        match self {
            Self::Whole(state) => change(state),
            Self::Short(short) => {
                short.unpack(room);
                let answer = change(room);
                if !short.pack(room) {
                    *self = Self::Whole(Box::new(room.clone()));
                }
                answer
            }
        }
    }

    /// The whole state, in `room`.
    pub(super) fn whole(&self, mut room: TrackerState<S>) -> TrackerState<S> {
        match self {
            Self::Whole(state) => TrackerState::clone(state),
            Self::Short(short) => {
                short.unpack(&mut room);
                room
            }
        }
    }
}
