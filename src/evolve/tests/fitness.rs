//! Evolution towards what is wanted.
#![expect(clippy::print_stdout, reason = "what is measured is part of the figures")]

use crate::{
    analysis::{Accessibility, Statistics, accessibility},
    evolve::{Aim, Genome, Judgement},
    genetic::{Evolution, Settings, State},
    geometry::Stop,
    programme::Tape,
};

fn aim(seed: u64, wanted: &str) -> Aim {
    Aim::parse(format!(r#"{{"seed": {seed}, "wanted": {wanted}}}"#).as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

const ACCESSIBLE: &str = r#"{"weight": 3, "criterion": {"accessibility": {"slope": 15, "share": 0.8}}}"#;

/// Breeds until it is near enough.
fn evolved(aim: &Aim, seed: u64, enough: f64) -> State<Genome, Judgement> {
    let mut evolution = Evolution::new(aim, Settings::default(), seed, &Stop::never()).expect("settings are right").expect("nobody stops it");
    evolution.run(&Stop::never(), &mut |state| state.progress().best < enough);
    evolution.into_state()
}

fn found(aim: &Aim, genome: &Genome) -> Accessibility {
    let tape = Tape::compile(genome.programme().expect("a programme").root());
    let (surface, _) = aim.surface(&tape, &Stop::never()).expect("terrain");
    accessibility(&surface, aim.spacing(), 15.0)
}

#[test]
fn evolution_reaches_the_accessibility_that_is_wanted() {
    let mut reached = 0;
    for seed in 0..10 {
        let aim = aim(seed, &format!("[{ACCESSIBLE}]"));
        let state = evolved(&aim, seed, 0.995);
        let best = state.best().expect("a population");
        let share = found(&aim, &best.genome).largest_share();
        println!("seed {seed}: {share:.3} after {} generations, {} genomes: {}", state.generation, state.evaluations, best.genome);
        reached += usize::from((share - 0.8).abs() <= 0.05);
    }
    assert!(reached >= 9, "{reached} of 10");
}

#[test]
#[ignore = "half a minute: ten evolutions of 40 generations with two criteria"]
fn edges_that_are_wanted_give_many_obstacles() {
    let (mut many, mut reached, mut gained) = (0, 0, 0);
    for seed in 0..10 {
        let alone = aim(seed, &format!("[{ACCESSIBLE}]"));
        let with_edges = aim(seed, &format!(r#"[{ACCESSIBLE}, {{"criterion": {{"edges": {{"slope": 15, "density": 8000}}}}}}]"#));
        let counts = [(&alone, 0.995), (&with_edges, 0.98)].map(|(aim, enough)| {
            let state = evolved(aim, seed, enough);
            let best = state.best().expect("a population");
            (found(aim, &best.genome), state.generation, best.genome.to_string())
        });
        let [(without, ..), (with, generations, text)] = counts;
        println!(
            "seed {seed}: {} obstacles without, {} with; {:.3} accessible, {:.0} m/km² of edges, {generations} generations: {text}",
            without.obstacles,
            with.obstacles,
            with.largest_share(),
            with.edge_density(31.25)
        );
        many += usize::from(with.obstacles >= 20);
        gained += usize::from(with.edges > without.edges);
        reached += usize::from((with.largest_share() - 0.8).abs() <= 0.05);
    }
    assert!(many >= 9 && reached >= 9 && gained >= 7, "{many} with many obstacles, {reached} accessible, {gained} with more edges than without");
}

/// Written down after any generation, it goes on to the same bits, on any number of threads.
#[test]
fn a_checkpoint_goes_on_to_the_same_programmes() {
    let aim = Aim { samples: 32, ..aim(3, &format!(r#"[{ACCESSIBLE}, {{"criterion": {{"roughness": {{"value": 0.05}}}}}}]"#)) };
    let settings = Settings { population: 16, islands: 2, generations: 9, ..Settings::default() };
    let mut whole = Evolution::new(&aim, settings, 5, &Stop::never()).expect("settings are right").expect("nobody stops it");
    let mut checkpoints = Vec::new();
    whole.run(&Stop::never(), &mut |state| {
        checkpoints.push(serde_json::to_string(state).expect("JSON"));
        true
    });
    for (threads, checkpoint) in [1, 2, 5].into_iter().zip(checkpoints.iter().step_by(4)) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut resumed = Evolution::resume(&aim, serde_json::from_str(checkpoint).expect("a state")).expect("a state");
        pool.install(|| resumed.run(&Stop::never(), &mut |_| true));
        assert_eq!(resumed.state(), whole.state(), "{threads} threads");
    }
}

/// Distributions, roughness and the likeness to a sample come nearer.
#[test]
fn whatever_is_wanted_comes_nearer() {
    let sample = {
        let aim = aim(77, &format!("[{ACCESSIBLE}]"));
        let tape =
            Tape::compile(Genome::parse("smooth(ridged_multifractal(1.1, 2, 6, 1, 2), 0.05)").expect("a programme").programme().expect("a programme").root());
        let (surface, _) = aim.surface(&tape, &Stop::never()).expect("terrain");
        serde_json::to_string(&Statistics::of(&surface, aim.spacing())).expect("JSON")
    };
    for criterion in [
        r#"{"slopes": {"degrees": [0, 2, 4, 10, 45]}}"#.to_owned(),
        r#"{"elevations": {"heights": [0, 0.05, 0.1, 0.2, 1]}}"#.to_owned(),
        r#"{"roughness": {"value": 0.1}}"#.to_owned(),
        format!(r#"{{"likeness": {{"sample": {sample}}}}}"#),
    ] {
        let aim = Aim { samples: 64, ..aim(1, &format!(r#"[{{"criterion": {criterion}}}]"#)) };
        let settings = Settings { population: 40, generations: 15, ..Settings::default() };
        let mut evolution = Evolution::new(&aim, settings, 2, &Stop::never()).expect("settings are right").expect("nobody stops it");
        let first = evolution.state().progress();
        evolution.run(&Stop::never(), &mut |_| true);
        let last = evolution.state().progress();
        println!("{:.60}: best {:.3} to {:.3}, mean {:.3} to {:.3}", criterion, first.best, last.best, first.mean, last.mean);
        assert!(last.best > first.best && last.best > 0.7 && last.mean > first.mean + 0.1, "{criterion}: from {first:?} to {last:?}");
    }
}

#[test]
fn what_is_wrong_in_an_aim_is_named() {
    let check = |json: &str, expected: &str| {
        let error = Aim::parse(json.as_bytes()).expect_err("wrong").to_string();
        assert!(error.starts_with(expected), "{json}: {error}");
    };
    check(r#"{"wanted": []}"#, "at /wanted: must hold a criterion");
    check(r#"{"wanted": [{"criterion": {"accessibility": {"slope": 15}}}]}"#, "at /wanted/0/criterion");
    check(
        r#"{"wanted": [{"criterion": {"accessibility": {"slope": 95, "share": 1}}}]}"#,
        "at /wanted/0/criterion/accessibility/slope: must be above 0 and below 90",
    );
    check(
        r#"{"wanted": [{"weight": -1, "criterion": {"roughness": {"value": 1}}}, {"criterion": {"roughness": {"value": 1}}}]}"#,
        "at /wanted/0/weight: must be 0",
    );
    check(r#"{"wanted": [{"criterion": {"slopes": {"degrees": [3, 2]}}}]}"#, "at /wanted/0/criterion/slopes/degrees: must be 2 to 1025 ascending");
    check(r#"{"sides": 3}"#, "at /sides: unknown field `sides`");
    check(r#"{"samples": 3}"#, "at /samples: must be 16 … 1024");
    check(r#"{"scale": 0}"#, "at /scale: must be 0.01");
}
