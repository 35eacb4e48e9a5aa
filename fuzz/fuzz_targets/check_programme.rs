//! What must hold for any bytes that are taken as a programme. The tests of the package run it over the corpus.

use terrane::{
    geometry::{Filter, Window},
    programme::{Frame, Programme, Reference, Tape},
};

/// What all samples of a window may be predicted to cost together, to keep the fuzzer quick.
const MOST_NS: f64 = 5e7;

/// Reads text, and what looks like JSON as JSON.
pub(crate) fn check(data: &[u8]) {
    // The last byte chooses where and how finely the programme is looked at.
    let (place, text) = data.split_last().map_or((0, data), |(place, text)| (*place, text));
    let Ok(text) = std::str::from_utf8(text) else { return };
    let read = if text.starts_with(['{', '"', '[']) { Programme::parse_json(text) } else { Programme::parse(text) };
    match read {
        Ok(programme) => holds(&programme, place),
        Err(error) => assert!(!error.message.is_empty() && error.message.len() < 4_096, "{error}"),
    }
}

fn holds(programme: &Programme, place: u8) {
    let text = programme.to_string();
    let again = Programme::parse(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
    assert_eq!(again.to_string(), text);
    let json = programme.to_json().to_string();
    assert_eq!(Programme::parse_json(&json).unwrap_or_else(|error| panic!("{json}: {error}")).to_string(), text);

    let tape = Tape::compile(programme.root());
    let [low, high] = tape.range();
    assert!(low <= high, "{text}: {low} … {high}");
    let frame = Frame { seed: place.into(), scale: 100.0, origin: [0.0, 0.0] };
    let spacing = [1e-6, 0.01, 1.0, 50.0, 3e3, 1e7][usize::from(place) % 6];
    let far = if place & 64 == 0 { 0.0 } else { 1e12 };
    let filter = if place & 128 == 0 { Filter::Band } else { Filter::Exact };
    // As a server: refused for its cost, or for the cost of exact samples so far apart.
    if programme.check_cost().is_err() || tape.cost_ns(spacing / frame.scale, filter, 18) * 18.0 > MOST_NS {
        return;
    }
    // Far out the finest spacings make no area.
    let Ok(window) = Window::area([far, -far, far + 9.0 * spacing, 2.0 * spacing - far], spacing, filter, 100) else { return };
    let mut heights = vec![0.0; window.samples()];
    tape.evaluate(&frame, &window, &mut heights);
    let reference = Reference::new(programme.root(), &frame, spacing, filter);
    for (row, y) in heights.chunks(window.columns.len()).zip(window.rows.coordinates()) {
        for (height, x) in row.iter().zip(window.columns.coordinates()) {
            assert!(height.is_finite() && low <= f64::from(*height) && f64::from(*height) <= high, "{text} at {x} {y}: {height} is not in {low} … {high}");
            assert_eq!(height.to_bits(), reference.at(x, y).to_bits(), "{text} at {x} {y}");
        }
    }
}
