//! Stored sets of features, read once for all documents that name them.

use super::{compute::Compute, shelf::LoadError};
use crate::{layout::geojson::FeatureSet, store::Store, world::FeatureSets};
use lru::LruCache;
use std::{
    num::NonZeroUsize,
    sync::{Arc, Mutex, PoisonError, Weak},
};

/// Names of sets that are remembered; the sets themselves live as long as documents hold them.
const REMEMBERED: NonZeroUsize = NonZeroUsize::new(1024).expect("not 0");

/// The sets of a store.
pub(super) struct StoredSets {
    store: Store,
    known: Mutex<LruCache<String, Weak<FeatureSet>>>,
}

impl StoredSets {
    pub(super) fn new(store: Store) -> Self {
        Self { store, known: Mutex::new(LruCache::new(REMEMBERED)) }
    }

    /// The sets of these names, as far as they are stored, and a new one that is not.
    pub(super) async fn find(&self, compute: &Compute, names: Vec<String>, new: Option<(String, Arc<FeatureSet>)>) -> Result<FeatureSets, LoadError> {
        let mut found = FeatureSets::default();
        if let Some((name, set)) = &new {
            self.remember(name, set);
        }
        for name in names {
            let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&name).and_then(Weak::upgrade);
            if let Some(set) = known {
                found.insert(name, set);
            } else if let Some(stored) = self.store.feature_set(&name).await? {
                let read = compute.run(move || FeatureSet::read(&stored)).await?;
                let set = Arc::new(read.map_err(|error| LoadError::Set { name: name.clone(), error })?);
                self.remember(&name, &set);
                found.insert(name, set);
            }
        }
        Ok(found)
    }

    fn remember(&self, name: &str, set: &Arc<FeatureSet>) {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).put(name.to_owned(), Arc::downgrade(set));
    }
}
