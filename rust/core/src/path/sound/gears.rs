//! Changes of gear that lie a waypoint beside their cusp.
//!
//! A segment is driven as the waypoint at its start says. Planners that say at each pose how it was reached
//! change the gear a waypoint later, others one sooner. The one segment between the cusp and the change is then
//! driven in the wrong gear: at the cusp the vehicle would turn round on the spot, by more than 120 degrees. No
//! vehicle does, so the segment takes the gear of the leg that it goes on with.

use alloc::vec::Vec;

use super::chain::along;
use super::mends::{Fault, Mend};
use crate::geometry::Point;

/// Which segments are driven backwards with each change of gear at its cusp, and how many were moved; None
/// if none is.
pub(in crate::path) fn at_cusps(
    x: &[f64],
    y: &[f64],
    reverse: &[bool],
) -> Option<(Vec<bool>, Mend)> {
    let at = |index: usize| Some(Point::new(*x.get(index)?, *y.get(index)?));
    let step = |segment: usize| Some(at(segment + 1)? - at(segment)?);
    let steps = |one: usize, other: usize| step(one).zip(step(other));
    let folds = |cusp: usize| steps(cusp - 1, cusp).is_some_and(|(into, out)| along(into, -out));
    let slips = |&cusp: &usize| reverse.get(cusp - 1) == reverse.get(cusp) && folds(cusp);
    let cusps: Vec<usize> = (1..x.len().saturating_sub(1)).filter(slips).collect();
    if cusps.is_empty() {
        return None;
    }
    let mut gears = reverse.to_vec();
    let mut mend: Option<Mend> = None;
    for cusp in cusps {
        // The leg that a segment goes on with, straight on and in the other gear.
        let leg = |segment: usize, neighbour: usize| {
            let ahead = steps(segment, neighbour).is_some_and(|(one, other)| along(one, other));
            let gear = gears.get(neighbour).copied();
            let gear = gear.filter(|gear| ahead && gears.get(segment) != Some(gear));
            gear.map(|gear| (segment, gear))
        };
        let late = leg(cusp, cusp + 1);
        let early = || leg(cusp - 1, cusp.checked_sub(2)?);
        let Some((segment, gear)) = late.or_else(early) else {
            continue;
        };
        if let Some(entry) = gears.get_mut(segment) {
            *entry = gear;
        }
        mend.get_or_insert(Mend {
            fault: Fault::Gear,
            times: 0,
            left_out: 0,
            index: cusp,
        })
        .times += 1;
    }
    mend.map(|mend| (gears, mend))
}
