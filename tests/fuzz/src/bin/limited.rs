//! libFuzzer on [`popsteer_fuzz::limited`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| popsteer_fuzz::limited::check(data));
