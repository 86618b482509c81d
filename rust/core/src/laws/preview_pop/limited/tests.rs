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

/// What the first moves of a plan cost, with what they lead to.
fn cost_of(horizon: &Horizon<'_>, start: ModelState, plan: &Plan) -> f64 {
    let mut state = start;
    let moves = plan.curvatures.iter().zip(horizon.turns);
    moves
        .map(|(&curvature, &turn)| horizon.advance(&mut state, curvature, turn))
        .sum()
}

#[test]
fn test_plan_of_more_passes_never_costs_more_also_where_limits_coincide() {
    let bends: [f64; 20] = core::array::from_fn(|k| if k % 7 < 3 { 0.08 } else { -0.05 });
    let (mut unchanged, mut cut_short) = (0, 0);
    for (n, turns) in [[0.0; 20], bends].iter().enumerate() {
        for move_cost in [1e-3, 1.0, 150.0] {
            for lag in [0.3, 1.2, 4.0] {
                let horizon = Horizon {
                    travel: Travel::new(0.8, lag, crate::math::decay(0.8, lag), 0.0),
                    stage: CostToGo::stage(2.7, 0.0),
                    move_cost,
                    turns,
                };
                // The curvature begins at its limit, a move spans the whole range, or the first
                // move has no freedom at all: limits that coincide.
                for (commanded, first, later) in [
                    (0.03, (-0.004, 0.004), 0.004),
                    (-0.03, (-0.01, 0.0), 0.06),
                    (0.03, (0.0, 0.0), 0.02),
                    (0.02, (-0.05, 0.01), 0.01),
                ] {
                    let start = ModelState {
                        error: if n == 0 { 1.0 } else { -0.4 },
                        heading: -0.2,
                        driven: 0.01,
                        commanded,
                    };
                    let limits = PlanLimits {
                        first,
                        later,
                        low: -0.03,
                        high: 0.03,
                    };
                    let mut before = f64::INFINITY;
                    // From a guess that is wrong everywhere, too.
                    for guess in [0, 0o1_1111_1111_1111_1111, 0o4_2314_2314_2314] {
                        for passes in 1..=MAX_PASSES {
                            let guess = ReachedLimits(guess);
                            let plan = horizon.limited_in(passes, start, &limits, guess);
                            let cost = cost_of(&horizon, start, &plan);
                            if passes > 1 {
                                assert!(cost <= before * (1.0 + 1e-10), "{cost} {before}");
                                unchanged += usize::from(plan.cut_short && cost >= before);
                            }
                            before = cost;
                            if !plan.cut_short {
                                break;
                            }
                            cut_short += usize::from(passes == MAX_PASSES);
                        }
                    }
                }
            }
        }
    }
    assert!(unchanged > 0 && cut_short == 0, "{unchanged} {cut_short}");
}
