//! Contact collocation: an integrator that gives every contact a time mesh of its own. It keeps a
//! high order through contacts, at a cost linear in the length of the chain.
//!
//! | symbol | meaning |
//! |---|---|
//! | `g_n, f_n` | overlap and force of bond `n`; `f_n = (g_n)_+^alpha` |
//! | `K(t) = m t + mu sin(omega t)/omega` | displacement by a unit impulse, [`Response`] |
//! | *window* | a time step `[0, h]`; it is solved at once, for the whole chain |
//! | *contact* | a time interval in which a bond is closed, from *onset* to *release* |
//! | *panel* | a part of a contact on which the force is smooth in a variable `x` in `[-1, 1]` |
//! | *sweep* | one iteration: overlaps from all forces, then forces from overlaps, bond by bond |
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
//! two, `int K_l (f_{n-1} - f_n) + int K_r (f_{n+1} - f_n)`; see [`ContactChain`]. The equations
//! need no common time mesh: each bond may have its own panels, placed where its own contacts begin
//! and end. A method that stops the whole chain at every event does work of order `N^2` a period;
//! this one of order `N`.
//!
//! # The panels
//!
//! Where a contact begins or ends, `f` goes like the power `alpha` of the distance in time. In
//! `sigma = |t - t_o|^{1/q}`, with the event `t_o` as origin, `f` is analytic if `q alpha` is an
//! integer (`q` = 2 for spheres, 1 for integers, where the variable is time), else smooth to order
//! `q (alpha + 1) >= 8`. A panel has `M` Gauss nodes in `sigma`. Its origin may lie before the
//! window (at an onset, which is kept with the contact) or after it (at a release, which is looked
//! for up to one and a half windows ahead): a singularity near the panel spoils the interpolation
//! as one at its end does.
//!
//! A contact of a neighbour that begins at `t'` adds to `g_n` a term `(t - t')^{alpha + 2}` after
//! `t'`; one that ends at `t'` adds `(t' - t)^{alpha + 2}` before `t'`. So panels are cut at `t'`
//! too, with the same kind of variable on the singular side. Where both ends are singular the panel
//! is cut once more in the middle. Without these cuts the order is about `alpha + 3`; with them
//! doubling the nodes squares the error, as in Gauss quadrature. Graded panels, ever shorter
//! towards `t'`, reach the same error with three times the panels.
//!
//! # The sweep
//!
//! `K(t - s)` is separable in `1, t, cos(omega t), sin(omega t)`. From `f` at the nodes one fixed
//! matrix (antiderivatives of the Lagrange polynomials) gives `int f`, `int s f`, `int f cos`,
//! `int f sin` up to every node, and these give the displacement by the force up to every node. It
//! is kept as one short series in `x`, which neighbours evaluate at their nodes; after the panel's
//! end the displacement is a path `A + B t + C cos + D sin`. A sweep computes overlaps from the
//! displacements, then the forces `f_n = (g_n)_+^alpha` at the nodes, and corrects the ends of
//! contacts by Newton's method on the interpolant of `g_n`. Sweeps are repeated, bond after bond
//! (Gauss-Seidel), until no impulse changes. Newton's method takes the slope between the two nodes
//! nearest to the event; the slope from the search for contacts is that of a chord which may span
//! half of a short contact. A sweep contracts by about `alpha g^{alpha-1} h^2/6`. The first forces
//! are those at the overlaps which forces `f_0 + f_0' t + b t^2` make, where `b` is chosen to meet
//! the force predicted at the window's end. A bond is swept again only if its own force or that of
//! a neighbour has changed; one that stays open is not swept at all.
//!
//! Contacts are first found in the predicted overlap, a cubic plus a bounded remainder, from the
//! signs of its coefficients in Bernstein's basis; where these do not decide, by subdivision under
//! a bound for `g''`. This search also gives a bound on how far the overlap may be off without a
//! change of the contacts. After the sweeps, every bond that may be off by more is searched again
//! with the forces found. A window stands only if its contacts are those of this search: as many,
//! and each with half of its time in common with the one found. The search evaluates overlaps and,
//! where contacts dissipate, their rates; it knows nothing of Newton's steps, which may have led a
//! contact to next to no time and to no force.
//!
//! # The error
//!
//! The last terms of the Chebyshev series of each impulse tell whether the nodes resolve the force.
//! Panels whose last terms are too large are halved in their variable, for that bond only. A window
//! whose sweeps do not converge is given up, and half its length is tried for the whole chain.
//!
//! A window is given up too if it is too long for its contacts, including those that begin in it:
//! few nodes may take a whole contact for something else with no sign of it in their last terms.
//! Before anything is solved, each bond bounds the overlap that it may reach, by its free path and
//! by the overlap at which its own force has stopped the approach. `f'(g) t^2` must be below a
//! limit, where `g` is this bound and `t` the time that a contact may last in the window.
//!
//! Where panels are halved often they get four nodes more; while all bonds are closed and last
//! terms are far below those allowed, four less for `T >= 1e-10`, but at least eight for
//! `T < 1e-5`. Windows have the length of least cost: `f'(g) h^2` is moved up or down, in the
//! direction in which the work for a unit of time falls. Work is counted, not timed, so that a run
//! has the same bits every time.
//!
//! Local errors go with a power 5/4 of the last terms, which was measured. If an overlap falls to
//! almost nothing without an event, the last terms of its force fall slowly; there the error is
//! taken to be proportional to them. A force with last terms above 0.3 of its largest value is not
//! resolved, however small these terms are beside the velocities: where resonators are much faster
//! than contacts, each of thousands of windows moves little, and would be wrong by most of it, with
//! the same sign. A tolerance is for the sum of local errors over the run, relative to the size of
//! the state. It does not include how the dynamics amplifies local errors.
//!
//! A sweep is the last when the next would change impulses by less than a hundredth of the window's
//! share of the tolerance. An error that grows like `t^{2n}`, as it does after `n` sweeps, shrinks
//! by `4 f' h^2/((2n+1)(2n+2))` in the next.
//!
//! # Sums
//!
//! The state of a site is `[R0, V, C, S]` and a phase `omega t` in twice the working precision.
//! Without damping only impulses change `V`, `C` and `S`; `R0` also moves on by `V h`. Each sum
//! keeps its rounding error. Sweeps and the search for events go on until their error is below the
//! roundings, since it is biased and adds up over windows. The energy error is then a random walk
//! of roundings: 1e-13 after 10^6 periods of a breather (measured).
//!
//! # Damping and drives
//!
//! A damped site has other functions of time in the place of `t`, `cos` and `sin`, as series, see
//! `flow.rs`; between windows its path is moved on by the same series. The position of a site that
//! a drive moves is a known part of the overlaps of its bonds, and so is the displacement of a site
//! that a drive pushes (`prescribed.rs`). The energy that is dissipated and the work of drives are
//! integrated over each window (`open.rs`). Windows end where a signal is not smooth, and are short
//! enough for all series to be resolved.
//!
//! A contact that dissipates has the force `f = (F + c g')_+`. Its panels have the rates of the
//! overlap at their nodes too, `int K' [..]`; the part of them that the panel's own forces make is
//! solved for directly (`loss.rs`). Such a contact ends where its force comes to zero, while beads
//! still overlap, and may begin again while they overlap (`dissipative.rs`).
//!
//! # Files
//!
//! A file imports only from files that come before it here:
//!
//! | | |
//! |---|---|
//! | the problem | `chain` |
//! | tools | `kernels`, `series`, `rule`, `detect` |
//! | the motion of sites | `flow`, `prescribed`, `open`, `link`, `sites` |
//! | forces on panels | `goal`, `panel`, `panels`, `bond` |
//! | bonds over a window | `motion`, `loss`, `layout`, `predict`, `dissipative`, `sweep` |
//! | windows | `window`, `pieces`, `ledger`, `block`, `derivative`, `solver`, `section` |
//! | runs | `control`, `stepper`, `tangent` |
//!
//! # Limits
//!
//! - `alpha < 1`: the force has an infinite slope at onsets; the predictions there are poor,
//!   windows short, and tangent maps do not exist.
//! - Resonators so light that they oscillate many times in a window are resolved where contacts
//!   excite them: the cost then grows with `omega`.
//! - Overlaps whose force over a window is too small to matter at the tolerance are taken as zero,
//!   also in the log of contacts.
//! - The method is not symplectic: its energy error is the sum of its local errors, down to a
//!   random walk of roundings.
//!
//! Source: this software. For Gauss collocation: Hairer, Lubich & Wanner 2006, *Geometric Numerical
//! Integration*, Sec. II.1.

#![allow(clippy::needless_range_loop, reason = "loops over nodes read like the formulas, and vectorise")]

mod block;
mod bond;
mod chain;
mod control;
mod derivative;
mod detect;
mod dissipative;
pub(crate) mod flow;
mod goal;
mod kernels;
mod layout;
mod ledger;
mod link;
pub(crate) mod loss;
mod motion;
mod open;
mod panel;
mod panels;
mod pieces;
mod predict;
mod prescribed;
mod rule;
mod section;
mod series;
mod sites;
mod solver;
mod stepper;
mod sweep;
mod tangent;
mod window;

pub use chain::{ContactChain, Drive, Path, Response};
pub use goal::StepControl;
pub(crate) use rule::Rule;
pub use stepper::{Collocation, ContactStepper};
pub use tangent::{Tangent, monodromy};
pub use window::Piece;
