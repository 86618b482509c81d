//! What a path takes with its index, counted at the allocator.
#![expect(unsafe_code, reason = "an allocator is unsafe to implement")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use popsteer_core::Path;

thread_local! {
    /// Bytes that this thread holds: the test harness has threads of its own.
    static HELD: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: hands everything on to the system's allocator; the counter itself does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        HELD.with(|held| held.set(held.get().wrapping_add(layout.size())));
        // SAFETY: the caller's promises are the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.with(|held| held.set(held.get().wrapping_sub(layout.size())));
        // SAFETY: the caller's promises are the same.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What `make` made, and the bytes that it holds.
fn held_by<T>(make: impl FnOnce() -> T) -> (T, usize) {
    let before = HELD.with(Cell::get);
    let made = make();
    (made, HELD.with(Cell::get) - before)
}

/// The bytes that a path of so many waypoints holds.
fn bytes_of(count: u32, speed: Option<fn(f64) -> f64>, closed: bool) -> usize {
    let x = (0..count).map(f64::from);
    let (x, y): (Vec<_>, Vec<_>) = x.map(|x| (x, 8.0 * (x / 25.0).sin())).unzip();
    let speed: Option<Vec<f64>> = speed.map(|speed| y.iter().map(|&y| speed(y)).collect());
    let (path, bytes) = held_by(|| Path::new(&x, &y, speed.as_deref(), closed));
    assert!(path.is_ok());
    bytes
}

#[test]
fn test_short_path_holds_its_waypoints_alone() {
    for (count, waypoints) in [(2, 2), (3, 3), (200, 200), (512, 512)] {
        assert_eq!(bytes_of(count, None, false), 24 * waypoints);
        assert_eq!(bytes_of(count, Some(f64::abs), false), 32 * waypoints);
        // A byte more where some of it is driven backwards.
        assert_eq!(bytes_of(count, Some(|_| -1.0), false), 33 * waypoints);
    }
}

#[test]
fn test_long_path_holds_two_bytes_a_waypoint_for_its_index() {
    for closed in [false, true] {
        for (count, waypoints) in [(1000, 1000), (100_000, 100_000), (1_000_000, 1_000_000)] {
            let index = bytes_of(count, None, closed) - 24 * waypoints;
            assert!(index.abs_diff(2 * waypoints) <= 64, "{index} for {count}");
        }
    }
}
