//! Memory that begins where a cache line does, so that no vector of it lies across two.

use core::ops::{Deref, DerefMut};

/// Bytes of a cache line, and of the widest vector.
const LINE: usize = 64;

/// A slice that begins with a cache line.
pub(super) struct Aligned<T> {
    room: Vec<T>,
    start: usize,
    count: usize,
}

impl<T: Copy> Aligned<T> {
    pub(super) fn new(value: T, count: usize) -> Self {
        let room = vec![value; count + LINE / size_of::<T>()];
        // Nothing but speed depends on the offset.
        let start = room.as_ptr().align_offset(LINE).min(room.len() - count);
        Self { room, start, count }
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.room[self.start..][..self.count]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.room[self.start..][..self.count]
    }
}

/// An array that begins with a cache line.
#[repr(align(64))]
pub(super) struct AlignedArray<const N: usize, T = f32>(pub [T; N]);
