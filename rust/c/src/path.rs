//! Paths: waypoints that are copied once, and shared by all who follow them.

use std::sync::Arc;

use popsteer_core::Path;

use crate::error::{CError, Failure, guard};
use crate::handle::{self, Handle};

/// A path: waypoints that never change. Many controllers may share one, on any number of threads;
/// the handle may be freed while they do.
#[derive(Debug)]
pub struct CPath {
    _private: (),
}

impl Handle for CPath {
    type Value = Arc<Path>;
    const MAGIC: u64 = 0x6874_6170_5f73_7001;
    const KIND: &'static str = "path";
}

/// Makes a path of `count` waypoints, which are copied.
///
/// `x`, `y`: coordinates [m]. `speed`: reference speeds [m/s], or NULL; a segment whose speed is
/// negative is driven backwards. `reverse`: for each waypoint not 0 where the segment that begins
/// there is driven backwards, whatever the signs of the speeds, or NULL. `closed`: whether the last
/// waypoint leads back to the first.
///
/// Refused as `POPSTEER_ERROR_PATH`: fewer than two waypoints (three in a closed path), a number
/// that is not finite or beyond 1e9 m, neighbours at one place. `out` gets the path, which is freed
/// by `popsteer_path_free`.
///
/// # Safety
///
/// The arrays have `count` entries each; `out` is a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_path_new(
    x: *const f64,
    y: *const f64,
    speed: *const f64,
    reverse: *const u8,
    count: usize,
    closed: bool,
    out: *mut *mut CPath,
) -> CError {
    let value = || {
        // SAFETY: the caller vouches for the arrays.
        let (x, y) = unsafe { (handle::items(x, count, "x")?, handle::items(y, count, "y")?) };
        let speed = if speed.is_null() {
            None
        } else {
            // SAFETY: the caller vouches for the array.
            Some(unsafe { handle::items(speed, count, "speed")? })
        };
        let path = Path::new(x, y, speed, closed)?;
        let path = if reverse.is_null() {
            path
        } else {
            // SAFETY: the caller vouches for the array.
            let reverse = unsafe { handle::items(reverse, count, "reverse")? };
            let reverse: Vec<bool> = reverse.iter().map(|&reverse| reverse != 0).collect();
            path.with_reverse(&reverse)?
        };
        Ok(Arc::new(path))
    };
    // SAFETY: the caller vouches for `out`.
    guard(|| unsafe { handle::give(out, value) })
}

/// Makes a path that is `path` with the slope at each of its waypoints: rise over run, positive
/// uphill in the direction of the waypoints, and linear between them. `count` is the number of
/// waypoints. Plans and speed trackers use it.
///
/// Refused as `POPSTEER_ERROR_PATH`: another count, a slope that is not finite or beyond 1. `out` gets
/// the path, which is freed by `popsteer_path_free`.
///
/// # Safety
///
/// `path` is NULL or a handle of this library; `grade` has `count` entries; `out` is a place for a
/// pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_path_with_grade(
    path: *const CPath,
    grade: *const f64,
    count: usize,
    out: *mut *mut CPath,
) -> CError {
    let value = || {
        // SAFETY: the caller vouches for the handle and the array.
        let (path, grade) = unsafe { (shared(path)?, handle::items(grade, count, "grade")?) };
        Ok(Arc::new(Path::clone(&path).with_grade(grade)?))
    };
    // SAFETY: the caller vouches for `out`.
    guard(|| unsafe { handle::give(out, value) })
}

/// The length of a path [m], the way from the last waypoint to the first of a closed one included;
/// NAN where `path` is no path.
///
/// # Safety
///
/// `path` is NULL or a handle of this library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_path_length(path: *const CPath) -> f64 {
    let mut length = f64::NAN;
    guard(|| {
        // SAFETY: the caller vouches for it.
        length = unsafe { handle::of(path, "path")? }.view().length();
        Ok(())
    });
    length
}

/// Frees a path, at the latest when the last controller that follows it is freed; NULL is left
/// alone.
///
/// # Safety
///
/// `path` is NULL or a handle of this library that is not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_path_free(path: *mut CPath) -> CError {
    // SAFETY: the caller vouches for it.
    guard(|| unsafe { handle::free(path, "path") })
}

/// The path behind a handle, shared.
///
/// # Safety
///
/// `path` is NULL or a handle of this library.
pub(crate) unsafe fn shared(path: *const CPath) -> Result<Arc<Path>, Failure> {
    // SAFETY: the caller vouches for it.
    Ok(Arc::clone(unsafe { handle::of(path, "path")? }))
}
