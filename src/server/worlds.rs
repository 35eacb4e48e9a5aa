//! The worlds of a server: on disk, and in memory ready to be evaluated.

use super::compute::{Compute, Panicked};
use crate::{
    store::{Condition, RevisionEntry, Saved, Store, StoreError},
    world::{Document, DocumentError, EXAMPLES, Revision, Survey, World},
};
use arc_swap::ArcSwap;
use lru::LruCache;
use std::{
    collections::BTreeMap,
    num::NonZeroUsize,
    sync::{Arc, Mutex, PoisonError},
};

/// A world ready to be served.
#[derive(Debug)]
pub(super) struct Live {
    pub name: String,
    pub world: World,
    pub survey: Survey,
}

impl Live {
    fn new(name: &str, document: Document) -> Self {
        let world = World::new(document);
        let survey = Survey::of(&world);
        Self { name: name.to_owned(), world, survey }
    }

    /// The title, or the name of a world without one.
    pub(super) fn title(&self) -> &str {
        self.world.document().title.as_deref().unwrap_or(&self.name)
    }
}

/// Why the worlds cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LoadError {
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A stored document is not one that this version reads.
    #[error("the stored world {name:?}: {error}")]
    Document {
        /// The world.
        name: String,
        /// What is wrong with it.
        error: DocumentError,
    },
    /// A world could not be evaluated.
    #[error(transparent)]
    Panicked(#[from] Panicked),
}

type Index = BTreeMap<String, Arc<Live>>;
type OldRevisions = LruCache<(String, Revision), Arc<Live>>;

/// The worlds of a server.
pub(super) struct Worlds {
    store: Store,
    compute: Arc<Compute>,
    index: ArcSwap<Index>,
    old: Mutex<OldRevisions>,
    /// Held from a write to the store until the index shows it, so that both change in the same order.
    writing: tokio::sync::Mutex<()>,
}

impl Worlds {
    /// Loads every world; an empty store gets the examples first.
    pub(super) async fn load(store: Store, compute: Arc<Compute>, old_revisions: NonZeroUsize) -> Result<Self, LoadError> {
        if store.is_empty().await? {
            for example in EXAMPLES {
                store.save(example.name, &parse(example.name, example.json)?, &Condition::Any).await?;
            }
        }
        let mut index = Index::new();
        for stored in store.worlds().await? {
            // One world that cannot be read must not take the others with it.
            let live = match parse(&stored.name, &stored.body) {
                Ok(document) => revive(&compute, &stored.name, document).await.map_err(LoadError::from),
                Err(error) => Err(error),
            };
            match live {
                Ok(live) => {
                    index.insert(stored.name, live);
                }
                Err(error) => tracing::error!(%error, "a stored world is left out"),
            }
        }
        let old = Mutex::new(LruCache::new(old_revisions));
        Ok(Self { store, compute, index: ArcSwap::from_pointee(index), old, writing: tokio::sync::Mutex::default() })
    }

    /// Every world, by name.
    pub(super) fn all(&self) -> Arc<Index> {
        self.index.load_full()
    }

    /// A world as it is now.
    pub(super) fn get(&self, name: &str) -> Option<Arc<Live>> {
        self.index.load().get(name).cloned()
    }

    /// A world as it was at a revision; `None` if it is gone or never was there.
    pub(super) async fn at(&self, name: &str, revision: &Revision) -> Result<Option<Arc<Live>>, LoadError> {
        let Some(head) = self.get(name) else { return Ok(None) };
        if head.world.revision() == revision {
            return Ok(Some(head));
        }
        let key = (name.to_owned(), revision.clone());
        if let Some(live) = self.old().get(&key) {
            return Ok(Some(Arc::clone(live)));
        }
        let Some(body) = self.store.document(name, revision).await? else { return Ok(None) };
        let live = revive(&self.compute, name, parse(name, &body)?).await?;
        self.old().put(key, Arc::clone(&live));
        Ok(Some(live))
    }

    fn old(&self) -> std::sync::MutexGuard<'_, OldRevisions> {
        self.old.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Every saved revision of a world.
    pub(super) async fn revisions(&self, name: &str) -> Result<Vec<RevisionEntry>, StoreError> {
        self.store.revisions(name).await
    }

    /// Saves a world, first on disk, then in memory.
    pub(super) async fn save(&self, name: &str, document: Document, condition: &Condition) -> Result<(Saved, Arc<Live>), LoadError> {
        let live = revive(&self.compute, name, document).await?;
        let _writing = self.writing.lock().await;
        let saved = self.store.save(name, live.world.document(), condition).await?;
        self.change(|index| {
            index.insert(name.to_owned(), Arc::clone(&live));
        });
        Ok((saved, live))
    }

    /// Takes a world out of the catalogue.
    pub(super) async fn delete(&self, name: &str, condition: &Condition) -> Result<(), StoreError> {
        let _writing = self.writing.lock().await;
        self.store.delete(name, condition).await?;
        self.change(|index| {
            index.remove(name);
        });
        Ok(())
    }

    fn change(&self, edit: impl Fn(&mut Index)) {
        self.index.rcu(|index| {
            let mut index = Index::clone(index);
            edit(&mut index);
            index
        });
    }

    pub(super) async fn close(&self) {
        self.store.close().await;
    }
}

fn parse(name: &str, body: &str) -> Result<Document, LoadError> {
    Document::parse_stored(body.as_bytes()).map_err(|error| LoadError::Document { name: name.to_owned(), error })
}

/// Compiles and surveys a world on the compute pool.
async fn revive(compute: &Compute, name: &str, document: Document) -> Result<Arc<Live>, Panicked> {
    let name = name.to_owned();
    compute.run(move || Arc::new(Live::new(&name, document))).await
}
