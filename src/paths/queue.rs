//! The queue of a search: buckets of costs, so fine that order within one does not matter, or sorted where they are not.

use std::{cmp::Reverse, collections::BinaryHeap};

/// Most buckets.
const BUCKETS: usize = 1 << 17;

/// Added to a number below 2^32 it leaves no room for a fraction.
const WHOLE: f64 = (1_u64 << 52) as f64;

/// No entry.
const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Entry {
    slot: u32,
    next: u32,
}

/// Labelled slots in ascending order of (cost, slot), as far as that order can matter.
///
/// Buckets no wider than the least step (R. B. Dial, 1969): no label leads to another of its own bucket. Where that would take too many, buckets are wider and the one that is
/// emptied goes through a heap.
#[derive(Debug, Default)]
pub(super) struct Queue {
    heads: Vec<u32>,
    filled: Vec<u64>,
    entries: Vec<Entry>,
    /// The first of the entries that are free again: few are in use at a time, and these stay in caches.
    free: u32,
    per_cost: f64,
    current: usize,
    heap: BinaryHeap<Reverse<(u32, u32)>>,
}

impl Queue {
    /// Makes it ready for costs from 0 to `most` and steps of at least `step`; true if buckets are so fine that none need be sorted.
    pub(super) fn clear(&mut self, most: f32, step: f32) -> bool {
        let range = f64::from(most).max(f64::from(f32::MIN_POSITIVE));
        // Costs are rounded: two that are a step apart on paper may be closer, by as much as their last places.
        let width = (f64::from(step) - f64::from(f32::EPSILON) * 2.0 * range) * 0.999;
        let fine = width * (BUCKETS - 2) as f64 >= range;
        self.per_cost = if fine { 1.0 / width } else { (BUCKETS - 2) as f64 / range };
        let buckets = (range * self.per_cost) as usize + 2;
        if self.heads.len() < buckets {
            self.heads.resize(buckets, NONE);
            self.filled.resize(buckets.div_ceil(64), 0);
        }
        debug_assert!(self.filled.iter().all(|word| *word == 0), "a search empties its queue");
        self.entries.clear();
        self.free = NONE;
        self.heap.clear();
        self.current = 0;
        fine
    }

    /// Adds a slot that got a label, of no less cost than the last one taken.
    #[inline]
    pub(super) fn push<const FINE: bool>(&mut self, cost: f32, slot: u32) {
        // The nearest whole number, left in the lowest bits.
        let bucket = (f64::from(cost) * self.per_cost + WHOLE).to_bits() as u32 as usize;
        if !FINE && bucket <= self.current {
            self.heap.push(Reverse((cost.to_bits(), slot)));
            return;
        }
        let head = &mut self.heads[bucket];
        let entry = Entry { slot, next: *head };
        self.filled[bucket / 64] |= 1 << (bucket % 64);
        if let Some(free) = self.entries.get_mut(self.free as usize) {
            *head = core::mem::replace(&mut self.free, free.next);
            *free = entry;
        } else {
            *head = self.entries.len() as u32;
            self.entries.push(entry);
        }
    }

    /// Takes all slots of the next bucket, where order within one does not matter; false if there is none. A slot that got better labels since comes again, after it came with the best.
    #[inline]
    pub(super) fn take(&mut self, slots: &mut Vec<u32>) -> bool {
        slots.clear();
        let Some((word, bucket)) = self.first() else { return false };
        self.filled[word] &= self.filled[word] - 1;
        let first = core::mem::replace(&mut self.heads[bucket], NONE);
        let mut at = first;
        while let Some(entry) = self.entries.get_mut(at as usize) {
            slots.push(entry.slot);
            at = entry.next;
            if at == NONE {
                entry.next = core::mem::replace(&mut self.free, first);
            }
        }
        true
    }

    /// The first filled bucket, and the word that says so.
    #[inline]
    fn first(&mut self) -> Option<(usize, usize)> {
        let mut word = self.current / 64;
        while *self.filled.get(word)? == 0 {
            word += 1;
        }
        self.current = word * 64 + self.filled[word].trailing_zeros() as usize;
        Some((word, self.current))
    }

    /// Takes the next slot where buckets are sorted: `cost` tells a slot's present one.
    pub(super) fn pop(&mut self, cost: impl Fn(u32) -> f32) -> Option<u32> {
        if self.heap.is_empty() {
            let (word, bucket) = self.first()?;
            self.filled[word] &= self.filled[word] - 1;
            let mut at = core::mem::replace(&mut self.heads[bucket], NONE);
            while at != NONE {
                let Entry { slot, next } = self.entries[at as usize];
                self.heap.push(Reverse((cost(slot).to_bits(), slot)));
                at = next;
            }
        }
        self.heap.pop().map(|Reverse((_, slot))| slot)
    }
}
