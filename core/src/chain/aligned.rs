//! Arrays that begin at a line of the cache.

use super::law::{LANES, Lanes};
use num_traits::Zero;
use std::ops::{Deref, DerefMut};

/// Bytes in a line of the cache, and in the widest register.
const LINE: usize = 64;

/// Numbers that begin at a line of the cache, so that no load of a whole register from a multiple
/// of its length crosses two lines.
///
/// It has the length it was made with, and is filled up to a whole number of registers.
#[derive(Debug)]
pub(crate) struct Aligned<T> {
    numbers: Vec<T>,
    start: usize,
    len: usize,
}

impl<T: Copy + Zero> Aligned<T> {
    /// Zeros.
    pub(crate) fn zeros(len: usize) -> Self {
        let whole = len.next_multiple_of(LANES);
        let numbers = vec![T::zero(); if len > 0 { whole + LINE / size_of::<T>() } else { 0 }];
        let start = if len > 0 { numbers.as_ptr().align_offset(LINE) } else { 0 };
        Self { numbers, start, len }
    }

    /// Registers, the last filled up.
    #[inline(always)]
    pub(crate) fn blocks_mut(&mut self) -> &mut [Lanes<T>] {
        self.numbers[self.start..][..self.len.next_multiple_of(LANES)].as_chunks_mut().0
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.numbers[self.start..][..self.len]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.numbers[self.start..][..self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_begin_at_a_line() {
        for len in [1, 7, 50, 1000] {
            let mut array = Aligned::<f64>::zeros(len);
            assert_eq!((array.len(), array.as_ptr() as usize % LINE), (len, 0));
            assert_eq!(array.blocks_mut().len(), len.div_ceil(LANES));
        }
        assert!(Aligned::<f64>::zeros(0).is_empty());
    }
}
