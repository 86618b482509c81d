//! A Cortex-M4F from its reset on, such as an STM32F4; `link.x` has its memory. In QEMU:
//!
//!     rustup target add thumbv7em-none-eabihf
//!     cargo run --release --target thumbv7em-none-eabihf --features semihosting \
//!         --config 'target.thumbv7em-none-eabihf.runner="qemu-system-arm -M mps2-an386 -nographic -semihosting -kernel"'

use core::arch::asm;
use core::ptr;
use core::sync::atomic::{Ordering, compiler_fence};

/// The stack's begin is the linker's; this follows it at once.
#[unsafe(link_section = ".vectors")]
#[used]
static RESET: unsafe extern "C" fn() -> ! = reset;

unsafe extern "C" {
    static mut data_start: u32;
    static mut data_end: u32;
    static data_load: u32;
    static mut bss_start: u32;
    static mut bss_end: u32;
}

/// Turns the floating-point unit on, before any function that might use it, and goes on.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn reset() -> ! {
    core::arch::naked_asm!(
        "ldr r0, =0xE000ED88", // CPACR
        "ldr r1, [r0]",
        "orr r1, r1, #(0xF << 20)",
        "str r1, [r0]",
        "dsb",
        "isb",
        "bl {start}",
        "udf #0",
        start = sym start,
    )
}

extern "C" fn start() -> ! {
    // SAFETY: the linker's addresses, of words that nothing else uses yet.
    unsafe {
        let count = (&raw const data_end).offset_from_unsigned(&raw const data_start);
        ptr::copy_nonoverlapping(&raw const data_load, &raw mut data_start, count);
        let count = (&raw const bss_end).offset_from_unsigned(&raw const bss_start);
        ptr::write_bytes(&raw mut bss_start, 0, count);
    }
    compiler_fence(Ordering::SeqCst);
    crate::drive(command);
    exit()
}

/// Where the driver of the steering would be.
fn command(steer: f64) {
    // Volatile: somebody reads it.
    // SAFETY: a word of our own.
    unsafe { ptr::write_volatile(&raw mut STEER, steer) };
    if cfg!(feature = "semihosting") {
        let mut line = *b"0000000000000000\n\0";
        let bits = steer.to_bits();
        for (place, digit) in line.iter_mut().zip((0..16).rev()) {
            let nibble = bits >> (4 * digit) & 15;
            let digit = nibble.to_le_bytes()[0];
            *place = if digit < 10 {
                b'0' + digit
            } else {
                b'a' - 10 + digit
            };
        }
        semihost(4, line.as_ptr().addr()); // SYS_WRITE0
    }
}

static mut STEER: f64 = 0.0;

fn exit() -> ! {
    if cfg!(feature = "semihosting") {
        semihost(0x18, 0x20026); // SYS_EXIT, the application's own
    }
    loop {
        core::hint::spin_loop();
    }
}

/// Asks the debugger for something.
fn semihost(operation: usize, argument: usize) {
    // SAFETY: with the feature on a debugger takes it, and changes r0 alone.
    unsafe {
        asm!(
            "bkpt #0xAB",
            inout("r0") operation => _,
            in("r1") argument,
            options(nostack)
        );
    }
}
