//! libFuzzer on [`popsteer_fuzz::predict`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| popsteer_fuzz::predict::check(data));
