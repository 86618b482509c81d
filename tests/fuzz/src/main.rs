//! libFuzzer on the target that the environment variable `POPSTEER_FUZZ` names.
#![no_main]

use libfuzzer_sys::fuzz_target;
use popsteer_fuzz::TARGETS;
use std::sync::LazyLock;

static CHECK: LazyLock<fn(&[u8])> = LazyLock::new(|| {
    let asked = std::env::var("POPSTEER_FUZZ").unwrap_or_default();
    let found = TARGETS.iter().find(|(name, _)| *name == asked);
    found.expect("POPSTEER_FUZZ names a target").1
});

fuzz_target!(|data: &[u8]| CHECK(data));
