//! libFuzzer on [`popsteer_fuzz::actuator`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| popsteer_fuzz::actuator::check(data));
