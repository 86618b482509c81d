//! The plan of preview POP over its horizon, without limits, and whether it keeps them.
//!
//! A plan is the commanded curvatures `c_1 ... c_N` after the moves of its steps. Without limits,
//! the backward recursion of [`cost_to_go`](super::cost_to_go) gives the best move of each step as
//! a feedback, [`BestMove`]; the prediction forward,
//!
//! ```text
//! c_{k+1} = remaining_k c_k - (K_k x_k + k_k),    x_{k+1} = F (x_k + b u_k) + g_k
//! ```
//!
//! then gives the curvatures, of which [`Horizon::keeps`] asks whether they keep [`PlanLimits`].

use crate::laws::preview_pop::active_set::{Choice, Held, ReachedLimits, Side, Step, StepLimits};
use crate::laws::preview_pop::cost_to_go::{BestMove, CostToGo, ModelState, Travel};
use crate::math::smaller;
use crate::vehicle::bicycle::MAX_STEPS;

/// Shares of the largest move that are rounding: a limit that is exceeded by less is kept.
pub(super) const ROUNDING: f64 = 1e-10;

/// The planning problem: the prediction over the horizon, and the cost of its steps.
#[derive(Clone, Copy, Debug)]
pub struct Horizon<'a> {
    /// One step of travel.
    pub travel: Travel,
    /// Q, the cost of the state after a step.
    pub stage: CostToGo,
    /// R, the cost of a move over its square; positive.
    pub move_cost: f64,
    /// How far the path turns in each step [rad]; at most [`MAX_STEPS`].
    pub turns: &'a [f64],
}

/// The limits of a plan: of its moves `u_k = c_{k+1} - c_k`, and of its curvatures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanLimits {
    /// Least and greatest `u_0` [1/m]; 0 lies between them.
    pub first: (f64, f64),
    /// The largest magnitude of the other moves [1/m]; positive.
    pub later: f64,
    /// Least curvature that is commanded [1/m].
    pub low: f64,
    /// Greatest curvature that is commanded [1/m].
    pub high: f64,
}

/// The limit that the first move of a plan reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveLimit {
    /// None.
    Nothing,
    /// That of the move: the rate of the wheels.
    Rate,
    /// That of the curvature after it.
    Curvature,
}

/// A plan, and how it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Curvature that is commanded after each move [1/m]; 0 beyond the horizon.
    pub curvatures: [f64; MAX_STEPS],
    /// The limit that the first move reaches.
    pub reached: MoveLimit,
    /// The limits that the plan reaches.
    pub limits: ReachedLimits,
    /// How many backward recursions it took.
    pub passes: usize,
    /// Whether the passes ran out: the plan keeps the limits but is not the best.
    pub cut_short: bool,
}

impl Plan {
    /// Curvature that is commanded after the first move [1/m].
    pub fn first(&self) -> f64 {
        let [first, ..] = self.curvatures;
        first
    }
}

impl Horizon<'_> {
    /// The best moves without limits, into `moves`, and the cost-to-go before the first of them.
    #[inline]
    pub fn unlimited(&self, moves: &mut [BestMove]) -> CostToGo {
        let mut after = self.stage;
        let mut cost = self.stage;
        for (&turn, best) in self.turns.iter().zip(moves).rev() {
            cost = after.before(&self.travel, turn);
            *best = cost.best_move(self.move_cost);
            after = cost.before_best_move(self.move_cost, &self.stage);
        }
        cost
    }

    /// Whether `moves` from `start` keep `limits`, except that of the first move, which the caller
    /// checks as an angle.
    ///
    /// Every control step needs this, so it is written to be fast: a processor that computes `c_{k+1}`
    /// from `x_k`, and `x_{k+1}` from that, waits for each. The state is therefore carried without
    /// what its last curvature adds to it, `z_k = x_k - (F_ec, F_pc, F_ac, 0)ᵀ c_k`, most of which
    /// can be computed before that curvature is known:
    ///
    /// ```text
    /// c_{k+1} = remaining_after c_k - (K_k z_k + k_k)         BestMove::remaining_after, pull
    /// z_{k+1} = (F_0 z_k + g_k) + F_0 (F_ec, F_pc, F_ac, 0)ᵀ c_k    Travel::without_commanded, added
    /// ```
    #[inline]
    pub fn keeps(&self, moves: &[BestMove], start: ModelState, limits: &PlanLimits) -> bool {
        let within = |curvature: f64| limits.low <= curvature && curvature <= limits.high;
        let [first, moves @ ..] = moves else {
            return true;
        };
        let [turn, turns @ ..] = self.turns else {
            return true;
        };
        let travel = &self.travel;
        let mut state = travel.without_commanded(&start, *turn);
        let mut present = first.commanded(&start);
        let mut kept = within(present);
        let added = travel.added();
        for (best, &turn) in moves.iter().zip(turns) {
            let next = best.remaining_after(travel) * present - best.pull(&state);
            kept &= (next - present).abs() <= limits.later;
            kept &= within(next);
            state = travel.without_commanded(&state, turn);
            state.error += added.error * present;
            state.heading += added.heading * present;
            state.driven += added.driven * present;
            present = next;
        }
        kept
    }

    /// Moves `state` on by a step with the commanded `curvature`; returns what the step costs.
    pub(super) fn advance(&self, state: &mut ModelState, curvature: f64, turn: f64) -> f64 {
        let moved = curvature - state.commanded;
        state.commanded = curvature;
        *state = self.travel.after(state, turn);
        self.move_cost * moved * moved + self.stage.stage_cost(state)
    }
}

impl PlanLimits {
    /// Prepares the steps of a plan that starts from the curvature `commanded`, and fixes the first
    /// of them where the curvature lies so far beyond its limits that no move reaches them: such a
    /// move goes back as fast as it may. Returns a length of move to measure rounding by.
    pub(super) fn begin(&self, commanded: f64, turns: &[f64], steps: &mut [Step]) -> f64 {
        let range = self.high - self.low;
        let scale = smaller(self.later, range);
        let rounding = scale * ROUNDING;
        let mut curvature = commanded;
        let (mut least, mut most) = self.first;
        for (step, &turn) in steps.iter_mut().zip(turns) {
            step.turn = turn;
            step.limits = StepLimits {
                least,
                most,
                low: self.low,
                high: self.high,
                forced: false,
            };
            // A move that has no end on that side is not held there.
            if step.held_move().is_some_and(f64::is_infinite) {
                step.held = Held::default();
            }
            if curvature + least >= self.high - rounding {
                step.force(Side::Low);
                curvature += least;
            } else if curvature + most <= self.low + rounding {
                step.force(Side::High);
                curvature += most;
            } else {
                // One move reaches the limits, so no later move is forced: any curvature within
                // them can stand for that after this step.
                curvature = 0.5 * (self.low + self.high);
            }
            (least, most) = (-self.later, self.later);
        }
        scale
    }
}

/// The plan that is made `of` the steps, with the limits of their working set.
pub(super) fn plan(
    steps: &[Step],
    of: impl Fn(&Step) -> Choice,
    passes: usize,
    cut_short: bool,
) -> Plan {
    let first = steps.first().copied().unwrap_or_default();
    let reached = match (first.held.rate, first.held.curvature) {
        (_, Side::Low | Side::High) => MoveLimit::Curvature,
        (Side::Low | Side::High, _) => MoveLimit::Rate,
        _ => MoveLimit::Nothing,
    };
    let mut curvatures = [0.0; MAX_STEPS];
    for (curvature, step) in curvatures.iter_mut().zip(steps) {
        *curvature = of(step).curvature;
    }
    Plan {
        curvatures,
        reached,
        limits: ReachedLimits::of(steps),
        passes,
        cut_short,
    }
}

#[cfg(test)]
mod tests;
