use super::*;

const GAINS: (f64, f64) = Estimator::GAINS;

/// Steps of 0.05 s at 8 m/s, in which the vehicle turns by `turn` of what is expected.
fn beyond(steps: u32, turn: impl Fn(u32, f64) -> f64) -> f64 {
    let mut state = MonitorState::settled(0.0);
    let mut most = f64::NEG_INFINITY;
    for k in 0..steps {
        let rate = 0.3 * crate::math::sin(0.1 * f64::from(k));
        state.observe(turn(k, rate * 0.05), rate, 0.0, 3.0, 0.05);
        let beyond = state.unexplained_by(3.0, None);
        assert_eq!(state.is_beyond(0.01, 3.0, None), beyond > 0.01, "{state:?}");
        if state.time >= MonitorState::LEAST_TIME && beyond > most {
            most = beyond;
        }
    }
    most
}

#[test]
fn test_turns_of_another_gain_are_explained_and_other_turns_are_not() {
    for gain in [0.45, 1.0, 2.4] {
        assert!(beyond(200, |_, expected| gain * expected) < 0.0, "{gain}");
    }
    for gain in [-1.0, 0.0, 4.0] {
        assert!(beyond(200, |_, expected| gain * expected) > 0.02, "{gain}");
    }
}

#[test]
fn test_a_steering_offset_is_explained_also_at_rest_after_driving_either_way() {
    for share in [3.0, -3.0] {
        let mut state = MonitorState::settled(0.0);
        for _ in 0..100 {
            state.observe(0.03 * share * 0.05, 0.0, 0.0, share, 0.05);
        }
        assert!(state.measured.abs() > 0.08);
        state.observe(0.0, 0.0, 0.0, 0.0 * share, 0.05);
        assert!(!state.is_beyond(0.01, 0.0, None), "{share}: {state:?}");
    }
}

#[test]
fn test_white_noise_is_measured_and_let_pass() {
    // Not white, but as large as noise of 0.02 rad gets at each step.
    let yaw = |k: u32| 0.02 * crate::math::sin(2.4 * f64::from(k * k));
    assert!(beyond(200, |k, expected| expected + yaw(k + 1) - yaw(k)) < 0.0);
}

/// What the sums come to where every step is the same.
#[test]
fn test_sums_of_steps_that_are_all_alike_come_to_their_window() {
    let (turn, rate, excess, share, dt) = (0.02, 0.3, -0.1, 2.0, 0.05);
    let mut state = MonitorState::settled(0.0);
    for _ in 0..20_000 {
        state.observe(turn, rate, excess, share, dt);
    }
    let window = MonitorState::WINDOW;
    let residual = turn - rate * dt;
    let forgotten = MonitorState::OFFSET_TIME + dt;
    for (sum, expected) in [
        (state.measured, turn / dt * window),
        (state.expected, rate * window),
        (state.delayed, rate * window),
        (state.rate, rate),
        (state.yaw_rate, turn / dt),
        (state.reach, share * window),
        (state.excess, 0.1 * window),
        (state.time, MonitorState::NOISE_TIME),
        (state.noise, 0.0),
        (state.offset_square, share * share * forgotten),
        (state.offset_sum, share * residual / dt * forgotten),
    ] {
        assert!(
            (sum - expected).abs() < 1e-9,
            "{sum}, not {expected}: {state:?}"
        );
    }
    // Changes of a residual that are all as large have that as their variance.
    for k in 0..20_000 {
        let large = if k % 2 == 0 { 0.5 } else { -0.5 };
        state.observe(turn + large, rate, excess, share, dt);
    }
    assert!((state.noise - 1.0 / 6.0).abs() < 1e-9, "{state:?}");
}

/// A turn against that of the window is uncertain by a part of it, one that goes on is not.
#[test]
fn test_turn_against_that_of_the_window_counts_as_excess() {
    for side in [1.0, -1.0] {
        let mut state = MonitorState::settled(0.0);
        for _ in 0..10 {
            state.observe(0.01, side * 0.2, 0.0, 1.0, 0.05);
        }
        assert_eq!(state.excess, 0.0);
        state.observe(0.01, side * -0.3, 0.0, 1.0, 0.05);
        let kept = MonitorState::WINDOW / (MonitorState::WINDOW + 0.05);
        let part = MonitorState::AGAINST * 0.3 * 0.05 * kept;
        assert!((state.excess - part).abs() < 1e-15, "{state:?}");
    }
}

/// Turn by a radian of steering offset [1/s] where what is unexplained is checked.
const SHARE: f64 = 2.5;
/// What is unknown of an offset there [rad], and the motion that halves it [1/s].
const UNKNOWN: (f64, f64) = (0.06, 2.0);

/// Nothing expected, no noise, and an offset that is known.
fn quiet() -> MonitorState {
    MonitorState {
        noise: 0.0,
        offset_square: 1e30,
        ..MonitorState::settled(0.0)
    }
}

/// What is unexplained of a state, of its mirror image, and of the same backwards.
fn check_unexplained(state: MonitorState, expected: f64) {
    let mirrored = MonitorState {
        measured: -state.measured,
        expected: -state.expected,
        delayed: -state.delayed,
        offset_sum: -state.offset_sum,
        ..state
    };
    let backwards = MonitorState {
        reach: -state.reach,
        offset_sum: -state.offset_sum,
        ..state
    };
    for state in [state, mirrored, backwards] {
        let share = SHARE.copysign(state.reach);
        let found = state.unexplained(share, UNKNOWN, GAINS);
        let off = (found - expected).abs();
        assert!(off < 1e-12, "{found}, not {expected}: {state:?}");
    }
}

/// A turn between 0.4 and 2.5 of what is expected is explained, where the wheels may lag or be
/// quicker; less half the excess and five deviations of the noise.
#[test]
fn test_what_is_unexplained_is_beyond_the_gains_the_excess_and_the_noise() {
    let quicker = 0.2 + MonitorState::QUICKER * 0.1;
    for (measured, delayed, excess, noise, expected) in [
        (0.7, 0.2, 0.0, 0.0, 0.7 - 2.5 * 0.2),
        (0.05, 0.2, 0.0, 0.0, 0.4 * 0.2 - 0.05),
        (
            0.7,
            0.2,
            0.1,
            0.02,
            0.7 - 2.5 * 0.2 - 0.5 * 0.1 - 5.0 * 0.02,
        ),
        (0.9, 0.1, 0.0, 0.0, 0.9 - 2.5 * quicker),
        (0.01, 0.1, 0.0, 0.0, 0.4 * 0.1 - 0.01),
        (0.9, 0.3, 0.0, 0.0, 0.9 - 2.5 * 0.3),
    ] {
        let state = MonitorState {
            measured,
            expected: 0.2,
            delayed,
            excess,
            noise: noise * noise,
            ..quiet()
        };
        check_unexplained(state, expected);
    }
}

/// A steering offset turns the vehicle without a command: one way alone, but for its doubt. What it
/// did within the window is no evidence of it.
#[test]
fn test_what_is_unexplained_is_beyond_the_offset_and_its_doubt() {
    let known = 3.0 * UNKNOWN.1;
    let doubt = 0.25 * UNKNOWN.0;
    for (measured, offset, explained) in [
        (0.9, 0.05, 0.05 + doubt),
        (-0.9, 0.05, doubt),
        (0.9, -0.05, doubt),
        (-0.9, -0.05, 0.05 + doubt),
    ] {
        let state = MonitorState {
            measured,
            reach: 0.8,
            offset_square: known + SHARE * 0.8,
            offset_sum: offset * (known + UNKNOWN.1) + SHARE * measured,
            ..quiet()
        };
        check_unexplained(state, 0.9 - 0.8 * explained);
    }
}

/// An offset that was seen for long may still differ by the play of the steering.
#[test]
fn test_what_is_unexplained_is_beyond_the_play_of_a_known_offset() {
    let known = MonitorState::OFFSET_TIME * SHARE * SHARE;
    let state = MonitorState {
        measured: 0.9,
        reach: 0.8,
        offset_square: known - UNKNOWN.1 + SHARE * 0.8,
        offset_sum: SHARE * 0.9,
        ..quiet()
    };
    check_unexplained(state, 0.9 - 0.8 * 0.5 * MonitorState::PLAY);
}

/// Before anything is known an offset may turn the car by so much, but is no larger than the
/// estimates allow; a gain that is known leaves less to explain.
#[test]
fn test_what_is_unexplained_is_beyond_an_unknown_offset_and_a_known_gain() {
    let learning = Estimator::default();
    for (share, estimator, doubt) in [
        (5.0, Some(&learning), MonitorState::OFFSET_TURN / 5.0),
        (1.0, Some(&learning), Estimator::MAX_STEER_OFFSET),
        (5.0, None, MonitorState::LASTING_OFFSET.0),
    ] {
        let state = MonitorState {
            measured: 0.9,
            reach: 0.4 * share,
            noise: 0.0,
            // Of the window alone.
            offset_square: 0.4 * share * share,
            offset_sum: 0.9 * share,
            ..MonitorState::settled(0.0)
        };
        let found = state.unexplained_by(share, estimator);
        let expected = 0.9 - 0.4 * share * doubt;
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }
    let state = MonitorState {
        measured: 0.1,
        expected: 0.2,
        delayed: 0.2,
        ..quiet()
    };
    for (low, expected) in [(0.4, 0.4 * 0.2 - 0.1), (0.8, 0.8 * 0.2 - 0.1)] {
        let found = state.unexplained(SHARE, UNKNOWN, (low, 1.2));
        assert!((found - expected).abs() < 1e-12, "{found}");
    }
    let found = MonitorState {
        measured: 0.3,
        ..state
    };
    assert!((found.unexplained(SHARE, UNKNOWN, (0.8, 1.2)) - 0.3 + 1.2 * 0.2).abs() < 1e-12);
}

/// At rest nothing is learnt of the offset, and nothing forgotten.
#[test]
fn test_what_is_known_of_the_offset_outlasts_a_rest() {
    let mut state = MonitorState::settled(0.0);
    for _ in 0..400 {
        state.observe(0.01, 0.1, 0.0, 3.0, 0.05);
    }
    let before = (state.offset_square, state.offset_sum);
    for _ in 0..2400 {
        state.observe(0.0, 0.0, 0.0, 0.0, 0.05);
    }
    assert_eq!((state.offset_square, state.offset_sum), before);
}

#[test]
fn test_an_interrupted_second_counts_no_more() {
    let mut state = MonitorState::settled(0.0);
    for _ in 0..20 {
        state.observe(0.2, 0.1, 0.1, 3.0, 0.05);
    }
    assert!(state.is_beyond(0.01, 3.0, None));
    state.interrupt();
    assert!(!state.is_beyond(0.0, 3.0, None) && state.yaw.is_none() && state.residual.is_none());
}
