use super::*;
use crate::math::sin;

const DT: f64 = 0.05;
/// Turn by a radian of steering offset [1/s].
const SHARE: f64 = 3.0;

fn at(rate: f64, share: f64) -> Expected {
    Expected {
        rate,
        share,
        dt: DT,
    }
}

/// An estimator to which gain and offset are known, or nothing.
fn knowing(gain: f64, offset: f64, deviation: f64) -> Estimator {
    let mut estimator = Estimator::default();
    estimator.estimate.gain = gain;
    estimator.estimate.steer_offset = offset;
    estimator.gain_deviation = deviation;
    estimator.turning.covariance *= 0.0;
    estimator
}

/// How many of 200 steps at 8 m/s alarm, in which the vehicle turns by `turn` of what is expected.
fn alarms(estimator: Option<&Estimator>, turn: impl Fn(u32, f64) -> f64) -> usize {
    let mut state = MonitorState::settled(0.0);
    let alarm = |k: u32| {
        let rate = 0.3 * sin(0.1 * f64::from(k));
        state.observe(turn(k, rate * DT), at(rate, SHARE), 0.01, estimator)
    };
    (0..200).map(alarm).filter(|alarm| *alarm).count()
}

#[test]
fn test_turns_of_another_gain_are_explained_and_other_turns_are_not() {
    for gain in [0.45, 1.0, 2.4] {
        assert_eq!(alarms(None, |_, expected| gain * expected), 0, "{gain}");
    }
    for gain in [-1.0, -0.5, 4.0] {
        assert!(alarms(None, |_, expected| gain * expected) > 1, "{gain}");
    }
    let known = knowing(1.2, 0.0, 0.0);
    for (gain, alarm) in [
        (1.0, false),
        (1.2, false),
        (1.4, false),
        (0.5, true),
        (2.2, true),
    ] {
        let found = alarms(Some(&known), |_, expected| gain * expected) > 0;
        assert_eq!(found, alarm, "{gain}");
    }
}

#[test]
fn test_white_noise_is_measured_and_let_pass() {
    // Not white, but as large as noise of 0.02 rad gets at each step.
    let yaw = |k: u32| 0.02 * sin(2.4 * f64::from(k * k));
    assert_eq!(
        alarms(None, |k, expected| expected + yaw(k + 1) - yaw(k)),
        0
    );
}

/// A period's explained rates, and of the mirror image and backwards.
fn check_explained(state: &MonitorState, rate: f64, estimator: Option<&Estimator>, to: (f64, f64)) {
    let found = state.explained(rate, SHARE, estimator);
    let close = |(least, most): (f64, f64), (a, b): (f64, f64)| {
        (least - a).abs() < 1e-12 && (most - b).abs() < 1e-12
    };
    assert!(close(found, to), "{found:?}, not {to:?}");
    let [gain, (offset, doubt)] = state.known;
    let mirrored = MonitorState {
        rates: (-state.rates.1, -state.rates.0),
        known: [gain, (-offset, doubt)],
        ..*state
    };
    let found = mirrored.explained(-rate, SHARE, estimator);
    assert!(close(found, (-to.1, -to.0)), "mirrored: {found:?}");
    let backwards = MonitorState {
        rates: (-state.rates.1, -state.rates.0),
        ..*state
    };
    let found = backwards.explained(-rate, -SHARE, estimator);
    assert!(close(found, (-to.1, -to.0)), "backwards: {found:?}");
}

/// A turn between 0.4 and 2.5 of what is expected is explained with an offset of 2 degrees, where the
/// wheels may lag or be quicker.
#[test]
fn test_what_nobody_estimates_is_explained_by_all_gains_and_a_lasting_offset() {
    let aside = 0.035 * SHARE;
    let (rate, slow) = (0.3, 0.2);
    let state = MonitorState {
        rates: (slow, rate),
        ..MonitorState::settled(0.0)
    };
    let quicker = rate + 0.3 * (rate - slow);
    check_explained(
        &state,
        rate,
        None,
        (0.4 * (slow - aside), 2.5 * quicker + aside),
    );
    // An offset acts alone against a turn that it outweighs: its gain is in it.
    let state = MonitorState {
        rates: (0.02, 0.02),
        ..state
    };
    check_explained(&state, 0.02, None, (0.02 - aside, 2.5 * 0.02 + aside));
}

#[test]
fn test_what_is_estimated_is_explained_by_that_its_doubt_play_and_what_was_told() {
    let estimator = Estimator::default();
    let state = MonitorState {
        rates: (0.3, 0.3),
        known: [(1.2, 0.06), (0.02, 0.01)],
        ..MonitorState::settled(0.0)
    };
    let (low, high) = (
        1.0_f64.min(1.2 - 0.06 - 0.15 * 1.2),
        1.2 + 0.06 + 0.15 * 1.2,
    );
    let (right, left) = (-0.01 - 0.012, 0.02 + 0.01 + 0.012);
    let expected = (low * (0.3 + right * SHARE), high * 0.3 + left * SHARE);
    check_explained(&state, 0.3, Some(&estimator), expected);
    // What is unknown of an offset turns no vehicle faster than 0.25 rad/s.
    let unknown = MonitorState {
        known: [(1.0, 0.0), (0.0, 0.15)],
        ..state
    };
    let aside = 0.25 + 0.012 * SHARE;
    let expected = (0.85 * (0.3 - aside), 1.15 * 0.3 + aside);
    check_explained(&unknown, 0.3, Some(&estimator), expected);
}

/// A dead time that was found longer or shorter may still be the one that was told.
#[test]
fn test_a_found_dead_time_may_be_the_one_told() {
    let mut estimator = Estimator::default();
    let aside = 0.012 * SHARE;
    for (later, slower, quicker) in [(0.0, 0.2, 0.33), (0.1, 0.1, 0.43), (-0.05, 0.15, 0.33)] {
        estimator.estimate.longer_dead_time = later;
        let state = MonitorState {
            rates: (slower, 0.3),
            later: f64::abs(later),
            known: [(1.0, 0.0), (0.0, 0.0)],
            ..MonitorState::settled(0.0)
        };
        let to = (0.85 * (slower - aside), 1.15 * quicker + aside);
        check_explained(&state, 0.3, Some(&estimator), to);
    }
}

/// Play turns wheels that go to and fro later, or not: whatever the period, a turn of which the rate was
/// expected within the believed dead time is explained.
#[test]
fn test_turns_to_and_fro_are_explained_within_the_believed_dead_time() {
    let mut estimator = Estimator::default();
    estimator.estimate.longer_dead_time = 0.2;
    for period in [0.3, 0.5, 0.9] {
        let rate = |k: u32| 1.5 * sin(core::f64::consts::TAU * f64::from(k) * DT / period);
        for late in 0..=4 {
            let mut state = MonitorState::settled(0.0);
            let mut found = 0;
            for k in 0..400 {
                let turn = DT * rate(k + 4 - late);
                let alarm = state.observe(turn, at(rate(k + 4), SHARE), 0.01, Some(&estimator));
                found += u32::from(alarm && k > 200);
            }
            assert_eq!(found, 0, "{period} {late}");
        }
    }
}

#[test]
fn test_estimates_come_to_be_believed_in_their_time_alone() {
    let estimator = knowing(1.3, 0.1, 0.02);
    let mut state = MonitorState::settled(0.0);
    let before = state.known;
    assert_eq!(before[1].0, 0.0);
    state.observe(0.0, at(0.0, SHARE), 0.01, Some(&estimator));
    let share = DT / (1.5 + DT);
    assert!((state.known[1].0 - 0.1 * share).abs() < 1e-15, "{state:?}");
    for _ in 0..2000 {
        state.observe(0.0, at(0.0, SHARE), 0.01, Some(&estimator));
    }
    let expected = [(1.3, 0.06), (0.1, 0.0)];
    for (found, expected) in state.known.iter().zip(expected) {
        assert!((found.0 - expected.0).abs() < 1e-9, "{state:?}");
        assert!((found.1 - expected.1).abs() < 1e-9, "{state:?}");
    }
}

#[test]
fn test_turning_rates_are_means_over_their_times() {
    let mut state = MonitorState::settled(0.0);
    for _ in 0..20_000 {
        state.observe(0.02, at(0.3, SHARE), 0.01, None);
    }
    assert!((state.yaw_rate - 0.4).abs() < 1e-9, "{state:?}");
    let (least, most) = state.rates;
    assert!(
        (least - 0.3).abs() < 1e-9 && (most - 0.3).abs() < 1e-9,
        "{state:?}"
    );
    assert!(state.noise.deviation() < 1e-9, "{state:?}");
}

#[test]
fn test_an_interrupted_turn_counts_no_more() {
    let mut state = MonitorState::settled(0.0);
    for _ in 0..4 {
        assert!(!state.observe(0.05, at(0.0, SHARE), 1.0, None));
    }
    assert!(state.turned.over > 0.1, "{state:?}");
    state.interrupt();
    assert_eq!(state.turned, Cusum::default());
    assert!(state.yaw.is_none() && state.noise.last.is_none());
}
