//! A tree of rectangles over the edges of a long curve.

use crate::geometry::{Curve, Rectangle};

/// Edges of a leaf.
const EDGES: usize = 16;
/// Children of a node.
const CHILDREN: usize = 8;

/// Curves of so many edges have a tree.
pub(super) const MANY: usize = 48;

/// Consecutive edges of a curve, or consecutive runs.
#[derive(Clone, Debug)]
struct Run {
    /// Holds the edges with their detail.
    bounds: Rectangle,
    /// First edge and the one after the last.
    edges: [u32; 2],
    /// Whether all edges are of one part.
    whole: bool,
    /// First child and the one after the last, in the list of runs; of a leaf both are 0.
    children: [u32; 2],
}

/// The runs of a curve, the root last.
#[derive(Clone, Debug)]
pub(super) struct Runs(Vec<Run>);

/// What a search of the runs comes to.
pub(super) enum Found {
    /// Edges from the first to before the second.
    Edges([u32; 2]),
    /// The path from the beginning of the first edge to the end of the one before the second: its ends say how often it is crossed.
    Path([u32; 2]),
}

impl Runs {
    /// The tree, `None` for curves of few edges.
    pub(super) fn new(curve: &Curve) -> Option<Box<Self>> {
        let count = curve.chord_count() * curve.stride();
        if count <= MANY {
            return None;
        }
        let mut runs = leaves(curve);
        let mut level = 0..runs.len();
        while level.len() > 1 {
            for start in level.clone().step_by(CHILDREN) {
                let end = (start + CHILDREN).min(level.end);
                let bounds = runs[start..end].iter().fold(Rectangle::EMPTY, |all, run| all.union(run.bounds));
                let edges = [runs[start].edges[0], runs[end - 1].edges[1]];
                let part = |run: &Run| curve.part_of(run.edges[0] as usize / curve.stride());
                let whole = part(&runs[start]) == part(&runs[end - 1]) && runs[start..end].iter().all(|run| run.whole);
                runs.push(Run { bounds, edges, whole, children: [start as u32, end as u32] });
            }
            level = level.end..runs.len();
        }
        Some(Box::new(Self(runs)))
    }

    /// Adds the edges that can be nearest to a point of an area and not farther than `reach`; ascending.
    pub(super) fn near(&self, curve: &Curve, area: &Rectangle, reach: f64, edges: &mut Vec<u32>) {
        let root = self.0.len() as u32 - 1;
        let (mut stack, mut leaves) = (vec![(gap(&self.0[root as usize].bounds, area), root)], Vec::new());
        // No point of the area is farther from the curve than its root is.
        let mut most = reach * reach * (1.0 + 1e-9);
        while let Some((least, run)) = stack.pop() {
            let run = &self.0[run as usize];
            if least > most {
                continue;
            }
            if run.children == [0; 2] {
                leaves.push((least, run.edges));
                for i in run.edges[0]..run.edges[1] {
                    let [vertex, _] = curve.edge(i as usize);
                    let farthest = area.corners().iter().fold(0.0, |most: f64, corner| most.max(square(*corner, vertex)));
                    most = most.min(farthest * (1.0 + 1e-9));
                }
                continue;
            }
            let from = stack.len();
            stack.extend((run.children[0]..run.children[1]).map(|child| (gap(&self.0[child as usize].bounds, area), child)));
            stack[from..].sort_by(|a, b| b.0.total_cmp(&a.0));
        }
        leaves.retain(|(least, _)| *least <= most);
        leaves.sort_by_key(|(_, edges)| *edges);
        edges.extend(leaves.into_iter().flat_map(|(_, [first, end])| first..end));
    }

    /// Visits what rays from an area eastwards can cross.
    pub(super) fn east(&self, area: &Rectangle, mut visit: impl FnMut(Found)) {
        let mut stack = vec![self.0.len() - 1];
        while let Some(run) = stack.pop().map(|run| &self.0[run]) {
            let misses = run.bounds.min[1] > area.max[1] || run.bounds.max[1] < area.min[1] || run.bounds.max[0] < area.min[0];
            if misses {
                continue;
            }
            if run.whole && run.bounds.min[0] > area.max[0] {
                visit(Found::Path(run.edges));
            } else if run.children == [0; 2] {
                visit(Found::Edges(run.edges));
            } else {
                stack.extend((run.children[0]..run.children[1]).map(|child| child as usize));
            }
        }
    }
}

fn leaves(curve: &Curve) -> Vec<Run> {
    let (stride, mut runs) = (curve.stride(), Vec::new());
    let mut first = 0;
    for part in curve.parts() {
        let end = first + part.len() - 1;
        for start in (first..end).step_by(EDGES) {
            let edges = start..(start + EDGES).min(end);
            let bounds = edges.clone().fold(Rectangle::EMPTY, |bounds, i| {
                let ends = curve.edge(i);
                let reach = curve.detail().map_or(0.0, |detail| detail.reach(ends[0], ends[1]));
                bounds.union(Rectangle::around(&ends).grown(reach))
            });
            runs.push(Run { bounds, edges: [edges.start as u32, edges.end as u32], whole: true, children: [0; 2] });
        }
        first = end;
    }
    debug_assert_eq!(first, curve.chord_count() * stride, "every edge is in a run");
    runs
}

/// The squared distance of two rectangles.
fn gap(one: &Rectangle, other: &Rectangle) -> f64 {
    let [x, y] = core::array::from_fn(|axis| (other.min[axis] - one.max[axis]).max(one.min[axis] - other.max[axis]).max(0.0));
    x * x + y * y
}

fn square(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])
}
