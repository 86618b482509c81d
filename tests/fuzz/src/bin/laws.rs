//! libFuzzer on [`popsteer_fuzz::laws`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| popsteer_fuzz::laws::check(data));
