//! Lattices of sample points.

use super::Rectangle;

/// How far from the origin terrain can be asked for, in metres: 2^40.
pub const PLANE_LIMIT: f64 = 1_099_511_627_776.0;

/// Which detail a sample carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Filter {
    /// Leaves out what the window's spacing cannot carry.
    #[default]
    Band,
    /// The function as it is: samples that two spacings share are equal to the bit.
    Exact,
}

impl Filter {
    /// The name in URLs and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Filter::Band => "band",
            Filter::Exact => "exact",
        }
    }
}

/// Why a window cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WindowError {
    /// A spacing that is not a positive number of metres.
    #[error("spacing must be a positive number of metres, got {0}")]
    Spacing(f64),
    /// An area without width or height, or with its corners the wrong way round.
    #[error("the area must have its least corner first and be at least one sample wide and high (minx,miny,maxx,maxy)")]
    Empty,
    /// A coordinate that is not finite or lies beyond [`PLANE_LIMIT`].
    #[error("coordinates must lie within 2^40 = 1099511627776 m of the origin, got {0}")]
    Far(f64),
    /// More samples than the caller allows.
    #[error("{samples} samples are more than the {limit} allowed")]
    Samples {
        /// Samples asked for.
        samples: u64,
        /// The limit.
        limit: u64,
    },
}

/// One direction of a window: sample i stands at `(first + i · stride) · unit + origin`.
///
/// A coordinate comes from its global integer index alone, so windows that share a sample share its coordinate to the bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    first: i64,
    stride: i64,
    unit: f64,
    origin: f64,
    count: usize,
}

impl Axis {
    /// `count` samples from global index `first` on, `stride` indices of `unit` metres apart.
    #[must_use]
    pub fn new(first: i64, stride: i64, unit: f64, origin: f64, count: usize) -> Self {
        Self { first, stride, unit, origin, count }
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// True for an axis without samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Distance between neighbouring samples in metres.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.stride.unsigned_abs() as f64 * self.unit
    }

    /// The coordinate of sample `i` in metres; `i` may lie outside the axis.
    #[must_use]
    pub fn coordinate(&self, i: i64) -> f64 {
        (self.first + i * self.stride) as f64 * self.unit + self.origin
    }

    /// The coordinates of all samples.
    pub fn coordinates(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.count as i64).map(|i| self.coordinate(i))
    }

    fn part(&self, from: i64, count: usize) -> Self {
        Self { first: self.first + from * self.stride, count, ..*self }
    }
}

/// A regular lattice of sample points, rows from north to south, columns from west to east.
///
/// ```
/// use terrane::geometry::{Filter, Window};
/// let window = Window::area([0.0, 0.0, 300.0, 200.0], 10.0, Filter::Band, 1 << 20)?;
/// assert_eq!((window.columns.len(), window.rows.len()), (30, 20));
/// assert_eq!((window.columns.coordinate(0), window.rows.coordinate(0)), (5.0, 195.0));
/// # Ok::<(), terrane::geometry::WindowError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// From west to east.
    pub columns: Axis,
    /// From north to south.
    pub rows: Axis,
    /// Which detail the samples carry.
    pub filter: Filter,
}

impl Window {
    /// One point; `spacing` in metres says what a filtered sample there may carry.
    ///
    /// # Errors
    /// If the spacing is not positive or the point lies beyond [`PLANE_LIMIT`].
    pub fn point(x: f64, y: f64, spacing: f64, filter: Filter) -> Result<Self, WindowError> {
        check_spacing(spacing)?;
        for c in [x, y] {
            check_coordinate(c)?;
        }
        Ok(Self { columns: Axis::new(0, 1, spacing, x, 1), rows: Axis::new(0, -1, spacing, y, 1), filter })
    }

    /// Samples at the pixel centres of the area `[minx, miny, maxx, maxy]` (metres), its north-west corner kept.
    ///
    /// The number of columns and rows is the side over the spacing, rounded to the nearest.
    ///
    /// # Errors
    /// If the spacing is not positive, the area is empty or reaches beyond [`PLANE_LIMIT`], or holds more than `limit` samples.
    pub fn area(bbox: [f64; 4], spacing: f64, filter: Filter, limit: u64) -> Result<Self, WindowError> {
        let [columns, rows] = steps(bbox, spacing)?;
        check_samples(columns, rows, limit)?;
        let ([min_x, _, _, max_y], half) = (bbox, spacing / 2.0);
        Ok(Self { columns: Axis::new(1, 2, half, min_x, columns as usize), rows: Axis::new(-1, -2, half, max_y, rows as usize), filter })
    }

    /// Samples on the edges of the area `[minx, miny, maxx, maxy]` (metres) and `spacing` apart between them, its north-west corner kept.
    ///
    /// The number of columns and rows is one more than the side over the spacing, rounded to the nearest.
    ///
    /// # Errors
    /// As [`Window::area`].
    pub fn vertices(bbox: [f64; 4], spacing: f64, filter: Filter, limit: u64) -> Result<Self, WindowError> {
        let [columns, rows] = steps(bbox, spacing)?.map(|steps| steps + 1.0);
        check_samples(columns, rows, limit)?;
        let [min_x, _, _, max_y] = bbox;
        Ok(Self { columns: Axis::new(0, 1, spacing, min_x, columns as usize), rows: Axis::new(0, -1, spacing, max_y, rows as usize), filter })
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// Distance between neighbouring samples in metres.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.columns.spacing()
    }

    /// The least rectangle that holds the samples; empty without any.
    #[must_use]
    pub fn bounds(&self) -> Rectangle {
        let ends = |axis: &Axis| [axis.coordinate(0), axis.coordinate(axis.len() as i64 - 1)];
        if self.samples() == 0 {
            return Rectangle::EMPTY;
        }
        let ([x0, x1], [y0, y1]) = (ends(&self.columns), ends(&self.rows));
        Rectangle { min: [x0.min(x1), y0.min(y1)], max: [x0.max(x1), y0.max(y1)] }
    }

    /// The window with `n` more samples on every side.
    #[must_use]
    pub fn with_apron(&self, n: usize) -> Self {
        let grow = |axis: &Axis| axis.part(-(n as i64), axis.count + 2 * n);
        Self { columns: grow(&self.columns), rows: grow(&self.rows), filter: self.filter }
    }

    /// A part of the window: first row and number of rows, first column and number of columns.
    ///
    /// # Panics
    /// If the window has no such rows or columns.
    #[must_use]
    pub fn part(&self, rows: [usize; 2], columns: [usize; 2]) -> Self {
        assert!(columns[0] + columns[1] <= self.columns.len(), "columns {} + {} of {}", columns[0], columns[1], self.columns.len());
        Self { columns: self.columns.part(columns[0] as i64, columns[1]), ..self.band(rows[0], rows[1]) }
    }

    /// `count` rows of the window from row `first` on.
    ///
    /// # Panics
    /// If the window has no such rows.
    #[must_use]
    pub fn band(&self, first: usize, count: usize) -> Self {
        assert!(first + count <= self.rows.len(), "rows {first} + {count} of {}", self.rows.len());
        Self { rows: self.rows.part(first as i64, count), ..*self }
    }
}

/// How many times the spacing goes into the sides of an area, rounded to the nearest, at least once.
fn steps(bbox: [f64; 4], spacing: f64) -> Result<[f64; 2], WindowError> {
    check_spacing(spacing)?;
    for c in bbox {
        check_coordinate(c)?;
    }
    let [min_x, min_y, max_x, max_y] = bbox;
    let steps = [max_x - min_x, max_y - min_y].map(|side| (side / spacing).round());
    if steps.iter().any(|steps| *steps < 1.0) { Err(WindowError::Empty) } else { Ok(steps) }
}

fn check_samples(columns: f64, rows: f64, limit: u64) -> Result<(), WindowError> {
    if columns * rows > limit as f64 { Err(WindowError::Samples { samples: (columns * rows) as u64, limit }) } else { Ok(()) }
}

fn check_spacing(spacing: f64) -> Result<(), WindowError> {
    if spacing.is_finite() && spacing > 0.0 { Ok(()) } else { Err(WindowError::Spacing(spacing)) }
}

fn check_coordinate(c: f64) -> Result<(), WindowError> {
    if c.abs() <= PLANE_LIMIT { Ok(()) } else { Err(WindowError::Far(c)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_apron_keeps_the_coordinates_of_the_samples_inside() {
        let window = Window::area([-7.0, 3.0, 93.0, 53.0], 0.7, Filter::Band, 1 << 20).expect("valid");
        let grown = window.with_apron(2);
        for i in 0..window.columns.len() as i64 {
            assert_eq!(window.columns.coordinate(i).to_bits(), grown.columns.coordinate(i + 2).to_bits());
        }
        assert!(grown.rows.coordinate(0) > window.rows.coordinate(0), "rows run from north to south");
    }

    #[test]
    fn a_band_is_a_part_of_the_whole() {
        let window = Window::area([0.0, 0.0, 100.0, 100.0], 10.0, Filter::Band, 1 << 20).expect("valid");
        assert_eq!(window.band(3, 4).rows.coordinates().collect::<Vec<_>>(), [65.0, 55.0, 45.0, 35.0]);
    }

    #[test]
    fn vertices_stand_on_both_edges_and_are_the_neighbours_too() {
        let window = |bbox| Window::vertices(bbox, 25.0, Filter::Band, 1 << 20).expect("valid");
        let (west, east) = (window([-1000.0, 0.0, 0.0, 500.0]), window([0.0, 0.0, 1000.0, 500.0]));
        assert_eq!((west.columns.len(), west.rows.len(), west.spacing()), (41, 21, 25.0));
        assert_eq!((west.bounds().min, west.bounds().max), ([-1000.0, 0.0], [0.0, 500.0]));
        assert_eq!(west.columns.coordinate(40), east.columns.coordinate(0));
        assert_eq!(west.rows.coordinate(0), 500.0, "rows run from north to south");
    }

    #[test]
    fn impossible_windows_are_refused() {
        let area = |bbox, spacing| Window::area(bbox, spacing, Filter::Band, 1000);
        assert_eq!(area([0.0, 0.0, 10.0, 10.0], 0.0), Err(WindowError::Spacing(0.0)));
        assert!(matches!(area([0.0, 0.0, 10.0, 10.0], f64::NAN), Err(WindowError::Spacing(_))));
        assert_eq!(area([10.0, 0.0, 0.0, 10.0], 1.0), Err(WindowError::Empty));
        assert_eq!(area([0.0, 0.0, 1e13, 10.0], 1.0), Err(WindowError::Far(1e13)));
        assert_eq!(area([0.0, 0.0, 100.0, 100.0], 1.0), Err(WindowError::Samples { samples: 10_000, limit: 1000 }));
    }
}
