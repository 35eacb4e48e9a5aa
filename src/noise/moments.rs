//! What noise is on average: the values that detail fades to where a spacing cannot carry it.

use super::{Basis, Feature, Metric};

/// Equal parts that a distribution is cut into.
pub(super) const PARTS: usize = 16;

/// Means over the whole plane of a noise n in a unit lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// The mean of n.
    pub mean: f64,
    /// The mean of |n|.
    pub absolute: f64,
    /// The mean of n².
    pub square: f64,
}

impl Basis {
    /// The means of the noise, to about four digits; a test measures them again.
    #[must_use]
    pub fn moments(self) -> Moments {
        let (mean, absolute, square) = match self {
            Basis::OPerlin => (0.0, 0.240_97, 0.089_62),
            Basis::IPerlin => (0.0, 0.201_64, 0.062_03),
            Basis::CellNoise => (0.5, 0.5, 1.0 / 3.0),
            Basis::Blender => (0.0, 0.2, 0.06),
            Basis::Voronoi { feature, metric } => {
                let (mean, square) = match (feature, metric) {
                    (Feature::F1, Metric::Distance) => (0.429_56, 0.220_51),
                    (Feature::F1, Metric::Squared) => (0.220_51, 0.079_13),
                    (Feature::F1, Metric::Manhattan) => (0.540_88, 0.350_70),
                    (Feature::F1, Metric::Chebychev) => (0.381_63, 0.174_28),
                    (_, Metric::Distance) => (0.698_93, 0.519_59),
                    (_, Metric::Squared) => (0.519_59, 0.331_40),
                    (_, Metric::Manhattan) => (0.876_51, 0.818_18),
                    _ => (0.621_32, 0.411_49),
                };
                (mean, mean, square)
            }
        };
        Moments { mean, absolute, square }
    }

    /// The mean of |n| in each sixteenth of its distribution, ascending.
    pub(super) fn parts(self) -> [f32; PARTS] {
        match self {
            Basis::OPerlin => [0.0118, 0.0358, 0.0602, 0.0845, 0.1088, 0.1327, 0.1576, 0.1865, 0.2182, 0.2523, 0.2904, 0.3344, 0.3835, 0.4426, 0.5165, 0.6397],
            Basis::IPerlin => [0.0094, 0.0299, 0.0513, 0.0734, 0.0955, 0.1172, 0.1379, 0.1598, 0.1872, 0.2158, 0.2429, 0.2719, 0.3089, 0.3606, 0.4296, 0.5349],
            Basis::CellNoise => {
                [0.0311, 0.0932, 0.1557, 0.2183, 0.2807, 0.3431, 0.4058, 0.4683, 0.5308, 0.5933, 0.6558, 0.7184, 0.7812, 0.8437, 0.9061, 0.9686]
            }
            Basis::Voronoi { feature: Feature::F1, metric: Metric::Distance } => {
                [0.0942, 0.1729, 0.2249, 0.2681, 0.3064, 0.3420, 0.3758, 0.4086, 0.4410, 0.4740, 0.5080, 0.5442, 0.5844, 0.6312, 0.6918, 0.8056]
            }
            Basis::Voronoi { feature: Feature::F1, metric: Metric::Squared } => {
                [0.0100, 0.0302, 0.0508, 0.0720, 0.0940, 0.1170, 0.1413, 0.1670, 0.1946, 0.2247, 0.2581, 0.2963, 0.3417, 0.3986, 0.4791, 0.6528]
            }
            Basis::Voronoi { feature: Feature::F1, metric: Metric::Manhattan } => {
                [0.1181, 0.2167, 0.2820, 0.3361, 0.3843, 0.4290, 0.4714, 0.5128, 0.5537, 0.5954, 0.6386, 0.6849, 0.7360, 0.7961, 0.8739, 1.0252]
            }
            Basis::Voronoi { feature: Feature::F1, metric: Metric::Chebychev } => {
                [0.0835, 0.1532, 0.1994, 0.2376, 0.2717, 0.3032, 0.3332, 0.3624, 0.3914, 0.4207, 0.4510, 0.4834, 0.5192, 0.5614, 0.6161, 0.7187]
            }
            Basis::Voronoi { metric: Metric::Distance, .. } => {
                [0.3487, 0.4599, 0.5173, 0.5603, 0.5963, 0.6286, 0.6587, 0.6875, 0.7158, 0.7443, 0.7738, 0.8051, 0.8396, 0.8798, 0.9323, 1.0349]
            }
            Basis::Voronoi { metric: Metric::Squared, .. } => {
                [0.1253, 0.2119, 0.2678, 0.3140, 0.3557, 0.3953, 0.4339, 0.4727, 0.5124, 0.5541, 0.5988, 0.6482, 0.7050, 0.7743, 0.8695, 1.0745]
            }
            Basis::Voronoi { metric: Metric::Manhattan, .. } => {
                [0.4354, 0.5744, 0.6461, 0.7003, 0.7458, 0.7866, 0.8247, 0.8612, 0.8972, 0.9333, 0.9707, 1.0104, 1.0543, 1.1058, 1.1732, 1.3047]
            }
            _ => [0.3081, 0.4066, 0.4575, 0.4958, 0.5280, 0.5568, 0.5837, 0.6096, 0.6351, 0.6609, 0.6876, 0.7160, 0.7474, 0.7844, 0.8327, 0.9307],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Field, FieldShape};

    /// |n| at 2,000 × 2,000 jittered samples of 1,400 × 1,400 cells.
    fn samples(basis: Basis) -> Vec<f32> {
        let coordinates: Vec<f64> = (0..2_000).map(|i| f64::from(i) * 0.7 + 0.013 * f64::from(i % 7)).collect();
        let field = Field::exact(FieldShape::Single, basis, 3);
        let mut rows = field.rows(&coordinates);
        let mut all = vec![0.0; coordinates.len() * coordinates.len()];
        for (line, &v) in all.chunks_mut(coordinates.len()).zip(&coordinates) {
            rows.begin(v);
            rows.fill(0, line);
        }
        all
    }

    fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
        let count = values.len() as f64;
        values.sum::<f64>() / count
    }

    #[test]
    fn the_tabulated_means_are_those_of_the_noise() {
        for basis in Basis::all() {
            let samples = samples(basis);
            let want = basis.moments();
            let check = |name: &str, want: f64, got: f64, within: f64| assert!((want - got).abs() < within, "{basis:?}: {name} is {got:.6}, tabulated {want}");
            check("mean", want.mean, mean(samples.iter().map(|&n| n.into())), 0.001);
            check("absolute", want.absolute, mean(samples.iter().map(|&n| n.abs().into())), 0.001);
            check("square", want.square, mean(samples.iter().map(|&n| f64::from(n) * f64::from(n))), 0.001);
            let mut sorted: Vec<f32> = samples.iter().map(|n| n.abs()).collect();
            sorted.sort_by(f32::total_cmp);
            for (part, (slice, want)) in sorted.chunks(sorted.len() / PARTS).zip(basis.parts()).enumerate() {
                check(&format!("part {part}"), want.into(), mean(slice.iter().map(|&n| n.into())), 0.003);
            }
        }
    }
}
