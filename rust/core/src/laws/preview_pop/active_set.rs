//! The working set of [`limited`](super::limited): which limits each step of a plan is held at.
//!
//! A step makes the move `u` from the commanded curvature `before` to `c = before + u`, with
//! `least <= u <= most` and `low <= c <= high`. It may be *held* at one end of either range: the
//! inequality is then an equality.

use crate::laws::preview_pop::cost_to_go::{BestMove, ModelState};
use crate::vehicle::bicycle::MAX_STEPS;

/// The limits that a plan reaches, three bits a step, the first step the lowest. The search for the
/// next plan starts from them.
///
/// | bits | the step is at |
/// |---|---|
/// | 0 | no limit |
/// | 1, 2 | its least, its greatest move |
/// | 3, 4 | the least, the greatest curvature |
///
/// Of a step that is at a limit of the move and at one of the curvature, the first is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReachedLimits(pub u64);

// The bits of all steps fit.
const _: () = assert!(3 * MAX_STEPS <= 64);

impl ReachedLimits {
    /// The same limits one step later: the first step's are dropped.
    pub fn later(self) -> Self {
        Self(self.0 >> 3)
    }

    pub(super) fn of(steps: &[Step]) -> Self {
        let bits = steps.iter().rev().fold(0, |bits, step| {
            let code = match (step.held.rate, step.held.curvature) {
                (Side::Low, _) => 1,
                (Side::High, _) => 2,
                (_, Side::Low) => 3,
                (_, Side::High) => 4,
                _ => 0,
            };
            bits << 3 | code
        });
        Self(bits)
    }

    pub(super) fn hold(self, steps: &mut [Step]) {
        let mut bits = self.0;
        for step in steps {
            let none = Side::Neither;
            let (rate, curvature) = match bits & 7 {
                1 => (Side::Low, none),
                2 => (Side::High, none),
                3 => (none, Side::Low),
                4 => (none, Side::High),
                _ => (none, none),
            };
            step.held = Held { rate, curvature };
            bits >>= 3;
        }
    }
}

/// One end of a range, or none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Side {
    #[default]
    Neither,
    Low,
    High,
}

impl Side {
    /// The end of the range from `low` to `high` that `value` exceeds by more than `rounding`.
    fn exceeded(value: f64, low: f64, high: f64, rounding: f64) -> Self {
        if value > high + rounding {
            Self::High
        } else if value < low - rounding {
            Self::Low
        } else {
            Self::Neither
        }
    }

    /// Whether leaving this end, into the range, lowers a cost that has this `slope` there: whether
    /// the multiplier of the limit has the wrong sign. A slope within `tolerance` is 0.
    pub(super) fn should_release(self, slope: f64, tolerance: f64) -> bool {
        match self {
            Self::Neither => false,
            Self::Low => slope < -tolerance,
            Self::High => slope > tolerance,
        }
    }
}

/// The limits that a step is held at: of its move (the rate of the wheels), and of the curvature
/// after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Held {
    pub rate: Side,
    pub curvature: Side,
}

/// The limits of a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StepLimits {
    /// Least and greatest move [1/m].
    pub least: f64,
    pub most: f64,
    /// Least and greatest curvature after it [1/m].
    pub low: f64,
    pub high: f64,
    /// Whether the move is fixed, because it brings the curvature back into its limits.
    pub forced: bool,
}

/// What a plan does in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Choice {
    /// Curvature commanded after the move [1/m].
    pub curvature: f64,
    pub held: Held,
}

/// One step of a plan while it is searched for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Step {
    /// How far the path turns in it [rad].
    pub turn: f64,
    pub limits: StepLimits,
    /// The working set: what the backward recursion holds this step at.
    pub held: Held,
    /// The state before the move along the best plan so far.
    pub state: ModelState,
    /// The best move if this step is free and the later ones follow the working set.
    pub policy: BestMove,
    /// The curvature that the step has to lead to [1/m]: that of its own limit, or the one from
    /// which the held moves after it arrive at the limit of a later step.
    pub target: Option<f64>,
    /// In the best plan so far.
    pub best: Choice,
    /// In the plan of this pass.
    pub next: Choice,
    /// In a plan between the two.
    pub trial: Choice,
}

impl Step {
    /// Fixes the move at one end, as no move keeps the limits of the curvature: they do not apply
    /// here.
    pub(super) fn force(&mut self, side: Side) {
        self.limits.forced = true;
        self.held = Held {
            rate: side,
            curvature: Side::Neither,
        };
        (self.limits.low, self.limits.high) = (f64::NEG_INFINITY, f64::INFINITY);
    }

    /// The move that the step is held at, if it is.
    pub(super) fn held_move(&self) -> Option<f64> {
        match self.held.rate {
            Side::Neither => None,
            Side::Low => Some(self.limits.least),
            Side::High => Some(self.limits.most),
        }
    }

    /// The curvature that the step is held at, if it is.
    pub(super) fn held_curvature(&self) -> Option<f64> {
        match self.held.curvature {
            Side::Neither => None,
            Side::Low => Some(self.limits.low),
            Side::High => Some(self.limits.high),
        }
    }

    /// Corrects `next.held` by where `next` leads from the curvature `before`: a limit that is
    /// exceeded is held, and a curvature that the step does not arrive at is released. What is held
    /// besides mainly tells that the plan is not optimal: [`first_stop`] chooses what is added.
    pub(super) fn hold_exceeded(&mut self, before: f64, rounding: f64) {
        let limits = self.limits;
        if limits.forced {
            return;
        }
        let curvature = self.next.curvature;
        if self.next.held.rate == Side::Neither {
            let moved = curvature - before;
            self.next.held.rate = Side::exceeded(moved, limits.least, limits.most, rounding);
            if self.next.held.rate != Side::Neither {
                return;
            }
        }
        // By the working set: a limit that was just released is not held again.
        match self.held_curvature() {
            None => {
                let side = Side::exceeded(curvature, limits.low, limits.high, rounding);
                if side != Side::Neither {
                    // Some smaller move keeps the curvature, so the limit of the move is released.
                    self.next.held = Held {
                        rate: Side::Neither,
                        curvature: side,
                    };
                }
            }
            Some(end) if (curvature - end).abs() > rounding => {
                self.next.held.curvature = Side::Neither;
            }
            Some(_) => {}
        }
    }

    /// The curvature `wanted` after the curvature `before`, or the limit that it exceeds.
    pub(super) fn cut(&self, before: f64, wanted: f64) -> Choice {
        let limits = &self.limits;
        if let (true, Some(moved)) = (limits.forced, self.held_move()) {
            return Choice {
                curvature: before + moved,
                held: self.held,
            };
        }
        let at_rate = |rate| Held {
            rate,
            ..Held::default()
        };
        let at_curvature = |curvature| Held {
            curvature,
            ..Held::default()
        };
        // Of the two limits on each side, the tighter one.
        let (mut low, mut at_low) = (before + limits.least, at_rate(Side::Low));
        if low < limits.low {
            (low, at_low) = (limits.low, at_curvature(Side::Low));
        }
        let (mut high, mut at_high) = (before + limits.most, at_rate(Side::High));
        if high > limits.high {
            (high, at_high) = (limits.high, at_curvature(Side::High));
        }
        let (curvature, held) = if wanted > high {
            (high, at_high)
        } else if wanted < low {
            (low, at_low)
        } else {
            (wanted, Held::default())
        };
        Choice { curvature, held }
    }
}

/// The largest share, at most 1, of the way from the best plan to the next one that keeps all
/// limits; and the step whose limit ends it, with what that step is held at then. `start` is the
/// curvature before the first move.
pub(super) fn first_stop(
    start: f64,
    steps: &[Step],
    rounding: f64,
) -> (f64, Option<(usize, Held)>) {
    let mut first = (1.0, None);
    let (mut best_before, mut next_before) = (start, start);
    for (index, step) in steps.iter().enumerate() {
        let Held { rate, curvature } = step.held;
        let curvatures = (step.best.curvature, step.next.curvature);
        let moves = (curvatures.0 - best_before, curvatures.1 - next_before);
        (best_before, next_before) = curvatures;
        let limits = &step.limits;
        if limits.forced {
            continue;
        }
        let of_move = crossed(rate, moves, limits.least, limits.most, rounding);
        let of_curvature = crossed(curvature, curvatures, limits.low, limits.high, rounding);
        let stops = [
            of_move.map(|(share, rate)| (share, Held { rate, curvature })),
            of_curvature.map(|(share, curvature)| (share, Held { rate, curvature })),
        ];
        for (share, held) in stops.into_iter().flatten() {
            if share < first.0 {
                first = (share, Some((index, held)));
            }
        }
    }
    first
}

/// The share of the way `from` one number `to` another at which it crosses an end of the range from
/// `low` to `high`, and which end. None if no end is crossed, or if the number is `held` at one.
fn crossed(
    held: Side,
    (from, to): (f64, f64),
    low: f64,
    high: f64,
    rounding: f64,
) -> Option<(f64, Side)> {
    if held != Side::Neither {
        return None;
    }
    let (end, side) = if to > high + rounding && to - from > rounding {
        (high, Side::High)
    } else if to < low - rounding && from - to > rounding {
        (low, Side::Low)
    } else {
        return None;
    };
    let share = (end - from) / (to - from);
    Some((if share > 0.0 { share } else { 0.0 }, side))
}
