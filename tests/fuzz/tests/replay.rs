//! Every input of the corpus again, without libFuzzer: what was found once stays found.

use std::fs;
use std::path::Path;

#[test]
fn test_corpus_replayed_breaks_no_rule() {
    for (name, check) in popsteer_fuzz::TARGETS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("corpus")
            .join(name);
        let mut replayed = 0;
        for entry in fs::read_dir(&folder).expect("every target has a corpus") {
            let file = entry.expect("the folder can be listed").path();
            check(&fs::read(&file).expect("the file can be read"));
            replayed += 1;
        }
        assert!(
            replayed >= 10,
            "{} holds {replayed} inputs",
            folder.display()
        );
    }
}

#[test]
fn test_no_input_breaks_no_rule() {
    for (_, check) in popsteer_fuzz::TARGETS {
        check(&[]);
    }
}
