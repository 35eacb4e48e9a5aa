//! Fractal detail that lets no water cross another.

use super::{
    plane::{Near, Point, Segment, bounds, crossing, distance},
    read::Water,
};
use crate::geometry::Detail;

/// How often displacements are halved before a line stays as straight as it was drawn.
const ROUNDS: usize = 7;

/// A stretch between two vertices of a water, and its path.
struct Stretch {
    water: usize,
    ends: Segment,
    path: Vec<Point>,
}

/// The detail of every water: that wished for, with the displacement halved where its path would cross another's or itself. Waters that only meet at vertices as
/// drawn do so in the end too.
pub(super) fn untangle(waters: &[Water], wishes: Vec<Option<Detail>>) -> Vec<Option<Detail>> {
    let mut details = wishes;
    let mut stretches: Vec<Stretch> = Vec::new();
    for (water, Water { line, closed }) in waters.iter().enumerate() {
        let count = if *closed { line.len() } else { line.len().saturating_sub(1) };
        let corner = |i: usize| [line[i % line.len()][0], line[i % line.len()][1]];
        stretches.extend((0..count).map(|i| Stretch { water, ends: [corner(i), corner(i + 1)], path: Vec::new() }));
    }
    let longest = stretches.iter().map(|stretch| distance(stretch.ends[0], stretch.ends[1])).fold(1e-3, f64::max);
    let near = Near::of(stretches.iter().map(|stretch| stretch.ends), longest);
    let mut stale: Vec<bool> = vec![true; waters.len()];
    for round in 0..=ROUNDS {
        for stretch in stretches.iter_mut().filter(|stretch| stale[stretch.water]) {
            stretch.path = path(stretch.ends, details[stretch.water]);
        }
        let mut crossed = vec![false; waters.len()];
        for (number, stretch) in stretches.iter().enumerate() {
            // A path stays within a third of its length of its ends' line: river displacements are small.
            let others = near.around(stretch.ends, longest).into_iter().filter(|&other| other > number);
            let others = others.filter(|&other| stale[stretch.water] || stale[stretches[other].water]);
            for other in meetings(stretch, others, &stretches) {
                (crossed[stretch.water], crossed[other]) = (true, true);
            }
        }
        for (water, detail) in details.iter_mut().enumerate().filter(|&(water, _)| crossed[water]) {
            *detail = detail.and_then(|detail| halved(detail, round + 1 >= ROUNDS));
            stale[water] = true;
        }
        stale = crossed;
        if !stale.contains(&true) {
            break;
        }
    }
    details
}

fn halved(detail: Detail, give_up: bool) -> Option<Detail> {
    if give_up { None } else { Detail::new(detail.iterations(), detail.displacement() / 2.0, detail.seed()).ok() }
}

/// The vertices of a stretch with its detail.
fn path(ends: Segment, detail: Option<Detail>) -> Vec<Point> {
    let Some(detail) = detail else { return ends.to_vec() };
    let mut path = Vec::new();
    detail.of_edge(ends[0], ends[1], 0.0).expand(&mut path);
    path
}

/// The waters of those other stretches whose path crosses this one's.
fn meetings(stretch: &Stretch, others: impl Iterator<Item = usize>, stretches: &[Stretch]) -> Vec<usize> {
    let [low, high] = bounds(stretch.path.iter().copied());
    let mut grid = None;
    let mut met = Vec::new();
    for other in others.map(|other| &stretches[other]) {
        let [left, right] = bounds(other.path.iter().copied());
        if left[0] > high[0] || right[0] < low[0] || left[1] > high[1] || right[1] < low[1] {
            continue;
        }
        let cell = distance(stretch.ends[0], stretch.ends[1]) / 64.0;
        let grid = grid.get_or_insert_with(|| Near::of(stretch.path.windows(2).map(|pair| [pair[0], pair[1]]), cell));
        let crosses = |piece: Segment| {
            let outside = (0..2).any(|axis| piece[0][axis].max(piece[1][axis]) < low[axis] || piece[0][axis].min(piece[1][axis]) > high[axis]);
            !outside
                && grid.around(piece, 0.0).into_iter().any(|k| {
                    let own = grid.segments()[k];
                    !own.iter().any(|end| piece.contains(end)) && crossing(own, piece).is_some()
                })
        };
        if other.path.windows(2).any(|pair| crosses([pair[0], pair[1]])) {
            met.push(other.water);
        }
    }
    met
}
