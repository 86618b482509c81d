//! libFuzzer on [`popsteer_fuzz::longitudinal`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| popsteer_fuzz::longitudinal::check(data));
