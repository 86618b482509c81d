//! The control step, and the trajectory that a controller intends.

use core::mem::offset_of;

use popsteer_core::VehicleState;
use popsteer_core::tracker::Predicted;

use crate::command::{CCommand, CPredicted, CReported, CVehicleState};
use crate::controller::{CController, Controller};
use crate::error::{CError, Failure, guard};
use crate::handle;

/// Takes one control step.
///
/// `vehicle`: pose of the vehicle's point, and speed. `dt`: time since the last step that answered
/// [s], 1e-6 to 1e3. `reported`: what was applied, and how old the pose is; NULL where there is
/// nothing to report. `out` gets the command.
///
/// Any other finite `dt`, of a clock that was set or repeats a stamp, counts as no time: `out` gets the
/// last command with `POPSTEER_STATUS_INPUT_HELD`, and beyond 10 in a row
/// `POPSTEER_STATUS_INPUT_LOST`. Another number that is not finite or beyond its bound is refused as
/// `POPSTEER_ERROR_INPUT`: controller and `out` are then unchanged. Nothing is allocated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_step(
    controller: *mut CController,
    vehicle: CVehicleState,
    dt: f64,
    reported: *const CReported,
    out: *mut CCommand,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for all three.
        unsafe {
            handle::place(out)?;
            let reported = handle::given(reported, "reported")?;
            let controller = handle::of_mut(controller, "controller")?;
            let command = controller.step(vehicle.into(), dt, reported)?;
            handle::write(out, command.into())
        }
    })
}

/// Takes one control step, and answers whatever comes in: where `popsteer_step` would refuse the
/// input, too, `out` gets the last command with `POPSTEER_STATUS_INPUT_HELD`, for up to `hold_limit`
/// inputs in a row, and `POPSTEER_STATUS_INPUT_LOST` beyond. Only NULL and wrong handles are errors.
///
/// `dt` is the time since the last call [s]; one out of 1e-6 to 1e3 counts as no time. The next
/// step counts the time of those that were held, but for the rate limit: a held angle does not turn.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_step_or_hold(
    controller: *mut CController,
    vehicle: CVehicleState,
    dt: f64,
    hold_limit: usize,
    reported: *const CReported,
    out: *mut CCommand,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for all three.
        unsafe {
            handle::place(out)?;
            let reported = handle::given(reported, "reported")?;
            let controller = handle::of_mut(controller, "controller")?;
            let command = controller.step_or_hold(vehicle.into(), dt, hold_limit, reported);
            handle::write(out, command.into())
        }
    })
}

// Both are six numbers in the same order: the caller's array is the core's.
const _: () = {
    assert!(size_of::<CPredicted>() == size_of::<Predicted>());
    assert!(align_of::<CPredicted>() == align_of::<Predicted>());
    assert!(offset_of!(CPredicted, time) == offset_of!(Predicted, time));
    assert!(offset_of!(CPredicted, vehicle) == offset_of!(Predicted, vehicle));
    assert!(offset_of!(CPredicted, steer) == offset_of!(Predicted, steer));
    assert!(offset_of!(CVehicleState, x) == offset_of!(VehicleState, x));
    assert!(offset_of!(CVehicleState, y) == offset_of!(VehicleState, y));
    assert!(offset_of!(CVehicleState, yaw) == offset_of!(VehicleState, yaw));
    assert!(offset_of!(CVehicleState, speed) == offset_of!(VehicleState, speed));
};

/// Writes the trajectory that a controller intends from the last step on into `out`, which has room
/// for `size` instants, one each `dt` [s], the last step itself first. `count`, which may be NULL,
/// gets how many were written: fewer than `size` where the trajectory leaves all bounds.
///
/// A copy of the controller drives the vehicle as it is known by now, at its present acceleration,
/// and to the next stop at most. The controller stays as it is. `POPSTEER_ERROR_NO_STEP` before the
/// first step. Nothing is allocated; the time it takes is that of `size` steps.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_predict(
    controller: *const CController,
    dt: f64,
    out: *mut CPredicted,
    size: usize,
    count: *mut usize,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for the handle and for the room.
        unsafe {
            let Controller {
                path,
                tracker,
                state,
            } = handle::of(controller, "controller")?;
            fill_predicted(out, size, count, |room| {
                if state.answer.is_none() {
                    return Err(Failure::NoStep);
                }
                Ok(tracker.predict(&path.view(), state, dt, room)?)
            })
        }
    })
}

/// Lets `predict` write into the room for `size` instants at `out`; `count`, which may be NULL, gets how many
/// it wrote.
///
/// # Safety
///
/// `out` is NULL or has that room, and `count` is NULL or valid for writing.
pub(crate) unsafe fn fill_predicted(
    out: *mut CPredicted,
    size: usize,
    count: *mut usize,
    predict: impl FnOnce(&mut [Predicted]) -> Result<usize, Failure>,
) -> Result<(), Failure> {
    // SAFETY: the caller vouches for the room, whose layout is the core's.
    let room = unsafe { handle::room(out.cast::<Predicted>(), size, Predicted::DEFAULT, "out")? };
    let written = predict(room)?;
    if !count.is_null() {
        // SAFETY: not NULL; the caller vouches for the rest.
        unsafe { count.write(written) };
    }
    Ok(())
}
