//! Distributions by four numbers.

use serde::Serialize;

/// A distribution, from k-statistics (Saunders 2006, Eq. III.3 … III.7; the misprinted mean of Eq. III.2 is the usual one): unbiased as `ddof=1` and `bias=False` are in other tools.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// How many values.
    pub count: usize,
    /// Mean; 0 of no values.
    pub mean: f64,
    /// Standard deviation √k2; 0 of fewer than two values.
    pub deviation: f64,
    /// γ1 = k3 / k2^1.5; 0 of fewer than three values or of equal ones.
    pub skewness: f64,
    /// γ2 = k4 / k2², 0 for a normal distribution; 0 of fewer than four values or of equal ones.
    pub kurtosis: f64,
}

impl Statistics {
    /// Of values, which are gone through twice, in order.
    #[must_use]
    pub fn of<I: Iterator<Item = f64> + Clone>(values: I) -> Self {
        let Some(first) = values.clone().next() else { return Self::default() };
        // Differences from the first value: equal values have a deviation of exactly 0.
        let (count, sum) = values.clone().fold((0_usize, 0.0), |(count, sum), value| (count + 1, sum + (value - first)));
        let n = count as f64;
        let mean = sum / n;
        let [m2, m3, m4] = values
            .fold([0.0; 3], |[second, third, fourth], value| {
                let x = (value - first) - mean;
                let square = x * x;
                [second + square, third + square * x, fourth + square * square]
            })
            .map(|sum| sum / n);
        Self::of_moments(count, first + mean, [m2, m3, m4])
    }

    /// Of the sums of the first four powers of values' differences from some number near them.
    #[must_use]
    pub fn of_sums(count: usize, from: f64, sums: [f64; 4]) -> Self {
        if count == 0 {
            return Self::default();
        }
        let [d, s2, s3, s4] = sums.map(|sum| sum / count as f64);
        let m2 = s2 - d * d;
        // What rounding leaves of equal values.
        let m2 = if m2 > 1e-12 * s2 { m2 } else { 0.0 };
        let (m3, m4) = (s3 - 3.0 * d * s2 + 2.0 * d * d * d, s4 - 4.0 * d * s3 + 6.0 * d * d * s2 - 3.0 * d * d * d * d);
        Self::of_moments(count, from + d, [m2, m3, m4])
    }

    /// Of a mean and the moments about it.
    fn of_moments(count: usize, mean: f64, [m2, m3, m4]: [f64; 3]) -> Self {
        let n = count as f64;
        let mut statistics = Self { count, mean, ..Self::default() };
        if count < 2 || m2 == 0.0 {
            return statistics;
        }
        let k2 = n / (n - 1.0) * m2;
        statistics.deviation = k2.sqrt();
        if count >= 3 {
            let k3 = n * n / ((n - 1.0) * (n - 2.0)) * m3;
            statistics.skewness = k3 / (k2 * k2.sqrt());
        }
        if count >= 4 {
            let k4 = n * n * ((n + 1.0) * m4 - 3.0 * (n - 1.0) * m2 * m2) / ((n - 1.0) * (n - 2.0) * (n - 3.0));
            statistics.kurtosis = k4 / (k2 * k2);
        }
        statistics
    }

    /// Mean, standard deviation, skewness, kurtosis.
    #[must_use]
    pub fn numbers(&self) -> [f64; 4] {
        [self.mean, self.deviation, self.skewness, self.kurtosis]
    }
}

/// How many values lie in each of equal ranges.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// The lower end of the first range.
    pub from: f64,
    /// The width of a range.
    pub step: f64,
    /// Values in each.
    pub counts: Vec<usize>,
}

impl Histogram {
    /// Of values, in ranges between two ends; values outside count in the outermost. `to` is above `from` and there is a range.
    #[must_use]
    pub fn of(values: impl Iterator<Item = f32>, from: f64, to: f64, ranges: usize) -> Self {
        let mut counts = vec![0; ranges.max(1)];
        let step = (to - from) / counts.len() as f64;
        let last = counts.len() - 1;
        for value in values.filter(|value| !value.is_nan()) {
            // Casts of what lies below give 0.
            counts[(((f64::from(value) - from) / step) as usize).min(last)] += 1;
        }
        Self { from, step, counts }
    }
}
