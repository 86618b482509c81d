//! The plan within limits against the quadratic program that it solves, written out densely.
#![expect(clippy::print_stdout, reason = "figures are shown by --nocapture")]

mod dense;
#[path = "limited/instance.rs"]
mod instance;

use instance::{Instance, Random};
use popsteer_core::laws::preview_pop::cost_to_go::{BestMove, ModelState};
use popsteer_core::laws::preview_pop::limited::{MAX_PASSES, MoveLimit, PlanLimits, ReachedLimits};

#[test]
fn test_plan_meets_the_conditions_of_optimality_on_20000_random_instances() {
    let mut random = Random(11);
    let mut passes = [0_usize; MAX_PASSES + 1];
    let (mut worst, mut guessed) = (0.0_f64, ReachedLimits::default());
    let mut cut_short = 0;
    for n in 0..20_000 {
        let instance = Instance::random(&mut random);
        let horizon = instance.horizon();
        let plan = horizon.limited(instance.start, &instance.limits, ReachedLimits::default());
        passes[plan.passes] += 1;
        // Any guess leads to the same plan, this one to that of another instance.
        let again = horizon.limited(instance.start, &instance.limits, guessed);
        for plan in [plan, again] {
            let residual = instance.residual(&plan);
            if plan.cut_short {
                println!("{n}: cut short {residual:e}");
                cut_short += 1;
                continue;
            }
            assert!(residual < 1e-8, "{n}: {residual} {plan:?}");
            worst = worst.max(residual);
        }
        let error = (again.first() - plan.first()).abs();
        assert!(
            plan.cut_short || again.cut_short || error < 1e-9 * instance.scale(),
            "{n}: {error}"
        );
        guessed = plan.limits;
    }
    assert!(cut_short < 8, "{cut_short}");
    println!("residual {worst:e}, cut short {cut_short}, passes {passes:?}");
}

#[test]
fn test_first_move_is_that_of_interior_points_on_1000_random_instances() {
    let mut random = Random(12);
    let mut worst = 0.0_f64;
    for n in 0..1000 {
        let instance = Instance::random(&mut random);
        let none = ReachedLimits::default();
        let plan = instance
            .horizon()
            .limited(instance.start, &instance.limits, none);
        let best = instance.by_interior_points();
        let error = (plan.first() - instance.start.commanded - best[0]).abs();
        assert!(instance.length * error < 1e-6, "{n}: {error} {plan:?}");
        worst = worst.max(instance.length * error);
    }
    println!("first move within {worst:e} rad");
}

/// Wheels that turn at their rate and then land at a limit of the curvature: the moves before it are held
/// one by one, and their multipliers are apart from that of the landing. From guesses that hold what the
/// plan does not, too.
#[test]
fn test_moves_at_their_rate_that_land_at_a_limit_are_those_of_the_exact_program() {
    let mut random = Random(16);
    let (mut landed, mut cut_short, mut passes) = (0, 0, 0);
    for n in 0..4000 {
        let mut instance = Instance::random(&mut random);
        instance.turns.resize(20, 0.0);
        let moves = random.uniform(2.0, 9.0);
        let side = random.of(&[-1.0, 1.0]);
        let limits = &mut instance.limits;
        limits.later *= 0.3;
        limits.first = (-limits.later, limits.later);
        let reach = moves * limits.later;
        (limits.low, limits.high) = (-reach, reach);
        instance.start.commanded = random.uniform(-0.5, 0.5) * reach;
        instance.start.driven = instance.start.commanded;
        instance.start.error = side * random.uniform(0.1, 4.0) * instance.length;
        let horizon = instance.horizon();
        // No guess, all moves at their least, at their greatest, and by turns with the curvature's.
        for guess in [
            0,
            0o1_1111_1111_1111_1111_1111,
            0o2_2222_2222_2222_2222_2222,
            0o4_2214_2231_1324,
        ] {
            let plan = horizon.limited(instance.start, &instance.limits, ReachedLimits(guess));
            passes += plan.passes;
            if plan.cut_short {
                cut_short += 1;
                continue;
            }
            let residual = instance.residual(&plan);
            assert!(residual < 1e-8, "{n} {guess:o}: {residual} {plan:?}");
            // Two moves at the rate, and then the limit of the curvature.
            let codes: Vec<u64> = (0..20).map(|k| plan.limits.0 >> (3 * k) & 7).collect();
            let lands = |w: &[u64]| matches!(w, [1 | 2, 1 | 2, 3 | 4, ..]);
            landed += usize::from(codes.windows(3).any(lands));
        }
    }
    println!("{landed} of 16000 land, {passes} passes, {cut_short} cut short");
    assert!(landed > 10_000 && cut_short <= 16, "{landed} {cut_short}");
}

#[test]
fn test_plan_within_limits_that_do_not_bind_is_the_unlimited_one() {
    let mut random = Random(13);
    for _ in 0..1000 {
        let mut instance = Instance::random(&mut random);
        instance.limits = PlanLimits {
            first: (-1e6, 1e6),
            later: 1e6,
            low: -1e6,
            high: 1e6,
        };
        let horizon = instance.horizon();
        let mut moves = [BestMove::default(); 20];
        horizon.unlimited(&mut moves);
        assert!(horizon.keeps(&moves, instance.start, &instance.limits));
        let none = ReachedLimits::default();
        let plan = horizon.limited(instance.start, &instance.limits, none);
        assert_eq!(
            plan.first().to_bits(),
            moves[0].commanded(&instance.start).to_bits()
        );
        assert_eq!((plan.passes, plan.reached), (1, MoveLimit::Nothing));
    }
}

#[test]
fn test_plan_from_beyond_the_limit_unwinds_at_the_full_rate() {
    let mut random = Random(14);
    for _ in 0..1000 {
        let mut instance = Instance::random(&mut random);
        let (least, most) = instance.limits.first;
        let later = instance.limits.later;
        let side = random.of(&[-1.0, 1.0]);
        let past = random.uniform(0.0, 5.0) * later;
        let end = if side > 0.0 {
            instance.limits.high
        } else {
            instance.limits.low
        };
        instance.start.commanded = end + side * past;
        let plan =
            instance
                .horizon()
                .limited(instance.start, &instance.limits, ReachedLimits::default());
        let mut before = instance.start.commanded;
        for (k, &next) in plan
            .curvatures
            .iter()
            .take(instance.turns.len())
            .enumerate()
        {
            let back = match (k, side > 0.0) {
                (0, true) => least,
                (0, false) => most,
                _ => -side * later,
            };
            if side * (before + back - end) < 0.0 {
                break;
            }
            assert!((next - before - back).abs() < 1e-9 * later, "{plan:?}");
            before = next;
        }
    }
}

#[test]
fn test_plan_in_a_noisy_loop_takes_more_than_12_passes_in_a_thousandth_of_the_steps() {
    let mut random = Random(15);
    let mut passes = [0_u32; MAX_PASSES + 1];
    for n in 0..2000 {
        let mut instance = Instance::random(&mut random);
        instance.turns = vec![0.0; 20];
        // A localisation that is wrong by 0.1 m and 0.005 rad, on every other run.
        let noise = if n % 2 == 0 { 0.0 } else { 1.0 };
        let away =
            |random: &mut Random| (0..12).map(|_| random.uniform(-0.5, 0.5)).sum::<f64>() * noise;
        let mut guess = ReachedLimits::default();
        let mut truth = instance.start;
        for _ in 0..100 {
            instance.start = ModelState {
                error: truth.error + 0.1 * instance.length / 2.7 * away(&mut random),
                heading: truth.heading + 0.005 * away(&mut random),
                ..truth
            };
            let horizon = instance.horizon();
            let mut moves = [BestMove::default(); 20];
            horizon.unlimited(&mut moves);
            let (least, most) = instance.limits.first;
            let mut next = moves[0].commanded(&instance.start);
            let moved = next - truth.commanded;
            let kept = (least..=most).contains(&moved)
                && horizon.keeps(&moves, instance.start, &instance.limits);
            if kept {
                guess = ReachedLimits::default();
            } else {
                let plan = horizon.limited(instance.start, &instance.limits, guess);
                passes[plan.passes] += 1;
                guess = plan.limits.later();
                next = plan.first();
            }
            truth.commanded = next;
            truth = instance.travel.after(&truth, 0.0);
        }
    }
    let all: u32 = passes.iter().sum();
    let many: u32 = passes.iter().skip(13).sum();
    println!("{many} of {all} plans in more than 12 passes: {passes:?}");
    assert!(all > 10_000 && f64::from(many) <= 1e-3 * f64::from(all));
}
