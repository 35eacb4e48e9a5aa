//! Fast forms against plain ones, the same bits however it is made, and real places.

use super::{
    gene::{Layout, Reading, Stock},
    ground::Ground,
    pattern::HeightGrid,
    raster::squared_distances,
    relax::Slopes,
    source::{TypeSources, distance, shares},
    *,
};
use crate::{
    genetic::{Draws, Problem},
    geometry::Stop,
    synthesis::{
        Analysis, Crop, Level, Library, LibraryProblem, Linking, Map, MapRegion, Model, ReadyLibrary, ReadySample, SampleGrid, Voids,
        tests::{hills, level, shared},
    },
};

fn whole(grid: SampleGrid) -> ReadySample {
    let part = Crop { column: 0, row: 0, columns: grid.columns, rows: grid.rows };
    ReadySample { grid, mask: None, water: Vec::new(), part, notes: Vec::new() }
}

fn library(count: usize) -> Library {
    let kind = |i: usize| serde_json::json!({"name": format!("type-{i}"), "colour": "#808080", "samples": [{"file": "made.asc"}]});
    let document = serde_json::json!({"types": (0..count).map(kind).collect::<Vec<_>>()});
    Library::parse(document.to_string().as_bytes()).expect("a library")
}

/// Two types of made-up hills, at 90 and 270 m.
fn made() -> ReadyLibrary {
    let kind = |relief: f32, seed: u64| (0..3).map(|i| whole(hills(96, 84, 90.0, relief, seed + 10 * i))).collect();
    ReadyLibrary { types: vec![kind(0.6, 1), kind(2.5, 100)] }
}

fn square(kind: usize, [west, south]: [f64; 2], [east, north]: [f64; 2]) -> MapRegion {
    MapRegion { kind: format!("type-{kind}"), rings: vec![vec![[west, south], [east, south], [east, north], [west, north]]] }
}

/// Two types side by side, 9 × 6 km.
fn halves() -> Map {
    Map { regions: vec![square(0, [0.0, 0.0], [4_000.0, 6_000.0]), square(1, [4_000.0, 0.0], [9_000.0, 6_000.0])], snap: 1.0 }
}

fn options() -> FieldOptions {
    FieldOptions { seed: 7, generations: 4, looks: 24, ..FieldOptions::default() }
}

fn run<'a>(ready: &'a ReadyLibrary, map: &Map, options: FieldOptions) -> Synthesis<'a> {
    let mut synthesis = Synthesis::new(&library(ready.types.len()), ready, map, options).expect("all is right");
    assert!(synthesis.run(&Stop::never(), &mut |_| true));
    synthesis
}

#[test]
fn decoding_an_encoded_sample_returns_it_to_the_last_bit() {
    let grid = hills(67, 45, 30.0, 3.0, 3);
    for gene in [8, 11, 16] {
        let layout = Layout::new([67, 45], gene);
        let types = [TypeSources::new(&[Analysis::new(grid.clone(), None)], &layout)];
        let place = |number: usize| layout.middle(number).map(|c| c as i32);
        let genome: Vec<Gene> = (0..layout.count()).map(place).map(|[column, row]| Gene { column, row, ..Gene::default() }).collect();
        let kinds = vec![0; genome.len()];
        let stock = Stock { types: &types, kinds: &kinds, reading: Reading::Whole };
        let mut decoded = HeightGrid { columns: 67, rows: 45, heights: vec![0.0; 67 * 45] };
        layout.decode(&genome, &stock, &mut decoded, [0, 67], [0, 45]);
        assert_eq!(decoded.heights, grid.heights, "genes of {gene}");
    }
}

#[test]
fn a_turn_of_a_piece_turns_its_slopes() {
    let grid = hills(60, 60, 30.0, 3.0, 5);
    let gradient = |heights: &dyn Fn([i32; 2]) -> f32| [heights([1, 0]) - heights([-1, 0]), heights([0, 1]) - heights([0, -1])];
    let at = |[x, y]: [i32; 2]| grid.heights[(30 + y) as usize * 60 + (30 + x) as usize];
    let own = gradient(&at);
    for turn in (0..8).map(Turn) {
        let turned = gradient(&|offset| at(turn.of(offset)));
        assert_eq!(turned, turn.back(own), "{turn:?}");
    }
}

/// The ground of a level above a made-up pattern.
fn with_ground(check: impl Fn(&Ground)) {
    let (ready, map, options) = (made(), halves(), options());
    let synthesis = Synthesis::new(&library(2), &ready, &map, options).expect("all is right");
    let (raster, coarse) = (synthesis.raster(level(90.0)), synthesis.raster(level(270.0)));
    let analyses = ready.analyse(level(90.0));
    let layout = Layout::new([1, 1], 16);
    let types: Vec<TypeSources> = analyses.iter().map(|samples| TypeSources::new(samples, &layout)).collect();
    let models = Model::new(&analyses.iter().map(|samples| samples.iter().collect()).collect::<Vec<_>>()).types;
    let (columns, rows) = (coarse.frame.columns, coarse.frame.rows);
    let pattern = HeightGrid { columns, rows, heights: hills(columns, rows, 270.0, 3.0, 9).heights };
    check(&Ground::new(&raster, &pattern, 16, &|region| region as usize, (&types, &models), &options));
}

#[test]
fn what_a_change_costs_is_its_own_area_and_the_bits_are_those_of_the_whole() {
    with_ground(|ground| {
        let mut draws = Draws::new(3);
        let genomes: Vec<Vec<Gene>> = (0..2).map(|number| ground.initialise(number, &mut draws)).collect();
        let never = Stop::never();
        let mut child = genomes[0].clone();
        let mut known = ground.evaluate(&child, None, &never);
        let mut changes = 0;
        for round in 0..30 {
            let mut change = Vec::new();
            match round % 3 {
                0 => ground.cross(&mut child, &genomes[1], &mut change, &mut draws),
                1 => ground.mutate(&mut child, &known, &mut change, &mut draws),
                _ => change = ground.conform(&mut child, &known.fits),
            }
            changes += change.len();
            known = ground.evaluate(&child, Some((&known, &change)), &never);
            assert_eq!(known, ground.evaluate(&child, None, &never), "round {round}: {} genes changed", change.len());
        }
        assert!(changes > 20, "{changes}");
    });
}

#[test]
fn statistics_of_blocks_are_those_of_regions() {
    with_ground(|ground| {
        let genome = ground.initialise(0, &mut Draws::new(4));
        let known = ground.evaluate(&genome, None, &Stop::never());
        let [columns, rows] = ground.layout.cells;
        let analysis = Analysis::new(SampleGrid { columns, rows, spacing: [90.0; 2], heights: known.ground.heights.clone() }, None);
        let side = tally::BLOCK * ground.layout.pitch;
        for region in 0..2 {
            let plain = analysis.profile_in(|cell| ground.region_of(cell) == Some(region), Linking::Blocks(side));
            let sums = ground.profiles(&known)[region];
            for (plain, sums) in plain.0.iter().zip(&sums.0).take(2) {
                assert_eq!(plain.count, sums.count);
                for (plain, sums) in plain.numbers().iter().zip(sums.numbers()) {
                    assert!((plain - sums).abs() < 1e-6 * (1.0 + plain.abs()), "{plain} {sums}");
                }
            }
            // Points are looked for about another middle: a few of them are on the edge of being found.
            for (plain, sums) in plain.0.iter().zip(&sums.0).skip(2) {
                assert!(plain.count.abs_diff(sums.count) <= 1 + plain.count / 50 && (plain.mean - sums.mean).abs() < 0.02 * plain.mean, "{plain:?} {sums:?}");
            }
        }
    });
}

#[test]
fn distances_are_those_of_looking_at_every_cell() {
    let mut draws = Draws::new(9);
    for _ in 0..40 {
        let (columns, rows) = (1 + draws.below(24), 1 + draws.below(24));
        let share = draws.unit() * 0.2;
        let ones: Vec<bool> = (0..columns * rows).map(|_| draws.chance(share)).collect();
        let squares = squared_distances(columns, rows, |cell| ones[cell]);
        for (cell, square) in squares.iter().enumerate() {
            let to = |other: usize| ((cell % columns).abs_diff(other % columns).pow(2) + (cell / columns).abs_diff(other / columns).pow(2)) as u64;
            match (0..ones.len()).filter(|other| ones[*other]).map(to).min() {
                Some(expected) => assert_eq!(*square, expected),
                None => assert!(*square > 1 << 30),
            }
        }
    }
}

#[test]
fn cells_have_the_region_and_the_distance_that_the_map_gives_them() {
    let map = Map {
        regions: vec![square(0, [0.0, 0.0], [270.0, 270.0]), square(1, [270.0, 0.0], [540.0, 180.0]), square(0, [270.0, 180.0], [540.0, 270.0])],
        snap: 1.0,
    };
    let library = Library { smoothness: 1.0, ..library(2) };
    let ready = made();
    let synthesis = Synthesis::new(&library, &ready, &map, options()).expect("all is right");
    let raster = synthesis.raster(level(90.0));
    assert_eq!((raster.frame.columns, raster.frame.rows), (6, 3));
    assert_eq!(raster.regions, [0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 0, 0, 0, 1, 1, 1], "regions of one type that touch are one");
    assert_eq!(raster.distance[9..12], [0.5, 0.5, 0.5]);
    assert_eq!(raster.distance[2], 0.5_f32.hypot(0.5));
    assert_eq!(raster.distance[6], 2.5);
    let image = raster.image(|region| [200, 100 * region as u8, 0]);
    assert_eq!((image.len(), &image[..3], &image[27..30]), (54, &[200, 0, 0][..], &[100, 50, 0][..]));
}

#[test]
fn ground_outside_of_the_map_is_that_of_the_nearest_region() {
    let map = Map {
        regions: vec![
            MapRegion { kind: "type-0".into(), rings: vec![vec![[0.0, 0.0], [4_500.0, 0.0], [0.0, 4_500.0]]] },
            square(1, [4_500.0, 0.0], [9_000.0, 900.0]),
        ],
        snap: 1.0,
    };
    let ready = made();
    let synthesis = Synthesis::new(&library(2), &ready, &map, options()).expect("all is right");
    let raster = synthesis.raster(level(90.0));
    let (columns, count) = (raster.frame.columns, raster.inside.iter().filter(|inside| **inside).count());
    assert!(count.abs_diff(1250 + 500) < 60, "{count}");
    assert_eq!([raster.regions[0], raster.regions[columns - 1]], [0, 1]);
    assert!(raster.inside[columns * 5 + 1] && !raster.inside[columns - 1]);
}

#[test]
fn ground_comes_back_from_its_slopes_and_a_step_is_spread() {
    let grid = hills(40, 30, 30.0, 5.0, 2);
    let same = Slopes::of(40, 30, &grid.heights).relaxed(8.0);
    assert!(same.iter().zip(&grid.heights).all(|(a, b)| (a - b).abs() < 1e-3));
    // Two plains 100 m apart whose seam is to be level.
    let mut slopes = Slopes::new(80, 8);
    (0..640).filter(|cell| cell % 80 >= 40).for_each(|cell| slopes.heights[cell] = 100.0);
    let spread = slopes.relaxed(5.0);
    let steepest = spread.windows(2).enumerate().filter(|(cell, _)| cell % 80 < 79).map(|(_, pair)| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
    assert!(steepest < 12.0 && spread[0] < 0.1 && spread[79] > 99.9, "{steepest} {} {}", spread[0], spread[79]);
}

#[test]
fn distances_of_distributions_are_in_degrees() {
    let of = |from: f32| shares((0..1000).map(move |i| from + i as f32 / 100.0));
    assert!((distance(&of(5.0), &of(8.0)) - 3.0).abs() < 0.01);
    assert_eq!(distance(&of(5.0), &of(5.0)), 0.0);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let ready = made();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| run(&ready, &halves(), options()).pyramid().to_vec())
    };
    let one = on(1);
    assert_eq!(one, on(3));
    assert_ne!(one, run(&ready, &halves(), FieldOptions { seed: 8, ..options() }).pyramid());
}

#[test]
fn a_checkpoint_of_any_generation_goes_on_to_the_same_bits() {
    let ready = made();
    let mut checkpoints = Vec::new();
    let mut whole = Synthesis::new(&library(2), &ready, &halves(), options()).expect("all is right");
    let mut shares = Vec::new();
    assert!(whole.run(&Stop::never(), &mut |step| {
        shares.push(step.progress.share);
        checkpoints.push(serde_json::to_string(step.checkpoint).expect("JSON"));
        true
    }));
    assert!(shares.is_sorted() && shares.last() == Some(&1.0), "{shares:?}");
    assert_eq!(checkpoints.len(), 1 + 5 + 1, "the base, five generations and the end");
    for checkpoint in checkpoints.iter().step_by(2) {
        let checkpoint = serde_json::from_str(checkpoint).expect("what was written");
        let mut resumed = Synthesis::resume(&library(2), &ready, &halves(), options(), checkpoint).expect("it is of the same");
        assert!(resumed.run(&Stop::never(), &mut |_| true));
        assert_eq!(resumed.pyramid(), whole.pyramid());
    }
    // Stopped by whoever is told, it goes on as well.
    let mut parts = Synthesis::new(&library(2), &ready, &halves(), options()).expect("all is right");
    let mut rounds = 0;
    while !parts.run(&Stop::never(), &mut |_| false) && rounds < 20 {
        rounds += 1;
    }
    assert!(parts.is_done() && rounds > 3, "{rounds}");
    assert_eq!(parts.pyramid(), whole.pyramid());
}

#[test]
fn a_stop_is_heeded() {
    let ready = made();
    let stop = Stop::new();
    let mut synthesis = Synthesis::new(&library(2), &ready, &halves(), options()).expect("all is right");
    let mut told = 0;
    assert!(!synthesis.run(&stop, &mut |_| {
        told += 1;
        stop.set();
        true
    }));
    assert!(told == 1 && !synthesis.is_done() && synthesis.pyramid().len() == 1);
}

/// Each level reduced to the one before differs by at most a tenth of the range, root mean square.
#[test]
fn coarse_features_stay() {
    let ready = made();
    let synthesis = run(&ready, &halves(), options());
    let [coarse, fine] = synthesis.pyramid() else { panic!("{:?}", synthesis.levels()) };
    let mut squares = Vec::new();
    for row in 0..fine.rows / 3 {
        for column in 0..fine.columns / 3 {
            let sum: f32 = (0..9).map(|i| fine.heights[(3 * row + i / 3) * fine.columns + 3 * column + i % 3]).sum();
            squares.push(f64::from(sum / 9.0 - coarse.heights[row * coarse.columns + column]).powi(2));
        }
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let [low, high] = coarse.heights.iter().fold([f32::MAX, f32::MIN], |[low, high], height| [low.min(*height), high.max(*height)]);
    assert!(rms < 0.1 * f64::from(high - low), "{rms} m of {}", high - low);
    assert!(fine.compatibility > 0.7, "{}", fine.compatibility);
}

#[test]
fn what_is_wrong_is_named() {
    let ready = made();
    let problem = |map: &Map, options: FieldOptions| -> LibraryProblem { Synthesis::new(&library(2), &ready, map, options).expect_err("wrong") };
    let strange = Map { regions: vec![square(5, [0.0, 0.0], [900.0, 900.0])], snap: 1.0 };
    assert_eq!(problem(&strange, options()).pointer, "/regions/0/type");
    assert_eq!(problem(&halves(), FieldOptions { population: 1, ..options() }).pointer, "/options/population");
    let finest = Level::ALL.last().copied();
    assert_eq!(problem(&halves(), FieldOptions { finest, ..options() }).pointer, "/regions");
    let wide = Map { regions: vec![square(0, [0.0, 0.0], [9e9, 9e9])], snap: 1.0 };
    assert_eq!(problem(&wide, options()).pointer, "/regions");
    let checkpoint = run(&ready, &halves(), options()).checkpoint().clone();
    let other = Synthesis::resume(&library(2), &ready, &halves(), FieldOptions { seed: 9, ..options() }, checkpoint.clone()).expect_err("another seed");
    assert_eq!(other.pointer, "/checkpoint/inputs");
    let mut short = checkpoint;
    short.done[0].heights.pop();
    let short = Synthesis::resume(&library(2), &ready, &halves(), options(), short).expect_err("a height is missing");
    assert_eq!(short.pointer, "/checkpoint/done");
}

/// The part of a shared sample without voids.
fn place(name: &str) -> Option<SampleGrid> {
    let grid = shared(&format!("{name}.asc"))?;
    Voids::Rectangle.part(&grid).and_then(|part| grid.crop(part))
}

/// Made of three quarters of a real place, ground is like the place: its slopes are those of the quarters, and it is more similar to them than the fourth quarter is.
#[test]
fn ground_is_like_the_quarters_that_it_is_made_of() {
    for (name, spacing, most) in [("front-range-srtm3", 90.0, 1.0), ("jacksboro-srtm3", 90.0, 1.0), ("bijou-escarpment-30m", 30.0, 1.0)] {
        let Some(grid) = place(name) else { continue };
        let quarters: Vec<SampleGrid> = grid.quarters().into_iter().filter_map(|crop| grid.crop(crop)).collect();
        let ready = ReadyLibrary { types: vec![quarters[..3].iter().cloned().map(whole).collect()] };
        let kept = Analysis::at(&quarters[3], None, level(spacing)).expect("it reaches the level");
        let size = [kept.grid.columns, kept.grid.rows].map(|cells| cells as f64 * spacing);
        let map = Map { regions: vec![square(0, [0.0, 0.0], size)], snap: 1.0 };
        let synthesis = run(&ready, &map, FieldOptions { seed: 1, ..FieldOptions::default() });
        let fine = synthesis.pyramid().last().expect("a level");
        let made = Analysis::new(SampleGrid { columns: fine.columns, rows: fine.rows, spacing: [spacing; 2], heights: fine.heights.clone() }, None);
        let types = ready.analyse(level(spacing));
        let all = shares(types[0].iter().flat_map(|analysis| analysis.slope.iter().copied()));
        let apart = distance(&shares(made.slope.iter().copied()), &all);
        assert!(apart <= most, "{name}: slopes are {apart}° apart");
        let model = ready.model(level(spacing));
        let similarity = |analysis: &Analysis| model.types[0].value(&analysis.profile());
        assert!(similarity(&made) >= similarity(&kept), "{name}: {} is less than {}", similarity(&made), similarity(&kept));
    }
}
