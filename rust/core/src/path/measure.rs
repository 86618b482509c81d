//! Waypoints, checked and measured once.

use crate::bounds::{MAX_COORDINATE, MAX_SPEED};
use crate::error::{PathError, Requirement, in_range};
use crate::geometry::{Point, get_distance};

/// Neighbouring waypoints at most this far apart [m] coincide.
pub const COINCIDING: f64 = 1e-9;

/// Lengths of a path, measured once [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measures {
    /// Arc length of the whole path, the closing segment included.
    pub length: f64,
    /// Length of the longest segment.
    pub longest: f64,
}

/// Checks waypoints, writes the arc length at each into `s`, measures the path.
pub(super) fn measure(
    x: &[f64],
    y: &[f64],
    speed: Option<&[f64]>,
    closed: bool,
    s: &mut [f64],
) -> Result<Measures, PathError> {
    check_waypoints(x, y, speed, closed, s.len())?;
    lengths(x, y, closed, s)
}

/// The same of waypoints that are checked.
pub(super) fn lengths(
    x: &[f64],
    y: &[f64],
    closed: bool,
    s: &mut [f64],
) -> Result<Measures, PathError> {
    let waypoints = x.len();
    let points = || x.iter().zip(y).map(|(&x, &y)| Point::new(x, y));
    let mut length = 0.0;
    let mut longest = 0.0;
    let segments = points().zip(points().cycle().skip(1));
    for (index, ((here, next), room)) in segments.zip(s.iter_mut()).enumerate() {
        *room = length;
        let last = index + 1 == waypoints;
        if last && !closed {
            break;
        }
        let step = get_distance(here, next);
        if step <= COINCIDING {
            return Err(PathError::Coinciding {
                index,
                next: if last { 0 } else { index + 1 },
            });
        }
        let before = length;
        length += step;
        // As differences of arc lengths have it, which is how a segment's length is asked for.
        if length - before > longest {
            longest = length - before;
        }
    }
    Ok(Measures { length, longest })
}

/// Checks that there are enough waypoints, as many entries of each kind, and each within its bound.
pub(super) fn check_waypoints(
    x: &[f64],
    y: &[f64],
    speed: Option<&[f64]>,
    closed: bool,
    arc_lengths: usize,
) -> Result<(), PathError> {
    let waypoints = x.len();
    let least = if closed { 3 } else { 2 };
    if waypoints < least {
        return Err(PathError::TooFewWaypoints {
            count: waypoints,
            least,
        });
    }
    let lengths = [
        ("y", y.len()),
        ("speed", speed.map_or(waypoints, <[f64]>::len)),
        ("s", arc_lengths),
    ];
    for (field, length) in lengths {
        check_length(field, length, waypoints)?;
    }
    check_numbers("x", x, MAX_COORDINATE)?;
    check_numbers("y", y, MAX_COORDINATE)?;
    if let Some(speed) = speed {
        check_numbers("speed", speed, MAX_SPEED)?;
    }
    Ok(())
}

/// Checks that there is a number for each of the `waypoints`, within `bound` either way.
pub(super) fn check_column(
    field: &'static str,
    column: &[f64],
    waypoints: usize,
    bound: f64,
) -> Result<(), PathError> {
    check_length(field, column.len(), waypoints)?;
    check_numbers(field, column, bound)
}

/// Checks that there is an entry for each of the `waypoints`.
pub(super) fn check_length(
    field: &'static str,
    length: usize,
    waypoints: usize,
) -> Result<(), PathError> {
    if length == waypoints {
        return Ok(());
    }
    Err(PathError::LengthMismatch {
        field,
        length,
        waypoints,
    })
}

fn check_numbers(field: &'static str, values: &[f64], bound: f64) -> Result<(), PathError> {
    match values
        .iter()
        .position(|&value| !in_range(value, -bound, bound))
    {
        None => Ok(()),
        Some(index) => Err(PathError::OutOfRange {
            field,
            index,
            value: values.get(index).copied().unwrap_or(f64::NAN),
            requirement: Requirement::InRange(-bound, bound),
        }),
    }
}
