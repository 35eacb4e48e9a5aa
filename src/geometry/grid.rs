//! How the plane is cut into tiles.

use super::{Axis, Filter, PLANE_LIMIT, Window};

/// The deepest zoom level.
pub const MAX_ZOOM: u8 = 30;

/// Most samples a side of a tile.
pub const MAX_SIDE: usize = 1025;

/// Metres of a pixel of a 256-pixel tile at zoom 0 of [`Grid::Web`].
const WEB_PIXEL: f64 = 156_543.033_928_040_97;

/// Metres of a degree of longitude or latitude on [`Grid::Geo`].
pub const DEGREE: f64 = WEB_PIXEL * 256.0 / 360.0;

/// A way to cut the plane into tiles, addressed as XYZ with y to the south; x and y are signed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Grid {
    /// `WebMercatorQuad`: the plane's origin is the middle of tile 0/0/0.
    Web,
    /// `WorldCRS84Quad`: 2^(z + 1) × 2^z tiles, plate carrée with [`DEGREE`] m to a degree; the plane's origin is longitude 0, latitude 0.
    Geo,
    /// Tile sides of 2^(25 - z) m; the plane's origin is the north-west corner of tile (0, 0) at every zoom.
    Metric,
}

/// Where the samples of a tile stand and how many there are a side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Samples {
    /// At the centres of `n` × `n` pixels.
    Centres(usize),
    /// At `n` × `n` vertices with both edges: neighbours share theirs.
    Vertices(usize),
}

impl Samples {
    /// Samples a side.
    #[must_use]
    pub fn side(self) -> usize {
        match self {
            Samples::Centres(n) | Samples::Vertices(n) => n,
        }
    }

    /// Intervals between samples a side: n for centres, n - 1 for vertices.
    fn intervals(self) -> i64 {
        match self {
            Samples::Centres(n) => n as i64,
            Samples::Vertices(n) => n as i64 - 1,
        }
    }
}

/// The address of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tile {
    /// Zoom level, 0 … [`MAX_ZOOM`].
    pub z: u8,
    /// Column, to the east.
    pub x: i64,
    /// Row, to the south.
    pub y: i64,
}

/// Why a grid has no such tile.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GridError {
    /// Beyond the deepest zoom level.
    #[error("zoom must be 0 … {MAX_ZOOM}, got {0}")]
    Zoom(u64),
    /// Too far from the origin.
    #[error("tile {z}/{x}/{y} lies beyond 2^40 m from the origin: at zoom {z}, x must be {} … {} and y {} … {}", .columns.0, .columns.1, .rows.0, .rows.1)]
    Far {
        /// Zoom level.
        z: u8,
        /// Column asked for.
        x: i64,
        /// Row asked for.
        y: i64,
        /// First and last possible column.
        columns: (i64, i64),
        /// First and last possible row.
        rows: (i64, i64),
    },
}

impl Grid {
    /// Every grid.
    pub const ALL: [Grid; 3] = [Grid::Web, Grid::Geo, Grid::Metric];

    /// The name in URLs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Grid::Web => "web",
            Grid::Geo => "geo",
            Grid::Metric => "metric",
        }
    }

    /// The grid of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|grid| grid.name() == name)
    }

    /// The side of a tile at a zoom level, in metres.
    #[must_use]
    pub fn tile_side(self, z: u8) -> f64 {
        let level_0 = match self {
            Grid::Web => WEB_PIXEL * 256.0,
            Grid::Geo => WEB_PIXEL * 128.0,
            Grid::Metric => 33_554_432.0,
        };
        level_0 / (1_u64 << z) as f64
    }

    /// First and last column and row whose tiles lie wholly within [`PLANE_LIMIT`] of the origin.
    fn span(self, z: u8) -> [(i64, i64); 2] {
        self.size(z).map(|tiles| {
            let reach = |middle: f64| (PLANE_LIMIT / self.tile_side(z) + middle).floor() as i64;
            let middle = tiles as f64 / 2.0;
            (-reach(-middle), reach(middle) - 1)
        })
    }

    /// Columns and rows of the grid's own range, which the plane's origin is the middle of; none on `metric`, whose tiles go on the same everywhere.
    #[must_use]
    pub fn size(self, z: u8) -> [i64; 2] {
        match self {
            Grid::Web => [1 << z, 1 << z],
            Grid::Geo => [2 << z, 1 << z],
            Grid::Metric => [0, 0],
        }
    }

    /// Checks that a tile exists.
    ///
    /// # Errors
    /// If the zoom level is above [`MAX_ZOOM`] or the tile reaches beyond [`PLANE_LIMIT`].
    pub fn check(self, tile: Tile) -> Result<(), GridError> {
        let Tile { z, x, y } = tile;
        if z > MAX_ZOOM {
            return Err(GridError::Zoom(z.into()));
        }
        let [columns, rows] = self.span(z);
        let is_within = (columns.0..=columns.1).contains(&x) && (rows.0..=rows.1).contains(&y);
        if is_within { Ok(()) } else { Err(GridError::Far { z, x, y, columns, rows }) }
    }

    /// The samples of a tile.
    ///
    /// A sample's global index counts half samples from the plane's origin, so that pixel centres and vertices are both whole.
    ///
    /// # Errors
    /// As [`Grid::check`].
    ///
    /// # Panics
    /// If there are fewer than 1 centre or 2 vertices a side, or more than [`MAX_SIDE`].
    pub fn window(self, tile: Tile, samples: Samples, filter: Filter) -> Result<Window, GridError> {
        self.check(tile)?;
        let intervals = samples.intervals();
        assert!(intervals > 0 && samples.side() <= MAX_SIDE, "{samples:?}");
        let half_spacing = self.tile_side(tile.z) / (2 * intervals) as f64;
        let [columns, rows] = self.size(tile.z);
        let into = i64::from(matches!(samples, Samples::Centres(_)));
        let first = |at: i64, size: i64| intervals * (2 * at - size) + into;
        Ok(Window {
            columns: Axis::new(first(tile.x, columns), 2, half_spacing, 0.0, samples.side()),
            rows: Axis::new(-first(tile.y, rows), -2, half_spacing, 0.0, samples.side()),
            filter,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(grid: Grid, z: u8, x: i64, y: i64, samples: Samples) -> Window {
        grid.window(Tile { z, x, y }, samples, Filter::Exact).expect("a tile of the plane")
    }

    #[test]
    fn the_metric_grid_has_one_metre_pixels_at_zoom_17() {
        let w = window(Grid::Metric, 17, 2, -1, Samples::Centres(256));
        assert_eq!((w.spacing(), w.columns.coordinate(0), w.rows.coordinate(0)), (1.0, 512.5, 255.5));
        let v = window(Grid::Metric, 17, 2, -1, Samples::Vertices(257));
        assert_eq!((v.columns.coordinate(0), v.columns.coordinate(256), v.rows.coordinate(256)), (512.0, 768.0, 0.0));
    }

    #[test]
    fn the_web_grid_has_its_origin_in_the_middle() {
        let w = window(Grid::Web, 0, 0, 0, Samples::Centres(256));
        assert_eq!(w.columns.coordinate(128), WEB_PIXEL / 2.0);
        let v = window(Grid::Web, 1, 1, 1, Samples::Vertices(257));
        assert_eq!((v.columns.coordinate(0), v.rows.coordinate(0)), (0.0, 0.0));
        assert!((v.columns.coordinate(256) - 20_037_508.342_789_244).abs() < 1e-7);
    }

    #[test]
    fn the_geo_grid_has_two_roots_and_ends_at_the_poles() {
        let west = window(Grid::Geo, 0, 0, 0, Samples::Vertices(181));
        assert_eq!((west.columns.coordinate(180), west.rows.coordinate(90)), (0.0, 0.0), "they meet at longitude 0");
        assert_eq!((west.columns.coordinate(0), west.rows.coordinate(0)), (-180.0 * DEGREE, 90.0 * DEGREE));
        assert_eq!(DEGREE, 111_319.490_793_273_58);
        let deep = window(Grid::Geo, 3, 9, 2, Samples::Vertices(2));
        assert_eq!((deep.columns.coordinate(0), deep.rows.coordinate(0)), (22.5 * DEGREE, 45.0 * DEGREE));
    }

    #[test]
    fn levels_share_the_coordinates_of_shared_vertices() {
        for grid in Grid::ALL {
            for n in [257, 505, 1009] {
                let parent = window(grid, 20, 700_001, -3, Samples::Vertices(n));
                let child = window(grid, 21, 1_400_003, -5, Samples::Vertices(n));
                let half = (n as i64 - 1) / 2;
                for i in 0..=half {
                    assert_eq!(parent.columns.coordinate(half + i).to_bits(), child.columns.coordinate(2 * i).to_bits());
                    assert_eq!(parent.rows.coordinate(half + i).to_bits(), child.rows.coordinate(2 * i).to_bits());
                }
            }
        }
    }

    #[test]
    fn tiles_end_where_the_plane_ends() {
        for grid in Grid::ALL {
            for z in [0, 1, 7, 30] {
                let [columns, rows] = grid.span(z);
                let (x, y) = (columns.1, rows.1);
                assert!(grid.check(Tile { z, x: columns.0, y }).is_ok());
                assert!(matches!(grid.check(Tile { z, x: x + 1, y: 0 }), Err(GridError::Far { .. })));
                assert!(matches!(grid.check(Tile { z, x: 0, y: rows.0 - 1 }), Err(GridError::Far { .. })));
                assert!(matches!(grid.check(Tile { z, x: i64::MIN, y: i64::MAX }), Err(GridError::Far { .. })));
                let edge = window(grid, z, x, y, Samples::Vertices(2));
                assert!(edge.columns.coordinate(1) <= PLANE_LIMIT && edge.columns.coordinate(2) > PLANE_LIMIT);
            }
        }
        assert_eq!(Grid::Web.check(Tile { z: 31, x: 0, y: 0 }), Err(GridError::Zoom(31)));
    }
}
