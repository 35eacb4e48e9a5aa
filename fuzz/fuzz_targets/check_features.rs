//! What must hold for any bytes that are taken as features. The tests of the package run it over the corpus.

use terrane::{
    geometry::{Filter, Window},
    layout::{
        Feature, Layout, LayoutSurface, Options,
        geojson::{Collection, MOST_PROBLEMS, ReadError, Sets},
    },
};

/// What a window may be predicted to cost, to keep the fuzzer quick.
const MOST_NS: f64 = 1e7;

pub(crate) fn check(data: &[u8]) {
    let collection = match Collection::read(data) {
        Ok(collection) => collection,
        Err(error) => return tells(&error),
    };
    let json = serde_json::to_string(&collection).expect("what was read can be written");
    let again = Collection::parse(&json).unwrap_or_else(|error| panic!("{json}: {error}"));
    assert_eq!(serde_json::to_string(&again).expect("what was read can be written"), json);
    let features = match (collection.features(&Sets::default()), again.features(&Sets::default())) {
        (Ok(features), Ok(again)) => {
            assert!(features.iter().map(Feature::hash).eq(again.iter().map(Feature::hash)), "{json}");
            features
        }
        (Err(error), Err(again)) => {
            assert_eq!(error.to_string(), again.to_string());
            return tells(&error);
        }
        (one, other) => panic!("{json}: {:?}, written and read {:?}", one.err(), other.err()),
    };
    let Ok(layout) = Layout::new(features, Options::default()) else { return };
    let Some(at) = layout.features().first().map(|feature| feature.shape().bounds(0.0).min) else { return };
    let Ok(window) = Window::area([at[0], at[1], at[0] + 50.0, at[1] + 20.0], 10.0, Filter::Band, 100) else { return };
    if layout.cost_ns(&window) <= MOST_NS {
        agrees(&layout, &window, &json);
    }
}

/// Every problem has a place and says something.
fn tells(error: &ReadError) {
    let ReadError::Invalid(problems) = error else { panic!("bytes in memory can be read: {error}") };
    assert!(!problems.is_empty() && problems.len() <= MOST_PROBLEMS + 1);
    assert!(problems.iter().all(|problem| !problem.detail.is_empty() && problem.detail.len() < 4_096), "{error}");
}

/// The layout by blocks is the layout at points.
fn agrees(layout: &Layout, window: &Window, json: &str) {
    let everything = layout.everything();
    let base = vec![100.0; window.samples()];
    let all = layout.sample(window, Some(&base), &everything);
    let places = window.rows.coordinates().flat_map(|y| window.columns.coordinates().map(move |x| [x, y]));
    for (number, place) in places.enumerate() {
        let one: LayoutSurface = layout.at(place, window.spacing(), Filter::Band, Some(100.0), &everything);
        assert_eq!(one.elevation[0].to_bits(), all.elevation[number].to_bits(), "{json} at {place:?}");
        assert!(all.elevation[number].is_finite(), "{json} at {place:?}");
    }
}
