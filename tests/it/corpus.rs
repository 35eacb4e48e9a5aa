//! Replays what fuzzing has found worth keeping.

#[path = "../../fuzz/fuzz_targets/check.rs"]
mod check;

use std::path::Path;

#[test]
fn the_corpus_of_the_fuzzer_holds() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/programme");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() > 100, "the corpus has {} files", files.len());
    for file in files {
        check::programme(&std::fs::read(&file).unwrap());
    }
}
