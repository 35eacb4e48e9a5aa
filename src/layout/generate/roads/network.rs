//! Which places roads join: the least tree of cheapest ways, and further roads where it makes for long ways round.

use super::{
    GenerateError, Place,
    course::Courses,
    search::{Known, Terms, pair},
    wrong,
};
use crate::geometry::Source;

/// Pieces of a way that are found not to do, at most, before a pair is given up.
const MOST_TRIES: usize = 100;

/// Roads between all places; every piece once.
pub(super) fn join(terms: &Terms, places: &[Place], nodes: &[usize], courses: &mut Courses<impl Source>, detour: f64) -> Result<Known, GenerateError> {
    let mut known = Known::new(terms.lattice, nodes);
    let mut met: Vec<(f64, [usize; 2])> = terms.meetings(nodes, &known).into_iter().map(|(both, cost)| (cost, both)).collect();
    met.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let chosen = choose(&met, places.len(), detour);
    if let Some(lonely) = (1..places.len()).find(|&place| chosen.1[place] != chosen.1[0]) {
        return Err(unreachable(terms, places, nodes, [0, lonely]));
    }
    for route in chosen.0 {
        let ends = route.map(|place| nodes[place]);
        let mut tries = 0;
        let way = loop {
            tries += 1;
            let way = terms.way(ends[0], ends[1], &known).filter(|_| tries <= MOST_TRIES);
            let Some(way) = way else { return Err(unreachable(terms, places, nodes, route)) };
            let refused = courses.too_long(terms, &known, &way);
            if refused.is_empty() {
                break way;
            }
            known.refused.extend(refused);
        };
        known.add(terms, &way, route);
    }
    Ok(known)
}

/// The pairs of the least tree, cheapest first, then those whose way over it costs too much more than their own; and which tree every place belongs to.
fn choose(met: &[(f64, [usize; 2])], count: usize, detour: f64) -> (Vec<[usize; 2]>, Vec<usize>) {
    let mut tree: Vec<usize> = (0..count).collect();
    let mut chosen = Vec::new();
    let mut costs = vec![vec![f64::INFINITY; count]; count];
    for (place, row) in costs.iter_mut().enumerate() {
        row[place] = 0.0;
    }
    let mut others = Vec::new();
    for &(cost, both) in met {
        let [a, b] = both.map(|place| tree[place]);
        if a == b {
            others.push((cost, both));
            continue;
        }
        tree.iter_mut().filter(|tree| **tree == b).for_each(|tree| *tree = a);
        add(&mut costs, both, cost);
        chosen.push(both);
    }
    for (cost, both) in others {
        if costs[both[0]][both[1]] > detour * cost {
            add(&mut costs, both, cost);
            chosen.push(both);
        }
    }
    (chosen, tree)
}

/// Takes a road into the costs of the ways between all places.
fn add(costs: &mut [Vec<f64>], [a, b]: [usize; 2], cost: f64) {
    let before: Vec<Vec<f64>> = costs.to_vec();
    for (from, row) in costs.iter_mut().enumerate() {
        for (to, least) in row.iter_mut().enumerate() {
            let over = (before[from][a] + before[b][to]).min(before[from][b] + before[a][to]) + cost;
            *least = least.min(over);
        }
    }
}

/// Says why no road leads from one place to another.
fn unreachable(terms: &Terms, places: &[Place], nodes: &[usize], [a, b]: [usize; 2]) -> GenerateError {
    let [from, to] = pair(a, b);
    let why = if terms.is_dry_between(nodes[from], nodes[to]) {
        "every way is steeper than the grade or needs more earthwork, or is closed by other roads; allow a greater grade or earthwork, or a smaller spacing"
    } else {
        "water lies between that no bridge of the length allowed crosses; allow longer bridges or a wider margin"
    };
    wrong(format!("places[{to}]"), format!("no road leads from {:?} to {:?}: {why}", places[from].name, places[to].name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_is_the_least_and_long_ways_round_get_a_road() {
        // A square with sides of 10 and one of 11; over the other three sides the way is 30.
        let met = [(10.0, [0, 1]), (10.0, [1, 2]), (10.0, [2, 3]), (11.0, [0, 3])];
        assert_eq!(choose(&met, 4, 3.0).0, [[0, 1], [1, 2], [2, 3]]);
        assert_eq!(choose(&met, 4, 2.0).0, [[0, 1], [1, 2], [2, 3], [0, 3]]);
        let (chosen, tree) = choose(&met[..1], 4, 2.0);
        assert_eq!((chosen, tree[0] == tree[1], tree[0] == tree[2]), (vec![[0, 1]], true, false));
    }
}
