//! libFuzzer on [`popsteer_fuzz::vehicle`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| popsteer_fuzz::vehicle::check(data));
