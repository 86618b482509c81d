//! libFuzzer on [`popsteer_fuzz::speed_tracker`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| popsteer_fuzz::speed_tracker::check(data));
