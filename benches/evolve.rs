//! Terrain that is bred: twelve programmes and their pictures, genomes judged a second, a generation of adaptive ground. Least and median of `ROUNDS` (5), on all threads.
#![expect(clippy::unwrap_used, reason = "a benchmark says what is wrong by failing")]
#![expect(clippy::print_stdout, reason = "what is measured is part of the figures")]

use rayon::prelude::*;
use std::time::{Duration, Instant};
use terrane::{
    evolve::{Adaptive, Aim, Choice, Feedback, Ground, Portrait, Session},
    genetic::{Evolution, Settings},
    geometry::Stop,
    tile::preview,
};

fn timed<T>(mut work: impl FnMut(u64) -> T) -> ([Duration; 2], T) {
    let rounds = std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(5).max(1);
    let mut last = None;
    let mut times: Vec<Duration> = (0..rounds)
        .map(|round| {
            let start = Instant::now();
            last = Some(work(round));
            start.elapsed()
        })
        .collect();
    times.sort_unstable();
    ([times[0], times[times.len() / 2]], last.unwrap())
}

fn ms([least, median]: [Duration; 2]) -> String {
    format!("{:.1} ms, median {:.1}", least.as_secs_f64() * 1e3, median.as_secs_f64() * 1e3)
}

fn breeding() {
    let (times, session) = timed(|seed| Session::new(seed, &[]).unwrap());
    println!("first generation of twelve: {}", ms(times));
    let (times, session) = timed(|again| {
        let mut session = session.clone();
        session.choose(&Choice { parents: vec![2, 7], again: again as u32 }).unwrap();
        session
    });
    println!("twelve bred of two: {}", ms(times));
    let pictures = |session: &Session| {
        let pictures = (0..12).into_par_iter().map(|i| preview(&session.portrait(i).unwrap(), &Portrait::window(192), f64::NEG_INFINITY).unwrap().len());
        pictures.sum::<usize>()
    };
    let (times, bytes) = timed(|_| pictures(&session));
    println!("twelve pictures of 192 × 192: {}, {} kB", ms(times), bytes / 1000);
    let (times, _) = timed(|again| {
        let mut session = session.clone();
        session.choose(&Choice { parents: vec![0, 5], again: again as u32 }).unwrap();
        pictures(&session)
    });
    println!("twelve bred and shown: {}", ms(times));
}

fn evolution() {
    let wanted = br#"{"seed": 7, "wanted": [{"weight": 3, "criterion": {"accessibility": {"slope": 15, "share": 0.8}}}, {"criterion": {"edges": {"slope": 15, "density": 8000}}}]}"#;
    let aim = Aim::parse(wanted).unwrap();
    let (times, state) = timed(|seed| {
        let mut evolution = Evolution::new(&aim, Settings { generations: 10, ..Settings::default() }, seed, &Stop::never()).unwrap().unwrap();
        evolution.run(&Stop::never(), &mut |_| true);
        evolution.into_state()
    });
    println!("ten generations of 64 at 128 × 128: {}, {:.0} genomes a second", ms(times), state.evaluations as f64 / times[0].as_secs_f64());
}

fn adaptive() {
    let (times, _) = timed(|seed| {
        let mut adaptive = Adaptive::new(Ground { seed, ..Ground::default() }).unwrap();
        for _ in 0..30 {
            adaptive.feed(Feedback::point([640.0, 640.0])).unwrap();
        }
        adaptive
    });
    println!("thirty generations of adaptive ground, 129 × 129 nodes: {}", ms(times));
}

fn main() {
    breeding();
    evolution();
    adaptive();
}
