//! The contact law `f = (g)_+^alpha`, its potential and its stiffness; and the law of one bond,
//! with a constant, a static overlap and dissipation of its own.
//!
//! Overlaps with a force below about 1e-250 count as zero. Without this dead band, forces and
//! impulses in the tails of waves and breathers become subnormal numbers, which are slow. Its
//! effect on the state is below 1e-200.

use crate::{DoubleDouble, Real, Vector};

/// Runs `$body` with `$power` bound to the [`Power`](crate::law::Power) of `$law`.
#[macro_export]
macro_rules! with_power {
    ($law:expr, $power:ident => $body:expr) => {
        match $law.exponent() {
            $crate::law::Exponent::ThreeHalves => {
                let $power = $crate::law::ThreeHalves;
                $body
            }
            $crate::law::Exponent::Integer(1) => {
                let $power = $crate::law::Monomial::<1>;
                $body
            }
            $crate::law::Exponent::Integer(2) => {
                let $power = $crate::law::Monomial::<2>;
                $body
            }
            $crate::law::Exponent::Integer(3) => {
                let $power = $crate::law::Monomial::<3>;
                $body
            }
            $crate::law::Exponent::Integer(k) => {
                let $power = $crate::law::Integer(k);
                $body
            }
            $crate::law::Exponent::HalfInteger(k) => {
                let $power = $crate::law::HalfInteger(k);
                $body
            }
            $crate::law::Exponent::General => {
                let $power = $crate::law::General($law.alpha());
                $body
            }
        }
    };
}

/// Runs `$body` with `$power` bound to [`ThreeHalves`](crate::law::ThreeHalves), or to the one type
/// of all other powers: for loops that are too large to be compiled for every kind of exponent.
#[macro_export]
macro_rules! with_hertz {
    ($law:expr, $power:ident => $body:expr) => {
        if $law.exponent() == $crate::law::Exponent::ThreeHalves {
            let $power = $crate::law::ThreeHalves;
            $body
        } else {
            let $power = $law.any_power();
            $body
        }
    };
}

/// A power `g^alpha` as a type, so that loops are compiled for it.
pub trait Power<R: Real>: Copy {
    /// `g^alpha` for `g >= 0`.
    fn raise<V: Vector<R>>(self, g: V) -> V;
    /// `g^alpha` and its derivative `alpha g^{alpha-1}` for `g > 0`; two zeros for `g = 0`.
    fn raise_with_slope<V: Vector<R>>(self, g: V) -> (V, V);
    /// `g^alpha` where `g` exceeds `band >= 0`; zero elsewhere.
    #[inline(always)]
    fn raise_above<V: Vector<R>>(self, band: R, g: V) -> V {
        self.raise(g.above(band, g))
    }
    /// As [`raise_with_slope`](Self::raise_with_slope) where `g` exceeds `band >= 0`; two zeros
    /// elsewhere.
    #[inline(always)]
    fn raise_above_with_slope<V: Vector<R>>(self, band: R, g: V) -> (V, V) {
        self.raise_with_slope(g.above(band, g))
    }
}

/// `g sqrt(g)`.
#[derive(Clone, Copy)]
pub struct ThreeHalves;
/// `g^K` by multiplications.
#[derive(Clone, Copy)]
pub struct Monomial<const K: u32>;
/// `g^k` by multiplications, for `k` from 4 to 64.
#[derive(Clone, Copy)]
pub struct Integer(pub u32);
/// `g^k sqrt(g)`, for half-integers other than 3/2, up to 64.
#[derive(Clone, Copy)]
pub struct HalfInteger(pub u32);
/// Any other power.
#[derive(Clone, Copy)]
pub struct General<R>(pub R);

/// The power of any law, for loops that are too large to be compiled for every kind of exponent:
/// the kind is chosen by a branch for each register.
#[derive(Clone, Copy)]
pub struct Any<R> {
    exponent: Exponent,
    alpha: R,
}

impl<R: Copy> Any<R> {
    #[inline(always)]
    fn exponent(self) -> Exponent {
        self.exponent
    }

    #[inline(always)]
    fn alpha(self) -> R {
        self.alpha
    }
}

impl<R: Real> Power<R> for Any<R> {
    #[inline(always)]
    fn raise<V: Vector<R>>(self, g: V) -> V {
        with_power!(self, power => power.raise(g))
    }

    #[inline(always)]
    fn raise_with_slope<V: Vector<R>>(self, g: V) -> (V, V) {
        with_power!(self, power => power.raise_with_slope(g))
    }
}

impl<R: Real> Power<R> for ThreeHalves {
    #[inline(always)]
    fn raise<V: Vector<R>>(self, g: V) -> V {
        g * g.root()
    }

    #[inline(always)]
    fn raise_with_slope<V: Vector<R>>(self, g: V) -> (V, V) {
        let root = g.root();
        (g * root, V::all(R::of(1.5)) * root)
    }

    // Masks come after the root, so that the root need not wait for the comparison.

    #[inline(always)]
    fn raise_above<V: Vector<R>>(self, band: R, g: V) -> V {
        g.above(band, self.raise(g))
    }

    #[inline(always)]
    fn raise_above_with_slope<V: Vector<R>>(self, band: R, g: V) -> (V, V) {
        let (power, slope) = self.raise_with_slope(g);
        (g.above(band, power), g.above(band, slope))
    }
}

impl<R: Real, const K: u32> Power<R> for Monomial<K> {
    #[inline(always)]
    fn raise<V: Vector<R>>(self, g: V) -> V {
        let mut power = g;
        for _ in 1..K {
            power = power * g;
        }
        power
    }

    #[inline(always)]
    fn raise_with_slope<V: Vector<R>>(self, g: V) -> (V, V) {
        let mut lower = g.above(R::zero(), V::one());
        for _ in 1..K {
            lower = lower * g;
        }
        (lower * g, V::all(R::of(f64::from(K))) * lower)
    }
}

impl<R: Real> Power<R> for Integer {
    #[inline(always)]
    fn raise<V: Vector<R>>(self, g: V) -> V {
        whole_power(g, self.0)
    }

    #[inline(always)]
    fn raise_with_slope<V: Vector<R>>(self, g: V) -> (V, V) {
        let lower = whole_power(g, self.0 - 1);
        (lower * g, V::all(R::of(f64::from(self.0))) * lower)
    }
}

impl<R: Real> Power<R> for HalfInteger {
    #[inline(always)]
    fn raise<V: Vector<R>>(self, g: V) -> V {
        whole_power(g, self.0) * g.root()
    }

    #[inline(always)]
    fn raise_with_slope<V: Vector<R>>(self, g: V) -> (V, V) {
        let power = self.raise(g);
        let alpha = V::all(R::of(f64::from(self.0)) + R::of(0.5));
        (power, alpha * power * g.above(R::zero(), g.inverse()))
    }
}

impl<R: Real> Power<R> for General<R> {
    #[inline(always)]
    fn raise<V: Vector<R>>(self, g: V) -> V {
        // Otherwise compilers compute the power of each lane before they look at its sign.
        if g.positive() == 0 {
            return V::all(R::zero());
        }
        g.each(|g| if g > R::zero() { g.powf(self.0) } else { R::zero() })
    }

    #[inline(always)]
    fn raise_with_slope<V: Vector<R>>(self, g: V) -> (V, V) {
        let power = self.raise(g);
        (power, g.above(R::zero(), V::all(self.0) * (power / g)))
    }
}

/// `g^k` by squares, compiled into the loop that calls it.
#[inline(always)]
fn whole_power<R, V: Vector<R>>(g: V, mut k: u32) -> V {
    if k == 0 {
        return V::one();
    }
    let mut square = g;
    while k & 1 == 0 {
        square = square * square;
        k >>= 1;
    }
    let mut power = square;
    while k > 1 {
        square = square * square;
        k >>= 1;
        if k & 1 == 1 {
            power = power * square;
        }
    }
    power
}

/// The way in which a power is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent {
    /// `g sqrt(g)`.
    ThreeHalves,
    /// By multiplications.
    Integer(u32),
    /// By multiplications and a square root.
    HalfInteger(u32),
    /// By `powf`.
    General,
}

/// The force law of a contact.
#[derive(Clone, Copy, Debug)]
pub struct ContactLaw<R> {
    exponent: Exponent,
    alpha: R,
    /// `1/(alpha + 1)`.
    per_alpha_plus_one: R,
    /// Overlaps up to this value count as zero.
    dead_band: R,
}

impl<R: Real> ContactLaw<R> {
    /// The law with exponent `alpha > 0`.
    pub fn new(alpha: f64) -> Self {
        let exponent = if alpha == 1.5 {
            Exponent::ThreeHalves
        } else if alpha.fract() == 0.0 && alpha <= 64.0 {
            Exponent::Integer(alpha as u32)
        } else if alpha.fract() == 0.5 && alpha <= 64.0 {
            Exponent::HalfInteger(alpha as u32)
        } else {
            Exponent::General
        };
        let dead_band = 1e-250_f64.powf(1.0 / alpha).max(f64::MIN_POSITIVE);
        let [one, alpha] = [1.0, alpha].map(|x| DoubleDouble::new(R::of(x)));
        let per_alpha_plus_one = one.over(alpha + one).value();
        Self { exponent, alpha: alpha.value(), per_alpha_plus_one, dead_band: R::of(dead_band) }
    }

    /// The exponent.
    pub fn alpha(&self) -> R {
        self.alpha
    }

    /// The power as one type for all kinds of exponents.
    pub fn any_power(&self) -> Any<R> {
        Any { exponent: self.exponent, alpha: self.alpha }
    }

    /// The way in which the power is computed.
    #[inline]
    pub fn exponent(&self) -> Exponent {
        self.exponent
    }

    /// The overlap above the dead band, otherwise zero.
    #[inline(always)]
    pub fn positive_part<V: Vector<R>>(&self, g: V) -> V {
        g.above(self.dead_band, g)
    }

    /// Forces, by the power of this law.
    #[inline(always)]
    pub fn force_by<V: Vector<R>>(&self, power: impl Power<R>, g: V) -> V {
        power.raise_above(self.dead_band, g)
    }

    /// Forces and their derivatives, by the power of this law.
    #[inline(always)]
    pub fn force_and_slope<V: Vector<R>>(&self, power: impl Power<R>, g: V) -> (V, V) {
        power.raise_above_with_slope(self.dead_band, g)
    }

    /// The force `(g)_+^alpha`.
    pub fn force(&self, g: R) -> R {
        with_power!(self, power => power.raise(self.positive_part(g)))
    }

    /// The forces of several overlaps.
    ///
    /// The loop for `alpha = 3/2` is inlined into the caller and uses its vector instructions; the
    /// loops for other powers are a call.
    #[inline(always)]
    pub fn forces<const M: usize>(&self, overlaps: &[R; M]) -> [R; M] {
        if self.exponent == Exponent::ThreeHalves {
            self.raise_all(ThreeHalves, overlaps)
        } else {
            self.other_forces(overlaps)
        }
    }

    #[inline(never)]
    fn other_forces<const M: usize>(&self, overlaps: &[R; M]) -> [R; M] {
        with_power!(self, power => self.raise_all(power, overlaps))
    }

    #[inline(always)]
    fn raise_all<const M: usize>(&self, power: impl Power<R>, overlaps: &[R; M]) -> [R; M] {
        let mut force = [R::zero(); M];
        for j in 0..M {
            force[j] = power.raise(self.positive_part(overlaps[j]));
        }
        force
    }

    /// The force and its derivative `alpha (g)_+^{alpha-1}`.
    #[inline]
    pub fn force_with_slope(&self, g: R) -> (R, R) {
        if self.exponent == Exponent::ThreeHalves {
            return ThreeHalves.raise_with_slope(self.positive_part(g));
        }
        self.any_force_with_slope(g)
    }

    #[inline(never)]
    fn any_force_with_slope(&self, g: R) -> (R, R) {
        with_power!(self, power => power.raise_with_slope(self.positive_part(g)))
    }

    /// The potential `(g)_+^{alpha+1} / (alpha+1)`.
    pub fn potential(&self, g: R) -> R {
        self.force(g) * self.positive_part(g) * self.per_alpha_plus_one
    }

    /// The stiffness `alpha (g)_+^{alpha-1}`, the derivative of the force; zero where there is no
    /// contact.
    pub fn stiffness(&self, g: R) -> R {
        let g = self.positive_part(g);
        if g == R::zero() { g } else { self.alpha * (self.force(g) / g) }
    }
}

/// How contacts dissipate: the law of their resistance. A new law is a variant here, in the methods
/// of this type and of [`BondLaw`], and a key of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Viscoelastic spheres, `c(g) = gamma F'(g)`, so that `f = (F + gamma dF/dt)_+` for `g > 0`:
    /// Kuwabara & Kono 1987, Jpn. J. Appl. Phys. 26, 1230; Brilliantov, Spahn, Hertzsch & Poeschel
    /// 1996, Phys. Rev. E 53, 5382. `gamma` is a time.
    Viscoelastic,
    /// A dashpot, `c(g) = gamma g^beta`, so that `f = (F + gamma g^beta g')_+` for `g > 0`; a
    /// linear one has `beta = 0`, and `gamma` is a force over a velocity: Tsuji, Tanaka & Ishida
    /// 1992, Powder Technol. 71, 239, have `beta = 1/4`. In place of `g'` it may have
    /// `|g'|^p sgn g'` with `p >= 1`.
    Dashpot,
    /// Hunt & Crossley 1975, J. Appl. Mech. 42, 440: `c(g) = gamma F(g)`, so that
    /// `f = F (1 + gamma g')_+`. `gamma` is a time over a length.
    HuntCrossley,
}

impl Kind {
    /// The key in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viscoelastic => "viscoelastic",
            Self::Dashpot => "dashpot",
            Self::HuntCrossley => "hunt_crossley",
        }
    }

    /// The law in words, for a list of its constants.
    pub fn words(self) -> &'static str {
        match self {
            Self::Viscoelastic => "viscoelastic contacts, gamma",
            Self::Dashpot => "contacts with dashpots, gamma",
            Self::HuntCrossley => "contacts of Hunt and Crossley, gamma",
        }
    }

    /// The exponents that it has, above this number, and the rule in words.
    pub fn exponents(self) -> (f64, &'static str) {
        match self {
            Self::Viscoelastic => (1.0, "viscoelastic contacts have exponents above 1"),
            Self::Dashpot | Self::HuntCrossley => (0.0, "an exponent is finite and positive"),
        }
    }
}

/// The law of one bond: elastic force `F(g) = A (g)_+^alpha`, resistance `c(g)`, and the force `f =
/// (F(g) + c(g) g')_+` for `g > 0`: beads never pull. Where they may, `f = F(g) + c(g) g'` up to
/// the zero of the overlap.
#[derive(Clone, Copy, Debug)]
pub struct BondLaw<R> {
    /// The power of the overlap.
    pub power: ContactLaw<R>,
    /// `A`; zero for beads that cannot touch.
    pub constant: R,
    /// Static overlap: that of beads at the origin.
    pub rest: R,
    /// How it dissipates, and the constant `gamma`, if it does.
    pub loss: Option<(Kind, R)>,
    /// `beta` of a dashpot.
    pub beta: R,
    /// `p` of a dashpot.
    pub rate_power: R,
    /// Whether a contact that dissipates may pull.
    pub pulls: bool,
}

impl<R: Real> BondLaw<R> {
    /// `A`, `alpha`, the static overlap, and the dissipation, which counts if its `gamma` and `A`
    /// are positive; with `beta = 0` and `p = 1`, and without pull.
    pub fn new(constant: f64, alpha: f64, rest: f64, loss: Option<(Kind, f64)>) -> Self {
        let loss = loss.filter(|&(_, gamma)| constant > 0.0 && gamma > 0.0).map(|(kind, gamma)| (kind, R::of(gamma)));
        let [constant, rest] = [constant, rest].map(R::of);
        Self {
            power: ContactLaw::new(alpha),
            constant,
            rest,
            loss,
            beta: R::zero(),
            rate_power: R::one(),
            pulls: false,
        }
    }

    /// The exponent.
    pub fn alpha(&self) -> R {
        self.power.alpha()
    }

    /// Whether it dissipates.
    pub fn dissipates(&self) -> bool {
        self.loss.is_some()
    }

    /// `F(g)`.
    #[inline]
    pub fn elastic(&self, g: R) -> R {
        self.constant * self.power.force(g)
    }

    /// `F'(g)`.
    #[inline]
    pub fn stiffness(&self, g: R) -> R {
        self.constant * self.power.stiffness(g)
    }

    /// `A (g)_+^{alpha+1} / (alpha+1)`.
    pub fn potential(&self, g: R) -> R {
        if g <= R::zero() { R::zero() } else { self.constant * self.power.potential(g) }
    }

    /// `c(g)` of a contact that pushes, also where rounding takes its overlap below zero.
    #[inline]
    pub fn resistance(&self, g: R) -> R {
        match self.loss {
            Some((Kind::Viscoelastic, gamma)) => self.stiffness(g) * gamma,
            Some((Kind::Dashpot, gamma)) if self.beta == R::zero() => gamma,
            Some((Kind::Dashpot, gamma)) => gamma * g.max(R::zero()).powf(self.beta),
            Some((Kind::HuntCrossley, gamma)) => self.elastic(g) * gamma,
            None => R::zero(),
        }
    }

    /// The force at an overlap and its rate; never negative unless it may pull.
    #[inline]
    pub fn force(&self, g: R, rate: R) -> R {
        if self.loss.is_none() || g <= R::zero() {
            return self.elastic(g);
        }
        let force = self.push(g, rate);
        if self.pulls { force } else { force.max(R::zero()) }
    }

    /// The force of a contact that is known to push: smooth through its onset and its end.
    #[inline]
    pub fn push(&self, g: R, rate: R) -> R {
        self.elastic(g) + self.resistance(g) * self.powered(rate)
    }

    /// `|g'|^p sgn g'`; the rate itself but for a dashpot.
    #[inline]
    fn powered(&self, rate: R) -> R {
        if self.rate_power == R::one() { rate } else { rate.abs().powf(self.rate_power - R::one()) * rate }
    }

    /// A function that is positive where a closed contact has a force: `g + gamma alpha g'` for
    /// viscoelastic ones, `F(g)/g^beta + gamma |g'|^p sgn g'` for dashpots, 1 where beads may pull;
    /// `None` without dissipation.
    pub fn pushes(&self, g: R, rate: R) -> Option<R> {
        self.loss.map(|loss| match loss {
            _ if self.pulls => R::one(),
            (Kind::Viscoelastic, gamma) => g + gamma * self.alpha() * rate,
            (Kind::Dashpot, gamma) => self.held_by_rate(g)[0] + gamma * self.powered(rate),
            (Kind::HuntCrossley, gamma) => R::one() + gamma * rate,
        })
    }

    /// The rate of [`pushes`](Self::pushes), from overlap, rate and second derivative.
    pub fn pushes_rate(&self, g: R, rate: R, second: R) -> Option<R> {
        self.loss.map(|loss| match loss {
            _ if self.pulls => R::zero(),
            (Kind::Viscoelastic, gamma) => rate + gamma * self.alpha() * second,
            (Kind::Dashpot, gamma) if self.rate_power == R::one() => self.held_by_rate(g)[1] * rate + gamma * second,
            (Kind::Dashpot, gamma) => {
                let p = self.rate_power;
                self.held_by_rate(g)[1] * rate + gamma * p * rate.abs().powf(p - R::one()) * second
            }
            (Kind::HuntCrossley, gamma) => gamma * second,
        })
    }

    /// `F(g)/g^beta` and its derivative.
    fn held_by_rate(&self, g: R) -> [R; 2] {
        if self.beta == R::zero() {
            return [self.elastic(g), self.stiffness(g)];
        }
        let (g, power) = (g.max(R::zero()), self.alpha() - self.beta);
        [self.constant * g.powf(power), self.constant * power * g.powf((power - R::one()).max(R::zero()))]
    }

    /// The exponent, if beads can touch: the power of time with which `F` begins or ends.
    pub fn elastic_power(&self) -> Option<f64> {
        (self.constant > R::zero()).then(|| self.alpha().f64())
    }

    /// The power of time with which the resisting force begins or ends.
    pub fn power_of_resistance(&self) -> Option<f64> {
        self.loss.map(|loss| match loss {
            (Kind::Viscoelastic, _) => self.alpha().f64() - 1.0,
            (Kind::Dashpot, _) => self.beta.f64(),
            (Kind::HuntCrossley, _) => self.alpha().f64(),
        })
    }

    /// The power of a rate about zero, if the force is not analytic there.
    pub fn kink(&self) -> Option<f64> {
        self.loss.map(|_| self.rate_power.f64()).filter(|power| power % 2.0 != 1.0)
    }

    /// The powers of time with which the force begins or ends.
    pub fn powers(&self) -> impl Iterator<Item = f64> + use<R> {
        self.elastic_power().into_iter().chain(self.power_of_resistance()).chain(self.kink())
    }
}

/// What the windows of contact collocation need of a law, see `collocation/loss.rs`.
impl BondLaw<f64> {
    /// `[a, b]` with `c(g) = a F'(g) + b g^beta`, up to what vanishes with `F(g)`.
    pub(crate) fn resistance_parts(&self) -> [f64; 2] {
        match self.loss {
            Some((Kind::Viscoelastic, gamma)) => [gamma, 0.0],
            Some((Kind::Dashpot, gamma)) => [0.0, gamma],
            Some((Kind::HuntCrossley, _)) | None => [0.0; 2],
        }
    }

    /// Whether `P` has a kink where the rate is zero, as that of a dashpot.
    pub(crate) fn kinked(&self) -> bool {
        matches!(self.loss, Some((Kind::Dashpot, _))) && !self.pulls
    }

    /// `P(g, g')`; the overlap itself where beads may pull.
    pub(crate) fn overlap_that_pushes(&self, overlap: f64, rate: f64) -> f64 {
        match self.loss {
            _ if self.pulls => overlap,
            Some((Kind::Viscoelastic, gamma)) => overlap + gamma * self.alpha() * rate,
            Some((Kind::Dashpot, gamma)) => overlap - self.held(gamma * (-rate).max(0.0)),
            Some((Kind::HuntCrossley, gamma)) if overlap > 0.0 => overlap * (1.0 + gamma * rate),
            _ => overlap,
        }
    }

    /// The overlap at which `F(g)/g^beta` has this value.
    fn held(&self, force: f64) -> f64 {
        (force / self.constant).powf(1.0 / (self.alpha() - self.beta))
    }

    /// An error of the overlap, in a window of length `h`, by which `P` is off by no more than its
    /// absolute `value`; the rate is then off by `2/h` times this.
    pub(crate) fn harmless(&self, overlap: f64, value: f64, h: f64) -> f64 {
        match self.loss {
            _ if self.pulls => value,
            Some((Kind::Viscoelastic, gamma)) => value / (1.0 + gamma * self.alpha() * 2.0 / h),
            // Half for the overlap, half for its rate.
            Some((Kind::Dashpot, _)) => {
                let half = 0.5 * value;
                half.min(0.5 * h * self.elastic(half) / self.resistance(half))
            }
            Some((Kind::HuntCrossley, gamma)) if value > 0.0 => {
                value / (value / overlap.abs() + gamma * overlap.abs() * 2.0 / h)
            }
            _ => value,
        }
    }

    /// A bound of the error of a contact's impulse if its event is off by the time `by` and the
    /// overlap `value`; or by the value `value` of `P` while beads overlap by at most `deepest`.
    pub(crate) fn impulse_besides(&self, value: f64, by: f64, deepest: Option<f64>) -> f64 {
        match (deepest.filter(|_| !self.pulls), self.loss) {
            (None, _) => self.elastic(value) * by + self.resistance(value) * value,
            // With `df/dP` where `P` is zero.
            (Some(overlap), Some((Kind::Viscoelastic | Kind::HuntCrossley, _))) => {
                self.stiffness(overlap) / self.alpha() * value * by
            }
            (Some(overlap), _) => self.stiffness(overlap) * value * by,
        }
    }

    /// The time from the end of a contact to the singularity of its force, where the overlap would
    /// come to zero if the force went on as the same analytic function: `g/|g'|` at the end, from
    /// overlap and rate there. Panels before a release have their origin there.
    pub(crate) fn singular_after(&self, overlap: f64, rate: f64) -> f64 {
        match self.loss {
            _ if self.pulls => 0.0,
            Some((Kind::Viscoelastic, gamma)) => gamma * self.alpha(),
            Some((Kind::Dashpot, gamma)) if rate < 0.0 => self.held(-gamma * rate) / -rate,
            Some((Kind::HuntCrossley, _)) if rate < 0.0 => overlap.max(0.0) / -rate,
            _ => 0.0,
        }
    }
}
