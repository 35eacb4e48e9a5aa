//! Who plays in which world: where everybody is, and was since each layer's newest generation. In memory alone.

use super::cover::Cover;
use crate::evolve::Ground;
use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};
use tokio::sync::{Mutex as Turn, OwnedMutexGuard};

/// Most players of a world.
const MAX_PLAYERS: usize = 64;

/// Most positions of one that are kept as they are: of longer ways, squares that hold them.
const MAX_POSITIONS: usize = 512;

/// Most squares of one: with the positions of all no more than a feedback may hold.
const MAX_SQUARES: f64 = 448.0;

/// Most nanoseconds that the ways of all may add to a generation.
const MOST_NS: f64 = 2e9;

/// Who was not heard of for so long is gone.
const GONE: Duration = Duration::from_mins(1);

/// A player.
struct Player {
    /// Plane metres, the last where it is; never empty.
    way: Vec<[f64; 2]>,
    /// Of layers from which position on the way counts for their next generation; of others all do.
    counts: BTreeMap<String, usize>,
    /// Of layers what it went through before that.
    covers: BTreeMap<String, Cover>,
    seen: Instant,
}

impl Player {
    fn way(&self, layer: &str) -> &[[f64; 2]] {
        &self.way[self.counts.get(layer).copied().unwrap_or(0)..]
    }

    fn position(&self) -> [f64; 2] {
        self.way.last().copied().unwrap_or_default()
    }

    /// Keeps of ways that are too long, or would take too long to be kept from changing, the squares that they went through.
    fn shorten(&mut self, grounds: &[(&str, &Ground)]) {
        for &(layer, ground) in grounds {
            let (way, most_ns) = (self.way(layer), MOST_NS / MAX_PLAYERS as f64);
            let point_ns = ground.part_ns([0.0; 2], [0.0; 2]);
            let covered = self.covers.get(layer).map_or(0, |cover| cover.points().count());
            let own_ns = way.windows(2).map(|pair| ground.part_ns(pair[0], pair[1])).sum::<f64>() + point_ns * covered as f64;
            if way.len() > MAX_POSITIONS || (way.len() > 1 && own_ns > most_ns) {
                let most = (most_ns / point_ns / 2.0).clamp(1.0, MAX_SQUARES) as usize;
                let mut cover = self.covers.get(layer).cloned().unwrap_or_default();
                cover.add(way, (ground.promise / 4.0).max(ground.cell), most);
                self.covers.insert(layer.to_owned(), cover);
                self.counts.insert(layer.to_owned(), self.way.len() - 1);
            }
        }
        let names: Vec<&str> = grounds.iter().map(|(layer, _)| *layer).collect();
        self.forget(&names);
    }

    /// Forgets what counts for none of the layers that evolve.
    fn forget(&mut self, layers: &[&str]) {
        self.counts.retain(|known, _| layers.contains(&known.as_str()));
        self.covers.retain(|known, _| layers.contains(&known.as_str()));
        let done = layers.iter().map(|layer| self.counts.get(*layer).copied().unwrap_or(0)).min().unwrap_or(self.way.len() - 1);
        self.way.drain(..done);
        self.counts.values_mut().for_each(|from| *from -= done);
    }
}

/// The players of a world.
#[derive(Default)]
pub(super) struct Room(BTreeMap<String, Player>);

/// As many players as a world can have are there.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Full;

impl Room {
    /// Forgets who is gone.
    fn tidy(&mut self, now: Instant) {
        self.0.retain(|_, player| now.saturating_duration_since(player.seen) < GONE);
    }

    /// Somebody comes, or goes on along some positions, of which there is one at least, over these layers.
    pub(super) fn go(&mut self, name: &str, positions: &[[f64; 2]], grounds: &[(&str, &Ground)], now: Instant) -> Result<(), Full> {
        if !self.0.contains_key(name) && self.0.len() >= MAX_PLAYERS {
            return Err(Full);
        }
        let new = || Player { way: Vec::new(), counts: BTreeMap::new(), covers: BTreeMap::new(), seen: now };
        let player = self.0.entry(name.to_owned()).or_insert_with(new);
        for &position in positions {
            if player.way.last() != Some(&position) {
                player.way.push(position);
            }
        }
        player.seen = now;
        player.shorten(grounds);
        Ok(())
    }

    /// Somebody leaves: nothing is promised to whoever is not there. Whether there was such a player.
    pub(super) fn leave(&mut self, name: &str) -> bool {
        self.0.remove(name).is_some()
    }

    /// The ways of all since a layer's last generation, each ending where one is, and how many metres they may be off.
    pub(super) fn ways(&self, layer: &str) -> (Vec<Vec<[f64; 2]>>, f64) {
        let covers = || self.0.values().filter_map(|player| player.covers.get(layer));
        let squares = covers().flat_map(Cover::points).map(|point| vec![point]);
        let ways = self.0.values().map(|player| player.way(layer).to_vec()).chain(squares).collect();
        (ways, covers().map(Cover::margin).fold(0.0, f64::max))
    }

    /// Where all are.
    pub(super) fn positions(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.0.values().map(Player::position)
    }

    /// All by name, each with its position and how long ago it was heard of.
    pub(super) fn all(&self, now: Instant) -> impl Iterator<Item = (&str, [f64; 2], Duration)> + '_ {
        self.0.iter().map(move |(name, player)| (name.as_str(), player.position(), now.saturating_duration_since(player.seen)))
    }

    /// A generation of a layer was bred with these ways: for the next of it only where players are counts, and where they go. `layers` are all that evolve.
    pub(super) fn rest(&mut self, layer: &str, layers: &[&str]) {
        for player in self.0.values_mut() {
            player.counts.insert(layer.to_owned(), player.way.len() - 1);
            player.covers.remove(layer);
            player.forget(layers);
        }
    }

    /// A player on a ground, or so near that nothing may change there.
    pub(super) fn near(&self, ground: &Ground) -> Option<&str> {
        let area = ground.area().grown(ground.promise);
        self.0.iter().find(|(_, player)| area.holds(player.position())).map(|(name, _)| name.as_str())
    }
}

/// A world's players, held: nobody comes or goes on, and no generation is bred, until it is dropped.
pub(super) type Held = OwnedMutexGuard<Room>;

/// The players of all worlds.
#[derive(Default)]
pub(super) struct Players(Mutex<BTreeMap<String, Arc<Turn<Room>>>>);

impl Players {
    /// Waits for the players of a world.
    pub(super) async fn hold(&self, world: &str) -> Held {
        let mut room = self.room(world).lock_owned().await;
        room.tidy(Instant::now());
        room
    }

    fn room(&self, world: &str) -> Arc<Turn<Room>> {
        let mut rooms = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Rooms that nobody is in, holds or waits for are forgotten.
        rooms.retain(|name, room| {
            let is_used = name == world || Arc::strong_count(room) > 1;
            is_used
                || room.try_lock().is_ok_and(|mut room| {
                    room.tidy(Instant::now());
                    !room.0.is_empty()
                })
        });
        Arc::clone(rooms.entry(world.to_owned()).or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_layer_counts_ways_for_itself() {
        let (mut room, now, ground) = (Room::default(), Instant::now(), Ground::default());
        let grounds = [("a", &ground), ("b", &ground)];
        let at = |x: f64| [x, 0.0];
        room.go("one", &[at(0.0), at(1.0)], &grounds, now).expect("room");
        room.rest("a", &["a", "b"]);
        room.go("one", &[at(1.0), at(2.0)], &grounds, now).expect("room");
        let ways = |room: &Room| [room.ways("a").0, room.ways("b").0];
        assert_eq!(ways(&room), [vec![vec![at(1.0), at(2.0)]], vec![vec![at(0.0), at(1.0), at(2.0)]]]);
        room.rest("b", &["a", "b"]);
        assert_eq!(ways(&room), [vec![vec![at(1.0), at(2.0)]], vec![vec![at(2.0)]]]);
        room.rest("a", &["a"]);
        assert_eq!((room.ways("a"), room.0["one"].way.len()), ((vec![vec![at(2.0)]], 0.0), 1));
        assert!(room.near(&ground) == Some("one") && room.leave("one") && !room.leave("one") && room.near(&ground).is_none());
    }

    #[test]
    fn rooms_are_bounded_and_who_is_silent_is_gone() {
        let (mut room, now, ground) = (Room::default(), Instant::now(), Ground::default());
        let grounds = [("a", &ground)];
        for i in 0..MAX_PLAYERS {
            room.go(&i.to_string(), &[[0.0, 0.0]], &grounds, now).expect("room");
        }
        assert_eq!(room.go("more", &[[0.0, 0.0]], &grounds, now), Err(Full));
        room.go("0", &[[5.0, 0.0]], &grounds, now + GONE / 2).expect("room");
        room.tidy(now + GONE);
        assert_eq!(room.all(now + GONE).map(|(name, ..)| name).collect::<Vec<_>>(), ["0"]);
    }

    /// However long a way is, and however far nothing may change around it: it is kept, or squares that hold it are.
    #[test]
    fn long_ways_are_kept_in_squares() {
        let vast = Ground { promise: 1e5, fade: 500, lines: 1025, length: 1023, passes: 0, ..Ground::default() };
        for ground in [Ground::default(), vast] {
            let (mut room, now, mut draws) = (Room::default(), Instant::now(), crate::genetic::Draws::new(1));
            let (mut at, mut all) = ([600.0, 600.0], Vec::new());
            for _ in 0..300 {
                let part: Vec<[f64; 2]> = (0..20)
                    .map(|_| {
                        at = [at[0] + 5.0 * draws.normal(), at[1] + 5.0 * draws.normal()];
                        at
                    })
                    .collect();
                room.go("one", &part, &[("a", &ground)], now).expect("room");
                all.extend(part);
            }
            let (ways, margin) = room.ways("a");
            assert!(ways.iter().map(Vec::len).sum::<usize>() <= 2 * MAX_POSITIONS && margin > 0.0 && margin <= 2.0 * ground.promise, "{margin}");
            for point in all.iter().step_by(11) {
                let off = |position: &[f64; 2]| libm::hypot(position[0] - point[0], position[1] - point[1]);
                assert!(ways.iter().flatten().map(off).fold(f64::INFINITY, f64::min) <= margin);
            }
            let feedback = crate::evolve::Feedback { ways, margin, ..crate::evolve::Feedback::height(100.0) };
            assert!(feedback.cost_ns(&ground) < ground.cost_ns() + MOST_NS / 20.0 + 5.0 * ground.part_ns([0.0; 2], [0.0; 2]));
            room.rest("a", &["a"]);
            assert_eq!(room.ways("a"), (vec![vec![at]], 0.0));
        }
    }

    #[tokio::test]
    async fn rooms_are_held_by_one_and_forgotten_when_empty() {
        use futures_util::FutureExt;
        let players = Players::default();
        let held = players.hold("one").await;
        assert!(players.hold("one").now_or_never().is_none() && players.hold("two").now_or_never().is_some());
        drop(held);
        players.hold("one").await.go("somebody", &[[0.0, 0.0]], &[], Instant::now()).expect("room");
        drop(players.hold("three").await);
        assert_eq!(players.0.lock().expect("no panic").keys().collect::<Vec<_>>(), ["one", "three"]);
    }
}
