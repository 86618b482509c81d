//! Changes of gear that lie a waypoint beside their cusp.
//!
//! A segment is driven as the waypoint at its start says. Planners that say at each pose how it was reached
//! change the gear a waypoint later, others one sooner. The one segment between the cusp and the change is then
//! driven in the wrong gear: at the cusp the vehicle would turn round on the spot, by more than 120 degrees. No vehicle does, so
//! the segment takes the gear of the leg that it goes on with.

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
    let step = |segment: usize| {
        let (start, end) = (
            Point::new(*x.get(segment)?, *y.get(segment)?),
            Point::new(*x.get(segment + 1)?, *y.get(segment + 1)?),
        );
        Some(end - start)
    };
    let mut gears = reverse.to_vec();
    let mut mend: Option<Mend> = None;
    for cusp in 1..x.len().saturating_sub(1) {
        let (before, after) = (cusp - 1, cusp);
        let is_fold = step(before)
            .zip(step(after))
            .is_some_and(|(into, out)| along(into, -out));
        if !is_fold || gears.get(before) != gears.get(after) {
            continue;
        }
        // The leg that a segment goes on with, straight on and in the other gear.
        let leg = |segment: usize, neighbour: usize| {
            let ahead = step(segment)
                .zip(step(neighbour))
                .is_some_and(|(one, other)| along(one, other));
            let gear = gears.get(neighbour).copied();
            gear.filter(|gear| ahead && gears.get(segment) != Some(gear))
        };
        let late = leg(after, after + 1).map(|gear| (after, gear));
        let early = || Some((before, leg(before, before.checked_sub(1)?)?));
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
