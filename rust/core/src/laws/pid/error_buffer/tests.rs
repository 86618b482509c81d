use super::*;

#[test]
fn test_error_buffer_forgets_the_oldest() {
    let mut buffer = ErrorBuffer::new(3);
    for term in [1.0, 2.0, 4.0, 8.0] {
        buffer.push(term);
    }
    assert_eq!(buffer.sum(), 14.0);
    assert!(buffer.terms().eq([2.0, 4.0, 8.0]));
}

#[test]
fn test_error_buffer_restored_goes_on_alike() {
    for pushed in [0, 2, 3, 7] {
        let mut buffer = ErrorBuffer::new(3);
        (0..pushed).for_each(|k| buffer.push(0.1 * f64::from(k)));
        let terms: alloc::vec::Vec<f64> = buffer.terms().collect();
        let restored = ErrorBuffer::of(3, &terms, buffer.next, buffer.sum());
        assert_eq!(restored, buffer);
        assert_eq!(restored.check(), Ok(()));
    }
    let long = [0.0; ErrorBuffer::CAPACITY + 1];
    for (terms, next, sum, field) in [
        (&long[..4], 0, 0.0, "law.buffer.terms"),
        (&long, 0, 0.0, "law.buffer.terms"),
        (&[f64::NAN], 1, 0.0, "law.buffer.terms"),
        (&long[..2], 0, 0.0, "law.buffer.next"),
        (&long[..2], usize::MAX, 0.0, "law.buffer.next"),
        (&long[..3], 3, 0.0, "law.buffer.next"),
        (&[], 0, f64::NAN, "law.buffer.sum"),
    ] {
        let refused = ErrorBuffer::of(3, terms, next, sum).check().unwrap_err();
        assert_eq!(refused.field, field);
    }
}

#[test]
fn test_error_buffer_sum_stays_exact_over_a_long_run() {
    let mut buffer = ErrorBuffer::new(500);
    for k in 0..1_000_000_u32 {
        buffer.push(if k % 1000 == 0 { 1e12 } else { 0.1 });
    }
    let sum: f64 = buffer.terms().sum();
    assert!((buffer.sum() - sum).abs() <= 1e-6);
}
