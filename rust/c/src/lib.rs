//! The C interface of popsteer: `include/popsteer.h`, and `include/popsteer.hpp` for C++.
//!
//! Each function checks its pointers, converts, calls `popsteer-core` and converts back; there is
//! no control law, unit or sign here. Nothing unwinds into C: a panic, which the core does not
//! know, would be answered with [`CError::Internal`].
#![expect(
    unsafe_code,
    reason = "C gives pointers; each use of one says why it is sound"
)]
#![expect(
    clippy::missing_safety_doc,
    reason = "all functions require the same of the caller: `cbindgen.toml` has it, for the header's head"
)]

pub mod batch;
pub mod command;
pub mod controller;
pub mod driver;
pub mod error;
mod fields;
mod handle;
pub mod laws;
pub mod options;
pub mod params;
pub mod path;
pub mod speed;
pub mod status;
pub mod step;
pub mod vehicle_file;

pub use error::CError;

use core::ffi::c_char;

/// The version of this binary interface: it rises with every change that a program compiled
/// against an older header would not survive. Compare it with `popsteer_abi_version()`.
pub const POPSTEER_ABI_VERSION: u32 = 3;

/// The `POPSTEER_ABI_VERSION` of the library that is linked, for comparison with the header's.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_abi_version() -> u32 {
    POPSTEER_ABI_VERSION
}

/// The version of popsteer, such as "0.3.0".
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
