use super::*;

/// Steps of 0.05 s at 8 m/s, in which the vehicle turns by `turn` of what is expected.
fn beyond(steps: u32, turn: impl Fn(u32, f64) -> f64) -> f64 {
    let mut state = MonitorState::settled(0.0);
    let mut most = f64::NEG_INFINITY;
    for k in 0..steps {
        let rate = 0.3 * crate::math::sin(0.1 * f64::from(k));
        state.observe(turn(k, rate * 0.05), rate, 0.0, 3.0, 0.05);
        let beyond = state.unexplained();
        assert_eq!(state.is_beyond(0.01), beyond > 0.01, "{state:?}");
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
            state.observe(0.05 * share * 0.05, 0.0, 0.0, share, 0.05);
        }
        assert!(state.measured.abs() > 0.1);
        state.observe(0.0, 0.0, 0.0, 0.0 * share, 0.05);
        assert!(!state.is_beyond(0.01), "{share}: {state:?}");
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
    // Changes of a residual that are all as large have that as their variance; a residual that
    // no offset explains counts as the largest that one does.
    for k in 0..20_000 {
        let large = if k % 2 == 0 { 0.5 } else { -0.5 };
        state.observe(turn + large, rate, excess, share, dt);
    }
    assert!((state.noise - 1.0 / 6.0).abs() < 1e-9, "{state:?}");
    for _ in 0..20_000 {
        state.observe(-9.0, rate, excess, share, dt);
    }
    let largest = share * share * Estimator::MAX_STEER_OFFSET * forgotten;
    assert!((state.offset_sum + largest).abs() < 1e-9, "{state:?}");
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
        let found = state.unexplained();
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

/// A steering offset turns the vehicle without a command: one way alone, but for its doubt.
#[test]
fn test_what_is_unexplained_is_beyond_the_offset_and_its_doubt() {
    let square = 3.0 * MonitorState::OFFSET_DOUBT;
    let doubt = 0.25 * MonitorState::OFFSET;
    for (measured, offset, explained) in [
        (0.9, 0.05, 0.05 + doubt),
        (-0.9, 0.05, doubt),
        (0.9, -0.05, doubt),
        (-0.9, -0.05, 0.05 + doubt),
    ] {
        let state = MonitorState {
            measured,
            reach: 0.8,
            offset_square: square,
            offset_sum: offset * (square + MonitorState::OFFSET_PRIOR),
            ..quiet()
        };
        check_unexplained(state, 0.9 - 2.5 * 0.8 * explained);
    }
}

#[test]
fn test_an_interrupted_second_counts_no_more() {
    let mut state = MonitorState::settled(0.0);
    for _ in 0..20 {
        state.observe(0.2, 0.1, 0.1, 3.0, 0.05);
    }
    assert!(state.is_beyond(0.01));
    state.interrupt();
    assert!(!state.is_beyond(0.0) && state.yaw.is_none() && state.residual.is_none());
}
