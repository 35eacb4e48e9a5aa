//! The region tree of a shadow picture: what lies inside what.

use super::super::lattice::Frame;
use std::collections::VecDeque;

/// No region yet.
const NONE: u32 = u32::MAX;

/// A connected part of the picture: shadow by eight neighbours, light by four.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    /// What surrounds it; none of the outside, number 0.
    pub parent: Option<u32>,
    /// How many surround it: odd in shadow, even in light.
    pub level: u32,
}

/// The regions of a picture, outer ones before those inside them.
#[derive(Clone, Debug)]
pub(super) struct Regions {
    pub regions: Vec<Region>,
    /// Of every slot the number of its region; the border is outside.
    pub slots: Vec<u32>,
}

impl Regions {
    /// Grows region after region from the outside; what of another kind is met on the way lies inside.
    pub(super) fn new(frame: &Frame, shadow: &[bool]) -> Self {
        let mut found = Self { regions: vec![Region { parent: None, level: 0 }], slots: vec![NONE; frame.slots()] };
        let mut inside = VecDeque::from(found.grow(frame, shadow, 0, 0));
        while let Some((parent, first)) = inside.pop_front() {
            if found.slots[first as usize] != NONE {
                continue;
            }
            let number = found.regions.len() as u32;
            found.regions.push(Region { parent: Some(parent), level: found.regions[parent as usize].level + 1 });
            inside.extend(found.grow(frame, shadow, first, number));
        }
        found
    }

    /// Of a slot how many regions surround it.
    pub(super) fn level(&self, slot: usize) -> u32 {
        self.regions[self.slots[slot] as usize].level
    }

    /// Labels all that is connected with a slot; gives back (number, slot) of its neighbours of the other kind.
    fn grow(&mut self, frame: &Frame, shadow: &[bool], first: u32, number: u32) -> Vec<(u32, u32)> {
        let kind = shadow[first as usize];
        let (stride, slots) = (frame.stride(), frame.slots());
        let mut beyond = Vec::new();
        let mut open = vec![first];
        self.slots[first as usize] = number;
        while let Some(slot) = open.pop() {
            let slot = slot as usize;
            let (row, column) = (slot / stride, slot % stride);
            for (j, i) in (0..9).map(|n| (n / 3, n % 3)).filter(|at| *at != (1, 1)) {
                let straight = j == 1 || i == 1;
                let (row, column) = (row + j, column + i);
                if row == 0 || column == 0 || row > slots / stride || column > stride {
                    continue;
                }
                let to = (row - 1) * stride + column - 1;
                if self.slots[to] != NONE {
                    continue;
                }
                if shadow[to] == kind {
                    if kind || straight {
                        self.slots[to] = number;
                        open.push(to as u32);
                    }
                } else if straight {
                    beyond.push((number, to as u32));
                }
            }
        }
        beyond
    }
}
