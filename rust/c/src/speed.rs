//! How fast: the speed tracker, which plans the speeds along a path and keeps them.

use std::sync::Arc;

use popsteer_core::speed::{
    Phase, SpeedCommand, SpeedTracker, SpeedTrackerParams, SpeedTrackerState, Told,
};
use popsteer_core::{Path, Status, Vehicle};

use crate::command::CVehicleState;
use crate::error::{CError, Failure, guard};
use crate::fields::{Field, answer_fields, c_type, same_fields};
use crate::handle::{self, Handle, given};
use crate::params::{CVehicle, params};
use crate::path::{self, CPath};

popsteer_core::SpeedTrackerParams! { params {
    /// [`SpeedTrackerParams`] for C.
    CSpeedTrackerParams(SpeedTrackerParams)
} }

/// What a step of a speed tracker answers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CSpeedCommand {
    /// Acceleration in the direction of driving [m/s^2]; negative brakes.
    pub acceleration: f64,
    /// Speed to command in the direction of driving [m/s], for a vehicle that takes a speed: never
    /// above the top speed; negative only while it still rolls the other way.
    pub speed: f64,
    /// Speed that the path allows beside the rear axle [m/s], never negative.
    pub reference_speed: f64,
    /// Distance along the path to the next stop [m]: a cusp, the end, or a speed of 0; INFINITY where
    /// there is none.
    pub distance_to_stop: f64,
    /// Whether the vehicle is to drive backwards.
    pub reverse: bool,
    /// Whether the vehicle is to be held where it stands.
    pub standing: bool,
    /// Whether it overruns its stop, however hard it brakes, or stands beyond it.
    pub cannot_stop: bool,
    /// What the vehicle does: `POPSTEER_PHASE_...`.
    pub phase: u32,
    /// What is known of the inputs: `POPSTEER_STATUS_...`.
    pub status: u32,
}

/// Keeps its plan.
pub const POPSTEER_PHASE_DRIVING: u32 = 0;
/// Brakes for a stop.
pub const POPSTEER_PHASE_STOPPING: u32 = 1;
/// Is held at its stop.
pub const POPSTEER_PHASE_STANDING: u32 = 2;
/// Stands until its wheels are turned.
pub const POPSTEER_PHASE_TURNING: u32 = 3;
/// Stands until its gear is in.
pub const POPSTEER_PHASE_SHIFTING: u32 = 4;
/// Brakes or stands as it was told to, for a fault, or as long as nothing is known of it.
pub const POPSTEER_PHASE_STOPPED: u32 = 5;

impl Field<Phase> for u32 {
    fn to_core(self) -> Phase {
        let found = Phase::ALL.into_iter().find(|&phase| phase as Self == self);
        found.unwrap_or_default()
    }

    fn of(value: Phase) -> Self {
        value as Self
    }
}

impl Field<Status> for u32 {
    fn to_core(self) -> Status {
        Status::from_bits(self).unwrap_or(Status::OK)
    }

    fn of(value: Status) -> Self {
        value.bits()
    }
}

answer_fields!(CSpeedCommand, SpeedCommand, {
    acceleration, speed, reference_speed, distance_to_stop, reverse, standing, cannot_stop,
    phase, status
});

/// A speed tracker: the speeds planned along a path, and what keeps them. One thread at a time may
/// use one.
#[derive(Debug)]
pub struct CSpeedTracker {
    _private: (),
}

impl Handle for CSpeedTracker {
    type Value = Paced;
    const MAGIC: u64 = 0x6465_6570_5f73_7004;
    const KIND: &'static str = "speed_tracker";
}

/// What is behind the handle.
#[derive(Debug)]
pub(crate) struct Paced {
    law: SpeedTracker,
    vehicle: Vehicle,
    path: Arc<Path>,
    plan: Vec<f64>,
    state: SpeedTrackerState,
}

/// The defaults of `popsteer_speed_tracker_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_speed_tracker_params_default() -> CSpeedTrackerParams {
    SpeedTrackerParams::DEFAULT.into()
}

/// Makes a speed tracker, and plans the speeds: as fast as the vehicle's limits allow, and at most the
/// path's own. What the vehicle does not limit is limited to 25 m/s, 4 m/s^2 to the side, 2 m/s^2
/// driving and 3 m/s^2 braking; bends take 0.9 of the lateral acceleration.
///
/// `vehicle` and `params` may be NULL for their defaults; they are copied. `path` may be freed
/// afterwards. `out` gets the tracker, which is freed by `popsteer_speed_tracker_free`.
/// `POPSTEER_ERROR_CONFIG` names a field that is out of its range.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_speed_tracker_new(
    path: *const CPath,
    vehicle: *const CVehicle,
    params: *const CSpeedTrackerParams,
    out: *mut *mut CSpeedTracker,
) -> CError {
    let value = || {
        // SAFETY: the caller vouches for the handle and the pointers.
        let (path, vehicle, params) = unsafe {
            (
                path::shared(path)?,
                given(vehicle, "vehicle")?,
                given(params, "params")?,
            )
        };
        let law = SpeedTracker::new(vehicle, params)?;
        let path = Path::for_vehicle(path, &vehicle);
        Ok(Paced {
            law,
            vehicle,
            plan: law.plan(&path.view())?,
            path,
            state: SpeedTrackerState::default(),
        })
    };
    // SAFETY: the caller vouches for `out`.
    guard(|| unsafe { handle::give(out, value) })
}

/// Takes one control step of the speed.
///
/// `vehicle`: pose of the vehicle's point, and speed, negative backwards. `dt`: time since the last
/// step that answered [s], 1e-6 to 1e3. `pose_age`: how long before the step the pose was measured [s],
/// 0 to 1. `out` gets the acceleration, and why.
///
/// Any other finite `dt` counts as no time and holds the last command, as in `popsteer_step`; before the
/// first the vehicle is to stand. Another number that is not finite or beyond its bound is refused as
/// `POPSTEER_ERROR_INPUT`: tracker and `out` are then unchanged. Nothing is allocated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_speed_tracker_step(
    tracker: *mut CSpeedTracker,
    vehicle: CVehicleState,
    dt: f64,
    pose_age: f64,
    out: *mut CSpeedCommand,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for both.
        unsafe {
            handle::place(out)?;
            let paced = handle::of_mut(tracker, "tracker")?;
            let (path, plan, state) = (paced.path.view(), &paced.plan, &mut paced.state);
            let vehicle = vehicle.into();
            let told = Told {
                pose_age,
                ..Told::default()
            };
            let command = (paced.law).step_told(&path, plan, state, vehicle, dt, told)?;
            handle::write(out, command.into())
        }
    })
}

/// Keeps the speeds of another path from the next step on, planned at once: this allocates. Command,
/// estimate and place carry on. `POPSTEER_ERROR_CONFIG` where a limit is out of the range of a plan;
/// nothing has changed then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_speed_tracker_set_path(
    tracker: *mut CSpeedTracker,
    path: *const CPath,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for both.
        let (tracker, path) = unsafe { (handle::of_mut(tracker, "tracker")?, path::shared(path)?) };
        let path = Path::for_vehicle(path, &tracker.vehicle);
        let plan = tracker.law.plan(&path.view())?;
        let (old, new) = (tracker.path.view(), path.view());
        tracker.law.set_path(&mut tracker.state, &old, &new);
        (tracker.plan, tracker.path) = (plan, path);
        Ok(())
    })
}

/// Writes the planned speed at each waypoint into `out` [m/s], never negative: the profile. `out` has
/// room for `size` numbers, and `count`, which may be NULL, gets how many waypoints there are; no more
/// than `size` are written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_speed_tracker_plan(
    tracker: *const CSpeedTracker,
    out: *mut f64,
    size: usize,
    count: *mut usize,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for the handle.
        let plan = unsafe { &handle::of(tracker, "tracker")?.plan };
        // SAFETY: the caller vouches for the room.
        let room = unsafe { handle::room(out, size.min(plan.len()), 0.0, "out")? };
        for (place, &speed) in room.iter_mut().zip(plan) {
            *place = speed;
        }
        if !count.is_null() {
            // SAFETY: not NULL; the caller vouches for the rest.
            unsafe { count.write(plan.len()) };
        }
        Ok(())
    })
}

/// Takes a speed tracker back to before its first step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_speed_tracker_reset(tracker: *mut CSpeedTracker) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        unsafe { handle::of_mut(tracker, "tracker")? }.state = SpeedTrackerState::default();
        Ok::<(), Failure>(())
    })
}

/// Frees a speed tracker; NULL is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_speed_tracker_free(tracker: *mut CSpeedTracker) -> CError {
    // SAFETY: the caller vouches for it.
    guard(|| unsafe { handle::free(tracker, "tracker") })
}
