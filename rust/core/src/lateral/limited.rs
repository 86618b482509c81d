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
//! with the state `x_{k+1}` that [`Travel::after`] predicts from `x_k` and `c_{k+1}`. It is solved
//! by an active set: the limits that are reached are held as given, the backward recursion gives
//! the best of the other moves, and which limits are held is put right until nothing changes. A
//! *pass* is one such recursion. Most passes change the whole set at once, as the moves cut to their
//! limits show it; once that fails to lower the cost, one limit at a time is added,
//! or those that keep the cost up are released, which lowers it at every pass (Nocedal and Wright,
//! *Numerical Optimization*, section 16.5).

use super::cost_to_go::{BestMove, CostToGo, Predicted, Travel};
use super::held::{Held, Side, Step, first_stop};
use crate::vehicle::bicycle::MAX_STEPS;

pub use super::held::ReachedLimits;

/// The most passes of a plan; after them the best plan so far is taken.
pub const MAX_PASSES: usize = 40;

/// Passes that may fail to lower the cost; after them limits are added one at a time.
const TRIES: usize = 2;

/// Shares of the largest move that are rounding: a limit that is exceeded by less is kept.
const ROUNDING: f64 = 1e-10;

/// A cost that is lower by no more than this share is not lower.
const SAME_COST: f64 = 1e-12;

/// What is planned: a prediction, and what its steps cost.
#[derive(Clone, Copy, Debug)]
pub struct Horizon<'a> {
    /// One step of travel.
    pub travel: Travel,
    /// Cost of the state after a step.
    pub stage: CostToGo,
    /// Cost of a move, times its square; positive.
    pub move_cost: f64,
    /// How far the path turns in each step [rad]; at most [`MAX_STEPS`].
    pub turns: &'a [f64],
    /// How far the vehicle drifts to the left in a step [m].
    pub drift: f64,
}

/// What the moves of a plan keep to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Least and greatest first move [1/m]; 0 lies between them.
    pub first: (f64, f64),
    /// The largest of the other moves, either way [1/m]; positive.
    pub later: f64,
    /// Least curvature that is commanded [1/m].
    pub low: f64,
    /// Greatest curvature that is commanded [1/m].
    pub high: f64,
}

/// The limit that a first move reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// None.
    Nothing,
    /// That of the move.
    Rate,
    /// That of the curvature.
    Curvature,
}

/// A plan, and how it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Curvature that is commanded after each move [1/m]; 0 beyond the horizon.
    pub curvatures: [f64; MAX_STEPS],
    /// The limit that the first move reaches.
    pub reached: Reached,
    /// The limits that the plan reaches.
    pub limits: ReachedLimits,
    /// Backward recursions taken.
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
            cost = after.before(&self.travel, turn, self.drift);
            *best = cost.best_move(self.move_cost);
            after = cost.before_best_move(self.move_cost, &self.stage);
        }
        cost
    }

    /// Whether `moves` from `start` keep to `limits`, that of the first move apart.
    #[inline]
    pub fn keeps(&self, moves: &[BestMove], start: Predicted, limits: &Limits) -> bool {
        let mut state = start;
        let mut most = f64::INFINITY;
        let mut kept = true;
        for (best, &turn) in moves.iter().zip(self.turns) {
            let next = best.commanded(&state);
            kept &= (next - state.commanded).abs() <= most;
            kept &= limits.low <= next && next <= limits.high;
            state.commanded = next;
            state = self.travel.after(&state, turn, self.drift);
            most = limits.later;
        }
        kept
    }

    /// The best plan from `start` within `limits`.
    ///
    /// Where the commanded curvature lies beyond its limit and cannot be brought back by one move,
    /// the moves go back as fast as they may until it can.
    ///
    /// `guess` are the limits that the plan may reach; it decides nothing but the count of passes.
    #[inline(never)]
    pub fn limited(&self, start: Predicted, limits: &Limits, guess: ReachedLimits) -> Plan {
        self.limited_in(MAX_PASSES, start, limits, guess)
    }

    fn limited_in(
        &self,
        most_passes: usize,
        start: Predicted,
        limits: &Limits,
        guess: ReachedLimits,
    ) -> Plan {
        let mut steps = [Step::default(); MAX_STEPS];
        let steps = steps.get_mut(..self.turns.len()).unwrap_or_default();
        guess.hold(steps);
        let scale = limits.begin(start.commanded, self.turns, steps);
        let rounding = scale * ROUNDING;
        let mut best_cost = f64::INFINITY;
        let mut tries = 0;
        for pass in 1..=most_passes {
            self.recur(steps);
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
                continue;
            }
            if self.roll_held(start, steps, rounding) {
                return plan(steps, |step| step.next, pass, false);
            }
            tries += 1;
            if tries <= TRIES {
                for step in steps.iter_mut() {
                    step.held = step.next_held;
                }
            } else if tries == TRIES + 1 {
                for step in steps.iter_mut() {
                    step.held = step.best_held;
                }
            } else {
                best_cost = self.go_on(start, steps, rounding);
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

    /// Forward: the best moves, each cut to its limits, and which limits cut them; their cost.
    fn roll_cut(&self, start: Predicted, steps: &mut [Step]) -> f64 {
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
    fn roll_held(&self, start: Predicted, steps: &mut [Step], rounding: f64) -> bool {
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
            let stiffness = self.move_cost / step.policy.left;
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

    /// Goes from the best plan towards the next one, which costs less without the limits: until a
    /// limit stops it, or farther, with the moves cut to their limits, where that costs less. The
    /// cost of the best plan then.
    fn go_on(&self, start: Predicted, steps: &mut [Step], rounding: f64) -> f64 {
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

    /// The cost of a plan a `share` of the way from the best one to the next, cut to its limits
    /// where that is asked for; the plan is `trial`.
    fn cost_along(&self, start: Predicted, steps: &mut [Step], share: f64, cut: bool) -> f64 {
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

    /// Moves on by a step under `curvature`; what it costs.
    fn advance(&self, state: &mut Predicted, curvature: f64, turn: f64) -> f64 {
        let moved = curvature - state.commanded;
        state.commanded = curvature;
        *state = self.travel.after(state, turn, self.drift);
        self.move_cost * moved * moved + self.stage.of(state)
    }
}

impl Limits {
    /// Prepares the steps of a plan that starts from the curvature `commanded`; returns a length
    /// of move to measure rounding by.
    fn begin(&self, commanded: f64, turns: &[f64], steps: &mut [Step]) -> f64 {
        let range = self.high - self.low;
        let scale = if self.later < range {
            self.later
        } else {
            range
        };
        let rounding = scale * ROUNDING;
        let mut curvature = commanded;
        let (mut least, mut most) = self.first;
        for (step, &turn) in steps.iter_mut().zip(turns) {
            step.turn = turn;
            (step.least, step.most) = (least, most);
            (step.low, step.high) = (self.low, self.high);
            if curvature + least >= self.high - rounding {
                step.force(Side::Low);
                curvature += least;
            } else if curvature + most <= self.low + rounding {
                step.force(Side::High);
                curvature += most;
            } else {
                // From here on the limits can be kept.
                curvature = 0.5 * (self.low + self.high);
            }
            (least, most) = (-self.later, self.later);
        }
        scale
    }
}

fn plan(steps: &[Step], of: impl Fn(&Step) -> f64, passes: usize, cut_short: bool) -> Plan {
    let first = steps.first().copied().unwrap_or_default();
    let reached = match (first.held.rate, first.held.curvature) {
        (_, Side::Low | Side::High) => Reached::Curvature,
        (Side::Low | Side::High, _) => Reached::Rate,
        _ => Reached::Nothing,
    };
    let mut curvatures = [0.0; MAX_STEPS];
    for (curvature, step) in curvatures.iter_mut().zip(steps) {
        *curvature = of(step);
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
mod tests {
    use super::*;

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
        let start = Predicted {
            error: 1.0,
            heading: -0.2,
            driven: 0.0,
            commanded: 0.0,
        };
        let limits = Limits {
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
