//! Tiles that wait for a thread.

use crate::world::Fingerprint;
use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

/// How urgent a tile is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(in crate::server) enum Class {
    /// Somebody looks at it.
    Visible,
    /// Somebody may look at it soon.
    Prefetch,
}

impl Class {
    pub(in crate::server) const ALL: [Self; 2] = [Self::Visible, Self::Prefetch];

    pub(in crate::server) fn name(self) -> &'static str {
        match self {
            Self::Visible => "visible",
            Self::Prefetch => "prefetch",
        }
    }
}

/// So many of a class may wait however long it takes: those of four pages, each with the six connections that browsers open.
pub(super) const ALWAYS: usize = 24;

struct Entry {
    fingerprint: Fingerprint,
    cost_ns: f64,
    since: Instant,
}

#[derive(Default)]
struct Lane {
    entries: VecDeque<Entry>,
    cost_ns: f64,
}

impl Lane {
    fn taken(&mut self, entry: &Entry) {
        // Rounding must not add up.
        self.cost_ns = if self.entries.is_empty() { 0.0 } else { self.cost_ns - entry.cost_ns };
    }
}

/// What comes next, and what has waited too long.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Taken {
    pub next: Option<Fingerprint>,
    pub expired: Vec<Fingerprint>,
}

/// Tiles that wait, by class; within a class the oldest first, the newest first once the oldest has waited half of what may be waited: then somebody still is
/// served in time.
#[derive(Default)]
pub(super) struct Queue {
    lanes: [Lane; 2],
}

impl Queue {
    /// Predicted nanoseconds of what comes before a new one of a class.
    pub(super) fn ahead_ns(&self, class: Class) -> f64 {
        self.lanes[..=class as usize].iter().map(|lane| lane.cost_ns).sum()
    }

    pub(super) fn waiting(&self, class: Class) -> usize {
        self.lanes[class as usize].entries.len()
    }

    pub(super) fn push(&mut self, class: Class, fingerprint: Fingerprint, cost_ns: f64, since: Instant) {
        let lane = &mut self.lanes[class as usize];
        lane.entries.push_back(Entry { fingerprint, cost_ns, since });
        lane.cost_ns += cost_ns;
    }

    pub(super) fn remove(&mut self, class: Class, fingerprint: &Fingerprint) {
        let lane = &mut self.lanes[class as usize];
        if let Some(entry) = lane.entries.iter().position(|entry| entry.fingerprint == *fingerprint).and_then(|i| lane.entries.remove(i)) {
            lane.taken(&entry);
        }
    }

    /// Takes the next one; `patience` is how long one may wait behind more than [`ALWAYS`].
    pub(super) fn take(&mut self, now: Instant, patience: Duration) -> Taken {
        let mut taken = Taken::default();
        for lane in &mut self.lanes {
            let waited = |entry: Option<&Entry>| entry.map_or(Duration::ZERO, |entry| now.saturating_duration_since(entry.since));
            while lane.entries.len() > ALWAYS && waited(lane.entries.front()) > patience {
                let Some(entry) = lane.entries.pop_front() else { break };
                lane.taken(&entry);
                taken.expired.push(entry.fingerprint);
            }
            let is_late = lane.entries.len() > ALWAYS && waited(lane.entries.front()) > patience / 2;
            let next = if is_late { lane.entries.pop_back() } else { lane.entries.pop_front() };
            if let Some(entry) = next {
                lane.taken(&entry);
                taken.next = Some(entry.fingerprint);
                break;
            }
        }
        taken
    }
}
