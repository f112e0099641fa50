//! Arrays that begin at a line of the cache.

use super::law::LANES;
use hertzchain_integrators::Column;
use num_traits::Zero;
use std::ops::{Deref, DerefMut};

/// Bytes in a line of the cache, and in the widest register.
const LINE: usize = 64;
/// Processors that compare only the lower bits of addresses take two addresses for the same that
/// differ by a multiple of this many bytes: a load then waits for an unrelated store.
const PAGE: usize = 4096;
/// Distance in bytes, within a page, between the starts of arrays that are walked side by side.
/// Timed with 1000 to 4096 sites: a sweep takes 12 % to 45 % less time than with equal starts.
const APART: usize = 10 * LINE;

/// Numbers that begin at a line of the cache, so that no load of a whole register from a multiple
/// of its length crosses two lines.
///
/// As a slice it has the length it was made with; its memory goes on to a whole number of
/// registers.
#[derive(Debug)]
pub(crate) struct Aligned<T> {
    numbers: Vec<T>,
    start: usize,
    len: usize,
}

impl<T: Copy + Zero> Aligned<T> {
    /// Zeros.
    pub(crate) fn zeros(len: usize) -> Self {
        Self::starting(len, 0, LINE)
    }

    /// `K` arrays of zeros, for loops that walk them side by side.
    pub(crate) fn together<const K: usize>(len: usize) -> [Self; K] {
        std::array::from_fn(|k| Self::starting(len, k * APART, PAGE))
    }

    /// `K` arrays of zeros, for loops that walk them beside up to four arrays made by
    /// [`together`](Self::together).
    pub(crate) fn between<const K: usize>(len: usize) -> [Self; K] {
        std::array::from_fn(|k| Self::starting(len, (4 + k) * APART, PAGE))
    }

    /// Zeros that begin at an address that is `offset` modulo `modulus`.
    fn starting(len: usize, offset: usize, modulus: usize) -> Self {
        if len == 0 {
            return Self { numbers: Vec::new(), start: 0, len };
        }
        let (whole, size) = (len.next_multiple_of(LANES), size_of::<T>());
        let numbers = vec![T::zero(); whole + (offset + modulus) / size];
        let start = numbers.as_ptr().align_offset(modulus) + offset / size;
        Self { numbers, start, len }
    }

    /// All numbers, with those that fill up the last register.
    pub(crate) fn column(&mut self) -> Column<'_, T> {
        Column::new(&mut self.numbers[self.start..][..self.len.next_multiple_of(LANES)])
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: `starting` has made room for `start + len` numbers, and they never move.
        unsafe { std::slice::from_raw_parts(self.numbers.as_ptr().add(self.start), self.len) }
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: as above.
        unsafe { std::slice::from_raw_parts_mut(self.numbers.as_mut_ptr().add(self.start), self.len) }
    }
}
