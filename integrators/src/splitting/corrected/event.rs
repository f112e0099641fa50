//! The correction at one onset or release.

use super::{
    bonds::{BondView, Correction},
    pack::Pack,
    path::{Paths, Zero},
    zeta::ZetaTable,
};
use crate::{real::Vector, with_registers};

/// Corrections at events, for one exponent and one step length.
#[derive(Clone, Debug)]
pub struct Corrector {
    alpha: f64,
    table: ZetaTable,
    h: f64,
    /// `h^{alpha+2}`.
    h2: f64,
}

impl Corrector {
    /// For forces with the exponent `alpha`, and steps of `h`.
    pub fn new(alpha: f64, h: f64) -> Self {
        Self { alpha, table: ZetaTable::new(alpha), h, h2: h.powf(alpha + 2.0) }
    }

    /// Appends the corrections of some events, each with whether it is an onset; `None` where a
    /// path is too flat to have a time of change. With the widest registers: those of AVX2 take 1.4
    /// of the time for events of a wave, five or ten in a step.
    ///
    /// A correction has the same bits whether its event is alone or among others.
    pub fn corrections(&self, events: &[(BondView, bool)], out: &mut Vec<Option<Correction>>) {
        with_registers!(V => for events in events.chunks(V::LANES) {
            let paths = Paths::<V>::of(events, |event| &event.0.path);
            let mobility = Pack::<V>::of(events, |event| event.0.mobility);
            let before = Pack::<V>::of(events, |event| event.0.pull[0]);
            let now = Pack::<V>::of(events, |event| event.0.pull[1]);
            // As in `Pack::of`, lanes without an event repeat the first one.
            let onset = |k: usize| u64::from(events.get(k).unwrap_or(&events[0]).1) << k;
            let onsets = (0..V::LANES).fold(0, |bits, k| bits | onset(k));
            let zero = paths.zeros(self.h, onsets);
            let turn = paths.turn(zero.at);
            let (impulse, displacement) = self.at_zeros(paths.overlap, mobility, [before, now], onsets, &zero);
            // No closure with registers: it would not be compiled for those of a kernel.
            let ([sin, cos], [at, rate]) = ([turn[0].lanes(), turn[1].lanes()], [zero.at.lanes(), zero.rate.lanes()]);
            let (impulse, displacement) = (impulse.lanes(), displacement.lanes());
            out.extend((0..events.len()).map(|k| {
                let turn = [sin[k], cos[k]];
                let correction =
                    Correction { impulse: impulse[k], displacement: displacement[k], at: at[k], rate: rate[k], turn };
                (correction.impulse.is_finite() && correction.displacement.is_finite()).then_some(correction)
            }));
        });
    }

    /// Impulses and displacements at the zeros of paths.
    #[inline(always)]
    fn at_zeros<V: Vector<f64>>(
        &self,
        overlap: Pack<V>,
        mobility: Pack<V>,
        pull: [Pack<V>; 2],
        onsets: u64,
        zero: &Zero<Pack<V>>,
    ) -> (Pack<V>, Pack<V>) {
        let &Zero { at, rate, acceleration } = zero;
        let one = Pack::all(1.0);
        let sign = one.or(onsets, Pack::all(-1.0));
        // Steps from the event into the contact, to the first kick at which the processed path is
        // closed: -at/h for an onset, 1 + at/h for a release.
        let theta = (Pack::all(0.0).or(onsets, one) - sign * (at / self.h)).fraction();
        // Rate and acceleration in a time that runs into the contact.
        let local = (sign * rate, acceleration);
        let mut z = self.zeta(theta);
        let start = self.gradient(local, None, &mut z);
        // One iteration of the implicit midpoint rule: the next would change it by a factor of the
        // size of f' h^2 less.
        let half = sign * (mobility * 0.5);
        let (by_overlap, by_rate) = self.gradient(local, Some((-half * start.1, half * start.0)), &mut z);
        let [before, now] = self.kicks(overlap, pull, (at, rate, acceleration));
        // The impulses for the two kicks act at these kicks, not at the event: the displacement
        // makes up for the difference.
        ((before + now) - by_overlap, sign * by_rate + (now * at + before * (at + self.h)))
    }

    /// Impulses that the kick before an event and the kick after it lack against the force of the
    /// processed path: `h (f(g + e) - f(g) - f'(g) e)` with `e = (h^2/12) s`. Farther kicks lack `h
    /// e^2 f''/2`, of which the singular part is of order `h^{alpha+3}`.
    #[inline(always)]
    fn kicks<V: Vector<f64>>(
        &self,
        now: Pack<V>,
        pull: [Pack<V>; 2],
        (at, rate, a): (Pack<V>, Pack<V>, Pack<V>),
    ) -> [Pack<V>; 2] {
        let h = self.h;
        let share = h * h / 12.0;
        let shifts = [pull[0] * share, pull[1] * share];
        let to_before = -(at + h);
        let before = to_before * (rate + a * 0.5 * to_before);
        [self.lack(before, shifts[0]), self.lack(now, shifts[1])]
    }

    /// The impulse that one kick lacks; `g` is the processed overlap, `g - shift` that of the
    /// kernel.
    #[inline(always)]
    fn lack<V: Vector<f64>>(&self, g: Pack<V>, shift: Pack<V>) -> Pack<V> {
        let Self { alpha, h, .. } = *self;
        let (there, here) = (g.positive(), (g - shift).positive());
        let slope_here = slope(alpha, here);
        // For alpha = 1 the derivative does not vanish with the overlap.
        let modified = (here + shift * alpha) * slope_here;
        (there * slope(alpha, there) - modified.where_positive(here)) * h
    }

    pub(super) fn step(&self) -> f64 {
        self.h
    }

    pub(super) fn exponent(&self) -> f64 {
        self.alpha
    }

    /// `h^alpha`.
    pub(super) fn power(&self) -> f64 {
        self.h2 / (self.h * self.h)
    }

    /// See [`ZetaTable::beyond`].
    #[inline(always)]
    pub(super) fn beyond<V: Vector<f64>>(&self, theta: Pack<V>) -> [Pack<V>; ZetaTable::COUNT] {
        self.table.beyond(theta)
    }

    /// Impulse and displacement of a bond at a known zero: its time, and rate and acceleration
    /// there.
    pub(super) fn given(&self, view: &BondView, zero: (f64, f64, f64), onset: bool) -> [f64; 2] {
        let zero = Zero { at: Pack(zero.0), rate: Pack(zero.1), acceleration: Pack(zero.2) };
        let (overlap, mobility, pull) = (Pack(view.path.overlap), Pack(view.mobility), view.pull.map(Pack));
        let (impulse, displacement) = self.at_zeros(overlap, mobility, pull, u64::from(onset), &zero);
        [impulse.0, displacement.0]
    }

    /// `dW/dg` and `dW/dr` of paths with this rate and acceleration at their zeros, and the zeta
    /// functions `z` there. `moved` are changes of overlap and rate at that time: zeros and zeta
    /// functions are then those of the changed paths.
    #[inline(always)]
    pub fn gradient<V: Vector<f64>>(
        &self,
        (rate, a): (Pack<V>, Pack<V>),
        moved: Option<(Pack<V>, Pack<V>)>,
        z: &mut [Pack<V>; ZetaTable::COUNT],
    ) -> (Pack<V>, Pack<V>) {
        let Self { alpha, h, .. } = *self;
        let (mut c, mut delta) = (rate, Pack::all(0.0));
        if let Some((overlap, change)) = moved {
            let r = rate + change;
            // The zero moves by delta, and c to the rate there.
            let root = (r * r - a * overlap * 2.0).positive().sqrt();
            delta = -(overlap * 2.0) / (r + root);
            c = r + a * delta;
            let steps = -delta / h;
            for k in (1..ZetaTable::COUNT).rev() {
                z[k] = z[k] + steps * (alpha + k as f64 - 1.0) * z[k - 1];
            }
        }
        let [_, z0, z1, z2] = *z;
        let one = Pack::all(1.0);
        let per_c = one / c;
        let force = c * slope(alpha, c);
        let turn = a * h * per_c;
        let steep = turn * turn * (turn * turn);
        let steep = steep * steep;
        let fade = one / (steep + 1.0);
        // W = h^{alpha+2} [ c^{alpha+1} z1/(alpha+1) + fade c^alpha (a h/2) z2 ]
        let first = fade * force * turn * 0.5;
        let by_c = (force * z1 + first * z2 * (fade * steep * 8.0 + alpha)) * self.h2;
        let by_theta = c * (force * z0 + first * z1 * (alpha + 2.0)) * self.h2;
        let by_zero = (by_c * a - by_theta * (1.0 / h)) * per_c;
        (-by_zero, by_c - by_zero * delta)
    }

    /// `zeta(-alpha - k, theta)` for `k = -1 .. 2`.
    #[inline(always)]
    pub fn zeta<V: Vector<f64>>(&self, theta: Pack<V>) -> [Pack<V>; ZetaTable::COUNT] {
        let mut z = self.table.beyond(theta);
        let mut power = slope(self.alpha, theta);
        for z in &mut z {
            *z = *z + power;
            power = power * theta;
        }
        z
    }
}

/// `x^{alpha-1}`.
#[inline(always)]
pub(super) fn slope<V: Vector<f64>>(alpha: f64, x: Pack<V>) -> Pack<V> {
    if alpha == 1.5 {
        return x.sqrt();
    }
    let mut lanes = x.lanes();
    raise(&mut lanes[..V::LANES], alpha - 1.0);
    Pack::from_lanes(&lanes)
}

/// Powers of numbers, as a function of its own: kernels have a dozen, of all lanes.
#[inline(never)]
fn raise(numbers: &mut [f64], power: f64) {
    numbers.iter_mut().for_each(|x| *x = x.powf(power));
}
