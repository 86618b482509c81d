//! popsteer in a browser: the core, a plant and the one closed loop behind plain exports.
//!
//! A page asks for room, writes numbers there, calls, and reads numbers back from the module's
//! memory. No binding is generated. There is one session for each instance of the module:
//!
//! ```text
//! playground_room(n)        room for n numbers, to be written by the page
//! playground_track(closed)  takes the room as waypoints x, y, x, y, ...
//! playground_draw()         takes it as a line drawn by hand; the output is the track made of it
//! playground_drive(k)       takes it as settings, and drives controller k along the track; the
//!                           output is the metrics, then the records, a row for each control step
//! playground_output()       where the output is, and playground_output_length() how long
//! playground_text(what)     names in their order, or the last message; UTF-8
//! ```
//!
//! What is refused answers 0 and leaves a message; the session works on.
//!
//! The mathematics is that of the crate `libm`, in the browser as in a native build of this crate:
//! both compute the same bits (`examples/native.rs` is compared). A build with the platform's
//! mathematics, such as the Python package, differs from them in the last bits of sines, tangents
//! and exponentials.
#![expect(
    unsafe_code,
    reason = "the exports keep their names; there is no unsafe block"
)]
#![cfg_attr(test, expect(clippy::float_cmp, reason = "a test compares bits"))]

mod controllers;
mod course;
mod drawn;
mod session;
mod settings;
#[cfg(test)]
mod tests;

pub use session::{Session, Text};

use std::cell::RefCell;

/// Why nothing was done, as a message for a person.
type Refusal = Box<dyn std::error::Error>;

thread_local! {
    static SESSION: RefCell<Session> = RefCell::default();
}

fn with<T>(work: impl FnOnce(&mut Session) -> T) -> T {
    SESSION.with_borrow_mut(work)
}

/// Room for `count` numbers, which stays until the next call for room; null where there is none.
#[unsafe(no_mangle)]
pub extern "C" fn playground_room(count: usize) -> *mut f64 {
    with(|session| {
        session
            .room(count)
            .map_or(std::ptr::null_mut(), <[f64]>::as_mut_ptr)
    })
}

/// Takes the room as the waypoints of a track; `closed` is 0 for an open one. 0: refused.
#[unsafe(no_mangle)]
pub extern "C" fn playground_track(closed: u32) -> u32 {
    with(|session| u32::from(session.track(closed != 0)))
}

/// Takes the room as a line drawn by hand. 0: refused, else 1 for an open track, 2 for a closed one.
#[unsafe(no_mangle)]
pub extern "C" fn playground_draw() -> u32 {
    with(|session| match session.draw() {
        None => 0,
        Some(false) => 1,
        Some(true) => 2,
    })
}

/// Takes the room as settings, and drives. 0: refused.
#[unsafe(no_mangle)]
pub extern "C" fn playground_drive(controller: usize) -> u32 {
    with(|session| u32::from(session.drive(controller)))
}

/// Where the output of the last call lies.
#[unsafe(no_mangle)]
pub extern "C" fn playground_output() -> *const f64 {
    with(|session| session.output().as_ptr())
}

/// How many numbers it has.
#[unsafe(no_mangle)]
pub extern "C" fn playground_output_length() -> usize {
    with(|session| session.output().len())
}

/// Where a text lies, of the kinds of [`Text`] by their numbers; valid until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn playground_text(what: u32) -> *const u8 {
    with(|session| session.text(Text::of(what)).as_ptr())
}

/// How many bytes it has.
#[unsafe(no_mangle)]
pub extern "C" fn playground_text_length(what: u32) -> usize {
    with(|session| session.text(Text::of(what)).len())
}
