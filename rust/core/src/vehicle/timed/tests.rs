use super::*;
use alloc::vec::Vec;

#[test]
fn test_ring_beyond_its_capacity_forgets_the_oldest() {
    let mut timed = Timed::<3>::EMPTY;
    for k in 0..5 {
        timed.push(f64::from(k), 0.25);
    }
    let kept: Vec<_> = timed.iter().collect();
    assert_eq!(kept, [(2.0, 0.25), (3.0, 0.25), (4.0, 0.25)]);
    assert_eq!(Timed::restore("field", kept.into_iter()), Ok(timed));
    let refused = Timed::<3>::restore("field", [(0.0, 1.0); 4].into_iter()).unwrap_err();
    assert_eq!((refused.field, refused.value), ("field", 4.0));
}

#[test]
fn test_short_angles_are_joined_to_their_mean() {
    let mut timed = Timed::<3>::EMPTY;
    for (angle, duration) in [(1.0, 0.25), (4.0, 0.5), (2.0, 0.25)] {
        timed.push_or_join(angle, duration, 0.75);
    }
    assert!(timed.iter().eq([(3.0, 0.75), (2.0, 0.25)]));
}

#[test]
fn test_angles_that_do_not_last_are_none_and_the_shortest_have_a_mean() {
    let (mut timed, least) = (Timed::<3>::EMPTY, f64::from_bits(1));
    for (angle, duration) in [(1.0, 0.0), (1.0, 0.0), (1.5, least), (1.5, least)] {
        timed.push_or_join(angle, duration, 0.75);
    }
    assert!(timed.iter().eq([(1.5, 2.0 * least)]));
}

#[test]
fn test_take_empties_the_ring_in_order() {
    let mut timed = Timed::<3>::EMPTY;
    timed.push(1.0, 0.5);
    timed.push(2.0, 0.25);
    assert_eq!(timed.take(0.125), Some((1.0, 0.125)));
    assert_eq!(timed.take(1.0), Some((1.0, 0.375)));
    assert_eq!(timed.take(0.25), Some((2.0, 0.25)));
    assert_eq!(timed.take(1.0), None);
}

#[test]
fn test_clipped_lasts_as_long_as_is_wanted() {
    let timed = [(1.0, 0.25), (2.0, 0.5)];
    let within = |time| clipped(timed.into_iter(), time).collect::<Vec<_>>();
    assert_eq!(within(0.0), []);
    assert_eq!(within(0.25), [(1.0, 0.25)]);
    assert_eq!(within(0.5), [(1.0, 0.25), (2.0, 0.25)]);
    assert_eq!(within(9.0), timed);
}
