//! What must hold for any bytes that are taken as a document of a world or of the programme library. The tests of the package run it over the corpus.

use terrane::{
    geometry::{Filter, Source, Window},
    world::{Document, DocumentError, Preset, World},
};

/// What a window may be predicted to cost, to keep the fuzzer quick.
const MOST_NS: f64 = 1e7;

pub(crate) fn check(data: &[u8]) {
    match Document::parse(data) {
        Ok(document) => holds(document),
        Err(error) => tells(&error),
    }
    match Preset::parse(data) {
        Ok(preset) => {
            let json = preset.to_json();
            let again = Preset::parse(json.as_bytes()).unwrap_or_else(|error| panic!("{json}: {error}"));
            assert_eq!((again.to_json(), again.revision()), (json, preset.revision()));
        }
        Err(error) => tells(&error),
    }
}

/// A document that is written is read as the same one, and its world has heights within its range.
fn holds(document: Document) {
    let json = document.to_json();
    let again = Document::parse(json.as_bytes()).unwrap_or_else(|error| panic!("{json}: {error}"));
    assert_eq!((again.to_json(), again.revision()), (json.clone(), document.revision()));
    let world = World::new(document);
    let [low, high] = world.legend().range;
    assert!(low <= high, "{json}: {low} … {high}");
    for (at, spacing) in [([0.0, 0.0], 10.0), ([-1e9, 1e9], 30.0), ([25_000.0, -25_000.0], 2_000.0)] {
        let Ok(window) = Window::area([at[0], at[1], at[0] + 5.0 * spacing, at[1] + 2.0 * spacing], spacing, Filter::Band, 100) else { continue };
        if world.cost_ns(&window) <= MOST_NS {
            let heights = world.evaluate(&window).elevation;
            assert!(heights.iter().all(|height| low <= f64::from(*height) && f64::from(*height) <= high), "{json} at {at:?}: {heights:?}");
        }
    }
}

/// Every problem has a place and says something.
fn tells(error: &DocumentError) {
    match error {
        DocumentError::Syntax(detail) => assert!(!detail.is_empty()),
        DocumentError::Invalid(problems) => {
            assert!(!problems.is_empty());
            let is_told = |pointer: &str, detail: &str| (pointer.is_empty() || pointer.starts_with('/')) && !detail.is_empty() && detail.len() < 4_096;
            assert!(problems.iter().all(|problem| is_told(&problem.pointer, &problem.detail)), "{error}");
        }
    }
}
