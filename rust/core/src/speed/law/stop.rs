//! The distance to the next stop, as steady as the speed.

use crate::math::{saturate, smaller};
use crate::path::follow::Located;
use crate::speed::law::limits::SpeedLaw;
use crate::speed::law::state::SpeedState;
use crate::speed::stops::Planned;

/// A distance to the stop that is off the expected one by so many times that is a jump.
const JUMP: f64 = 2.5;
/// Besides, by so many standard deviations of the position's noise.
const NOISE: f64 = 5.0;
/// How much a pose counts for the distance to a stop, against the distance travelled since the last. Less:
/// a wrong speed shifts the stop. More: noise does.
const POSE_SHARE: f64 = 0.2;

/// By so much the distance to a stop may be off for noise of the position, times its standard deviation:
/// five of what is left of it, `sqrt(POSE_SHARE / (2 - POSE_SHARE))`.
pub(super) const STEADY_NOISE: f64 = 1.7;

impl SpeedLaw {
    /// What neither the motion nor `noise` of the position explains of a distance to a stop [m].
    pub(super) fn jump(&self, noise: f64) -> f64 {
        JUMP * self.leaves() + NOISE * noise
    }

    /// The distance to the next stop [m], as measured and as `D`; infinite if there is none. A stop that
    /// is known stays, also where it is overrun, until a path is set without it.
    pub(super) fn stop_ahead(
        &self,
        planned: &Planned<'_, '_>,
        at: &Located,
        state: &mut SpeedState,
        (speed, noise): (f64, f64),
    ) -> (f64, f64) {
        let path = planned.path;
        let rear = at.closest.arc_length(path);
        let lead = if at.reverse {
            0.0
        } else {
            self.car.stop_offset()
        };
        let from = Planned {
            segment: path
                .segment_by_arc(saturate(rear + lead, 0.0, path.length()), planned.segment),
            ..*planned
        };
        // Cusps are the rear axle's.
        let is_last = |waypoint: usize| {
            planned
                .end_stop(rear)
                .is_some_and(|(end, _)| end == waypoint)
        };
        let ends = |waypoint: usize| waypoint + 1 == path.len() && !path.is_closed();
        let arc = |waypoint: usize| {
            let cusp = is_last(waypoint) && !ends(waypoint);
            rear + if cusp { 0.0 } else { lead }
        };
        let gone = 0.5 * (state.speed + speed) * at.dt;
        let expected = state.stop.map(|(_, _, last)| last - gone);
        state.speed = speed;
        let kept = state
            .stop
            .zip(expected)
            .map(|((waypoint, _, _), expected)| {
                (
                    waypoint,
                    planned.distance(waypoint, arc(waypoint), expected),
                )
            });
        let next = from.next_stop(rear + lead, self.leaves(), self.accelerations.1);
        let next =
            next.map(|(waypoint, distance)| (waypoint, distance + rear + lead - arc(waypoint)));
        let found = match (kept, next) {
            (Some(one), Some(other)) => Some(if one.1 <= other.1 { one } else { other }),
            (one, other) => one.or(other),
        };
        let Some((waypoint, measured)) = found else {
            state.stop = None;
            return (f64::INFINITY, f64::INFINITY);
        };
        let measured = if planned.stays_at_zero() {
            smaller(measured, 0.0)
        } else {
            measured
        };
        let same = state.stop.is_some_and(|(known, _, _)| known == waypoint);
        let steady = steady(measured, expected.filter(|_| same), self.jump(noise));
        let place = path.waypoint(waypoint);
        state.stop = Some((waypoint, (place.x, place.y), steady));
        (measured, steady)
    }
}

/// The distance to a stop [m] without most of the noise: `measured`, and as the speed has it since the last
/// step. Farther off than a `jump` the localisation has jumped.
fn steady(measured: f64, expected: Option<f64>, jump: f64) -> f64 {
    match expected {
        Some(expected) if (measured - expected).abs() < jump => {
            expected + POSE_SHARE * (measured - expected)
        }
        _ => measured,
    }
}
