//! The constructors, one a controller.

use popsteer_core::Path;
use popsteer_core::laws::{Law, Pid, Pop, PreviewPop, PurePursuit, Stanley};

use crate::controller::{CController, Controller};
use crate::error::{CError, guard};
use crate::handle::{give, given};
use crate::options::COptions;
use crate::params::{
    CPidParams, CPopParams, CPreviewPopParams, CPurePursuitParams, CStanleyParams, CVehicle,
};
use crate::path::{self, CPath};

/// Makes a controller of `$law` from C's arguments.
macro_rules! make {
    ($law:ident, $path:ident, $vehicle:ident, $params:ident, $options:ident, $out:ident) => {{
        let value = || {
            // SAFETY: the caller vouches for the handle and the pointers.
            let (path, vehicle, params, options) = unsafe {
                (
                    path::shared($path)?,
                    given($vehicle, "vehicle")?,
                    given($params, "params")?,
                    given::<_, COptions>($options, "options")?,
                )
            };
            let law = $law::new(vehicle, params)?;
            let path = Path::for_vehicle(path, &vehicle);
            let tracker = options.track(&Law::from(law))?;
            let state = tracker.initial_state();
            Ok(Controller {
                path,
                tracker,
                state,
            })
        };
        // SAFETY: the caller vouches for `out`.
        guard(|| unsafe { give($out, value) })
    }};
}

/// Makes a POP controller, the paper's: of the angles near the last one that which leads nearest to
/// the lookahead point.
///
/// `vehicle`, `params` and `options` may be NULL for their defaults; they are copied. `path` may be
/// freed afterwards. `out` gets the controller, which is freed by `popsteer_controller_free`.
/// `POPSTEER_ERROR_CONFIG` names a field that is out of its range.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_pop_new(
    path: *const CPath,
    vehicle: *const CVehicle,
    params: *const CPopParams,
    options: *const COptions,
    out: *mut *mut CController,
) -> CError {
    make!(Pop, path, vehicle, params, options, out)
}

/// Makes a preview POP controller, which plans its angles ahead within all limits of the vehicle:
/// the one for real vehicles. Arguments as of `popsteer_pop_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_preview_pop_new(
    path: *const CPath,
    vehicle: *const CVehicle,
    params: *const CPreviewPopParams,
    options: *const COptions,
    out: *mut *mut CController,
) -> CError {
    make!(PreviewPop, path, vehicle, params, options, out)
}

/// Makes a PID controller on the cross-track error. Arguments as of `popsteer_pop_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_pid_new(
    path: *const CPath,
    vehicle: *const CVehicle,
    params: *const CPidParams,
    options: *const COptions,
    out: *mut *mut CController,
) -> CError {
    make!(Pid, path, vehicle, params, options, out)
}

/// Makes a pure-pursuit controller: the arc of the rear axle through the lookahead point.
/// Arguments as of `popsteer_pop_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_pure_pursuit_new(
    path: *const CPath,
    vehicle: *const CVehicle,
    params: *const CPurePursuitParams,
    options: *const COptions,
    out: *mut *mut CController,
) -> CError {
    make!(PurePursuit, path, vehicle, params, options, out)
}

/// Makes a Stanley controller: heading and cross-track error of the front axle. Arguments as of
/// `popsteer_pop_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_stanley_new(
    path: *const CPath,
    vehicle: *const CVehicle,
    params: *const CStanleyParams,
    options: *const COptions,
    out: *mut *mut CController,
) -> CError {
    make!(Stanley, path, vehicle, params, options, out)
}
