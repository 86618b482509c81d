//! The whole vehicle in one step: the driver.

use core::ffi::c_char;
use std::sync::Arc;

use popsteer_core::Path;
use popsteer_core::driver::{Drive, Driver, DriverParams, DriverState, Sensed};
use popsteer_core::laws::{Law, LawState};
use popsteer_core::speed::SpeedTracker;
use popsteer_core::vehicle::{Fault, Known};

use crate::command::{CEstimate, CPredicted, CReported, CVehicleState};
use crate::controller::CController;
use crate::error::{CError, Failure, guard};
use crate::fields::{Field, c_type, same_fields};
use crate::handle::{self, Handle, given};
use crate::params::params;
use crate::path::{self, CPath};
use crate::speed::CSpeedTrackerParams;
use crate::step::fill_predicted;

popsteer_core::DriverParams! { params {
    /// [`DriverParams`] for C.
    CDriverParams(DriverParams)
} }

/// What a step of a driver answers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CDrive {
    /// Angle to command [rad], positive to the left.
    pub steer: f64,
    /// Acceleration in the direction of driving [m/s^2]; negative brakes.
    pub acceleration: f64,
    /// Speed to command in the direction of driving [m/s], for a vehicle that takes a speed.
    pub speed: f64,
    /// Offset of the tracked point from the path [m], positive left of it.
    pub cross_track_error: f64,
    /// Yaw less direction of the path [rad], in [-pi, pi].
    pub heading_error: f64,
    /// Cross-track error of the vehicle as it will be when the command reaches the wheels [m].
    pub predicted_cross_track_error: f64,
    /// Heading error of that vehicle [rad].
    pub predicted_heading_error: f64,
    /// The point aimed at [m].
    pub target_x: f64,
    /// The point aimed at [m].
    pub target_y: f64,
    /// The planned speed beside the rear axle [m/s], never negative.
    pub reference_speed: f64,
    /// Distance that the rear axle has to go to the next stop [m]; negative past it, INFINITY if
    /// there is none.
    pub distance_to_stop: f64,
    /// How the step went: `POPSTEER_STATUS_...` bits.
    pub status: u32,
    /// What the vehicle does, as of `popsteer_speed_command`.
    pub phase: u32,
    /// Why the vehicle stops, or has stopped; 0: it drives. `popsteer_fault_name` names it.
    pub fault: u32,
    /// Whether the vehicle is to be in reverse gear.
    pub reverse: bool,
    /// Whether the vehicle is to be held where it stands.
    pub hold: bool,
}

/// The number of a fault: its place among all, from 1 on.
fn number(fault: Option<Fault>) -> u32 {
    let place = fault.and_then(|fault| Fault::ALL.iter().position(|each| *each == fault));
    place.map_or(0, |place| u32::try_from(place + 1).unwrap_or(0))
}

impl From<Drive> for CDrive {
    #[inline]
    fn from(drive: Drive) -> Self {
        Self {
            steer: drive.steer,
            acceleration: drive.acceleration,
            speed: drive.speed,
            cross_track_error: drive.cross_track_error,
            heading_error: drive.heading_error,
            predicted_cross_track_error: drive.predicted_cross_track_error,
            predicted_heading_error: drive.predicted_heading_error,
            target_x: drive.target.x,
            target_y: drive.target.y,
            reference_speed: drive.reference_speed,
            distance_to_stop: drive.distance_to_stop,
            status: drive.status.bits(),
            phase: Field::of(drive.phase),
            fault: number(drive.fault),
            reverse: drive.reverse,
            hold: drive.hold,
        }
    }
}

/// A driver: who steers and drives along which path, and what is remembered. One thread at a time may
/// use one.
#[derive(Debug)]
pub struct CDriver {
    _private: (),
}

impl Handle for CDriver {
    type Value = Driving;
    const MAGIC: u64 = 0x7265_7664_5f73_7006;
    const KIND: &'static str = "driver";
}

/// What is behind the handle.
#[derive(Debug)]
pub(crate) struct Driving {
    driver: Driver<Law>,
    state: DriverState<LawState>,
    path: Arc<Path>,
    plan: Vec<f64>,
}

/// The defaults of `popsteer_driver_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_driver_params_default() -> CDriverParams {
    DriverParams::DEFAULT.into()
}

/// The name of a fault of `popsteer_drive`, such as "position": what it blames. NULL for 0 and for a
/// number of none. "position", "heading", "speed": that signal; "steering": the vehicle turns otherwise
/// than commanded; "input": nothing comes; "deviation": too far off the path; "path": the path is not
/// where the vehicle is; "cannot-stop": it overruns its stop, however hard it brakes.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_fault_name(fault: u32) -> *const c_char {
    const NAMES: [&core::ffi::CStr; Fault::ALL.len()] = [
        c"position",
        c"heading",
        c"speed",
        c"steering",
        c"input",
        c"deviation",
        c"path",
        c"cannot-stop",
    ];
    let place = usize::try_from(fault)
        .ok()
        .and_then(|fault| fault.checked_sub(1));
    let name = place.and_then(|place| NAMES.get(place));
    name.map_or(core::ptr::null(), |name| name.as_ptr())
}

/// Makes a driver that steers by a copy of `controller`, along its path, and plans its speeds: as fast as
/// the vehicle's limits allow, and at most the path's own.
///
/// `speed` and `params` may be NULL for their defaults. `controller` may be freed afterwards. `out` gets
/// the driver, which is freed by `popsteer_driver_free`. `POPSTEER_ERROR_CONFIG` names a field that is
/// out of its range.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_driver_new(
    controller: *const CController,
    speed: *const CSpeedTrackerParams,
    params: *const CDriverParams,
    out: *mut *mut CDriver,
) -> CError {
    let value = || {
        // SAFETY: the caller vouches for the handle and the pointers.
        let (controller, speed, params) = unsafe {
            (
                handle::of(controller, "controller")?,
                given(speed, "speed")?,
                given(params, "params")?,
            )
        };
        let tracker = controller.tracker;
        let speed = SpeedTracker::new(*tracker.vehicle(), speed)?;
        let driver = Driver::new(tracker, speed, params)?;
        let path = Arc::clone(&controller.path);
        Ok(Driving {
            state: driver.initial_state(),
            plan: speed.plan(&path.view())?,
            driver,
            path,
        })
    };
    // SAFETY: the caller vouches for `out`.
    guard(|| unsafe { handle::give(out, value) })
}

/// Takes one control step, and answers whatever comes in.
///
/// `vehicle`: pose of the vehicle's point, and speed; a number that is not finite or beyond its bound has
/// not come, and what is expected stands in for it, until that is a fault. `dt`: time since the last
/// step [s]; one that is none, as of a stamp that repeats, counts as no time. `reported`: what the
/// vehicle reports besides, or NULL. `gear`: 1 where reverse gear is in, 0 where it is not, negative
/// where that is not reported. `out` gets what to do.
///
/// Only NULL and wrong handles are errors. Nothing is allocated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_driver_step(
    driver: *mut CDriver,
    vehicle: CVehicleState,
    dt: f64,
    reported: *const CReported,
    gear: i32,
    out: *mut CDrive,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for all three.
        unsafe {
            handle::place(out)?;
            let sensed = Sensed {
                vehicle: vehicle.into(),
                reported: given(reported, "reported")?,
                gear: (gear >= 0).then_some(gear > 0),
            };
            let Driving {
                driver,
                state,
                path,
                plan,
            } = handle::of_mut(driver, "driver")?;
            let drive = driver.step(&path.view(), plan, state, sensed, dt);
            handle::write(out, drive.into())
        }
    })
}

/// Follows another path from the next step on, its speeds planned at once: this allocates. Place, angle
/// and estimates carry on. `POPSTEER_ERROR_CONFIG` where a limit is out of the range of a plan; nothing
/// has changed then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_driver_set_path(
    driver: *mut CDriver,
    path: *const CPath,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for both.
        let (it, path) = unsafe { (handle::of_mut(driver, "driver")?, path::shared(path)?) };
        let path = Path::for_vehicle(path, it.driver.vehicle());
        let plan = it.driver.speed().plan(&path.view())?;
        it.driver
            .set_path(&mut it.state, &it.path.view(), &path.view());
        (it.plan, it.path) = (plan, path);
        Ok(())
    })
}

/// Brakes the vehicle to a stand in comfort, and holds it, for as long as `held` is true: the operator's
/// stop.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_driver_hold(driver: *mut CDriver, held: bool) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        unsafe { handle::of_mut(driver, "driver")? }.state.held = held;
        Ok::<(), Failure>(())
    })
}

/// Forgets the fault for which the vehicle stopped, and drives again: it is looked for about its last
/// place. `fault`, which may be NULL, gets what it was.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_driver_release(driver: *mut CDriver, fault: *mut u32) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        let it = unsafe { handle::of_mut(driver, "driver")? };
        let released = number(it.driver.release(&mut it.state));
        if !fault.is_null() {
            // SAFETY: not NULL; the caller vouches for the rest.
            unsafe { fault.write(released) };
        }
        Ok::<(), Failure>(())
    })
}

/// Takes a driver back to before its first step, with the wheels at the angle `steer` [rad], from which
/// it goes on without a jump.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_driver_reset(driver: *mut CDriver, steer: f64) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        let it = unsafe { handle::of_mut(driver, "driver")? };
        it.state = it.driver.state_from(steer)?;
        Ok(())
    })
}

/// Writes to `out` what the motion has shown of the vehicle so far.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_driver_estimate(
    driver: *const CDriver,
    out: *mut CEstimate,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for both.
        unsafe {
            let Driving { driver, state, .. } = handle::of(driver, "driver")?;
            let tracker = driver.tracker();
            let estimate = Known::of(driver.vehicle(), &tracker.estimate(&state.tracker));
            handle::write(out, estimate.into())
        }
    })
}

/// Predicts the trajectory that the vehicle is to take, one instant every `dt` [s] from the last step on,
/// into the `size` instants at `out`; `count`, which may be NULL, gets how many were written. Arguments
/// as of `popsteer_predict`.
///
/// A copy of the driver steers and drives the vehicle as estimated: through cusps, and to its stop, or to
/// rest where it stops for a fault. `POPSTEER_ERROR_NO_STEP` before the first step. Nothing is allocated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_driver_predict(
    driver: *const CDriver,
    dt: f64,
    out: *mut CPredicted,
    size: usize,
    count: *mut usize,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for the handle and for the room.
        unsafe {
            let Driving {
                driver,
                state,
                path,
                plan,
            } = handle::of(driver, "driver")?;
            fill_predicted(out, size, count, |room| {
                if state.tracker.answer.is_none() {
                    return Err(Failure::NoStep);
                }
                Ok(driver.predict(&path.view(), plan, state, dt, room)?)
            })
        }
    })
}

/// Frees a driver; NULL is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_driver_free(driver: *mut CDriver) -> CError {
    // SAFETY: the caller vouches for it.
    guard(|| unsafe { handle::free(driver, "driver") })
}
