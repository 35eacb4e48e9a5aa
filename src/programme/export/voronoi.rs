//! Voronoi noises as functions of a shader.
//!
//! The server looks at rings of cells until no nearer point can exist; a shader looks at a fixed square of cells, so large that it never misses one: distances
//! are the true ones of the plane there too.

use super::number;
use crate::noise::{Feature, Metric};

/// Places a side of half a cell at which [`rings`] looks.
const PLACES: i32 = 16;

fn order(feature: Feature) -> usize {
    match feature {
        Feature::F1 => 1,
        Feature::F2 | Feature::F2F1 | Feature::Crackle => 2,
        Feature::F3 => 3,
        Feature::F4 => 4,
    }
}

/// A measure that grows with the distance.
fn measure(metric: Metric, x: f64, y: f64) -> f64 {
    match metric {
        Metric::Manhattan => x + y,
        Metric::Chebychev => x.max(y),
        Metric::Minkowski { exponent } => libm::pow(libm::pow(x, exponent.into()) + libm::pow(y, exponent.into()), 1.0 / f64::from(exponent)),
        Metric::Distance | Metric::Squared => (x * x + y * y).sqrt(),
    }
}

/// The rings of cells around a place's own that surely hold its nearest points.
///
/// Beyond r rings every point is further than r + m, m the distance to the nearest side of the own cell; and every cell has a point, no further than the cell's
/// furthest corner. So r rings are enough where the order-th of those corner distances is at most r + m, everywhere in the cell: by symmetry, in a quarter of it.
fn rings(metric: Metric, order: usize) -> i32 {
    let enough = |rings: i32, x: f64, y: f64| {
        let furthest = |cell: i32, at: f64| (f64::from(cell) - at).abs().max((f64::from(cell + 1) - at).abs());
        let mut bounds: Vec<f64> = (-2..=2).flat_map(|j| (-2..=2).map(move |i| measure(metric, furthest(i, x), furthest(j, y)))).collect();
        bounds.sort_by(f64::total_cmp);
        bounds[order - 1] <= f64::from(rings) + x.min(y) + 1e-9
    };
    let places = || (0..=PLACES).map(|i| f64::from(i) / f64::from(2 * PLACES));
    (1..16).find(|&rings| places().all(|x| places().all(|y| enough(rings, x, y)))).unwrap_or(16)
}

/// The function of a Voronoi noise in a lattice.
pub(super) fn function(index: usize, feature: Feature, metric: Metric) -> String {
    let (compared, distance) = match metric {
        Metric::Distance => ("dot(d, d)".to_owned(), "sqrt(#)".to_owned()),
        Metric::Squared => ("dot(d, d)".to_owned(), "#".to_owned()),
        Metric::Manhattan => ("d.x + d.y".to_owned(), "#".to_owned()),
        Metric::Chebychev => ("max(d.x, d.y)".to_owned(), "#".to_owned()),
        Metric::Minkowski { exponent } => {
            let (e, root) = (number::float(exponent), number::float(1.0 / exponent));
            (format!("terrane_power(d.x, {e}) + terrane_power(d.y, {e})"), format!("terrane_power(#, {root})"))
        }
    };
    let of = |nearest: &str| distance.replace('#', nearest);
    let value = match feature {
        Feature::F1 => of("nearest.x"),
        Feature::F2 => of("nearest.y"),
        Feature::F3 => of("nearest.z"),
        Feature::F4 => of("nearest.w"),
        Feature::F2F1 => format!("{} - {}", of("nearest.y"), of("nearest.x")),
        Feature::Crackle => format!("min(1.0, 10.0 * ({} - {}))", of("nearest.y"), of("nearest.x")),
    };
    let rings = rings(metric, order(feature));
    format!(
        "// {} by {}: {rings} rings of cells hold the nearest points for certain.
fn terrane_voronoi_{index}(at: TerranePlace, lattice: TerraneLattice) -> f32 {{
    let spot: TerraneSpot = terrane_locate(at, lattice);
    let f: vec2<f32> = terrane_fraction(spot.part);
    var nearest: vec4<f32> = vec4<f32>(1e30);
    for (var j: i32 = -{rings}; j <= {rings}; j++) {{
        for (var i: i32 = -{rings}; i <= {rings}; i++) {{
            let point: vec2<f32> = terrane_point(terrane_corner(spot, vec2<i32>(i, j), lattice.seed));
            let d: vec2<f32> = abs((point + vec2<f32>(f32(i), f32(j))) - f);
            nearest = terrane_nearest(nearest, {compared});
        }}
    }}
    return {value};
}}

",
        format!("{feature:?}").to_lowercase(),
        metric.name(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_are_as_large_as_they_must_be() {
        for metric in [Metric::Distance, Metric::Squared, Metric::Minkowski { exponent: 2.5 }] {
            assert_eq!([1, 2, 3, 4].map(|order| rings(metric, order)), [2; 4], "{metric:?}");
        }
        assert_eq!([1, 2, 3, 4].map(|order| rings(Metric::Chebychev, order)), [1, 1, 2, 2]);
        assert_eq!([1, 2, 3, 4].map(|order| rings(Metric::Manhattan, order)), [2, 2, 3, 3]);
        assert_eq!(rings(Metric::Minkowski { exponent: 0.5 }, 4), 5);
    }
}
