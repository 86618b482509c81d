//! The same on the machine it is built on: an angle a line, as the bits of its double.

use core::ffi::{c_char, c_int, c_ulonglong};

#[link(name = "c")]
unsafe extern "C" {
    fn printf(format: *const c_char, ...) -> c_int;
}

/// Asked for by the precompiled compiler runtime; never called, as a panic cannot unwind here.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

#[unsafe(no_mangle)]
extern "C" fn main() -> c_int {
    crate::drive(|steer| {
        let bits: c_ulonglong = steer.to_bits();
        // SAFETY: the format asks for one number of this size and gets one.
        unsafe { printf(c"%016llx\n".as_ptr(), bits) };
    });
    0
}
