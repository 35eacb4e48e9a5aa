//! Tiles from memory or from the compute pool: identical concurrent requests evaluate once, urgent ones first, and what nobody waits for any more is given up.

mod disk;
mod failures;
mod queue;
#[cfg(test)]
mod tests;
mod underway;

use super::{
    compute::{Compute, Panicked, caught},
    metrics::Metrics,
};
use crate::{
    geometry::Stop,
    tile::TileError,
    world::{Fingerprint, Revision},
};
use axum::body::Bytes;
use disk::Disk;
pub(super) use disk::DiskError;
use failures::Failures;
pub(super) use queue::Class;
use quick_cache::{
    DefaultHashBuilder, OptionsBuilder, Weighter,
    sync::{Cache, DefaultLifecycle},
};
use std::{
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};
use tokio::sync::oneshot;
use underway::{Job, Underway};

/// What a cached tile costs beside its bytes.
const OVERHEAD_BYTES: u64 = 128;

/// The largest tile: 1025 × 1025 samples of 4 bytes.
const LARGEST_TILE_BYTES: u64 = 1025 * 1025 * 4 + OVERHEAD_BYTES;

/// A shard takes no item near its own size, so it has room for several of the largest tiles.
const SHARD_BYTES: u64 = 8 * LARGEST_TILE_BYTES;

/// What a typical tile costs, for the cache's first sizes.
pub(super) const TYPICAL_BYTES: u64 = 64 * 1024;

/// Why a tile could not be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TileFailure {
    /// More tiles wait than the server takes.
    Overloaded,
    /// The evaluation failed; it was logged.
    Failed,
    /// Evaluations of this revision have failed so often that it is not tried again.
    SetAside,
}

/// A tile that is wanted.
#[derive(Clone, Debug)]
pub(super) struct Order {
    pub fingerprint: Fingerprint,
    /// Of what is evaluated.
    pub revision: Revision,
    pub class: Class,
    /// Predicted nanoseconds of its evaluation.
    pub cost_ns: f64,
    /// What it is, for the metrics: tileset and kind of source.
    pub kind: [&'static str; 2],
}

/// A tile, and how long it took where it was evaluated.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Made {
    pub bytes: Bytes,
    pub timing: Option<Timing>,
}

/// How long a tile waited for a thread, and how long its evaluation took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Timing {
    pub queued: Duration,
    pub evaluated: Duration,
}

type Outcome = Result<Made, TileFailure>;

#[derive(Clone)]
struct ByBytes;

impl Weighter<Fingerprint, Bytes> for ByBytes {
    fn weight(&self, _: &Fingerprint, tile: &Bytes) -> u64 {
        tile.len() as u64 + OVERHEAD_BYTES
    }
}

/// The tile service: a byte-bounded cache before a queue before a pool of threads.
pub(super) struct Tiles {
    shared: Arc<Shared>,
    compute: Compute,
}

struct Shared {
    cache: Cache<Fingerprint, Bytes, ByBytes>,
    disk: Option<Disk>,
    underway: Mutex<Underway>,
    failures: Failures,
    metrics: Arc<Metrics>,
    /// How long a tile may wait behind others.
    patience: Duration,
}

impl Shared {
    fn underway(&self) -> MutexGuard<'_, Underway> {
        // It is whole at every point where a holder could panic.
        self.underway.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Evaluates what is next, if anybody still waits for anything.
    fn work(&self) {
        let Some(Job { fingerprint, number, order, make, stop, queued }) = self.next() else { return };
        let begun = Instant::now();
        let made = caught(|| make(&stop));
        let evaluated = begun.elapsed();
        let is_stopped = stop.is_set();
        let outcome = match made {
            _ if is_stopped => Err(TileFailure::Failed),
            Ok(Ok(bytes)) => Ok(Made { bytes: bytes.into(), timing: Some(Timing { queued, evaluated }) }),
            Ok(Err(error)) => {
                tracing::error!(%error, revision = %order.revision, "a tile failed");
                Err(TileFailure::Failed)
            }
            Err(Panicked) => {
                self.metrics.panicked("evaluation");
                self.failures.add(&order.revision);
                Err(TileFailure::Failed)
            }
        };
        if let Ok(made) = &outcome {
            self.metrics.evaluated(&order, queued, evaluated);
            self.cache.insert(fingerprint, made.bytes.clone());
            if let Some(disk) = &self.disk {
                disk.put(&fingerprint, made.bytes.clone());
            }
        }
        let measured_ns = outcome.is_ok().then_some(evaluated.as_nanos() as f64);
        self.underway().finish(&fingerprint, number, (order.cost_ns, measured_ns), &outcome);
    }

    fn next(&self) -> Option<Job> {
        let (job, expired) = self.underway().next(Instant::now(), self.patience);
        self.metrics.refused("expired", expired);
        job
    }
}

/// Somebody who waits for a tile; when the last one goes, the tile is given up.
struct Waiter {
    shared: Arc<Shared>,
    receiver: oneshot::Receiver<Outcome>,
    fingerprint: Fingerprint,
    number: u64,
    is_served: bool,
}

impl Drop for Waiter {
    fn drop(&mut self) {
        if !self.is_served
            && let Some(state) = self.shared.underway().leave(&self.fingerprint, self.number)
        {
            self.shared.metrics.cancelled(state);
        }
    }
}

impl Tiles {
    /// `queue_ms` is how long a tile may wait for a thread.
    pub(super) fn new(compute: Compute, metrics: Arc<Metrics>, cache_bytes: u64, queue_ms: u64) -> Self {
        let shards = (cache_bytes / SHARD_BYTES).clamp(1, 64) as usize;
        let options = OptionsBuilder::new()
            .shards(if shards.is_power_of_two() { shards } else { shards.next_power_of_two() / 2 })
            .estimated_items_capacity((cache_bytes / TYPICAL_BYTES).max(16) as usize)
            .weight_capacity(cache_bytes)
            .build()
            .expect("both capacities are given");
        let cache = Cache::with_options(options, ByBytes, DefaultHashBuilder::default(), DefaultLifecycle::default());
        let underway = Mutex::new(Underway::new(compute.threads()));
        let shared = Shared { cache, disk: None, underway, failures: Failures::new(), metrics, patience: Duration::from_millis(queue_ms) };
        Self { shared: Arc::new(shared), compute }
    }

    /// Lets tiles be kept on disk, too, in a folder of its own; where that is full, they are not.
    pub(super) async fn keep_on_disk(&mut self, folder: &Path, bytes: u64) -> Result<(), DiskError> {
        let shared = Arc::get_mut(&mut self.shared).expect("nothing is made yet");
        shared.disk = Some(Disk::open(folder, bytes).await?);
        Ok(())
    }

    /// The tile of a fingerprint, if it is in memory; the metrics do not count that.
    pub(super) fn in_memory(&self, fingerprint: &Fingerprint) -> Option<Bytes> {
        self.shared.cache.get(fingerprint)
    }

    /// The tile of a fingerprint, if it is at hand: in memory or on disk.
    pub(super) async fn cached(&self, fingerprint: &Fingerprint) -> Option<Bytes> {
        let Shared { cache, disk, metrics, .. } = &*self.shared;
        if let Some(tile) = cache.get(fingerprint) {
            metrics.looked_up("hit");
            return Some(tile);
        }
        let tile = disk.as_ref()?.get(fingerprint).await?;
        metrics.looked_up("disk");
        cache.insert(*fingerprint, tile.clone());
        Some(tile)
    }

    /// Finishes what is being written.
    pub(super) async fn close(&self) {
        if let Some(disk) = &self.shared.disk {
            disk.close().await;
        }
    }

    /// Whether a tile that is not at hand would be refused: what is asked before anything is predicted of it, as it has to cost next to nothing.
    pub(super) fn refuses(&self, fingerprint: &Fingerprint, class: Class) -> bool {
        let underway = self.shared.underway();
        let is_refused = !underway.has(fingerprint) && !underway.admits(class, self.shared.patience);
        drop(underway);
        if is_refused {
            self.shared.metrics.refused("queue", 1);
        }
        is_refused
    }

    /// A tile that is not at hand: under way, or made now. It is made by a task of its own, which others may wait for too; it is given up when all who wait have
    /// gone, at the next row if it has begun.
    pub(super) async fn get(&self, order: Order, make: impl FnOnce(&Stop) -> Result<Vec<u8>, TileError> + Send + 'static) -> Outcome {
        let mut waiter = match self.start(order, make)? {
            Started::Made(bytes) => return Ok(Made { bytes, timing: None }),
            Started::Waits(waiter) => waiter,
        };
        let outcome = (&mut waiter.receiver).await.unwrap_or(Err(TileFailure::Failed));
        waiter.is_served = true;
        outcome
    }

    fn start(&self, order: Order, make: impl FnOnce(&Stop) -> Result<Vec<u8>, TileError> + Send + 'static) -> Result<Started, TileFailure> {
        let shared = &self.shared;
        let (fingerprint, class) = (order.fingerprint, order.class);
        let waits = |(number, receiver)| Started::Waits(Waiter { shared: Arc::clone(shared), receiver, fingerprint, number, is_served: false });
        let mut underway = shared.underway();
        if let Some(joined) = underway.join(&fingerprint, class) {
            shared.metrics.looked_up("joined");
            return Ok(waits(joined));
        }
        // It may have been finished since the cache was asked.
        if let Some(bytes) = shared.cache.get(&fingerprint) {
            shared.metrics.looked_up("hit");
            return Ok(Started::Made(bytes));
        }
        if shared.failures.is_set_aside(&order.revision) {
            shared.metrics.refused("set-aside", 1);
            return Err(TileFailure::SetAside);
        }
        if !underway.admits(class, shared.patience) {
            shared.metrics.refused("queue", 1);
            return Err(TileFailure::Overloaded);
        }
        shared.metrics.looked_up("miss");
        let waiter = waits(underway.begin(order, Box::new(make), Instant::now()));
        drop(underway);
        let worker = Arc::clone(shared);
        self.compute.spawn(move || worker.work());
        Ok(waiter)
    }

    /// How many tiles are being evaluated, and how many of each class wait.
    pub(super) fn load(&self) -> (usize, [usize; 2]) {
        let underway = self.shared.underway();
        (underway.running(), Class::ALL.map(|class| underway.waiting(class)))
    }

    /// How many tiles the cache holds, and their bytes.
    pub(super) fn held(&self) -> (usize, u64) {
        (self.shared.cache.len(), self.shared.cache.weight())
    }
}

enum Started {
    Made(Bytes),
    Waits(Waiter),
}
