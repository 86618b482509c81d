//! The active set of [`limited`](super::limited).

use crate::laws::preview_pop::cost_to_go::{BestMove, ModelState};

/// The limits that a plan reaches, three bits a step. The search for the next plan starts from
/// them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReachedLimits(pub u64);

impl ReachedLimits {
    /// One step later.
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
    /// Whether what is held at this end would lower the cost by leaving it, where the cost rises
    /// with `slope`.
    pub(super) fn resists(self, slope: f64, least: f64) -> bool {
        match self {
            Self::Neither => false,
            Self::Low => slope < -least,
            Self::High => slope > least,
        }
    }
}

/// The limits that a step is held at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Held {
    pub rate: Side,
    pub curvature: Side,
}

/// One step of a plan while it is made.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Step {
    pub turn: f64,
    pub least: f64,
    pub most: f64,
    pub low: f64,
    pub high: f64,
    /// Whether the move is fixed, because the curvature is being brought back into its limits.
    pub forced: bool,
    pub held: Held,
    /// Before the move, along the best plan so far.
    pub state: ModelState,
    pub policy: BestMove,
    /// The curvature that the step has to lead to.
    pub target: Option<f64>,
    /// Curvature commanded in the best plan so far.
    pub best: f64,
    pub best_held: Held,
    /// Curvature commanded in the plan of this pass.
    pub next: f64,
    pub next_held: Held,
    /// Curvature commanded in a plan between the two.
    pub trial: f64,
    pub trial_held: Held,
}

impl Step {
    pub(super) fn force(&mut self, side: Side) {
        self.forced = true;
        self.held = Held {
            rate: side,
            curvature: Side::Neither,
        };
        (self.low, self.high) = (f64::NEG_INFINITY, f64::INFINITY);
    }

    pub(super) fn held_move(&self) -> Option<f64> {
        match self.held.rate {
            Side::Neither => None,
            Side::Low => Some(self.least),
            Side::High => Some(self.most),
        }
    }

    pub(super) fn held_curvature(&self) -> Option<f64> {
        match self.held.curvature {
            Side::Neither => None,
            Side::Low => Some(self.low),
            Side::High => Some(self.high),
        }
    }

    /// Holds a limit that the next plan exceeds, and not one that it cannot be brought to.
    pub(super) fn hold_exceeded(&mut self, before: f64, rounding: f64) {
        if self.forced {
            return;
        }
        let beyond = |value: f64, low: f64, high: f64| {
            if value > high + rounding {
                Side::High
            } else if value < low - rounding {
                Side::Low
            } else {
                Side::Neither
            }
        };
        if self.next_held.rate == Side::Neither {
            self.next_held.rate = beyond(self.next - before, self.least, self.most);
            if self.next_held.rate != Side::Neither {
                return;
            }
        }
        match self.held_curvature() {
            None => {
                let side = beyond(self.next, self.low, self.high);
                if side != Side::Neither {
                    // Less of the move keeps the curvature.
                    self.next_held = Held {
                        rate: Side::Neither,
                        curvature: side,
                    };
                }
            }
            Some(held) if (self.next - held).abs() > rounding => {
                self.next_held.curvature = Side::Neither;
            }
            Some(_) => {}
        }
    }

    /// The curvature `wanted` after `before`, or the limit that it exceeds, and which.
    pub(super) fn cut(&self, before: f64, wanted: f64) -> (f64, Held) {
        if let (true, Some(moved)) = (self.forced, self.held_move()) {
            return (before + moved, self.held);
        }
        let at_rate = |rate| Held {
            rate,
            ..Held::default()
        };
        let at_curvature = |curvature| Held {
            curvature,
            ..Held::default()
        };
        let (mut low, mut at_low) = (before + self.least, at_rate(Side::Low));
        if low < self.low {
            (low, at_low) = (self.low, at_curvature(Side::Low));
        }
        let (mut high, mut at_high) = (before + self.most, at_rate(Side::High));
        if high > self.high {
            (high, at_high) = (self.high, at_curvature(Side::High));
        }
        if wanted > high {
            (high, at_high)
        } else if wanted < low {
            (low, at_low)
        } else {
            (wanted, Held::default())
        }
    }
}

/// The share of the step from the best plan to the next one that keeps all limits; the step that
/// ends it, with what it is held at then.
pub(super) fn first_stop(
    start: f64,
    steps: &[Step],
    rounding: f64,
) -> (f64, Option<(usize, Held)>) {
    let mut first = (1.0, None);
    let (mut best_before, mut next_before) = (start, start);
    for (index, step) in steps.iter().enumerate() {
        let Held { rate, curvature } = step.held;
        let moves = (step.best - best_before, step.next - next_before);
        let curvatures = (step.best, step.next);
        (best_before, next_before) = curvatures;
        if step.forced {
            continue;
        }
        let of_move = crossed(rate, moves, step.least, step.most, rounding);
        let of_curvature = crossed(curvature, curvatures, step.low, step.high, rounding);
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

/// The share of the step between two numbers at which a limit is crossed, and which; none where
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
