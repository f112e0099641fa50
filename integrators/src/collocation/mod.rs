//! Contact collocation: every contact resolved where it happens, at full order, at a cost that
//! grows with the chain only linearly.
//!
//! | symbol | meaning |
//! |---|---|
//! | `g_n, f_n` | overlap and force of bond `n`; `f_n = (g_n)_+^alpha` |
//! | `K(t) = m t + mu sin(omega t)/omega` | displacement of a site by a unit impulse, [`Response`] |
//! | *window* | a stretch `[0, h]` of time that is solved at once, for the whole chain |
//! | *contact* | a stretch of it in which a bond is closed, from *onset* to *release* |
//! | *panel* | a part of a contact on which the force is smooth in the panel's own variable `x` in `[-1, 1]` |
//! | *sweep* | overlaps from all forces, then forces from overlaps, bond by bond |
//!
//! # The equations
//!
//! Between contacts every site moves along an exact linear path
//! `r + v t + c cos(omega t) + s sin(omega t)`. An impulse adds another such path, `K`. So the
//! chain is a closed set of scalar Volterra equations for the overlaps,
//!
//! ```text
//! g_n(t) = g_n^lin(t) + int_0^t K(t - s) [ f_{n-1}(s) - 2 f_n(s) + f_{n+1}(s) ] ds
//! ```
//!
//! (with 1 for the 2 at a wall). Where sites differ each has a kernel of its own, and a bond sees
//! two, `int K_l (f_{n-1} - f_n) + int K_r (f_{n+1} - f_n)`; see [`ContactChain`]. Nothing in it
//! asks for a common mesh: each bond may have its own panels, placed where its own contacts begin
//! and end. A method that stops the whole chain at every event does work of order `N^2` a period;
//! this one of order `N`.
//!
//! # The panels
//!
//! Where a contact begins or ends, `f` goes like the power `alpha` of the distance in time. In
//! `sigma = |t - t_o|^{1/q}`, with the event `t_o` as origin, it is analytic if `q alpha` is an
//! integer (`q` = 2 for spheres, 1 for integers: then there is nothing to map), else smooth to
//! order `q (alpha + 1) >= 8`. A panel spans equal steps of `sigma`, `M` Gauss nodes in it. The
//! origin may lie before the window (an onset, remembered) or beyond it (a release, looked for up
//! to one and a half windows ahead): a singularity that is near is as bad as one that is there.
//!
//! A contact of a neighbour that begins at `t'` gives `g_n` a term `(t - t')^{alpha + 2}` from then
//! on, one that ends has it until then. So panels are cut there as well, with the same kind of
//! variable on the singular side; where both ends are singular the panel is cut once more in the
//! middle. Without these cuts the order is about `alpha + 3`; with them it is that of Gauss
//! quadrature, and doubling the nodes squares the error. Cutting in ever smaller parts towards `t'`
//! instead reaches the same with three times the panels.
//!
//! # The sweep
//!
//! `K(t - s)` is separable in `1, t, cos(omega t), sin(omega t)`. From `f` at the nodes one fixed
//! matrix (antiderivatives of the Lagrange polynomials) gives `int f`, `int s f`, `int f cos`,
//! `int f sin` up to every node, and these what the force has moved so far. That becomes one short
//! series in `x`, which is all that neighbours need; after a panel its force has left a path
//! `A + B t + C cos + D sin` behind. Then `f_n = (g_n)_+^alpha` at the nodes, the ends of contacts
//! by Newton's method on the interpolant of `g_n`, and again, in the order of the bonds (Gauss and
//! Seidel), until no impulse changes. The slope for Newton's method is that between the two nodes
//! nearest to the event: the one that the search for contacts knows belongs to a chord that may
//! span half of a short contact. A sweep contracts by about `alpha g^{alpha-1} h^2/6`; the first
//! forces come from overlaps under forces `f_0 + f_0' t + b t^2` with the `b` that meets the force
//! predicted at the window's end. A bond is swept again only if its own force or one beside it has
//! changed; one that stays open is not swept at all.
//!
//! What contacts there are is first told from the prediction, a cubic plus a bounded remainder, by
//! the signs of its coefficients in Bernstein's basis; where these do not decide, by subdivision
//! under a bound for `g''`. When the sweeps are done, every bond whose overlap moved by more than
//! its certificate allows is searched anew with the forces found.
//!
//! # The error
//!
//! The last terms of the Chebyshev series of each impulse tell whether the nodes resolve the force.
//! Panels that do not are halved in their variable, that bond's only; a window that does not settle
//! is halved for all. So is one that is too long for its contacts, also for those to come: before
//! anything is solved, each bond bounds the overlap that it may reach, by its free path and by
//! where its own force has taken up the speed of approach, and `f'(g) h^2` for the time that is
//! then left must be below a limit. Few nodes may take a whole contact for something else with no
//! sign of it in their last terms. Where panels are halved often they get two nodes more, where the
//! last terms are far below what is asked two less. Windows are as long as they are cheapest:
//! `f'(g) h^2` is moved up and down, whichever way the work for a unit of time falls, and work is
//! counted, not timed, so that a run has the same bits every time. Local errors go with a power 5/4
//! of the last terms, which was measured. An overlap that falls to almost nothing without an event
//! makes a force whose terms fall slowly at last; there the error is taken to be proportional to
//! them. Last terms above 0.3 of the largest value resolve nothing, however small they are beside
//! the velocities: where resonators are much faster than contacts, each of thousands of windows
//! moves little, and would be wrong by most of it to the same side. A tolerance is for the sum over
//! the run, relative to the size of the state. What the dynamics makes of local errors is not in
//! it.
//!
//! A sweep is the last when what the next would change is less than a hundredth of that. An error
//! that grows like `t^{2n}`, as it does after `n` sweeps, shrinks by `4 f' h^2/((2n+1)(2n+2))` in
//! the next.
//!
//! # Sums
//!
//! Sites keep `[R0, V, C, S]`, which only impulses change, in a phase `omega t` that is one number
//! in two parts. Each sum keeps its rounding error; sweeps and the search for events go on until
//! what they leave is below the roundings, for it has a sign and adds up. The energy error is then
//! a random walk of roundings: 1e-13 after 10^6 periods of a breather (measured).
//!
//! # Damping and drives
//!
//! A damped site has other functions of time in the place of `t`, `cos` and `sin`, as series, see
//! `flow.rs`; between windows its path is moved on by the same series. A site that is moved is a
//! known part of the overlaps beside it, and so is what a force does to one that is pushed
//! (`known.rs`). What is dissipated and driven is integrated over each window (`open.rs`). Windows
//! end where a signal is not smooth, and are so short that all series are resolved.
//!
//! Where contacts dissipate, `f = (F + c g')_+`, panels have rates `int K' [..]` beside overlaps, and
//! solve for those by their own forces at once (`loss.rs`). A contact ends where its force comes to
//! zero, with an overlap, and may begin again with one (`rebound.rs`).
//!
//! # Limits
//!
//! - `alpha < 1`: the force has an infinite slope at onsets; the predictions there are poor,
//!   windows short, and tangent maps do not exist.
//! - Resonators so light that they turn many times in a window are resolved where contacts excite
//!   them: the cost then grows with `omega`.
//! - Overlaps whose force over a window would change no digit that the tolerance asks for count as
//!   none, also for the log of contacts.
//! - It is no symplectic method: its energy error is the sum of its local errors, down to a random
//!   walk of roundings.
//!
//! Source: this software. For Gauss collocation: Hairer, Lubich & Wanner 2006, *Geometric Numerical
//! Integration*, Sec. II.1.

#![allow(clippy::needless_range_loop, reason = "loops over nodes read like the formulas, and vectorise")]

mod block;
mod bond;
mod control;
mod detect;
mod flow;
mod foresee;
mod goal;
mod known;
mod layout;
mod loss;
mod numbers;
mod open;
mod panel;
mod panels;
mod rebound;
mod rule;
pub(crate) use rule::Rule;
mod section;
mod sites;
mod solver;
mod system;
mod tangent;

pub use block::{Piece, Share, Verdict};
pub use control::Pace;
pub use goal::Window;
pub use loss::Loss;
pub use section::{BLOCK, EDGE, Section};
pub use system::{ContactChain, Drive, Path, Response};
pub use tangent::{Tangent, monodromy};

use crate::{clock::Twofold, drive::Stepper, error::Error, stats::Stats};
use control::Control;
use system::Links;

/// Parts that a window is cut into at most, to show the state inside it. Chosen, not measured.
const MOST_PARTS: u32 = 1 << 10;

/// Times that a window is shortened for what drives do in it, each by a tenth at least. Chosen: a
/// signal that is rounding by then is resolved by nothing.
const MOST_SHORTENED: u32 = 40;

/// A stepper that logs what contacts do.
pub trait ContactStepper: Stepper<f64> {
    /// Tells what contacts did in the last step, part by part, and the time that times of a piece
    /// count from.
    fn tell(&self, told: &mut dyn FnMut(&Piece, f64));
}

/// Solves the windows that a run decides on: in one place, or in parts of the chain wherever these
/// are.
pub trait Windows: Send + Sized {
    /// Number of components of the state.
    fn dim(&self) -> usize;
    /// The longest windows that may begin where the chain stands: until a signal of a drive is not
    /// smooth, and until flows of damped sites are not resolved.
    fn longest(&self) -> [f64; 2] {
        [f64::INFINITY; 2]
    }
    /// Looks at what drives do in a window of length `h`; returns the length of a shorter one if
    /// this is not resolved to a tolerance, else infinity.
    fn foresee(&mut self, _h: f64, _tol: f64) -> f64 {
        f64::INFINITY
    }
    /// Solves for a window from where the chain stands, and leaves it there.
    fn solve(&mut self, window: &Window) -> Verdict;
    /// Moves the chain over the window that was solved last.
    fn advance(&mut self);
    /// Another one, where this one stands.
    fn duplicate(&self) -> Self;
    /// Goes to where another one of the same chain stands, with the window that it solved last.
    fn copy_from(&mut self, other: &Self);
    /// Writes the state where the chain stands.
    fn store(&self, y: &mut [f64]);
    /// Instead: no state could be computed.
    fn lose(&self, y: &mut [f64]) {
        y.fill(f64::NAN);
    }
    /// Tells what contacts did in the window that was solved last, by bond, if that is logged.
    fn tell(&self, told: &mut dyn FnMut(&Piece));
}

/// A run by contact collocation. It decides which windows are solved and how well, and when one
/// counts; a [`Section`] or another `W` solves them.
pub struct Collocation<W> {
    windows: W,
    control: Control,
    /// The tolerance, or zero.
    tol: f64,
    /// Start of the last window, its length and its nodes a panel; the length is zero if there is
    /// none.
    t: Twofold<f64>,
    h: f64,
    nodes: usize,
    end: Twofold<f64>,
    log: bool,
    stats: Stats,
    /// For states inside a window; made when first asked for.
    inside: Option<W>,
}

impl<C: ContactChain<S>, const S: usize> Collocation<Section<C, S>> {
    /// A run from the state `y0` over `span`, of a chain whose bonds see `S` different sites, see
    /// [`ContactChain`].
    ///
    /// # Errors
    /// A span, a pace or a state outside its rule.
    pub fn new(chain: C, y0: &[f64], span: (f64, f64), pace: Pace) -> Result<Self, Error> {
        Self::on_threads(chain, y0, span, pace, None)
    }

    /// The same on at most so many threads; without a number, on all that there are.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn on_threads(
        chain: C,
        y0: &[f64],
        span: (f64, f64),
        pace: Pace,
        threads: Option<usize>,
    ) -> Result<Self, Error> {
        crate::dop853::check_start(chain.dim(), y0, span)?;
        let section = Section::whole(chain, (y0, span.0), threads);
        let chain = &section.held.chain;
        let control = control(chain, &section.held.links, &|i| chain.path(y0, i), span, pace)?;
        Ok(Self::steered(section, control, (span, pace)))
    }

    /// What contacts did in the last window, by bond, if that is logged; and when the window began.
    pub fn pieces(&self) -> (f64, impl Iterator<Item = &Piece>) {
        (self.t.value(), self.windows.pieces())
    }
}

/// The control of a run of a chain from the paths of its sites over a span.
fn control<C: ContactChain<S>, const S: usize>(
    chain: &C,
    links: &Links<S>,
    start: &dyn Fn(usize) -> Path,
    span: (f64, f64),
    pace: Pace,
) -> Result<Control, Error> {
    Control::new((chain, links), start, pace, Twofold::new(span.1) - Twofold::new(span.0))
}

impl<W: Windows> Collocation<W> {
    /// A run of `chain` from the state `y0` over `span`, whose windows are solved by `windows`:
    /// these stand at `y0`.
    ///
    /// # Errors
    /// A span, a pace or a state outside its rule.
    pub fn by<C: ContactChain<S>, const S: usize>(
        windows: W,
        chain: &C,
        y0: &[f64],
        span: (f64, f64),
        pace: Pace,
    ) -> Result<Self, Error> {
        crate::dop853::check_start(chain.dim(), y0, span)?;
        Self::by_paths(windows, chain, &|i| chain.path(y0, i), span, pace)
    }

    /// The same from the paths of sites, which are asked for from the first to the last.
    ///
    /// # Errors
    /// A pace outside its rule.
    pub fn by_paths<C: ContactChain<S>, const S: usize>(
        windows: W,
        chain: &C,
        start: &dyn Fn(usize) -> Path,
        span: (f64, f64),
        pace: Pace,
    ) -> Result<Self, Error> {
        let control = control(chain, &Links::of(chain), start, span, pace)?;
        Ok(Self::steered(windows, control, (span, pace)))
    }

    fn steered(windows: W, control: Control, (span, pace): ((f64, f64), Pace)) -> Self {
        Self {
            nodes: control.nodes(),
            windows,
            control,
            tol: if let Pace::Tolerance(tol) = pace { tol } else { 0.0 },
            t: Twofold::new(span.0),
            h: 0.0,
            end: Twofold::new(span.1),
            log: false,
            stats: Stats::default(),
            inside: None,
        }
    }

    /// Keeps what contacts do, for [`ContactStepper::tell`].
    #[must_use]
    pub fn logged(mut self) -> Self {
        self.log = true;
        self
    }

    /// The length of the next window, with what drives do in it.
    fn propose(&mut self, left: f64) -> f64 {
        let [smooth, resolved] = self.windows.longest();
        let mut h = self.control.propose(left.min(smooth)).min(smooth).min(resolved);
        for _ in 0..MOST_SHORTENED {
            let shorter = self.windows.foresee(h, self.tol);
            if shorter >= h {
                break;
            }
            h = shorter;
        }
        h
    }

    /// A window of length `h`.
    fn window(&self, h: f64, log: bool) -> Window {
        Window { h, nodes: self.nodes, log, goal: self.control.goal(h) }
    }

    /// Moves what is inside the last window by so much, in so many parts; `false` if one of them
    /// does not settle.
    fn moves_inside(&self, inside: &mut W, by: f64, parts: u32) -> bool {
        let window = self.window(by / f64::from(parts), false);
        (0..parts).all(|_| {
            inside.foresee(window.h, 0.0);
            let settled = inside.solve(&window).failure.is_none();
            inside.advance();
            settled
        })
    }
}

impl<W: Windows> ContactStepper for Collocation<W> {
    fn tell(&self, told: &mut dyn FnMut(&Piece, f64)) {
        let start = self.t.value();
        self.windows.tell(&mut |piece| told(piece, start));
    }
}

impl<W: Windows> Stepper<f64> for Collocation<W> {
    fn dim(&self) -> usize {
        self.windows.dim()
    }

    fn time(&self) -> f64 {
        if self.done() { self.end.value() } else { (self.t + Twofold::new(self.h)).value() }
    }

    fn done(&self) -> bool {
        self.control.done()
    }

    fn step(&mut self) -> Result<(), Error> {
        if self.h > 0.0 {
            self.windows.advance();
            self.t = self.t + Twofold::new(self.h);
            self.h = 0.0;
        }
        self.nodes = self.control.nodes();
        loop {
            let left_to_go = (self.end - self.t).value();
            let h = self.propose(left_to_go);
            let window = self.window(h, self.log);
            let verdict = self.windows.solve(&window);
            self.stats.force_evaluations += verdict.sweeps * self.nodes as u64;
            let Some((bond, residual)) = verdict.failure else {
                self.control.accept(&verdict, h, h >= left_to_go);
                self.h = h;
                self.stats.steps += 1;
                return Ok(());
            };
            self.stats.rejected += 1;
            if !self.control.reject(h) {
                return Err(Error::NoContraction { t: self.t.value(), h, bond, residual });
            }
        }
    }

    /// The state inside the last window is that of a window that ends there: as accurate as at its
    /// end.
    fn sample(&mut self, t: f64, y: &mut [f64]) {
        let mut inside = self.inside.take().unwrap_or_else(|| self.windows.duplicate());
        inside.copy_from(&self.windows);
        let by = (Twofold::new(t) - self.t).value();
        if self.h > 0.0 && (t >= self.time() || by >= self.h) {
            inside.advance();
        } else if by > 0.0 && self.h > 0.0 {
            let mut parts = 1;
            while !self.moves_inside(&mut inside, by, parts) {
                inside.copy_from(&self.windows);
                parts *= 2;
                if parts > MOST_PARTS {
                    // No state is better than a wrong one.
                    return self.windows.lose(y);
                }
            }
        }
        inside.store(y);
        self.inside = Some(inside);
    }

    fn stats(&self) -> Stats {
        self.stats
    }
}
