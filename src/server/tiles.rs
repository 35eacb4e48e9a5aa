//! Tiles from memory or from the compute pool: identical concurrent requests evaluate once.

use super::compute::{Compute, Panicked};
use crate::{tile::TileError, world::Fingerprint};
use axum::body::Bytes;
use futures_util::{FutureExt, future::Shared};
use quick_cache::{Weighter, sync::Cache};
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
type Pending = HashMap<Fingerprint, Shared<oneshot::Receiver<Outcome>>>;

/// The tile service: a byte-bounded cache before a pool of threads.
pub(super) struct Tiles {
    shared: Arc<SharedTiles>,
    compute: Arc<Compute>,
    pending_limit: usize,
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

    /// Hands the outcome of an evaluation to the cache and to all who wait.
    fn finish(&self, fingerprint: Fingerprint, made: Result<Result<Vec<u8>, TileError>, Panicked>, to: oneshot::Sender<Outcome>) {
        let outcome = match made {
            Ok(Ok(bytes)) => Ok(Bytes::from(bytes)),
            Ok(Err(error)) => {
                tracing::error!(%error, "a tile failed");
                Err(TileFailure::Failed)
            }
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
    pub(super) fn new(compute: Arc<Compute>, cache_bytes: u64, pending_limit: usize) -> Self {
        let typical_bytes = 64 * 1024;
        let cache = Cache::with_weighter((cache_bytes / typical_bytes).max(16) as usize, cache_bytes, ByBytes);
        let shared = SharedTiles { cache, pending: Mutex::default(), evaluations: AtomicU64::new(0) };
        Self { shared: Arc::new(shared), compute, pending_limit }
    }

    /// The tile of a fingerprint: cached, under way, or made now.
    ///
    /// The evaluation is a task of its own, so a caller that goes away takes nothing from others that wait.
    pub(super) async fn get(&self, fingerprint: Fingerprint, make: impl FnOnce() -> Result<Vec<u8>, TileError> + Send + 'static) -> Outcome {
        if let Some(bytes) = self.shared.cache.get(&fingerprint) {
            return Ok(bytes);
        }
        let waiting = self.start(fingerprint, make)?;
        waiting.await.unwrap_or(Err(TileFailure::Failed))
    }

    fn start(
        &self,
        fingerprint: Fingerprint,
        make: impl FnOnce() -> Result<Vec<u8>, TileError> + Send + 'static,
    ) -> Result<Shared<oneshot::Receiver<Outcome>>, TileFailure> {
        let mut pending = self.shared.pending();
        if let Some(waiting) = pending.get(&fingerprint) {
            return Ok(waiting.clone());
        }
        let (sender, receiver) = oneshot::channel();
        let receiver = receiver.shared();
        // It may have been finished since the cache was asked.
        if let Some(bytes) = self.shared.cache.get(&fingerprint) {
            let _ = sender.send(Ok(bytes));
            return Ok(receiver);
        }
        if pending.len() >= self.pending_limit {
            return Err(TileFailure::Overloaded);
        }
        pending.insert(fingerprint, receiver.clone());
        let shared = Arc::clone(&self.shared);
        shared.evaluations.fetch_add(1, Ordering::Relaxed);
        self.compute.spawn(make, move |made| shared.finish(fingerprint, made, sender));
        Ok(receiver)
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
        geometry::{Filter, Grid, Samples, Tile},
        world::{Document, World},
    };
    use std::{sync::mpsc, time::Duration};

    fn tiles(threads: usize, pending_limit: usize) -> Tiles {
        Tiles::new(Arc::new(Compute::new(threads).expect("threads")), 1 << 20, pending_limit)
    }

    fn fingerprint(x: i64) -> Fingerprint {
        let document = Document::parse(br#"{"seed":1,"base":{"programme":"x","scale":1}}"#).expect("valid");
        World::new(document).fingerprint("test", Grid::Web, Tile { z: 9, x, y: 0 }, Samples::Centres(256), Filter::Band)
    }

    #[tokio::test]
    async fn identical_concurrent_requests_evaluate_once() {
        let tiles = tiles(2, 10);
        let (open, gate) = mpsc::channel::<()>();
        let gate = Arc::new(Mutex::new(gate));
        let requests = (0..50).map(|_| {
            let gate = Arc::clone(&gate);
            tiles.get(fingerprint(1), move || {
                gate.lock().expect("the gate").recv_timeout(Duration::from_secs(10)).expect("opened");
                Ok(vec![7; 100])
            })
        });
        let all = futures_util::future::join_all(requests);
        let (results, ()) = tokio::join!(all, async { open.send(()).expect("somebody waits") });
        assert!(results.iter().all(|result| result.as_ref().is_ok_and(|bytes| bytes[..] == [7; 100])));
        assert_eq!(tiles.evaluations(), 1);
        assert_eq!(tiles.get(fingerprint(1), || Ok(Vec::new())).await.expect("cached").len(), 100);
    }

    #[tokio::test]
    async fn a_caller_that_leaves_takes_nothing_with_it() {
        let tiles = tiles(1, 10);
        let (open, gate) = mpsc::channel::<()>();
        let first = tiles.get(fingerprint(2), move || {
            gate.recv_timeout(Duration::from_secs(10)).expect("opened");
            Ok(vec![1])
        });
        assert!(tokio::time::timeout(Duration::from_millis(20), first).await.is_err());
        open.send(()).expect("still under way");
        assert_eq!(tiles.get(fingerprint(2), || Ok(vec![2])).await.expect("made")[..], [1]);
        assert_eq!(tiles.evaluations(), 1);
    }

    #[tokio::test]
    async fn panics_are_caught_and_full_queues_refuse() {
        let tiles = tiles(1, 1);
        assert_eq!(tiles.get(fingerprint(3), || panic!("on purpose")).await, Err(TileFailure::Failed));
        let (open, gate) = mpsc::channel::<()>();
        let slow = tiles.get(fingerprint(4), move || {
            gate.recv_timeout(Duration::from_secs(10)).expect("opened");
            Ok(Vec::new())
        });
        let (slow, refused) = tokio::join!(slow, async {
            let refused = tiles.get(fingerprint(5), || Ok(Vec::new())).await;
            open.send(()).expect("somebody waits");
            refused
        });
        assert_eq!((slow.map(|bytes| bytes.len()), refused), (Ok(0), Err(TileFailure::Overloaded)));
    }
}
