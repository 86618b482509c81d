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
//! *pass* is one such recursion. The first passes change the whole set at once, as the moves cut
//! to their limits show it; where that does not lower the cost, one limit at a time is added, and
//! those that keep the cost up are released, as in the textbooks (Nocedal and Wright, *Numerical
//! Optimization*, section 16.5).

use super::cost_to_go::{BestMove, CostToGo, Predicted, Travel};
use crate::vehicle::bicycle::MAX_STEPS;

/// The most passes of a plan; after them the best plan so far is taken.
pub const MAX_PASSES: usize = 40;

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

/// How a plan begins, and how it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Curvature that is commanded after the first move [1/m].
    pub curvature: f64,
    /// The limit that the first move reaches.
    pub reached: Reached,
    /// Backward recursions taken.
    pub passes: usize,
    /// Whether the passes ran out: the plan keeps the limits but is not the best.
    pub cut_short: bool,
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
    #[inline(never)]
    pub fn limited(&self, start: Predicted, limits: &Limits) -> Plan {
        let mut steps = [Step::default(); MAX_STEPS];
        let steps = steps.get_mut(..self.turns.len()).unwrap_or_default();
        let scale = limits.begin(start.commanded, self.turns, steps);
        let mut best_cost = f64::INFINITY;
        for pass in 1..=MAX_PASSES {
            self.recur(steps);
            let cost = self.roll_cut(start, steps);
            if steps.iter().all(|step| step.next_held == step.held) {
                return plan(steps, |step| step.next, pass, false);
            }
            if cost < best_cost * (1.0 - SAME_COST) {
                best_cost = cost;
                for step in steps.iter_mut() {
                    step.best = step.next;
                    step.held = step.next_held;
                }
                continue;
            }
            let right = self.roll_held(start, steps, scale * ROUNDING);
            let cut = stop(start.commanded, steps, scale * ROUNDING);
            if right && cut.is_none() {
                return plan(steps, |step| step.next, pass, false);
            }
            let share = cut.as_ref().map_or(1.0, |cut| cut.share);
            for step in steps.iter_mut() {
                step.best += share * (step.next - step.best);
            }
            if let Some(cut) = cut {
                if let Some(step) = steps.get_mut(cut.step) {
                    step.held = cut.held;
                }
            } else {
                for step in steps.iter_mut() {
                    step.held = step.next_held;
                }
            }
            best_cost = self.cost_of_best(start, steps);
        }
        plan(steps, |step| step.best, MAX_PASSES, true)
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
            step.cut(state.commanded, wanted);
            cost += self.advance(&mut state, step.next, step.turn);
        }
        cost
    }

    /// Forward: the best moves where some are held, without a look at other limits. Whether all
    /// limits that are held keep the cost down; those that keep it up are not in `next_held`.
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
            right &= step.next_held == step.held;
            self.advance(&mut state, step.next, step.turn);
        }
        right
    }

    /// The cost of the best plan so far.
    fn cost_of_best(&self, start: Predicted, steps: &[Step]) -> f64 {
        let mut state = start;
        let mut cost = 0.0;
        for step in steps {
            cost += self.advance(&mut state, step.best, step.turn);
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

/// One end of a range, or none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Side {
    #[default]
    Neither,
    Low,
    High,
}

impl Side {
    /// Whether what is held at this end would lower the cost by leaving it, where the cost rises
    /// with `slope`.
    fn resists(self, slope: f64, least: f64) -> bool {
        match self {
            Self::Neither => false,
            Self::Low => slope < -least,
            Self::High => slope > least,
        }
    }
}

/// The limits that a step is held at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Held {
    rate: Side,
    curvature: Side,
}

/// One step of a plan while it is made.
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    turn: f64,
    least: f64,
    most: f64,
    low: f64,
    high: f64,
    /// Whether the move is given: the curvature is on its way back into its limits.
    forced: bool,
    held: Held,
    policy: BestMove,
    /// The curvature that the step has to lead to.
    target: Option<f64>,
    /// Curvature commanded in the best plan so far.
    best: f64,
    /// Curvature commanded in the plan of this pass.
    next: f64,
    next_held: Held,
}

impl Step {
    fn force(&mut self, side: Side) {
        self.forced = true;
        self.held.rate = side;
        (self.low, self.high) = (f64::NEG_INFINITY, f64::INFINITY);
    }

    fn held_move(&self) -> Option<f64> {
        match self.held.rate {
            Side::Neither => None,
            Side::Low => Some(self.least),
            Side::High => Some(self.most),
        }
    }

    fn held_curvature(&self) -> Option<f64> {
        match self.held.curvature {
            Side::Neither => None,
            Side::Low => Some(self.low),
            Side::High => Some(self.high),
        }
    }

    /// Takes the curvature `wanted` after `before`, or the limit that it exceeds.
    fn cut(&mut self, before: f64, wanted: f64) {
        if let (true, Some(moved)) = (self.forced, self.held_move()) {
            self.next = before + moved;
            self.next_held = self.held;
            return;
        }
        let none = Side::Neither;
        let (mut low, mut at_low) = (before + self.least, (Side::Low, none));
        if low < self.low {
            (low, at_low) = (self.low, (none, Side::Low));
        }
        let (mut high, mut at_high) = (before + self.most, (Side::High, none));
        if high > self.high {
            (high, at_high) = (self.high, (none, Side::High));
        }
        let (next, (rate, curvature)) = if wanted > high {
            (high, at_high)
        } else if wanted < low {
            (low, at_low)
        } else {
            (wanted, (none, none))
        };
        self.next = next;
        self.next_held = Held { rate, curvature };
    }
}

/// Where the way from the best plan to the next one ends: at a limit that is not held yet.
struct Cut {
    share: f64,
    step: usize,
    held: Held,
}

/// The first limit on the way from the best plan to the next one; none if it keeps all.
fn stop(start: f64, steps: &[Step], rounding: f64) -> Option<Cut> {
    let mut first: Option<Cut> = None;
    let (mut best_before, mut next_before) = (start, start);
    for (index, step) in steps.iter().enumerate() {
        let Held { rate, curvature } = step.held;
        let moves = (step.best - best_before, step.next - next_before);
        (best_before, next_before) = (step.best, step.next);
        if step.forced {
            continue;
        }
        let of_move = crossed(rate, moves, step.least, step.most, rounding);
        let of_curvature = crossed(
            curvature,
            (step.best, step.next),
            step.low,
            step.high,
            rounding,
        );
        let shares = [
            of_move.map(|(share, rate)| (share, Held { rate, curvature })),
            of_curvature.map(|(share, curvature)| (share, Held { rate, curvature })),
        ];
        for (share, held) in shares.into_iter().flatten() {
            if first.as_ref().is_none_or(|cut| share < cut.share) {
                first = Some(Cut {
                    share,
                    step: index,
                    held,
                });
            }
        }
    }
    first
}

/// The share of the way between two numbers at which a limit is crossed, and which; none where
/// it is `held`, or not crossed.
fn crossed(held: Side, way: (f64, f64), low: f64, high: f64, rounding: f64) -> Option<(f64, Side)> {
    let (from, to) = way;
    if held != Side::Neither {
        return None;
    }
    let (limit, side) = if to > high + rounding && to - from > rounding {
        (high, Side::High)
    } else if to < low - rounding && from - to > rounding {
        (low, Side::Low)
    } else {
        return None;
    };
    let share = (limit - from) / (to - from);
    Some((if share > 0.0 { share } else { 0.0 }, side))
}

fn plan(steps: &[Step], of: impl Fn(&Step) -> f64, passes: usize, cut_short: bool) -> Plan {
    let first = steps.first().copied().unwrap_or_default();
    let reached = match (first.held.rate, first.held.curvature) {
        (_, Side::Low | Side::High) => Reached::Curvature,
        (Side::Low | Side::High, _) => Reached::Rate,
        _ => Reached::Nothing,
    };
    Plan {
        curvature: of(&first),
        reached,
        passes,
        cut_short,
    }
}
