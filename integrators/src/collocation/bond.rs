//! A bond in a window: its contacts and their panels.

use super::{chain::Path, detect::Crossing, panels::Panels, prescribed::Prescribed};

/// A time interval in which the bond is closed. It may have begun before the window and may end
/// after it. Times count from the start of the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    /// Time of the onset; see [`from_the_start`](Self::from_the_start) if the bond was closed when
    /// the run began.
    pub(crate) onset: f64,
    /// Time of the release; infinity where none is predicted.
    pub(crate) release: f64,
    /// Slopes `dg/dt` at onset and release; `dP/dt`, see `loss.rs`, if the contact dissipates and
    /// the event is a zero of `P`.
    pub(crate) slopes: [f64; 2],
    /// The sizes of the last steps of Newton's method for onset and release; infinite before the
    /// first.
    pub(crate) steps: [f64; 2],
    /// Whether beads overlapped already at the onset, which is then a zero of `P`, see `loss.rs`.
    pub(crate) overlaps_at_onset: bool,
    /// Its panels in this window: index of the first, and one past the last.
    pub(crate) panels: (usize, usize),
}

impl Contact {
    pub(super) fn new(onset: f64, release: f64, slopes: [f64; 2]) -> Self {
        Self { onset, release, slopes, steps: [f64::INFINITY; 2], overlaps_at_onset: false, panels: (0, 0) }
    }

    /// The contact of a bond that is closed when the run begins, with this overlap and its rate.
    ///
    /// Its force is singular at the zero of the overlap before the run, if the overlap grows: the
    /// onset is there, as far as the rate tells it. Else it is at minus infinity.
    pub(crate) fn from_the_start(overlap: f64, rate: f64) -> Self {
        let onset = if rate > 0.0 { (-overlap / rate).min(-f64::MIN_POSITIVE) } else { f64::NEG_INFINITY };
        Self::new(onset, f64::INFINITY, [0.0; 2])
    }

    /// Whether it begins and whether it ends inside the window.
    pub(super) fn events(&self, h: f64) -> [bool; 2] {
        [self.onset >= 0.0, self.release <= h]
    }
}

/// A bond in a window, from the linear path that it enters with to the panels that it is solved on.
#[derive(Clone, Debug)]
pub(crate) struct Bond<const M: usize, const S: usize> {
    pub(crate) initial: Initial<S>,
    /// The part of the overlap that drives prescribe, in addition to its path.
    pub(crate) known: Option<Prescribed>,
    pub(crate) prediction: Prediction,
    pub(crate) contacts: Contacts,
    pub(crate) panels: Panels<M, S>,
    pub(crate) sweeps: Sweeps,
    pub(crate) resolution: Resolution,
    pub(crate) pending: Pending,
}

/// The state of a bond when a window begins.
///
/// Without forces the overlap goes on along `path`. The bond's own force `f` changes the second
/// derivative of its overlap by `-mobility f`, a neighbour's force `f` by `f` times the weight of
/// the side that they share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Initial<const S: usize> {
    /// Index of the bond in the chain.
    pub(crate) bond: usize,
    /// The sum of the weights of both sides: 2 between two sites of mass 1, 1 at a wall.
    pub(crate) mobility: f64,
    /// The linear path of the overlap, as the sum of one path for each side.
    pub(crate) path: [Path; S],
    /// Overlaps of at most this absolute value are rounding.
    pub(crate) band: f64,
    /// Overlap at the start of the window, and its time derivative.
    pub(crate) overlap: [f64; 2],
    /// Force at the start of the window, and its time derivative.
    pub(crate) force: [f64; 2],
    /// The contact that the bond is in when the window begins.
    pub(crate) ongoing: Option<Contact>,
    /// See [`Link::singular_after`](super::link::Link::singular_after); of the last release that
    /// was found.
    pub(super) singular_after: f64,
}

impl<const S: usize> Initial<S> {
    fn none() -> Self {
        Self {
            bond: 0,
            mobility: 0.0,
            path: [[0.0; 4]; S],
            band: 0.0,
            overlap: [0.0; 2],
            force: [0.0; 2],
            ongoing: None,
            singular_after: 0.0,
        }
    }

    /// The factor on the displacement by the bond's own forces on a side, in its overlap: 1; or the
    /// mobility for `S = 1`, where one side stands for both.
    #[inline(always)]
    pub(super) fn own(&self) -> f64 {
        if S == 1 { self.mobility } else { 1.0 }
    }
}

impl<const M: usize, const S: usize> Bond<M, S> {
    /// See [`Link::singular_after`](super::link::Link::singular_after).
    #[inline(always)]
    pub(super) fn singular_after(&self) -> f64 {
        if S == 1 { 0.0 } else { self.initial.singular_after }
    }
}

/// The prediction of the overlap from the forces at the start of a window, extrapolated linearly in
/// time.
///
/// Contacts are first found in this prediction. They are kept as long as the error of the predicted
/// overlap is below `margin`; a bound of this error follows from the `predictor_error` of the bond
/// and of its neighbours.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Prediction {
    /// Coefficient `b` of the predicted force `f_0 + f_0' t + b t^2`, which meets the force of the
    /// predicted overlap at the end of the window.
    pub(crate) curvature: f64,
    /// Overlap at the end of the window that a release after the window was last estimated from;
    /// `P` at the end of the window where the contact dissipates.
    pub(super) at_end: f64,
    /// Largest error of the predicted overlap that cannot change the contacts found, see
    /// [`Search::run`](super::detect::Search::run).
    pub(crate) margin: f64,
    /// Largest difference in the window between the computed force and `f_0 + f_0' t`.
    pub(crate) predictor_error: f64,
}

/// The contacts of a bond in a window, in order of time, and memory for the search.
#[derive(Clone, Debug)]
pub(crate) struct Contacts {
    pub(crate) found: Vec<Contact>,
    /// The contacts before the last search.
    pub(super) assumed: Vec<Contact>,
    /// Contacts of bonds beyond the neighbours at whose ends panels are cut too, with their
    /// [`singular_after`](super::link::Link::singular_after): where contacts dissipate, see
    /// [`look_beyond`](super::layout::look_beyond).
    pub(super) beyond: Vec<(Contact, f64)>,
    /// The changes of sign of the overlap that the last search found.
    pub(super) crossings: Vec<Crossing>,
}

/// How the sweeps over a bond converge.
///
/// A sweep contracts changes by a factor. Its bound depends on the stiffness `f'(g) h^2/m`, with
/// the mass `m` of the lighter site, and on the number of sweeps, see [`Bond::answer`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sweeps {
    /// The largest overlap at a node in the last sweep.
    pub(super) largest: f64,
    /// `f'(g) h^2/m` at the largest overlap of the last two sweeps; dimensionless.
    pub(crate) stiffness: f64,
    /// `c(g) h/m` at this overlap, of a contact that dissipates. Its square is a part of the
    /// stiffness.
    pub(super) resistance: f64,
    /// Change of an impulse by the last sweep, as a change of velocity.
    pub(crate) change: f64,
    /// Sweeps since panels were laid out, of this bond or of the bond from which a change came.
    pub(crate) age: u32,
}

/// Whether the nodes resolve the force.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Resolution {
    /// Last terms of the force's series over the allowed ones; above 1 panels are halved.
    pub(crate) tail: f64,
    /// Number of times that every panel is halved in its variable.
    pub(crate) halvings: u32,
}

/// What must still be done for a bond.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pending {
    /// An event has moved: panels must be laid out anew.
    pub(crate) layout: bool,
    /// The force of the bond or of a neighbour has changed: the bond must be swept again.
    pub(crate) sweep: bool,
    /// Newton's method found events that contradict the contacts: the contacts must be searched for
    /// again.
    pub(crate) search: bool,
    /// In the last sweep Newton's method would have led an onset out of the window: it was not
    /// moved, and the contacts must be searched for again.
    pub(crate) diverged: bool,
}

/// The part of an overlap that drives prescribe. For `S = 1` it is `None` at compile time, since
/// chains with drives have `S = 2`.
#[inline(always)]
pub(super) fn known<const S: usize>(known: &Option<Prescribed>) -> Option<&Prescribed> {
    if S == 1 { None } else { known.as_ref() }
}

/// A neighbour of a bond; `None` at the end of a chain.
pub(crate) type Beside<'a, const M: usize, const S: usize> = Option<&'a Bond<M, S>>;

/// Number of contacts of a bond in one window that memory is reserved for; more cost an allocation.
/// Chosen, not measured.
const CONTACTS: usize = 4;

impl<const M: usize, const S: usize> Bond<M, S> {
    pub(crate) fn new() -> Self {
        let contacts = Contacts {
            found: Vec::with_capacity(CONTACTS),
            assumed: Vec::with_capacity(CONTACTS),
            beyond: Vec::new(),
            crossings: Vec::with_capacity(2 * CONTACTS),
        };
        Self {
            initial: Initial::none(),
            known: None,
            prediction: Prediction::default(),
            contacts,
            panels: Panels::new(),
            sweeps: Sweeps::default(),
            resolution: Resolution::default(),
            pending: Pending::default(),
        }
    }
}
