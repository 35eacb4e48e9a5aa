//! What holds for every programme, tried on random ones. `TERRANE_PROGRAMMES` says how many; `make soak` tries many more.

use crate::grow::{Random, programme};
use proptest::{prelude::ProptestConfig, proptest};
use terrane::{
    geometry::{Filter, Window},
    noise::Isa,
    programme::{Frame, Programme, Reference, Tape},
};

const FRAME: Frame = Frame { seed: 7, scale: 300.0, origin: [-40.0, 1_000.0] };

fn cases() -> ProptestConfig {
    let cases = std::env::var("TERRANE_PROGRAMMES").map_or(200, |text| text.parse().expect("TERRANE_PROGRAMMES is a number"));
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// A few rows somewhere, at some spacing, near or far.
fn window(random: &mut Random) -> Window {
    let spacing = 10f64.powf(random.unit() * 7.0 - 3.0);
    let reach = 10f64.powf(random.unit() * 9.0);
    let [x, y] = [0, 1].map(|_| ((random.unit() - 0.5) * reach).round());
    let filter = [Filter::Band, Filter::Exact][random.below(2)];
    let columns = 1.0 + random.below(40) as f64;
    Window::area([x, y, x + columns * spacing, y + 3.0 * spacing], spacing, filter, 1_000).expect("near enough")
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn what_is_printed_is_read_again(seed in 0_u64..1 << 40) {
        let programme = programme(&mut Random::new(seed), 6);
        let text = programme.to_string();
        let read = Programme::parse(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(read.root(), programme.root(), "{text}");
        assert_eq!(read.to_string(), text);
        let json = programme.to_json().to_string();
        let read = Programme::parse_json(&json).unwrap_or_else(|error| panic!("{json}: {error}"));
        assert_eq!(read.root(), programme.root(), "{json}");
    }

    #[test]
    fn every_way_of_evaluation_gives_the_same_bits_within_the_range(seed in 0_u64..1 << 40) {
        check_evaluations(seed);
    }
}

/// What long runs found and no longer find.
#[test]
fn what_was_found_stays_right() {
    // A wave that is never chosen.
    check_evaluations(503_163_554_450);
}

/// Simplification, classes, registers and instruction sets change no bit, and no value lies outside the static range.
fn check_evaluations(seed: u64) {
    let random = &mut Random::new(seed);
    let programme = programme(random, 5);
    let tape = Tape::compile(programme.root());
    let window = window(random);
    let mut heights = vec![0.0; window.samples()];
    tape.evaluate(&FRAME, &window, &mut heights);
    for isa in Isa::ALL {
        let mut other = vec![0.0; window.samples()];
        tape.evaluate_on(isa, &FRAME, &window, &mut other);
        assert!(heights.iter().zip(&other).all(|(a, b)| a.to_bits() == b.to_bits()), "{programme} on {isa:?}, seed {seed}");
    }
    let reference = Reference::new(programme.root(), &FRAME, window.spacing(), window.filter);
    let [low, high] = tape.range();
    for (row, y) in heights.chunks(window.columns.len()).zip(window.rows.coordinates()) {
        for (height, x) in row.iter().zip(window.columns.coordinates()) {
            assert_eq!(height.to_bits(), reference.at(x, y).to_bits(), "{programme} at {x} {y}, {:?}, seed {seed}", window.filter);
            assert!(low <= f64::from(*height) && f64::from(*height) <= high, "{programme} at {x} {y}, seed {seed}: {height} is not in {low} … {high}");
        }
    }
}
