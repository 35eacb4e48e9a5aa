//! Few triangles that stay near all samples.
//!
//! What stands on an edge is decided from the edge's own samples, so that both neighbours decide alike; inside, the sample that its triangle misses by most is
//! taken in, triangle by triangle, until none is missed by more than the tolerance (greedy insertion: M. Garland, P. Heckbert, "Fast polygonal approximation of
//! terrains and height fields", 1995). The Delaunay triangulation is the crate `delaunator`, as for layouts.

/// Samples of a tile at their places in the mesh: rows from the north, columns from the west.
pub(super) struct Lattice {
    /// Places of the columns, ascending from 0 to 32767.
    pub across: Vec<u16>,
    /// Places of the rows, descending from 32767 to 0.
    pub along: Vec<u16>,
    /// Metres, row by row.
    pub heights: Vec<f64>,
}

/// A sample by its row and column.
pub(super) type Place = [usize; 2];

/// Vertices and triangles over a [`Lattice`].
#[derive(Debug, Default)]
pub(super) struct Mesh {
    /// In the order in which triangles first use them.
    pub vertices: Vec<Place>,
    /// Counter-clockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
}

impl Lattice {
    /// Samples a side.
    pub(super) fn side(&self) -> usize {
        self.across.len()
    }

    /// The height of a sample in metres.
    pub(super) fn height(&self, [row, column]: Place) -> f64 {
        self.heights[row * self.side() + column]
    }

    /// A sample's place in the mesh, to the east and north.
    pub(super) fn at(&self, [row, column]: Place) -> [i64; 2] {
        [i64::from(self.across[column]), i64::from(self.along[row])]
    }

    /// A mesh that misses no sample by more than `tolerance` metres, of which every `stride`-th sample of every `stride`-th row is a vertex at least.
    ///
    /// There must be 2^n + 1 samples a side, and the stride be a power of two no greater than 2^n.
    pub(super) fn simplify(&self, tolerance: f64, stride: usize) -> Mesh {
        let last = self.side() - 1;
        let mut taken = vec![false; self.heights.len()];
        for row in (0..=last).step_by(stride) {
            (0..=last).step_by(stride).for_each(|column| taken[row * (last + 1) + column] = true);
        }
        for edge in 0..4 {
            self.split([0, last], &move |i| [[0, i], [last, i], [i, 0], [i, last]][edge], tolerance, &mut taken);
        }
        loop {
            let triangles = self.triangulate(&taken);
            let missed: Vec<Place> = triangles.iter().filter_map(|corners| self.missed_most(corners, tolerance, &taken)).collect();
            if missed.is_empty() {
                return ordered(&triangles, self.side());
            }
            for [row, column] in missed {
                taken[row * (last + 1) + column] = true;
            }
        }
    }

    /// Takes in samples of an edge between two of them until their chords miss no sample by more than the tolerance.
    fn split(&self, [from, to]: [usize; 2], sample: &impl Fn(usize) -> Place, tolerance: f64, taken: &mut [bool]) {
        if to - from < 2 {
            return;
        }
        let along = |i: usize| self.at(sample(i)).iter().sum::<i64>() as f64;
        let (start, rise) = (self.height(sample(from)), self.height(sample(to)) - self.height(sample(from)));
        let chord = |i: usize| start + rise * ((along(i) - along(from)) / (along(to) - along(from)));
        let index = |i: usize| sample(i)[0] * self.side() + sample(i)[1];
        let is_missed = |i: usize| taken[index(i)] || (self.height(sample(i)) - chord(i)).abs() > tolerance;
        if !(from + 1..to).any(is_missed) {
            return;
        }
        let middle = usize::midpoint(from, to);
        taken[index(middle)] = true;
        self.split([from, middle], sample, tolerance, taken);
        self.split([middle, to], sample, tolerance, taken);
    }

    /// The Delaunay triangles of what is taken, counter-clockwise.
    fn triangulate(&self, taken: &[bool]) -> Vec<[Place; 3]> {
        let places: Vec<Place> = (0..taken.len()).filter(|&i| taken[i]).map(|i| [i / self.side(), i % self.side()]).collect();
        // Sheared, so that few samples of the lattice lie on one circle: what is a tie should not decide. Whole numbers keep edges straight.
        let sheared = |&place: &Place| {
            let [x, y] = self.at(place);
            delaunator::Point { x: (128 * x + 5 * y) as f64, y: (128 * y + 11 * x) as f64 }
        };
        let points: Vec<_> = places.iter().map(sheared).collect();
        let corners = delaunator::triangulate(&points).triangles;
        let turned = |&[a, b, c]: &[usize; 3]| {
            let [a, b, c] = [places[a], places[b], places[c]];
            if doubled_area(self.at(a), self.at(b), self.at(c)) < 0 { [a, c, b] } else { [a, b, c] }
        };
        corners.as_chunks::<3>().0.iter().map(turned).collect()
    }

    /// The sample inside the tile that a triangle misses by most, if that is more than the tolerance; of equals the first.
    fn missed_most(&self, corners: &[Place; 3], tolerance: f64, taken: &[bool]) -> Option<Place> {
        let [a, b, c] = corners.map(|corner| self.at(corner));
        let heights = corners.map(|corner| self.height(corner));
        let (area, inner) = (doubled_area(a, b, c) as f64, 1..self.side() - 1);
        let ends = |axis: usize| {
            let along = corners.map(|corner| corner[axis]);
            let (least, most) = (along.iter().min().copied().unwrap_or(0), along.iter().max().copied().unwrap_or(0));
            least.max(inner.start)..most.saturating_add(1).min(inner.end)
        };
        let (rows, columns) = (ends(0), ends(1));
        let (mut most, mut found) = (tolerance, None);
        for row in rows {
            for column in columns.clone() {
                let place = [row, column];
                let weights = [doubled_area(self.at(place), b, c), doubled_area(a, self.at(place), c), doubled_area(a, b, self.at(place))];
                if taken[row * self.side() + column] || weights.iter().any(|&weight| weight < 0) {
                    continue;
                }
                let [wa, wb, wc] = weights.map(|weight| weight as f64);
                let missed = ((wa * heights[0] + wb * heights[1] + wc * heights[2]) / area - self.height(place)).abs();
                if missed > most {
                    (most, found) = (missed, Some(place));
                }
            }
        }
        found
    }
}

/// Twice the area of a triangle, more than 0 if its corners run counter-clockwise.
pub(super) fn doubled_area(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Triangles by the numbers of their vertices, counted as they first appear, in a lattice with so many samples a side.
fn ordered(triangles: &[[Place; 3]], side: usize) -> Mesh {
    let (mut numbers, mut mesh) = (vec![u32::MAX; side * side], Mesh::default());
    for corners in triangles {
        mesh.triangles.push(corners.map(|[row, column]| {
            let number = &mut numbers[row * side + column];
            if *number == u32::MAX {
                *number = mesh.vertices.len() as u32;
                mesh.vertices.push([row, column]);
            }
            *number
        }));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal steps, and heights from a function of row and column.
    fn lattice(side: usize, height: impl Fn(usize, usize) -> f64) -> Lattice {
        let across: Vec<u16> = (0..side).map(|i| ((32_767 * i + (side - 1) / 2) / (side - 1)) as u16).collect();
        let along = across.iter().rev().copied().collect();
        Lattice { across, along, heights: (0..side * side).map(|i| height(i / side, i % side)).collect() }
    }

    /// Heights without any order, 0 … 1.
    fn noise(row: usize, column: usize) -> f64 {
        let mixed = (row as u64 * 73_856_093) ^ (column as u64 * 19_349_663).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f64 / (1_u64 << 24) as f64
    }

    /// Every triangle has an area and together they cover the tile once; no sample is missed by more than the tolerance.
    fn check(lattice: &Lattice, tolerance: f64, stride: usize) -> Mesh {
        let mesh = lattice.simplify(tolerance, stride);
        let corners = |triangle: &[u32; 3]| triangle.map(|vertex| mesh.vertices[vertex as usize]);
        let areas: Vec<i64> =
            mesh.triangles.iter().map(|triangle| corners(triangle).map(|corner| lattice.at(corner))).map(|[a, b, c]| doubled_area(a, b, c)).collect();
        assert!(areas.iter().all(|&area| area > 0));
        assert_eq!(areas.iter().sum::<i64>(), 2 * 32_767 * 32_767);
        let none = vec![false; lattice.heights.len()];
        assert!(mesh.triangles.iter().all(|triangle| lattice.missed_most(&corners(triangle), tolerance, &none).is_none()));
        mesh
    }

    #[test]
    fn flat_ground_is_two_triangles_and_a_bowl_is_all_samples() {
        assert_eq!(check(&lattice(65, |_, _| 7.0), 0.1, 64).triangles.len(), 2);
        assert_eq!(check(&lattice(65, |row, column| row as f64 * 3.0 - column as f64), 0.1, 64).triangles.len(), 2);
        assert_eq!(check(&lattice(65, |_, _| 7.0), 0.1, 16).vertices.len(), 25);
        let bowl = |row: usize, column: usize| (7 * row * row + 5 * column * column + row * column) as f64;
        assert_eq!(check(&lattice(33, bowl), 0.0, 32).vertices.len(), 33 * 33, "a bowl lies on no triangle");
    }

    #[test]
    fn hills_take_fewer_vertices_where_more_may_be_missed() {
        let hills = |row: usize, column: usize| {
            let (x, y) = (row as f64 / 9.0, column as f64 / 7.0);
            50.0 * (x - y * 0.3).sin() + 30.0 * (y + x * 0.2).cos() + noise(row, column)
        };
        let counts: Vec<usize> = [0.5, 2.0, 10.0, 40.0].map(|tolerance| check(&lattice(65, hills), tolerance, 64).vertices.len()).to_vec();
        assert!(counts.is_sorted_by(|a, b| a > b) && counts[3] < 100, "{counts:?}");
    }

    #[test]
    fn edges_are_decided_by_their_own_samples() {
        let here = lattice(65, |row, column| noise(row, column + 640) * 9.0 + (row as f64 / 8.0).sin() * 20.0);
        let other = lattice(65, |row, column| if column == 0 { here.height([row, 64]) } else { noise(column, row) * 500.0 });
        let rows_at = |mesh: &Mesh, edge: usize| {
            let mut rows: Vec<usize> = mesh.vertices.iter().filter(|place| place[1] == edge).map(|place| place[0]).collect();
            rows.sort_unstable();
            rows
        };
        let (east, west) = (rows_at(&check(&here, 6.0, 64), 64), rows_at(&check(&other, 6.0, 64), 0));
        assert_eq!(east, west);
        assert!(east.len() > 4 && east.len() < 65, "{}", east.len());
    }
}
