//! Who changes a world's features: one at a time each world, and few at a time together.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError, Weak},
};
use tokio::sync::{Mutex as Turn, OwnedMutexGuard, Semaphore, SemaphorePermit};

/// Worlds that are edited at the same time at most: each edit holds its world's features twice.
const AT_ONCE: usize = 4;

/// The edits of a server.
pub(super) struct Editing {
    /// Worlds that are being edited or waited for.
    worlds: Mutex<BTreeMap<String, Weak<Turn<()>>>>,
    room: Semaphore,
}

/// Held from reading a world's features to saving them, so that no edit is lost.
pub(super) struct Edit<'a> {
    _room: Option<SemaphorePermit<'a>>,
    _turn: OwnedMutexGuard<()>,
}

impl Editing {
    pub(super) fn new() -> Self {
        Self { worlds: Mutex::default(), room: Semaphore::new(AT_ONCE) }
    }

    /// Waits for a world's turn, and then for room.
    pub(super) async fn begin(&self, world: &str) -> Edit<'_> {
        let turn = self.turn(world).lock_owned().await;
        // The semaphore is never closed.
        Edit { _room: self.room.acquire().await.ok(), _turn: turn }
    }

    fn turn(&self, world: &str) -> Arc<Turn<()>> {
        let mut worlds = self.worlds.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(turn) = worlds.get(world).and_then(Weak::upgrade) {
            return turn;
        }
        // What nobody holds or waits for any more is forgotten.
        worlds.retain(|_, turn| turn.strong_count() > 0);
        let turn = Arc::new(Turn::new(()));
        worlds.insert(world.to_owned(), Arc::downgrade(&turn));
        turn
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::FutureExt;

    fn waits(editing: &Editing, world: &str) -> bool {
        editing.begin(world).now_or_never().is_none()
    }

    #[tokio::test]
    async fn each_world_is_edited_by_one_at_a_time() {
        let editing = Editing::new();
        let one = editing.begin("one").await;
        assert!(waits(&editing, "one") && !waits(&editing, "other"));
        drop(one);
        assert!(!waits(&editing, "one"));
        drop(editing.begin("last").await);
        assert_eq!(editing.worlds.lock().expect("no panic").len(), 1, "what is not edited is forgotten");
    }

    #[tokio::test]
    async fn few_worlds_are_edited_at_once() {
        let editing = Editing::new();
        let mut edits = Vec::new();
        for number in 0..AT_ONCE {
            edits.push(editing.begin(&number.to_string()).await);
        }
        assert!(waits(&editing, "more"));
        edits.pop();
        assert!(!waits(&editing, "more"));
    }
}
