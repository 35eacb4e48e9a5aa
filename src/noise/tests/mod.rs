//! All fast forms against the definitions, bit for bit, and the filter against the mean.

pub(crate) mod reference;
mod spectrum;

use super::{Basis, Feature, Field, FieldShape, Isa, Metric};

const SHAPES: [FieldShape; 9] = [
    FieldShape::Single,
    FieldShape::Fbm { h: 1.0, lacunarity: 2.03, octaves: 6.4 },
    FieldShape::Ridged { h: 0.9, lacunarity: 2.1, octaves: 5.5, offset: 1.0, gain: 2.0 },
    FieldShape::Turbulence { octaves: 4.0, amplitude: 0.5, frequency: 2.0, hard: true },
    FieldShape::Turbulence { octaves: 3.5, amplitude: 0.6, frequency: 1.9, hard: false },
    FieldShape::Multifractal { h: 0.8, lacunarity: 1.9, octaves: 5.3 },
    FieldShape::Hetero { h: 1.0, lacunarity: 2.0, octaves: 5.0, offset: 0.7 },
    FieldShape::Hybrid { h: 0.5, lacunarity: 2.2, octaves: 5.6, offset: 0.7, gain: 1.5 },
    FieldShape::Spectral { beta: 2.0, octaves: 6.0 },
];

/// The bases whose noise has vectors of its own, and some of those that have not.
fn bases() -> impl Iterator<Item = Basis> {
    let voronoi = [(Feature::F1, Metric::Distance), (Feature::F2, Metric::Manhattan), (Feature::Crackle, Metric::Squared)];
    [Basis::OPerlin, Basis::IPerlin, Basis::Blender, Basis::CellNoise].into_iter().chain(voronoi.map(|(feature, metric)| Basis::Voronoi { feature, metric }))
}

/// Near and far origins with spacings from far below a cell to far above.
const PLACES: [(f64, f64); 8] = [(0.0, 0.0031), (-3.7, 0.11), (5.4e7, 0.013), (12.25, 0.6), (-1e9, 7.3), (0.0, 1e-9), (-0.5, 1.0 / 64.0), (1e15, 4.0)];

fn fields() -> impl Iterator<Item = (Field, f64, f64)> {
    let shapes = SHAPES.into_iter().flat_map(|shape| bases().map(move |basis| (shape, basis)));
    shapes.flat_map(|(shape, basis)| {
        PLACES
            .into_iter()
            .flat_map(move |(origin, spacing)| [Field::exact(shape, basis, 99), Field::banded(shape, basis, 99, spacing)].map(|field| (field, origin, spacing)))
    })
}

/// The same bits, or both not a number.
fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

#[test]
fn rows_equal_points_bit_for_bit() {
    for (field, origin, spacing) in fields() {
        let columns: Vec<f64> = (0..77).map(|i| origin + f64::from(i) * spacing).collect();
        for (start, count) in [(17, 60), (0, 77), (16, 32), (5, 1)] {
            let lines = [0, 1, 2, 9, 8, 7, 40].map(|j| origin * 0.5 - f64::from(j) * spacing);
            let expected: Vec<Vec<f32>> = lines.iter().map(|&v| columns[start..start + count].iter().map(|&u| field.at(u, v)).collect()).collect();
            for isa in Isa::ALL {
                let mut rows = field.rows_on(isa, &columns);
                let mut line = vec![0.0; count];
                for (&v, expected) in lines.iter().zip(&expected) {
                    rows.begin(v);
                    rows.fill(start, &mut line);
                    for ((&got, &want), u) in line.iter().zip(expected).zip(&columns[start..]) {
                        assert!(same(got, want), "{isa:?} {field:?} at {u} {v}: {got} is not {want}");
                    }
                }
            }
        }
    }
}

#[test]
fn general_positions_equal_points_bit_for_bit() {
    for (field, origin, spacing) in fields() {
        let us: Vec<f64> = (0..45).map(|i| origin + f64::from(i * 37 % 45) * spacing).collect();
        let vs: Vec<f64> = (0..45).map(|i| -0.3 * origin + f64::from(i * 19 % 45) * spacing).collect();
        check_points(&field, &us, &vs);
    }
}

/// Smooth lines of positions, whose vectors share cells or do not, in blocks and what is left of one, also where the words of cells' numbers change.
#[test]
fn warped_positions_equal_points_bit_for_bit() {
    const ORIGINS: [f64; 5] = [0.0, 4_294_967_291.0, -4_294_967_299.0, 68_719_476_731.0, 5e13];
    let gradient = [Basis::OPerlin, Basis::IPerlin, Basis::Blender];
    for (shape, basis) in [SHAPES[0], SHAPES[1], SHAPES[2]].into_iter().flat_map(|shape| gradient.map(|basis| (shape, basis))) {
        let field = Field::exact(shape, basis, 7);
        for (origin, wavelength) in ORIGINS.into_iter().flat_map(|origin| [300.0, 40.0, 9.0, 3.7, 0.9, 0.3].map(|wavelength| (origin, wavelength))) {
            let line = |i: f64| (i - 70.0 + 6.0 * (i / 40.0).sin(), 8.0 * (i / 31.0).cos());
            let positions = (0..300).map(|i| line(f64::from(i))).map(|(u, v)| (origin + u / wavelength, v / wavelength - origin));
            let (us, vs): (Vec<f64>, Vec<f64>) = positions.unzip();
            check_points(&field, &us, &vs);
            check_points(&field, &vs, &us);
        }
    }
}

#[test]
fn places_that_are_none_have_values_too() {
    const STRANGE: [f64; 14] = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e300,
        -1e300,
        -0.0,
        5e-324,
        -5e-324,
        1e15,
        -1e18,
        2_147_483_647.0,
        -2_147_483_649.0,
        4_294_967_295.5,
        1e-310,
    ];
    for shape in SHAPES {
        for basis in bases() {
            let field = Field::exact(shape, basis, 3);
            for &strange in &STRANGE {
                let us: Vec<f64> = (0..19).map(|i| if i % 3 == 0 { strange } else { f64::from(i) * 0.3 }).collect();
                let vs: Vec<f64> = (0..19).map(|i| if i % 2 == 0 { strange } else { -f64::from(i) }).collect();
                check_points(&field, &us, &vs);
                check_points(&field, &vec![strange; 300], &vec![0.5; 300]);
            }
        }
    }
}

fn check_points(field: &Field, us: &[f64], vs: &[f64]) {
    let expected: Vec<(f32, [f32; 2])> = us.iter().zip(vs).map(|(&u, &v)| (field.at(u, v), field.slopes_at(u, v))).collect();
    for isa in Isa::ALL {
        let (mut values, mut du, mut dv) = (vec![0.0; us.len()], vec![0.0; us.len()], vec![0.0; us.len()]);
        field.points(isa, us, vs, &mut values);
        field.slope_points(isa, us, vs, &mut du, &mut dv);
        for (i, &(value, slopes)) in expected.iter().enumerate() {
            let (u, v) = (us[i], vs[i]);
            assert!(same(values[i], value), "{isa:?} {field:?} at {u} {v}: {} is not {value}", values[i]);
            assert!(same(du[i], slopes[0]) && same(dv[i], slopes[1]), "{isa:?} {field:?} at {u} {v}: slopes {} {} are not {slopes:?}", du[i], dv[i]);
        }
    }
}

#[test]
fn gradient_noise_stays_in_its_range_and_uses_it() {
    for basis in [Basis::OPerlin, Basis::IPerlin, Basis::Blender] {
        let field = Field::exact(FieldShape::Single, basis, 5);
        let (mut low, mut high) = (0.0_f32, 0.0_f32);
        for i in 0..400_000 {
            let n = field.at(f64::from(i % 1000) * 0.171, f64::from(i / 1000) * 0.233);
            (low, high) = (low.min(n), high.max(n));
        }
        let [least, greatest] = basis.range();
        assert!(low >= least && high <= greatest && low < -0.85 && high > 0.85, "{basis:?}: {low} … {high}");
    }
}

#[test]
fn values_and_slopes_stay_within_their_bounds() {
    for (field, origin, spacing) in fields() {
        let ([low, high], steepest) = (field.range(), field.max_slope());
        for i in 0..200 {
            let (u, v) = (origin + spacing * 50.0 * reference::unit(2 * i), 0.3 * origin - spacing * 50.0 * reference::unit(2 * i + 1));
            let value = field.at(u, v);
            assert!(value >= low && value <= high, "{field:?} at {u} {v}: {value} is not within {low} … {high}");
            assert!(field.slopes_at(u, v).iter().all(|slope| slope.abs() <= steepest), "{field:?} at {u} {v}: {:?} and {steepest}", field.slopes_at(u, v));
        }
    }
}

#[test]
fn bounds_of_sums_are_tight_and_jumps_have_no_slope() {
    let shape = FieldShape::Fbm { h: 1.0, lacunarity: 2.0, octaves: 3.0 };
    let field = Field::exact(shape, Basis::IPerlin, 1);
    assert!((field.range()[1] - 1.75).abs() < 1e-5 && (field.range()[0] + 1.75).abs() < 1e-5, "{:?}", field.range());
    assert!((field.max_slope() - 3.0 * 2.7501).abs() < 1e-3, "{}", field.max_slope());
    assert_eq!(Field::exact(shape, Basis::CellNoise, 1).max_slope(), f32::INFINITY);
    assert!(Field::banded(shape, Basis::IPerlin, 1, 0.25).range()[1] < 1.2, "what is left out has no part in the bounds");
}

/// In band the filtered field's own slopes count, those of the means of what is left out too.
#[test]
fn slopes_of_filtered_fields_are_their_own() {
    const STEP: f64 = 1.0 / 1024.0;
    for shape in SHAPES {
        let field = Field::banded(shape, Basis::OPerlin, 99, 0.11);
        for i in 0..500 {
            let (u, v) = (9.0 * reference::unit(2 * i), 9.0 * reference::unit(2 * i + 1));
            let at = |step: f64| f64::from(field.at(u + step * STEP, v));
            let (left, right) = ((at(0.0) - at(-1.0)) / STEP, (at(1.0) - at(0.0)) / STEP);
            let got = f64::from(field.slopes_at(u, v)[0]);
            assert!((left - right).abs() > 0.1 || (got - f64::midpoint(left, right)).abs() < 0.1, "{shape:?} at {u} {v}: {got} is not {left} or {right}");
        }
    }
}

/// The mean must not move when detail is left out, or ridged land would sink on zooming out.
#[test]
fn the_mean_stays_from_level_to_level() {
    let voronoi = Basis::Voronoi { feature: Feature::F1, metric: Metric::Distance };
    let others = [Basis::IPerlin, Basis::Blender, Basis::CellNoise, voronoi].into_iter().flat_map(|basis| [1, 2, 7].map(|shape| (SHAPES[shape], basis)));
    for (shape, basis) in SHAPES.map(|shape| (shape, Basis::OPerlin)).into_iter().chain(others) {
        let means: Vec<f64> = (0..9).map(|level| mean_at(shape, basis, 0.02 * f64::from(1 << level))).collect();
        let [low, high] = Field::exact(shape, basis, 7).range();
        let amplitude = f64::from(high - low).min(2.0) / 2.0;
        for (level, pair) in means.windows(2).enumerate() {
            assert!((pair[1] - pair[0]).abs() < 0.01 * amplitude, "{shape:?} {basis:?}: mean {} becomes {} at level {level}", pair[0], pair[1]);
        }
    }
}

/// Mean of the field filtered to a spacing over 10⁶ samples that cover 1,400 cells a side, whatever the spacing.
fn mean_at(shape: FieldShape, basis: Basis, spacing: f64) -> f64 {
    let field = Field::banded(shape, basis, 7, spacing);
    let columns: Vec<f64> = (0..1000).map(|i| f64::from(i) * 1.4).collect();
    let mut rows = field.rows(&columns);
    let mut line = vec![0.0; columns.len()];
    let mut sum = 0.0;
    for &v in &columns {
        rows.begin(v);
        rows.fill(0, &mut line);
        sum += line.iter().map(|&n| f64::from(n)).sum::<f64>();
    }
    sum / (columns.len() * columns.len()) as f64
}
