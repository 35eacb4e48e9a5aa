//! Sessions of breeding: records that are kept as documents are, with the generations that follow from them in memory.

use super::{
    compute::Compute,
    events::Events,
    parts::StoredParts,
    shelf::{LoadError, Shelf, Shelved},
    state::App,
};
use crate::{
    evolve::{Record, RecordError, Session},
    store::{Content, Kind, Store},
    world::{DocumentError, PartNames, Parts, Problem, Revision},
};
use lru::LruCache;
use std::{
    num::NonZeroUsize,
    sync::{Arc, LazyLock, Mutex, PoisonError},
};

/// Sessions that others may go on from.
const REMEMBERED: NonZeroUsize = NonZeroUsize::new(64).expect("not 0");

/// By what does not change while one breeds. What is remembered decides about time alone.
static KNOWN: LazyLock<Mutex<LruCache<Revision, Session>>> = LazyLock::new(|| Mutex::new(LruCache::new(REMEMBERED)));

/// A session, ready to be shown.
pub(super) struct Breeding {
    name: String,
    session: Session,
    revision: Revision,
}

impl Breeding {
    pub(super) fn session(&self) -> &Session {
        &self.session
    }
}

impl Shelved for Breeding {
    const KIND: Kind = Kind::Session;
    const PATH: &'static str = "breeding";
    type Document = Session;

    fn parse(json: &[u8], _: &Parts) -> Result<Session, DocumentError> {
        if let Err(error) = serde_json::from_slice::<serde::de::IgnoredAny>(json) {
            return Err(DocumentError::Syntax(error.to_string()));
        }
        let wrong = |RecordError { at, message }| DocumentError::Invalid(vec![Problem::new(at, message)]);
        let record = Record::parse(json).map_err(wrong)?;
        let key = Revision::of(&(record.seed, record.budget, &record.programmes));
        let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let before = known().get(&key).cloned();
        let session = match before {
            Some(before) => before.resume(record),
            None => Session::replay(record),
        };
        let session = session.map_err(wrong)?;
        known().put(key, session.clone());
        Ok(session)
    }

    fn parse_stored(json: &[u8], parts: &Parts) -> Result<Session, DocumentError> {
        Self::parse(json, parts)
    }

    fn named_in(_: &[u8]) -> PartNames {
        PartNames::default()
    }

    fn content(session: &Session) -> Content {
        session.record().into()
    }

    fn title_of(_: &Session) -> Option<&str> {
        None
    }

    fn new(name: &str, session: Session) -> Self {
        Self { name: name.to_owned(), revision: Self::content(&session).revision, session }
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn document(&self) -> &Session {
        &self.session
    }

    fn revision(&self) -> &Revision {
        &self.revision
    }

    fn shelf(app: &App) -> &Shelf<Self> {
        &app.0.breeding
    }
}

/// Loads every session.
pub(super) async fn load(store: Store, compute: Arc<Compute>, parts: Arc<StoredParts>, events: &Arc<Events>) -> Result<Shelf<Breeding>, LoadError> {
    Shelf::load(store, compute, parts, events).await
}
