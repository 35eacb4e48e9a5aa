//! Tiles from memory or from the compute pool: identical concurrent requests evaluate once.

use super::compute::{Compute, Panicked};
use crate::{tile::TileError, world::Fingerprint};
use axum::body::Bytes;
use futures_util::{FutureExt, future::Shared};
use quick_cache::{
    DefaultHashBuilder, OptionsBuilder, Weighter,
    sync::{Cache, DefaultLifecycle},
};
use std::{
    collections::HashMap,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};
use tokio::sync::oneshot;

/// What a cached tile costs beside its bytes.
const OVERHEAD_BYTES: u64 = 128;

/// The largest tile: 1025 × 1025 samples of 4 bytes.
const LARGEST_TILE_BYTES: u64 = 1025 * 1025 * 4 + OVERHEAD_BYTES;

/// A shard takes no item near its own size, so it has room for several of the largest tiles.
const SHARD_BYTES: u64 = 8 * LARGEST_TILE_BYTES;

/// What a typical tile costs, for the cache's first sizes.
const TYPICAL_BYTES: u64 = 64 * 1024;

/// Why a tile could not be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TileFailure {
    /// More tiles wait than the server takes.
    Overloaded,
    /// The evaluation failed; it was logged.
    Failed,
}

#[derive(Clone)]
struct ByBytes;

impl Weighter<Fingerprint, Bytes> for ByBytes {
    fn weight(&self, _: &Fingerprint, tile: &Bytes) -> u64 {
        tile.len() as u64 + OVERHEAD_BYTES
    }
}

type Outcome = Result<Bytes, TileFailure>;

/// A tile under way.
struct Waiting {
    outcome: Shared<oneshot::Receiver<Outcome>>,
    /// Predicted nanoseconds of its evaluation.
    cost_ns: f64,
}

/// The tiles under way and what they cost together.
#[derive(Default)]
struct Pending {
    tiles: HashMap<Fingerprint, Waiting>,
    cost_ns: f64,
}

impl Pending {
    fn remove(&mut self, fingerprint: &Fingerprint) {
        if let Some(waiting) = self.tiles.remove(fingerprint) {
            self.cost_ns = if self.tiles.is_empty() { 0.0 } else { self.cost_ns - waiting.cost_ns };
        }
    }
}

/// The tile service: a byte-bounded cache before a pool of threads.
pub(super) struct Tiles {
    shared: Arc<SharedTiles>,
    compute: Compute,
    /// Predicted nanoseconds that may wait.
    pending_limit_ns: f64,
}

struct SharedTiles {
    cache: Cache<Fingerprint, Bytes, ByBytes>,
    pending: Mutex<Pending>,
    evaluations: AtomicU64,
}

impl SharedTiles {
    fn pending(&self) -> std::sync::MutexGuard<'_, Pending> {
        // The map is whole at every point where a holder could panic.
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether somebody still waits for a tile whose turn has come; if nobody does, it is no longer under way.
    fn begin(&self, fingerprint: &Fingerprint) -> bool {
        let mut pending = self.pending();
        // The map's own is one of them; others are cloned from it under the same lock.
        let awaited = pending.tiles.get(fingerprint).is_some_and(|waiting| waiting.outcome.strong_count().is_some_and(|count| count > 1));
        if awaited {
            self.evaluations.fetch_add(1, Ordering::Relaxed);
        } else {
            pending.remove(fingerprint);
        }
        awaited
    }

    /// Hands the outcome of an evaluation to the cache and to all who wait; `None` was left out.
    fn finish(&self, fingerprint: Fingerprint, made: Result<Option<Result<Vec<u8>, TileError>>, Panicked>, to: oneshot::Sender<Outcome>) {
        let outcome = match made {
            Ok(Some(Ok(bytes))) => Ok(Bytes::from(bytes)),
            Ok(Some(Err(error))) => {
                tracing::error!(%error, "a tile failed");
                Err(TileFailure::Failed)
            }
            Ok(None) => return,
            Err(Panicked) => Err(TileFailure::Failed),
        };
        if let Ok(bytes) = &outcome {
            self.cache.insert(fingerprint, bytes.clone());
        }
        self.pending().remove(&fingerprint);
        // Nobody may be waiting any more.
        let _ = to.send(outcome);
    }
}

impl Tiles {
    pub(super) fn new(compute: Compute, cache_bytes: u64, pending_limit_ns: f64) -> Self {
        let shards = (cache_bytes / SHARD_BYTES).clamp(1, 64) as usize;
        let options = OptionsBuilder::new()
            .shards(if shards.is_power_of_two() { shards } else { shards.next_power_of_two() / 2 })
            .estimated_items_capacity((cache_bytes / TYPICAL_BYTES).max(16) as usize)
            .weight_capacity(cache_bytes)
            .build()
            .expect("both capacities are given");
        let cache = Cache::with_options(options, ByBytes, DefaultHashBuilder::default(), DefaultLifecycle::default());
        let shared = SharedTiles { cache, pending: Mutex::default(), evaluations: AtomicU64::new(0) };
        Self { shared: Arc::new(shared), compute, pending_limit_ns }
    }

    /// The tile of a fingerprint, if it is at hand.
    pub(super) fn cached(&self, fingerprint: &Fingerprint) -> Option<Bytes> {
        self.shared.cache.get(fingerprint)
    }

    /// The tile of a fingerprint: cached, under way, or made now at a predicted cost.
    ///
    /// The evaluation is a task of its own, so a caller that goes away takes nothing from others that wait. When all have gone before it begins, it is left out.
    pub(super) async fn get(&self, fingerprint: Fingerprint, cost_ns: f64, make: impl FnOnce() -> Result<Vec<u8>, TileError> + Send + 'static) -> Outcome {
        if let Some(bytes) = self.cached(&fingerprint) {
            return Ok(bytes);
        }
        let waiting = self.start(fingerprint, cost_ns, make)?;
        waiting.await.unwrap_or(Err(TileFailure::Failed))
    }

    fn start(
        &self,
        fingerprint: Fingerprint,
        cost_ns: f64,
        make: impl FnOnce() -> Result<Vec<u8>, TileError> + Send + 'static,
    ) -> Result<Shared<oneshot::Receiver<Outcome>>, TileFailure> {
        let mut pending = self.shared.pending();
        if let Some(waiting) = pending.tiles.get(&fingerprint) {
            return Ok(waiting.outcome.clone());
        }
        let (sender, receiver) = oneshot::channel();
        let outcome = receiver.shared();
        // It may have been finished since the cache was asked.
        if let Some(bytes) = self.shared.cache.get(&fingerprint) {
            let _ = sender.send(Ok(bytes));
            return Ok(outcome);
        }
        // A tile may cost more than the limit, but not wait behind others then.
        if !pending.tiles.is_empty() && pending.cost_ns + cost_ns > self.pending_limit_ns {
            return Err(TileFailure::Overloaded);
        }
        pending.tiles.insert(fingerprint, Waiting { outcome: outcome.clone(), cost_ns });
        pending.cost_ns += cost_ns;
        let (before, after) = (Arc::clone(&self.shared), Arc::clone(&self.shared));
        let task = move || before.begin(&fingerprint).then(make);
        self.compute.spawn(task, move |made| after.finish(fingerprint, made, sender));
        Ok(outcome)
    }

    /// How many tiles were evaluated since the start.
    pub(super) fn evaluations(&self) -> u64 {
        self.shared.evaluations.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::{Filter, Grid, Rectangle, Samples, Tile},
        world::{Document, World},
    };
    use std::{sync::mpsc, time::Duration};

    /// A service that lets `pending_limit` tiles of cost 1 wait.
    fn tiles(threads: usize, pending_limit: usize) -> Tiles {
        Tiles::new(Compute::new("test", threads).expect("threads"), 1 << 26, pending_limit as f64)
    }

    fn fingerprint(x: i64) -> Fingerprint {
        let document = Document::parse(br#"{"seed":1,"base":{"programme":"x","scale":1}}"#).expect("valid");
        World::new(document).fingerprint("test", &Rectangle::EMPTY, Grid::Web, Tile { z: 9, x, y: 0 }, Samples::Centres(256), Filter::Band)
    }

    #[tokio::test]
    async fn identical_concurrent_requests_evaluate_once() {
        let tiles = tiles(2, 10);
        let (open, gate) = mpsc::channel::<()>();
        let gate = Arc::new(Mutex::new(gate));
        let requests = (0..50).map(|_| {
            let gate = Arc::clone(&gate);
            tiles.get(fingerprint(1), 1.0, move || {
                gate.lock().expect("the gate").recv_timeout(Duration::from_secs(10)).expect("opened");
                Ok(vec![7; 100])
            })
        });
        let all = futures_util::future::join_all(requests);
        let (results, ()) = tokio::join!(all, async { open.send(()).expect("somebody waits") });
        assert!(results.iter().all(|result| result.as_ref().is_ok_and(|bytes| bytes[..] == [7; 100])));
        assert_eq!(tiles.evaluations(), 1);
        assert_eq!(tiles.get(fingerprint(1), 1.0, || Ok(Vec::new())).await.expect("cached").len(), 100);
    }

    /// One leaves a tile that is being evaluated, one a tile that still waits for its turn; others want both.
    #[tokio::test]
    async fn a_caller_that_leaves_takes_nothing_from_others() {
        let tiles = tiles(1, 10);
        let (open, gate) = mpsc::channel::<()>();
        let (begins, begun) = oneshot::channel();
        let mut running = Box::pin(tiles.get(fingerprint(2), 1.0, move || {
            begins.send(()).expect("the test waits");
            gate.recv_timeout(Duration::from_secs(10)).expect("opened");
            Ok(vec![1])
        }));
        tokio::select! {
            _ = &mut running => panic!("the gate is closed"),
            begun = begun => begun.expect("it begins"),
        }
        let mut queued = Box::pin(tiles.get(fingerprint(10), 1.0, || Ok(vec![10])));
        let mut other = Box::pin(tiles.get(fingerprint(10), 1.0, || Ok(vec![11])));
        assert!((&mut queued).now_or_never().is_none() && (&mut other).now_or_never().is_none());
        drop((running, queued));
        let late = tiles.get(fingerprint(2), 1.0, || Ok(vec![2]));
        open.send(()).expect("still under way");
        let (late, other) = tokio::join!(late, other);
        assert_eq!((&late.expect("made")[..], &other.expect("made")[..]), (&[1][..], &[10][..]));
        assert_eq!(tiles.evaluations(), 2);
    }

    #[tokio::test]
    async fn a_tile_that_nobody_waits_for_is_left_out() {
        let tiles = tiles(1, 10);
        let (open, gate) = mpsc::channel::<()>();
        let busy = tiles.get(fingerprint(6), 1.0, move || {
            gate.recv_timeout(Duration::from_secs(10)).expect("opened");
            Ok(Vec::new())
        });
        let deserted = async {
            let deserted = tiles.get(fingerprint(7), 1.0, || Ok(vec![7]));
            assert!(tokio::time::timeout(Duration::from_millis(20), deserted).await.is_err());
            open.send(()).expect("somebody waits");
        };
        let (busy, ()) = tokio::join!(busy, deserted);
        assert!(busy.is_ok());
        assert_eq!(tiles.get(fingerprint(8), 1.0, || Ok(vec![8])).await.expect("made")[..], [8]);
        assert_eq!(tiles.evaluations(), 2, "6 and 8");
        assert_eq!(tiles.get(fingerprint(7), 1.0, || Ok(vec![9])).await.expect("made after all")[..], [9]);
    }

    #[tokio::test]
    async fn the_largest_tile_is_cached_on_a_machine_with_many_cores() {
        let tiles = Tiles::new(Compute::new("test", 1).expect("threads"), 1 << 28, 1.0);
        let large = || Ok(vec![0; 1025 * 1025 * 4]);
        for _ in 0..2 {
            tiles.get(fingerprint(9), 1.0, large).await.expect("made");
        }
        assert_eq!(tiles.evaluations(), 1);
    }

    #[tokio::test]
    async fn panics_are_caught_and_full_queues_refuse() {
        let tiles = tiles(1, 1);
        assert_eq!(tiles.get(fingerprint(3), 1.0, || panic!("on purpose")).await, Err(TileFailure::Failed));
        let (open, gate) = mpsc::channel::<()>();
        let slow = tiles.get(fingerprint(4), 1.0, move || {
            gate.recv_timeout(Duration::from_secs(10)).expect("opened");
            Ok(Vec::new())
        });
        let (slow, refused) = tokio::join!(slow, async {
            let refused = tiles.get(fingerprint(5), 1.0, || Ok(Vec::new())).await;
            open.send(()).expect("somebody waits");
            refused
        });
        assert_eq!((slow.map(|bytes| bytes.len()), refused), (Ok(0), Err(TileFailure::Overloaded)));
    }
}
