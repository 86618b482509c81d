//! The plan of preview POP within its limits.

use crate::bytes::Bytes;
use popsteer_core::laws::preview_pop::cost_to_go::{BestMove, CostToGo, ModelState, Travel};
use popsteer_core::laws::preview_pop::limited::{
    Horizon, MAX_PASSES, Plan, PlanLimits, ReachedLimits,
};
use popsteer_core::vehicle::bicycle::MAX_STEPS;

/// One vehicle, planned for from a few states.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let length = bytes.within(0.2, 10.0);
    let step = length * bytes.within(0.01, 1.0);
    let lag = length * bytes.within(0.0, 4.0);
    let kept = if lag > 0.0 {
        f64::exp(-step / lag)
    } else {
        0.0
    };
    let offset = length * bytes.within(-0.3, 0.3);
    let cost = length * length * bytes.within(0.2, 20.0);
    let bend = bytes.within(-0.3, 0.3) * step / length;
    let (count, from) = (1 + bytes.below(MAX_STEPS), bytes.below(MAX_STEPS));
    let turns: Vec<f64> = (0..count)
        .map(|k| if k < from { 0.0 } else { bend })
        .collect();
    let horizon = Horizon {
        travel: Travel::new(step, lag, kept, offset),
        stage: CostToGo::stage(length, offset),
        move_cost: cost * cost,
        turns: &turns,
    };
    let mut guess = ReachedLimits::default();
    for _ in 0..4 {
        let later = bytes.within(0.001, 0.3) / length;
        let limits = PlanLimits {
            first: (
                -later * bytes.within(0.0, 1.0),
                later * bytes.within(0.0, 1.0),
            ),
            later,
            low: -bytes.within(0.001, 0.7) / length,
            high: bytes.within(0.001, 0.7) / length,
        };
        let start = ModelState {
            error: length * bytes.within(-3.0, 3.0),
            heading: bytes.within(-1.0, 1.0),
            driven: bytes.within(-0.7, 0.7) / length,
            commanded: bytes.within(-0.7, 0.7) / length,
        };
        let plan = horizon.limited(start, &limits, guess);
        check_plan(&plan, &limits, start.commanded, count);
        let cold = horizon.limited(start, &limits, ReachedLimits::default());
        check_plan(&cold, &limits, start.commanded, count);
        // A guess changes the count of passes alone.
        let scale = later.min(limits.high - limits.low);
        assert!(
            plan.cut_short || cold.cut_short || (plan.first() - cold.first()).abs() <= 1e-6 * scale
        );
        let mut moves = [BestMove::default(); MAX_STEPS];
        let _ = horizon.unlimited(&mut moves[..count]);
        let first = moves[0].commanded(&start);
        let within =
            limits.first.0 <= first - start.commanded && first - start.commanded <= limits.first.1;
        if within && horizon.keeps(&moves[..count], start, &limits) {
            assert!((cold.first() - first).abs() <= 1e-6 * scale);
        }
        // Whatever bits a caller hands in, no plan suffers.
        guess = if bytes.byte() < 128 {
            plan.limits.later()
        } else {
            let mut bits = [0; 8];
            bits.fill_with(|| bytes.byte());
            ReachedLimits(u64::from_le_bytes(bits))
        };
        if bytes.is_empty() {
            break;
        }
    }
}

/// Moves within their limits, curvatures within theirs or on their way there.
fn check_plan(plan: &Plan, limits: &PlanLimits, commanded: f64, count: usize) {
    assert!(plan.passes <= MAX_PASSES && plan.cut_short <= (plan.passes == MAX_PASSES));
    assert!(plan.curvatures.iter().all(|each| each.is_finite()));
    let scale = limits.later.min(limits.high - limits.low);
    let rounding = 1e-9 * scale.max(commanded.abs());
    let (mut least, mut most) = (commanded, commanded);
    let mut before = commanded;
    for (k, &next) in plan.curvatures.iter().take(count).enumerate() {
        let ends = if k == 0 {
            limits.first
        } else {
            (-limits.later, limits.later)
        };
        least += ends.0;
        most += ends.1;
        assert!(ends.0 - rounding <= next - before && next - before <= ends.1 + rounding);
        assert!(limits.low.min(most) - rounding <= next);
        assert!(next <= limits.high.max(least) + rounding);
        before = next;
    }
}
