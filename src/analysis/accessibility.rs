//! Where one can go: ground that is not too steep, and how it hangs together.
//!
//! Source: M. Frade, F. Fernández de Vega, C. Cotta, "Automatic evolution of programs for procedural generation of terrains for video games: accessibility and edge
//! length constraints" (2012). Ground hangs together over the four sides of cells, what is too steep over their corners, too: so a line of steep cells divides ground
//! exactly if it is one obstacle.

use super::slope::gradient;
use crate::geometry::Surface;

/// How much of a surface can be reached by what climbs slopes up to a threshold. Numbers count cells, a sample each.
#[derive(Clone, Debug, PartialEq)]
pub struct Accessibility {
    /// Cells a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Cells that are not too steep.
    pub accessible: usize,
    /// Areas that these lie in.
    pub areas: usize,
    /// Cells of the largest area; of equals the one that begins first.
    pub largest: usize,
    /// Areas of cells that are too steep.
    pub obstacles: usize,
    /// Cell sides between what is accessible and what is not.
    pub edges: usize,
    /// Of every cell, row by row, whether it belongs to the largest area.
    pub reached: Vec<bool>,
}

impl Accessibility {
    fn share(&self, cells: usize) -> f64 {
        cells as f64 / (self.columns * self.rows).max(1) as f64
    }

    /// The share of all cells that is not too steep.
    #[must_use]
    pub fn accessible_share(&self) -> f64 {
        self.share(self.accessible)
    }

    /// The share of all cells that is not too steep and lies in the largest connected area.
    #[must_use]
    pub fn largest_share(&self) -> f64 {
        self.share(self.largest)
    }

    /// Length of the edges of obstacles, in metres a square kilometre, of cells `spacing` metres wide.
    #[must_use]
    pub fn edge_density(&self, spacing: f64) -> f64 {
        self.share(self.edges) / spacing * 1e6
    }
}

/// Finds what of a surface is accessible to what climbs slopes of at most `degrees`. The surface has an apron of one sample around the cells that are judged.
///
/// ```
/// use terrane::{analysis::accessibility, geometry::Surface};
/// // A wall, 20 m high, across ground of 7 × 5 samples, 10 m apart.
/// let elevation = (0..35).map(|i| if i % 7 == 3 { 20.0 } else { 0.0 }).collect();
/// let found = accessibility(&Surface { columns: 7, rows: 5, elevation, ..Surface::default() }, 10.0, 30.0);
/// assert_eq!((found.columns, found.rows), (5, 3));
/// // On the crest itself slopes cancel out: the wall is a column of cells between two that are steep.
/// assert_eq!((found.accessible, found.areas, found.largest, found.obstacles), (9, 3, 3, 2));
/// ```
#[must_use]
pub fn accessibility(surface: &Surface, spacing: f64, degrees: f64) -> Accessibility {
    let (columns, rows) = (surface.columns.saturating_sub(2), surface.rows.saturating_sub(2));
    let steepest = libm::tan(degrees.clamp(0.0, 89.999).to_radians());
    let is_accessible = |row: usize, column: usize| {
        let [east, north] = gradient(surface, row + 1, column + 1, spacing).map(f64::from);
        east * east + north * north <= steepest * steepest
    };
    let cells: Vec<bool> = (0..rows * columns).map(|i| is_accessible(i / columns, i % columns)).collect();
    connected(&cells, columns)
}

/// Puts cells of a kind that touch into one area, row by row, with a forest of joined areas (Rosenfeld and Pfaltz 1966).
fn connected(cells: &[bool], columns: usize) -> Accessibility {
    let mut forest = Forest { parents: (0..cells.len() as u32).collect() };
    let mut edges = 0;
    for (i, &cell) in cells.iter().enumerate() {
        let (column, has_north) = (i % columns, i >= columns);
        let mut side = |other: usize| {
            if cells[other] == cell {
                forest.join(i, other);
            } else {
                edges += 1;
            }
        };
        if column > 0 {
            side(i - 1);
        }
        if has_north {
            side(i - columns);
        }
        if !cell && has_north {
            let corners = [(column > 0).then(|| i - columns - 1), (column + 1 < columns).then(|| i - columns + 1)];
            corners.into_iter().flatten().filter(|&other| !cells[other]).for_each(|other| forest.join(i, other));
        }
    }
    let roots: Vec<usize> = (0..cells.len()).map(|i| forest.root(i)).collect();
    let mut sizes = vec![0_usize; cells.len()];
    for &root in &roots {
        sizes[root] += 1;
    }
    let (areas, obstacles): (Vec<usize>, Vec<usize>) = (0..cells.len()).filter(|&i| roots[i] == i).partition(|&root| cells[root]);
    let largest = areas.iter().copied().reduce(|best, root| if sizes[root] > sizes[best] { root } else { best });
    Accessibility {
        columns,
        rows: cells.len() / columns.max(1),
        accessible: cells.iter().filter(|cell| **cell).count(),
        areas: areas.len(),
        largest: largest.map_or(0, |root| sizes[root]),
        obstacles: obstacles.len(),
        edges,
        reached: roots.iter().map(|&root| Some(root) == largest).collect(),
    }
}

/// Areas as trees: a root is its area's first cell.
struct Forest {
    parents: Vec<u32>,
}

impl Forest {
    fn root(&mut self, cell: usize) -> usize {
        let mut at = cell;
        while self.parents[at] as usize != at {
            // Every other step is left out from now on.
            let above = self.parents[self.parents[at] as usize];
            self.parents[at] = above;
            at = above as usize;
        }
        at
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise;

    /// The plain meaning: areas filled cell by cell.
    fn reference(cells: &[bool], columns: usize) -> Accessibility {
        let rows = cells.len() / columns;
        let (mut seen, mut areas, mut largest) = (vec![false; cells.len()], [0, 0], Vec::new());
        for start in 0..cells.len() {
            if seen[start] {
                continue;
            }
            let (mut area, mut at) = (vec![start], 0);
            seen[start] = true;
            while at < area.len() {
                let (row, column) = ((area[at] / columns) as i64, (area[at] % columns) as i64);
                for (dr, dc) in (-1..=1).flat_map(|dr| (-1..=1).map(move |dc| (dr, dc))) {
                    let (r, c) = (row + dr, column + dc);
                    let touches = !cells[start] || dr == 0 || dc == 0;
                    if touches && (0..rows as i64).contains(&r) && (0..columns as i64).contains(&c) {
                        let other = r as usize * columns + c as usize;
                        if !seen[other] && cells[other] == cells[start] {
                            seen[other] = true;
                            area.push(other);
                        }
                    }
                }
                at += 1;
            }
            areas[usize::from(cells[start])] += 1;
            if cells[start] && area.len() > largest.len() {
                largest = area;
            }
        }
        let differ = |a: usize, b: usize| usize::from(cells[a] != cells[b]);
        let across: usize = (0..cells.len()).filter(|i| i % columns > 0).map(|i| differ(i, i - 1)).sum();
        let down: usize = (columns..cells.len()).map(|i| differ(i, i - columns)).sum();
        let mut reached = vec![false; cells.len()];
        for &cell in &largest {
            reached[cell] = true;
        }
        Accessibility {
            columns,
            rows,
            accessible: cells.iter().filter(|cell| **cell).count(),
            areas: areas[1],
            largest: largest.len(),
            obstacles: areas[0],
            edges: across + down,
            reached,
        }
    }

    #[test]
    fn areas_are_those_that_filling_finds() {
        for case in 0..300_u64 {
            let (columns, rows) = (1 + (noise::key(case, 1) % 23) as usize, 1 + (noise::key(case, 2) % 23) as usize);
            let share = noise::key(case, 3) % 101;
            let cells: Vec<bool> = (0..columns * rows).map(|i| noise::key(case, 10 + i as u64) % 100 < share).collect();
            assert_eq!(connected(&cells, columns), reference(&cells, columns), "case {case}");
        }
    }

    #[test]
    fn diagonal_walls_divide_ground_and_are_one_obstacle() {
        let cells: Vec<bool> = (0..49).map(|i| i / 7 != i % 7).collect();
        let found = connected(&cells, 7);
        assert_eq!((found.areas, found.obstacles, found.accessible, found.largest, found.edges), (2, 1, 42, 21, 24));
        assert_eq!(found.edge_density(1000.0), 24.0 / 49.0 * 1000.0);
    }

    #[test]
    fn the_threshold_is_a_slope() {
        let ramp = |rise: f32| Surface { columns: 6, rows: 4, elevation: (0..24).map(|i| rise * (i % 6) as f32).collect(), ..Surface::default() };
        assert_eq!(accessibility(&ramp(2.6), 10.0, 15.0).largest_share(), 1.0, "14.6°");
        assert_eq!(accessibility(&ramp(2.8), 10.0, 15.0).accessible_share(), 0.0, "15.6°");
        let tiny = accessibility(&Surface { columns: 2, rows: 2, elevation: vec![0.0; 4], ..Surface::default() }, 1.0, 15.0);
        assert_eq!((tiny.largest, tiny.largest_share()), (0, 0.0));
    }
}
