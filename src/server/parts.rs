//! Stored sets of features and rasters, read once for all documents that name them.

use super::{compute::Compute, shelf::LoadError};
use crate::{
    evolve::Generation,
    geometry::Raster,
    layout::geojson::FeatureSet,
    store::Store,
    world::{PartNames, Parts},
};
use lru::LruCache;
use std::{
    num::NonZeroUsize,
    sync::{Arc, Mutex, PoisonError, Weak},
};

/// Names of parts that are remembered; the parts themselves live as long as documents hold them.
const REMEMBERED: NonZeroUsize = NonZeroUsize::new(1024).expect("not 0");

/// What was read and is still held by some document.
struct Known<T>(Mutex<LruCache<String, Weak<T>>>);

impl<T> Known<T> {
    fn new() -> Self {
        Self(Mutex::new(LruCache::new(REMEMBERED)))
    }

    fn get(&self, name: &str) -> Option<Arc<T>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(name).and_then(Weak::upgrade)
    }

    fn remember(&self, name: &str, part: &Arc<T>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).put(name.to_owned(), Arc::downgrade(part));
    }
}

/// The parts of a store.
pub(super) struct StoredParts {
    store: Store,
    sets: Known<FeatureSet>,
    rasters: Known<Raster>,
    generations: Known<Generation>,
}

/// A part that is not stored yet.
pub(super) enum New {
    Set(String, Arc<FeatureSet>),
    Generation(Arc<Generation>),
}

impl StoredParts {
    pub(super) fn new(store: Store) -> Self {
        Self { store, sets: Known::new(), rasters: Known::new(), generations: Known::new() }
    }

    /// The parts of these names, as far as they are stored, and a new part that is not.
    pub(super) async fn find(&self, compute: &Compute, names: PartNames, new: Option<New>) -> Result<Parts, LoadError> {
        let mut found = Parts::default();
        match &new {
            Some(New::Set(name, set)) => self.sets.remember(name, set),
            Some(New::Generation(generation)) => self.generations.remember(generation.hash(), generation),
            None => {}
        }
        for name in names.sets {
            if let Some(set) = self.set(compute, &name).await? {
                found.insert_set(name, set);
            }
        }
        for name in names.rasters {
            if let Some(raster) = self.raster(compute, &name).await? {
                found.insert_raster(name, raster);
            }
        }
        for hash in names.generations {
            if let Some(generation) = self.generation(compute, &hash).await? {
                found.insert_generation(generation);
            }
        }
        Ok(found)
    }

    /// The generation of a hash, if it is stored; bred again where that is needed.
    pub(super) async fn generation(&self, compute: &Compute, hash: &str) -> Result<Option<Arc<Generation>>, LoadError> {
        if let Some(generation) = self.generations.get(hash) {
            return Ok(Some(generation));
        }
        let Some(stored) = self.store.generation(hash).await? else { return Ok(None) };
        let read = compute.run(move || stored.read()).await?;
        let generation = Arc::new(read.map_err(|error| LoadError::Generation { hash: hash.to_owned(), error })?);
        self.generations.remember(hash, &generation);
        Ok(Some(generation))
    }

    async fn set(&self, compute: &Compute, name: &str) -> Result<Option<Arc<FeatureSet>>, LoadError> {
        if let Some(set) = self.sets.get(name) {
            return Ok(Some(set));
        }
        let Some(stored) = self.store.feature_set(name).await? else { return Ok(None) };
        let read = compute.run(move || FeatureSet::read(&stored)).await?;
        let set = Arc::new(read.map_err(|error| LoadError::Set { name: name.to_owned(), error })?);
        self.sets.remember(name, &set);
        Ok(Some(set))
    }

    /// The raster of a name, if there is one.
    pub(super) async fn raster(&self, compute: &Compute, name: &str) -> Result<Option<Arc<Raster>>, LoadError> {
        if let Some(raster) = self.rasters.get(name) {
            return Ok(Some(raster));
        }
        let Some(stored) = self.store.raster(name).await? else { return Ok(None) };
        let read = compute.run(move || stored.read()).await?;
        let raster = Arc::new(read.map_err(|error| LoadError::Raster { name: name.to_owned(), error })?);
        self.rasters.remember(name, &raster);
        Ok(Some(raster))
    }
}
