//! The conditions of a step: the core's bits by name.

use core::ffi::c_char;

use popsteer_core::Status;

use crate::error::Text;

/// Degraded: more angle, lateral acceleration or speed of the wheels is wanted than the vehicle
/// allows. The command is limited.
pub const POPSTEER_STATUS_SATURATED: u32 = 1;
/// Degraded: no point ahead lies on the lookahead circle. A stand-in is aimed at.
pub const POPSTEER_STATUS_LOOKAHEAD_LOST: u32 = 2;
/// Degraded: past the end of the path. The last segment is followed on as a straight line.
pub const POPSTEER_STATUS_END_OF_PATH: u32 = 4;
/// Degraded: the vehicle was farther than `lost_distance` from its place on the path, and was
/// looked for on the whole of it.
pub const POPSTEER_STATUS_OFF_PATH: u32 = 8;
/// Degraded: the input was refused, or its `dt` is no control period. The last command is held.
pub const POPSTEER_STATUS_INPUT_HELD: u32 = 16;
/// Fault: the same of more inputs in a row than are held. Stop.
pub const POPSTEER_STATUS_INPUT_LOST: u32 = 32;
/// Fault: the measured cross-track error is beyond `deviation_limit`, once it was within.
pub const POPSTEER_STATUS_DEVIATING: u32 = 64;
/// Fault: the vehicle turns otherwise than the commands explain, or did so within the last 2 s, or
/// its poses and its speed do not belong together.
pub const POPSTEER_STATUS_IMPLAUSIBLE: u32 = 128;
/// Degraded: the best plan within the vehicle's limits was not found in the time that a step may
/// take. The command is that of the best plan found.
pub const POPSTEER_STATUS_PLAN_CUT_SHORT: u32 = 256;
/// Degraded: the position repeats the last one, though the vehicle drives; it is rolled forward.
pub const POPSTEER_STATUS_POSE_STALE: u32 = 512;
/// Degraded: the pose is farther off than speed and wheels explain; the expected one takes its
/// place.
pub const POPSTEER_STATUS_OUTLIER: u32 = 1024;
/// Degraded, with `POPSTEER_STATUS_SATURATED`: the largest angle of the wheels limits.
pub const POPSTEER_STATUS_STEER_LIMIT: u32 = 2048;
/// Degraded, with `POPSTEER_STATUS_SATURATED`: the rate of the wheels limits.
pub const POPSTEER_STATUS_RATE_LIMIT: u32 = 4096;
/// Degraded, with `POPSTEER_STATUS_SATURATED`: the lateral acceleration limits.
pub const POPSTEER_STATUS_LATERAL_LIMIT: u32 = 8192;
/// Degraded: the lateral acceleration is beyond the vehicle's limit by the measured turn, or, for
/// preview POP, will be in a bend ahead even if the vehicle brakes in comfort.
pub const POPSTEER_STATUS_TOO_FAST: u32 = 16384;
/// All faults: stop the vehicle where any of these bits is set.
pub const POPSTEER_STATUS_FAULTS: u32 = 224;

const NAMED: [(u32, Status); 15] = [
    (POPSTEER_STATUS_SATURATED, Status::SATURATED),
    (POPSTEER_STATUS_LOOKAHEAD_LOST, Status::LOOKAHEAD_LOST),
    (POPSTEER_STATUS_END_OF_PATH, Status::END_OF_PATH),
    (POPSTEER_STATUS_OFF_PATH, Status::OFF_PATH),
    (POPSTEER_STATUS_INPUT_HELD, Status::INPUT_HELD),
    (POPSTEER_STATUS_INPUT_LOST, Status::INPUT_LOST),
    (POPSTEER_STATUS_DEVIATING, Status::DEVIATING),
    (POPSTEER_STATUS_IMPLAUSIBLE, Status::IMPLAUSIBLE),
    (POPSTEER_STATUS_PLAN_CUT_SHORT, Status::PLAN_CUT_SHORT),
    (POPSTEER_STATUS_POSE_STALE, Status::POSE_STALE),
    (POPSTEER_STATUS_OUTLIER, Status::OUTLIER),
    (POPSTEER_STATUS_STEER_LIMIT, Status::STEER_LIMIT),
    (POPSTEER_STATUS_RATE_LIMIT, Status::RATE_LIMIT),
    (POPSTEER_STATUS_LATERAL_LIMIT, Status::LATERAL_LIMIT),
    (POPSTEER_STATUS_TOO_FAST, Status::TOO_FAST),
];

// The core's bits, each with a name, and its faults.
const _: () = {
    assert!(NAMED.len() == Status::NAMES.len());
    let (mut index, mut faults) = (0, 0);
    while index < NAMED.len() {
        let (bits, status) = NAMED[index];
        assert!(bits == status.bits() && bits == Status::NAMES[index].0.bits());
        faults |= status.faults().bits();
        index += 1;
    }
    assert!(faults == POPSTEER_STATUS_FAULTS);
};

/// Writes the names of the conditions that hold, such as "saturated|end-of-path", or "ok": at most
/// `size` bytes into `buffer`, the final NUL included. Returns the length of all of it without the
/// NUL, as snprintf does; 255 bytes are always enough. Bits that stand for no condition have no
/// name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_status_names(
    status: u32,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    let known = NAMED.iter().fold(0, |all, (bits, _)| all | bits);
    let status = Status::from_bits(status & known).unwrap_or(Status::OK);
    // SAFETY: the caller vouches for it.
    unsafe { Text::new(buffer, size) }.show(status)
}
