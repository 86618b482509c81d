//! Proof that nothing panics: the program links only where no panic is left in it.

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn the_core_can_panic() -> !;
    }
    // SAFETY: never runs; the function does not exist, so linking fails where a panic is possible.
    unsafe { the_core_can_panic() }
}
