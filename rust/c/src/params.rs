//! The vehicle and the tuning of the controllers: plain structs with defaults.
//!
//! They are the core's, field for field: a number that may be left out is NaN in C, a flag is a
//! count. `tests/header.rs` writes them for the header.

use popsteer_core::Vehicle;
use popsteer_core::laws::{
    PidParams, PopParams, PreviewPopParams, PurePursuitParams, StanleyParams,
};

use crate::error::{CError, guard};
use crate::fields::{c_type, same_fields};
use crate::handle::read;

/// The struct of C that the core's declares.
macro_rules! params {
    ({ $(#[doc = $about:literal])+ $here:ident($core:ident) } $(
        $(#[doc = $text:literal])+
        $field:ident: $kind:ident $(<$of:ty>)? = $default:expr $(, in [$low:expr, $high:expr])?;
    )+) => {
        $(#[doc = $about])+
        #[repr(C)]
        #[derive(Clone, Copy, Debug)]
        pub struct $here {
            $($(#[doc = $text])+ pub $field: c_type!($kind),)+
        }

        same_fields!($here, $core, { $($field),+ });
    };
}
pub(crate) use params;

popsteer_core::Vehicle! { params {
    /// [`Vehicle`] for C.
    CVehicle(Vehicle)
} }

popsteer_core::PopParams! { params {
    /// [`PopParams`] for C.
    CPopParams(PopParams)
} }

popsteer_core::PreviewPopParams! { params {
    /// [`PreviewPopParams`] for C.
    CPreviewPopParams(PreviewPopParams)
} }

popsteer_core::PidParams! { params {
    /// [`PidParams`] for C.
    CPidParams(PidParams)
} }

popsteer_core::PurePursuitParams! { params {
    /// [`PurePursuitParams`] for C.
    CPurePursuitParams(PurePursuitParams)
} }

popsteer_core::StanleyParams! { params {
    /// [`StanleyParams`] for C.
    CStanleyParams(StanleyParams)
} }

/// The paper's wheelbase (3 m) and largest angle (1.22 rad), a lag of 0.1 s, 4 m/s^2 of lateral
/// acceleration; the pose is the rear axle's.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_vehicle_default() -> CVehicle {
    Vehicle::DEFAULT.into()
}

/// Whether every field is within its range; `POPSTEER_ERROR_CONFIG` and a message that names it
/// where one is not. Controllers check their vehicle by themselves.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_vehicle_check(vehicle: *const CVehicle) -> CError {
    guard(|| {
        // SAFETY: the caller vouches for it.
        let vehicle = unsafe { read(vehicle, "vehicle")? };
        Vehicle::from(vehicle).checked()?;
        Ok(())
    })
}

/// The defaults of `popsteer_pop_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_pop_params_default() -> CPopParams {
    PopParams::DEFAULT.into()
}

/// The defaults of `popsteer_preview_pop_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_preview_pop_params_default() -> CPreviewPopParams {
    PreviewPopParams::DEFAULT.into()
}

/// The defaults of `popsteer_pid_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_pid_params_default() -> CPidParams {
    PidParams::DEFAULT.into()
}

/// The defaults of `popsteer_pure_pursuit_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_pure_pursuit_params_default() -> CPurePursuitParams {
    PurePursuitParams::DEFAULT.into()
}

/// The defaults of `popsteer_stanley_params`.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_stanley_params_default() -> CStanleyParams {
    StanleyParams::DEFAULT.into()
}
