//! A problem whose answer is known, and the promises of the framework.

use super::*;
use crate::geometry::Stop;
use std::sync::atomic::{AtomicUsize, Ordering};

const GENES: usize = 24;

/// Angles that should all be 0.25: evaluations are errors a gene, and only changed genes are evaluated.
#[derive(Default)]
struct Angles {
    /// Genes evaluated.
    evaluated: AtomicUsize,
    /// Asks for the end when so many are.
    stop_at: Option<(usize, Stop)>,
}

impl Angles {
    fn error(&self, gene: f64) -> f64 {
        let before = self.evaluated.fetch_add(1, Ordering::Relaxed);
        if let Some((at, stop)) = &self.stop_at
            && before >= *at
        {
            stop.set();
        }
        (gene - 0.25) * (gene - 0.25)
    }
}

impl Problem for Angles {
    type Genome = Vec<f64>;
    type Evaluation = Vec<f64>;
    type Change = Vec<usize>;

    fn initialise(&self, number: usize, draws: &mut Draws) -> Vec<f64> {
        // One in eight is straight.
        (0..GENES).map(|_| if number.is_multiple_of(8) { 0.0 } else { draws.between(-1.0, 1.0) }).collect()
    }

    fn cross(&self, child: &mut Vec<f64>, mate: &Vec<f64>, change: &mut Vec<usize>, draws: &mut Draws) {
        let from = draws.below(GENES);
        child[from..].copy_from_slice(&mate[from..]);
        change.extend(from..GENES);
    }

    fn mutate(&self, child: &mut Vec<f64>, parent: &Vec<f64>, change: &mut Vec<usize>, draws: &mut Draws) {
        // What is wrong is mutated first.
        let gene = draws.weighted(parent);
        child[gene] += 0.3 * draws.normal();
        change.push(gene);
    }

    fn evaluate(&self, genome: &Vec<f64>, from: Option<(&Vec<f64>, &Vec<usize>)>, _: &Stop) -> Vec<f64> {
        let Some((parent, change)) = from else { return genome.iter().map(|gene| self.error(*gene)).collect() };
        let mut errors = parent.clone();
        for &gene in change {
            errors[gene] = self.error(genome[gene]);
        }
        errors
    }

    fn fitness(&self, errors: &Vec<f64>) -> f64 {
        1.0 / (1.0 + errors.iter().sum::<f64>())
    }
}

fn settings() -> Settings {
    Settings {
        population: 20,
        islands: 3,
        generations: 30,
        variation: Variation::Both { crossover: 0.7, mutation: 0.6 },
        migration: Migration { every: 4, count: 2 },
        ..Settings::default()
    }
}

fn evolution(problem: &Angles, settings: Settings, seed: u64) -> Evolution<'_, Angles> {
    Evolution::new(problem, settings, seed, &Stop::never()).expect("settings are right").expect("nobody stops it")
}

fn run(settings: Settings, seed: u64) -> State<Vec<f64>, Vec<f64>> {
    let problem = Angles::default();
    let mut evolution = evolution(&problem, settings, seed);
    assert!(evolution.run(&Stop::never(), &mut |_| true));
    evolution.into_state()
}

#[test]
fn evolution_finds_the_answer_by_either_selection() {
    for selection in [Selection::Tournament { size: 3 }, Selection::Proportional] {
        let state = run(Settings { generations: 120, selection, ..settings() }, 5);
        let first = evolution(&Angles::default(), settings(), 5).state().progress().best;
        assert!(state.progress().best > 0.9 && first < 0.5, "{selection:?}: from {first} to {}", state.progress().best);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let on = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool").install(|| run(settings(), 11));
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
    assert_ne!(one, run(settings(), 12));
}

#[test]
fn a_checkpoint_of_any_generation_goes_on_to_the_same_bits() {
    let problem = Angles::default();
    let mut whole = evolution(&problem, settings(), 3);
    let mut checkpoints = Vec::new();
    whole.run(&Stop::never(), &mut |state| {
        checkpoints.push(serde_json::to_string(state).expect("a state is JSON"));
        true
    });
    assert_eq!(checkpoints.len(), 31, "the first generation and all that are bred");
    for checkpoint in checkpoints.iter().step_by(7) {
        let state = serde_json::from_str(checkpoint).expect("it is what was written");
        let mut resumed = Evolution::resume(&problem, state).expect("a state");
        resumed.run(&Stop::never(), &mut |_| true);
        assert_eq!(resumed.state(), whole.state());
    }
}

#[test]
fn a_stopped_generation_is_given_up() {
    let stop = Stop::new();
    let problem = Angles { stop_at: Some((6_000, stop.clone())), ..Angles::default() };
    let mut evolution = Evolution::new(&problem, settings(), 3, &stop).expect("settings are right").expect("it is not stopped yet");
    let mut seen = 0;
    assert!(!evolution.run(&stop, &mut |_| {
        seen += 1;
        true
    }));
    let generation = evolution.state().generation;
    assert!(generation > 3 && generation < 30 && seen == generation + 1, "{generation} {seen}");
    let mut resumed = Evolution::resume(&problem, evolution.into_state()).expect("a state");
    resumed.run(&Stop::never(), &mut |_| true);
    assert_eq!(*resumed.state(), run(settings(), 3));
}

/// Two in three children are changed from one gene on or in one gene: half of all genes and less.
#[test]
fn only_changed_genes_are_evaluated() {
    let problem = Angles::default();
    let mut evolution = evolution(&problem, Settings { variation: Variation::Both { crossover: 0.0, mutation: 1.0 }, ..settings() }, 9);
    let before = problem.evaluated.load(Ordering::Relaxed);
    assert_eq!(before, 3 * 20 * GENES);
    assert!(evolution.step(&Stop::never()));
    assert_eq!(problem.evaluated.load(Ordering::Relaxed) - before, 3 * 18, "one gene a child");
    // Incremental evaluations are those of the whole genome.
    for individual in evolution.state().individuals() {
        assert_eq!(individual.evaluation, problem.evaluate(&individual.genome, None, &Stop::never()));
    }
}

#[test]
fn rates_are_what_the_settings_say() {
    struct Count([AtomicUsize; 2]);
    impl Problem for Count {
        type Genome = ();
        type Evaluation = ();
        type Change = ();
        fn initialise(&self, _: usize, _: &mut Draws) {}
        fn cross(&self, (): &mut (), (): &(), (): &mut (), _: &mut Draws) {
            self.0[0].fetch_add(1, Ordering::Relaxed);
        }
        fn mutate(&self, (): &mut (), (): &(), (): &mut (), _: &mut Draws) {
            self.0[1].fetch_add(1, Ordering::Relaxed);
        }
        fn evaluate(&self, (): &(), _: Option<(&(), &())>, _: &Stop) {}
        fn fitness(&self, (): &()) -> f64 {
            f64::NAN
        }
    }
    let check = |variation, expected: [f64; 2], unchanged: f64| {
        let count = Count([AtomicUsize::new(0), AtomicUsize::new(0)]);
        let settings = Settings { population: 1_000, generations: 20, elite: 0, variation, ..Settings::default() };
        let mut evolution = Evolution::new(&count, settings, 1, &Stop::never()).expect("settings are right").expect("nobody stops it");
        evolution.run(&Stop::never(), &mut |_| true);
        let of = |count: &AtomicUsize| count.load(Ordering::Relaxed) as f64 / 20_000.0;
        let copies = 1.0 - (evolution.state().evaluations - 1_000) as f64 / 20_000.0;
        // Four standard deviations.
        for (got, want) in [of(&count.0[0]), of(&count.0[1]), copies].into_iter().zip([expected[0], expected[1], unchanged]) {
            assert!((got - want).abs() < 4.0 * (want * (1.0 - want) / 20_000.0_f64).sqrt() + 1e-9, "{variation:?}: {got} is not {want}");
        }
        assert_eq!(evolution.state().progress().best, f64::MIN, "what is not a number is the least");
    };
    check(Variation::Either { crossover: 0.9, mutation: 0.1 }, [0.9, 0.1], 0.0);
    check(Variation::Either { crossover: 0.2, mutation: 0.5 }, [0.2, 0.5], 0.3);
    check(Variation::Both { crossover: 0.7, mutation: 0.1 }, [0.7, 0.1], 0.27);
}

#[test]
fn the_elite_lives_on_and_migrants_arrive() {
    let problem = Angles::default();
    let mut evolution = evolution(&problem, Settings { migration: Migration { every: 1, count: 1 }, elite: 1, ..settings() }, 21);
    for _ in 0..10 {
        let best =
            |evolution: &Evolution<Angles>, island: usize| evolution.state().islands[island].iter().map(|member| member.fitness).fold(f64::MIN, f64::max);
        let before: Vec<f64> = (0..3).map(|island| best(&evolution, island)).collect();
        assert!(evolution.step(&Stop::never()));
        for (island, &best_before) in before.iter().enumerate() {
            assert!(best(&evolution, island) >= best_before, "the fittest of island {island} was lost");
            // Its copy went on to the next.
            assert!(best(&evolution, (island + 1) % 3) >= best_before, "the fittest of island {island} did not arrive");
        }
    }
}

#[test]
fn draws_are_uniform_normal_and_weighted() {
    let mut draws = Draws::of(3, &[1, 2, 3]);
    let n = 100_000;
    let (mut dice, mut weights, mut mean, mut variance) = ([0_u32; 6], [0_u32; 4], 0.0, 0.0);
    for _ in 0..n {
        dice[draws.below(6)] += 1;
        weights[draws.weighted(&[1.0, f64::NAN, 3.0, -2.0])] += 1;
        let normal = draws.normal();
        mean += normal / f64::from(n);
        variance += normal * normal / f64::from(n);
    }
    assert!(dice.iter().all(|&count| (f64::from(count) - 16_666.7).abs() < 4.0 * 118.0), "{dice:?}");
    assert_eq!([weights[1], weights[3]], [0, 0]);
    assert!((f64::from(weights[0]) - 25_000.0).abs() < 4.0 * 137.0, "{weights:?}");
    assert!(mean.abs() < 0.013 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
    assert_eq!(draws.weighted(&[0.0]), 0);
}

#[test]
fn a_tournament_of_two_chooses_the_better_half_three_times_in_four() {
    let fitness: Vec<f64> = (0..100).map(f64::from).collect();
    let mut draws = Draws::new(8);
    let better = (0..10_000).filter(|_| Selection::Tournament { size: 2 }.choose(&fitness, &mut draws) >= 50).count();
    assert!(better.abs_diff(7_500) < 4 * 44, "{better}");
    // In proportion to 0 … 99: the upper half has 3,725 of 4,950.
    let better = (0..10_000).filter(|_| Selection::Proportional.choose(&fitness, &mut draws) >= 50).count();
    assert!(better.abs_diff(7_525) < 4 * 44, "{better}");
}

#[test]
fn wrong_settings_are_named() {
    let check = |settings: Settings, at: &str| assert_eq!(settings.check().expect_err("wrong").at, at);
    let good = settings();
    good.check().expect("right");
    check(Settings { population: 1, ..good }, "/population");
    check(Settings { islands: 0, ..good }, "/islands");
    check(Settings { islands: usize::MAX, ..good }, "/islands");
    check(Settings { elite: 20, ..good }, "/elite");
    check(Settings { selection: Selection::Tournament { size: 0 }, ..good }, "/selection/tournament/size");
    check(Settings { variation: Variation::Either { crossover: 0.9, mutation: 0.2 }, ..good }, "/variation/either");
    check(Settings { variation: Variation::Both { crossover: f64::NAN, mutation: 0.2 }, ..good }, "/variation/both/crossover");
    check(Settings { migration: Migration { every: 1, count: 11 }, ..good }, "/migration/count");
    let problem = Angles::default();
    let mut state = evolution(&problem, good, 1).into_state();
    state.islands[1].pop();
    assert_eq!(Evolution::resume(&problem, state).err().expect("wrong").at, "/islands/1");
}
