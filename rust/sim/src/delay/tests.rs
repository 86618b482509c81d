use super::*;

fn passed(dead_time: f64, commands: &[f64]) -> Vec<(f64, usize)> {
    let mut delay = Delay::new(dead_time);
    let mut seen = Vec::new();
    for &command in commands {
        delay.pass(command, 0.01, 5, |command, count| {
            seen.push((command, count));
        });
    }
    seen
}

#[test]
fn test_delay_of_nothing_passes_on_at_once() {
    assert_eq!(passed(0.0, &[0.1, 0.2]), [(0.1, 5), (0.2, 5)]);
}

#[test]
fn test_delay_of_whole_periods_shifts_by_them() {
    let seen = passed(0.1, &[0.1, 0.2, 0.3, 0.4]);
    assert_eq!(seen, [(0.0, 5), (0.0, 5), (0.1, 5), (0.2, 5)]);
}

#[test]
fn test_delay_within_a_period_changes_in_it() {
    let seen = passed(0.03, &[0.1, 0.2]);
    assert_eq!(seen, [(0.0, 3), (0.1, 2), (0.1, 3), (0.2, 2)]);
    let seen = passed(0.025, &[0.1]);
    assert_eq!(seen[0], (0.0, 2));
    assert!((seen[1].0 - 0.05).abs() < 1e-12 && seen[1].1 == 1);
    assert_eq!(seen[2], (0.1, 2));
}

#[test]
fn test_delay_keeps_its_length_over_a_long_run() {
    let mut delay = Delay::new(0.152);
    for k in 0..100_000_u32 {
        delay.pass(f64::from(k), 0.005, 10, |_, _| ());
    }
    let total: f64 = delay.commands().map(|(_, duration)| duration).sum();
    assert!((total - 0.152).abs() < 1e-6, "{total}");
}
