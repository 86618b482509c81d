//! Waypoints as people have them, mended where that is certain and refused where it is not.
//!
//! A path that turns by more than a right angle at a waypoint is folded there. Recordings and stitched
//! routes have folds that no vehicle drives: neighbours in the wrong order, a step back to where a
//! second list begins, a vehicle that stood in the noise of its position. They are found by one dot
//! product a waypoint, and mended by leaving waypoints out, or by turning some round (the 2-opt move,
//! Croes 1958), if that leaves no fold and the path still passes what was left out. A path that has
//! none of them stays as it is, to the bit.
//!
//! Lengths are compared with the spacing of the waypoints, so that all of this scales with the path.

mod chain;
mod ends;
mod fit;
mod folds;
mod gears;
mod mends;

use alloc::boxed::Box;
use alloc::vec::Vec;

use self::chain::{CORNERS, Chain, EVEN};
use self::fit::{fit_end, sharp_end};
pub(super) use self::gears::at_cusps;
pub use self::mends::{Fault, Mend};
use super::measure::COINCIDING;
use crate::error::PathError;
use crate::geometry::{Point, get_distance};
use crate::math::{larger, smaller};

/// The square of the cosine of [`TURNED`](chain::TURNED): no fault turns a path by less.
const CALM: f64 = 0.9605;

/// The waypoints that make a sound path, in their order, and what was mended.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sound {
    /// Their indices as given; None if all stay as they are.
    pub kept: Option<Box<[usize]>>,
    /// What was mended, at most once each kind.
    pub mends: Vec<Mend>,
}

/// Finds what to leave out of waypoints and what to exchange. If `directed`, the user says where the
/// path is driven backwards or how the vehicle heads: then folds are cusps, and nothing but
/// waypoints at one place is mended.
///
/// # Errors
///
/// [`PathError`]: a fold that may be a cusp, a gap that the path turns at, waypoints without an order.
pub fn sound(x: &[f64], y: &[f64], closed: bool, directed: bool) -> Result<Sound, PathError> {
    if is_plain(x, y, closed) {
        return Ok(Sound::default());
    }
    let mut chain = Chain {
        x,
        y,
        order: distinct_waypoints(x, y, closed),
        spacing: 0.0,
        reach: 0.0,
        mends: Vec::new(),
    };
    chain.note_coinciding(closed);
    if chain.order.len() > 2 {
        chain.spacing = chain.usual_spacing(closed);
        let away = |place| get_distance(chain.at(place), chain.at(0));
        chain.reach = (1..chain.order.len()).map(away).fold(0.0, larger);
        if !directed {
            chain.mend(closed)?;
            chain.rejoin();
        }
        chain.check_gaps(directed)?;
    }
    let all = chain.order.len() == x.len() && chain.mends.is_empty();
    Ok(Sound {
        kept: (!all).then(|| chain.order.into()),
        mends: chain.mends,
    })
}

/// Waypoints with ends that a vehicle drives whose wheelbase is `reach` [m] and whose largest
/// curvature is `tightest` [1/m], and how many ends were smoothed; None if both are driven as they are.
pub(super) fn fit_ends(
    x: &[f64],
    y: &[f64],
    reach: f64,
    tightest: f64,
) -> Option<(Vec<Point>, usize)> {
    if x.len() < CORNERS {
        return None;
    }
    let point = |at: usize| match (x.get(at), y.get(at)) {
        (Some(&x), Some(&y)) => Point::new(x, y),
        _ => Point::default(),
    };
    let backwards = |at: usize| point(x.len() - 1 - at.min(x.len() - 1));
    // Most paths are smooth, and a fresh path in the loop is to cost no allocation.
    let any = sharp_end(x.len(), point, reach, tightest).is_some()
        || sharp_end(x.len(), backwards, reach, tightest).is_some();
    if !any {
        return None;
    }
    let mut points: Vec<Point> = x.iter().zip(y).map(|(&x, &y)| Point::new(x, y)).collect();
    let end = fit_end(&mut points, reach, tightest);
    points.reverse();
    let start = fit_end(&mut points, reach, tightest);
    points.reverse();
    (end || start).then_some((points, usize::from(end) + usize::from(start)))
}

/// Whether there is nothing to look for: no fold, and either no segment much shorter or longer than
/// others, and none at an end shorter than half of the longest, or no turn that a fault would make.
fn is_plain(x: &[f64], y: &[f64], closed: bool) -> bool {
    let point = |index: usize| Some(Point::new(*x.get(index)?, *y.get(index)?));
    let count = x.len();
    let (Some(first), Some(second)) = (point(0), point(1)) else {
        return true;
    };
    let mut last = second - first;
    let start = last.dot(&last);
    let (mut least, mut most, mut forward, mut calm) = (start, start, true, true);
    let mut here = second;
    let seam = if closed { 2 } else { 0 };
    let further = x.iter().zip(y).cycle().skip(2);
    for (&x, &y) in further.take((count + seam).saturating_sub(2)) {
        let step = Point::new(x, y) - here;
        let squared = step.dot(&step);
        let dot = step.dot(&last);
        forward &= dot >= 0.0;
        calm &= dot > 0.0 && dot * dot >= CALM * squared * last.dot(&last);
        least = smaller(squared, least);
        most = larger(squared, most);
        (here, last) = (Point::new(x, y), step);
    }
    let short = |end: f64| !closed && end < 0.25 * most;
    let even = !short(start) && !short(last.dot(&last)) && most < EVEN * EVEN * least;
    forward && (even || calm && least > COINCIDING)
}

/// The waypoints to keep so that no two neighbours coincide: of several at one place the last,
/// whose speed and direction are those of what follows. A closed path that comes back to its
/// start also loses the repetition.
#[must_use]
pub fn distinct_waypoints(x: &[f64], y: &[f64], closed: bool) -> Vec<usize> {
    let points = || x.iter().zip(y).map(|(&x, &y)| Point::new(x, y));
    let mut kept: Vec<(usize, Point)> = Vec::new();
    for (index, point) in points().enumerate() {
        while let Some((_, last)) = kept.last()
            && get_distance(*last, point) <= COINCIDING
        {
            kept.pop();
        }
        kept.push((index, point));
    }
    if closed {
        while let [(_, first), .., (_, last)] = kept.as_slice()
            && get_distance(*first, *last) <= COINCIDING
        {
            kept.pop();
        }
    }
    kept.into_iter().map(|(index, _)| index).collect()
}
