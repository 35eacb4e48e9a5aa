//! Ground from wanted slopes and, more weakly, wanted heights: steps at seams become slopes that nobody sees.

/// Wanted differences of neighbouring cells, and wanted heights.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Metres.
    pub(super) heights: Vec<f64>,
    /// The next cell to the east less this one, metres.
    pub(super) east: Vec<f64>,
    /// The next cell to the south less this one, metres.
    pub(super) south: Vec<f64>,
}

/// Rounds of relaxation for every cell of the length over which heights settle.
const ROUNDS: f64 = 10.0;

impl Slopes {
    /// Of flat ground.
    pub(super) fn new(columns: usize, rows: usize) -> Self {
        let zero = vec![0.0; columns * rows];
        Self { columns, rows, heights: zero.clone(), east: zero.clone(), south: zero }
    }

    /// Of ground.
    pub(super) fn of(columns: usize, rows: usize, heights: &[f32]) -> Self {
        let mut slopes = Self::new(columns, rows);
        for cell in 0..columns * rows {
            let own = f64::from(heights[cell]);
            slopes.heights[cell] = own;
            if cell % columns + 1 < columns {
                slopes.east[cell] = f64::from(heights[cell + 1]) - own;
            }
            if cell / columns + 1 < rows {
                slopes.south[cell] = f64::from(heights[cell + columns]) - own;
            }
        }
        slopes
    }

    /// The heights whose slopes differ least from those wanted, Σ (Δh - slope)² + Σ (h - height)² / length²: differences of heights are spread over about `length` cells. By successive over-relaxation, first the
    /// cells of one colour of a chessboard, then those of the other, so often that what is left is below a thousandth.
    pub(super) fn relaxed(&self, length: f64) -> Vec<f32> {
        let (columns, rows) = (self.columns, self.rows);
        let hold = 1.0 / (length * length);
        let radius = 4.0 / (4.0 + hold);
        let over = 2.0 / (1.0 + (1.0 - radius * radius).sqrt());
        let mut heights = self.heights.clone();
        for _ in 0..(ROUNDS * length).max(10.0) as usize {
            for colour in 0..2 {
                for row in 0..rows {
                    for column in ((row + colour) % 2..columns).step_by(2) {
                        let cell = row * columns + column;
                        let (mut sum, mut count) = (hold * self.heights[cell], hold);
                        let mut add = |value: f64| {
                            sum += value;
                            count += 1.0;
                        };
                        if column > 0 {
                            add(heights[cell - 1] + self.east[cell - 1]);
                        }
                        if column + 1 < columns {
                            add(heights[cell + 1] - self.east[cell]);
                        }
                        if row > 0 {
                            add(heights[cell - columns] + self.south[cell - columns]);
                        }
                        if row + 1 < rows {
                            add(heights[cell + columns] - self.south[cell]);
                        }
                        heights[cell] += over * (sum / count - heights[cell]);
                    }
                }
            }
        }
        heights.into_iter().map(|height| height as f32).collect()
    }
}
