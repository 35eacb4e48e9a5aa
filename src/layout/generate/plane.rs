//! Points, segments and rings of the plane as the generators need them, and a grid to find what is near.

/// A place in metres.
pub(super) type Point = [f64; 2];

/// A segment by its ends.
pub(super) type Segment = [Point; 2];

pub(super) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// `a + t · b`.
pub(super) fn along(a: Point, t: f64, b: Point) -> Point {
    [a[0] + t * b[0], a[1] + t * b[1]]
}

pub(super) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn distance(a: Point, b: Point) -> f64 {
    let d = minus(a, b);
    dot(d, d).sqrt()
}

/// `a` with length 1; the zero vector stays what it is.
pub(super) fn unit(a: Point) -> Point {
    let length = dot(a, a).sqrt();
    if length > 0.0 { [a[0] / length, a[1] / length] } else { a }
}

/// Where on the segment, 0 … 1, the place nearest to `p` lies.
pub(super) fn nearest(p: Point, [a, b]: Segment) -> f64 {
    let ab = minus(b, a);
    let square = dot(ab, ab);
    if square > 0.0 { (dot(minus(p, a), ab) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// The distance of `p` from the segment.
pub(super) fn segment_distance(p: Point, segment: Segment) -> f64 {
    distance(p, along(segment[0], nearest(p, segment), minus(segment[1], segment[0])))
}

/// The least distance between two segments; zero where they cross.
pub(super) fn gap(a: Segment, b: Segment) -> f64 {
    if crossing(a, b).is_some() {
        return 0.0;
    }
    segment_distance(a[0], b).min(segment_distance(a[1], b)).min(segment_distance(b[0], a)).min(segment_distance(b[1], a))
}

/// Where two segments cross or touch, as the share 0 … 1 of the way along each; parallel segments never do.
pub(super) fn crossing([a, b]: Segment, [c, d]: Segment) -> Option<[f64; 2]> {
    let (ab, cd, ac) = (minus(b, a), minus(d, c), minus(c, a));
    let denominator = cross(ab, cd);
    if denominator == 0.0 {
        return None;
    }
    let (t, u) = (cross(ac, cd) / denominator, cross(ac, ab) / denominator);
    ((0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u)).then_some([t, u])
}

/// The least rectangle that holds the points: least and greatest corner.
pub(super) fn bounds(points: impl IntoIterator<Item = Point>) -> [Point; 2] {
    points
        .into_iter()
        .fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], p| [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]])
}

/// Segments in square cells, to find those near a place without asking all.
#[derive(Clone, Debug)]
pub(super) struct Near {
    low: Point,
    cell: f64,
    columns: usize,
    rows: usize,
    cells: Vec<Vec<u32>>,
    segments: Vec<Segment>,
}

/// Cells a [`Near`] has at most; larger extents get larger cells.
const MOST_CELLS: f64 = 1_048_576.0;

impl Near {
    /// An empty grid over a rectangle; `cell` is about the distance that will be asked for.
    pub(super) fn new([low, high]: [Point; 2], cell: f64) -> Self {
        let (width, height) = ((high[0] - low[0]).max(0.0), (high[1] - low[1]).max(0.0));
        let cell = cell.max((width.max(1.0) * height.max(1.0) / MOST_CELLS).sqrt()).max(width.max(height) / MOST_CELLS);
        let (columns, rows) = ((width / cell) as usize + 1, (height / cell) as usize + 1);
        Near { low, cell, columns, rows, cells: vec![Vec::new(); columns * rows], segments: Vec::new() }
    }

    /// A grid that holds the segments given.
    pub(super) fn of(segments: impl IntoIterator<Item = Segment>, cell: f64) -> Self {
        let segments: Vec<_> = segments.into_iter().collect();
        let mut near = Near::new(bounds(segments.iter().flatten().copied()), cell);
        for segment in segments {
            near.insert(segment);
        }
        near
    }

    /// First and last column and row that a rectangle reaches; what lies outside counts to the cells at the edge.
    fn reach(&self, [low, high]: [Point; 2]) -> [[usize; 2]; 2] {
        let index = |x: f64, axis: usize, count: usize| (((x - self.low[axis]) / self.cell).max(0.0) as usize).min(count - 1);
        [[index(low[0], 0, self.columns), index(high[0], 0, self.columns)], [index(low[1], 1, self.rows), index(high[1], 1, self.rows)]]
    }

    /// Adds a segment and gives its number; numbers count from zero.
    pub(super) fn insert(&mut self, segment: Segment) -> usize {
        let number = self.segments.len();
        let [[left, right], [bottom, top]] = self.reach(bounds(segment));
        for row in bottom..=top {
            for column in left..=right {
                self.cells[row * self.columns + column].push(number as u32);
            }
        }
        self.segments.push(segment);
        number
    }

    /// All segments, by number.
    pub(super) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The numbers, in ascending order, of the segments that may lie within `range` of a segment.
    pub(super) fn around(&self, segment: Segment, range: f64) -> Vec<usize> {
        let [low, high] = bounds(segment);
        let [[left, right], [bottom, top]] = self.reach([[low[0] - range, low[1] - range], [high[0] + range, high[1] + range]]);
        let mut found = Vec::new();
        for row in bottom..=top {
            for column in left..=right {
                found.extend(self.cells[row * self.columns + column].iter().map(|&number| number as usize));
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// Rings with even-odd filling: a land with its holes, or several.
#[derive(Clone, Debug)]
pub(super) struct Area {
    edges: Near,
    bounds: [Point; 2],
}

impl Area {
    /// The area inside closed rings, whose first vertices are not repeated at the end.
    pub(super) fn of<'a>(rings: impl IntoIterator<Item = &'a [Point]>, cell: f64) -> Self {
        let edges: Vec<Segment> = rings.into_iter().flat_map(|ring| (0..ring.len()).map(move |i| [ring[i], ring[(i + 1) % ring.len()]])).collect();
        Area { bounds: bounds(edges.iter().flatten().copied()), edges: Near::of(edges, cell) }
    }

    pub(super) fn bounds(&self) -> [Point; 2] {
        self.bounds
    }

    /// The rings' edges.
    pub(super) fn edges(&self) -> &Near {
        &self.edges
    }

    /// Whether a ray from `p` to the east meets an odd number of edges.
    pub(super) fn contains(&self, p: Point) -> bool {
        if self.edges.segments().is_empty() || p[0] > self.bounds[1][0] {
            return false;
        }
        let ray = [p, [self.bounds[1][0], p[1]]];
        let meets = self.edges.around(ray, 0.0).into_iter().filter(|&number| {
            let [a, b] = self.edges.segments()[number];
            (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        meets.count() % 2 == 1
    }

    /// Whether some edge lies nearer to the segment than `range`.
    pub(super) fn edge_within(&self, segment: Segment, range: f64) -> bool {
        self.edges.around(segment, range).into_iter().any(|number| gap(segment, self.edges.segments()[number]) < range)
    }
}
