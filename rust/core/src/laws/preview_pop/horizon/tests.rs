use super::*;

/// `keeps` carries the state in parts; the plain prediction says where the limits lie that it
/// keeps.
fn check_kept(horizon: &Horizon<'_>, start: ModelState) {
    let mut moves = [BestMove::default(); MAX_STEPS];
    let (moves, _) = moves.split_at_mut(horizon.turns.len());
    horizon.unlimited(moves);
    let mut state = start;
    let (mut low, mut high, mut most) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for (k, (best, &turn)) in moves.iter().zip(horizon.turns).enumerate() {
        let next = best.commanded(&state);
        if k > 0 {
            most = f64::max(most, (next - state.commanded).abs());
        }
        (low, high) = (low.min(next), high.max(next));
        state.commanded = next;
        state = horizon.travel.after(&state, turn);
    }
    let slack = 1e-9 * (low.abs() + high.abs() + most);
    let wide = PlanLimits {
        first: (0.0, 0.0),
        later: most + slack,
        low: low - slack,
        high: high + slack,
    };
    let lower = PlanLimits {
        high: high - slack,
        ..wide
    };
    let higher = PlanLimits {
        low: low + slack,
        ..wide
    };
    let slower = PlanLimits {
        later: most - slack,
        ..wide
    };
    let keeps = |limits| horizon.keeps(moves, start, &limits);
    assert!(keeps(wide));
    assert!(!keeps(lower) && !keeps(higher) && !keeps(slower));
}

#[test]
fn test_plan_keeps_limits_as_far_as_its_plain_prediction_needs() {
    let bends = [0.02, 0.0, -0.01, -0.03, 0.0, 0.05, 0.02, 0.0];
    for (lag, kept) in [(0.0, 0.0), (0.8, crate::math::decay(0.5, 0.8))] {
        for offset in [0.0, 0.4] {
            for (error, heading, driven) in [(0.5, 0.1, 0.02), (-1.0, 0.2, 0.0)] {
                let horizon = Horizon {
                    travel: Travel::new(0.5, lag, kept, offset),
                    stage: CostToGo::stage(2.7, offset),
                    move_cost: 12.0,
                    turns: &bends,
                };
                let start = ModelState {
                    error,
                    heading,
                    driven,
                    commanded: 0.05,
                };
                check_kept(&horizon, start);
            }
        }
    }
}
