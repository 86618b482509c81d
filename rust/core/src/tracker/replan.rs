//! A new path during a run: place, estimates and angle continue.
//!
//! A planner sends a path many times a second, mostly the last one shifted a little. The place on
//! the new path is therefore that of the last projection, and only a path that lies elsewhere
//! starts a hand-over.

use crate::bounds::MIN_DT;
use crate::geometry::Point;
use crate::laws::{LateralLaw, LateralState};
use crate::math::{saturate, sqrt};
use crate::path::carry::{Progress, carry_over, goes_on};
use crate::path::index::STEP_BUDGET;
use crate::path::place::Spot;
use crate::path::projection::ClosestPoint;
use crate::path::view::PathView;
use crate::tracker::state::{HANDOVER_TIME, Handover, Tracking};
use crate::tracker::step::Tracker;

/// A path that passes the last projection farther off than this lies elsewhere, in wheelbases.
/// Smaller values fade in more of a planner's noise; larger ones let the angle jump by more.
const ELSEWHERE: f64 = 0.1;
/// So does one whose direction there is another by more than half a radian: the cosine of that.
/// The segments of a noisy plan differ by less.
const ELSEWHERE_COSINE: f64 = 0.877_582_561_890_372_8;

impl<L: LateralLaw> Tracker<L> {
    /// The path `new` replaces `old`.
    ///
    /// The place on it is that of the last projection. Estimates, integral and commands in flight
    /// continue; so does the whole state if the path is unchanged there. To a path that lies
    /// elsewhere the command changes over from the present angle within [`HANDOVER_TIME`]; a
    /// hand-over in progress keeps its end. Before the first step nothing changes.
    pub fn set_path(&self, state: &mut Tracking<L::State>, old: &PathView<'_>, new: &PathView<'_>) {
        let Some(Spot { segment, point }) = state.place.spot() else {
            return;
        };
        if goes_on(old, new, segment) {
            return;
        }
        let last = old.segment_at(segment);
        let is_reverse = old.is_reverse(last);
        let follow = self.follow();
        let (opposite, reach) = (follow.opposite_distance, follow.search_distance);
        let progress = Progress {
            segment: last,
            point,
            reach,
        };
        let closest = carry_over(old, new, progress, opposite, follow.noise(), STEP_BUDGET);
        let closest = closest.on_curve(new, point);
        let (start, end) = old.segment(last);
        let along = end - start;
        state.place = state.place.moved(Spot {
            segment: closest.segment,
            point: closest.point,
        });

        let changes_direction = new.is_reverse(closest.segment) != is_reverse;
        self.change_over(state, along, &closest, changes_direction);
    }

    /// Continues on a new path at `closest`, where the old one led `along`: the controller keeps
    /// what still holds, and the command changes over if the new path lies elsewhere.
    fn change_over(
        &self,
        state: &mut Tracking<L::State>,
        along: Point,
        closest: &ClosestPoint,
        changes_direction: bool,
    ) {
        let ahead = closest.along();
        let lengths = sqrt(along.dot(&along)) * sqrt(ahead.dot(&ahead));
        let cosine = along.dot(&ahead) / lengths;
        let is_askew = cosine < ELSEWHERE_COSINE;
        if changes_direction {
            state.law.leave_path();
        } else if is_askew {
            state.law.change_path(None);
        } else {
            state.law.change_path(Some(closest.cross_track_error()));
        }
        let limit = ELSEWHERE * self.vehicle().wheelbase;
        if changes_direction || is_askew || closest.squared_distance > limit * limit {
            state.hand_over();
        }
    }
}

impl<S: LateralState> Tracking<S> {
    /// Continues from the present angle: its difference to the controller's angle fades in the
    /// remaining time of a hand-over in progress, or within [`HANDOVER_TIME`].
    pub(super) fn hand_over(&mut self) {
        if let Some(monitor) = &mut self.monitor {
            // A new path is a new task: the vehicle may start it beyond the limit.
            monitor.within = false;
        }
        let remaining = match self.handover {
            // Less than all of its time remains once a hand-over has begun.
            Some(fading) if fading.offset.is_some() => {
                saturate(fading.remaining, 0.0, HANDOVER_TIME - MIN_DT)
            }
            Some(fading) => fading.remaining,
            None => HANDOVER_TIME,
        };
        let fades = !self.law.set_steer(self.steer);
        let offset = None;
        self.handover = fades.then_some(Handover { offset, remaining });
    }
}
