//! A run by contact collocation.

use super::{
    chain::ContactChain,
    control::Control,
    goal::StepControl,
    section::{Held, Section},
    window::{Piece, Window},
};
use crate::{clock::DoubleDouble, drive::Stepper, error::Error, interrupt, stats::Stats};

/// Most parts that the time from the start of a window to a sample inside it is divided into; the
/// sample is lost beyond that. Chosen, not measured.
const MOST_PARTS: u32 = 1 << 10;

/// Most times that a window is shortened because it does not resolve a drive, each by a tenth at
/// least. Chosen: if a signal is still not resolved then, its last terms are rounding.
const MOST_SHORTENED: u32 = 40;

/// Largest error of a largest overlap that is logged, in tolerances: if it may be larger, the
/// window is solved again for the log, in as many parts as it takes, up to `MOST_LOGGED`. Chosen.
const LOGGED: f64 = 16.0;
const MOST_LOGGED: u32 = 8;

/// A stepper that logs what contacts do.
pub trait ContactStepper: Stepper<f64> {
    /// Calls `told` with every [`Piece`] of the last step, and the time from which the times in the
    /// piece count.
    fn tell(&self, told: &mut dyn FnMut(&Piece, f64));
}

/// A run by contact collocation. It chooses the length of each window and the accuracy that it must
/// reach, and accepts it or tries a shorter one.
pub struct Collocation<C, const S: usize = 1> {
    pub(super) section: Section<C, S>,
    pub(super) control: Control,
    /// Relative tolerance of the run; zero if the windows are given.
    tol: f64,
    /// Start time of the last window, its length and its number of nodes a panel; the length is
    /// zero before the first window.
    pub(super) t: DoubleDouble<f64>,
    pub(super) h: f64,
    nodes: usize,
    /// End of the run, a time.
    end: DoubleDouble<f64>,
    /// Whether windows keep what contacts do.
    log: bool,
    pub(super) stats: Stats,
    /// A copy that is moved to samples inside the last window; made at the first of them.
    inside: Option<Section<C, S>>,
    /// What contacts did in the last window, each with the time from which its times count.
    told: Vec<(Piece, f64)>,
}

impl<C: ContactChain<S>, const S: usize> Collocation<C, S> {
    /// A run from the state `y0` over `span`, of a chain whose bonds see `S` different sites, see
    /// [`ContactChain`].
    ///
    /// # Errors
    /// A span, a step control or a state outside its rule.
    pub fn new(chain: C, y0: &[f64], span: (f64, f64), step_control: StepControl) -> Result<Self, Error> {
        Self::on_threads(chain, y0, span, step_control, None)
    }

    /// As [`new`](Self::new), on at most `threads` threads; `None` stands for all that there are.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn on_threads(
        chain: C,
        y0: &[f64],
        span: (f64, f64),
        step_control: StepControl,
        threads: Option<usize>,
    ) -> Result<Self, Error> {
        crate::dop853::check_start(chain.dim(), y0, span)?;
        let section = Section::new(chain, (y0, span.0), threads);
        let (Held { chain, links, .. }, end) = (&*section.held, DoubleDouble::new(span.1));
        let length = end - DoubleDouble::new(span.0);
        let control = Control::new((chain, links), &|i| chain.path(y0, i), step_control, length)?;
        Ok(Self {
            nodes: control.nodes(),
            section,
            control,
            tol: if let StepControl::Tolerance(tol) = step_control { tol } else { 0.0 },
            t: DoubleDouble::new(span.0),
            h: 0.0,
            end,
            log: false,
            stats: Stats::default(),
            inside: None,
            told: Vec::new(),
        })
    }

    /// The start time of the last window, and what contacts did in it, in the order of bonds, if
    /// that is logged.
    pub fn pieces(&self) -> (f64, impl Iterator<Item = &Piece>) {
        (self.t.value(), self.section.pieces())
    }

    /// Keeps what contacts do, for [`ContactStepper::tell`].
    #[must_use]
    pub fn logged(mut self) -> Self {
        self.log = true;
        self
    }

    /// The length of the next window, when `left` is left of the span; prepares what drives do in
    /// this window.
    fn propose(&mut self, left: f64) -> f64 {
        let [smooth, resolved] = self.section.longest();
        let mut h = self.control.propose(left.min(smooth)).min(smooth).min(resolved);
        for _ in 0..MOST_SHORTENED {
            let shorter = self.section.predict_drives(h, self.tol);
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

    /// Moves `inside` on by the time `by`, in `parts` windows of equal length; `false` if one of
    /// them does not converge. Appends to `log`, if there is one, what contacts do.
    fn moves_inside(
        &self,
        inside: &mut Section<C, S>,
        (by, parts): (f64, u32),
        mut log: Option<&mut Vec<(Piece, f64)>>,
    ) -> bool {
        let window = self.window(by / f64::from(parts), log.is_some());
        (0..parts).all(|k| {
            inside.predict_drives(window.h, 0.0);
            let settled = inside.solve(&window).failure.is_none();
            let start = (self.t + DoubleDouble::new(f64::from(k) * window.h)).value();
            log.iter_mut().for_each(|log| log.extend(inside.pieces().map(|piece| (*piece, start))));
            inside.advance();
            settled
        })
    }

    /// Takes note of what contacts did in the last window. If the error of a largest overlap inside
    /// it may be too large, the window is solved again, in parts.
    fn take_log(&mut self) {
        let (start, mut log) = (self.t.value(), std::mem::take(&mut self.told));
        log.clear();
        log.extend(self.section.pieces().map(|piece| (*piece, start)));
        let most = if self.tol > 0.0 { LOGGED * self.tol.max(10.0 * f64::EPSILON) } else { f64::INFINITY };
        let mut parts = 1;
        while parts < MOST_LOGGED && log.iter().any(|(piece, _)| piece.error > most) {
            let mut inside = self.inside.take().unwrap_or_else(|| self.section.duplicate());
            inside.copy_from(&self.section);
            parts *= 2;
            let mut finer = Vec::new();
            if self.moves_inside(&mut inside, (self.h, parts), Some(&mut finer)) {
                log = finer;
            }
            self.inside = Some(inside);
        }
        self.told = log;
    }
}

impl<C: ContactChain<S>, const S: usize> ContactStepper for Collocation<C, S> {
    fn tell(&self, told: &mut dyn FnMut(&Piece, f64)) {
        self.told.iter().for_each(|(piece, start)| told(piece, *start));
    }
}

impl<C: ContactChain<S>, const S: usize> Stepper<f64> for Collocation<C, S> {
    fn dim(&self) -> usize {
        self.section.dim()
    }

    fn time(&self) -> f64 {
        if self.done() { self.end.value() } else { (self.t + DoubleDouble::new(self.h)).value() }
    }

    fn done(&self) -> bool {
        self.control.done()
    }

    fn step(&mut self) -> Result<(), Error> {
        if self.h > 0.0 {
            self.section.advance();
            self.t = self.t + DoubleDouble::new(self.h);
            self.h = 0.0;
        }
        self.nodes = self.control.nodes();
        loop {
            interrupt::check(self.t.value())?;
            let left_to_go = (self.end - self.t).value();
            let h = self.propose(left_to_go);
            if self.t + DoubleDouble::new(h) == self.t {
                return Err(Error::StepUnderflow { t: self.t.value(), h });
            }
            let window = self.window(h, self.log);
            let outcome = self.section.solve(&window);
            self.stats.force_evaluations += outcome.sweeps * self.nodes as u64;
            let Some((bond, residual)) = outcome.failure else {
                self.control.accept(&outcome, h, h >= left_to_go);
                self.h = h;
                self.stats.steps += 1;
                if self.log {
                    self.take_log();
                }
                return Ok(());
            };
            self.stats.rejected += 1;
            if !self.control.reject(h) {
                return Err(Error::NoContraction { t: self.t.value(), h, bond, residual });
            }
        }
    }

    /// The state at a time inside the last window is computed by a window that ends at this time,
    /// so that it is as accurate as a state between windows.
    fn sample(&mut self, t: f64, y: &mut [f64]) {
        let mut inside = self.inside.take().unwrap_or_else(|| self.section.duplicate());
        inside.copy_from(&self.section);
        let by = (DoubleDouble::new(t) - self.t).value();
        if self.h > 0.0 && (t >= self.time() || by >= self.h) {
            inside.advance();
        } else if by > 0.0 && self.h > 0.0 {
            let mut parts = 1;
            while !self.moves_inside(&mut inside, (by, parts), None) {
                inside.copy_from(&self.section);
                parts *= 2;
                if parts > MOST_PARTS {
                    // No state is better than a wrong one.
                    return y.fill(f64::NAN);
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
