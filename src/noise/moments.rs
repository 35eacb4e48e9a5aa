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

/// A noise's mean and mean square, and the mean of each sixteenth of its distribution, ascending. For noises that are never negative.
#[derive(Clone, Copy, Debug)]
struct Spread([f64; 2], [f32; PARTS]);

impl Basis {
    /// The means of the noise, to about four digits; a test measures them again.
    #[must_use]
    pub fn moments(self) -> Moments {
        let (mean, absolute, square) = match self {
            Basis::OPerlin => (0.0, 0.240_97, 0.089_62),
            Basis::IPerlin => (0.0, 0.201_64, 0.062_03),
            Basis::CellNoise => (0.5, 0.5, 1.0 / 3.0),
            Basis::Blender => (0.0, 0.285_19, 0.123_90),
            Basis::Voronoi { feature, metric } => {
                let [mean, square] = spread(feature, metric).0;
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
            Basis::Blender => [0.0139, 0.0428, 0.0723, 0.1019, 0.1314, 0.1596, 0.1890, 0.2231, 0.2606, 0.3011, 0.3453, 0.3976, 0.4550, 0.5240, 0.6086, 0.7368],
            Basis::CellNoise => {
                [0.0311, 0.0932, 0.1557, 0.2183, 0.2807, 0.3431, 0.4058, 0.4683, 0.5308, 0.5933, 0.6558, 0.7184, 0.7812, 0.8437, 0.9061, 0.9686]
            }
            Basis::Voronoi { feature, metric } => spread(feature, metric).1,
        }
    }
}

/// The metrics that are tabulated: Minkowski's at 1/e = 0, ½, 1 and 2, and the squares.
const METRICS: [Metric; 5] = [Metric::Chebychev, Metric::Distance, Metric::Manhattan, Metric::Minkowski { exponent: 0.5 }, Metric::Squared];

fn spread(feature: Feature, metric: Metric) -> Spread {
    let row = &CELLULAR[feature as usize];
    match metric {
        Metric::Minkowski { exponent } => between(feature, row, exponent),
        _ => row[METRICS.iter().position(|&tabulated| tabulated == metric).expect("every metric without a parameter is in the table")],
    }
}

/// Minkowski's other exponents: points of the same density lie at distances that the area A of the metric's unit disc sets, d ~ 1/√A; what is left of the exponent
/// is taken from the tabulated neighbours by straight lines over 1/e. The crackle's share of edges does not scale and is taken as it is.
fn between(feature: Feature, row: &[Spread; 5], exponent: f32) -> Spread {
    let inverse = f64::from(Metric::Minkowski { exponent }.inverse_exponent());
    let nodes = METRICS.map(|metric| f64::from(metric.inverse_exponent()));
    let above = (1..3).find(|&node| inverse <= nodes[node]).unwrap_or(3);
    let part = (inverse - nodes[above - 1]) / (nodes[above] - nodes[above - 1]);
    let radius = |inverse: f64| if feature == Feature::Crackle { 1.0 } else { 1.0 / unit_disc(inverse).sqrt() };
    let scales = [(1.0 - part) * radius(inverse) / radius(nodes[above - 1]), part * radius(inverse) / radius(nodes[above])];
    let squares = [scales[0] * radius(inverse) / radius(nodes[above - 1]), scales[1] * radius(inverse) / radius(nodes[above])];
    let (low, high) = (row[above - 1], row[above]);
    let mean = scales[0] * low.0[0] + scales[1] * high.0[0];
    let square = squares[0] * low.0[1] + squares[1] * high.0[1];
    Spread([mean, square], core::array::from_fn(|i| scales[0] as f32 * low.1[i] + scales[1] as f32 * high.1[i]))
}

/// Area of the points within one of the origin, 4 Γ(1 + 1/e)² / Γ(1 + 2/e).
fn unit_disc(inverse: f64) -> f64 {
    let side = libm::tgamma(1.0 + inverse);
    4.0 * side * side / libm::tgamma(1.0 + 2.0 * inverse)
}

/// Of every feature with the metrics of [`METRICS`]; `the_table` of the tests writes it.
#[rustfmt::skip]
const CELLULAR: [[Spread; 5]; 6] = [
    [
        Spread([0.38163, 0.17428], [0.0835, 0.1532, 0.1994, 0.2376, 0.2717, 0.3032, 0.3332, 0.3624, 0.3913, 0.4207, 0.4511, 0.4834, 0.5193, 0.5614, 0.6162, 0.7186]),
        Spread([0.42955, 0.22050], [0.0942, 0.1728, 0.2249, 0.2681, 0.3064, 0.3419, 0.3757, 0.4085, 0.4410, 0.4740, 0.5080, 0.5443, 0.5844, 0.6312, 0.6919, 0.8054]),
        Spread([0.54082, 0.35062], [0.1180, 0.2166, 0.2819, 0.3361, 0.3843, 0.4289, 0.4713, 0.5127, 0.5537, 0.5954, 0.6386, 0.6848, 0.7360, 0.7959, 0.8739, 1.0250]),
        Spread([0.95211, 1.09670], [0.2045, 0.3753, 0.4888, 0.5832, 0.6673, 0.7455, 0.8204, 0.8937, 0.9671, 1.0421, 1.1205, 1.2048, 1.2991, 1.4107, 1.5581, 1.8528]),
        Spread([0.22050, 0.07911], [0.0100, 0.0302, 0.0508, 0.0720, 0.0940, 0.1170, 0.1412, 0.1670, 0.1946, 0.2247, 0.2582, 0.2964, 0.3417, 0.3987, 0.4792, 0.6524]),
    ],
    [
        Spread([0.62135, 0.41150], [0.3080, 0.4067, 0.4576, 0.4960, 0.5282, 0.5570, 0.5839, 0.6097, 0.6352, 0.6609, 0.6876, 0.7160, 0.7474, 0.7843, 0.8326, 0.9306]),
        Spread([0.69894, 0.51957], [0.3487, 0.4601, 0.5173, 0.5604, 0.5965, 0.6287, 0.6587, 0.6875, 0.7158, 0.7443, 0.7738, 0.8050, 0.8395, 0.8798, 0.9321, 1.0346]),
        Spread([0.87649, 0.81811], [0.4355, 0.5745, 0.6461, 0.7002, 0.7459, 0.7867, 0.8248, 0.8612, 0.8971, 0.9333, 0.9707, 1.0104, 1.0543, 1.1058, 1.1729, 1.3044]),
        Spread([1.52912, 2.50746], [0.7412, 0.9800, 1.1052, 1.2011, 1.2829, 1.3567, 1.4260, 1.4928, 1.5590, 1.6261, 1.6957, 1.7704, 1.8535, 1.9517, 2.0816, 2.3418]),
        Spread([0.51957, 0.33131], [0.1253, 0.2121, 0.2678, 0.3141, 0.3559, 0.3954, 0.4340, 0.4728, 0.5125, 0.5541, 0.5988, 0.6482, 0.7049, 0.7742, 0.8692, 1.0740]),
    ],
    [
        Spread([0.79340, 0.65119], [0.5002, 0.5966, 0.6434, 0.6787, 0.7084, 0.7350, 0.7597, 0.7834, 0.8067, 0.8301, 0.8543, 0.8800, 0.9086, 0.9424, 0.9875, 1.0793]),
        Spread([0.89440, 0.82634], [0.5671, 0.6761, 0.7288, 0.7682, 0.8014, 0.8309, 0.8584, 0.8847, 0.9104, 0.9363, 0.9630, 0.9913, 1.0227, 1.0595, 1.1079, 1.2037]),
        Spread([1.12227, 1.30248], [0.7070, 0.8438, 0.9106, 0.9608, 1.0029, 1.0406, 1.0756, 1.1091, 1.1420, 1.1751, 1.2093, 1.2457, 1.2861, 1.3334, 1.3955, 1.5189]),
        Spread([1.95328, 3.96662], [1.1951, 1.4350, 1.5556, 1.6470, 1.7244, 1.7940, 1.8591, 1.9218, 1.9837, 2.0463, 2.1114, 2.1812, 2.2588, 2.3506, 2.4720, 2.7163]),
        Spread([0.82634, 0.76693], [0.3259, 0.4574, 0.5313, 0.5903, 0.6423, 0.6905, 0.7369, 0.7827, 0.8289, 0.8767, 0.9274, 0.9828, 1.0460, 1.1227, 1.2277, 1.4518]),
    ],
    [
        Spread([0.93414, 0.89101], [0.6622, 0.7524, 0.7963, 0.8292, 0.8568, 0.8813, 0.9039, 0.9256, 0.9467, 0.9680, 0.9901, 1.0137, 1.0402, 1.0717, 1.1133, 1.1950]),
        Spread([1.05493, 1.13547], [0.7520, 0.8529, 0.9018, 0.9384, 0.9691, 0.9964, 1.0217, 1.0458, 1.0696, 1.0935, 1.1181, 1.1444, 1.1736, 1.2078, 1.2529, 1.3409]),
        Spread([1.32481, 1.79273], [0.9376, 1.0647, 1.1270, 1.1738, 1.2130, 1.2481, 1.2807, 1.3120, 1.3427, 1.3737, 1.4057, 1.4398, 1.4777, 1.5222, 1.5807, 1.6975]),
        Spread([2.30266, 5.43951], [1.5781, 1.8089, 1.9244, 2.0117, 2.0856, 2.1519, 2.2137, 2.2733, 2.3321, 2.3916, 2.4535, 2.5196, 2.5932, 2.6804, 2.7959, 3.0285]),
        Spread([1.13547, 1.38921], [0.5694, 0.7278, 0.8134, 0.8807, 0.9392, 0.9928, 1.0438, 1.0938, 1.1440, 1.1957, 1.2503, 1.3098, 1.3773, 1.4590, 1.5699, 1.8006]),
    ],
    [
        Spread([0.23971, 0.08984], [0.0110, 0.0333, 0.0565, 0.0806, 0.1056, 0.1317, 0.1593, 0.1883, 0.2193, 0.2526, 0.2891, 0.3298, 0.3766, 0.4333, 0.5092, 0.6594]),
        Spread([0.26938, 0.11292], [0.0123, 0.0375, 0.0637, 0.0908, 0.1191, 0.1487, 0.1798, 0.2126, 0.2475, 0.2850, 0.3260, 0.3715, 0.4238, 0.4868, 0.5707, 0.7341]),
        Spread([0.33566, 0.17567], [0.0152, 0.0463, 0.0786, 0.1123, 0.1476, 0.1844, 0.2232, 0.2643, 0.3080, 0.3551, 0.4065, 0.4637, 0.5291, 0.6079, 0.7126, 0.9157]),
        Spread([0.57700, 0.52663], [0.0254, 0.0775, 0.1320, 0.1887, 0.2483, 0.3110, 0.3772, 0.4476, 0.5231, 0.6047, 0.6943, 0.7946, 0.9101, 1.0500, 1.2375, 1.6101]),
        Spread([0.29907, 0.14613], [0.0131, 0.0399, 0.0675, 0.0962, 0.1260, 0.1573, 0.1905, 0.2257, 0.2637, 0.3051, 0.3510, 0.4034, 0.4652, 0.5425, 0.6509, 0.8870]),
    ],
    [
        Spread([0.86273, 0.81812], [0.1095, 0.3335, 0.5651, 0.8056, 0.9900, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000]),
        Spread([0.87747, 0.83758], [0.1231, 0.3754, 0.6369, 0.9043, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000]),
        Spread([0.89983, 0.86712], [0.1517, 0.4627, 0.7862, 0.9967, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000]),
        Spread([0.93920, 0.91921], [0.2536, 0.7736, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000]),
        Spread([0.88424, 0.84638], [0.1314, 0.3992, 0.6753, 0.9418, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000]),
    ],
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Field, FieldShape};

    /// n at `side` × `side` jittered samples 0.7 cells apart.
    fn samples(basis: Basis, side: i32) -> Vec<f32> {
        let coordinates: Vec<f64> = (0..side).map(|i| f64::from(i) * 0.7 + 0.013 * f64::from(i % 7)).collect();
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

    /// Means of |n| in each part.
    fn measured_parts(samples: &[f32]) -> [f64; PARTS] {
        let mut sorted: Vec<f32> = samples.iter().map(|n| n.abs()).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let size = sorted.len() / PARTS;
        core::array::from_fn(|part| mean(sorted[part * size..(part + 1) * size].iter().map(|&n| n.into())))
    }

    fn check_basis(basis: Basis, side: i32, within: f64, parts_within: f64) {
        let samples = samples(basis, side);
        let want = basis.moments();
        let check = |name: &str, want: f64, got: f64, within: f64| assert!((want - got).abs() < within, "{basis:?}: {name} is {got:.6}, tabulated {want}");
        check("mean", want.mean, mean(samples.iter().map(|&n| n.into())), within);
        check("absolute", want.absolute, mean(samples.iter().map(|&n| n.abs().into())), within);
        check("square", want.square, mean(samples.iter().map(|&n| f64::from(n) * f64::from(n))), 2.0 * within);
        for (part, (got, want)) in measured_parts(&samples).into_iter().zip(basis.parts()).enumerate() {
            check(&format!("part {part}"), want.into(), got, parts_within);
        }
    }

    #[test]
    fn the_tabulated_means_are_those_of_the_noise() {
        for basis in Basis::all() {
            let size = basis.moments().mean.max(0.5);
            check_basis(basis, 800, 0.0015 * size, 0.005 * size);
        }
    }

    #[test]
    fn means_of_exponents_between_are_within_a_hundredth() {
        for exponent in [0.5, 0.7, 2.5, 4.0] {
            for feature in Feature::ALL {
                let basis = Basis::Voronoi { feature, metric: Metric::Minkowski { exponent } };
                let mean = basis.moments().mean;
                // The crackle's part that reaches 1 is the least certain.
                check_basis(basis, 400, 0.01 * mean, 0.07 * mean);
            }
        }
    }

    /// Writes the table: `cargo test --release --lib the_table -- --ignored --nocapture`.
    #[test]
    #[ignore = "writes the table"]
    #[expect(clippy::print_stdout, reason = "writes the table")]
    fn the_table() {
        for feature in Feature::ALL {
            println!("    [");
            for metric in METRICS {
                let samples = samples(Basis::Voronoi { feature, metric }, 6_000);
                let means = [1, 2].map(|power| format!("{:.5}", mean(samples.iter().map(|&n| f64::from(n).powi(power)))));
                println!("        Spread([{}], [{}]),", means.join(", "), measured_parts(&samples).map(|part| format!("{part:.4}")).join(", "));
            }
            println!("    ],");
        }
    }
}
