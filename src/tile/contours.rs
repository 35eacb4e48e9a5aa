//! Contour lines by marching squares (W. Lorensen and H. Cline 1987, in the plane), linear between vertices.
//!
//! Where a line crosses an edge of the lattice depends on the elevations at the edge's two ends alone, and its place in the tile is rounded within the edge: tiles
//! that share vertices share the ends of their lines to the bit.

use super::mvt::{EXTENT, Geometry, Layer, Value, encode, straightened};
use crate::geometry::{Grid, Surface};

/// Vertices beyond each side of the tile, so that lines do not end at its edges.
pub(super) const APRON: usize = 4;

/// Metres between lines, finest first; each zoom takes the first that is no less than the spacing of the samples of a 256-pixel tile.
const INTERVALS: [f64; 10] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];

/// Every so many lines there is an index line.
const INDEX: i64 = 5;

/// Pieces of lines that a tile holds at most; where there would be more, as on cliffs of many kilometres, index lines are drawn alone, or index lines of index lines.
const MOST_PIECES: i64 = 400_000;

/// Metres between the contours of a zoom level: the same however many vertices a tile has.
#[must_use]
pub fn contour_interval(grid: Grid, z: u8) -> f64 {
    interval(grid.tile_side(z) / 256.0)
}

/// Metres between contours that suit a spacing of samples.
pub(super) fn interval(spacing: f64) -> f64 {
    INTERVALS.into_iter().find(|&interval| interval >= spacing).unwrap_or(1000.0)
}

/// Draws the lines of a surface of vertices with an apron of [`APRON`].
pub(super) fn draw(surface: &Surface, interval: f64) -> Vec<u8> {
    let cells = (surface.rows - 1) * (surface.columns - 1);
    let counted = |stride: i64| (0..cells).map(|cell| Cell::of(surface, cell).levels(interval, stride).count() as i64).sum::<i64>();
    let mut stride = 1;
    while counted(stride) > MOST_PIECES {
        stride *= INDEX;
    }
    let mut pieces = Vec::new();
    for number in 0..cells {
        let cell = Cell::of(surface, number);
        for level in cell.levels(interval, stride) {
            cell.cross(level, interval, |[from, to]| pieces.push((level, from, to)));
        }
    }
    let mut layer = Layer::new("contours");
    pieces.sort_unstable();
    for pieces in pieces.chunk_by(|a, b| a.0 == b.0) {
        let level = pieces[0].0;
        let elevation = level as f64 * interval;
        let place = |edge: &usize| place(surface, *edge, elevation);
        let lines: Vec<_> = chain(pieces).iter().map(|edges| straightened(edges.iter().map(place))).filter(|line| line.len() > 1).collect();
        let properties = [("elevation", Value::Int(elevation as i64)), ("index", Value::Bool(level % INDEX == 0))];
        layer.add(None, &properties, &Geometry::Lines(lines));
    }
    encode(vec![layer])
}

/// A square of four vertices.
struct Cell {
    /// Number of its north-west vertex.
    first: usize,
    columns: usize,
    /// North-west, north-east, south-east, south-west.
    corners: [f64; 4],
}

impl Cell {
    fn of(surface: &Surface, number: usize) -> Self {
        let columns = surface.columns;
        let first = number / (columns - 1) * columns + number % (columns - 1);
        let corners = [first, first + 1, first + columns + 1, first + columns].map(|i| f64::from(surface.elevation[i]));
        Self { first, columns, corners }
    }

    /// The numbers of the lines, multiples of `stride`, that cross the cell: above its lowest vertex and not above its highest.
    fn levels(&self, interval: f64, stride: i64) -> impl Iterator<Item = i64> + use<> {
        let low = self.corners.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self.corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let step = interval * stride as f64;
        let (mut first, mut last) = ((low / step).floor() as i64, (high / step).floor() as i64);
        // Division rounds; multiples say which lines there are.
        while first as f64 * step <= low {
            first += 1;
        }
        while last as f64 * step > high {
            last -= 1;
        }
        (first..=last).map(move |level| level * stride)
    }

    /// Gives the pairs of edges that a line joins in the cell. An edge is named by twice its first vertex, and one more if it runs to the south.
    fn cross(&self, level: i64, interval: f64, mut piece: impl FnMut([usize; 2])) {
        let elevation = level as f64 * interval;
        let above = self.corners.map(|corner| corner >= elevation);
        let [north, east, south, west] = [2 * self.first, 2 * (self.first + 1) + 1, 2 * (self.first + self.columns), 2 * self.first + 1];
        let ends = [above[0] != above[1], above[1] != above[2], above[2] != above[3], above[3] != above[0]];
        let mut crossed = [north, east, south, west].into_iter().zip(ends).filter(|(_, crossed)| *crossed).map(|(edge, _)| edge);
        if ends == [true; 4] {
            // A saddle: the mean decides which corners belong together.
            let middle = self.corners.iter().sum::<f64>() / 4.0 >= elevation;
            if middle == above[0] {
                piece([north, east]);
                piece([south, west]);
            } else {
                piece([north, west]);
                piece([south, east]);
            }
        } else if let (Some(from), Some(to)) = (crossed.next(), crossed.next()) {
            piece([from, to]);
        }
    }
}

/// Joins the pieces of one line at the edges they share: rings, and lines that end at the border of the lattice.
fn chain(pieces: &[(i64, usize, usize)]) -> Vec<Vec<usize>> {
    let mut ends: Vec<(usize, usize)> = pieces.iter().enumerate().flat_map(|(i, piece)| [(piece.1, i), (piece.2, i)]).collect();
    ends.sort_unstable();
    let at = |edge: usize| {
        let first = ends.partition_point(|end| end.0 < edge);
        ends[first..].iter().take_while(move |end| end.0 == edge).map(|end| end.1)
    };
    let mut used = vec![false; pieces.len()];
    let mut lines = Vec::new();
    // Lines that have an end begin there; what is left are rings.
    let open = ends.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| same[0]);
    let rings = pieces.iter().enumerate().map(|(i, piece)| (piece.1, i));
    for (start, first) in open.chain(rings) {
        let (mut line, mut edge, mut next) = (vec![start], start, Some(first));
        while let Some(piece) = next.filter(|&piece| !used[piece]) {
            used[piece] = true;
            edge = if pieces[piece].1 == edge { pieces[piece].2 } else { pieces[piece].1 };
            line.push(edge);
            next = at(edge).find(|&other| !used[other]);
        }
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

/// Where a line crosses an edge, in units of the tile.
fn place(surface: &Surface, edge: usize, elevation: f64) -> [i32; 2] {
    let (vertex, south) = (edge / 2, edge % 2);
    let other = if south == 1 { vertex + surface.columns } else { vertex + 1 };
    let [a, b] = [vertex, other].map(|i| f64::from(surface.elevation[i]));
    let along = ((elevation - a) / (b - a)).clamp(0.0, 1.0);
    let unit = |vertex: usize, side: usize, along: f64| {
        // Whole tiles are taken off first, so that neighbours round the same number.
        let intervals = (side - 1 - 2 * APRON) as i64;
        let from_tile = vertex as i64 - APRON as i64;
        let (tile, inside) = (from_tile.div_euclid(intervals), from_tile.rem_euclid(intervals));
        tile as i32 * EXTENT + ((inside as f64 + along) * f64::from(EXTENT) / intervals as f64).round() as i32
    };
    let (row, column) = (vertex / surface.columns, vertex % surface.columns);
    let (right, down) = if south == 1 { (0.0, along) } else { (along, 0.0) };
    [unit(column, surface.columns, right), unit(row, surface.rows, down)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::{Filter, Samples, Source, Tile},
        tile::{Height, Options, TileRequest, Tileset, mvt::tests, render},
    };

    /// Smooth hills whose elevations are known everywhere.
    struct Hills;

    impl Source for Hills {
        fn sample(&self, window: &crate::geometry::Window, surface: &mut Surface) {
            let wave = |c: f64, length: f64| libm::sin(c / length);
            let heights =
                window.rows.coordinates().flat_map(|y| window.columns.coordinates().map(move |x| 900.0 * wave(x, 40_000.0) * wave(y + x / 3.0, 31_000.0)));
            heights.zip(&mut surface.elevation).for_each(|(height, out)| *out = height as f32);
        }
    }

    fn tile(x: i64, y: i64, side: usize) -> Vec<tests::Read> {
        let tile = Tile { z: 9, x, y };
        let request = TileRequest {
            grid: Grid::Web,
            tile,
            samples: Samples::Vertices(side),
            filter: Filter::Exact,
            tileset: Tileset::Contours,
            height: Height::Ground,
            options: Options::default(),
        };
        tests::read(&render(&Hills, &request).expect("drawn"))
    }

    #[test]
    fn lines_lie_where_the_ground_has_their_elevation() {
        let lines = tile(256, 254, 257);
        assert_eq!(contour_interval(Grid::Web, 9), 500.0);
        let side = Grid::Web.tile_side(9);
        let mut points = 0;
        for line in &lines {
            let elevation: f64 = line.properties["elevation"].parse().expect("a number");
            assert_eq!((elevation % 500.0, line.properties["index"] == "true"), (0.0, elevation % 2_500.0 == 0.0));
            for [column, row] in line.paths.iter().flatten() {
                let (x, y) = (*column as f64 / 4096.0 * side, (2.0 - *row as f64 / 4096.0) * side);
                let height = 900.0 * libm::sin(x / 40_000.0) * libm::sin((y + x / 3.0) / 31_000.0);
                assert!((height - elevation).abs() < 2.0, "{height} on the line of {elevation}");
                points += 1;
            }
        }
        assert!(points > 300, "{points}");
    }

    /// The places on an edge of a tile that its lines cross, with their elevations.
    fn crossings(lines: &[tests::Read], axis: usize, at: i64) -> Vec<(String, i64)> {
        let mut all: Vec<_> = lines
            .iter()
            .flat_map(|line| line.paths.iter().flatten().map(|point| (line.properties["elevation"].clone(), *point)))
            .filter(|(_, point)| point[axis] == at && (0..=4096).contains(&point[1 - axis]))
            .map(|(elevation, point)| (elevation, point[1 - axis]))
            .collect();
        all.sort();
        all.dedup();
        all
    }

    #[test]
    fn neighbours_agree_on_their_shared_edges() {
        let mut shared = 0;
        for side in [257, 100] {
            for (x, y) in [(256, 254), (257, 255), (250, 251)] {
                let (here, east, south) = (tile(x, y, side), tile(x + 1, y, side), tile(x, y + 1, side));
                assert_eq!(crossings(&here, 0, 4096), crossings(&east, 0, 0));
                assert_eq!(crossings(&here, 1, 4096), crossings(&south, 1, 0));
                shared += crossings(&here, 0, 4096).len() + crossings(&here, 1, 4096).len();
            }
        }
        assert!(shared > 12, "{shared}");
    }

    #[test]
    fn a_saddle_and_a_summit_are_drawn_as_they_are() {
        let draw = |rows: [[f32; 13]; 13]| {
            let surface = Surface { columns: 13, rows: 13, elevation: rows.concat(), ..Surface::default() };
            tests::read(&super::draw(&surface, 10.0))
        };
        let mut summit = [[0.0; 13]; 13];
        summit[6][6] = 40.0;
        let lines = draw(summit);
        assert_eq!(lines.iter().map(|line| &*line.properties["elevation"]).collect::<Vec<_>>(), ["10", "20", "30"], "at 40 m it is a point");
        let mut ring = lines[0].paths[0].clone();
        assert_eq!((lines[0].paths.len(), ring.first()), (1, ring.last()));
        ring.sort_unstable();
        ring.dedup();
        assert_eq!(ring, [[1280, 2048], [2048, 1280], [2048, 2816], [2816, 2048]]);
        let mut saddle = [[0.0; 13]; 13];
        (saddle[6][6], saddle[7][7]) = (16.0, 16.0);
        assert_eq!(draw(saddle)[0].paths.len(), 2, "the mean of 8 m is below: two rings");
        (saddle[6][6], saddle[7][7]) = (25.0, 25.0);
        assert_eq!(draw(saddle)[0].paths.len(), 1, "the mean of 12.5 m is above: one ring round both");
    }

    #[test]
    fn cliffs_without_end_are_drawn_coarser() {
        let rows = |i: usize| if (i + i / 265).is_multiple_of(2) { 0.0 } else { 30_000.0 };
        let surface = Surface { columns: 265, rows: 265, elevation: (0..265 * 265).map(rows).collect(), ..Surface::default() };
        let lines = tests::read(&super::draw(&surface, 1.0));
        assert!(!lines.is_empty() && lines.len() < 10, "{}", lines.len());
    }
}
