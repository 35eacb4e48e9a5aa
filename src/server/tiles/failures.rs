//! Revisions whose evaluation panics.

use crate::world::Revision;
use lru::LruCache;
use std::{
    num::NonZeroUsize,
    sync::{Mutex, PoisonError},
};

/// From so many panics on a revision is set aside.
const MOST_PANICS: u32 = 3;

/// Revisions that are remembered.
const REMEMBERED: NonZeroUsize = NonZeroUsize::new(1024).expect("not 0");

/// Counts panics by revision, until the server starts again.
pub(super) struct Failures(Mutex<LruCache<Revision, u32>>);

impl Failures {
    pub(super) fn new() -> Self {
        Self(Mutex::new(LruCache::new(REMEMBERED)))
    }

    pub(super) fn add(&self, revision: &Revision) {
        let mut panics = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let count = panics.get_or_insert_mut(revision.clone(), || 0);
        *count += 1;
        if *count == MOST_PANICS {
            tracing::error!(%revision, "set aside: evaluating it has panicked {MOST_PANICS} times");
        }
    }

    pub(super) fn is_set_aside(&self, revision: &Revision) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).peek(revision).is_some_and(|&count| count >= MOST_PANICS)
    }
}
