//! Random numbers in a fixed order, out of a key.

use crate::noise;

/// A row of random numbers: hashes of (key, how many came before).
#[derive(Clone, Debug)]
pub(in crate::layout) struct Stream {
    key: u64,
    count: u64,
}

impl Stream {
    /// The stream of what is called `purpose` inside something of key `seed`; two purposes share nothing.
    pub(in crate::layout) fn new(seed: u64, purpose: &str) -> Self {
        let purpose = purpose.bytes().fold(0_u64, |key, byte| noise::key(key, u64::from(byte)));
        Stream { key: noise::key(seed, purpose), count: 0 }
    }

    /// The next 64 random bits.
    pub(in crate::layout) fn bits(&mut self) -> u64 {
        self.count += 1;
        noise::key(self.key, self.count)
    }

    /// The next number, at least 0 and less than 1, a multiple of 2^-53.
    pub(in crate::layout) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// The next number between `low` and `high`.
    pub(in crate::layout) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// The next index of a list of `count` (at least 1) entries.
    pub(in crate::layout) fn index(&mut self, count: usize) -> usize {
        ((u128::from(self.bits()) * count as u128) >> 64) as usize
    }

    /// The next direction: a point of the unit disc, thrown until it is not too near the centre, set on the circle. No angle, so no sine.
    pub(in crate::layout) fn direction(&mut self) -> [f64; 2] {
        loop {
            let (x, y) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let square = x * x + y * y;
            if (0.01..=1.0).contains(&square) {
                let length = square.sqrt();
                return [x / length, y / length];
            }
        }
    }
}
