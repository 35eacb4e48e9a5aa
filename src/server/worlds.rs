//! The worlds of a server.

use super::{
    compute::Compute,
    events::{Event, Events},
    parts::StoredParts,
    shelf::{LoadError, Shelf, Shelved, shipped},
    state::App,
};
use crate::{
    store::{Condition, Content, Kind, Store},
    world::{Document, DocumentError, EXAMPLES, PartNames, Parts, Revision, Survey, World},
};
use lru::LruCache;
use std::{
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

impl Shelved for Live {
    const KIND: Kind = Kind::World;
    const PATH: &'static str = "worlds";
    type Document = Document;

    fn parse(json: &[u8], parts: &Parts) -> Result<Document, DocumentError> {
        Document::parse_with(json, parts)
    }

    fn parse_stored(json: &[u8], parts: &Parts) -> Result<Document, DocumentError> {
        Document::parse_stored(json, parts)
    }

    fn named_in(json: &[u8]) -> PartNames {
        PartNames::in_world(json)
    }

    fn content(document: &Document) -> Content {
        document.into()
    }

    fn title_of(document: &Document) -> Option<&str> {
        document.title.as_deref()
    }

    fn new(name: &str, document: Document) -> Self {
        let world = World::new(document);
        let survey = Survey::of(&world);
        Self { name: name.to_owned(), world, survey }
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn document(&self) -> &Document {
        self.world.document()
    }

    fn revision(&self) -> &Revision {
        self.world.revision()
    }

    fn event(name: &str, revision: Option<&Revision>) -> Option<Event> {
        Some(Event::World { world: name.to_owned(), revision: revision.map(ToString::to_string) })
    }

    fn shelf(app: &App) -> &Shelf<Self> {
        &app.0.worlds.shelf
    }
}

type OldRevisions = LruCache<(String, Revision), Arc<Live>>;

/// The worlds of a server, with the old revisions of them that were asked for lately.
pub(super) struct Worlds {
    pub shelf: Shelf<Live>,
    old: Mutex<OldRevisions>,
}

impl Worlds {
    /// Loads every world; a store that never held any gets the examples first.
    pub(super) async fn load(
        store: Store,
        compute: Arc<Compute>,
        parts: Arc<StoredParts>,
        events: &Arc<Events>,
        old_revisions: NonZeroUsize,
    ) -> Result<Self, LoadError> {
        let mut documents = Vec::new();
        if store.is_empty(Kind::World).await? {
            for example in EXAMPLES {
                let (content, document) = shipped::<Live>(&compute, example.name, example.json).await?;
                store.save(example.name, content, &Condition::Any).await?;
                documents.push(document);
            }
        }
        Ok(Self { shelf: Shelf::load(store, compute, parts, events).await?, old: Mutex::new(LruCache::new(old_revisions)) })
    }

    /// A world as it was at a revision; `None` if it is gone or never was there.
    pub(super) async fn at(&self, name: &str, revision: &Revision) -> Result<Option<Arc<Live>>, LoadError> {
        let Some(head) = self.shelf.get(name) else { return Ok(None) };
        if head.world.revision() == revision {
            return Ok(Some(head));
        }
        let key = (name.to_owned(), revision.clone());
        if let Some(live) = self.old().get(&key) {
            return Ok(Some(Arc::clone(live)));
        }
        let live = self.shelf.read(name, revision).await?;
        if let Some(live) = &live {
            self.old().put(key, Arc::clone(live));
        }
        Ok(live)
    }

    fn old(&self) -> std::sync::MutexGuard<'_, OldRevisions> {
        self.old.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
