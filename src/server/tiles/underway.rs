//! Tiles under way: those that wait for a thread and those that are being evaluated, and who waits for them.

use super::{
    Order, Outcome, TileFailure,
    queue::{ALWAYS, Class, Queue, Taken},
};
use crate::{geometry::Stop, tile::TileError, world::Fingerprint};
use std::{
    collections::HashMap,
    time::{Duration, Instant},
};
use tokio::sync::oneshot;

/// What makes a tile.
pub(super) type Make = Box<dyn FnOnce(&Stop) -> Result<Vec<u8>, TileError> + Send>;

/// How much a new measurement counts in [`Underway::pace`], and how far one may lie off.
const NEW: f64 = 0.1;
const PACES: [f64; 2] = [0.1, 10.0];

/// A tile whose turn has come.
pub(super) struct Job {
    pub fingerprint: Fingerprint,
    pub number: u64,
    pub order: Order,
    pub make: Make,
    pub stop: Stop,
    /// How long it waited.
    pub queued: Duration,
}

struct Tile {
    /// Another one of the same fingerprint has another number.
    number: u64,
    /// Who has not been served; some may have gone.
    senders: Vec<oneshot::Sender<Outcome>>,
    /// How many have not gone.
    waiters: usize,
    stop: Stop,
    /// Until its turn comes.
    waiting: Option<(Order, Make, Instant)>,
}

impl Tile {
    fn answer(self, outcome: &Outcome) {
        for sender in self.senders {
            // Nobody may be waiting any more.
            let _ = sender.send(outcome.clone());
        }
    }
}

pub(super) struct Underway {
    tiles: HashMap<Fingerprint, Tile>,
    queue: Queue,
    /// Tiles that are being evaluated, also those that nobody wants any more, and what they were predicted to cost.
    running: usize,
    running_ns: f64,
    /// Measured over predicted time of late.
    pace: f64,
    threads: usize,
    last_number: u64,
}

impl Underway {
    pub(super) fn new(threads: usize) -> Self {
        Self { tiles: HashMap::new(), queue: Queue::default(), running: 0, running_ns: 0.0, pace: 1.0, threads, last_number: 0 }
    }

    pub(super) fn running(&self) -> usize {
        self.running
    }

    pub(super) fn has(&self, fingerprint: &Fingerprint) -> bool {
        self.tiles.contains_key(fingerprint)
    }

    pub(super) fn waiting(&self, class: Class) -> usize {
        self.queue.waiting(class)
    }

    /// One more who waits for a tile, which becomes as urgent as the most urgent of them wants it.
    pub(super) fn join(&mut self, fingerprint: &Fingerprint, class: Class) -> Option<(u64, oneshot::Receiver<Outcome>)> {
        let tile = self.tiles.get_mut(fingerprint)?;
        let (sender, receiver) = oneshot::channel();
        tile.senders.push(sender);
        tile.waiters += 1;
        if let Some((order, _, since)) = &mut tile.waiting
            && class < order.class
        {
            self.queue.remove(order.class, fingerprint);
            order.class = class;
            self.queue.push(class, *fingerprint, order.cost_ns, *since);
        }
        Some((tile.number, receiver))
    }

    /// Whether a new tile would have its turn in time.
    pub(super) fn admits(&self, class: Class, patience: Duration) -> bool {
        let ahead_ns = (self.queue.ahead_ns(class) + self.running_ns) * self.pace / self.threads as f64;
        self.queue.waiting(class) < ALWAYS || ahead_ns <= patience.as_nanos() as f64
    }

    pub(super) fn begin(&mut self, order: Order, make: Make, now: Instant) -> (u64, oneshot::Receiver<Outcome>) {
        self.last_number += 1;
        let (number, fingerprint) = (self.last_number, order.fingerprint);
        let (sender, receiver) = oneshot::channel();
        self.queue.push(order.class, fingerprint, order.cost_ns, now);
        let tile = Tile { number, senders: vec![sender], waiters: 1, stop: Stop::new(), waiting: Some((order, make, now)) };
        self.tiles.insert(fingerprint, tile);
        (number, receiver)
    }

    /// The tile whose turn it is, and how many were told that it took too long.
    pub(super) fn next(&mut self, now: Instant, patience: Duration) -> (Option<Job>, u64) {
        let Taken { next, expired } = self.queue.take(now, patience);
        for fingerprint in &expired {
            if let Some(tile) = self.tiles.remove(fingerprint) {
                tile.answer(&Err(TileFailure::Overloaded));
            }
        }
        let job = next.and_then(|fingerprint| {
            let tile = self.tiles.get_mut(&fingerprint)?;
            let (order, make, since) = tile.waiting.take()?;
            self.running += 1;
            self.running_ns += order.cost_ns;
            Some(Job { fingerprint, number: tile.number, order, make, stop: tile.stop.clone(), queued: now.saturating_duration_since(since) })
        });
        (job, expired.len() as u64)
    }

    /// An evaluation has ended; those who still wait are told.
    pub(super) fn finish(&mut self, fingerprint: &Fingerprint, number: u64, (cost_ns, measured_ns): (f64, Option<f64>), outcome: &Outcome) {
        self.running -= 1;
        self.running_ns = if self.running == 0 { 0.0 } else { self.running_ns - cost_ns };
        if let Some(measured_ns) = measured_ns
            && cost_ns > 0.0
        {
            self.pace += NEW * ((measured_ns / cost_ns).clamp(PACES[0], PACES[1]) - self.pace);
        }
        if self.tiles.get(fingerprint).is_some_and(|tile| tile.number == number)
            && let Some(tile) = self.tiles.remove(fingerprint)
        {
            tile.answer(outcome);
        }
    }

    /// One who waited has gone. When it was the last, the tile is given up, and its state is answered.
    pub(super) fn leave(&mut self, fingerprint: &Fingerprint, number: u64) -> Option<&'static str> {
        let tile = self.tiles.get_mut(fingerprint).filter(|tile| tile.number == number)?;
        tile.waiters -= 1;
        if tile.waiters > 0 {
            return None;
        }
        let tile = self.tiles.remove(fingerprint)?;
        tile.stop.set();
        let Some((order, ..)) = tile.waiting else { return Some("running") };
        self.queue.remove(order.class, fingerprint);
        Some("waiting")
    }
}
