//! The plan of preview POP within the vehicle's limits.
//!
//! The plan is the solution of a quadratic program over the moves `u_k` of the curvature that is
//! commanded, `c_{k+1} = c_k + u_k`:
//!
//! ```text
//! minimise    sum over k of  move_cost u_k^2 + stage(x_{k+1})
//! subject to  least_k <= u_k <= most_k,    low <= c_{k+1} <= high
//! ```
//!
//! with the state `x_{k+1}` that [`Travel::after`](super::cost_to_go::Travel::after) predicts from
//! `x_k` and `c_{k+1}`. It is solved by an active set: the limits that are reached are held as
//! given, the backward recursion gives the best of the other moves, and which limits are held is
//! put right until nothing changes. A
//! *pass* is one such recursion. The first holds what the guess says. Most of the others decide
//! what to hold during the backward recursion: the limits that the moves exceed along the best plan
//! so far, as in control-limited differential dynamic programming does (Tassa, Mansard and Todorov,
//! 2014), which changes the whole set at once. If the plan of a pass costs more, only a part of the
//! step towards it is taken. Once that does not lower the cost either, one limit at a time is
//! added, or those that keep the cost up are released, which lowers it at every pass (Nocedal and
//! Wright, *Numerical Optimization*, section 16.5).

use crate::laws::preview_pop::active_set::{Held, Side, Step, first_stop};
use crate::laws::preview_pop::cost_to_go::ModelState;
use crate::laws::preview_pop::horizon::{ROUNDING, plan};
use crate::vehicle::bicycle::MAX_STEPS;

pub use crate::laws::preview_pop::active_set::ReachedLimits;
pub use crate::laws::preview_pop::horizon::{Horizon, MoveLimit, Plan, PlanLimits};

/// The most passes of a plan; after them the best plan so far is taken.
pub const MAX_PASSES: usize = 40;

/// How often a part of the step is tried in a pass that does not lower the cost; after that limits
/// are added one at a time.
const SHORTENED: usize = 2;

/// A cost that is lower by no more than this share is not lower.
const SAME_COST: f64 = 1e-12;

/// How a pass finds which limits to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PassKind {
    /// Those of the guess.
    Guess,
    /// Those that the moves exceed along the best plan so far.
    Along,
    /// Those of the last pass, with one more, or without those that keep the cost up.
    OneByOne,
}

impl Horizon<'_> {
    /// The best plan from `start` within `limits`.
    ///
    /// Where the commanded curvature lies beyond its limit and cannot be brought back by one move,
    /// the moves go back as fast as they may until it can.
    ///
    /// `guess` are the limits that the plan may reach; it decides nothing but the count of passes.
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
            if steps.iter().all(|step| step.next_held == step.held) {
                return plan(steps, |step| step.next, pass, false);
            }
            if cost < best_cost * (1.0 - SAME_COST) {
                best_cost = cost;
                for step in steps.iter_mut() {
                    step.best = step.next;
                    step.best_held = step.next_held;
                    step.held = step.next_held;
                }
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
            if shortened < SHORTENED
                && let Some(cost) = self.shorten(start, steps, best_cost)
            {
                best_cost = cost;
                shortened += 1;
                kind = PassKind::Along;
                continue;
            }
            kind = PassKind::OneByOne;
            for step in steps.iter_mut() {
                step.held = step.best_held;
            }
        }
        plan(steps, |step| step.best, most_passes, true)
    }

    /// Backward: the best moves where some are held.
    fn recur(&self, steps: &mut [Step]) {
        let mut after = self.stage;
        let mut landing = None;
        for step in steps.iter_mut().rev() {
            let cost = after.before(&self.travel, step.turn, self.drift);
            step.policy = cost.best_move(self.move_cost);
            step.target = step.held_curvature().or(landing);
            landing = None;
            after = match (step.held_move(), step.target) {
                (Some(moved), target) => {
                    // Both are held, so it is the step before that brings the curvature there.
                    landing = target.map(|target| target - moved);
                    cost.before_move_by(moved, &self.stage)
                }
                (None, Some(target)) => cost.before_move_to(target, self.move_cost, &self.stage),
                (None, None) => cost.before_best_move(self.move_cost, &self.stage),
            };
        }
    }

    /// Backward along the best plan so far: the best moves, each held where it exceeds a limit.
    fn recur_along(&self, start: ModelState, steps: &mut [Step]) {
        let mut state = start;
        for step in steps.iter_mut() {
            step.state = state;
            self.advance(&mut state, step.best, step.turn);
        }
        let mut after = self.stage;
        for step in steps.iter_mut().rev() {
            let cost = after.before(&self.travel, step.turn, self.drift);
            step.policy = cost.best_move(self.move_cost);
            let wanted = step.policy.commanded(&step.state);
            (_, step.held) = step.cut(step.state.commanded, wanted);
            step.target = step.held_curvature();
            after = match (step.held_move(), step.target) {
                (Some(moved), _) => cost.before_move_by(moved, &self.stage),
                (None, Some(target)) => cost.before_move_to(target, self.move_cost, &self.stage),
                (None, None) => cost.before_best_move(self.move_cost, &self.stage),
            };
        }
    }

    /// Forward: the best moves, each cut to its limits, and which limits cut them; their cost.
    fn roll_cut(&self, start: ModelState, steps: &mut [Step]) -> f64 {
        let mut state = start;
        let mut cost = 0.0;
        for step in steps {
            let wanted = step.policy.commanded(&state);
            (step.next, step.next_held) = step.cut(state.commanded, wanted);
            cost += self.advance(&mut state, step.next, step.turn);
        }
        cost
    }

    /// Forward: the best moves where some are held. Whether they are the best of all: no other
    /// limit is exceeded, and none that is held keeps the cost up. Where that is not so,
    /// `next_held` has those and not these.
    fn roll_held(&self, start: ModelState, steps: &mut [Step], rounding: f64) -> bool {
        let mut state = start;
        // What it is worth to move the place where held moves have to land.
        let mut landed = 0.0;
        let mut right = true;
        for step in steps {
            let before = state.commanded;
            let wanted = step.policy.commanded(&state);
            let moved = step.held_move();
            step.next = match (moved, step.target) {
                (Some(moved), _) => before + moved,
                (None, Some(target)) => target,
                (None, None) => wanted,
            };
            // Half the slope of the cost over this move, and what of it counts.
            let stiffness = self.move_cost / step.policy.remaining;
            let slope = stiffness * (step.next - wanted);
            let least = stiffness * rounding;
            step.next_held = step.held;
            if moved.is_none() {
                landed = slope;
            } else if !step.forced {
                let own = if step.target.is_some() {
                    slope - landed
                } else {
                    slope
                };
                if step.held.rate.resists(own, least) {
                    step.next_held.rate = Side::Neither;
                }
            }
            if step.held.curvature.resists(landed, least) {
                step.next_held.curvature = Side::Neither;
            }
            step.hold_exceeded(before, rounding);
            right &= step.next_held == step.held;
            self.advance(&mut state, step.next, step.turn);
        }
        right
    }

    /// Takes a part of the step from the best plan to the next one, with the moves cut to their
    /// limits, where that costs less than `best_cost`; the cost then.
    fn shorten(&self, start: ModelState, steps: &mut [Step], best_cost: f64) -> Option<f64> {
        let mut share = 0.5;
        while share > 0.05 {
            let cost = self.cost_along(start, steps, share, true);
            if cost < best_cost * (1.0 - SAME_COST) {
                for step in steps {
                    step.best = step.trial;
                    step.held = step.trial_held;
                    step.best_held = step.held;
                }
                return Some(cost);
            }
            share *= 0.5;
        }
        None
    }

    /// Goes from the best plan towards the next one, which costs less without the limits: until a
    /// limit stops it, or farther, with the moves cut to their limits, where that costs less. The
    /// cost of the best plan then.
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
                farther *= 0.25;
            }
        }
        if best.0 > share {
            self.cost_along(start, steps, best.0, true);
        } else {
            self.cost_along(start, steps, share, false);
            for (index, step) in steps.iter_mut().enumerate() {
                step.trial_held = match stop {
                    None => step.next_held,
                    Some((at, held)) if at == index => held,
                    Some(_) => step.held,
                };
            }
        }
        for step in steps {
            step.best = step.trial;
            step.held = step.trial_held;
            step.best_held = step.held;
        }
        best.1
    }

    /// The cost of a plan a `share` of the step from the best one to the next, cut to its limits
    /// where that is asked for; the plan is `trial`.
    fn cost_along(&self, start: ModelState, steps: &mut [Step], share: f64, cut: bool) -> f64 {
        let mut state = start;
        let mut cost = 0.0;
        for step in steps {
            let before = state.commanded;
            let between = step.best + share * (step.next - step.best);
            step.trial = between;
            if cut {
                let wanted = step.held_move().map_or(between, |moved| before + moved);
                (step.trial, step.trial_held) = step.cut(before, wanted);
                if step.trial_held == Held::default() {
                    // Neither limit is exceeded, so what was held still is where it is reached.
                    step.trial_held.rate = step.held.rate;
                    if step
                        .held_curvature()
                        .is_some_and(|end| (end - step.trial).abs() <= 0.0)
                    {
                        step.trial_held.curvature = step.held.curvature;
                    }
                }
            }
            cost += self.advance(&mut state, step.trial, step.turn);
        }
        cost
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::preview_pop::cost_to_go::{CostToGo, Travel};

    #[test]
    fn test_plan_cut_short_keeps_the_limits_and_says_so() {
        let turns = [0.0; MAX_STEPS];
        let horizon = Horizon {
            travel: Travel::new(0.4, 1.2, 0.7, 0.0),
            stage: CostToGo::stage(2.7, 0.0),
            move_cost: 150.0,
            turns: &turns,
            drift: 0.0,
        };
        let start = ModelState {
            error: 1.0,
            heading: -0.2,
            driven: 0.0,
            commanded: 0.0,
        };
        let limits = PlanLimits {
            first: (-0.004, 0.004),
            later: 0.004,
            low: -0.03,
            high: 0.02,
        };
        let guess = ReachedLimits::default();
        let best = horizon.limited(start, &limits, guess);
        assert!(!best.cut_short && best.passes > 1, "{best:?}");
        let plan = horizon.limited_in(1, start, &limits, guess);
        assert!(plan.cut_short && plan.passes == 1, "{plan:?}");
        let mut before = 0.0;
        for next in plan.curvatures {
            assert!((next - before).abs() <= 0.004 * (1.0 + 1e-12));
            assert!((-0.03..=0.02).contains(&next));
            before = next;
        }
        // From the limits that the best plan reaches, nothing has to change.
        let again = horizon.limited(start, &limits, best.limits);
        assert_eq!((again.passes, again.curvatures), (1, best.curvatures));
    }
}
