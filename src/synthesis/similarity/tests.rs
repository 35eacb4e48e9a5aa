//! Similarities of real and made-up terrain.

use crate::synthesis::{
    tests::{hills, level, shared},
    *,
};

/// The quarters of the three ranges at 90 m, by type.
fn quarters() -> Option<Vec<Vec<Analysis>>> {
    let ranges = ["front-range-srtm3.asc", "jacksboro-srtm3.asc", "bijou-escarpment-30m.asc"];
    let quarters = |name: &str| {
        let grid = shared(name)?;
        Some(grid.quarters().map(|crop| Analysis::at(&grid.crop(crop).unwrap(), None, level(90.0)).unwrap()).to_vec())
    };
    ranges.into_iter().map(quarters).collect()
}

fn model(types: &[Vec<Analysis>]) -> Model {
    Model::new(&types.iter().map(|samples| samples.iter().collect()).collect::<Vec<Samples>>())
}

#[test]
fn quarters_of_ranges_are_told_apart() {
    let Some(types) = quarters() else { return };
    let mut right = 0;
    for number in 0..3 {
        for quarter in 0..4 {
            let mut rest = types.clone();
            let out = rest[number].remove(quarter);
            let nearest = model(&rest).nearest(&out.profile());
            right += usize::from(nearest[0].0 == number);
        }
    }
    assert!(right >= 10, "{right} of 12");
}

#[test]
fn a_mirror_changes_nothing_and_a_crop_little() {
    let Some(types) = quarters() else { return };
    let model = model(&types);
    for (number, name) in ["front-range-srtm3.asc", "jacksboro-srtm3.asc", "bijou-escarpment-30m.asc"].into_iter().enumerate() {
        let Some(whole) = shared(name) else { return };
        let similarity = |grid: &SampleGrid| model.similarity(number, &Analysis::at(grid, None, level(90.0)).unwrap().profile()).unwrap().value;
        let own = similarity(&whole);
        let mirror = (similarity(&whole.mirrored()) - own).abs();
        assert!(mirror <= 1e-6, "{name}: {mirror}");
        let (columns, rows) = (whole.columns * 9 / 10, whole.rows * 9 / 10);
        for (column, row) in [
            (0, 0),
            (whole.columns - columns, 0),
            (0, whole.rows - rows),
            (whole.columns - columns, whole.rows - rows),
            ((whole.columns - columns) / 2, (whole.rows - rows) / 2),
        ] {
            let part = similarity(&whole.crop(Crop { column, row, columns, rows }).unwrap());
            assert!((part - own).abs() <= 0.05, "{name}: {own}, from {column}, {row} {part}");
        }
    }
}

#[test]
fn a_stranger_among_samples_is_noticed() {
    let Some(types) = quarters() else { return };
    let profiles: Vec<Vec<Profile>> = types.iter().map(|samples| samples.iter().map(Analysis::profile).collect()).collect();
    let stranger = addition(&profiles, 2, &profiles[0][0]).unwrap();
    assert!(stranger.lost.len() >= 2, "{stranger:?}");
    assert!(stranger.trust[1] < stranger.trust[0]);
    // One of their own disturbs nothing.
    let mut rest = profiles.clone();
    let own = rest[1].remove(0);
    assert!(addition(&rest, 1, &own).unwrap().lost.is_empty());
}

#[test]
fn the_mean_height_is_not_seen_where_samples_differ_in_it() {
    let raised = |grid: &SampleGrid, metres: f32| {
        Analysis::new(SampleGrid { heights: grid.heights.iter().map(|height| height + metres).collect(), ..grid.clone() }, None)
    };
    let hill = |seed| hills(64, 64, 90.0, 50.0, seed);
    let types = [
        vec![raised(&hill(1), 0.0), raised(&hill(2), 1000.0), raised(&hill(3), 2000.0)],
        vec![raised(&hills(64, 64, 90.0, 5.0, 4), 900.0), raised(&hills(64, 64, 90.0, 6.0, 5), 1100.0)],
    ];
    let model = model(&types);
    assert!(model.types[0].agreements[0][0] < 0.01, "{:?}", model.types[0].agreements);
    let at = |metres: f32| model.similarity(0, &raised(&hill(6), metres).profile()).unwrap();
    let (low, high) = (at(0.0), at(1600.0));
    assert!((low.value - high.value).abs() < 1e-3, "{} {}", low.value, high.value);
    // The other type's samples agree in it.
    let other = |metres: f32| model.similarity(1, &raised(&hills(64, 64, 90.0, 5.5, 7), metres).profile()).unwrap().value;
    assert!(other(1000.0) > other(2600.0) + 0.02, "{} {}", other(1000.0), other(2600.0));
}

#[test]
fn own_samples_reach_nine_tenths_and_weights_are_one() {
    let types = [
        [1, 2, 3].map(|seed| Analysis::new(hills(64, 48, 90.0, 50.0, seed), None)).to_vec(),
        [4, 5].map(|seed| Analysis::new(hills(64, 64, 90.0, 9.0, seed), None)).to_vec(),
    ];
    let model = model(&types);
    for (number, samples) in types.iter().enumerate() {
        for sample in samples {
            let similarity = model.similarity(number, &sample.profile()).unwrap();
            assert!((0.9 - 1e-12..=1.0).contains(&similarity.value), "{}", similarity.value);
            assert!((similarity.parts.iter().map(|part| part.weight).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(similarity.parts.iter().all(|part| (part.statistics.iter().map(|part| part.weight).sum::<f64>() - 1.0).abs() < 1e-12));
            assert!(similarity.trust > 0.1, "{}", similarity.trust);
            let other = model.similarity(1 - number, &sample.profile()).unwrap();
            assert!(other.value < similarity.value);
            assert!(serde_json::to_value(&similarity).unwrap()["parts"][2]["measure"] == "edge-scale");
        }
    }
    assert_eq!(model.similarity(2, &types[0][0].profile()), None);
}

#[test]
fn one_sample_takes_the_tolerance_of_others_or_of_its_quarters() {
    let analysis = |relief: f32, seed| Analysis::new(hills(64, 64, 90.0, relief, seed), None);
    let types = [vec![analysis(50.0, 1), analysis(50.0, 2), analysis(50.0, 3)], vec![analysis(9.0, 4)], vec![analysis(5.0, 5), analysis(5.0, 6)]];
    let known = model(&types).types;
    let sigma = |number: usize| known[number].projections[1][0].sigma;
    assert_eq!(sigma(1), f64::midpoint(sigma(0), sigma(2)));
    let alone = model(&[vec![analysis(50.0, 1)]]);
    let similarity = alone.similarity(0, &analysis(50.0, 2).profile()).unwrap();
    assert_eq!(similarity.trust, 0.0, "nothing to compare the sample's spread with");
    assert!(similarity.parts.iter().all(|part| part.weight == 0.2 && part.statistics.iter().all(|part| part.weight == 0.25)));
    assert!(similarity.value > alone.similarity(0, &analysis(5.0, 2).profile()).unwrap().value);
    let quarter = Analysis::new(hills(64, 64, 90.0, 50.0, 1), None);
    for crop in quarter.grid.quarters() {
        let part = alone.similarity(0, &quarter.profile_of(crop)).unwrap();
        assert!(part.value >= 0.9 - 1e-12, "{}", part.value);
    }
}

#[test]
fn regions_of_any_shape_are_compared() {
    let of = |relief: f32, seeds: [u64; 4]| seeds.map(|seed| Analysis::new(hills(96, 96, 90.0, relief, seed), None)).to_vec();
    let model = model(&[of(50.0, [1, 2, 3, 4]), of(9.0, [5, 6, 7, 8])]);
    // A ring, and what is inside and outside of it.
    let ring = |cell: usize| (900..1800).contains(&((cell % 96).abs_diff(48).pow(2) + (cell / 96).abs_diff(48).pow(2)));
    for (relief, own) in [(50.0, 0), (9.0, 1)] {
        let terrain = Analysis::new(hills(96, 96, 90.0, relief, 31), None);
        assert_eq!(model.nearest(&region_profile(&terrain, ring))[0].0, own);
        assert_eq!(model.nearest(&region_profile(&terrain, |cell| !ring(cell)))[0].0, own);
        assert_eq!(region_profile(&terrain, |_| true), terrain.profile());
    }
    let terrain = Analysis::new(hills(96, 96, 90.0, 9.0, 31), None);
    let nothing = region_profile(&terrain, |_| false);
    assert_eq!(nothing.0[0].count, 0);
    assert_eq!(model.similarity(0, &nothing).unwrap().value, 0.0);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    use rayon::prelude::*;
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (0..6_u64).into_par_iter().map(|seed| Analysis::at(&hills(120, 100, 10.0, 50.0, seed), None, level(30.0)).unwrap()).collect::<Vec<_>>())
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one, three);
    let model = model(&[one[..3].to_vec(), one[3..].to_vec()]);
    assert_eq!(model, self::model(&[three[..3].to_vec(), three[3..].to_vec()]));
}
