//! The equations of motion of a chain with details together with their linearisation.
//!
//! | symbol | meaning |
//! |---|---|
//! | `z` | positions and velocities, a state without its ledger |
//! | `W` | columns `dz`, given at the start: `W(t) = dz(t)/dz(0) W(0)` |
//! | `K_n` | on-site spring of a bead |
//! | `k_b` | stiffness `A_b alpha_b (g_b)_+^{alpha_b - 1}` of a contact, plus that of a [`Joint`](super::Joint) |
//!
//! ```text
//! m_n du_n'' = k_n dg_n - k_{n+1} dg_{n+1} - kappa_n (du_n - dv_n) - K_n du_n - c_n du_n' - d_n (du_n' - dv_n')
//! rho_n m_n dv_n'' = kappa_n (du_n - dv_n) + d_n (du_n' - dv_n'),     dg_b = du_{b-1} - du_b
//! ```
//!
//! The force of a contact that does not dissipate is continuous where it begins or ends, so `W` is
//! continuous there: no jump matrix is needed. The stiffness begins like `t^{alpha-1}`, one power
//! of time below the force.
//!
//! # Contacts that dissipate
//!
//! A contact that pushes has the force `f = F(g) + c(g) g'`, with `F = A g^alpha` and `c = gamma
//! F'(g)` (viscoelastic) or `c = gamma` (dashpot). Its derivative `F' dg + c' g' dg + c dg'` has
//! two difficulties where beads meet. With a dashpot `f` jumps from 0 to `gamma g'`. With a
//! viscoelastic contact `f` is continuous, but `c' g'` begins like `t^{alpha-2}`. Both disappear
//! with other variables for velocities of beads: `w_nb` is the weight of contact `b` in the force
//! on bead `n` (1 or -1), and the sum is over contacts that push.
//!
//! ```text
//! dp_n = du_n' - (1/m_n) sum_b w_nb c(g_b) dg_b
//! ```
//!
//! As `d/dt (c dg) = c' g' dg + c dg'`, only `w_nb F'(g_b) dg_b / m_n` is left of the contact in
//! `dp_n'`. At an event, with `h` the function that vanishes and `f_-, f_+` the vector fields
//! before and after it, the jump (saltation) matrix is
//!
//! ```text
//! dz_+ = (I + (f_+ - f_-) grad(h)^T / (grad(h)^T f_-)) dz_-
//! ```
//!
//! - *Beads meet*: `h = g_b`. For a dashpot the accelerations jump by `w_nb gamma g_b' / m_n`, and
//!   `grad(h)^T f_- = g_b'`, so that `du_n'` jumps by `w_nb gamma dg_b / m_n`. The speed of
//!   approach cancels. This is the jump of the sum above: `dp_n` is continuous. For a viscoelastic
//!   contact `f_+ = f_-`, so that `du_n'` is continuous; `dp_n` is too, as `c(0) = 0`.
//! - *Beads let go*: `h = f` reaches zero at a positive overlap. Both laws are continuous there,
//!   `f_+ = f_-`, and only the derivative of the force jumps. So `du_n'` is continuous, and the
//!   term of the contact is added to `dp_n`. It is subtracted again where `f` rises through zero
//!   while beads overlap.
//!
//! Both kinds of jumps have the determinant 1, as they add positions to velocities. So by Liouville
//! contacts contribute the factor `exp(-int sum_b c(g_b) sum_n w_nb^2/m_n dt)` to the determinant,
//! the sums over contacts that push and beads that no drive moves.
//!
//! # Beads that touch at rest
//!
//! Where a chain whose beads just touch is struck, overlaps begin at `g = g' = 0`: the division by
//! `grad(h)^T f_-` above is 0/0, and the first values of `g_b` are below rounding. Their signs say
//! nothing. But `p` may be taken for the state, too, with `p_n = u_n' - (1/m_n) sum_b w_nb C(g_b)`
//! and `C' = c`, `C(g) = 0` for `g <= 0`. In it a contact that pushes has
//!
//! ```text
//! u_n' = p_n + (1/m_n) sum_b w_nb C(g_b),     p_n' = (1/m_n) sum_b w_nb F(g_b) + ...
//! ```
//!
//! - *Viscoelastic*: `C = gamma F`. The right hand side has a continuous derivative at `g = 0`, and
//!   it is zero there. So the flow has a derivative, and there is no jump, whatever the rate is. A
//!   contact that counts as pushing has no force, stiffness and resistance for `g <= 0`: it may
//!   count as pushing from the start. To count it as pushing only from an overlap `e` on that it
//!   reaches after the time `s` would change columns by up to `F'(e) s |dg|/m`; this goes like
//!   `e^{alpha-1}` and is no rounding even if `e` is.
//! - *Dashpot*: `C = gamma (g)_+` has a kink. If `g > 0` after the start, the kink matters at the
//!   start only. Columns with `dg = 0` there have a derivative: that of a contact which pushes from
//!   the start on. For columns with `dg != 0` a gap costs the impulse `gamma |dg|`, and an overlap
//!   gains none: the derivatives on the two sides differ by `gamma dg/m`, there is none.
//!   [`Variations::flow`] refuses such columns. So it does where beads touch at rest for longer, as
//!   beyond a gap that the wave has not closed, and a column changes their overlap or its rate.
//!
//! Without dissipation the flow has a derivative at `g = g' = 0`, too, and the same holds.
//!
//! So values inside the band at the start count as positive until they are below zero by more than
//! the error of a step ([`EventFunctions::told`](hertzchain_integrators::EventFunctions::told)). An
//! event that was found within such errors, and after which its function goes back to where it came
//! from, is taken back.

use super::{
    Chain, Details, Field, Overlaps, Parameter, Resonators,
    details::{CheckedDetails, Pushing, Switched},
    max_norm,
    natural::Natural,
};
use crate::{
    error::{Error, Result, SMOOTH, refuse, require},
    numerics::unit,
};
use hertzchain_integrators::{Real, Regularised, Stepper, VectorField, dop853::Options, kernel};

/// A state and the columns `W` that the linearised flow carries along, in one vector: the state,
/// then `W` row by row. If contacts dissipate, the last entry is
/// [`contraction`](Varied::contraction), and rows of velocities of beads are `dp`. The field must
/// then be told the signs of functions that are positive where contacts push, as [`Regularised`]
/// does; until then no contact pushes, and `dp` is `du'`.
pub struct Variations<R> {
    chain: Chain<R>,
    field: Field<R>,
    columns: usize,
    /// The numbers whose sources the first columns have.
    by: Vec<Parameter>,
    /// Change of the overlap of a bond in every column.
    change: Vec<R>,
    /// Rows `du'` of beads, if contacts dissipate.
    velocities: Vec<R>,
}

/// A state and columns `W` at the end of a flow.
#[derive(Clone, Debug, PartialEq)]
pub struct Varied<R> {
    /// The state, with its ledger.
    pub state: Vec<R>,
    /// `W`, row by row; a row for each position, then for each velocity.
    pub columns: Vec<R>,
    /// What contacts that dissipate contribute to `-ln det dz(t)/dz(0)`, for beads that no drive
    /// moves; drag and dashpots of resonators contribute the time times a constant.
    pub contraction: R,
}

impl<R: Real> Variations<R> {
    /// The field of a chain and of `columns` columns. A uniform chain counts as one with details.
    ///
    /// # Errors
    /// A strain ring; contacts with an exponent of 1 or less: the derivative of the force jumps;
    /// dashpots that resist as another power of the rate than the first.
    pub fn new(chain: &Chain<R>, columns: usize) -> Result<Self> {
        let chain = match chain.parts() {
            Some(_) => chain.clone(),
            None => chain.clone().with(&Details::default())?,
        };
        let parts = parts(&chain);
        refuse("alpha", parts.exponents().find(|alpha| *alpha <= 1.0), SMOOTH)?;
        let power = parts.given.rate_power.filter(|power| parts.dissipative && *power != 1.0);
        let rule = "1: tangent maps are of dashpots that resist in proportion to the rate";
        power.map_or(Ok(()), |power| Err(Error::parameter("rate_power", power, rule)))?;
        let (field, rows) = match chain.dissipative_contacts() {
            true => (Field::from_event_to_event(chain.clone()), chain.sites()),
            false => (Field::new(chain.clone()), 0),
        };
        Ok(Self {
            field,
            change: vec![R::zero(); columns],
            velocities: vec![R::zero(); rows * columns],
            columns,
            by: Vec::new(),
            chain,
        })
    }

    /// Number of rows of `W`: positions and velocities.
    pub fn rows(&self) -> usize {
        2 * self.chain.layout().half()
    }

    /// Integrates the state `start` and the `columns`, given row by row, over a span by regularised
    /// DOP853.
    ///
    /// Tolerance of a step: relative, and absolute in units of the size of the motion; of a column
    /// at most in units of its size at the start.
    ///
    /// ```
    /// use hertzchain_core::{Boundary, Chain, Params, chain::{Details, Variations}};
    /// // A bead with drag that touches nobody: u' decays, u moves by (1 - e^{-c t})/c of it.
    /// let details = Details { drag: vec![0.5], ..Details::default() };
    /// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 1)?.with(&details)?;
    /// let varied = Variations::flow(&chain, &[0.0, 1.0, 0.0, 0.0, 0.0, 0.0], (0.0, 2.0), &[0.0, 1.0], 1e-12)?;
    /// let decay = (-1.0f64).exp();
    /// assert!((varied.columns[0] - 2.0 * (1.0 - decay)).abs() < 1e-11);
    /// assert!((varied.columns[1] - decay).abs() < 1e-11);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new); columns whose number of entries is no multiple of the rows; a state
    /// of another length; an integration that fails, or a contact that dissipates whose onset or
    /// release the search for events has not found; columns that change the overlap of beads which
    /// touch at the start, or touch at rest later, where their contact is a dashpot: then the flow
    /// has no derivative.
    pub fn flow(chain: &Chain<R>, start: &[R], span: (R, R), columns: &[R], tol: R) -> Result<Varied<R>> {
        Self::flow_by(chain, start, span, (columns, &[]), tol)
    }

    /// As [`flow`](Self::flow), where the first columns are derivatives by numbers of the chain:
    /// those of the start, zero unless it depends on them, become those of the end.
    ///
    /// ```
    /// use hertzchain_core::{Boundary, Chain, Params, chain::{Parameter, Variations}};
    /// // A bead on a spring to a fixed mass, u = cos(omega t) with omega^2 = kappa.
    /// let chain = Chain::new(Params::new(1.5, 4.0, f64::INFINITY)?, Boundary::Free, 1)?;
    /// let by = [Parameter::Kappa];
    /// let end = Variations::flow_by(&chain, &[1.0, 0.0], (0.0, 3.0), (&[0.0, 0.0], &by), 1e-12)?;
    /// // d cos(omega t)/d kappa = -t sin(omega t)/(2 omega)
    /// assert!((end.columns[0] + 0.75 * 6.0f64.sin()).abs() < 1e-10);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`flow`](Self::flow); fewer columns than numbers; contacts that dissipate; a number that
    /// the chain does not have, as where each bead has its own.
    pub fn flow_by(
        chain: &Chain<R>,
        start: &[R],
        span: (R, R),
        (columns, by): (&[R], &[Parameter]),
        tol: R,
    ) -> Result<Varied<R>> {
        let rows = 2 * chain.layout().half();
        if !columns.len().is_multiple_of(rows) {
            let rule = "columns have an entry for each position and velocity";
            return Err(Error::parameter("columns", format!("{} entries for {rows} rows", columns.len()), rule));
        }
        let mut field = Self::new(chain, columns.len() / rows)?;
        by.iter().try_for_each(|parameter| parameter.check(&field.chain, parts(&field.chain)))?;
        require(by.len() <= field.columns, "columns", field.columns, "one for each number of the chain")?;
        field.by = by.to_vec();
        let chain = field.chain.clone();
        field.field = Field::from_event_to_event(chain.clone());
        let dim = chain.layout().dim();
        require(start.len() == dim, "state", format!("{} entries", start.len()), "a state of the chain")?;
        let mut y: Vec<R> = start.iter().chain(columns).copied().collect();
        y.resize(field.dim(), R::zero());
        let natural = chain.natural(start);
        let (size, time) = (natural.size.max(R::of(natural.driven)), R::of(natural.time));
        let units = field.units(&natural, columns);
        let map = match columns.is_empty() {
            true => parts(&chain).map(ORDER),
            false => parts(&chain).map_of_columns(ORDER),
        };
        let scale @ (unit, _) = natural.of_overlaps(map.0);
        // An overlap is rounded by the rounding of its static part.
        let atol = (tol * size).max(R::epsilon() * R::of(chain.largest_rest()) / unit);
        let options = Options { atol, ..Options::new(tol) };
        let overlaps = Overlaps::with_pushes(chain, &natural, true);
        let run = Regularised::new(field, overlaps, map, &y, span, options)?;
        let (mut run, mut end) = (run.in_units(&units, time, scale), y);
        let (margin, lossy) = (tol.sqrt() * size * unit, run.field_mut().chain.dissipative_contacts());
        run.field_mut().refuse_kinks(&end, span.0, false)?;
        // Each step carries motion to the next bond at least.
        let mut unreached = run.field_mut().chain.sites();
        while !run.done() {
            run.step()?;
            if !lossy {
                continue;
            }
            let t = run.time();
            run.sample(t, &mut end);
            unreached = unreached.saturating_sub(1);
            if unreached == 0 {
                run.field_mut().refuse_kinks(&end, t, true)?;
            }
            if let Some(bond) = run.field_mut().diverged(&end, margin, &natural) {
                let (value, rule) =
                    (format!("of bond {bond} at t = {}", t.f64()), "its onset or release was not found");
                return Err(Error::parameter("dissipation", value, rule));
            }
        }
        run.sample(span.1, &mut end);
        run.field_mut().release(&mut end);
        let mut columns = end.split_off(dim);
        let contraction = columns.split_off(rows * (columns.len() / rows)).first().copied().unwrap_or(R::zero());
        Ok(Varied { state: end, columns, contraction })
    }

    /// The units of the state and of the `columns`: each column, as a change of positions, has its
    /// size at the start; one with a source has that of the state over that of its number.
    fn units(&self, natural: &Natural<R>, columns: &[R]) -> Vec<R> {
        let (mut units, half, k) = (natural.of_state(&self.chain), self.rows() / 2, self.columns);
        let ([length, speed], size) =
            ([0, half].map(|i| units[i].f64()), natural.size.max(R::of(natural.driven)).f64());
        let of = |j: usize| match self.by.get(j) {
            Some(Parameter::Kappa) => length / natural.mass * natural.time * natural.time,
            Some(Parameter::Mass(_)) => length / natural.mass,
            Some(Parameter::Alpha | Parameter::Rho) => length,
            None => {
                let rows = (0..2 * half).map(|i| columns[i * k + j].f64() * if i < half { 1.0 } else { natural.time });
                unit(max_norm(rows)) / size.max(1.0)
            }
        };
        let of: Vec<f64> = (0..k).map(of).collect();
        units.extend((0..2 * half * k).map(|i| R::of(of[i % k] * if i < half * k { 1.0 } else { speed / length })));
        units.resize(self.dim(), R::one());
        units
    }

    /// A contact that pushes although the signs of its overlap and force say otherwise by more than
    /// `margin`, or the reverse. The search for events may give up an event where many contacts are
    /// all but at rest.
    fn diverged(&self, y: &[R], margin: R, natural: &Natural<R>) -> Option<usize> {
        let (pushing, parts, layout) = (self.field.pushing()?, parts(&self.chain), self.chain.layout());
        let (u, u_dot) = (layout.u(y), layout.u_dot(y));
        pushing.lossy().iter().copied().find(|&bond| {
            let contact = &parts.bonds[bond];
            let (g, rate) = (contact.rest + self.chain.across(bond, |i| u[i]), self.chain.across(bond, |i| u_dot[i]));
            let least = contact.pushes(g, rate).map_or(g, |force| g.min(natural.per_push(contact) * force));
            if pushing.pushes(bond) { least < -margin } else { least > margin }
        })
    }

    /// Fails if beads touch whose contact is a dashpot, and a column changes their overlap; with
    /// `at_rest`, if they touch at rest, and a column changes their overlap or its rate.
    fn refuse_kinks(&mut self, y: &[R], t: R, at_rest: bool) -> Result<()> {
        let Self { chain, change, columns, .. } = self;
        let (layout, entries) = (chain.layout(), chain.layout().half() * *columns);
        let (u, u_dot, w) = (layout.u(y), layout.u_dot(y), &y[layout.dim()..]);
        let (positions, velocities) = (&w[..entries], &w[entries..2 * entries]);
        let band = chain.dead_band(u.iter().copied());
        let mut changes = |bond: usize, rows: &[R]| {
            overlap_change(chain, bond, rows, change);
            let largest = |of: &[R]| of.iter().fold(R::zero(), |largest: R, x| largest.max(x.abs()));
            largest(change) > R::of(CHANGED) * largest(rows)
        };
        for bond in chain.lossy() {
            let contact = &parts(chain).bonds[bond];
            let (g, rate) = (contact.rest + chain.across(bond, |i| u[i]), chain.across(bond, |i| u_dot[i]));
            let touch = if at_rest { g == R::zero() && rate == R::zero() } else { g.abs() <= band };
            let kinked = touch && contact.resistance(R::zero()) > R::zero();
            if kinked && (changes(bond, positions) || at_rest && changes(bond, velocities)) {
                let value = format!("changes of the overlap of bond {bond}, whose beads touch at t = {}", t.f64());
                return Err(Error::parameter("columns", value, "a dashpot's derivatives by gap and overlap differ"));
            }
        }
        Ok(())
    }

    /// Turns `dp` at the end of a run into `du'`.
    fn release(&mut self, y: &mut [R]) {
        if self.columns == 0 {
            return;
        }
        let pushing: Vec<usize> = self.field.pushing().map_or(Vec::new(), |pushing| pushing.bonds().collect());
        for bond in pushing {
            self.shift(bond, R::one(), y);
        }
    }

    /// Adds `sign w_n c(g) dg / m_n` of a contact to the rows of velocities.
    fn shift(&mut self, bond: usize, sign: R, y: &mut [R]) {
        let (dim, half, k) = (self.chain.layout().dim(), self.chain.layout().half(), self.columns);
        let (state, w) = y.split_at_mut(dim);
        let (parts, contact) = (parts(&self.chain), &parts(&self.chain).bonds[bond]);
        let g = contact.rest + self.chain.across(bond, |i| state[i]);
        let (positions, velocities) = w.split_at_mut(half * k);
        let resistance = sign * contact.resistance(g);
        resist(&self.chain, parts, bond, resistance, &mut self.change, positions, velocities);
    }
}

/// The change of the overlap of a bond in every column, from the rows of positions.
#[inline(always)]
fn overlap_change<R: Real>(chain: &Chain<R>, bond: usize, positions: &[R], change: &mut [R]) {
    let k = change.len();
    change.fill(R::zero());
    // Displacements are in the overlap with minus the weights of the forces on beads.
    for &(site, weight) in chain.topology().pushed(bond).iter() {
        accumulate(change, -R::of(weight), &positions[site * k..(site + 1) * k]);
    }
}

/// Adds `w_n c dg / m_n` of a bond to rows of velocities of beads that no drive moves.
#[inline(always)]
fn resist<R: Real>(
    chain: &Chain<R>,
    parts: &CheckedDetails<R>,
    bond: usize,
    resistance: R,
    change: &mut [R],
    positions: &[R],
    velocities: &mut [R],
) {
    let k = change.len();
    overlap_change(chain, bond, positions, change);
    for &(site, weight) in chain.topology().pushed(bond).iter() {
        let own = &parts.sites[site];
        if !own.moved {
            accumulate(&mut velocities[site * k..(site + 1) * k], R::of(weight) * resistance / own.mass, change);
        }
    }
}

/// Changes of overlaps up to this, relative to the largest change of a position or velocity, count
/// as none. Columns of an earlier run have them where its wave has just come to beads that touch;
/// either side then changes columns by this share times `gamma/m`.
const CHANGED: f64 = 1e-12;

/// Order of DOP853.
const ORDER: u32 = 8;

fn parts<R: Real>(chain: &Chain<R>) -> &CheckedDetails<R> {
    chain.parts().expect("a chain with details")
}

impl<R: Real> VectorField<R> for Variations<R> {
    fn dim(&self) -> usize {
        let contraction = usize::from(self.chain.dissipative_contacts());
        self.chain.layout().dim() + self.rows() * self.columns + contraction
    }

    fn eval(&mut self, t: R, y: &[R], dy: &mut [R]) {
        let (dim, entries) = (self.chain.layout().dim(), self.rows() * self.columns);
        let ((state, w), (rates, dw)) = (y.split_at(dim), dy.split_at_mut(dim));
        self.field.eval(t, state, rates);
        let ((w, _), (dw, contraction)) = (w.split_at(entries), dw.split_at_mut(entries));
        let Self { chain, field, change, velocities, .. } = self;
        if let (Some(pushing), [contraction]) = (field.pushing(), contraction) {
            *contraction = resisted(chain, pushing, state);
        }
        if self.columns > 0 {
            let (pushing, chain, column) = (field.pushing(), &*chain, &mut *dw);
            R::run(kernel!(linearised((chain, pushing), state, (w, column), (change, velocities))));
            for (j, parameter) in self.by.iter().enumerate() {
                parameter.source(chain, parts(chain), (state, rates), |row, by| dw[row * self.columns + j] += by);
            }
        }
    }

    fn breaks(&self) -> Vec<f64> {
        self.chain.breaks()
    }

    fn complete(&self, start: R, t: R, y: &mut [R]) {
        self.field.complete(start, t, &mut y[..self.chain.layout().dim()]);
    }

    fn turn(&mut self, index: usize, positive: bool, y: &mut [R]) -> bool {
        let Some(Switched { bond, pushes, meeting }) = self.field.told(index, positive) else { return false };
        if !meeting && self.columns > 0 {
            self.shift(bond, if pushes { -R::one() } else { R::one() }, y);
        }
        true
    }
}

/// `sum_b c(g_b) sum_n w_nb^2/m_n` over contacts that push and beads that no drive moves.
fn resisted<R: Real>(chain: &Chain<R>, pushing: &Pushing, state: &[R]) -> R {
    let parts = parts(chain);
    let of = |bond: usize| {
        let contact = &parts.bonds[bond];
        let g = contact.rest + chain.across(bond, |i| state[i]);
        let pushed = chain.topology().pushed(bond);
        let free = pushed.iter().filter(|(site, _)| !parts.sites[*site].moved);
        let per_mass =
            free.fold(R::zero(), |sum, &(site, weight)| sum + R::of(weight * weight) / parts.sites[site].mass);
        contact.resistance(g) * per_mass
    };
    pushing.bonds().fold(R::zero(), |sum, bond| sum + of(bond))
}

/// `W'` at a state, with room for one row and for the velocities.
#[inline(always)]
fn linearised<R: Real>(
    (chain, pushing): (&Chain<R>, Option<&Pushing>),
    state: &[R],
    (w, dw): (&[R], &mut [R]),
    (change, velocities): (&mut [R], &mut [R]),
) {
    let (parts, layout, k) = (parts(chain), chain.layout(), change.len());
    let (n, half) = (chain.sites(), layout.half());
    dw[..half * k].copy_from_slice(&w[half * k..]);
    dw[half * k..].fill(R::zero());
    let row = |i: usize| &w[i * k..(i + 1) * k];
    let resisted = pushing.filter(|_| chain.dissipative_contacts());
    if let Some(pushing) = resisted {
        velocities.copy_from_slice(&w[half * k..(half + n) * k]);
        for bond in pushing.bonds() {
            let contact = &parts.bonds[bond];
            let g = contact.rest + chain.across(bond, |i| state[i]);
            resist(chain, parts, bond, contact.resistance(g), change, w, velocities);
        }
        dw[..n * k].copy_from_slice(velocities);
    }
    let velocities = if resisted.is_some() { &*velocities } else { &w[half * k..] };
    for (i, site) in parts.sites.iter().enumerate() {
        let (u, u_dot) = (row(i), &velocities[i * k..(i + 1) * k]);
        let (bead, resonator) = dw[(half + i) * k..].split_at_mut(k);
        accumulate(bead, -site.drag / site.mass, u_dot);
        if site.resonators == Resonators::None {
            continue;
        }
        let (spring, dashpot) = (site.kappa, site.dashpot);
        accumulate(bead, -(spring + site.onsite) / site.mass, u);
        accumulate(bead, -dashpot / site.mass, u_dot);
        if site.resonators != Resonators::Moving {
            continue;
        }
        let (v, v_dot) = (row(n + i), row(half + n + i));
        accumulate(bead, spring / site.mass, v);
        accumulate(bead, dashpot / site.mass, v_dot);
        let resonator = &mut resonator[(n - 1) * k..n * k];
        let own = site.resonator();
        for (by, [from, to]) in [(spring / own, [u, v]), (dashpot / own, [u_dot, v_dot])] {
            accumulate(resonator, by, from);
            accumulate(resonator, -by, to);
        }
    }
    let u = layout.u(state);
    for bond in chain.touching() {
        let contact = &parts.bonds[bond];
        let strain = chain.across(bond, |i| u[i]);
        let g = contact.rest + strain;
        let apart = g <= R::zero() || pushing.is_some_and(|pushing| !pushing.pushes(bond));
        let joint = parts.joint(bond).map_or(R::zero(), |joint| joint.stiffness(strain));
        let stiffness = if apart { joint } else { contact.stiffness(g) + joint };
        if stiffness == R::zero() {
            continue;
        }
        overlap_change(chain, bond, w, change);
        for &(site, weight) in chain.topology().pushed(bond).iter() {
            let by = R::of(weight) * stiffness / parts.sites[site].mass;
            accumulate(&mut dw[(half + site) * k..(half + site + 1) * k], by, change);
        }
    }
    for (i, _) in parts.sites.iter().enumerate().filter(|(_, site)| site.moved) {
        dw[i * k..(i + 1) * k].fill(R::zero());
        dw[(half + i) * k..(half + i + 1) * k].fill(R::zero());
    }
}

/// `to += by from`.
#[inline(always)]
fn accumulate<R: Real>(to: &mut [R], by: R, from: &[R]) {
    for (to, &from) in to.iter_mut().zip(from) {
        *to += by * from;
    }
}
