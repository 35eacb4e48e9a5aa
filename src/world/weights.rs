//! How much of the ground is of each material, as bytes.

/// Shares of the base alone, which has no material: for every sample number 0 and then all materials.
pub(super) fn base(samples: usize, materials: usize) -> Vec<f32> {
    let mut shares = vec![0.0; samples * (materials + 1)];
    for none in shares.iter_mut().step_by(materials + 1) {
        *none = 1.0;
    }
    shares
}

/// Writes one page of the shares as bytes that sum to 255 over all pages.
pub(super) fn write(shares: &[f32], materials: usize, page: u8, out: &mut [[u8; 4]]) {
    let mut bytes = vec![0; materials + 1];
    let mut order = Vec::new();
    for (shares, out) in shares.chunks_exact(materials + 1).zip(out) {
        whole(shares, &mut bytes, &mut order);
        *out = std::array::from_fn(|channel| bytes.get(4 * usize::from(page) + channel).copied().unwrap_or(0));
    }
}

/// Rounds shares so that they sum to 255: all down, then the largest remainders up (T. Hare); of equal remainders the lower number first.
fn whole(shares: &[f32], bytes: &mut [u8], order: &mut Vec<(f64, usize)>) {
    let total: f64 = shares.iter().map(|&share| f64::from(share)).sum();
    let mut left = 255_u8;
    order.clear();
    for (i, (&share, byte)) in shares.iter().zip(&mut *bytes).enumerate() {
        let exact = 255.0 * f64::from(share) / total;
        *byte = exact as u8;
        left = left.saturating_sub(*byte);
        order.push((exact - f64::from(*byte), i));
    }
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    for &(_, i) in order.iter().take(left.into()) {
        bytes[i] += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_255_and_are_nearest_to_the_shares() {
        let mut seed = 1_u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f32 / 16_777_216.0
        };
        for materials in 0..9 {
            for _ in 0..200 {
                let mut shares: Vec<f32> = (0..=materials).map(|_| next() * next()).collect();
                let total: f32 = shares.iter().sum();
                for share in &mut shares {
                    *share /= total;
                }
                let mut all = Vec::new();
                for page in 0..3 {
                    let mut out = [[0; 4]];
                    write(&shares, materials, page, &mut out);
                    all.extend(out[0]);
                }
                assert_eq!(all.iter().map(|&byte| u32::from(byte)).sum::<u32>(), 255);
                assert!(shares.iter().zip(&all).all(|(&share, &byte)| (255.0 * share - f32::from(byte)).abs() < 1.001));
            }
        }
        let mut out = [[9; 4]; 2];
        write(&base(2, 2), 2, 0, &mut out);
        assert_eq!(out, [[255, 0, 0, 0]; 2]);
        write(&[0.25, 0.25, 0.5], 2, 0, &mut out[..1]);
        assert_eq!(out[0], [64, 64, 127, 0], "of equal remainders the lower numbers are first");
    }
}
