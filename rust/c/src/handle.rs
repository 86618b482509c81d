//! Handles: pointers that C cannot look into, with a number by which a wrong one shows.

use core::mem::size_of;
use core::ptr;

use crate::error::Failure;

/// What C knows as a kind of handle, and what is behind it.
pub(crate) trait Handle: Sized {
    /// Behind the handle.
    type Value;
    /// The first eight bytes behind every handle of this kind.
    const MAGIC: u64;
    /// Its name, without the prefix.
    const KIND: &'static str;
}

/// What a handle really points to.
#[repr(C)]
struct Tagged<T> {
    magic: u64,
    value: T,
}

/// Behind a handle that was freed, until the memory is used for something else.
const FREED: u64 = 0x6465_6572_665f_7370;

/// Moves `value` behind a new handle, and writes that to `out`; NULL where there is none.
///
/// # Safety
///
/// `out` is NULL or a place for a pointer.
pub(crate) unsafe fn give<H: Handle>(
    out: *mut *mut H,
    value: impl FnOnce() -> Result<H::Value, Failure>,
) -> Result<(), Failure> {
    // SAFETY: the caller vouches for the place.
    unsafe { write(out, ptr::null_mut())? };
    let tagged = Box::new(Tagged {
        magic: H::MAGIC,
        value: value()?,
    });
    // SAFETY: the caller vouches for the place.
    unsafe { out.write(Box::into_raw(tagged).cast()) };
    Ok(())
}

/// Refuses what cannot be a handle of this kind.
///
/// # Safety
///
/// `handle` is NULL, misaligned, or leads to eight bytes that may be read.
#[inline]
unsafe fn check<H: Handle>(handle: *const H, argument: &'static str) -> Result<(), Failure> {
    if handle.is_null() {
        return Err(Failure::Null(argument));
    }
    let tagged = handle.cast::<Tagged<H::Value>>();
    // SAFETY: aligned; the caller vouches for the rest.
    if !tagged.is_aligned() || unsafe { handle.cast::<u64>().read() } != H::MAGIC {
        return Err(Failure::Handle(argument, H::KIND));
    }
    Ok(())
}

/// What is behind a handle, to be read.
///
/// # Safety
///
/// As [`check`]; what is behind a handle of this kind is not written to meanwhile.
#[inline]
pub(crate) unsafe fn of<'a, H: Handle>(
    handle: *const H,
    argument: &'static str,
) -> Result<&'a H::Value, Failure> {
    // SAFETY: the caller vouches for it.
    unsafe { check(handle, argument)? };
    // SAFETY: it came from `give`, by its magic number.
    Ok(unsafe { &(*handle.cast::<Tagged<H::Value>>()).value })
}

/// What is behind a handle, to be changed.
///
/// # Safety
///
/// As [`check`]; nothing else uses a handle of this kind meanwhile.
#[inline]
pub(crate) unsafe fn of_mut<'a, H: Handle>(
    handle: *mut H,
    argument: &'static str,
) -> Result<&'a mut H::Value, Failure> {
    // SAFETY: the caller vouches for it.
    unsafe { check(handle, argument)? };
    // SAFETY: it came from `give`, by its magic number, and is used by no one else.
    Ok(unsafe { &mut (*handle.cast::<Tagged<H::Value>>()).value })
}

/// The core's value of what a pointer leads to; its default where that is NULL.
///
/// # Safety
///
/// `pointer` is NULL or leads to a `C`.
#[inline]
pub(crate) unsafe fn given<C: Copy + Into<T>, T: Default>(
    pointer: *const C,
    argument: &'static str,
) -> Result<T, Failure> {
    if pointer.is_null() {
        return Ok(T::default());
    }
    // SAFETY: the caller vouches for it.
    unsafe { read(pointer, argument) }.map(Into::into)
}

/// Frees what is behind a handle; nothing where that is NULL.
///
/// # Safety
///
/// As [`check`]; nothing uses the handle any more.
pub(crate) unsafe fn free<H: Handle>(
    handle: *mut H,
    argument: &'static str,
) -> Result<(), Failure> {
    if handle.is_null() {
        return Ok(());
    }
    // SAFETY: the caller vouches for it.
    unsafe { check(handle, argument)? };
    let tagged = handle.cast::<Tagged<H::Value>>();
    // SAFETY: it came from `give`, by its magic number, and is used by no one else. Volatile: the
    // number has to be gone although nobody may look any more.
    unsafe {
        ptr::write_volatile(&raw mut (*tagged).magic, FREED);
        drop(Box::from_raw(tagged));
    }
    Ok(())
}

/// What a pointer leads to, by its name.
///
/// # Safety
///
/// `pointer` is NULL or leads to a `T`.
#[inline]
pub(crate) unsafe fn read<T: Copy>(
    pointer: *const T,
    argument: &'static str,
) -> Result<T, Failure> {
    if pointer.is_null() {
        return Err(Failure::Null(argument));
    }
    // SAFETY: the caller vouches for it; where its alignment is wrong, that does no harm.
    Ok(unsafe { pointer.read_unaligned() })
}

/// Refuses NULL as a place for a result.
#[inline]
pub(crate) fn place<T>(out: *mut T) -> Result<(), Failure> {
    if out.is_null() {
        return Err(Failure::Null("out"));
    }
    Ok(())
}

/// Writes a result.
///
/// # Safety
///
/// `out` is NULL or a place for a `T`.
#[inline]
pub(crate) unsafe fn write<T>(out: *mut T, value: T) -> Result<(), Failure> {
    place(out)?;
    // SAFETY: not NULL; the caller vouches for the rest, and a wrong alignment does no harm.
    unsafe { out.write_unaligned(value) };
    Ok(())
}

/// `count` items of an array.
///
/// # Safety
///
/// `pointer` is NULL or leads to `count` items, which are not written to meanwhile.
pub(crate) unsafe fn items<'a, T>(
    pointer: *const T,
    count: usize,
    argument: &'static str,
) -> Result<&'a [T], Failure> {
    checked_array(pointer, count, argument)?;
    if count == 0 {
        return Ok(&[]);
    }
    // SAFETY: aligned, not NULL and not too long; the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Room for `count` items, each `blank` to begin with.
///
/// # Safety
///
/// `pointer` is NULL or leads to room for `count` items, which nothing else uses meanwhile.
pub(crate) unsafe fn room<'a, T: Copy>(
    pointer: *mut T,
    count: usize,
    blank: T,
    argument: &'static str,
) -> Result<&'a mut [T], Failure> {
    checked_array(pointer, count, argument)?;
    if count == 0 {
        return Ok(&mut []);
    }
    for index in 0..count {
        // SAFETY: within the room that the caller vouches for.
        unsafe { pointer.add(index).write(blank) };
    }
    // SAFETY: aligned, not NULL, not too long and all written.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

fn checked_array<T>(
    pointer: *const T,
    count: usize,
    argument: &'static str,
) -> Result<(), Failure> {
    if count > isize::MAX.unsigned_abs() / size_of::<T>().max(1) {
        return Err(Failure::TooMany("count", count));
    }
    if count > 0 && (pointer.is_null() || !pointer.is_aligned()) {
        return Err(Failure::Null(argument));
    }
    Ok(())
}
