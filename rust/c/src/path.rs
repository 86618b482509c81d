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
/// Mended, see `popsteer_path_mended`: waypoints at one place, neighbours swapped, a step back that the
/// path passes again, a standstill in the noise of its position, a short end that points aside. With
/// `reverse` or a negative speed folds are cusps, and only waypoints at one place are mended.
///
/// Refused as `POPSTEER_ERROR_PATH`: fewer than two waypoints (three in a closed path), a number
/// that is not finite or beyond 1e9 m, a path that turns back on itself though nothing says that it is
/// driven backwards, a gap far longer than the spacing at which it turns, waypoints without an order.
/// `out` gets the path, which is freed by `popsteer_path_free`.
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
        let (x, y, speed, reverse) = unsafe {
            (
                handle::items(x, count, "x")?,
                handle::items(y, count, "y")?,
                given(speed, count, "speed")?,
                given(reverse, count, "reverse")?,
            )
        };
        let reverse = reverse.map(|all| all.iter().map(|&each| each != 0).collect::<Vec<_>>());
        let path = Path::sound(x, y, speed, reverse.as_deref(), closed, false)?;
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

/// Makes a path that is `path` with the vehicle's heading `yaw` [rad] and `curvature` [1/m] at each
/// of its waypoints, as its planner has them: those of the vehicle, whose yaw points against the
/// order of the waypoints where it drives backwards. `count` is the number of waypoints. One that is
/// NULL is that of the natural cubic spline through the waypoints, but there is no curvature beside
/// a `yaw`. Both NULL are for coarse waypoints without noise; `count` is not used then.
///
/// Refused as `POPSTEER_ERROR_PATH`: another count, a number that is not finite or beyond 1e6 rad or
/// 1e3 1/m, a yaw more than 0.35 rad off the waypoints beside it, a curvature that contradicts the
/// yaw. `out` gets the path, which is freed by `popsteer_path_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_path_with_yaw(
    path: *const CPath,
    yaw: *const f64,
    curvature: *const f64,
    count: usize,
    out: *mut *mut CPath,
) -> CError {
    let value = || {
        // SAFETY: the caller vouches for the handle and the arrays.
        let (path, yaw, curvature) = unsafe {
            (
                shared(path)?,
                given(yaw, count, "yaw")?,
                given(curvature, count, "curvature")?,
            )
        };
        Ok(Arc::new(Path::clone(&path).with_yaw(yaw, curvature)?))
    };
    // SAFETY: the caller vouches for `out`.
    guard(|| unsafe { handle::give(out, value) })
}

/// The length of a path [m], the way from the last waypoint to the first of a closed one included;
/// NAN where `path` is no path.
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

/// How many faults of the waypoints were mended when the path was made; 0 where `path` is no path.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_path_mended(path: *const CPath) -> usize {
    let mut times = 0;
    guard(|| {
        // SAFETY: the caller vouches for it.
        let mends = unsafe { handle::of(path, "path")? }.mends();
        times = mends.iter().map(|mend| mend.times).sum();
        Ok(())
    });
    times
}

/// Frees a path, at the latest when the last controller that follows it is freed; NULL is left
/// alone.
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

/// An array that may be NULL.
///
/// # Safety
///
/// `items` is NULL or has `count` entries.
unsafe fn given<'a, T>(
    items: *const T,
    count: usize,
    name: &'static str,
) -> Result<Option<&'a [T]>, Failure> {
    if items.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller vouches for the array.
    unsafe { handle::items(items, count, name) }.map(Some)
}
