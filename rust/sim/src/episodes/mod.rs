//! Many vehicles that are steered from outside, one control step at a time: what a learner acts on.
//!
//! Each vehicle is on an episode of its own: a [`Simulation`] that is begun again where it has
//! ended. An action is the steering as a share of the largest angle, and the pedals where the
//! learner works them; what comes back is an observation, a reward and whether the episode is over.

mod episode;
mod reward;

pub use episode::{Episode, FIGURES, INFO, PREVIEW_BOUND};
pub use reward::Weights;

use popsteer_core::InputError;
use popsteer_core::error::{ConfigError, input_in_range};
use rayon::prelude::*;

use crate::longitudinal::Longitudinal;
use crate::simulation::Simulation;

/// Vehicles a thread takes at a time: enough to outweigh handing them over. No more than that are
/// stepped on the thread that asks for it.
pub const CHUNK: usize = 64;

/// An action is bounded, however far a learner overshoots its range; beyond this it is a mistake.
const MAX_ACTION: f64 = 1e9;

/// What all episodes of a batch have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// Who works the pedals; None if the learner does.
    pub longitudinal: Option<Longitudinal>,
    /// How far ahead along the path the points lie that are observed [m].
    pub preview: Vec<f64>,
    /// What is rewarded.
    pub weights: Weights,
    /// An episode is truncated that gets no farther along its path for so long [s]; infinite for
    /// never.
    pub stall_time: f64,
}

impl Terms {
    /// Numbers in an action: the steering, and the pedals where the learner works them.
    pub fn actions(&self) -> usize {
        if self.longitudinal.is_some() { 1 } else { 2 }
    }

    /// Numbers in an observation.
    pub fn observations(&self) -> usize {
        FIGURES.len() + 2 * self.preview.len()
    }
}

/// An action that is refused, with the vehicle's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionError {
    /// Its place in the batch.
    pub vehicle: usize,
    /// Why.
    pub error: InputError,
}

/// Many vehicles, each on an episode of its own.
#[derive(Clone, Debug)]
pub struct Episodes {
    terms: Terms,
    episodes: Vec<Option<Episode>>,
}

impl Episodes {
    /// Room for `count` vehicles, none of which has begun.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] for a weight out of its range.
    pub fn new(count: usize, terms: Terms) -> Result<Self, ConfigError> {
        terms.weights.checked()?;
        Ok(Self {
            terms,
            episodes: vec![None; count],
        })
    }

    /// What the episodes have in common.
    pub fn terms(&self) -> &Terms {
        &self.terms
    }

    /// How many vehicles.
    pub fn len(&self) -> usize {
        self.episodes.len()
    }

    /// Whether there is no vehicle.
    pub fn is_empty(&self) -> bool {
        self.episodes.is_empty()
    }

    /// Begins a new episode. A place beyond the batch changes nothing.
    pub fn begin(&mut self, vehicle: usize, simulation: Simulation) {
        let begun = Episode::new(simulation, &self.terms);
        if let Some(place) = self.episodes.get_mut(vehicle) {
            *place = Some(begun);
        }
    }

    /// The episodes in order; None if a vehicle has not begun one.
    pub fn episodes(&self) -> impl ExactSizeIterator<Item = Option<&Episode>> {
        self.episodes.iter().map(Option::as_ref)
    }

    /// Ends an episode as a failure: the plant cannot go on.
    pub fn fail(&mut self, vehicle: usize) {
        if let Some(Some(episode)) = self.episodes.get_mut(vehicle) {
            episode.fail(&self.terms);
        }
    }

    /// Moves every vehicle by one control step under its `actions`, one after the other in one
    /// slice; beyond -1 and 1 they count as those. A vehicle that is to `rest`, whose episode is
    /// over or has not begun, stays where it is, with no reward.
    ///
    /// With `parallel` on the threads of the pool that it is called from.
    ///
    /// # Errors
    ///
    /// [`ActionError`] for the first action that is not finite; nothing has moved then.
    ///
    /// # Panics
    ///
    /// Where `actions` or `rest` is not as long as the batch asks for.
    pub fn step(
        &mut self,
        actions: &[f64],
        rest: &[bool],
        parallel: bool,
    ) -> Result<(), ActionError> {
        let width = self.terms.actions();
        assert_eq!(actions.len(), width * self.len(), "an action each");
        assert_eq!(rest.len(), self.len(), "a flag each");
        for (vehicle, (action, &rest)) in actions.chunks_exact(width).zip(rest).enumerate() {
            if rest {
                continue;
            }
            for &number in action {
                input_in_range("action", number, -MAX_ACTION, MAX_ACTION)
                    .map_err(|error| ActionError { vehicle, error })?;
            }
        }
        let terms = &self.terms;
        let one = |episode: &mut Option<Episode>, action: &[f64], rest: bool| {
            if let Some(episode) = episode {
                if rest {
                    episode.reward = 0.0;
                } else {
                    episode.step(action, terms);
                }
            }
        };
        if !parallel || self.episodes.len() <= CHUNK {
            let acting = self.episodes.iter_mut().zip(actions.chunks_exact(width));
            for ((episode, action), &rest) in acting.zip(rest) {
                one(episode, action, rest);
            }
            return Ok(());
        }
        self.episodes
            .par_iter_mut()
            .zip(actions.par_chunks_exact(width))
            .zip(rest.par_iter())
            .with_min_len(CHUNK)
            .for_each(|((episode, action), &rest)| one(episode, action, rest));
        Ok(())
    }
}

#[cfg(test)]
mod tests;
