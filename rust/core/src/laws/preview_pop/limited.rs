//! The plan of preview POP within the vehicle's limits: a quadratic program, and its active set.
//!
//! # Problem
//!
//! The unknowns are the moves `u_k` of the commanded curvature, `k = 0 ... N - 1`. With the model
//! and the cost of [`cost_to_go`](super::cost_to_go):
//!
//! ```text
//! minimise    Σ_k  R u_k² + x_{k+1}ᵀ Q x_{k+1}
//! subject to  x_{k+1} = F (x_k + b u_k) + g_k
//!             least_k <= u_k <= most_k           the rate of the wheels
//!             low <= c_{k+1} <= high             their angle, and the lateral acceleration
//! ```
//!
//! where `c_{k+1} = c_k + u_k` is the commanded curvature in `x_{k+1}`. Where it begins outside its
//! limits, the moves until it can be within them are fixed: towards them, as fast as the rate allows
//! ([`PlanLimits::begin`]), so that a plan exists. R is positive and Q has no negative eigenvalue, so
//! there is one solution: the plan that keeps all limits, whose reached limits all have a multiplier
//! of the right sign (the conditions of Karush, Kuhn and Tucker).
//!
//! # Method
//!
//! The limits in a working set are *held*: taken as equalities. The others are left out, so that
//! the backward recursion of [`cost_to_go`](super::cost_to_go) solves the rest. The working set is
//! then corrected until it is stable. One backward recursion with the prediction forward after it
//! is a *pass*; a *step* is always one of the horizon:
//!
//! 1. `PassKind::Guess`: the first pass holds what the last plan reached.
//! 2. `PassKind::Along`: the working set is decided during the backward recursion, by the limits
//!    that the best moves exceed along the best plan so far, as in control-limited differential
//!    dynamic programming (Tassa, Mansard and Todorov, ICRA 2014). This changes the whole set at
//!    once, and most plans need no more. If its moves, cut to their limits, cost more, only a part of
//!    the way to the solution with that set held is gone, cut to its limits.
//! 3. `PassKind::OneByOne`: once no part of the way lowers the cost either, limits are added one at a
//!    time, and where none is in the way those with a multiplier of the wrong sign are released: as in
//!    the primal active-set method (Nocedal and Wright, *Numerical Optimization*, second edition,
//!    section 16.5), but all wrong ones at once, and a pass may go on beyond the first limit. A plan
//!    whose cut moves cost less is still taken whole. So that method's proof of convergence does not
//!    hold here.
//!
//! # When it does not progress
//!
//! The cost of the best plan never rises from pass to pass, but for rounding. It may stay: where the
//! best plan already touches a limit that lies on the way, or one that was just released, the way up
//! to it has length 0, and the pass only adds that limit to the working set (a degenerate step, in the
//! textbook's words). An active-set method may then return to a working set that it had before; there
//! is no rule against it here. [`MAX_PASSES`] ends that, as any slow search: the best plan so far keeps
//! all limits and is returned, with `cut_short`. `rust/core/tests/limited.rs` bounds how often that
//! happens on random problems.
//!
//! The reference in Python solves the same program by another method, the dual active set of
//! Goldfarb and Idnani.

use crate::laws::preview_pop::active_set::{Choice, Held, Side, Step, first_stop};
use crate::laws::preview_pop::cost_to_go::{CostToGo, ModelState};
use crate::laws::preview_pop::horizon::{ROUNDING, plan};
use crate::vehicle::bicycle::MAX_STEPS;

pub use crate::laws::preview_pop::active_set::ReachedLimits;
pub use crate::laws::preview_pop::horizon::{Horizon, MoveLimit, Plan, PlanLimits};

/// The most passes of a plan; after them the best plan so far is taken.
pub const MAX_PASSES: usize = 40;

/// How many passes of a search may go a part of the way; after them limits are added one at a time.
const MAX_SHORTENED: usize = 2;

/// A cost that is lower by no more than this share counts as the same.
const SAME_COST: f64 = 1e-12;

/// How a pass finds which limits to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PassKind {
    /// Those of the guess.
    Guess,
    /// Those that the best moves exceed along the best plan so far.
    Along,
    /// Those of the last pass, with one more, or without those of a wrong multiplier.
    OneByOne,
}

impl Horizon<'_> {
    /// The best plan from `start` within `limits`.
    ///
    /// Where the commanded curvature lies beyond its limit and cannot be brought back by one move,
    /// the moves go back as fast as they may until it can.
    ///
    /// `guess` are the limits that the plan is expected to reach. It changes only the count of
    /// passes, unless the passes run out. Of more than [`MAX_STEPS`] turns the plan is empty; no
    /// caller has as many.
    #[inline(never)]
    pub fn limited(&self, start: ModelState, limits: &PlanLimits, guess: ReachedLimits) -> Plan {
        self.limited_in(MAX_PASSES, start, limits, guess)
    }

    fn limited_in(
        &self,
        most_passes: usize,
        start: ModelState,
        limits: &PlanLimits,
        guess: ReachedLimits,
    ) -> Plan {
        let mut steps = [Step::default(); MAX_STEPS];
        let steps = steps.get_mut(..self.turns.len()).unwrap_or_default();
        guess.hold(steps);
        let scale = limits.begin(start.commanded, self.turns, steps);
        let rounding = scale * ROUNDING;
        let mut best_cost = f64::INFINITY;
        let mut kind = PassKind::Guess;
        let mut shortened = 0;
        for pass in 1..=most_passes {
            if kind == PassKind::Along {
                self.recur_along(start, steps);
            } else {
                self.recur(steps);
            }
            let cost = self.roll_cut(start, steps);
            // Each held step's best move exceeds just the limit that it is held at, and no other
            // step's exceeds one: multipliers of the right sign.
            if steps.iter().all(|step| step.next.held == step.held) {
                return plan(steps, |step| step.next, pass, false);
            }
            if cost < best_cost * (1.0 - SAME_COST) {
                best_cost = cost;
                take(steps, |step| step.next);
                if kind == PassKind::Guess {
                    kind = PassKind::Along;
                }
                continue;
            }
            if self.roll_held(start, steps, rounding) {
                return plan(steps, |step| step.next, pass, false);
            }
            if kind == PassKind::OneByOne {
                best_cost = self.go_on(start, steps, rounding);
                continue;
            }
            if shortened < MAX_SHORTENED
                && let Some(cost) = self.shorten(start, steps, best_cost)
            {
                best_cost = cost;
                shortened += 1;
                kind = PassKind::Along;
                continue;
            }
            kind = PassKind::OneByOne;
            for step in steps.iter_mut() {
                step.held = step.best.held;
            }
        }
        plan(steps, |step| step.best, most_passes, true)
    }

    /// Backward: the best moves, where those of the working set are held.
    fn recur(&self, steps: &mut [Step]) {
        let mut after = self.stage;
        let mut landing = None;
        for step in steps.iter_mut().rev() {
            let cost = after.before(&self.travel, step.turn);
            step.policy = cost.best_move(self.move_cost);
            step.target = step.held_curvature().or(landing);
            // Where a held move has to arrive at a curvature, the step before has to bring the
            // curvature to where this move begins.
            landing = match (step.held_move(), step.target) {
                (Some(moved), Some(target)) => Some(target - moved),
                _ => None,
            };
            after = self.before_move(&cost, step);
        }
    }

    /// Backward along the best plan so far: the best moves, each held at the limit that it exceeds.
    fn recur_along(&self, start: ModelState, steps: &mut [Step]) {
        let mut state = start;
        for step in steps.iter_mut() {
            step.state = state;
            self.advance(&mut state, step.best.curvature, step.turn);
        }
        let mut after = self.stage;
        for step in steps.iter_mut().rev() {
            let cost = after.before(&self.travel, step.turn);
            step.policy = cost.best_move(self.move_cost);
            let wanted = step.policy.commanded(&step.state);
            step.held = step.cut(step.state.commanded, wanted).held;
            step.target = step.held_curvature();
            after = self.before_move(&cost, step);
        }
    }

    /// The cost-to-go before the move of `step`, held or free; `cost` is the one after it.
    #[inline]
    fn before_move(&self, cost: &CostToGo, step: &Step) -> CostToGo {
        match (step.held_move(), step.target) {
            (Some(moved), _) => cost.before_move_by(moved, &self.stage),
            (None, Some(target)) => cost.before_move_to(target, self.move_cost, &self.stage),
            (None, None) => cost.before_best_move(self.move_cost, &self.stage),
        }
    }

    /// Forward: the best moves, each cut to its limits, into `next`; their cost.
    fn roll_cut(&self, start: ModelState, steps: &mut [Step]) -> f64 {
        let mut state = start;
        let mut cost = 0.0;
        for step in steps {
            let wanted = step.policy.commanded(&state);
            step.next = step.cut(state.commanded, wanted);
            cost += self.advance(&mut state, step.next.curvature, step.turn);
        }
        cost
    }

    /// Forward: the solution with the working set held, into `next`; `next.held` is the working set
    /// corrected by the limits that it exceeds and the multipliers of the wrong sign. Returns
    /// whether nothing had to be corrected: the plan is then the best of all.
    ///
    /// The cost is a parabola in each move: `(R + S_cc) (u - u_best)²` plus a constant. Half its
    /// slope is the multiplier of a limit of this move: wrong below 0 at the low end, and above 0 at
    /// the high one. The multiplier λ of a limit of the curvature `c_{k+1}` is that slope at the last
    /// step up to k whose move is not held; that of each held move after it is its own slope less λ.
    /// If all moves up to k are held, the limits depend on each other, and λ is 0.
    fn roll_held(&self, start: ModelState, steps: &mut [Step], rounding: f64) -> bool {
        let mut state = start;
        // Half the slope of the cost over the curvature at which the held moves have to arrive.
        let mut landing_slope = 0.0;
        let mut optimal = true;
        for step in steps {
            let before = state.commanded;
            let wanted = step.policy.commanded(&state);
            let moved = step.held_move();
            step.next.curvature = match (moved, step.target) {
                (Some(moved), _) => before + moved,
                (None, Some(target)) => target,
                (None, None) => wanted,
            };
            // R + S_cc, as `remaining` is R / (R + S_cc).
            let stiffness = self.move_cost / step.policy.remaining;
            let slope = stiffness * (step.next.curvature - wanted);
            let tolerance = stiffness * rounding;
            step.next.held = step.held;
            if moved.is_none() {
                landing_slope = slope;
            } else if !step.limits.forced {
                let own = if step.target.is_some() {
                    slope - landing_slope
                } else {
                    slope
                };
                if step.held.rate.should_release(own, tolerance) {
                    step.next.held.rate = Side::Neither;
                }
            }
            if step.held.curvature.should_release(landing_slope, tolerance) {
                step.next.held.curvature = Side::Neither;
            }
            step.hold_exceeded(before, rounding);
            optimal &= step.next.held == step.held;
            self.advance(&mut state, step.next.curvature, step.turn);
        }
        optimal
    }

    /// Goes a part of the way from the best plan to the next one, with the moves cut to their
    /// limits, if one costs less than `best_cost`; the cost then.
    fn shorten(&self, start: ModelState, steps: &mut [Step], best_cost: f64) -> Option<f64> {
        let mut share = 0.5;
        while share > 0.05 {
            let cost = self.cost_along(start, steps, share, true);
            if cost < best_cost * (1.0 - SAME_COST) {
                take(steps, |step| step.trial);
                return Some(cost);
            }
            share *= 0.5;
        }
        None
    }

    /// Goes from the best plan towards the next one, which costs less but may exceed limits: until
    /// the first limit stops it, or farther, with the moves cut to their limits, if that costs
    /// less. Returns the cost of the best plan then. The limit that stops it is added to the
    /// working set, even if the way up to it has length 0.
    fn go_on(&self, start: ModelState, steps: &mut [Step], rounding: f64) -> f64 {
        let (share, stop) = first_stop(start.commanded, steps, rounding);
        let mut best = (share, self.cost_along(start, steps, share, false));
        if stop.is_some() {
            let mut farther = 1.0;
            while farther > share && farther > 1e-3 {
                let cost = self.cost_along(start, steps, farther, true);
                if cost < best.1 {
                    best = (farther, cost);
                }
                farther *= 0.25; // shares 1, 1/4, ... 1/256
            }
        }
        if best.0 > share {
            self.cost_along(start, steps, best.0, true);
        } else {
            self.cost_along(start, steps, share, false);
            for (index, step) in steps.iter_mut().enumerate() {
                step.trial.held = match stop {
                    None => step.next.held,
                    Some((at, held)) if at == index => held,
                    Some(_) => step.held,
                };
            }
        }
        take(steps, |step| step.trial);
        best.1
    }

    /// The cost of the plan, into `trial`, that lies a `share` of the way from the best one to the
    /// next. With `cut`, each move is cut to its limits, and one that is held is made in full; without,
    /// `trial.held` is not set.
    fn cost_along(&self, start: ModelState, steps: &mut [Step], share: f64, cut: bool) -> f64 {
        let mut state = start;
        let mut cost = 0.0;
        for step in steps {
            let before = state.commanded;
            let best = step.best.curvature;
            let between = best + share * (step.next.curvature - best);
            step.trial.curvature = between;
            if cut {
                let wanted = step.held_move().map_or(between, |moved| before + moved);
                step.trial = step.cut(before, wanted);
                if step.trial.held == Held::default() {
                    // It exceeds no limit. What is held may still be reached: equal, to the bit.
                    step.trial.held.rate = step.held.rate;
                    let end = step.held_curvature();
                    if end.is_some_and(|end| (end - step.trial.curvature).abs() <= 0.0) {
                        step.trial.held.curvature = step.held.curvature;
                    }
                }
            }
            cost += self.advance(&mut state, step.trial.curvature, step.turn);
        }
        cost
    }
}

/// Makes the plan `of` the steps the best one so far, and its limits the working set.
#[inline]
fn take(steps: &mut [Step], of: impl Fn(&Step) -> Choice) {
    for step in steps {
        step.best = of(step);
        step.held = step.best.held;
    }
}

#[cfg(test)]
mod tests;
