//! Levels of detail: a sample at one spacing is the mean of the four samples at half of it that lie in it.

use rayon::prelude::*;
use terrane::{
    geometry::{Axis, Filter, Window},
    world::{Document, EXAMPLES, PRESETS, Preset, Survey, World},
};

/// Every shipped programme and example world, with its name.
fn shipped() -> Vec<(String, World)> {
    let programmes = PRESETS.iter().map(|shipped| (shipped.name.to_owned(), Preset::parse(shipped.json.as_bytes()).unwrap().document()));
    let worlds = EXAMPLES.iter().map(|shipped| (format!("world {}", shipped.name), Document::parse(shipped.json.as_bytes()).unwrap()));
    programmes.chain(worlds).map(|(name, document)| (name, World::new(document))).collect()
}

/// A square of pixel centres.
fn window(centre: [f64; 2], spacing: f64, side: usize) -> Window {
    let last = side as i64 - 1;
    let axis = |(first, stride, centre)| Axis::new(first, stride, spacing / 2.0, centre, side);
    Window { columns: axis((-last, 2, centre[0])), rows: axis((last, -2, centre[1])), filter: Filter::Band }
}

/// The difference of the elevations that 0.1 and 99.9 % of the exact samples of the survey's view lie below.
fn relief(world: &World, survey: &Survey, side: usize) -> f64 {
    let mut elevations = world.evaluate(&Window { filter: Filter::Exact, ..survey.window(side) }).elevation;
    elevations.sort_by(f32::total_cmp);
    let tail = elevations.len() / 1000;
    f64::from(elevations[elevations.len() - 1 - tail] - elevations[tail])
}

/// Root mean square and mean of what samples at twice the spacing differ from the means of those at it, around a centre.
fn step(world: &World, centre: [f64; 2], spacing: f64, side: usize) -> [f64; 2] {
    let children = world.evaluate(&window(centre, spacing, 2 * side));
    let parents = world.evaluate(&window(centre, 2.0 * spacing, side));
    let (mut squares, mut sum) = (0.0, 0.0);
    for row in 0..side {
        for column in 0..side {
            let four = [0, 1].map(|i| children.row(2 * row + i)[2 * column..2 * column + 2].iter().map(|&h| f64::from(h)).sum::<f64>());
            let difference = f64::from(parents.row(row)[column]) - (four[0] + four[1]) / 4.0;
            squares += difference * difference;
            sum += difference;
        }
    }
    let count = (side * side) as f64;
    [(squares / count).sqrt(), sum / count]
}

/// What misses the promise somewhere among the steps of the test, and the most that it may, in percent. Curves of what erosion cuts, where its second lattice goes. Of
/// `dunes`, `mesas` and `spires` the coarsest waves and octaves go at once; `eq2` has poles at all places. Features go where samples are about as far apart as they reach, and
/// `ranges` fades into its mean from 0.06 cells a sample on.
const KNOWN: [(&str, f64); 13] = [
    ("canyonlands", 2.9),
    ("dunes", 3.6),
    ("eq2", 4.2),
    ("fjords", 2.6),
    ("glacial-valleys", 3.6),
    ("spires", 2.1),
    ("world archipelago-endless", 8.0),
    ("world dunes", 2.9),
    ("world eq2", 4.2),
    ("world mesas", 3.6),
    ("world ranges", 7.1),
    ("world ridges-and-rivers", 5.1),
    ("world ridges-rivers-and-lakes", 4.8),
];

/// The promise: at most 2 % of the relief from level to level. Four steps of each programme; `the_table_of_levels` takes all.
#[test]
fn a_sample_is_the_mean_of_the_finer_samples_in_it() {
    let wrong: Vec<String> = shipped()
        .par_iter()
        .flat_map_iter(|(name, world)| {
            let survey = Survey::of(world);
            let (relief, scale) = (relief(world, &survey, 64), world.document().base.scale);
            let limit = KNOWN.iter().find(|known| known.0 == name).map_or(2.0, |known| known.1);
            [1.0 / 64.0, 1.0 / 16.0, 0.25, 1.0].into_iter().filter_map(move |part| {
                let rms = step(world, survey.centre, scale * part, 16)[0] / relief * 100.0;
                (rms > limit).then(|| format!("{name} at {part} units: {rms:.2} %"))
            })
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// All doublings from 10 m on to where little is left, and how far the mean moves: `cargo test --release --test it -- --ignored --nocapture levels`.
#[test]
#[ignore = "takes minutes"]
#[expect(clippy::print_stdout, reason = "writes the table")]
fn the_table_of_levels() {
    let spacings = || core::iter::successors(Some(10.0), |spacing| Some(spacing * 2.0)).take(13);
    println!("RMS(sample - mean of the four finer ones), then the mean's shift, in % of the relief (exact, 0.1 to 99.9 %, survey's view)");
    println!("{:18} relief {}", "", spacings().map(|spacing| format!("{spacing:6}")).collect::<String>());
    let lines: Vec<String> = shipped()
        .par_iter()
        .map(|(name, world)| {
            let survey = Survey::of(world);
            let relief = relief(world, &survey, 256);
            let steps: Vec<[f64; 2]> = spacings().map(|spacing| step(world, survey.centre, spacing, 32).map(|d| d / relief * 100.0)).collect();
            let line = |i: usize| steps.iter().map(|step| format!(" {:5.2}", step[i])).collect::<String>();
            format!("{name:18} {relief:6.0}{}\n{:25}{}", line(0), "", line(1))
        })
        .collect();
    println!("{}", lines.join("\n"));
}
