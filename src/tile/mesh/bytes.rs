//! The bytes of a mesh: quantized-mesh-1.0 (github.com/CesiumGS/quantized-mesh), little-endian throughout.

/// The most vertices whose numbers have 16 bits.
const MOST_SHORT: usize = 65_536;

/// Numbers of the extensions.
pub(super) const NORMALS: u8 = 1;
pub(super) const WATER_MASK: u8 = 2;
pub(super) const METADATA: u8 = 4;

/// The bytes of a tile so far.
#[derive(Debug, Default)]
pub(super) struct Bytes(pub Vec<u8>);

impl Bytes {
    pub(super) fn doubles(&mut self, values: &[f64]) {
        self.0.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    }

    pub(super) fn float(&mut self, value: f32) {
        self.0.extend(value.to_le_bytes());
    }

    pub(super) fn count(&mut self, count: usize) {
        self.0.extend((count as u32).to_le_bytes());
    }

    /// Each the zig-zag code of its difference to the one before, the first to 0.
    pub(super) fn deltas(&mut self, values: impl Iterator<Item = u16>) {
        let mut before = 0;
        for value in values {
            let delta = i32::from(value) - before;
            self.0.extend((((delta << 1) ^ (delta >> 31)) as u16).to_le_bytes());
            before = i32::from(value);
        }
    }

    /// Numbers of so many vertices.
    fn index(&mut self, index: u32, vertices: usize) {
        if vertices > MOST_SHORT { self.0.extend(index.to_le_bytes()) } else { self.0.extend((index as u16).to_le_bytes()) }
    }

    /// Triangles of so many vertices that are numbered in the order of their first use: each number as its distance to the first that was not used yet.
    pub(super) fn triangles(&mut self, triangles: &[[u32; 3]], vertices: usize) {
        if vertices > MOST_SHORT {
            self.0.resize(self.0.len().next_multiple_of(4), 0);
        }
        self.count(triangles.len());
        let mut unused = 0;
        for &index in triangles.as_flattened() {
            self.index(unused - index, vertices);
            unused += u32::from(index == unused);
        }
    }

    /// The vertices of an edge.
    pub(super) fn edge(&mut self, edge: &[u32], vertices: usize) {
        self.count(edge.len());
        for &index in edge {
            self.index(index, vertices);
        }
    }

    /// An extension by its number.
    pub(super) fn extension(&mut self, number: u8, content: &[u8]) {
        self.0.push(number);
        self.count(content.len());
        self.0.extend(content);
    }
}

/// A unit vector in two bytes: folded onto the octahedron, 0 … 255 a side (Q. Meyer et al., "On floating-point normal vectors", 2010).
pub(super) fn octahedral([x, y, z]: [f64; 3]) -> [u8; 2] {
    let sum = x.abs() + y.abs() + z.abs();
    let (u, v) = (x / sum, y / sum);
    let sign = |value: f64| if value < 0.0 { -1.0 } else { 1.0 };
    let folded = if z < 0.0 { [(1.0 - v.abs()) * sign(u), (1.0 - u.abs()) * sign(v)] } else { [u, v] };
    folded.map(|side| (side.clamp(-1.0, 1.0) * 127.5 + 128.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_fold_their_sign() {
        let mut bytes = Bytes::default();
        bytes.deltas([5, 3, 32_767, 0].into_iter());
        let codes: Vec<u16> = bytes.0.chunks_exact(2).map(|code| u16::from_le_bytes([code[0], code[1]])).collect();
        assert_eq!(codes, [10, 3, 65_528, 65_533]);
    }

    #[test]
    fn numbers_count_back_from_the_first_unused_one() {
        let mut bytes = Bytes::default();
        bytes.triangles(&[[0, 1, 2], [2, 1, 3]], 4);
        assert_eq!(bytes.0, [2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 2, 0, 0, 0]);
        let mut long = Bytes(vec![7; 5]);
        long.triangles(&[[0, 1, 2]], 65_537);
        assert_eq!(long.0.len(), 8 + 4 + 12, "32 bits, at a multiple of 4");
    }

    #[test]
    fn normals_come_back_within_a_degree() {
        for i in 0..2_000_u32 {
            let (z, turn) = (f64::from(i) / 1_000.0 - 0.9995, f64::from(i) * 2.4);
            let normal = [(1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z];
            let [u, v] = octahedral(normal).map(|byte| f64::from(byte) / 127.5 - 1.0);
            let up = 1.0 - u.abs() - v.abs();
            let (x, y) = if up < 0.0 { ((1.0 - v.abs()) * u.signum(), (1.0 - u.abs()) * v.signum()) } else { (u, v) };
            let length = (x * x + y * y + up * up).sqrt();
            let cosine = (x * normal[0] + y * normal[1] + up * normal[2]) / length;
            assert!(cosine > 0.9998, "{normal:?} came back {cosine}");
        }
    }
}
