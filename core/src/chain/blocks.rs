//! A state that is looked at in blocks of neighbouring sites, so that nobody needs all of it.

use super::Layout;

/// The sites of a state from the first to the last, in blocks of any lengths.
///
/// Sums over sites go through them in this order, one block after the other: they have the same
/// bits for any blocks.
pub trait Blocks<R> {
    /// Calls `see` with the first site of each block and its arrays `[u, v, u', v']`; those of
    /// resonators are empty unless they move.
    fn each(&self, see: &mut dyn FnMut(usize, [&[R]; 4]));
    /// Displacement of the last bead.
    fn last(&self) -> R;
}

/// A state in one piece.
pub struct Whole<'a, R>(pub Layout, pub &'a [R]);

impl<R: Copy> Blocks<R> for Whole<'_, R> {
    fn each(&self, see: &mut dyn FnMut(usize, [&[R]; 4])) {
        see(0, self.0.arrays(self.1));
    }

    fn last(&self) -> R {
        self.0.u(self.1)[self.0.sites() - 1]
    }
}
