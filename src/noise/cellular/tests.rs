use super::{
    nearest::{insert, point},
    *,
};
use crate::noise::{
    Basis, Field, FieldShape, Isa,
    cells::Lattice,
    hash,
    metric::{Measure, Measured},
};

const METRICS: [Metric; 12] = [
    Metric::Distance,
    Metric::Squared,
    Metric::Manhattan,
    Metric::Chebychev,
    Metric::Minkowski { exponent: 0.5 },
    Metric::Minkowski { exponent: 0.7 },
    Metric::Minkowski { exponent: 1.0 },
    Metric::Minkowski { exponent: 2.0 },
    Metric::Minkowski { exponent: 2.5 },
    Metric::Minkowski { exponent: 3.0 },
    Metric::Minkowski { exponent: 4.0 },
    Metric::Minkowski { exponent: 40.0 },
];

fn pairs() -> impl Iterator<Item = (Metric, Feature)> {
    METRICS.into_iter().flat_map(|metric| Feature::ALL.map(|feature| (metric, feature)))
}

/// The four least distances among all points within nine cells, the plain way.
fn brute_force(metric: Metric, lattice: &Lattice, u: f64, v: f64) -> [f32; 4] {
    struct All<'a>(&'a Lattice, f64, f64);
    impl Measured for All<'_> {
        type Output = [f32; 4];

        fn run<M: Measure>(self, measure: M) -> [f32; 4] {
            let (column, row) = (self.0.locate(0, self.1), self.0.locate(1, self.2));
            let mut near = [f32::INFINITY; 4];
            for b in -9..=9_i64 {
                for a in -9..=9_i64 {
                    let hash = hash::corner(hash::column_key(column.cell + a), hash::row_key(row.cell + b, self.0.seed));
                    let [px, py] = point(hash, a as f32, b as f32);
                    let (dx, dy) = (px - column.fraction as f32, py - row.fraction as f32);
                    insert(&mut near, measure.join(measure.axis(dx), measure.axis(dy)));
                }
            }
            near.map(|near| measure.distance(near))
        }
    }
    metric.measured(All(lattice, u, v))
}

#[test]
fn distances_are_those_of_the_whole_plane() {
    let lattice = Lattice::new(11, 0, 1.0);
    for metric in METRICS {
        for i in 0..4_000 {
            let (u, v) = (f64::from(i % 67) * 0.371 - 20.0, f64::from(i / 67) * 0.313 - 20.0);
            let [f1, f2, f3, f4] = brute_force(metric, &lattice, u, v);
            let want = [f1, f2, f3, f4, f2 - f1, (10.0 * (f2 - f1)).min(1.0)];
            let got = Feature::ALL.map(|feature| feature_at(metric, feature, &lattice, 0.0, u, v));
            assert_eq!(got, want, "{metric:?} at {u} {v}");
        }
    }
}

fn assert_same(got: f32, want: f32, what: impl Fn() -> String) {
    assert!(got.to_bits() == want.to_bits() || got.is_nan() && want.is_nan(), "{}: {got} is not {want}", what());
}

/// Rows, points and the definition agree to the bit: cells of many samples and of less than one, near and far, on every instruction set.
#[test]
fn rows_and_points_equal_the_definition() {
    let far = 1_099_511_627_776.0;
    for (origin, spacing) in [(0.0, 0.0031), (-3.7, 0.11), (12.25, 0.6), (-1e9, 7.3), (0.0, 1e-9), (far, 0.013), (-far * 64.0, 0.25), (3.0, 1e12)] {
        for (index, (metric, feature)) in pairs().enumerate() {
            for isa in Isa::ALL {
                let extent = [0.0, 0.3, 0.001][index % 3];
                let query = Query { isa, metric, feature, lattice: Lattice::new(index as u64, 3, 1.0), extent };
                check_query(&query, origin, spacing);
            }
        }
    }
}

fn check_query(query: &Query, origin: f64, spacing: f64) {
    let columns: Vec<f64> = (0..203).map(|i| origin + f64::from(i) * spacing).collect();
    let mut rows = DistanceRows::new(*query, &columns);
    for (j, (start, count)) in [(0, (0, 203)), (1, (17, 60)), (2, (202, 1)), (40, (3, 129))] {
        let v = origin * 0.5 - f64::from(j) * spacing;
        let (mut line, mut points) = (vec![0.0; count], vec![0.0; count]);
        rows.begin(v);
        rows.fill(start, &mut line);
        feature_points(query, &columns[start..start + count], &vec![v; count], &mut points);
        for ((&line, &point), &u) in line.iter().zip(&points).zip(&columns[start..]) {
            let want = feature_at(query.metric, query.feature, &query.lattice, query.extent, u, v);
            let at = || format!("{:?} {:?} {:?} at {u} {v}", query.isa, query.metric, query.feature);
            assert_same(line, want, || format!("row, {}", at()));
            assert_same(point, want, || format!("point, {}", at()));
        }
    }
}

#[test]
fn values_of_rows_and_points_equal_the_definition() {
    let far = 1_099_511_627_776.0;
    for (origin, spacing) in [(0.0, 0.0031), (-3.7, 0.11), (12.25, 0.6), (-1e9, 7.3), (far, 0.013), (3.0, 1e12)] {
        for (extent, isa) in [0.0, 1e-5, 0.3, 0.9, 4.0].into_iter().flat_map(|extent| Isa::ALL.map(|isa| (extent, isa))) {
            let values = Values::new(Lattice::new(5, 1, 1.0), extent);
            let columns: Vec<f64> = (0..203).map(|i| origin + f64::from(i) * spacing).collect();
            let mut rows = ValueRows::new(isa, values, &columns);
            for (j, (start, count)) in [(0, (0, 203)), (1, (17, 60)), (40, (3, 129))] {
                let v = origin * 0.5 - f64::from(j) * spacing;
                let (mut line, mut points) = (vec![0.0; count], vec![0.0; count]);
                rows.begin(v);
                rows.fill(start, &mut line);
                value_points(isa, &values, &columns[start..start + count], &vec![v; count], &mut points);
                for ((&line, &point), &u) in line.iter().zip(&points).zip(&columns[start..]) {
                    assert_same(line, values.at(u, v), || format!("row, {isa:?} {extent} at {u} {v}"));
                    assert_same(point, values.at(u, v), || format!("point, {isa:?} {extent} at {u} {v}"));
                }
            }
        }
    }
}

/// Coordinates that are not numbers or beyond all cells have some value, found in a time that ends, and the same in every form.
#[test]
fn strange_coordinates_do_no_harm() {
    let strange = [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 9.3e18, f64::MIN_POSITIVE, -0.0];
    let (us, vs): (Vec<f64>, Vec<f64>) = strange.into_iter().flat_map(|u| strange.map(|v| (u, v))).unzip();
    let lattice = Lattice::new(1, 0, 1.0);
    let mut out = vec![0.0; us.len()];
    for (metric, feature) in pairs() {
        for isa in Isa::ALL {
            let query = Query { isa, metric, feature, lattice, extent: 0.2 };
            feature_points(&query, &us, &vs, &mut out);
            for ((&got, &u), &v) in out.iter().zip(&us).zip(&vs) {
                assert_same(got, feature_at(metric, feature, &lattice, 0.2, u, v), || format!("{isa:?} {metric:?} {feature:?} at {u} {v}"));
            }
            let mut rows = DistanceRows::new(query, &[f64::NEG_INFINITY, -1e300, 0.0, 1e300, f64::INFINITY, f64::NAN]);
            for v in strange {
                rows.begin(v);
                rows.fill(0, &mut out[..6]);
            }
        }
    }
    let values = Values::new(lattice, 0.3);
    value_points(Isa::Baseline, &values, &us, &vs, &mut out);
    for ((&got, &u), &v) in out.iter().zip(&us).zip(&vs) {
        assert_same(got, values.at(u, v), || format!("at {u} {v}"));
    }
}

/// Cells whose numbers differ only beyond 32 bits are different cells.
#[test]
fn far_cells_are_their_own() {
    let lattice = Lattice::new(1, 0, 1.0);
    let far = 4_294_967_296.0;
    let at = |u: f64, v: f64| (Values::new(lattice, 0.0).at(u, v), feature_at(Metric::Distance, Feature::F1, &lattice, 0.0, u, v));
    let here = at(0.25, 0.5);
    for (u, v) in [(far, 0.0), (0.0, far), (256.0 * far, 0.0), (0.0, -256.0 * far)] {
        let there = at(u + 0.25, v + 0.5);
        assert!(here.0 != there.0 && here.1 != there.1, "{u} {v}");
    }
}

#[test]
fn values_stay_within_range_and_slope() {
    let lattice = Lattice::new(3, 0, 1.0);
    let step = 1.0 / 4_096.0;
    for (metric, feature) in pairs() {
        let ([low, high], slope) = (feature.range(metric), feature.slope(metric));
        let mut greatest = 0.0_f32;
        for i in 0..3_000 {
            let (u, v) = (f64::from(i) * 0.717, f64::from(i % 59) * 0.431);
            let at = |u: f64, v: f64| feature_at(metric, feature, &lattice, 0.0, u, v);
            let here = at(u, v);
            greatest = greatest.max(here);
            assert!(low <= here && here <= high, "{metric:?} {feature:?} at {u} {v}: {here} is not in {low} … {high}");
            let turn = (at(u + step, v) - here).abs().max((at(u, v + step) - here).abs()) / step as f32;
            assert!(turn <= slope * 1.000_1 + 0.01, "{metric:?} {feature:?} at {u} {v}: turns by {turn}, not {slope}");
        }
        assert!(greatest > 0.4 * high, "{metric:?} {feature:?}: of {high} only {greatest} is used");
    }
}

/// Bounds of the distances, by search: no arrangement of points puts the k-th farther than the range says.
#[test]
fn ranges_hold_for_the_farthest_points() {
    for metric in METRICS {
        for i in 0..=32_i16 {
            for j in 0..=32_i16 {
                let [x, y] = [f32::from(i) / 64.0, f32::from(j) / 64.0];
                let farthest = |cell: i16, at: f32| (f32::from(cell) - at).abs().max((f32::from(cell + 1) - at).abs());
                let mut all: Vec<f32> =
                    (-2..=2).flat_map(|a| (-2..=2).map(move |b| (a, b))).map(|(a, b)| metric.length(farthest(a, x), farthest(b, y))).collect();
                all.sort_by(f32::total_cmp);
                for (feature, far) in [Feature::F1, Feature::F2, Feature::F3, Feature::F4].into_iter().zip(all) {
                    assert!(far <= feature.range(metric)[1], "{metric:?} {feature:?} at {x} {y}: {far}");
                }
            }
        }
    }
}

fn cellular_bases() -> impl Iterator<Item = Basis> {
    let voronoi = pairs().filter(|(metric, _)| METRICS[..6].contains(metric)).map(|(metric, feature)| Basis::Voronoi { feature, metric });
    voronoi.chain([Basis::CellNoise])
}

/// A field on a square of samples, from row to row.
fn window(field: &Field, side: u32, at: impl Fn(f64) -> f64) -> Vec<f32> {
    let coordinates: Vec<f64> = (0..side).map(|i| at(f64::from(i))).collect();
    let mut rows = field.rows(&coordinates);
    let mut all = vec![0.0; coordinates.len() * coordinates.len()];
    for (line, &v) in all.chunks_mut(coordinates.len()).zip(&coordinates) {
        rows.begin(v);
        rows.fill(0, line);
    }
    all
}

/// The mean of what is left when a spacing cannot carry all is that of the whole, for single noises and sums of them.
#[test]
fn means_stay_from_level_to_level() {
    for basis in cellular_bases() {
        let [_, high] = match basis {
            Basis::Voronoi { feature, metric } => feature.range(metric),
            _ => [0.0, 1.0],
        };
        let fbm = FieldShape::Fbm { h: 1.0, lacunarity: 2.0, octaves: 2.4 };
        let shapes = if matches!(basis, Basis::CellNoise | Basis::Voronoi { metric: Metric::Distance, .. }) {
            &[FieldShape::Single, fbm][..]
        } else {
            &[FieldShape::Single]
        };
        for &shape in shapes {
            let mean = |spacing: f64| {
                let all = window(&Field::banded(shape, basis, 7, spacing), 300, |i| i * 1.4);
                all.iter().map(|&n| f64::from(n)).sum::<f64>() / all.len() as f64
            };
            let means = [0.08, 0.16, 0.32, 0.64, 1.28].map(mean);
            for pair in means.windows(2) {
                assert!((pair[1] - pair[0]).abs() < 0.01 * f64::from(high), "{shape:?} {basis:?}: {} becomes {}", pair[0], pair[1]);
            }
        }
    }
}

/// What a level shows and what its finer one shows reduced come much nearer to each other with the edges made fit than with sharp ones.
#[test]
fn edges_fit_for_the_spacing_alias_less() {
    let crease = |feature: Feature| Basis::Voronoi { feature, metric: Metric::Distance };
    for (basis, at_most) in [(crease(Feature::Crackle), 0.5), (crease(Feature::F2F1), 0.8), (Basis::CellNoise, 0.2)] {
        for spacing in [0.0625, 0.125, 0.25] {
            let difference = |make: &dyn Fn(f64) -> Field| {
                let parent = window(&make(spacing), 200, |i| (i + 0.5) * spacing);
                let child = window(&make(spacing / 2.0), 400, |i| (i + 0.5) * spacing / 2.0);
                let reduced = |i: usize| {
                    let (x, y) = (i % 200, i / 200);
                    [0, 1, 400, 401].map(|k| child[2 * y * 400 + 2 * x + k]).iter().sum::<f32>() / 4.0
                };
                (parent.iter().enumerate().map(|(i, n)| f64::from(n - reduced(i)).powi(2)).sum::<f64>() / parent.len() as f64).sqrt()
            };
            let exact = difference(&|_| Field::exact(FieldShape::Single, basis, 3));
            let banded = difference(&|spacing| Field::banded(FieldShape::Single, basis, 3, spacing));
            assert!(banded < at_most * exact, "{basis:?} at {spacing}: {banded} in band, {exact} as it is");
        }
    }
}
