//! Branches of solutions in one parameter, whatever their equations are.
//!
//! A [`Problem`] has equations, multipliers, test functions of bifurcations, and the ways in which
//! its orbits are also orbits of a branch that crosses. A [`Branch`] has the orbits. It is followed
//! by the loop of `arclength`. Multipliers and bifurcations need the orbits only and are computed
//! afterwards, orbit by orbit: they make its points.

use super::{
    arclength::{self, BranchState, End, Family, Range, Scales, Solution},
    shooting::{Equations, NewtonStep},
    switching,
};
use crate::{
    chain::max_norm,
    error::{Error, Result},
    named::named,
    output::FileFormat,
};
use nalgebra::DVector;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::{fmt::Debug, sync::OnceLock};

named! {
    /// What is found about the orbits of a branch; each includes those before it.
    #[derive(PartialOrd)]
    pub enum AnalysisLevel {
        /// Only what is measured without multipliers.
        Orbits = "orbits",
        /// Multipliers.
        Multipliers = "multipliers",
        /// Bifurcations.
        Bifurcations = "bifurcations",
    }
}

named! {
    /// The kinds of bifurcation that are located.
    pub enum BifurcationKind {
        /// A pair of multipliers crosses -1; of driven orbits, one multiplier.
        PeriodDoubling = "period-doubling", "a period doubling";
        /// A pair crosses 1; of driven orbits, one multiplier, and the branch does not turn.
        PlusOne = "plus-one", "a branch point";
        /// Two pairs meet on the circle and leave it, or the other way round.
        KreinCollision = "krein-collision", "a Krein collision";
        /// Two pairs meet on the real axis and leave it, or the other way round.
        RealCollision = "real-collision", "a collision on the real axis";
        /// The branch turns back.
        Fold = "fold", "a fold";
        /// A pair leaves the circle elsewhere than at 1 and -1, or enters it: Neimark-Sacker, of
        /// driven orbits only.
        Torus = "torus", "a torus bifurcation";
    }
    /// The kind in words.
    pub(super) fn words
}

/// An orbit with its multipliers.
pub type At<'a, P> = (&'a <P as Problem>::Orbit, &'a <P as Problem>::Spectrum);

/// A kind of orbits that make branches in one parameter. The type has the numbers of a
/// continuation.
pub trait Problem: Copy + Debug + Serialize + DeserializeOwned + Send + Sync {
    /// The numbers that do not vary, and for those that do the values at one orbit.
    type Setting: Clone + Debug + Send + Sync;
    /// An orbit, with its parameter.
    type Orbit: Clone + Debug + Send + Sync;
    /// Its multipliers.
    type Spectrum: Clone + Debug + Serialize + DeserializeOwned + Send + Sync;
    /// What else is measured at a point.
    type Measures: Clone + Debug + Serialize + DeserializeOwned + Send + Sync;
    /// The multipliers at a bifurcation.
    type Critical: Clone + Debug + Serialize + DeserializeOwned + Send + Sync;
    /// If the corrector fails during the search for the zero of a test function, the last orbit
    /// counts as the bifurcation if the function is at most this there: the corrector is singular
    /// where another branch crosses.
    const NEAR: f64 = 0.0;
    /// What `Branch::weak` is at first.
    const WEAK: Option<f64> = None;
    /// Format and version of the file of a branch.
    const FORMAT: FileFormat;

    /// The name of the parameter.
    fn name(&self) -> &'static str;
    /// How far the branch is followed.
    fn range(&self) -> Range;
    /// The continuation with another range.
    #[must_use]
    fn with_range(self, range: Range) -> Self;
    /// Refuses a value of the parameter outside its rule.
    ///
    /// # Errors
    /// The rule.
    fn check_value(&self, _setting: &Self::Setting, _p: f64) -> Result<()> {
        Ok(())
    }
    /// Refuses numbers outside their rules, for a branch that begins at the value `from`.
    ///
    /// # Errors
    /// The rule, with the name of the number on the command line.
    fn check_range(&self, setting: &Self::Setting, from: f64) -> Result<()> {
        let Range { to, step, most_points, .. } = self.range();
        arclength::check([from, to], step, most_points)?;
        self.check_value(setting, to).map_err(|why| why.named("to"))
    }

    /// The equations `F(z, p) = 0`, as in `arclength`.
    ///
    /// # Errors
    /// A flow that fails.
    fn equations(&self, setting: &Self::Setting, z: &[f64], p: f64, derivative: bool) -> Result<Equations>;
    /// A solution at this value of the parameter, by Newton's method from `seed`.
    ///
    /// # Errors
    /// No convergence.
    fn solve(&self, setting: &Self::Setting, seed: &[f64], p: f64) -> Result<Solution>;
    /// Unit of residuals.
    fn size(&self, _setting: &Self::Setting, z: &[f64], _p: f64) -> f64 {
        max_norm(z.iter().copied())
    }
    /// Least unit of unknowns along a branch, where they may be nearly zero.
    fn least(&self, _setting: &Self::Setting, _z: &[f64]) -> f64 {
        0.0
    }
    /// Whether a solution may be one of another branch, from the chord to it, the predictor and
    /// Newton's corrections; the step is then halved.
    fn strays(&self, chord: f64, predictor: f64, newton: &[NewtonStep]) -> bool {
        arclength::strays(chord, predictor, newton)
    }
    /// Largest residual of a solution, in its unit.
    fn solved(&self, setting: &Self::Setting, z: &[f64], p: f64) -> f64;

    /// The orbit of a solution.
    fn orbit(&self, setting: &Self::Setting, solution: &Solution) -> Self::Orbit;
    /// The solution of an orbit.
    fn solution(&self, setting: &Self::Setting, orbit: &Self::Orbit) -> Solution;
    /// Why a branch ends with this orbit, if it does.
    fn ends(&self, _setting: &Self::Setting, _orbit: &Self::Orbit) -> Option<End> {
        None
    }

    /// The multipliers of an orbit.
    ///
    /// # Errors
    /// An integration that fails, or eigenvalues that do not converge.
    fn spectrum(&self, setting: &Self::Setting, orbit: &Self::Orbit) -> Result<Self::Spectrum>;
    /// The multipliers as points have them.
    fn kept(spectrum: Self::Spectrum) -> Self::Spectrum {
        spectrum
    }
    /// What else is measured.
    ///
    /// # Errors
    /// An integration that fails.
    fn measures(&self, setting: &Self::Setting, orbit: &Self::Orbit) -> Result<Self::Measures>;

    /// Names and lengths of the arrays into which the numbers of an orbit are divided in a file.
    fn arrays(setting: &Self::Setting) -> Vec<(&'static str, usize)>;
    /// The numbers of an orbit that are kept, its unknowns, with its parameter and residual.
    fn numbers(&self, setting: &Self::Setting, orbit: &Self::Orbit) -> Solution {
        self.solution(setting, orbit)
    }
    /// The orbit of these numbers, to the bit.
    fn restored(&self, setting: &Self::Setting, numbers: Solution) -> Self::Orbit {
        self.orbit(setting, &numbers)
    }
    /// Real part, imaginary part and error of the modulus of each multiplier.
    fn multipliers(spectrum: &Self::Spectrum) -> Vec<[f64; 3]>;
    /// Refuses numbers that are not those of an orbit, by an integration.
    ///
    /// # Errors
    /// The rule that they break.
    fn verify(&self, setting: &Self::Setting, orbit: &Self::Orbit) -> Result<()>;

    /// Least unit of the parameter between two orbits, of which the first has the parameter `p`:
    /// beside a fold both have nearly the same.
    fn least_change(&self, _p: f64) -> f64 {
        0.0
    }
    /// The bifurcations between two orbits, and the number of places with several that were not
    /// separated.
    fn between(_branch: &Branch<Self>, _ends: [At<'_, Self>; 2]) -> (Vec<Located<Self>>, usize) {
        (Vec::new(), 0)
    }
    /// The fold between the first and the last of three orbits, if [`between`](Self::between) does
    /// not find it.
    fn fold(_branch: &Branch<Self>, _three: [At<'_, Self>; 3]) -> Option<Located<Self>> {
        None
    }

    /// The setting of the branch that crosses at a bifurcation, and the numbers of the ways in
    /// which an orbit may be one of it; otherwise why none does.
    ///
    /// # Errors
    /// A setting outside its rules.
    fn crossing(
        &self,
        _setting: &Self::Setting,
        _kind: BifurcationKind,
    ) -> Result<std::result::Result<(Self::Setting, usize), &'static str>> {
        Ok(Err("branches of this kind are not followed"))
    }
    /// Unknowns and parameter of an orbit as one of the branch that crosses, in one of these ways.
    ///
    /// # Errors
    /// An integration that fails.
    fn crossed(
        &self,
        setting: &Self::Setting,
        orbit: &Self::Orbit,
        _kind: BifurcationKind,
        _way: usize,
    ) -> Result<(Vec<f64>, f64)> {
        let Solution { z, p, .. } = self.solution(setting, orbit);
        Ok((z, p))
    }
    /// State after half of the time of an orbit of doubled period, less that at its start.
    ///
    /// # Errors
    /// An integration that fails.
    fn halves_apart(&self, _setting: &Self::Setting, _orbit: &Self::Orbit) -> Result<DVector<f64>> {
        Ok(DVector::zeros(0))
    }
    /// What changes its sign where the orbits of the branch vanish, if they can.
    fn swing(&self, _setting: &Self::Setting, _orbit: &Self::Orbit) -> Option<DVector<f64>> {
        None
    }
}

/// The range of a continuation that has fields for it.
macro_rules! ranged {
    () => {
        fn range(&self) -> Range {
            let &Self { to, step, most_points, .. } = self;
            Range { to, step, most_points }
        }

        fn with_range(self, Range { to, step, most_points }: Range) -> Self {
            Self { to, step, most_points, ..self }
        }
    };
}
pub(crate) use ranged;

/// The equations of a problem with a setting.
pub(super) struct Varying<'a, P: Problem> {
    continuation: &'a P,
    setting: &'a P::Setting,
}

impl<P: Problem> Family for Varying<'_, P> {
    fn equations(&self, z: &[f64], p: f64, derivative: bool) -> Result<Equations> {
        self.continuation.equations(self.setting, z, p, derivative)
    }

    fn solve(&self, seed: &[f64], p: f64) -> Result<Solution> {
        self.continuation.solve(self.setting, seed, p)
    }

    fn size(&self, z: &[f64], p: f64) -> f64 {
        self.continuation.size(self.setting, z, p)
    }

    fn least(&self, z: &[f64]) -> f64 {
        self.continuation.least(self.setting, z)
    }

    fn strays(&self, chord: f64, predictor: f64, newton: &[NewtonStep]) -> bool {
        self.continuation.strays(chord, predictor, newton)
    }

    fn solved(&self, z: &[f64], p: f64) -> f64 {
        self.continuation.solved(self.setting, z, p)
    }
}

/// An orbit of a branch with its multipliers.
#[derive(Clone, Debug)]
pub struct Point<P: Problem> {
    /// The orbit.
    pub orbit: P::Orbit,
    /// Its multipliers.
    pub spectrum: P::Spectrum,
    /// What else was measured.
    pub measures: P::Measures,
}

/// A bifurcation of a branch.
#[derive(Clone, Debug, PartialEq)]
pub struct Bifurcation<P: Problem> {
    /// The kind of bifurcation.
    pub kind: BifurcationKind,
    /// Value of the parameter.
    pub parameter: f64,
    /// The multipliers that meet or cross the unit circle.
    pub critical: P::Critical,
    /// The orbit there.
    pub orbit: P::Orbit,
    /// Number of the orbit of the branch before it, from 0 on.
    pub after: usize,
}

/// A bifurcation with the solution there.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Located<P: Problem> {
    /// Its kind.
    pub kind: BifurcationKind,
    /// The multipliers.
    pub critical: P::Critical,
    /// The solution.
    pub solution: Solution,
    /// Number of the orbit before it.
    pub after: usize,
}

/// A branch: its orbits with everything that is needed to go on, and what was found about them.
#[derive(Clone, Debug)]
pub struct Branch<P: Problem> {
    /// How the branch is followed.
    pub continuation: P,
    /// The numbers that do not vary.
    pub setting: P::Setting,
    /// The value of the parameter at which the branch ends if it has turned back: that of its first
    /// orbit or, for a branch that was begun where it crosses another one, of the first orbit of
    /// the other branch.
    pub back: f64,
    /// The kind of the bifurcation at which the branch begins, if it was begun where it crosses
    /// another one; the first orbit is the one at that bifurcation. After a period doubling the
    /// branch ends where it comes back to the branch of half its period.
    pub birth: Option<BifurcationKind>,
    /// Bound for collisions of multipliers: those that lead to no modulus above `1 + weak` are not
    /// located. `None`: no bifurcations are located.
    pub weak: Option<f64>,
    /// What is found about the orbits.
    pub level: AnalysisLevel,
    /// The orbits, at least one, in their order along the branch.
    pub orbits: Vec<P::Orbit>,
    /// Length of the next predictor.
    pub ds: f64,
    /// Why the orbits end; `None` while the branch can go on.
    pub end: Option<End>,
    /// The orbits whose multipliers are known, with these.
    pub points: Vec<Point<P>>,
    /// What was measured of the first orbits, if no multipliers are asked for; `None` where that
    /// failed.
    pub measured: Vec<Option<P::Measures>>,
    /// Values of the parameter of orbits whose multipliers could not be computed.
    pub gaps: Vec<f64>,
    /// Whether the multipliers of the last orbit are known.
    pub whole: bool,
    /// The bifurcations between the points, in their order, with the folds of reversible orbits
    /// last.
    pub bifurcations: Vec<Bifurcation<P>>,
    /// Number of places with bifurcations that were not located one by one.
    pub unresolved: usize,
}

impl<P: Problem> Branch<P> {
    /// A branch that has only its first orbit.
    ///
    /// # Errors
    /// Numbers of the continuation outside their rules.
    pub fn new(continuation: P, setting: P::Setting, start: P::Orbit) -> Result<Self> {
        let (back, Range { to, step, .. }) = (continuation.solution(&setting, &start).p, continuation.range());
        let branch = Self {
            end: continuation.ends(&setting, &start),
            continuation,
            setting,
            back,
            birth: None,
            weak: P::WEAK,
            level: AnalysisLevel::Bifurcations,
            orbits: vec![start],
            ds: step / (to - back).abs(),
            points: Vec::new(),
            measured: Vec::new(),
            gaps: Vec::new(),
            whole: false,
            bifurcations: Vec::new(),
            unresolved: 0,
        };
        branch.check().map(|()| branch)
    }

    /// Refuses numbers of the continuation outside their rules.
    pub(super) fn check(&self) -> Result<()> {
        self.continuation.check_range(&self.setting, self.back)
    }

    pub(super) fn family(&self) -> Varying<'_, P> {
        Varying { continuation: &self.continuation, setting: &self.setting }
    }

    pub(super) fn solution(&self, orbit: &P::Orbit) -> Solution {
        self.continuation.solution(&self.setting, orbit)
    }

    /// The value of the parameter of an orbit.
    pub fn parameter(&self, orbit: &P::Orbit) -> f64 {
        self.solution(orbit).p
    }

    /// The numbers that determine an orbit: parameter and unknowns.
    pub fn numbers(&self, orbit: &P::Orbit) -> (f64, Vec<f64>) {
        let Solution { z, p, .. } = self.solution(orbit);
        (p, z)
    }

    fn last(&self) -> Result<&P::Orbit> {
        self.orbits.last().ok_or_else(|| Error::parameter("orbits", 0, "at least one"))
    }

    /// Changes the settings so that the branch can continue: the end, the step and the largest
    /// number of points.
    ///
    /// A branch that reached its end, turned back or came back to the branch of half its period
    /// stays as it is unless another end is given; one that its last orbit ends, in any case.
    ///
    /// # Errors
    /// An end that is not beyond the last point, seen from the first; numbers outside their rules.
    pub fn onward(mut self, to: Option<f64>, step: Option<f64>, most_points: usize) -> Result<Self> {
        let complete = to.is_none() && self.end.is_some_and(End::is_complete);
        let range = self.continuation.range();
        let (to, step) = (to.unwrap_or(range.to), step.unwrap_or(range.step));
        self.continuation = self.continuation.with_range(Range { to, step, most_points });
        let last = self.parameter(self.last()?);
        self.check()?;
        if !complete {
            arclength::check_onward([self.back, last], to)?;
            self.end = self.continuation.ends(&self.setting, self.last()?);
        }
        Ok(self)
    }

    /// Follows the branch from its last orbit, past folds, to the final value of the parameter.
    ///
    /// `seen` is called after every new orbit. A branch that was stopped on the way continues with
    /// the same bits.
    ///
    /// # Errors
    /// Numbers outside their rules; [`Error::Stopped`] if the process was asked to end, after which
    /// the branch can continue. A branch that ends early is not an error: the [`End`] says why.
    pub fn extend(&mut self, mut seen: impl FnMut(&Self)) -> Result<End> {
        self.check()?;
        let (continuation, setting, back) = (self.continuation, self.setting.clone(), self.back);
        let range = continuation.range();
        let family = Varying { continuation: &continuation, setting: &setting };
        let place = |orbit: &P::Orbit| {
            let Solution { z, p, .. } = continuation.solution(&setting, orbit);
            (z, p)
        };
        let (last, previous) = (self.last()?, self.orbits.iter().rev().nth(1).map(place));
        let state = BranchState { back, previous, last: place(last), ds: self.ds, points: self.orbits.len() };
        let direction = (range.to - back).signum();
        let doubled = self.birth == Some(BifurcationKind::PeriodDoubling);
        let vanishing = |orbit: &P::Orbit| match doubled {
            true => continuation.halves_apart(&setting, orbit).map(Some),
            false => Ok(continuation.swing(&setting, orbit)),
        };
        let mut before = vanishing(last)?;
        self.end = None;
        let end = arclength::follow(&family, state, range, direction, &mut |solution, ds, end| {
            let orbit = continuation.orbit(&setting, solution);
            let now = vanishing(&orbit)?;
            if before.iter().zip(&now).any(|(before, now)| switching::changed_places(before, now)) {
                return Ok(Some(if doubled { End::Rejoined } else { End::AtRest }));
            }
            before = now;
            let end = end.or(continuation.ends(&setting, &orbit));
            *solution = continuation.solution(&setting, &orbit);
            self.orbits.push(orbit);
            // `end` is set before the call, so that a branch saved by `seen` has it.
            (self.ds, self.end) = (ds, end);
            seen(self);
            Ok(end)
        })?;
        self.end = Some(end);
        Ok(end)
    }

    /// Whether bifurcations are located, for which the multipliers of the orbit before are needed.
    pub fn joined(&self) -> bool {
        self.level == AnalysisLevel::Bifurcations && self.weak.is_some()
    }

    /// The branch with points and bifurcations.
    pub fn analysed(self) -> Self {
        let spectra = Spectra::new(&self);
        let rows = (0..self.orbits.len()).map(|k| spectra.analysis(k)).collect();
        self.with(rows)
    }

    /// The branch with what was found about its first orbits. An orbit without multipliers is no
    /// point; its parameter is among the gaps.
    pub fn with(mut self, rows: Vec<Analysis<P>>) -> Self {
        (self.points, self.measured, self.gaps, self.bifurcations, self.unresolved) = Default::default();
        self.whole = rows.len() == self.orbits.len() && rows.last().is_none_or(|row| row.measured.is_ok());
        let mut folds = Vec::new();
        for (k, Analysis { measured, found, fold, unresolved }) in rows.into_iter().enumerate() {
            let found: Vec<_> = found.into_iter().map(|one| self.bifurcation(one)).collect();
            self.bifurcations.extend(found);
            folds.extend(fold.map(|one| self.bifurcation(one)));
            self.unresolved += unresolved;
            match measured {
                Ok((Some(spectrum), measures)) => {
                    self.points.push(Point { orbit: self.orbits[k].clone(), spectrum, measures });
                }
                Ok((None, measures)) => self.measured.push(Some(measures)),
                Err(_) if self.level == AnalysisLevel::Orbits => self.measured.push(None),
                Err(_) => self.gaps.push(self.parameter(&self.orbits[k])),
            }
        }
        self.bifurcations.extend(folds);
        self
    }

    /// Why the branch ended, with its multipliers.
    pub fn ended(&self) -> End {
        End::with_multipliers(self.end, self.whole)
    }

    pub(super) fn bifurcation(&self, Located { kind, critical, solution, after }: Located<P>) -> Bifurcation<P> {
        let orbit = self.continuation.orbit(&self.setting, &solution);
        Bifurcation { kind, parameter: solution.p, critical, orbit, after }
    }

    /// The branch that crosses this one at bifurcation `k`, from 0 on: of doubled period at a
    /// period doubling, of the same period at a branch point. Its first orbit is the one at the
    /// crossing, its second one is off this branch, in one of two directions. At a period doubling
    /// both directions have the same orbits, which begin half of the doubled period apart.
    ///
    /// # Errors
    /// No such bifurcation, or one at which no other branch of periodic orbits crosses; a doubled
    /// period outside its rule; no direction in which a branch leaves, or no orbit on it.
    pub fn switched(&self, k: usize) -> Result<Self> {
        let birth = switching::numbered(&self.bifurcations, k)?;
        let refused =
            |rule: &'static str| Err(Error::parameter("switch", format!("{}, {}", k + 1, birth.kind.words()), rule));
        let (setting, ways) = match self.continuation.crossing(&self.setting, birth.kind)? {
            Ok(crossing) => crossing,
            Err(rule) => return refused(rule),
        };
        let range = self.continuation.range();
        let family = Varying { continuation: &self.continuation, setting: &setting };
        for way in 0..ways {
            let place = |orbit: &P::Orbit| self.continuation.crossed(&setting, orbit, birth.kind, way);
            let (z, p) = place(&birth.orbit)?;
            let scales = Scales::new(&z, (range.to - self.back).abs());
            let [a, b] = [0, 1].map(|j| place(&self.orbits[birth.after + j]));
            let (a, b) = (a?, b?);
            let along = scales.chord((&a.0, a.1), (&b.0, b.1)).normalize();
            let Some(v) = switching::crossing(&family, (&z, p), scales, &along)? else { continue };
            let (second, ds) = switching::first(&family, (&z, p), scales, &v)?;
            // Seen from another time the parameter may have the other sign.
            let sign = if p * birth.parameter < 0.0 { -1.0 } else { 1.0 };
            let residual = self.solution(&birth.orbit).residual;
            let orbits = [Solution { z, p, residual, newton: Vec::new() }, second];
            let orbits = orbits.map(|one| self.continuation.orbit(&setting, &one)).to_vec();
            let continuation = self.continuation.with_range(Range { to: sign * range.to, ..range });
            let branch = Self::new(continuation, setting, orbits[0].clone())?;
            let (back, weak, level, birth) = (sign * self.back, self.weak, self.level, Some(birth.kind));
            return Ok(Self { back, weak, level, birth, orbits, ds, ..branch });
        }
        refused("not exactly one other branch crosses there, of orbits that this search finds")
    }
}

/// What was found about an orbit of a branch.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Analysis<P: Problem> {
    /// Multipliers, if they are asked for, and measures, or why there are none.
    measured: std::result::Result<(Option<P::Spectrum>, P::Measures), String>,
    /// Bifurcations between the nearest orbit before that has multipliers and this one.
    found: Vec<Located<P>>,
    /// The fold at that orbit, if the branch turns there.
    fold: Option<Located<P>>,
    /// Number of places there with bifurcations that were not located one by one.
    unresolved: usize,
}

/// The multipliers of the orbits of a branch, computed when they are first asked for.
pub struct Spectra<'a, P: Problem> {
    branch: &'a Branch<P>,
    /// Number of the first orbit before which the branch has turned.
    turned: Option<usize>,
    all: Vec<OnceLock<std::result::Result<P::Spectrum, String>>>,
}

impl<'a, P: Problem> Spectra<'a, P> {
    /// Those of a branch, none of them computed yet.
    pub fn new(branch: &'a Branch<P>) -> Self {
        let all: Vec<f64> = branch.orbits.iter().map(|orbit| branch.parameter(orbit)).collect();
        let turned = all.windows(3).position(|p| (p[1] - p[0]) * (p[2] - p[1]) < 0.0).map(|k| k + 2);
        Self { branch, turned, all: branch.orbits.iter().map(|_| OnceLock::new()).collect() }
    }

    /// The multipliers of orbit `k`.
    pub fn at(&self, k: usize) -> std::result::Result<&P::Spectrum, &String> {
        let Branch { continuation, setting, orbits, .. } = self.branch;
        let compute = || continuation.spectrum(setting, &orbits[k]).map(P::kept).map_err(|why| why.to_string());
        self.all[k].get_or_init(compute).as_ref()
    }

    /// The nearest orbit before `k` whose multipliers are known. The orbit at a crossing is on both
    /// branches: its multiplier 1 is no bifurcation of this one, so it is left out.
    fn before(&self, k: usize) -> Option<(usize, At<'_, P>)> {
        let first = usize::from(self.branch.birth.is_some());
        (first..k).rev().find_map(|k| Some((k, (&self.branch.orbits[k], self.at(k).ok()?))))
    }

    /// The bifurcations between orbit `k` and the one before, the fold there, and the number of
    /// places that were not resolved.
    fn bifurcations(&self, k: usize) -> (Vec<Located<P>>, Option<Located<P>>, usize) {
        let branch = self.branch;
        let joined = branch.joined().then(|| Some((self.at(k).ok()?, self.before(k)?)));
        let Some((spectrum, (j, before))) = joined.flatten() else { return (Vec::new(), None, 0) };
        let here = (&branch.orbits[k], spectrum);
        let (mut found, unresolved) = P::between(branch, [before, here]);
        found.iter_mut().for_each(|one| one.after = j);
        // Where the branch does not turn, the multipliers of a third orbit are not needed.
        let third = self.turned.filter(|turned| *turned <= k).and_then(|_| self.before(j));
        let fold = third.and_then(|(i, first)| Some(Located { after: i, ..P::fold(branch, [first, before, here])? }));
        (found, fold, unresolved)
    }

    /// All that is found about orbit `k`.
    pub fn analysis(&self, k: usize) -> Analysis<P> {
        let Branch { continuation, setting, orbits, level, .. } = self.branch;
        let spectrum = (*level > AnalysisLevel::Orbits).then(|| self.at(k)).transpose().map_err(String::clone);
        let measured = spectrum.and_then(|spectrum| {
            let measures = continuation.measures(setting, &orbits[k]).map_err(|why| why.to_string())?;
            Ok((spectrum.cloned(), measures))
        });
        let (found, fold, unresolved) = self.bifurcations(k);
        Analysis { measured, found, fold, unresolved }
    }
}
