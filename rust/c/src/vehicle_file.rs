//! The vehicle's TOML file, as Python's `Vehicle.load` reads it.

use core::ffi::{CStr, c_char};
use std::fs;
use std::path::PathBuf;

use popsteer_core::Vehicle;
use popsteer_core::params::{Field, Value};
use toml::{Table, Value as Toml};

use crate::error::{CError, Failure, guard, of_file};
use crate::handle;
use crate::params::CVehicle;

/// Fields for which NAN is no limit, and which a file may set to `inf`.
const LIMITS: [&str; 3] = ["max_steer_rate", "max_lateral_acceleration", "max_speed"];

/// A field of C's vehicle, which a file may set.
trait Settable {
    fn set(&mut self, declared: &Field, value: &Toml) -> Result<(), String>;
}

impl Settable for f64 {
    fn set(&mut self, declared: &Field, value: &Toml) -> Result<(), String> {
        let name = declared.name;
        *self = match *value {
            Toml::Float(value) if value == Self::INFINITY && LIMITS.contains(&name) => Self::NAN,
            // In C that is a field that is absent; in a file it is a mistake.
            Toml::Float(value) if value.is_nan() => {
                let refused = Value::Number(value).checked(name, declared.requirement);
                return refused.map_err(|error| error.to_string());
            }
            Toml::Float(value) => value,
            #[expect(clippy::cast_precision_loss, reason = "no field needs 2^53")]
            Toml::Integer(value) => value as Self,
            ref value => return Err(format!("{name} must be a number, got {value}")),
        };
        Ok(())
    }
}

impl Settable for u32 {
    fn set(&mut self, declared: &Field, value: &Toml) -> Result<(), String> {
        let Toml::Boolean(value) = *value else {
            let name = declared.name;
            return Err(format!("{name} must be true or false, got {value}"));
        };
        *self = value.into();
        Ok(())
    }
}

macro_rules! by_name {
    ({} $(
        $(#[doc = $text:literal])+
        $field:ident: $kind:ident $(<$of:ty>)? = $default:expr $(, in [$low:expr, $high:expr])?;
    )+) => {
        /// The field of `car` named `key`.
        fn field<'a>(car: &'a mut CVehicle, key: &str) -> Option<&'a mut dyn Settable> {
            match key {
                $(stringify!($field) => Some(&mut car.$field),)+
                _ => None,
            }
        }
    };
}

popsteer_core::Vehicle! { by_name {} }

/// The vehicle that a table says; what it leaves out has its default.
fn vehicle(table: &Table) -> Result<CVehicle, String> {
    let fields: &[Field] = &Vehicle::fields();
    let mut car = CVehicle::from(Vehicle::DEFAULT);
    for (key, value) in table {
        let declared = fields.iter().find(|field| field.name == key);
        let (Some(field), Some(declared)) = (field(&mut car, key), declared) else {
            let mut known = String::new();
            // Not `join`: of so many names, whose number is known, it takes minutes to compile.
            for field in fields {
                known += if known.is_empty() { "" } else { ", " };
                known += field.name;
            }
            let near = fields
                .iter()
                .map(|field| (edits(key, field.name), field.name))
                .min()
                .filter(|(edits, name)| 3 * edits <= name.len());
            return Err(match near {
                Some((_, name)) => {
                    format!("unknown key '{key}', did you mean {name}? Known: {known}")
                }
                None => format!("unknown key '{key}'; known: {known}"),
            });
        };
        field.set(declared, value)?;
    }
    let checked = Vehicle::from(car).checked();
    checked.map_err(|error| error.to_string())?;
    Ok(car)
}

/// How many letters to insert, leave out or replace to make `one` of `other`: Levenshtein's distance.
fn edits(one: &str, other: &str) -> usize {
    // From what was read of `one` to each beginning of `other` but the empty one.
    let mut row: Vec<usize> = (1..=other.chars().count()).collect();
    for (read, letter) in one.chars().enumerate() {
        // One letter less of both, and of `other` alone.
        let (mut replaced, mut left) = (read, read + 1);
        for (each, wanted) in row.iter_mut().zip(other.chars()) {
            let here = (replaced + usize::from(letter != wanted)).min(left.min(*each) + 1);
            (replaced, left) = (*each, here);
            *each = here;
        }
    }
    row.last().copied().unwrap_or(one.chars().count())
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
