//! Valleys against their definition.

use super::{
    network::{Site, find_link},
    *,
};
use crate::noise::{Basis, Field, FieldShape};
use std::collections::BTreeMap;

struct Flat;

impl Terrain for Flat {
    fn heights(&mut self, _: &[f64], _: &[f64], out: &mut [f32]) {
        out.fill(0.25);
    }
}

/// Where a link leads, and how it turns.
type Target = ([f32; 3], f32);

struct Ground(Field);

impl Terrain for Ground {
    fn heights(&mut self, us: &[f64], vs: &[f64], out: &mut [f32]) {
        self.0.points(Isa::Baseline, us, vs, out);
    }
}

fn ground() -> Ground {
    Ground(Field::exact(FieldShape::Fbm { h: 1.0, lacunarity: 2.0, octaves: 5.0 }, Basis::OPerlin, 7))
}

const EROSION: Erosion = Erosion { strength: 1.0, scale: 0.4, octaves: 3.0, depth: 0.7 };

fn networks(isa: Isa) -> Networks {
    Networks::new(isa, &EROSION, 5)
}

fn whole(erosion: &Erosion) -> Valleys {
    Valleys::new(erosion, Fading::NONE, &Stead::NONE)
}

fn eroded(networks: &mut Networks, valleys: &mut Valleys, us: &[f64], vs: &[f64]) -> Vec<f32> {
    let mut ground = ground();
    let mut heights = vec![0.0; us.len()];
    ground.heights(us, vs, &mut heights);
    valleys.carve(networks, &mut ground, us, vs, &mut heights, 0);
    heights
}

/// A grid of places of some side and spacing around a place.
fn places(around: f64, spacing: f64) -> (Vec<f64>, Vec<f64>) {
    let at = |i: i32| around + f64::from(i) * spacing;
    ((0..900).map(|i| at(i % 30)).collect(), (0..900).map(|i| at(i / 30)).collect())
}

/// Whatever was asked before, in whatever order and on whatever instruction set.
#[test]
fn a_place_has_one_height() {
    for (around, spacing) in [(0.3, 0.004), (-5.0, 0.31), (3e7, 0.02), (1e12, 1e9)] {
        let (us, vs) = places(around, spacing);
        let mut valleys = whole(&EROSION);
        let all = eroded(&mut networks(Isa::Baseline), &mut valleys, &us, &vs);
        for isa in Isa::ALL {
            let mut networks = networks(isa);
            let (back_us, back_vs): (Vec<f64>, Vec<f64>) = (us.iter().rev().copied().collect(), vs.iter().rev().copied().collect());
            let back = eroded(&mut networks, &mut valleys, &back_us, &back_vs);
            assert!(back.iter().rev().zip(&all).all(|(a, b)| a.to_bits() == b.to_bits()), "{isa:?} {around} {spacing}");
            for i in (0..us.len()).step_by(97) {
                let alone = eroded(&mut networks, &mut valleys, &us[i..=i], &vs[i..=i]);
                assert_eq!(alone[0].to_bits(), all[i].to_bits(), "{isa:?} at {} {}", us[i], vs[i]);
            }
        }
    }
}

/// The definition written out: every link of every cell near enough, none left out for being far.
#[test]
fn valleys_are_those_of_every_link_around() {
    let (us, vs) = places(0.7, 0.021);
    let erosion = Erosion { octaves: 1.0, ..EROSION };
    let got = eroded(&mut Networks::new(Isa::active(), &erosion, 5), &mut whole(&erosion), &us, &vs);
    let (pitch, cut) = erosion.level(0);
    let level = Level::new(5, 0, pitch, cut as f32);
    let mut ground = ground();
    let site = |i: i64, j: i64, ground: &mut Ground| {
        let all = (0..CANDIDATES).map(|candidate| {
            let [x, y] = level.place([i, j], candidate);
            let mut z = [0.0];
            ground.heights(&[(i as f64 + f64::from(x)) * pitch], &[(j as f64 + f64::from(y)) * pitch], &mut z);
            Site { x: i as f32 + x, y: j as f32 + y, z: z[0] }
        });
        all.reduce(|lowest, other| if other.z < lowest.z { other } else { lowest }).expect("four")
    };
    let sites: BTreeMap<[i64; 2], Site> = (-16..24).flat_map(|j| (-16..24).map(move |i| [i, j])).map(|[i, j]| ([i, j], site(i, j, &mut ground))).collect();
    let links: Vec<(Site, [f32; 2], Option<Target>)> = (-11..19)
        .flat_map(|j| (-11..19).map(move |i| [i, j]))
        .map(|[i, j]| {
            let within = |a: i64, b: i64| {
                let Site { x, y, z } = sites[&[a, b]];
                Site { x: x - a as f32, y: y - b as f32, z }
            };
            let found = find_link(&within, REACH, [i, j]).map(|(_, to)| (to, level.turn([i, j])));
            (sites[&[i, j]], [i as f32 + 0.5, j as f32 + 0.5], found)
        })
        .collect();
    for ((&u, &v), got) in us.iter().zip(&vs).zip(got) {
        let (x, y) = ((u / pitch) as f32, (v / pitch) as f32);
        let (mut sum, mut weights, mut height) = (0.0, 0.0, [0.0]);
        ground.heights(&[u], &[v], &mut height);
        for (site, [cell_x, cell_y], found) in &links {
            // The 4 × 4 cells around the nearest corner.
            if (cell_x - (x + 0.5).floor()).abs() < 2.0 && (cell_y - (y + 0.5).floor()).abs() < 2.0 {
                let square = |dx: f32, dy: f32| dx * dx + dy * dy;
                let near = (1.0 - square(x - site.x, y - site.y) / KERNEL).max(0.0);
                let slope = found.map_or(0.0, |([ex, ey, ez], _)| -ez / square(ex, ey).sqrt());
                (sum, weights) = (sum + near * near * slope, weights + near * near);
            }
        }
        let mut lowest = height[0];
        for (site, _, found) in &links {
            let Some(([ex, ey, ez], turn)) = found else { continue };
            let square = ex * ex + ey * ey;
            let t = (((x - site.x) * ex + (y - site.y) * ey) / square).clamp(0.0, 1.0);
            let bow = 4.0 * BEND * turn / square.sqrt() * t * (1.0 - t);
            let (dx, dy) = (x - site.x - t * ex + bow * ey, y - site.y - t * ey - bow * ex);
            let weight = (1.0 - (dx * dx + dy * dy).sqrt() / HALF_WIDTH).max(0.0);
            lowest = lowest.min(height[0] - weight * (height[0] - (site.z + t * ez - cut as f32 * (sum / weights))).max(0.0));
        }
        assert!((lowest - got).abs() < 2e-5, "{u} {v}: {got} is not {lowest}");
    }
}

/// Networks that an erosion with more lattices has used serve one with fewer, and one with a part of a lattice.
#[test]
fn erosions_share_networks() {
    let (us, vs) = places(0.7, 0.021);
    let mut shared = networks(Isa::active());
    for octaves in [3.0, 1.0, 1.5, 2.0, 2.25, 3.0] {
        let erosion = Erosion { octaves, strength: 0.5 + octaves / 10.0, ..EROSION };
        let alone = eroded(&mut Networks::new(Isa::active(), &erosion, 5), &mut whole(&erosion), &us, &vs);
        let got = eroded(&mut shared, &mut whole(&erosion), &us, &vs);
        assert!(erosion.shares_networks(&EROSION) && got.iter().zip(&alone).all(|(a, b)| a.to_bits() == b.to_bits()), "{octaves}");
    }
}

/// Valleys lower the land; nowhere more than the range allows.
#[test]
fn erosion_only_lowers_and_flat_land_stays() {
    let (us, vs) = places(0.0, 0.05);
    let mut before = vec![0.0; us.len()];
    ground().heights(&us, &vs, &mut before);
    let after = eroded(&mut networks(Isa::active()), &mut whole(&EROSION), &us, &vs);
    let [low, high] = ground().0.range();
    assert!(before.iter().zip(&after).all(|(before, after)| after <= before));
    assert!(after.iter().all(|&height| height >= low - (high - low) * EROSION.greatest_cut() as f32));
    let mut flat = vec![0.25; us.len()];
    whole(&EROSION).carve(&mut networks(Isa::active()), &mut Flat, &us, &vs, &mut flat, 0);
    assert!(flat.iter().all(|&height| height == 0.25));
}

/// The mean over an area moves by less than a hundredth of the amplitude from level to level.
#[test]
fn the_mean_stays_as_lattices_fade() {
    let side = 160;
    let at = |i: usize| i as f64 * 0.05;
    let (us, vs): (Vec<f64>, Vec<f64>) = (0..side * side).map(|i| (at(i % side), at(i / side))).unzip();
    let mut networks = networks(Isa::active());
    let mean_slope = networks.mean_slope(&mut ground());
    let mut mean = |spacing: f64, gradual: bool| {
        let mut valleys = Valleys::new(&EROSION, Fading { spacing, gradual }, &Stead { mean_slope, ..Stead::NONE });
        let heights = eroded(&mut networks, &mut valleys, &us, &vs);
        heights.iter().map(|&h| f64::from(h)).sum::<f64>() / heights.len() as f64
    };
    let [low, high] = ground().0.range();
    let amplitude = f64::from(high - low) / 2.0;
    for gradual in [false, true] {
        let means = [0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32].map(|spacing| mean(spacing, gradual));
        assert!(means.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.008 * amplitude), "{gradual}: {means:?}");
    }
}

/// What stands for valleys swings around its mean, never lower than the floor and never up.
#[test]
fn what_stands_for_valleys_swings_and_keeps_its_floor() {
    let swings = Stead::swings(0);
    assert!((swings.iter().sum::<f32>() / 16.0 - 1.0).abs() < 1e-3);
    let lowered = |floor: f32| {
        let stead = Stead { mean_slope: 0.5, floor, swings: Some(swings) };
        let (us, vs, mut heights) = ([0.0; 4], [0.0; 4], [1.0; 4]);
        Valleys::new(&EROSION, Fading { spacing: 10.0, gradual: false }, &stead).carve(&mut networks(Isa::active()), &mut Flat, &us, &vs, &mut heights, 4);
        heights
    };
    let free = lowered(f32::MIN);
    let ratio = (1.0 - free[1]) / (1.0 - free[2]);
    assert!(free.iter().all(|&height| height < 1.0) && (ratio * swings[6] / swings[5] - 1.0).abs() < 1e-3, "{free:?}");
    assert!(lowered(0.99).iter().zip(free).all(|(&height, free)| height == free.max(0.99)));
    assert_eq!(lowered(2.0), [1.0; 4]);
}

/// Writes [`MEAN_CUTS`]: `cargo test --release --lib the_mean_cuts -- --ignored --nocapture`.
#[test]
#[ignore = "writes the table"]
#[expect(clippy::print_stdout, reason = "writes the table")]
fn the_mean_cuts() {
    for (h, octaves) in [(1.0, 3.0), (1.0, 8.0), (0.9, 5.0)] {
        let mut table = [[[0.0_f64; 2]; MAX_LEVELS]; MAX_LEVELS];
        for seed in 0..4 {
            let mut ground = Ground(Field::exact(FieldShape::Fbm { h, lacunarity: 2.05, octaves }, Basis::OPerlin, seed));
            for (which, depth) in [0.3, 0.8].into_iter().enumerate() {
                let erosion = Erosion { strength: 1.0, scale: 0.4, octaves: 5.0, depth };
                let found = mean_cuts(&erosion, seed, &mut ground);
                (0..MAX_LEVELS).for_each(|k| (0..=k).for_each(|by| table[k][by][which] += found[k][by] / 4.0));
            }
        }
        println!("H {h}, {octaves} octaves");
        for (k, row) in table.iter().enumerate() {
            let fit = |&[low, high]: &[f64; 2]| {
                let rise = (high - low) / 0.5;
                format!("[{:.3}, {:.3}]", low - 0.3 * rise, rise)
            };
            println!("    {}", row[..=k].iter().map(fit).collect::<Vec<_>>().join(", "));
        }
    }
}

/// What each lattice lowers the terrain by, in its pitches, where the network of each coarser one has slope 1.
fn mean_cuts(erosion: &Erosion, key: u64, ground: &mut Ground) -> [[f64; MAX_LEVELS]; MAX_LEVELS] {
    let side = 96;
    let at = |i: usize| i as f64 * 0.083_7 - 4.0;
    let (us, vs): (Vec<f64>, Vec<f64>) = (0..side * side).map(|i| (at(i % side), at(i / side))).unzip();
    let mean = |heights: &[f32]| heights.iter().map(|&h| f64::from(h)).sum::<f64>() / heights.len() as f64;
    let mut heights = vec![0.0; us.len()];
    ground.heights(&us, &vs, &mut heights);
    let mut networks = Networks::new(Isa::active(), erosion, key);
    let (mut cuts, mut slopes) = ([0.0; MAX_LEVELS], [0.0; MAX_LEVELS]);
    for number in 0..MAX_LEVELS {
        let (before, pitch) = (heights.clone(), networks.levels[number].pitch);
        let mut slope = vec![0.0; us.len()];
        carve(Isa::active(), &mut networks.levels[..=number], ground, &us, &vs, [&mut heights, &mut slope], [1.0, 1.0]);
        (cuts[number], slopes[number]) = ((mean(&before) - mean(&heights)) / pitch, mean(&slope) / pitch);
    }
    core::array::from_fn(|k| core::array::from_fn(|by| cuts[k] / slopes[by]))
}
