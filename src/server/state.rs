//! What all handlers share.

use super::{
    access::Keys,
    adaptive::Feeding,
    breeding::{self, Breeding},
    budget::Budgets,
    compute::Compute,
    config::{Config, Reads},
    editing::Editing,
    events::Events,
    exports::Exports,
    jobs::Jobs,
    library::{self, Shown},
    metrics::Metrics,
    parts::StoredParts,
    players::Players,
    recall::Recall,
    shelf::{LoadError, Shelf},
    tiles::{DiskError, Tiles},
    worlds::Worlds,
};
use crate::store::Store;
use std::{
    num::NonZeroUsize,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

/// A server's state.
#[derive(Clone)]
pub struct App(pub(super) Arc<AppState>);

pub(super) struct AppState {
    pub worlds: Worlds,
    pub library: Shelf<Shown>,
    pub breeding: Shelf<Breeding>,
    pub tiles: Tiles,
    pub recall: Recall,
    pub metrics: Arc<Metrics>,
    pub exports: Exports,
    pub jobs: Jobs,
    pub parts: Arc<StoredParts>,
    /// Threads for single points and first looks at worlds, so that these do not wait behind tiles.
    pub queries: Arc<Compute>,
    /// Without a slash at its end; empty: from each request's Host header.
    pub public_url: String,
    pub world_bytes: usize,
    pub feature_bytes: usize,
    pub editing: Editing,
    pub adaptive: Feeding,
    pub players: Players,
    pub events: Arc<Events>,
    pub keys: Keys,
    pub budgets: Budgets,
    pub proxies: usize,
    pub reads: Reads,
    /// Whether no other machine is meant to reach the server: then its own may write without a key.
    pub is_local: bool,
    pub store: Store,
    draining: AtomicBool,
}

/// Why a server cannot start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The worlds or the programmes cannot be loaded.
    #[error("loading worlds and programmes: {0}")]
    Load(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// The disk cannot hold tiles.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The compute threads cannot be started.
    #[error("starting threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The address cannot be listened on.
    #[error("listening on {address}: {source}")]
    Listen {
        /// The address.
        address: std::net::SocketAddr,
        /// What the system said.
        source: std::io::Error,
    },
}

impl App {
    /// Opens the store and loads every world and the programme library.
    ///
    /// # Errors
    /// If the store cannot be opened or holds what this version cannot read, or threads cannot be started.
    pub async fn load(config: &Config) -> Result<Self, StartError> {
        let load = |error: LoadError| StartError::Load(Box::new(error));
        let compute = Compute::new("tile", config.server.threads)?;
        let queries = Arc::new(Compute::new("query", config.server.threads)?);
        let metrics = Arc::new(Metrics::new());
        let exports = Exports::new(Compute::new("export", config.server.threads)?, &config.limits);
        let store = Store::open(&config.server.data).await.map_err(|error| load(error.into()))?;
        let old_revisions = NonZeroUsize::new(config.cache.old_revisions).unwrap_or(NonZeroUsize::MIN);
        let parts = Arc::new(StoredParts::new(store.clone()));
        let events = Arc::new(Events::new());
        let worlds = Worlds::load(store.clone(), Arc::clone(&queries), Arc::clone(&parts), &events, old_revisions).await.map_err(load)?;
        let library = library::load(store.clone(), Arc::clone(&queries), Arc::clone(&parts), &events).await.map_err(load)?;
        let jobs = Compute::last("job", config.server.threads)?;
        let jobs = Jobs::load(store.clone(), jobs, &events, config.limits.jobs).await.map_err(|error| load(error.into()))?;
        let breeding = breeding::load(store.clone(), Arc::clone(&queries), Arc::clone(&parts), &events).await.map_err(load)?;
        let mut tiles = Tiles::new(compute, Arc::clone(&metrics), config.cache.tile_bytes, config.limits.queue_ms);
        if config.cache.disk_bytes > 0 {
            tiles.keep_on_disk(&config.server.data.join("tile-cache"), config.cache.disk_bytes).await?;
        }
        Ok(Self(Arc::new(AppState {
            worlds,
            library,
            breeding,
            tiles,
            recall: Recall::new(config.cache.tile_bytes),
            metrics,
            exports,
            jobs,
            parts,
            queries,
            public_url: config.server.public_url.trim_end_matches('/').to_owned(),
            world_bytes: config.limits.world_bytes,
            feature_bytes: config.limits.feature_bytes,
            editing: Editing::new(),
            adaptive: Feeding::new(),
            players: Players::default(),
            events,
            keys: Keys::load(store.clone()).await.map_err(|error| load(error.into()))?,
            budgets: Budgets::new(&config.limits),
            proxies: config.server.proxies,
            reads: config.server.reads,
            is_local: config.server.listen.ip().is_loopback() && config.server.public_url.is_empty(),
            store,
            draining: AtomicBool::new(false),
        })))
    }

    /// How many tiles were evaluated since the start.
    #[must_use]
    pub fn evaluations(&self) -> u64 {
        self.0.metrics.evaluations()
    }

    /// How many parts of exports were evaluated since the start.
    #[must_use]
    pub fn export_parts(&self) -> u64 {
        self.0.exports.evaluations()
    }

    /// Says from now on that no new requests should come.
    pub fn drain(&self) {
        self.0.draining.store(true, Ordering::Relaxed);
        self.0.events.close();
    }

    pub(super) fn is_draining(&self) -> bool {
        self.0.draining.load(Ordering::Relaxed)
    }

    /// Ends jobs under way, which the next start takes up again, and closes the store and the disk cache.
    pub async fn close(&self) {
        self.0.jobs.close().await;
        self.0.tiles.close().await;
        self.0.store.close().await;
    }
}
