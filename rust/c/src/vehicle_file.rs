//! The vehicle's TOML file, as Python's `Vehicle.load` reads it.

use core::ffi::{CStr, c_char};
use std::fs;
use std::path::PathBuf;

use popsteer_core::Vehicle;
use popsteer_core::error::ConfigError;
use popsteer_core::params::{Field, Value};
use toml::{Table, Value as Toml};

use crate::error::{CError, Failure, guard, of_file};
use crate::handle;
use crate::params::CVehicle;

/// Fields for which NAN is no limit, and which a file may set to `inf`.
const LIMITS: [&str; 3] = ["max_steer_rate", "max_lateral_acceleration", "max_speed"];

/// A field of a vehicle, by its name.
enum Slot<'a> {
    Number(&'a mut f64),
    Flag(&'a mut u32),
}

impl<'a> From<&'a mut f64> for Slot<'a> {
    fn from(number: &'a mut f64) -> Self {
        Self::Number(number)
    }
}

impl<'a> From<&'a mut u32> for Slot<'a> {
    fn from(flag: &'a mut u32) -> Self {
        Self::Flag(flag)
    }
}

macro_rules! by_name {
    ({} $(
        $(#[doc = $text:literal])+
        $field:ident: $kind:ident $(<$of:ty>)? = $default:expr $(, in [$low:expr, $high:expr])?;
    )+) => {
        /// The field of `car` named `key`, and how it was declared.
        fn slot<'a>(car: &'a mut CVehicle, key: &str) -> Option<(Slot<'a>, Field)> {
            let declared = Vehicle::fields().into_iter().find(|field| field.name == key)?;
            match key {
                $(stringify!($field) => Some(((&mut car.$field).into(), declared)),)+
                _ => None,
            }
        }
    };
}

popsteer_core::Vehicle! { by_name {} }

/// The vehicle that a table says; what it leaves out has its default.
fn vehicle(table: &Table) -> Result<CVehicle, String> {
    let mut car = CVehicle::from(Vehicle::DEFAULT);
    for (key, value) in table {
        let Some((slot, declared)) = slot(&mut car, key) else {
            let known = Vehicle::fields().map(|field| field.name).join(", ");
            return Err(format!("unknown key '{key}'; known: {known}"));
        };
        match (slot, value) {
            (Slot::Flag(flag), &Toml::Boolean(value)) => *flag = value.into(),
            (Slot::Number(number), &Toml::Float(value)) => {
                let is_absent = value.is_infinite() && value > 0.0 && LIMITS.contains(&&**key);
                *number = if is_absent { f64::NAN } else { value };
                if value.is_nan() {
                    // In C that is a field that is absent; in a file it is a mistake.
                    Value::Number(value)
                        .checked(declared.name, declared.requirement)
                        .map_err(|error| error.to_string())?;
                }
            }
            #[expect(clippy::cast_precision_loss, reason = "no field needs 2^53")]
            (Slot::Number(number), &Toml::Integer(value)) => *number = value as f64,
            (Slot::Flag(_), value) => {
                return Err(format!("{key} must be true or false, got {value}"));
            }
            (Slot::Number(_), value) => return Err(format!("{key} must be a number, got {value}")),
        }
    }
    Vehicle::from(car)
        .checked()
        .map_err(|error: ConfigError| error.to_string())?;
    Ok(car)
}

/// Reads a vehicle from the TOML file `file`, as Python's `Vehicle.load` does: one key a field, each
/// optional; `inf` is no limit. `out` gets the vehicle.
///
/// `POPSTEER_ERROR_CONFIG` where the file cannot be read or is no TOML, a key is unknown, or its value
/// is of another type or out of its range: the message names file, key and value, and `out` is
/// unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_vehicle_load(file: *const c_char, out: *mut CVehicle) -> CError {
    guard(|| {
        if file.is_null() {
            return Err(Failure::Null("file"));
        }
        handle::place(out)?;
        // SAFETY: not NULL; the caller vouches for its end.
        let name = unsafe { CStr::from_ptr(file) };
        let car = fs::read(path_of(name))
            .map_err(|error| error.to_string())
            .and_then(|bytes| {
                String::from_utf8(bytes).map_err(|error| {
                    format!("not UTF-8 at byte {}", error.utf8_error().valid_up_to())
                })
            })
            .and_then(|text| {
                text.parse::<Table>()
                    .map_err(|error| format!("not TOML: {}", error.to_string().trim_end()))
            })
            .and_then(|table| vehicle(&table))
            .map_err(|why| of_file(&name.to_string_lossy(), &why))?;
        // SAFETY: the caller vouches for the place.
        unsafe { handle::write(out, car) }
    })
}

#[cfg(unix)]
fn path_of(name: &CStr) -> PathBuf {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    OsStr::from_bytes(name.to_bytes()).into()
}

#[cfg(not(unix))]
fn path_of(name: &CStr) -> PathBuf {
    PathBuf::from(name.to_string_lossy().into_owned())
}
