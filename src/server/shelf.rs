//! Named documents of one kind: on disk, and in memory ready to be used.

use super::{
    compute::{Compute, Panicked},
    events::{Event, Events},
    parts::StoredParts,
    state::App,
};
use crate::{
    layout::geojson::{FeatureSet, ReadError, StoredSet},
    store::{Condition, Content, Kind, RevisionEntry, Saved, Store, StoreError},
    world::{DocumentError, PartNames, Parts, RasterError, Revision},
};
use arc_swap::ArcSwap;
use axum::body::Bytes;
use std::{
    collections::BTreeMap,
    sync::{Arc, Weak},
};

/// A document of a kind with what was made of it for serving.
pub(super) trait Shelved: Sized + Send + Sync + 'static {
    /// What it is.
    const KIND: Kind;
    /// Where its kind stands in addresses.
    const PATH: &'static str;
    type Document: Clone + Send + Sync + 'static;

    /// Reads a new document; the parts that it names are given.
    fn parse(json: &[u8], parts: &Parts) -> Result<Self::Document, DocumentError>;
    /// Reads a document that was accepted before.
    fn parse_stored(json: &[u8], parts: &Parts) -> Result<Self::Document, DocumentError>;
    /// The names of the parts that a document names.
    fn named_in(json: &[u8]) -> PartNames;
    fn content(document: &Self::Document) -> Content;
    fn title_of(document: &Self::Document) -> Option<&str>;

    /// Makes of a document what serves it; this may evaluate terrain.
    fn new(name: &str, document: Self::Document) -> Self;
    fn name(&self) -> &str;
    fn document(&self) -> &Self::Document;
    fn revision(&self) -> &Revision;

    /// What those who listen are told when a name stands for another revision, or for nothing any more.
    fn event(_: &str, _: Option<&Revision>) -> Option<Event> {
        None
    }

    /// The server's shelf of this kind.
    fn shelf(app: &App) -> &Shelf<Self>;

    /// The title, or the name of a document without one.
    fn title(&self) -> &str {
        Self::title_of(self.document()).unwrap_or(self.name())
    }
}

/// Why documents cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LoadError {
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A stored document is not one that this version reads.
    #[error("the stored {kind} {name:?}: {error}")]
    Document {
        /// What it is.
        kind: Kind,
        /// Its name.
        name: String,
        /// What is wrong with it.
        error: DocumentError,
    },
    /// A stored set of features is not one that this version reads.
    #[error("the stored set of features {name:?}: {error}")]
    Set {
        /// Its name.
        name: String,
        /// What is wrong with it.
        error: ReadError,
    },
    /// A stored raster cannot be read.
    #[error("the stored raster {name:?}: {error}")]
    Raster {
        /// Its name.
        name: String,
        /// What is wrong with it.
        error: RasterError,
    },
    /// It could not be evaluated.
    #[error(transparent)]
    Panicked(#[from] Panicked),
}

type Index<T> = BTreeMap<String, Arc<T>>;

/// The documents of a kind.
pub(super) struct Shelf<T> {
    store: Store,
    compute: Arc<Compute>,
    parts: Arc<StoredParts>,
    events: Arc<Events>,
    index: ArcSwap<Index<T>>,
    /// Held from a write to the store until the index shows it, so that both change in the same order.
    writing: tokio::sync::Mutex<()>,
}

impl<T: Shelved> Shelf<T> {
    /// Loads every document of the kind.
    pub(super) async fn load(store: Store, compute: Arc<Compute>, parts: Arc<StoredParts>, events: &Arc<Events>) -> Result<Self, LoadError> {
        let mut index = Index::new();
        for stored in store.documents(T::KIND).await? {
            // One document that cannot be read must not take the others with it.
            match revive(&compute, &parts, &stored.name, stored.body).await {
                Ok(live) => {
                    index.insert(stored.name, live);
                }
                Err(error) => tracing::error!(%error, "a stored {} is left out", T::KIND),
            }
        }
        Ok(Self { store, compute, parts, events: Arc::clone(events), index: ArcSwap::from_pointee(index), writing: tokio::sync::Mutex::default() })
    }

    /// Every document, by name.
    pub(super) fn all(&self) -> Arc<Index<T>> {
        self.index.load_full()
    }

    /// What a name stands for now.
    pub(super) fn get(&self, name: &str) -> Option<Arc<T>> {
        self.index.load().get(name).cloned()
    }

    /// Whether a document is what its name stands for now.
    pub(super) fn is_current(&self, document: &Weak<T>) -> bool {
        document.upgrade().is_some_and(|document| self.index.load().get(document.name()).is_some_and(|now| Arc::ptr_eq(now, &document)))
    }

    /// What a name stood for at a revision, from disk.
    pub(super) async fn read(&self, name: &str, revision: &Revision) -> Result<Option<Arc<T>>, LoadError> {
        match self.store.document(T::KIND, name, revision).await? {
            Some(body) => Ok(Some(revive(&self.compute, &self.parts, name, body).await?)),
            None => Ok(None),
        }
    }

    /// Every saved revision of a name.
    pub(super) async fn revisions(&self, name: &str) -> Result<Vec<RevisionEntry>, StoreError> {
        self.store.revisions(T::KIND, name).await
    }

    /// Reads a new document, with the stored parts that it names and perhaps a set of features that is not stored yet.
    pub(super) async fn parse(&self, json: Bytes, new: Option<(String, Arc<FeatureSet>)>) -> Result<Result<T::Document, DocumentError>, LoadError> {
        let parts = self.parts.find(&self.compute, T::named_in(&json), new).await?;
        Ok(self.compute.run(move || T::parse(&json, &parts)).await?)
    }

    /// Saves a document, first on disk, then in memory.
    pub(super) async fn save(&self, name: &str, document: T::Document, condition: &Condition) -> Result<(Saved, Arc<T>), LoadError> {
        self.save_with(name, document, None, condition).await
    }

    /// As [`Shelf::save`], together with a set of features that the document names.
    pub(super) async fn save_with(
        &self,
        name: &str,
        document: T::Document,
        set: Option<&StoredSet>,
        condition: &Condition,
    ) -> Result<(Saved, Arc<T>), LoadError> {
        let live = prepare::<T>(&self.compute, name, document).await?;
        let _writing = self.writing.lock().await;
        let saved = self.store.save_with(name, T::content(live.document()), set, condition).await?;
        self.change(|index| {
            index.insert(name.to_owned(), Arc::clone(&live));
        });
        if saved != Saved::Unchanged {
            self.tell(name, Some(live.revision()));
        }
        Ok((saved, live))
    }

    /// Takes a name out of use.
    pub(super) async fn delete(&self, name: &str, condition: &Condition) -> Result<(), StoreError> {
        let _writing = self.writing.lock().await;
        self.store.delete(T::KIND, name, condition).await?;
        self.change(|index| {
            index.remove(name);
        });
        self.tell(name, None);
        Ok(())
    }

    /// Told while the next write waits, so that events come in the order of revisions.
    fn tell(&self, name: &str, revision: Option<&Revision>) {
        if let Some(event) = T::event(name, revision) {
            self.events.send(event);
        }
    }

    fn change(&self, edit: impl Fn(&mut Index<T>)) {
        self.index.rcu(|index| {
            let mut index = Index::clone(index);
            edit(&mut index);
            index
        });
    }
}

/// Reads what ships with the program, on the compute pool. As long as the document is kept, what it took long to make is not made again.
pub(super) async fn shipped<T: Shelved>(compute: &Compute, name: &'static str, json: &'static str) -> Result<(Content, T::Document), LoadError> {
    compute.run(move || parse::<T>(name, json, &Parts::default()).map(|document| (T::content(&document), document))).await?
}

fn parse<T: Shelved>(name: &str, body: &str, parts: &Parts) -> Result<T::Document, LoadError> {
    T::parse_stored(body.as_bytes(), parts).map_err(|error| LoadError::Document { kind: T::KIND, name: name.to_owned(), error })
}

/// Reads, generates, compiles, and surveys where that is needed, on the compute pool.
async fn revive<T: Shelved>(compute: &Compute, parts: &StoredParts, name: &str, body: String) -> Result<Arc<T>, LoadError> {
    let found = parts.find(compute, T::named_in(body.as_bytes()), None).await?;
    let name = name.to_owned();
    compute.run(move || Ok(Arc::new(T::new(&name, parse::<T>(&name, &body, &found)?)))).await?
}

/// Compiles, and surveys where that is needed, on the compute pool.
async fn prepare<T: Shelved>(compute: &Compute, name: &str, document: T::Document) -> Result<Arc<T>, Panicked> {
    let name = name.to_owned();
    compute.run(move || Arc::new(T::new(&name, document))).await
}
