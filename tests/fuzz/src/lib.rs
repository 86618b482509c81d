//! What the fuzzer runs: each target takes any bytes, makes calls of the core from them, and
//! panics where an answer breaks a rule.
//!
//! A target is a module with a function `check`; the program hands it to libFuzzer, and
//! `replay` runs it on each input of `corpus/NAME.hex` without, as the core's test `corpus`.

// Two crates have it: its own, and the core's test.
#![allow(
    unreachable_pub,
    reason = "modules show each other what no crate shows"
)]
#![allow(clippy::missing_panics_doc, reason = "a finding is a panic")]

mod backwards;
pub mod bytes;
pub mod laws;
pub mod limited;
pub mod longitudinal;
pub mod path;
pub mod predict;
#[cfg(test)]
mod replay;
mod scene;
pub mod speed_tracker;
mod subject;
pub mod trust;
pub mod vehicle;

/// The name of a target, which is also that of its corpus, and what it runs.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const TARGETS: [Target; 8] = [
    ("path", path::check),
    ("laws", laws::check),
    ("limited", limited::check),
    ("vehicle", vehicle::check),
    ("longitudinal", longitudinal::check),
    ("speed_tracker", speed_tracker::check),
    ("predict", predict::check),
    ("trust", trust::check),
];
