//! Controllers: one of the core's, its state and its path, in one allocation.

use std::sync::Arc;

use popsteer_core::laws::{Law, LawState};
use popsteer_core::tracker::{Reported, TrackerState};
use popsteer_core::vehicle::Known;
use popsteer_core::{Command, InputError, Path, Tracker, VehicleState};

use crate::command::CEstimate;
use crate::error::{CError, guard};
use crate::handle::{self, Handle};
use crate::path::{self, CPath};

/// A controller: who steers along which path, and what is remembered. One thread at a time may use
/// one; different ones on different threads are independent of each other.
#[derive(Debug)]
pub struct CController {
    _private: (),
}

impl Handle for CController {
    type Value = Controller;
    const MAGIC: u64 = 0x726c_7463_5f73_7002;
    const KIND: &'static str = "controller";
}

/// What is behind the handle: any of the controllers, and what it remembers.
#[derive(Clone, Debug)]
pub(crate) struct Controller {
    pub(crate) path: Arc<Path>,
    pub(crate) tracker: Tracker<Law>,
    pub(crate) state: TrackerState<LawState>,
}

impl Controller {
    #[inline]
    pub(crate) fn step(
        &mut self,
        vehicle: VehicleState,
        dt: f64,
        reported: Reported,
    ) -> Result<Command, InputError> {
        let path = &self.path.view();
        self.tracker
            .step(path, &mut self.state, vehicle, dt, reported)
    }

    #[inline]
    pub(crate) fn step_or_hold(
        &mut self,
        vehicle: VehicleState,
        dt: f64,
        hold_limit: usize,
        reported: Reported,
    ) -> Command {
        let path = &self.path.view();
        self.tracker
            .step_or_hold(path, &mut self.state, vehicle, dt, hold_limit, reported)
    }

    /// Refuses what a step with these inputs would refuse.
    pub(crate) fn check(
        &self,
        vehicle: VehicleState,
        reported: Reported,
    ) -> Result<(), InputError> {
        vehicle.checked()?;
        reported.checked(self.tracker.vehicle()).map(|_| ())
    }

    pub(crate) fn reset(&mut self) {
        self.state = self.tracker.initial_state();
    }

    pub(crate) fn set_path(&mut self, path: Arc<Path>) {
        let path = Path::for_vehicle(path, self.tracker.vehicle());
        let (old, new) = (self.path.view(), path.view());
        self.tracker.set_path(&mut self.state, &old, &new);
        self.path = path;
    }
}

/// Takes a controller back to before its first step, with straight wheels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_controller_reset(controller: *mut CController) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        unsafe { handle::of_mut(controller, "controller")? }.reset();
        Ok(())
    })
}

/// Takes a controller back to before its first step, for a vehicle that a driver hands over,
/// steering at the angle `steer` [rad]: it goes on from there without a jump.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_controller_reset_to(
    controller: *mut CController,
    steer: f64,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        let controller = unsafe { handle::of_mut(controller, "controller")? };
        controller.state = controller.tracker.state_from(steer)?;
        Ok(())
    })
}

/// Follows another path from the next step on; may be called before every step, as a planner gives
/// its paths. The place on the new path is that of the last step; integral, estimate and commands in
/// flight carry on. The old path is freed here if nobody else holds it: to have no memory freed in
/// the control loop, free its handle elsewhere, later.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_controller_set_path(
    controller: *mut CController,
    path: *const CPath,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for both.
        let (controller, path) = unsafe {
            (
                handle::of_mut(controller, "controller")?,
                path::shared(path)?,
            )
        };
        controller.set_path(path);
        Ok(())
    })
}

/// Finds the vehicle's place on the whole path anew, after a jump of the vehicle or of its
/// localisation. Exact, but on long paths slower than a step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_controller_relocalise(
    controller: *mut CController,
    x: f64,
    y: f64,
    yaw: f64,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        let controller = unsafe { handle::of_mut(controller, "controller")? };
        let Controller {
            path,
            tracker,
            state,
        } = controller;
        tracker.relocalise(&path.view(), state, x, y, yaw)?;
        Ok(())
    })
}

/// Writes to `out` what the motion has shown of the vehicle so far.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_controller_estimate(
    controller: *const CController,
    out: *mut CEstimate,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for both.
        unsafe {
            let Controller { tracker, state, .. } = handle::of(controller, "controller")?;
            let estimate = Known::of(tracker.vehicle(), &tracker.estimate(state));
            handle::write(out, estimate.into())
        }
    })
}

/// How far ahead of the pose's point the tracked point lies [m], driving forward: the point whose
/// errors a command tells; NAN where `controller` is no controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_controller_tracked_point(controller: *const CController) -> f64 {
    let mut ahead = f64::NAN;
    guard(|| {
        // SAFETY: the caller vouches for it.
        ahead = unsafe { handle::of(controller, "controller")? }
            .tracker
            .tracked_point();
        Ok(())
    });
    ahead
}

/// Makes a second controller that stands where `controller` stands: to try something, or to go back
/// to it. It follows the same path.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_controller_clone(
    controller: *const CController,
    out: *mut *mut CController,
) -> CError {
    // SAFETY: the caller vouches for both.
    guard(|| unsafe { handle::give(out, || Ok(handle::of(controller, "controller")?.clone())) })
}

/// Frees a controller; NULL is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_controller_free(controller: *mut CController) -> CError {
    // SAFETY: the caller vouches for it.
    guard(|| unsafe { handle::free(controller, "controller") })
}
