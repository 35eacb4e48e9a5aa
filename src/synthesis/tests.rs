//! Fast forms against plain ones, figures of other tools, and real terrain.

use super::{
    edges::{detect, link},
    gaussian::{blur, kernel, mirrored},
    *,
};
use std::path::Path;

/// A sample from the shared folder; without the folder the test that asks for it is left out, and says so.
pub(in crate::synthesis) fn shared(name: &str) -> Option<SampleGrid> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/dem").join(name);
    let Ok(bytes) = std::fs::read(&path) else {
        #[expect(clippy::print_stderr, reason = "whoever runs the tests should know what was left out")]
        {
            eprintln!("skipped: there is no {}", path.display());
        }
        return None;
    };
    Some(read(name, &bytes, &Hints::default()).unwrap_or_else(|error| panic!("{error}")).grid)
}

/// Numbers 0 … 1 from a linear congruence.
fn uniform(count: usize, seed: u64) -> Vec<f64> {
    let step = |state: &mut u64| {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        Some((*state >> 40) as f64 / 16_777_216.0)
    };
    std::iter::repeat_n((), count).scan(seed, |state, ()| step(state)).collect()
}

/// Made-up hills: noise blurred at three widths.
pub(in crate::synthesis) fn hills(columns: usize, rows: usize, spacing: f64, relief: f32, seed: u64) -> SampleGrid {
    let layer = |sigma: f64, seed: u64| {
        let noise: Vec<f32> = uniform(columns * rows, seed).into_iter().map(|value| value as f32 - 0.5).collect();
        blur(&noise, columns, rows, sigma).into_iter().map(move |height| height * sigma as f32 * sigma as f32).collect::<Vec<f32>>()
    };
    let layers = [layer(1.5, seed), layer(4.0, seed + 1), layer(10.0, seed + 2)];
    let heights = (0..columns * rows).map(|cell| 500.0 + relief * layers.iter().map(|layer| layer[cell]).sum::<f32>()).collect();
    SampleGrid { columns, rows, spacing: [spacing; 2], heights }
}

pub(in crate::synthesis) fn level(spacing: f64) -> Level {
    Level::try_from(spacing).unwrap()
}

// ---- statistics

/// `SciPy` 1.17: `mean`, `std(ddof=1)`, `skew(bias=False)`, `kurtosis(bias=False)`.
const SCIPY: [(&str, usize, [f64; 4]); 12] = [
    ("uniform", 1000, [1_050.794_589_334_726_4, 28.954_789_068_410_463, -0.027_640_811_180_358_146, -1.199_771_884_262_340_8]),
    ("squares", 100, [3_283.5, 2_968.174_803_926_929_6, 0.653_940_703_866_235_3, -0.833_373_240_652_592_9]),
    ("cubed", 5000, [128.309_938_924_859_27, 146.115_731_582_169_67, 1.053_356_619_907_080_3, -0.116_255_472_044_447_75]),
    ("four", 4, [3.75, 3.095_695_936_834_452, 1.137_624_366_957_688_9, 0.757_655_954_631_379_9]),
    ("tailed", 3000, [4.775_206_393_934_847, 9.402_440_082_870_923, 5.505_065_753_223_214, 37.057_533_121_758_375]),
    ("high", 4000, [8_000.495_849_561_9, 0.293_058_842_987_579_06, -0.003_275_297_405_638_950_7, -1.228_500_584_971_804_3]),
    ("front-range-srtm3", 34_560, [2_547.078_414_351_851_7, 236.249_166_491_632_65, 0.200_010_847_684_528_54, -0.219_315_074_835_463_53]),
    ("jacksboro-srtm3", 138_632, [531.031_168_849_904_8, 162.457_237_027_322_55, 0.591_449_889_739_054_3, -0.164_276_086_498_941_88]),
    ("bijou-escarpment-30m", 8643, [1_746.584_750_665_278_3, 34.465_520_421_283_905, 0.210_096_429_712_714_58, -1.355_745_352_354_087_7]),
    ("bijou-gully-5m", 8085, [1_709.864_734_649_186_4, 15.089_858_346_997_115, -0.494_349_773_950_146_5, -1.083_097_904_872_302_8]),
    ("pre-runout-10m", 9638, [376.766_795_634_728_6, 118.126_032_743_325_96, -0.027_438_973_966_827_17, -1.348_295_118_122_916_4]),
    ("hugo-site-10m", 2152, [1_689.570_167_286_245_4, 12.380_669_924_992_795, -0.344_117_831_100_342_55, -0.918_951_014_559_926]),
];

#[test]
fn statistics_are_those_of_scipy() {
    for (name, count, expected) in SCIPY {
        let values: Vec<f64> = match name {
            "uniform" => uniform(1000, 1).into_iter().map(|u| 1000.0 + 100.0 * u).collect(),
            "squares" => (0..100).map(|i| f64::from(i * i)).collect(),
            "cubed" => uniform(5000, 7).into_iter().map(|u| (u * 8.0).powi(3)).collect(),
            "four" => vec![1.0, 2.0, 4.0, 8.0],
            "tailed" => uniform(3000, 11).into_iter().map(|u| 1.0 / (u + 0.01)).collect(),
            "high" => uniform(4000, 5).into_iter().map(|u| 8000.0 + u).collect(),
            file => match shared(&format!("{file}.asc")) {
                Some(grid) => grid.heights.iter().filter(|height| !height.is_nan()).map(|height| f64::from(*height)).collect(),
                None => continue,
            },
        };
        let statistics = Statistics::of(values.iter().copied());
        assert_eq!(statistics.count, count, "{name}");
        for (ours, theirs) in statistics.numbers().into_iter().zip(expected) {
            assert!((ours - theirs).abs() <= 1e-9 * theirs.abs().max(1.0), "{name}: {ours}, SciPy {theirs}");
        }
    }
}

#[test]
fn few_or_equal_values_have_no_shape() {
    let of = |values: &[f64]| Statistics::of(values.iter().copied()).numbers();
    assert_eq!(Statistics::of(std::iter::empty()), Statistics::default());
    assert_eq!(of(&[5.0]), [5.0, 0.0, 0.0, 0.0]);
    assert_eq!(of(&[0.1; 1001]), [0.1, 0.0, 0.0, 0.0]);
    assert_eq!(of(&[1.0, 3.0]), [2.0, 2.0_f64.sqrt(), 0.0, 0.0]);
    assert_eq!(of(&[1.0, 2.0, 6.0])[3], 0.0);
    assert!(of(&[1.0, 2.0, 6.0])[2] > 0.0);
}

#[test]
fn histograms_count_every_value_once() {
    let histogram = Histogram::of([-5.0, 0.0, 0.9, 1.0, 3.9, 4.0, 99.0, f32::NAN].into_iter(), 0.0, 4.0, 4);
    assert_eq!(histogram, Histogram { from: 0.0, step: 1.0, counts: vec![3, 1, 0, 3] });
}

// ---- voids and water

/// Voids where a picture has dots.
fn picture(lines: &[&str]) -> SampleGrid {
    let heights = lines.iter().flat_map(|line| line.chars()).map(|c| if c == '.' { f32::NAN } else { 1.0 }).collect();
    SampleGrid { columns: lines[0].len(), rows: lines.len(), spacing: [30.0; 2], heights }
}

/// The most cells of a rectangle without voids, by trying all.
fn most_cells(grid: &SampleGrid) -> usize {
    let mut most = 0;
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            for rows in 1..=grid.rows - row {
                for columns in 1..=grid.columns - column {
                    if columns * rows > most && grid.crop(Crop { column, row, columns, rows }).unwrap().voids() == 0 {
                        most = columns * rows;
                    }
                }
            }
        }
    }
    most
}

#[test]
fn the_largest_rectangle_is_the_largest_of_all() {
    for seed in 0..200 {
        let (columns, rows) = (1 + seed as usize % 9, 1 + seed as usize / 9 % 8);
        let share = f64::from(seed as u8 % 5) * 0.15;
        let heights = uniform(columns * rows, seed).into_iter().map(|u| if u < share { f32::NAN } else { 1.0 }).collect();
        let grid = SampleGrid { columns, rows, spacing: [1.0; 2], heights };
        let cells = largest_rectangle(&grid).map_or(0, |crop| {
            assert_eq!(grid.crop(crop).unwrap().voids(), 0);
            crop.columns * crop.rows
        });
        assert_eq!(cells, most_cells(&grid), "seed {seed}");
    }
}

#[test]
fn void_edges_are_trimmed() {
    let slanted = picture(&["....####", "..######", ".#######", "########", "#######.", "######..", "####...."]);
    let crop = trimmed(&slanted).unwrap();
    assert_eq!(slanted.crop(crop).unwrap().voids(), 0);
    assert!(crop.columns * crop.rows >= 9, "{crop:?}");
    assert_eq!(trimmed(&picture(&["..", ".."])), None);
    assert_eq!(largest_rectangle(&picture(&["..", ".."])), None);
    let whole = picture(&["###", "###"]);
    assert_eq!(Voids::Trim.part(&whole), Voids::Rectangle.part(&whole));
    let holed = picture(&["#####", "#####", "##.##", "#####", "#####"]);
    assert_eq!(holed.crop(trimmed(&holed).unwrap()).unwrap().voids(), 0);
}

#[test]
fn water_is_found_and_narrow_steps_are_not() {
    let mut grid = hills(80, 60, 90.0, 60.0, 3);
    // A lake, and a road of one elevation too narrow to be one.
    for row in 20..35 {
        for column in 10..40 {
            grid.heights[row * 80 + column] = 432.0;
        }
    }
    (0..80).for_each(|column| grid.heights[50 * 80 + column] = 433.0);
    let (land, bodies) = find_water(&grid);
    assert_eq!(bodies, [Water { elevation: 432.0, cells: 15 * 30 }]);
    assert_eq!(land.iter().filter(|land| !**land).count(), 15 * 30);
    let (masked, all) = (Analysis::at(&grid, Some(&land), level(90.0)).unwrap(), Analysis::at(&grid, None, level(90.0)).unwrap());
    assert_eq!(masked.profile().0[0].count, 80 * 60 - 15 * 30);
    assert!(masked.points.iter().all(|point| land[point.row * 80 + point.column]));
    assert_eq!(masked.profile(), all.profile_in(|cell| land[cell], Linking::Whole));
}

#[test]
fn the_reservoir_of_jacksboro_is_found() {
    let Some(grid) = shared("jacksboro-srtm3.asc") else { return };
    let (_, bodies) = find_water(&grid);
    assert!(bodies.iter().any(|body| body.cells > 300), "{bodies:?}");
}

// ---- levels

/// A ripple of one wave to the east.
fn ripple(columns: usize, spacing: f64, wave: f64) -> SampleGrid {
    let heights = (0..columns * 64).map(|cell| (100.0 * ((cell % columns) as f64 * spacing * core::f64::consts::TAU / wave).sin()) as f32).collect();
    SampleGrid { columns, rows: 64, spacing: [spacing; 2], heights }
}

fn deviation(grid: &SampleGrid) -> f64 {
    let inner = grid.crop(Crop { column: grid.columns / 4, row: 0, columns: grid.columns / 2, rows: grid.rows }).unwrap();
    Statistics::of(inner.heights.iter().map(|height| f64::from(*height))).deviation
}

#[test]
fn what_a_level_cannot_carry_is_left_out_and_the_rest_kept() {
    let kept = ripple(1200, 10.0, 900.0);
    assert!((deviation(&kept.at(level(90.0)).unwrap()) / deviation(&kept) - 1.0).abs() < 0.02);
    let lost = ripple(1200, 10.0, 120.0);
    assert!(deviation(&lost.at(level(90.0)).unwrap()) < 0.05 * deviation(&lost));
}

#[test]
fn levels_keep_planes_and_their_own_cells() {
    let plane =
        SampleGrid { columns: 90, rows: 60, spacing: [30.0, 20.0], heights: (0..5400).map(|i| 2.0 * (i % 90) as f32 + 3.0 * (i / 90) as f32).collect() };
    let coarse = plane.at(level(90.0)).unwrap();
    assert_eq!((coarse.columns, coarse.rows, coarse.spacing), (30, 13, [90.0; 2]));
    let inner = |grid: &SampleGrid, column: usize, row: usize| f64::from(grid.row(row)[column]);
    let [east, south] = [inner(&coarse, 16, 6) - inner(&coarse, 15, 6), inner(&coarse, 15, 7) - inner(&coarse, 15, 6)];
    assert!((east - 6.0).abs() < 0.05 && (south - 13.5).abs() < 0.05, "{east} {south}");
    let same = SampleGrid { columns: 64, rows: 64, spacing: [30.0; 2], heights: hills(64, 64, 30.0, 50.0, 1).heights };
    assert_eq!(same.at(level(30.0)).unwrap(), same);
    assert_eq!(same.at(level(10.0)), None, "finer than it is");
    assert_eq!(SampleGrid { columns: 2, rows: 2, spacing: [30.0; 2], heights: vec![0.0; 4] }.at(level(810.0)), None);
}

#[test]
fn genes_shrink_to_eight_cells() {
    let side = |columns, rows| gene_side(&SampleGrid { columns, rows, spacing: [90.0; 2], heights: vec![0.0; columns * rows] });
    assert_eq!([side(100, 48), side(47, 60), side(24, 24), side(23, 400)], [Some(16), Some(15), Some(8), None]);
    assert!(Level::try_from(91.0).is_err());
    assert_eq!(serde_json::to_string(&Level::ALL).unwrap(), "[10.0,30.0,90.0,270.0,810.0]");
}

// ---- analysis

#[test]
fn a_blur_is_its_plain_sum_to_the_bit() {
    for (columns, rows) in [(1, 1), (3, 7), (40, 33)] {
        let heights: Vec<f32> = uniform(columns * rows, 9).into_iter().map(|u| u as f32 * 100.0).collect();
        for sigma in [0.7, 1.0, 2.5, 4.0] {
            let kernel = kernel(sigma);
            assert!((kernel[0] + 2.0 * kernel[1..].iter().sum::<f32>() - 1.0).abs() < 1e-6);
            let along = |of: &dyn Fn(isize) -> f32| {
                let pairs = kernel.iter().enumerate().skip(1);
                pairs.fold(kernel[0] * of(0), |sum, (distance, weight)| sum + weight * (of(-(distance as isize)) + of(distance as isize)))
            };
            let across: Vec<f32> = (0..columns * rows)
                .map(|cell| along(&|step| heights[cell / columns * columns + mirrored((cell % columns) as isize + step, columns)]))
                .collect();
            let plain: Vec<f32> =
                (0..columns * rows).map(|cell| along(&|step| across[mirrored((cell / columns) as isize + step, rows) * columns + cell % columns])).collect();
            assert_eq!(blur(&heights, columns, rows, sigma), plain);
        }
    }
}

/// [`link`] by looking at all pairs.
fn plain_link(points: &[EdgePoint], linking: Linking, spacing: f64, together: &dyn Fn(&EdgePoint, &EdgePoint) -> bool) -> Vec<Edge> {
    let linked = |one: &EdgePoint, other: &EdgePoint| {
        let blocks = match linking {
            Linking::Whole => true,
            Linking::Blocks(side) => one.column / side == other.column / side && one.row / side == other.row / side,
        };
        blocks && one.column.abs_diff(other.column) <= 1 && one.row.abs_diff(other.row) <= 1 && together(one, other)
    };
    let mut edge_of: Vec<usize> = (0..points.len()).collect();
    let mut length = vec![0.0; points.len()];
    for (i, one) in points.iter().enumerate() {
        for (j, other) in points.iter().enumerate().skip(i + 1) {
            if !linked(one, other) || (one.column, one.row) == (other.column, other.row) {
                continue;
            }
            let corner = |third: &EdgePoint| linked(one, third) && [(other.column, one.row), (one.column, other.row)].contains(&(third.column, third.row));
            if one.column == other.column || one.row == other.row || !points.iter().any(corner) {
                let [dx, dy] = [0, 1].map(|axis| f64::from(other.position[axis]) - f64::from(one.position[axis]));
                length[i] += (dx * dx + dy * dy).sqrt() * spacing;
            }
            let (low, high) = (edge_of[i].min(edge_of[j]), edge_of[i].max(edge_of[j]));
            edge_of.iter_mut().filter(|edge| **edge == high).for_each(|edge| *edge = low);
        }
    }
    let mut edges = Vec::new();
    for root in 0..points.len() {
        let members: Vec<usize> = (0..points.len()).filter(|i| edge_of[*i] == root).collect();
        if members.len() >= 3 {
            let sum = |of: &dyn Fn(usize) -> f64| members.iter().map(|i| of(*i)).sum::<f64>();
            let count = members.len() as f64;
            edges.push(Edge {
                scale: sum(&|i| f64::from(points[i].scale)) / count,
                length: sum(&|i| length[i]),
                strength: sum(&|i| f64::from(points[i].strength)) / count,
                points: members.clone(),
            });
        }
    }
    edges
}

#[test]
fn links_are_those_of_all_pairs_to_the_bit() {
    let grid = hills(90, 70, 30.0, 80.0, 5);
    let points = detect(&grid.heights, 90, 70, 30.0);
    assert!(points.len() > 100, "{}", points.len());
    for linking in [Linking::Whole, Linking::Blocks(64), Linking::Blocks(16)] {
        let edges = link(&points, 30.0, linking);
        assert!(edges.len() > 5, "{}", edges.len());
        assert_eq!(edges, plain_link(&points, linking, 30.0, &|one, other| one.step().abs_diff(other.step()) <= 1));
    }
}

#[test]
fn a_step_is_one_edge_of_its_own_scale() {
    // A cliff that rises as the integral of a Gaussian of so many cells: Lindeberg's scale is that of the cliff.
    for wide in [1.3_f64, 2.0] {
        let (columns, rows) = (61, 50);
        let heights = (0..columns * rows).map(|cell| 50.0 * libm::erf(((cell % columns) as f64 - 30.2) / (wide * 2.0_f64.sqrt())) as f32).collect();
        let analysis = Analysis::new(SampleGrid { columns, rows, spacing: [10.0; 2], heights }, None);
        assert_eq!(analysis.edges.len(), 1, "{wide}");
        let edge = &analysis.edges[0];
        assert!((edge.length - 470.0).abs() < 1.0, "{edge:?}");
        assert!((edge.scale / (wide * 10.0) - 1.0).abs() < 0.1, "{wide}: {}", edge.scale);
        assert!(edge.points.iter().all(|i| (analysis.points[*i].position[0] - 30.2).abs() < 0.15));
    }
}

#[test]
fn plains_have_no_edges_and_their_own_slope() {
    let plain =
        SampleGrid { columns: 60, rows: 50, spacing: [10.0; 2], heights: (0..3000).map(|i| 3000.0 + 7.3 * (i % 60) as f32 - 2.1 * (i / 60) as f32).collect() };
    let analysis = Analysis::new(plain, None);
    assert!(analysis.edges.is_empty(), "{:?}", analysis.edges);
    for gradient in &analysis.gradient {
        assert!((gradient[0] - 0.73).abs() < 1e-4 && (gradient[1] - 0.21).abs() < 1e-4, "{gradient:?}");
    }
}

#[test]
fn windows_are_plain_means_and_ranges_to_the_bit() {
    let grid = hills(37, 29, 30.0, 300.0, 8);
    let analysis = Analysis::new(grid.clone(), None);
    for reach in [0, 1, 4, 8, 40] {
        let windows = Windows::new(&grid, &analysis.gradient, reach);
        for cell in 0..37 * 29 {
            let (column, row) = (cell % 37, cell / 37);
            let near = |i: &usize| (i % 37).abs_diff(column) <= reach && (i / 37).abs_diff(row) <= reach;
            let inside: Vec<usize> = (0..37 * 29).filter(near).collect();
            let step = 1_048_576.0;
            let mean = |of: &dyn Fn(usize) -> f32| {
                let sum: f64 = inside.iter().map(|i| (f64::from(of(*i)) * step).round()).sum();
                (sum / (inside.len() as f64 * step)) as f32
            };
            assert_eq!(windows.mean[cell], mean(&|i| grid.heights[i]));
            assert_eq!(windows.gradient[cell], [mean(&|i| analysis.gradient[i][0]), mean(&|i| analysis.gradient[i][1])]);
            let range = inside.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], i| [low.min(grid.heights[*i]), high.max(grid.heights[*i])]);
            assert_eq!(windows.range[cell], range);
        }
    }
}
