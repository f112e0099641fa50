//! Contact-corrected splitting: order four through contacts, for one sweep over the forces a step.
//!
//! | symbol | meaning |
//! |---|---|
//! | `g, g'` | overlap of a bond and its rate |
//! | `f = (g)_+^alpha` | its force; `V = (g)_+^{alpha+1}/(alpha+1)` its potential |
//! | `h; t_k = k h` | step; times of kicks |
//! | `t_e` | time of an event: an *onset* (the bond closes) or a *release* (it opens) |
//! | `theta` | steps from an event to the nearest kick at which the bond is closed, in `[0, 1]` |
//! | `c, a` | speed `abs(g')` at an event; acceleration of the overlap there by everything but the bond's own force |
//! | `s` | acceleration of the overlap by the forces of all other bonds |
//! | `zeta(z, theta)` | Hurwitz' zeta function, the finite part of `sum_{k >= 0} (k + theta)^{-z}` |
//!
//! # Why contacts lower the order
//!
//! Between kicks every site moves exactly. The error of a kicked run is therefore one of quadrature
//! only: kicks at `t_k` replace the integrals `int f(s) K(t - s) ds` of the variation of constants
//! by sums. For a smooth force the formula of Euler and Maclaurin says that the sum differs from
//! the integral by terms at the two ends of the run, in even powers of `h`. A force that begins at
//! `t_e` like `C tau^alpha + D tau^{alpha+1} + ..`, `tau = t - t_e`, is not smooth. The generalised
//! formula (Navot 1961) adds, for every event,
//!
//! ```text
//! h sum f(t_k) - int f dt           =  C h^{alpha+1} zeta(-alpha, theta) + D h^{alpha+2} zeta(-alpha-1, theta) + ..
//! h sum (t_k-t_e) f - int (t-t_e) f =  C h^{alpha+2} zeta(-alpha-1, theta) + ..
//! ```
//!
//! These terms account for all kicks near the event, not only for the nearest one. A release is the
//! mirror image, counted from the last kick inside. Since the number of events does not depend on
//! `h`, every splitting with kicks at given times has an error of order `alpha + 1`, whatever its
//! order on smooth problems.
//!
//! # The correction
//!
//! Let `E[.]` be the sum minus the integral above. It is known as soon as the event is, and is
//! taken back: the bond gets the impulse `-E[f]` and the displacement `E[(t-t_e) f]`, both acting
//! at `t_e`. Both are derivatives of one function. Let `W` be the singular part of the quadrature
//! error of the *potential* along the path of the bond,
//!
//! ```text
//! W(g, g') = h^{alpha+2} [ c^{alpha+1} zeta(-alpha-1, theta)/(alpha+1) + c^alpha (a h/2) zeta(-alpha-2, theta) ]
//! impulse = -dW/dg,    displacement = dW/dg'
//! ```
//!
//! where `theta` and `c` are functions of overlap and rate at a fixed time, through the zero of the
//! path. (`d zeta(z, theta)/d theta = -z zeta(z+1, theta)`.) The correction is the canonical map
//! that `-W` generates, as a step of the implicit midpoint rule in `(g, g')`.
//!
//! `W` is smooth where an event meets a kick. For `theta -> 0` its singular term is `h^{alpha+2}
//! c^{alpha+1} theta^{alpha+1}/(alpha+1) = h V(g)`, so that the impulse `-dW/dg` cancels this kick,
//! and the rest of `W` counts from the next one.
//!
//! # The kernel
//!
//! On smooth stretches Strang's step has an error of `h^2`. Processing removes it: a kick with the
//! force
//!
//! ```text
//! F = f + (h^2/12) f'(g) s_n,     s_n the acceleration of the overlap by all forces
//! ```
//!
//! (the gradient of the potential `V - (h^2/24) |grad V|^2` of Takahashi and Imada) makes Strang's
//! step conjugate to a method of order four. The conjugation moves positions by `h^2/12` times the
//! accelerations by the kick, and velocities by `-h^2/12` times the rates of these accelerations.
//! It is applied forward where a state is sampled, and backward at the start. These are the end
//! terms of Euler and Maclaurin; they are applied by one explicit midpoint step, whose error of
//! order `h^6` does not add up.
//!
//! Since `f(g) + (h^2/12) f'(g) s` is the force at the processed overlap `g + (h^2/12) s`, but for
//! `O(h^4)`, events are those of the processed path: this includes the singular part of the
//! modified force in `W`, and makes `t_e` the time of the event itself.
//!
//! # Which path
//!
//! `theta` must be right to `O(h^2)`, hence `t_e` to `O(h^3)`. Between two kicks the kernel moves
//! along the exact flow of the drift, a chord of the smooth path through its positions at the
//! kicks. The smooth path differs from the chord by a motion that vanishes at both kicks. It has
//! the acceleration `s(t)`, linear in time between the accelerations by all other bonds at the two
//! kicks. The bond's own force is left out: it is `O(tau^alpha)` near the event, and moves the path
//! by `O(h^{alpha+2})`. This is the path of [`BondPath`]: right to `O(h^4)` in `t_e`, with the
//! exact oscillation of resonators, so that `omega h` need not be small for it. As both kicks enter
//! alike, and the chord and the midpoint rule are symmetric, the correction of a step is its own
//! reverse in time, like the kernel. With a constant `s` from the later kick the order is the same,
//! but the energy of a random ring drifts in proportion to time (measured); with the linear `s` it
//! does not.
//!
//! # Remaining errors
//!
//! | source | error of an event | remark |
//! |---|---|---|
//! | next singular terms: the rate of `s`, the curvature of `f` | `h^{alpha+3}` | at least 4 for `alpha >= 1` |
//! | the bond's own force in its path; the square of that force in the modified force; an event of a neighbour in the same step, whose force enters `s` like `tau^alpha` | `h^{2 alpha+2}` | at least 4 |
//! | *grazing*: an overlap that turns within a few steps of its zero, seen by the kicks or not (see `graze`) | `a^alpha h^{2 alpha+2}` | at least 4 |
//! | a run that starts, or a state that is sampled, within a few steps of a grazing event | `a^alpha h^{2 alpha+1}` times a few hundredths | below 4 for `alpha < 3/2`, in that run or state alone |
//!
//! No term of order `h^{alpha+2}` remains: the second-order terms of the averaging are products of
//! two quadrature errors. The product of a bond's event with the smooth force of its neighbours is
//! in the modified force, above. That with the smooth force of springs is zero, since the drift
//! contains the springs. The product of two events in one step, or of an event with itself, has a
//! factor `h^{alpha+1}` for each. The second term of `W` is multiplied by `1/(1 + (a h/c)^8)`, for
//! the sake of grazing events: else its derivative has a pole at `c = 0`, of order `2 - alpha`. The
//! error of a grazing event that this `W` leaves is known, and the bond gets a correction for it at
//! the turning point.
//!
//! Kicks next to an event differ from the force of the processed path: `f(g) + (h^2/12) f'(g) s` is
//! zero where `g` is not yet positive but `g + (h^2/12) s` is, and `f''` is large. The difference,
//! an impulse of up to `h (s h^2/12)^alpha`, is given to the bond for the two kicks around the
//! event: the derivative of `h (V(g + e) - V(g) - e f(g))`, `e = (h^2/12) s`.
//!
//! For integer `alpha` the zeta functions are the polynomials of Bernoulli, and the formulas hold
//! as they are. For `alpha < 1` the modified force is not bounded at an event: such exponents are
//! refused.
//!
//! The next terms (`zeta(-alpha-3)`, the rate of `s`, the bias of the centred rate) were tried:
//! they change no error by more than a few percent, since the smooth error of order `h^4` is the
//! larger one. Extrapolation of two runs (Richardson) removes the smooth error and leaves about
//! order 5: at 1.5 times the work an error 20 to 60 times smaller between 1e-8 and 1e-11. One run
//! would need 1.4 to 1.9 times the work of the two for the same error. Extrapolation is not built
//! in, since its result is no canonical map of the initial state.
//!
//! # Ends
//!
//! A state that is sampled within a few steps of an event needs the end terms of the singular
//! force, which are zeta functions too: see `ends`.
//!
//! # How far the method is symplectic
//!
//! In `(g, g')` of its bond each correction is canonical up to the error of the iterated midpoint
//! rule. `s` at both kicks depends on the positions of neighbours: exact symplecticity would need
//! impulses `-(dW/ds) f'(g_m)/2` on neighbours at both kicks, the first of which is past when the
//! event is found. These impulses are of order `h^{alpha+3}`, and are left out; with the one at the
//! second kick the energies of long runs were no better (measured).
//!
//! # Literature
//!
//! We know of no publication of this method. Near it come: Navot 1961, *J. Math. and Phys.* 40, 271
//! (the Euler-Maclaurin formula for end points with an algebraic singularity); Takahashi & Imada
//! 1984, *J. Phys. Soc. Jpn.* 53, 3765, and Rowlands 1991, *J. Comput. Phys.* 97, 235 (the modified
//! force, processed); Lopez-Marcos, Sanz-Serna & Skeel 1997, *SIAM J. Sci. Comput.* 18, 223;
//! Blanes, Casas & Ros 1999, *SIAM J. Sci. Comput.* 21, 711 (processing); Wisdom, Holman & Touma
//! 1996, *Fields Inst. Commun.* 10, 217 (symplectic correctors); Kapur & Rokhlin 1997, *SIAM J.
//! Numer. Anal.* 34, 1331 (quadrature corrected at singular end points); Tao & Jin 2022, *J.
//! Comput. Phys.* 450, 110846 (potentials with jumps, where reversible maps do well over long times
//! too).

mod bonds;
pub(crate) mod ends;
pub(crate) mod event;
pub(crate) mod graze;
mod log;
pub(crate) mod pack;
pub(crate) mod path;
mod zeta;

pub use bonds::{BondFlow, BondView, Correction, Side};
pub use path::BondPath;
pub use zeta::hurwitz;

use super::{
    stepper::{mirrored, steps_a_row},
    steps::Steps,
};
use crate::{
    clock::DoubleDouble,
    collocation::{ContactStepper, Piece},
    drive::Stepper,
    error::Error,
    interrupt,
    stats::Stats,
};
use ends::Ends;
use event::Corrector;
use graze::{Extrema, Extremum, REACH};
use log::Log;
use std::cell::OnceCell;

/// Range of the exponents `alpha` that the method accepts.
const EXPONENTS: std::ops::RangeInclusive<f64> = 1.0..=10.0;

/// The parts of the method that a run uses in addition to plain kicks. Either part alone has the
/// order of Strang's splitting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Kicks with the forces of Takahashi and Imada, between processed ends.
    pub processed: bool,
    /// Corrections at onsets and releases.
    pub corrected: bool,
}

impl Parts {
    /// Contact-corrected splitting.
    pub const ALL: Self = Self { processed: true, corrected: true };
    /// The processed kernel of Takahashi and Imada by itself, which is symplectic.
    pub const PROCESSED: Self = Self { processed: true, corrected: false };
    /// Strang's splitting with corrections.
    pub const CORRECTED: Self = Self { processed: false, corrected: true };
}

/// Contact-corrected splitting at work, in equal steps, with a kick at both ends of each.
///
/// The state inside is that of the kernel; [`sample`](Stepper::sample) processes a copy.
pub struct Corrected<S> {
    flow: S,
    /// The copy of the flow for samples; made at the first sample.
    mirror: Option<S>,
    parts: Parts,
    /// The corrections at events and at turning points, with their tables; each made at its first
    /// use.
    corrector: OnceCell<Corrector>,
    turns: OnceCell<Extrema>,
    /// Bonds that changed their side in the step, and whether they are closed now.
    changed: Vec<(usize, bool)>,
    /// Bonds whose overlap turned near zero at the kick before, and whether they were closed there.
    turned: Vec<(usize, bool)>,
    /// The motions of the bonds of `changed`, and their corrections.
    events: Vec<(BondView, bool)>,
    corrections: Vec<Option<Correction>>,
    sides: Vec<Side>,
    log: Option<Log>,
    steps: Steps<f64>,
    /// Duration of the kick that the state still lacks: it is made together with the drift and the
    /// evaluation that follow it.
    due: Option<f64>,
    /// The (kick, drift) pairs of as many steps as are made in a row.
    row: Vec<(f64, DoubleDouble<f64>)>,
}

impl<S: BondFlow> Corrected<S> {
    /// Runs `flow`, which holds the state at `start`, to `end` in `steps` equal steps.
    ///
    /// # Errors
    /// `end < start`, times that are not finite, no step for a span that is not empty, or an
    /// exponent below 1 or above 10.
    pub fn new(mut flow: S, span: (f64, f64), steps: u64, parts: Parts) -> Result<Self, Error> {
        let steps = Steps::new(span, steps)?;
        let alpha = flow.exponent();
        if !EXPONENTS.contains(&alpha) {
            let rule = "processed kicks and corrections are for exponents from 1 to 10";
            return Err(Error::Argument { name: "alpha", value: alpha, rule });
        }
        let (h, total) = (steps.h, steps.total);
        flow.prepare(h.value(), REACH);
        flow.evaluate();
        let mut new = Self {
            mirror: None,
            parts,
            corrector: OnceCell::new(),
            turns: OnceCell::new(),
            changed: Vec::with_capacity(flow.bonds()),
            turned: Vec::with_capacity(flow.bonds()),
            events: Vec::with_capacity(flow.bonds()),
            corrections: Vec::with_capacity(flow.bonds()),
            sides: vec![Side::Open; flow.bonds()],
            log: None,
            steps,
            due: Some(0.5 * h.value()),
            row: vec![(h.value(), h); steps_a_row(flow.moved())],
            flow,
        };
        // The sides of bonds at the start are those of the solution, not those of the kernel's
        // state.
        new.flow.changed(&mut new.changed);
        if parts.processed && total > 0 {
            let ends = Ends { h: h.value(), corrector: parts.corrected.then_some(&new.corrector) };
            ends.to_kernel(&mut new.flow, &mut new.sides);
        }
        new.flow.evaluate();
        Ok(new)
    }

    /// Keeps a log of contacts, for [`ContactStepper::tell`]. To be called before the first step.
    #[must_use]
    pub fn logged(mut self) -> Self {
        self.kick_now();
        self.log = Some(Log::new(&self.flow, self.steps.h.value()));
        self
    }

    /// Makes the kick that is due. Runs with a log need it at once, as the log reads the state
    /// after it.
    fn kick_now(&mut self) {
        let share = self.share();
        if let Some(kick) = self.due.take() {
            self.flow.kick(kick, share);
        }
    }

    /// A copy of the flow that holds the solution at the time reached: half of the last kick is
    /// taken back, and the state is processed.
    pub fn solution(&mut self) -> &S {
        let (h, share) = (self.steps.h.value(), self.share());
        let mirror = mirrored(&mut self.mirror, &self.flow);
        if let Some(kick) = self.due {
            mirror.kick(kick, share);
        }
        mirror.kick(-0.5 * h, share);
        if self.parts.processed && self.steps.total > 0 {
            let ends = Ends { h, corrector: self.parts.corrected.then_some(&self.corrector) };
            ends.to_solution(mirror, &mut self.sides);
        }
        mirror
    }

    /// The share of the modified force, `h^2/12`.
    fn share(&self) -> f64 {
        if self.parts.processed { self.steps.h.value() * self.steps.h.value() / 12.0 } else { 0.0 }
    }

    /// Makes the corrections that the evaluation at the end of a step calls for. `inner`: whether
    /// this is not the first step of the run.
    fn see(&mut self, inner: bool) {
        if self.parts.corrected || self.log.is_some() {
            self.changed.clear();
            self.flow.changed(&mut self.changed);
            if !self.changed.is_empty() {
                self.correct();
            }
        }
        // A turning point at the kick before needs a kick of this run on either side.
        if self.parts == Parts::ALL && inner {
            self.turned.clear();
            self.flow.turned(&mut self.turned);
            if !self.turned.is_empty() {
                self.correct_turns();
            }
        }
    }

    /// Corrects the bonds whose overlap turned near zero about the kick before: by the error that
    /// the corrections of their events, if they had any, leave.
    fn correct_turns(&mut self) {
        let (h, alpha) = (self.steps.h.value(), self.flow.exponent());
        let corrector = self.corrector.get_or_init(|| Corrector::new(alpha, h));
        let turns = self.turns.get_or_init(|| Extrema::new(alpha));
        for &(bond, closed) in &self.turned {
            let turn = Extremum { view: self.flow.view(bond, h), closed };
            if let Some(graze) = turns.correction(&turn, corrector) {
                self.flow.correct([(bond, &graze.correction)].into_iter());
                if let Some(log) = &mut self.log {
                    log.graze(bond, &graze);
                }
            }
        }
    }

    /// Corrects the bonds that have changed their side in the step that ends now.
    fn correct(&mut self) {
        let (h, alpha) = (self.steps.h.value(), self.flow.exponent());
        let Self { flow, changed, events, corrections, corrector, .. } = self;
        let corrector = corrector.get_or_init(|| Corrector::new(alpha, h));
        events.clear();
        corrections.clear();
        events.extend(changed.iter().map(|&(bond, onset)| (flow.view(bond, h), onset)));
        corrector.corrections(events, corrections);
        let told = changed.iter().zip(&*corrections);
        flow.correct(told.clone().filter_map(|(&(bond, _), correction)| Some((bond, correction.as_ref()?))));
        if let Some(log) = &mut self.log {
            told.for_each(|(&(bond, onset), correction)| log.event(bond, onset, *correction));
        }
    }
}

impl<S: BondFlow> Stepper<f64> for Corrected<S> {
    fn dim(&self) -> usize {
        self.flow.dim()
    }

    fn time(&self) -> f64 {
        self.steps.reached().value()
    }

    fn done(&self) -> bool {
        self.steps.done()
    }

    fn step(&mut self) -> Result<(), Error> {
        interrupt::check(self.time())?;
        let (h, share) = (self.steps.h.value(), self.share());
        if let Some(kick) = self.due.take() {
            self.flow.kicks_and_evaluations(&[(kick, self.steps.h)], share, false);
        } else {
            self.flow.drift(self.steps.h);
            self.flow.evaluate();
        }
        self.see(self.steps.taken > 0);
        self.due = Some(h);
        self.steps.taken += 1;
        if self.log.is_some() {
            self.kick_now();
            let time = self.time();
            self.log.iter_mut().for_each(|log| log.step(&self.flow, time));
        }
        Ok(())
    }

    fn steps(&mut self, wanted: Option<f64>) -> Result<(), Error> {
        if self.log.is_some() || self.steps.taken == 0 {
            return self.step();
        }
        interrupt::check(self.time())?;
        let mut left = self.steps.in_row(wanted, self.row.len());
        let (share, watched) = (self.share(), self.parts.corrected);
        while left > 0 {
            let made = self.flow.kicks_and_evaluations(&self.row[..left], share, watched);
            self.see(true);
            self.steps.taken += made as u64;
            left -= made;
        }
        Ok(())
    }

    /// At the end of a step the state is that of [`solution`](Self::solution). Times inside the
    /// last step are reached backwards from its end, by [`BondFlow::back`].
    fn sample(&mut self, t: f64, y: &mut [f64]) {
        let (reached, inside) = (self.steps.reached(), self.steps.inside(t));
        let mirror = self.solution();
        mirror.store(y);
        if inside {
            mirror.back(y, (reached - DoubleDouble::new(t)).value());
        }
    }

    fn stats(&self) -> Stats {
        Stats { steps: self.steps.taken, rejected: 0, force_evaluations: self.steps.taken + 1 }
    }
}

impl<S: BondFlow> ContactStepper for Corrected<S> {
    fn tell(&self, told: &mut dyn FnMut(&Piece, f64)) {
        self.log.iter().flat_map(Log::pieces).for_each(|piece| told(piece, 0.0));
    }
}
