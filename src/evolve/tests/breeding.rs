//! Genomes, operators and sessions.
#![expect(clippy::print_stdout, reason = "what is measured is part of the figures")]

use crate::{
    evolve::{
        vocabulary::{Method, grow},
        *,
    },
    genetic::Draws,
};

fn genome(text: &str) -> Genome {
    Genome::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn grown(seed: u64, depth: usize) -> Genome {
    Genome::new(grow(depth, if seed.is_multiple_of(2) { Method::Full } else { Method::Grow }, &mut Draws::of(seed, &[9])))
}

/// What a genome writes is canonical text, which is its programme.
fn check_valid(genome: &Genome) {
    let programme = genome.programme().unwrap_or_else(|error| panic!("{genome}: {error}"));
    assert_eq!(programme.to_string(), genome.to_string());
    assert_eq!((programme.root().size(), programme.root().depth()), (genome.size(), genome.depth()), "{genome}");
    assert_eq!(Genome::of(&programme), *genome);
}

#[test]
fn a_session_goes_on_from_any_that_begins_as_it_does() {
    let mut long = Session::new(11, &[]).expect("a session");
    for parents in [&[3][..], &[0, 5], &[7], &[1, 2]] {
        long.choose(&Choice::of(parents)).expect("chosen");
    }
    let mut branch = long.branch(2).expect("a branch");
    branch.choose(&Choice::of(&[4])).expect("chosen");
    branch.keep(1, "kept").expect("kept");
    for (from, to) in [(&long, &branch), (&branch, &long), (&long, &long)] {
        assert_eq!(&from.resume(to.record().clone()).expect("resumed"), to);
    }
    let other = Session::new(12, &[]).expect("a session");
    assert_eq!(long.resume(other.record().clone()).expect("replayed"), other);
}

#[test]
fn genomes_are_the_trees_of_their_text() {
    for text in [
        "3",
        "x",
        "plus(fbm(1, 1.97, 2), multiply(0.3, x))",
        "turbulence(4, 0.5, 2, hard=true, basis=voronoi_f1, seed=3)",
        "smooth(terrace(erosion(fbm(1, 2, 8), scale=0.5), 4, 0.7), 0.1)",
        "mix(select(x, y, -0.5), warp(gauss(0.5, repeat=3), x, y), clamp(o_perlin(seed=9), 0, 1))",
    ] {
        let genome = genome(text);
        check_valid(&genome);
        assert_eq!(genome.to_string(), text);
    }
    let genome = genome("plus(sin(x), mix(1, 2, y))");
    let texts: Vec<String> = (0..genome.size()).map(|at| Genome::new(genome.genes()[genome.subtree(at)].to_vec()).to_string()).collect();
    assert_eq!(texts, ["plus(sin(x), mix(1, 2, y))", "sin(x)", "x", "mix(1, 2, y)", "1", "2", "y"]);
}

#[test]
fn trees_are_grown_as_deep_as_asked() {
    for seed in 0..400 {
        let genome = grown(seed, 1 + seed as usize / 2 % 6);
        check_valid(&genome);
        let depth = 1 + seed as usize / 2 % 6;
        assert!(if seed % 2 == 0 { genome.depth() == depth } else { genome.depth() <= depth }, "{genome}");
    }
}

/// Chains of crossovers and mutations: all children are valid, and what a budget admits is within the limits of programmes.
fn vary_many(operations: u64) {
    use rayon::prelude::*;
    const CHAIN: u64 = 100;
    let refused: u64 = (0..operations / CHAIN)
        .into_par_iter()
        .map(|chain| {
            let mut pool = [grown(chain, 6), grown(chain + 1, 5)];
            let mut refused = 0;
            for step in 0..CHAIN {
                let mut draws = Draws::of(chain, &[step, 77]);
                let child = if draws.chance(0.5) { cross(&pool[0], &pool[1], &mut draws) } else { mutate(&pool[0], &mut draws).0 };
                check_valid_or_large(&child);
                if Budget::default().admit(&child).is_some() {
                    child.programme().expect("within the limits").check_cost().expect("within the limits");
                    pool[step as usize % 2] = child;
                } else {
                    refused += 1;
                }
            }
            refused
        })
        .sum();
    println!("{operations} operations, {refused} children over the budget");
    assert!(refused < operations / 5, "{refused}");
}

fn check_valid_or_large(genome: &Genome) {
    if genome.size() > crate::programme::MAX_NODES || genome.depth() > crate::programme::MAX_DEPTH {
        assert!(Budget::default().admit(genome).is_none());
    } else {
        match genome.programme() {
            Ok(_) => check_valid(genome),
            // Derivatives of derivatives: the one limit that text alone does not show.
            Err(error) => assert!(error.message.contains("written out"), "{genome}: {error}"),
        }
    }
}

#[test]
fn ten_thousand_children_are_valid_and_within_the_budget() {
    vary_many(10_000);
}

#[test]
#[ignore = "minutes: a million crossovers and mutations"]
fn a_million_children_are_valid_and_within_the_budget() {
    vary_many(1_000_000);
}

#[test]
fn the_three_mutations_are_as_frequent() {
    let parent = genome("plus(sin(fbm(1, 2, 8, seed=1)), mix(o_perlin(seed=2), 2, y))");
    let mut counts = [0_i32; 3];
    let n = 9_000;
    for i in 0..n {
        let (_, mutation) = mutate(&parent, &mut Draws::of(5, &[i]));
        counts[mutation as usize] += 1;
    }
    // Four standard deviations of 9,000 draws of a third are 179.
    assert!(counts.iter().all(|count| (count - 3_000).abs() < 179), "{counts:?}");
}

#[test]
fn mutations_do_what_they_say() {
    let parent = genome("plus(sin(x), mix(1, 2, y))");
    let bare = |genome: &Genome| genome.genes().iter().map(|gene| gene.signature.map_or("number", |signature| signature.name)).collect::<Vec<_>>();
    let parent_names = bare(&parent);
    let mut swaps = std::collections::BTreeSet::new();
    for i in 0..2_000 {
        let (child, mutation) = mutate(&parent, &mut Draws::of(6, &[i]));
        let mut names = bare(&child);
        match mutation {
            Mutation::Replace => {}
            Mutation::Shrink => assert!(names.len() < parent_names.len() && names.iter().all(|name| parent_names.contains(name)), "{child}"),
            Mutation::Swap => {
                swaps.insert(names.join(" "));
                names.sort_unstable();
                let mut all = parent_names.clone();
                all.sort_unstable();
                assert_eq!(names, all, "{child}");
            }
        }
    }
    assert!(swaps.len() >= 8, "{swaps:?}");
    // A chain has no disjoint subtrees: two functions change places; with one function there is nothing to swap.
    let chain = genome("sin(abs(sqrt(x)))");
    let swapped = (0..200).map(|i| mutate(&chain, &mut Draws::of(7, &[i]))).filter(|(_, mutation)| *mutation == Mutation::Swap);
    let swapped: Vec<_> = swapped.map(|(child, _)| child).collect();
    assert!(swapped.len() > 40 && swapped.iter().all(|child| child.depth() == 4 && *child != chain), "{}", swapped.len());
    assert!((0..200).all(|i| mutate(&genome("sin(x)"), &mut Draws::of(8, &[i])).1 != Mutation::Swap));
}

#[test]
fn a_crossover_puts_a_subtree_of_one_into_the_other() {
    let (taker, giver) = (genome("plus(x, sin(y))"), genome("multiply(2, abs(3))"));
    let all: std::collections::BTreeSet<String> = (0..2_000).map(|i| cross(&taker, &giver, &mut Draws::of(4, &[i])).to_string()).collect();
    assert_eq!(all.len(), 16, "four places, four subtrees: {all:?}");
    assert!(all.contains("plus(x, sin(abs(3)))") && all.contains("multiply(2, abs(3))"));
}

/// Rates of table I over many sessions, within four standard deviations.
#[test]
fn operators_are_applied_at_the_rates_of_the_paper() {
    let (mut one, mut two) = ([0_f64; 2], [0_f64; 2]);
    for seed in 0..60 {
        let given: Vec<Genome> = (0..12).map(|i| genome(&format!("plus(fbm(1, 2, 4, seed={i}), sin(multiply({i}, x)))"))).collect();
        let mut session = Session::new(seed, &given).expect("a session");
        for generation in 0..6 {
            let parents: &[usize] = if generation % 2 == 0 { &[3] } else { &[4, 11] };
            for bred in &session.choose(&Choice::of(parents)).expect("a choice")[parents.len()..] {
                match bred.origin {
                    Origin::Copied(_) => one[1] += 1.0,
                    Origin::Mutated { .. } if parents.len() == 1 => one[0] += 1.0,
                    Origin::Mutated { .. } => two[1] += 1.0,
                    Origin::Crossed { .. } => two[0] += 1.0,
                    other => panic!("{other:?}"),
                }
            }
        }
    }
    let check = |[applied, not]: [f64; 2], rate: f64| {
        let n = applied + not;
        let got = applied / n;
        println!("{got:.4} of {n} children, wanted {rate}");
        assert!((got - rate).abs() < 4.0 * (rate * (1.0 - rate) / n).sqrt(), "{got} of {n}, not {rate}");
    };
    check(one, 0.5);
    check(two, 0.9);
}

fn session(seed: u64) -> Session {
    let mut session = Session::new(seed, &[genome("ridged_multifractal(1, 2, 6, 1, 2)")]).expect("a session");
    for (generation, parents) in [&[0][..], &[3, 7], &[11], &[5, 0], &[2, 9], &[1]].into_iter().enumerate() {
        session.choose(&Choice { parents: parents.to_vec(), again: generation as u32 % 2 }).expect("a choice");
        session.keep(generation, &format!("generation {generation}")).expect("kept");
    }
    session
}

#[test]
fn replay_gives_the_same_genomes_on_any_number_of_threads_and_from_json() {
    for seed in 0..4 {
        let whole = session(seed);
        let json = serde_json::to_string(whole.record()).expect("JSON");
        let record = Record::parse(json.as_bytes()).expect("a record");
        assert_eq!(record, *whole.record());
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let replayed = pool.install(|| Session::replay(record.clone())).expect("a record");
            assert_eq!(replayed.generations(), whole.generations(), "{threads} threads");
        }
        // Written and read again after any step, it goes on alike.
        for step in 0..whole.record().choices.len() {
            let part = whole.branch(step).expect("a generation");
            let json = serde_json::to_string(part.record()).expect("JSON");
            let mut resumed = Session::replay(Record::parse(json.as_bytes()).expect("a record")).expect("a record");
            for choice in &whole.record().choices[step..] {
                resumed.choose(choice).expect("a choice");
            }
            assert_eq!(resumed.generations(), whole.generations());
        }
    }
    assert_ne!(session(1).newest(), session(2).newest());
}

#[test]
fn choices_are_undone_branched_and_bred_again() {
    let mut session = session(3);
    let (before, generations) = (session.clone(), session.generations().len());
    session.choose(&Choice::of(&[4])).expect("a choice");
    let first = session.newest().to_vec();
    assert_eq!(first[0].origin, Origin::Chosen(4));
    assert_eq!(first[0].genome, before.newest()[4].genome);
    assert_eq!(session.undo(), Some(Choice::of(&[4])));
    assert_eq!(session, before);
    session.choose(&Choice::of(&[4])).expect("a choice");
    assert_eq!(session.newest(), first);
    session.undo();
    session.choose(&Choice { parents: vec![4], again: 1 }).expect("a choice");
    assert_ne!(session.newest(), first);
    let branch = before.branch(2).expect("a generation");
    assert_eq!(branch.generations(), &before.generations()[..3]);
    assert_eq!(branch.record().kept, before.record().kept, "what was kept stays");
    assert!(before.branch(generations).is_err());
    let mut empty = Session::new(1, &[]).expect("a session");
    assert_eq!(empty.undo(), None);
}

#[test]
fn what_is_wrong_in_a_record_is_named() {
    let check = |json: &str, expected: &str| {
        let error = Record::parse(json.as_bytes()).err().or_else(|| Session::replay(Record::default()).err()).expect("wrong");
        assert!(error.to_string().starts_with(expected), "{json}: {error}");
    };
    check(r#"{"form": 2, "seed": 1}"#, "at /form: must be 1");
    check(r#"{"form": 1, "seed": 9007199254740992}"#, "at /seed: must be 0 … 9007199254740991");
    check(r#"{"form": 1, "seed": 1, "sed": 1}"#, "at /sed: unknown field");
    check(r#"{"form": 1, "seed": 1, "budget": {"nodes": 5000}}"#, "at /budget/nodes: must be 1 … 4096");
    check(r#"{"form": 1, "seed": 1, "programmes": ["x", "plus(x, fmb(1))"]}"#, "at /programmes/1: at /args/1: unknown function");
    check(r#"{"form": 1, "seed": 1, "budget": {"cost_ns": 60}, "programmes": ["fbm(1, 2, 32, basis=voronoi_f4)"]}"#, "at /programmes/0: is over the budget");
    check(r#"{"form": 1, "seed": 1, "choices": [{"parents": [1]}, {"parents": [2, 2]}]}"#, "at /choices/1/parents: must be one or two different");
    check(r#"{"form": 1, "seed": 1, "choices": [{"parents": [12]}]}"#, "at /choices/0/parents: must be one or two different individuals, 0 … 11");
    check(r#"{"form": 1, "seed": 1, "kept": [{"name": "", "generation": 0, "individual": 0, "programme": "x"}]}"#, "at /kept/0/name");
    let mut session = Session::new(1, &[]).expect("a session");
    let before = session.clone();
    assert!(session.choose(&Choice::of(&[])).is_err() && session.choose(&Choice::of(&[1, 2, 3])).is_err() && session.keep(12, "x").is_err());
    assert!(session.keep(1, &"x".repeat(101)).is_err());
    assert_eq!(session, before);
    session.keep(1, "one").expect("kept");
    session.keep(2, "one").expect("kept anew");
    assert_eq!((session.record().kept.len(), session.record().kept[0].individual), (1, 2));
    assert!(session.forget("one") && !session.forget("one"));
}

/// A small budget is kept by construction, and what cannot be bred is counted.
#[test]
fn children_stay_within_a_small_budget() {
    let budget = Budget { nodes: 9, depth: 4, cost_ns: 60.0 };
    let mut session = Session::replay(Record { seed: 5, budget, ..Record::default() }).expect("a record");
    for generation in 0..20 {
        session.choose(&Choice::of(&[generation % 12, (generation + 5) % 12])).expect("a choice");
    }
    assert!(session.generations().iter().flatten().all(|bred| budget.admit(&bred.genome).is_some()));
    let redrawn: u32 = session.generations().iter().flatten().map(|bred| bred.redrawn).sum();
    assert!(redrawn > 0, "the budget is so small that children are drawn again");
}

/// Of twelve that are grown nearly all show terrain, and every range is known.
#[test]
fn first_generations_are_worth_seeing() {
    let (mut worth, mut count) = (0, 0);
    for seed in 0..10 {
        let session = Session::new(seed, &[]).expect("a session");
        for individual in 0..POPULATION {
            let extent = session.portrait(individual).expect("an individual").extent();
            assert!(extent.measured[0] <= extent.measured[1] && extent.measured.iter().all(|value| value.is_finite()));
            assert!(extent.bounds[0] <= f64::from(extent.measured[0]) && f64::from(extent.measured[1]) <= extent.bounds[1]);
            worth += usize::from(extent.is_worth_seeing);
            count += 1;
        }
    }
    assert!(worth * 100 >= count * 97, "{worth} of {count}");
}

/// What a record breeds is part of what it is: the same on every machine and with every version of its form.
#[test]
fn a_record_breeds_what_it_always_bred() {
    let text: String = session(7).generations().iter().flatten().map(|bred| bred.genome.to_string()).collect();
    assert_eq!(text.bytes().fold(0, |digest, byte| crate::noise::key(digest, byte.into())), 7_459_423_560_038_567_038, "{text:.200}");
}
