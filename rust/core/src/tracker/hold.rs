//! Missing and refused inputs: the last command is held, and the next step covers their time.

use crate::bounds::{MAX_DT, MIN_DT};
use crate::error::InputError;
use crate::laws::LateralLaw;
use crate::math::saturate;
use crate::path::view::PathView;
use crate::status::{HOLD_LIMIT, Status};
use crate::tracker::state::{TrackerState, Tracking};
use crate::tracker::{Command, Reported, Tracker};
use crate::vehicle::state::checked_dt;
use crate::vehicle::{Estimator, VehicleState};

/// Longest period whose motion is used for estimates [s]: what happened within a longer one is not
/// known well enough. Larger values allow slower loops, and let gaps disturb the estimates. Poses that
/// tell their age may lie farther apart: what the wheels did between them is remembered.
pub const ESTIMATION_GAP: f64 = 1.0;

impl<L: LateralLaw> Tracker<L> {
    /// A step that never fails: where [`step`](Self::step) refuses the input, too, the
    /// last command is held, its angle, direction, errors and target, with the status
    /// [`Status::INPUT_HELD`] for up to `hold_limit` inputs in a row and [`Status::INPUT_LOST`]
    /// beyond.
    ///
    /// The time `dt` of an input that is refused is added to the next step, which then is one step over
    /// the whole time, and has to report for all of it: what is `reported` with a held input is
    /// ignored. A `dt` that is no control period counts as no time: a clock that repeats a stamp, or goes
    /// back, shows the time with its next stamp, and one that leaps ahead is not believed.
    pub fn step_or_hold(
        &self,
        path: &PathView<'_>,
        state: &mut TrackerState<L::State>,
        vehicle: VehicleState,
        dt: f64,
        hold_limit: usize,
        reported: Reported,
    ) -> Command {
        let TrackerState { tracking, model } = state;
        let outcome = self.advance(path, tracking, model, vehicle, dt, reported);
        tracking.or_hold(outcome, dt, hold_limit)
    }
}

impl<S> Tracking<S> {
    /// The command of [`Tracker::step_or_hold`] for an input `dt` [s] after the last, of which
    /// [`Tracker::advance`] makes this `outcome`.
    pub fn or_hold(
        &mut self,
        outcome: Result<Status, InputError>,
        dt: f64,
        hold_limit: usize,
    ) -> Command {
        let status = outcome.unwrap_or_else(|_| self.hold(dt));
        self.command(match self.held {
            0 => status,
            count => Status::held(count, hold_limit),
        })
    }

    /// Holds the last command for an input that came `dt` [s] after the last: the next step covers its
    /// time, which is none where `dt` is no control period.
    pub fn hold(&mut self, dt: f64) -> Status {
        let dt = checked_dt(dt).unwrap_or(0.0);
        self.held_time = saturate(self.held_time + dt, 0.0, MAX_DT);
        self.held = self.held.saturating_add(1);
        Status::held(self.held, HOLD_LIMIT)
    }

    /// The time since the last step [s] of an input that comes in `dt` [s] after the last, missed
    /// or not; no time has been missed then.
    #[inline]
    pub(super) fn elapse(&mut self, estimator: &mut Estimator, dt: f64) -> f64 {
        let elapsed = saturate(self.held_time + dt, MIN_DT, MAX_DT);
        self.held_time = 0.0;
        self.period = elapsed;
        if elapsed > ESTIMATION_GAP {
            estimator.last_measured = None;
            // What it was before the gap says nothing of now.
            estimator.estimate.acceleration = 0.0;
        }
        elapsed
    }
}
