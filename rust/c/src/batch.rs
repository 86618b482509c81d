//! Many vehicles in one call, on the calling thread.

use popsteer_core::tracker::Reported;
use popsteer_core::vehicle::state::period;

use crate::command::{CCommand, CReported, CVehicleState};
use crate::controller::{CController, Controller};
use crate::error::{CError, Failure, guard};
use crate::handle::{self, Handle};
use crate::path::{self, CPath};

/// Many vehicles, each with its controller. One thread at a time may use a batch; for several
/// threads make a batch for each.
#[derive(Debug)]
pub struct CBatch {
    _private: (),
}

impl Handle for CBatch {
    type Value = Vec<Controller>;
    const MAGIC: u64 = 0x6863_7462_5f73_7003;
    const KIND: &'static str = "batch";
}

/// Makes a batch of copies of `count` controllers, in the state in which they are; they may be of
/// several kinds, and may be freed afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_batch_new(
    controllers: *const *const CController,
    count: usize,
    out: *mut *mut CBatch,
) -> CError {
    let value = || {
        // SAFETY: the caller vouches for the array.
        let controllers = unsafe { handle::items(controllers, count, "controllers")? };
        let mut members = Vec::new();
        members
            .try_reserve_exact(count)
            .map_err(|_| Failure::Memory)?;
        for &controller in controllers {
            // SAFETY: the caller vouches for each.
            members.push(unsafe { handle::of(controller, "controllers[...]")? }.clone());
        }
        Ok(members)
    };
    // SAFETY: the caller vouches for `out`.
    guard(|| unsafe { handle::give(out, value) })
}

/// How many vehicles a batch has; 0 where `batch` is no batch.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_batch_size(batch: *const CBatch) -> usize {
    let mut size = 0;
    guard(|| {
        // SAFETY: the caller vouches for it.
        size = unsafe { handle::of(batch, "batch")? }.len();
        Ok(())
    });
    size
}

/// Checks lengths of arrays before a step, for languages whose arrays know theirs: `vehicles` and
/// `out` have to be as long as the batch, and `reported` too, or 0. `POPSTEER_ERROR_INPUT` where
/// one is not; the message names it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_batch_check_lengths(
    batch: *const CBatch,
    vehicles: usize,
    reported: usize,
    out: usize,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        let count = unsafe { handle::of(batch, "batch")? }.len();
        let reported = if reported == 0 { count } else { reported };
        for (name, length) in [("vehicles", vehicles), ("reported", reported), ("out", out)] {
            if length != count {
                return Err(Failure::Length(name, length, count));
            }
        }
        Ok(())
    })
}

/// The vehicles of a batch, and what goes into a step of each.
type Arrays<'a> = (&'a mut [Controller], &'a [CVehicleState], &'a [CReported]);

/// A batch and the arrays that go into a step of it.
///
/// # Safety
///
/// `batch` is NULL or a handle that no one else uses; the arrays are NULL or as long as it.
unsafe fn arrays<'a>(
    batch: *mut CBatch,
    vehicles: *const CVehicleState,
    reported: *const CReported,
    out: *mut CCommand,
) -> Result<Arrays<'a>, Failure> {
    // SAFETY: the caller vouches for the handle.
    let members = unsafe { handle::of_mut(batch, "batch")? };
    let count = members.len();
    if count > 0 {
        handle::place(out)?;
    }
    // SAFETY: the caller vouches for the arrays.
    unsafe {
        let vehicles = handle::items(vehicles, count, "vehicles")?;
        let given = if reported.is_null() { 0 } else { count };
        Ok((
            members,
            vehicles,
            handle::items(reported, given, "reported")?,
        ))
    }
}

fn reported_of(reported: &[CReported], vehicle: usize) -> Reported {
    reported
        .get(vehicle)
        .map_or(Reported::NOTHING, |&reported| reported.into())
}

/// Takes one control step with every vehicle: `vehicles` and `out` have an entry for each, and so
/// has `reported`, which may be NULL. Each answer is that of `popsteer_step`, to the bit.
///
/// Where an input is refused, `POPSTEER_ERROR_INPUT`, no vehicle has moved and `out` is unchanged;
/// the message names the first of them. Nothing is allocated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_batch_step(
    batch: *mut CBatch,
    vehicles: *const CVehicleState,
    dt: f64,
    reported: *const CReported,
    out: *mut CCommand,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for all four.
        let (members, vehicles, reported) = unsafe { arrays(batch, vehicles, reported, out)? };
        period(dt)?;
        for (index, (member, &vehicle)) in members.iter().zip(vehicles).enumerate() {
            member
                .check(vehicle.into(), reported_of(reported, index))
                .map_err(|error| Failure::InputOf(index, error))?;
        }
        for (index, (member, &vehicle)) in members.iter_mut().zip(vehicles).enumerate() {
            let command = member
                .step(vehicle.into(), dt, reported_of(reported, index))
                .map_err(|error| Failure::InputOf(index, error))?;
            // SAFETY: within the array, which is as long as the batch.
            unsafe { out.add(index).write(command.into()) };
        }
        Ok(())
    })
}

/// Takes one control step with every vehicle, and answers whatever comes in: each answer is that of
/// `popsteer_step_or_hold`, to the bit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_batch_step_or_hold(
    batch: *mut CBatch,
    vehicles: *const CVehicleState,
    dt: f64,
    hold_limit: usize,
    reported: *const CReported,
    out: *mut CCommand,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for all four.
        let (members, vehicles, reported) = unsafe { arrays(batch, vehicles, reported, out)? };
        for (index, (member, &vehicle)) in members.iter_mut().zip(vehicles).enumerate() {
            let reported = reported_of(reported, index);
            let command = member.step_or_hold(vehicle.into(), dt, hold_limit, reported);
            // SAFETY: within the array, which is as long as the batch.
            unsafe { out.add(index).write(command.into()) };
        }
        Ok(())
    })
}

/// Has one vehicle follow another path from its next step on; see `popsteer_controller_set_path`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_batch_set_path(
    batch: *mut CBatch,
    vehicle: usize,
    path: *const CPath,
) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for both.
        let (members, path) = unsafe { (handle::of_mut(batch, "batch")?, path::shared(path)?) };
        let count = members.len();
        let member = members.get_mut(vehicle);
        member
            .ok_or(Failure::NoVehicle(vehicle, count))?
            .set_path(path);
        Ok(())
    })
}

/// Takes every vehicle back to before its first step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_batch_reset(batch: *mut CBatch) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        unsafe { handle::of_mut(batch, "batch")? }
            .iter_mut()
            .for_each(Controller::reset);
        Ok(())
    })
}

/// Frees a batch; NULL is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_batch_free(batch: *mut CBatch) -> CError {
    // SAFETY: the caller vouches for it.
    guard(|| unsafe { handle::free(batch, "batch") })
}
