//! libFuzzer on [`popsteer_fuzz::path`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| popsteer_fuzz::path::check(data));
