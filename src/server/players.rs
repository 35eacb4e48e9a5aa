//! Who plays in which world: where everybody is, and was since each layer's newest generation. In memory alone.

use crate::evolve::Ground;
use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};
use tokio::sync::{Mutex as Turn, OwnedMutexGuard};

/// Most players of a world.
const MAX_PLAYERS: usize = 64;

/// Most positions of one since the last generation.
const MAX_POSITIONS: usize = 4096;

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
    seen: Instant,
}

impl Player {
    fn way(&self, layer: &str) -> &[[f64; 2]] {
        &self.way[self.counts.get(layer).copied().unwrap_or(0)..]
    }

    fn position(&self) -> [f64; 2] {
        self.way.last().copied().unwrap_or_default()
    }
}

/// The players of a world.
#[derive(Default)]
pub(super) struct Room(BTreeMap<String, Player>);

/// Why somebody cannot come or go on.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Refused {
    Full,
    TooLong,
}

impl Room {
    /// Forgets who is gone.
    fn tidy(&mut self, now: Instant) {
        self.0.retain(|_, player| now.saturating_duration_since(player.seen) < GONE);
    }

    /// Somebody comes, or goes on along some positions, over these layers.
    pub(super) fn go(&mut self, name: &str, positions: &[[f64; 2]], grounds: &[(&str, &Ground)], now: Instant) -> Result<(), Refused> {
        let known = self.0.get(name);
        if known.is_none() && self.0.len() >= MAX_PLAYERS {
            return Err(Refused::Full);
        }
        let mut way = known.map_or_else(Vec::new, |player| player.way.clone());
        way.extend(positions);
        way.dedup();
        let took_ns = |(layer, ground): &(&str, &Ground)| self.0.values().flat_map(|player| player.way(layer).windows(2)).map(part(ground)).sum::<f64>();
        let own_ns = |(_, ground): &(&str, &Ground)| way.windows(2).map(part(ground)).sum::<f64>();
        if !grounds.is_empty() && (way.len() > MAX_POSITIONS || grounds.iter().any(|ground| took_ns(ground) + own_ns(ground) > MOST_NS)) {
            return Err(Refused::TooLong);
        }
        if grounds.is_empty() {
            way.drain(..way.len().saturating_sub(1));
        }
        match self.0.get_mut(name) {
            Some(player) => (player.way, player.seen) = (way, now),
            None => drop(self.0.insert(name.to_owned(), Player { way, counts: BTreeMap::new(), seen: now })),
        }
        Ok(())
    }

    /// Somebody leaves: nothing is promised to whoever is not there. Whether there was such a player.
    pub(super) fn leave(&mut self, name: &str) -> bool {
        self.0.remove(name).is_some()
    }

    /// The ways of all since a layer's last generation, each ending where one is.
    pub(super) fn ways(&self, layer: &str) -> Vec<Vec<[f64; 2]>> {
        self.0.values().map(|player| player.way(layer).to_vec()).collect()
    }

    /// All by name, each with its position and how long ago it was heard of.
    pub(super) fn all(&self, now: Instant) -> impl Iterator<Item = (&str, [f64; 2], Duration)> + '_ {
        self.0.iter().map(move |(name, player)| (name.as_str(), player.position(), now.saturating_duration_since(player.seen)))
    }

    /// A generation of a layer was bred with these ways: for the next of it only where players are counts, and where they go. `layers` are all that evolve.
    pub(super) fn rest(&mut self, layer: &str, layers: &[&str]) {
        for player in self.0.values_mut() {
            player.counts.retain(|known, _| layers.contains(&known.as_str()));
            player.counts.insert(layer.to_owned(), player.way.len() - 1);
            let done = layers.iter().map(|layer| player.counts.get(*layer).copied().unwrap_or(0)).min().unwrap_or(0);
            player.way.drain(..done);
            player.counts.values_mut().for_each(|from| *from -= done);
        }
    }

    /// A player on a ground, or so near that nothing may change there.
    pub(super) fn near(&self, ground: &Ground) -> Option<&str> {
        let area = ground.area().grown(ground.promise);
        self.0.iter().find(|(_, player)| area.holds(player.position())).map(|(name, _)| name.as_str())
    }
}

fn part(ground: &Ground) -> impl Fn(&[[f64; 2]]) -> f64 + '_ {
    |pair| ground.part_ns(pair[0], pair[1])
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
        assert_eq!((room.ways("a"), room.ways("b")), (vec![vec![at(1.0), at(2.0)]], vec![vec![at(0.0), at(1.0), at(2.0)]]));
        room.rest("b", &["a", "b"]);
        assert_eq!((room.ways("a"), room.ways("b")), (vec![vec![at(1.0), at(2.0)]], vec![vec![at(2.0)]]));
        room.rest("a", &["a"]);
        assert_eq!((room.ways("a"), room.0["one"].way.len()), (vec![vec![at(2.0)]], 1));
        assert!(room.near(&ground) == Some("one") && room.leave("one") && !room.leave("one") && room.near(&ground).is_none());
    }

    #[test]
    fn rooms_are_bounded_and_who_is_silent_is_gone() {
        let (mut room, now, ground) = (Room::default(), Instant::now(), Ground::default());
        let grounds = [("a", &ground)];
        for i in 0..MAX_PLAYERS {
            room.go(&i.to_string(), &[[0.0, 0.0]], &grounds, now).expect("room");
        }
        assert_eq!(room.go("more", &[[0.0, 0.0]], &grounds, now), Err(Refused::Full));
        let long: Vec<_> = (0..=MAX_POSITIONS as u32).map(|i| [f64::from(i), 0.0]).collect();
        assert_eq!(room.go("0", &long, &grounds, now), Err(Refused::TooLong));
        assert_eq!(room.ways("a")[0], [[0.0, 0.0]]);
        let vast = Ground { promise: 1e6, lines: 1025, length: 1023, passes: 0, ..Ground::default() };
        assert_eq!(room.go("1", &long[..200], &[("a", &vast)], now), Err(Refused::TooLong));
        room.go("0", &[[5.0, 0.0]], &grounds, now + GONE / 2).expect("room");
        room.tidy(now + GONE);
        assert_eq!(room.all(now + GONE).map(|(name, ..)| name).collect::<Vec<_>>(), ["0"]);
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
