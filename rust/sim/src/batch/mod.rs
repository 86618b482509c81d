//! Many vehicles, one step at a time, on all cores.

mod member;

#[cfg(test)]
mod tests;

pub use member::{Member, OnError};

use std::sync::Arc;

use popsteer_core::tracker::{Reported, TrackerState};
use popsteer_core::vehicle::state::period;
use popsteer_core::{Command, InputError, LateralLaw, Path, Tracker, VehicleState};
use rayon::prelude::*;

use self::member::{Kept, Scratch};

/// Vehicles a thread takes at a time: enough to outweigh handing them over. A batch of no more is
/// stepped on the thread that asks for it.
pub const CHUNK: usize = 256;

/// A vehicle whose input is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchError {
    /// Its place in the batch; None if `dt` is not finite.
    pub vehicle: Option<usize>,
    /// Why.
    pub error: InputError,
}

/// Vehicles under controllers of one kind, each with vehicle, parameters, path and state of its
/// own.
#[derive(Clone, Debug)]
pub struct Batch<L: LateralLaw> {
    members: Vec<Kept<L>>,
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
            tracker: Tracker::clone(&member.tracker),
            path: Arc::clone(&member.path),
            state: member.state(),
        })
    }

    /// Takes every vehicle back to its initial state.
    pub fn reset(&mut self) {
        for member in &mut self.members {
            member.set_state(member.tracker.initial_state());
        }
    }

    /// Has a vehicle follow another path from its next step on, as [`Tracker::set_path`]. A place
    /// beyond the batch changes nothing.
    pub fn set_path(&mut self, vehicle: usize, path: Arc<Path>) {
        if let Some(member) = self.members.get_mut(vehicle) {
            let path = Path::for_vehicle(path, member.tracker.vehicle());
            let (state, old) = (&mut member.tracking, member.path.view());
            member.tracker.set_path(state, &old, &path.view());
            member.path = path;
        }
    }

    /// The states, in order.
    pub fn states(&self) -> impl ExactSizeIterator<Item = TrackerState<L::State>> {
        self.members.iter().map(Kept::state)
    }

    /// Puts the states, in order; each is one that [`Tracker::check_state`] accepts.
    pub fn set_states(&mut self, states: impl IntoIterator<Item = TrackerState<L::State>>) {
        for (member, state) in self.members.iter_mut().zip(states) {
            member.set_state(state);
        }
    }

    /// Steps every vehicle, which report what is `reported`, nothing where that is empty: `write`
    /// is given each place in `out`, and the command for it, that of [`Tracker::step`].
    /// Where an input is refused under [`OnError::Mark`] the command has no numbers, the direction
    /// of the last one, and [`Status::INPUT_HELD`].
    ///
    /// # Errors
    ///
    /// [`BatchError`] for a `dt` that is not finite, and for the first vehicle whose input is refused, as
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
        let one = |member: &mut Kept<L>, scratch: &mut _, input, reported, place: &mut T| {
            write(place, member.step(scratch, input, dt, on_error, reported));
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
        let one = |member: &mut Kept<L>, scratch: &mut _, input, reported, angle: &mut f64| {
            *angle = member.steer(scratch, input, dt, on_error, reported);
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
        one: impl Fn(&mut Kept<L>, &mut Scratch, VehicleState, Reported, &mut T) + Sync,
    ) -> Result<(), BatchError> {
        let reported_of = |vehicle: usize| reported.get(vehicle).copied().unwrap_or_default();
        let given = reported.is_empty() || reported.len() == self.len();
        assert!(given, "one report for each vehicle, or none");
        assert_eq!(inputs.len(), self.len(), "one input for each vehicle");
        assert_eq!(out.len(), self.len(), "one place for each vehicle");
        if !matches!(on_error, OnError::Hold(_)) {
            period(dt).map_err(|error| BatchError {
                vehicle: None,
                error,
            })?;
        }
        if on_error == OnError::Raise {
            let refused = inputs.iter().enumerate().find_map(|(vehicle, input)| {
                // Without reports no vehicle is looked at: this is done by one thread.
                let reported = || {
                    let car = self.members.get(vehicle)?.tracker.vehicle();
                    reported.get(vehicle)?.checked(car).err()
                };
                let error = input.checked().err().or_else(reported)?;
                Some(BatchError {
                    vehicle: Some(vehicle),
                    error,
                })
            });
            refused.map_or(Ok(()), Err)?;
        }
        if self.len() <= CHUNK {
            let mut scratch = Scratch::default();
            let members = self.members.iter_mut().zip(inputs).zip(out);
            for (vehicle, ((member, &input), place)) in members.enumerate() {
                one(member, &mut scratch, input, reported_of(vehicle), place);
            }
            return Ok(());
        }
        self.members
            .par_iter_mut()
            .zip(inputs.par_iter())
            .zip(out.par_iter_mut())
            .enumerate()
            .with_min_len(CHUNK)
            .for_each_init(
                Scratch::default,
                |scratch, (vehicle, ((member, &input), place))| {
                    one(member, scratch, input, reported_of(vehicle), place);
                },
            );
        Ok(())
    }
}
