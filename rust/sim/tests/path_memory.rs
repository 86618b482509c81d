//! What a path and its index take, counted at the allocator.
#![expect(unsafe_code, reason = "an allocator is unsafe to implement")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use popsteer_core::Path;
use popsteer_sim::PathIndex;

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

fn waypoints(count: u32) -> (Vec<f64>, Vec<f64>) {
    let x = (0..count).map(f64::from);
    x.map(|x| (x, 8.0 * (x / 25.0).sin())).unzip()
}

#[test]
fn test_path_with_speeds_holds_32_bytes_a_waypoint() {
    for count in [1000, 100_000] {
        let (x, y) = waypoints(count);
        let speed: Vec<f64> = y.iter().map(|y| y.abs()).collect();
        let (path, bytes) = held_by(|| Path::new(&x, &y, Some(&speed), false));
        assert!(path.is_ok());
        assert_eq!(bytes, 32 * x.len());
        let (path, bytes) = held_by(|| Path::new(&x, &y, None, false));
        assert!(path.is_ok());
        assert_eq!(bytes, 24 * x.len());
    }
}

#[test]
fn test_path_driven_backwards_holds_one_byte_more_a_waypoint() {
    for count in [1000, 100_000] {
        let (x, y) = waypoints(count);
        let speed: Vec<f64> = y.iter().map(|y| -y.abs()).collect();
        let (path, bytes) = held_by(|| Path::new(&x, &y, Some(&speed), false));
        assert!(path.is_ok());
        assert_eq!(bytes, 33 * x.len());
    }
}

#[test]
fn test_index_holds_a_fraction_of_its_path() {
    for count in [1000, 10_000, 100_000, 1_000_000] {
        let (x, y) = waypoints(count);
        let path = Path::new(&x, &y, None, false).unwrap();
        let (index, bytes) = held_by(|| PathIndex::new(&path.view()));
        drop(index);
        assert!(bytes <= 4 * x.len(), "{bytes} bytes for {count}");
    }
}
