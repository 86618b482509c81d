//! Every input of the corpus again, without libFuzzer: what was found once stays found.

use crate::TARGETS;
use std::fs;
use std::path::Path;

/// Read the inputs of a target: one a line, in hexadecimal, as `run.py` writes them.
fn corpus(target: &str) -> Vec<Vec<u8>> {
    // The crate of this test is this folder's or that of the core's tests.
    let name = format!("tests/fuzz/corpus/{target}.hex");
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let text = folders.find_map(|folder| fs::read_to_string(folder.join(&name)).ok());
    let text = text.expect("every target has a corpus");
    text.lines().map(decoded).collect()
}

fn decoded(line: &str) -> Vec<u8> {
    assert!(line.len().is_multiple_of(2), "half a byte in {line:?}");
    (0..line.len())
        .step_by(2)
        .map(|i| u8::from_str_radix(&line[i..i + 2], 16).expect("two hexadecimal digits a byte"))
        .collect()
}

#[test]
fn test_corpus_replayed_breaks_no_rule() {
    for (name, check) in TARGETS {
        let inputs = corpus(name);
        assert!(inputs.len() >= 10, "{name} has {} inputs", inputs.len());
        for input in inputs {
            check(&input);
        }
    }
}

/// What a corpus has no input for: bytes at random, the same on every machine (G. Marsaglia,
/// *Xorshift RNGs*, Journal of Statistical Software 8, 2003).
#[test]
fn test_random_input_breaks_no_rule() {
    for (name, check) in TARGETS {
        for seed in 1_u64..=3000 {
            let mut drawn = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let input: Vec<u8> = (0..320)
                .map(|_| {
                    drawn ^= drawn << 13;
                    drawn ^= drawn >> 7;
                    drawn ^= drawn << 17;
                    drawn.to_be_bytes()[3]
                })
                .collect();
            let held = std::panic::catch_unwind(|| check(&input));
            assert!(held.is_ok(), "{name}, bytes of seed {seed}");
        }
    }
}

#[test]
fn test_no_input_breaks_no_rule() {
    for (_, check) in TARGETS {
        check(&[]);
    }
}
