//! What went wrong: a code that is returned, and a message that is asked for.

use core::cell::{Cell, RefCell};
use core::ffi::c_char;
use core::fmt::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

use popsteer_core::{ConfigError, InputError, PathError};

/// What a function came to. Everything but `POPSTEER_ERROR_NONE` left all handles as they were;
/// `popsteer_last_error_message` says more.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CError {
    /// No error: it is done.
    None = 0,
    /// A pointer that is needed is NULL, or not aligned.
    Null = 1,
    /// A handle of another kind, one that was freed, or no handle at all, as far as that shows.
    Handle = 2,
    /// A field of a vehicle, of parameters or of options is out of its range, or a vehicle's file is
    /// wrong.
    Config = 3,
    /// The waypoints make no path.
    Path = 4,
    /// A number given to a step is not finite or beyond its bound.
    Input = 5,
    /// There was no step yet that could be gone on from.
    NoStep = 6,
    /// There is not enough memory.
    Memory = 7,
    /// A fault of popsteer itself.
    Internal = 8,
}

/// Why a function did nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Failure {
    /// This argument is NULL or not aligned.
    Null(&'static str),
    /// This argument is no handle of this kind.
    Handle(&'static str, &'static str),
    Config(ConfigError),
    Path(PathError),
    Input(InputError),
    /// Of the vehicle at this place in a batch.
    InputOf(usize, InputError),
    /// This argument counts more than memory holds.
    TooMany(&'static str, usize),
    /// This array has so many entries for a batch of so many vehicles.
    Length(&'static str, usize, usize),
    /// There is no vehicle at this place of a batch, which has so many.
    NoVehicle(usize, usize),
    NoStep,
    /// A file, by [`of_file`].
    File,
    Memory,
    Internal,
}

thread_local! {
    static LAST: Cell<Option<Failure>> = const { Cell::new(None) };
    static FILE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// The failure of a file, and `why`.
pub(crate) fn of_file(file: &str, why: &str) -> Failure {
    FILE.replace(format!("{file}: {why}"));
    Failure::File
}

/// Does `work`; remembers why it failed.
#[inline]
pub(crate) fn guard(work: impl FnOnce() -> Result<(), Failure>) -> CError {
    // What is left half done by a panic is never seen as sound: it stays within the handle's
    // plain numbers.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => CError::None,
        Ok(Err(failure)) => failed(failure),
        Err(_) => failed(Failure::Internal),
    }
}

#[cold]
fn failed(failure: Failure) -> CError {
    LAST.set(Some(failure));
    failure.code()
}

impl Failure {
    fn code(self) -> CError {
        match self {
            Self::Null(_) => CError::Null,
            Self::Handle(..) => CError::Handle,
            Self::Config(_) | Self::File => CError::Config,
            Self::Path(_) => CError::Path,
            Self::Input(_)
            | Self::InputOf(..)
            | Self::TooMany(..)
            | Self::Length(..)
            | Self::NoVehicle(..) => CError::Input,
            Self::NoStep => CError::NoStep,
            Self::Memory => CError::Memory,
            Self::Internal => CError::Internal,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null(argument) => write!(f, "{argument} is NULL or not aligned"),
            Self::Handle(argument, kind) => write!(f, "{argument} is no popsteer_{kind}"),
            Self::Config(error) => error.fmt(f),
            Self::Path(error) => error.fmt(f),
            Self::Input(error) => error.fmt(f),
            Self::InputOf(vehicle, error) => write!(f, "vehicle {vehicle}: {error}"),
            Self::TooMany(argument, usize::MAX) => {
                write!(f, "{argument} is SIZE_MAX, as is a negative number")
            }
            Self::TooMany(argument, count) => {
                write!(f, "{argument} is {count}: more than memory holds")
            }
            Self::Length(argument, given, count) => {
                write!(
                    f,
                    "{argument} has {given} entries, the batch {count} vehicles"
                )
            }
            Self::NoVehicle(vehicle, count) => {
                write!(f, "there is no vehicle {vehicle} in a batch of {count}")
            }
            Self::File => FILE.with_borrow(|message| f.write_str(message)),
            Self::NoStep => f.write_str("no step was taken yet that a prediction could go on from"),
            Self::Memory => f.write_str("out of memory"),
            Self::Internal => f.write_str("a fault of popsteer itself: please report it"),
        }
    }
}

macro_rules! failures {
    ($($kind:ident($error:ident)),+) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::$kind(error)
            }
        }
    )+};
}
failures!(Config(ConfigError), Path(PathError), Input(InputError));

/// Text that is cut to a buffer from C, and counted whole.
pub(crate) struct Text<'a> {
    room: &'a mut [u8],
    length: usize,
}

impl Text<'_> {
    /// Room for `size` bytes at `buffer`, the last of them for the final NUL; None if that is
    /// NULL.
    ///
    /// # Safety
    ///
    /// `buffer` is NULL or leads to `size` bytes that may be written.
    pub(crate) unsafe fn new(buffer: *mut c_char, size: usize) -> Self {
        let room: &mut [u8] = if buffer.is_null() || size == 0 || isize::try_from(size).is_err() {
            &mut []
        } else {
            // What the caller has there need not have been written yet.
            // SAFETY: the caller vouches for so many bytes.
            unsafe {
                buffer.cast::<u8>().write_bytes(0, size);
                std::slice::from_raw_parts_mut(buffer.cast::<u8>(), size)
            }
        };
        Self { room, length: 0 }
    }

    /// Writes it; the length that it has whole, without the final NUL.
    pub(crate) fn show(mut self, words: impl fmt::Display) -> usize {
        // `write_str` below refuses nothing.
        let _ = write!(self, "{words}");
        self.length
    }
}

impl Write for Text<'_> {
    fn write_str(&mut self, words: &str) -> fmt::Result {
        let last = self.room.len().saturating_sub(1);
        let places = self.room.iter_mut().take(last).skip(self.length);
        for (place, byte) in places.zip(words.bytes()) {
            *place = byte;
        }
        self.length += words.len();
        Ok(())
    }
}

/// Writes why the last call of this thread that failed did so, with the name of the field and its
/// value: at most `size` bytes into `buffer`, the final NUL included. Returns the length of the whole
/// message without the NUL, as snprintf does; `buffer` may be NULL where `size` is 0. The message
/// is empty before the first failure; calls that succeed leave it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn popsteer_last_error_message(buffer: *mut c_char, size: usize) -> usize {
    // SAFETY: the caller vouches for it.
    let text = unsafe { Text::new(buffer, size) };
    match LAST.get() {
        Some(failure) => text.show(failure),
        None => text.show(""),
    }
}

/// What a code stands for, in a few words.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_error_name(error: i32) -> *const c_char {
    let name = match error {
        0 => c"no error",
        1 => c"a pointer is NULL or not aligned",
        2 => c"a handle is none of this kind",
        3 => c"a field is out of its range, or a vehicle's file is wrong",
        4 => c"the waypoints make no path",
        5 => c"an input is not finite or beyond its bound",
        6 => c"no step was taken yet",
        7 => c"out of memory",
        8 => c"internal fault",
        _ => c"unknown error",
    };
    name.as_ptr()
}
