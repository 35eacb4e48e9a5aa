//! Replays what fuzzing has found worth keeping.

#[path = "../../fuzz/fuzz_targets/check_config.rs"]
mod check_config;
#[path = "../../fuzz/fuzz_targets/check_features.rs"]
mod check_features;
#[path = "../../fuzz/fuzz_targets/check_part.rs"]
mod check_part;
#[path = "../../fuzz/fuzz_targets/check_programme.rs"]
mod check_programme;
#[path = "../../fuzz/fuzz_targets/check_request.rs"]
mod check_request;
#[path = "../../fuzz/fuzz_targets/check_sample.rs"]
mod check_sample;
#[path = "../../fuzz/fuzz_targets/check_world.rs"]
mod check_world;

use std::path::Path;

/// Runs a check over all files of a corpus, of which there are more than so many.
fn replay(target: &str, least: usize, check: impl Fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() > least, "the corpus of {target} has {} files", files.len());
    for file in files {
        check(&std::fs::read(&file).unwrap());
    }
}

#[test]
fn the_corpus_of_programmes_holds() {
    replay("programme", 100, check_programme::check);
}

#[test]
fn the_corpus_of_features_holds() {
    replay("features", 30, check_features::check);
}

#[test]
fn the_corpus_of_documents_holds() {
    replay("world", 15, check_world::check);
}

#[test]
fn the_corpus_of_requests_holds() {
    check_request::start();
    replay("request", 30, check_request::check);
}

#[test]
fn the_corpus_of_configurations_holds() {
    replay("config", 5, check_config::check);
}

#[test]
fn the_corpus_of_parts_holds() {
    replay("part", 5, check_part::check);
}

#[test]
fn the_corpus_of_samples_holds() {
    replay("sample", 10, check_sample::check);
}
