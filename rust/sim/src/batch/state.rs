//! States as a batch keeps them.

use popsteer_core::tracker::{ShortState, TrackerState};

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
