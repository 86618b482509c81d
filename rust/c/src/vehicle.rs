//! The vehicle: a plain struct that is copied into each controller.

use popsteer_core::Vehicle;

use crate::error::{CError, guard};
use crate::fields::same_fields;
use crate::handle::read;

/// All that is true of a car-like vehicle, given once. Begin with `popsteer_vehicle_default()` and
/// change what is known; a field marked "NAN: ..." need not be known.
///
/// A pose is always that of the vehicle's point, wherever it is measured; the axles are given from
/// there. One chain leads from a command to the motion:
///
///     wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, +-max_steer_rate)
///     |wheel| <= max_steer
///     yaw'   = speed tan(wheel) / (turning_wheelbase + understeer speed^2)
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CVehicle {
    /// Distance of the axles [m], 1e-3 to 1e3; the default lengths of all parameters scale with it.
    pub wheelbase: f64,
    /// How far ahead of the pose's point the rear axle lies [m]: 0 where the pose is the rear
    /// axle's, negative where it is of a point ahead of that.
    pub rear_axle: f64,
    /// How far ahead of the pose's point lies the no-slip point [m], the one that moves along the
    /// vehicle's heading; NAN: the rear axle.
    pub no_slip_point: f64,
    /// The wheelbase that the vehicle turns by [m]; NAN: `wheelbase`.
    pub turning_wheelbase: f64,
    /// Understeer gradient [s^2/m].
    pub understeer: f64,
    /// Angle of the wheels at the command 0 [rad].
    pub steer_offset: f64,
    /// Time constant of the wheels' first-order response to a command [s].
    pub steer_lag: f64,
    /// Time from a command to its first effect on the wheels [s].
    pub dead_time: f64,
    /// Largest angle of the front wheels [rad].
    pub max_steer: f64,
    /// Fastest move of the front wheels [rad/s]; NAN: no limit.
    pub max_steer_rate: f64,
    /// Largest lateral acceleration that a command may ask for [m/s^2]; NAN: no limit.
    pub max_lateral_acceleration: f64,
    /// Top speed [m/s]; NAN: no limit.
    pub max_speed: f64,
    /// Largest driving acceleration [m/s^2]; NAN: not known.
    pub max_acceleration: f64,
    /// Largest braking deceleration [m/s^2]; NAN: not known.
    pub max_deceleration: f64,
    /// Time constant with which the drive answers the pedals [s].
    pub drive_lag: f64,
}

same_fields!(CVehicle, Vehicle, {
    wheelbase,
    rear_axle,
    no_slip_point,
    turning_wheelbase,
    understeer,
    steer_offset,
    steer_lag,
    dead_time,
    max_steer,
    max_steer_rate,
    max_lateral_acceleration,
    max_speed,
    max_acceleration,
    max_deceleration,
    drive_lag,
});

/// The paper's wheelbase (3 m) and largest angle (1.22 rad), a lag of 0.1 s, 4 m/s^2 of lateral
/// acceleration; the pose is the rear axle's.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_vehicle_default() -> CVehicle {
    Vehicle::DEFAULT.into()
}

/// Whether every field is within its range; `POPSTEER_ERROR_CONFIG` and a message that names it
/// where one is not. Controllers check their vehicle by themselves.
///
/// # Safety
///
/// `vehicle` is NULL or leads to a vehicle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_vehicle_check(vehicle: *const CVehicle) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        let vehicle = unsafe { read(vehicle, "vehicle")? };
        Vehicle::from(vehicle).checked()?;
        Ok(())
    })
}
