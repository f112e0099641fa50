//! Section 5: bright breathers, both the exact trivial ones and the small long-lived ones.
//!
//! | symbol | meaning |
//! |---|---|
//! | `l_n` | right side of (constraint2), the least `b_n - b_{n-1}` |
//! | `Fbar_n` | mean contact force over a period |
//! | core | fewest sites, symmetric about the centre, that hold a share of 0.999 of `sum a_n^2` |

use super::{Group, Quantity, Runs};
use crate::{
    breathers::{BrightBreather, DarkBreather, TrivialBreather},
    chain::{Boundary, Chain, Params, State, max_norm},
    dps::{Center, Homoclinic, per_gamma},
    error::Result,
    orbits::Shooting,
    run::method::Method,
    run::state_at,
    scene::Scene,
    study::{self, BreatherOptions, Initial, Norm, TheoremOptions, bright_breather, trivial_breather},
};
use hertzchain_integrators::collocation::Pace;
use num_complex::Complex64;
use std::f64::consts::PI;

pub(super) const GROUPS: &[Group] = &[
    Group::of(trivial),
    Group::of(no_others),
    Group::of(homoclinics),
    Group::of(theorem),
    Group::of(frequencies),
    Group::of(numbers),
    Group::of(long_run),
];

const CENTERS: [Center; 2] = [Center::Site, Center::Bond];
const ALPHA: f64 = 1.5;
const RHO: f64 = 1.0 / 3.0;
const SITES: usize = 12;
const TOLERANCE: f64 = 1e-12;

/// A localised breather without symmetry: `a_n` is a Gaussian that is not centred on a site,
/// `phase` gives the `phi_n`, and the `d_n` increase by `step` at every third site.
fn breather(phase: impl Fn(f64) -> f64, step: f64) -> Result<TrivialBreather> {
    let sites = || (0..SITES).map(|n| n as f64);
    let amplitude = |n: f64| 0.1 * (-0.2 * (n - 4.8).powi(2)).exp();
    let offsets: Vec<f64> = sites().map(|n| step * (n / 3.0).floor()).collect();
    let params = Params::new(ALPHA, 1.0, RHO)?;
    TrivialBreather::new(params, sites().map(amplitude).collect(), sites().map(phase).collect(), &offsets)
}

fn irregular(n: f64) -> f64 {
    0.7 * n * n
}

/// `l_n` as printed, with `a = 0` before the first site.
fn least_gap(breather: &TrivialBreather, n: usize) -> f64 {
    let (a, phi) = (breather.amplitudes(), breather.phases());
    let Some(k) = n.checked_sub(1) else { return RHO / (1.0 + RHO) * a[0] };
    let square = a[n].powi(2) + a[k].powi(2) - 2.0 * a[n] * a[k] * (phi[n] - phi[k]).cos();
    RHO / (1.0 + RHO) * square.max(0.0).sqrt()
}

/// The free chain at `t = 0`, with the mean positions of the breather times `scale`.
fn chain_of(breather: &TrivialBreather, scale: f64) -> Result<(Chain<f64>, State<f64>)> {
    let chain = Chain::new(breather.params(), Boundary::Free, SITES)?;
    let state = State::from_fn(&chain, |n| {
        let (site, moved) = (breather.site(n, 0.0), (scale - 1.0) * breather.means()[n]);
        crate::chain::Site { u: site.u + moved, v: site.v + moved, ..site }
    })?;
    Ok((chain, state))
}

/// Mean contact forces over a period of a breather whose gaps are `scale` times the least ones,
/// divided by the force at an overlap of the largest amplitude.
fn mean_force(scale: f64) -> Result<f64> {
    let breather = breather(irregular, 0.0)?;
    let (chain, state) = chain_of(&breather, scale)?;
    let period = 2.0 * PI / breather.params().omega();
    let forces = chain.mean_contact_forces(state.as_slice(), period, Pace::Tolerance(TOLERANCE))?;
    let swing = max_norm((0..SITES).map(|n| breather.swing(n)));
    Ok(forces.range().1 / swing.powf(ALPHA))
}

/// Largest difference of two sequences divided by the largest entry of the second.
fn apart(ours: &[f64], theirs: &[f64]) -> f64 {
    max_norm(ours.iter().zip(theirs).map(|(a, b)| a - b)) / max_norm(theirs.iter().copied())
}

/// The formulas from (constraint) to the simplified `b_n`.
fn trivial(_: &Runs) -> Result<Vec<Quantity>> {
    let (loose, antiphase) = (breather(irregular, 0.01)?, breather(|n| PI * n, 0.01)?);
    let omega = loose.params().omega();
    // (uncpl) as printed compared with the chain, at a time not in step with the oscillation.
    let (chain, state) = chain_of(&loose, 1.0)?;
    let end = 10.3 * 2.0 * PI / omega;
    let mut run = chain.collocation(state.as_slice(), (0.0, end), Pace::Tolerance(TOLERANCE))?;
    let y = state_at(&mut run, end)?;
    let swing = |n: usize| loose.amplitudes()[n] * (omega * end + loose.phases()[n]).cos() / (1.0 + RHO);
    let printed = |n: usize| [loose.means()[n] + RHO * swing(n), loose.means()[n] - swing(n)];
    let off = (0..SITES).flat_map(|n| [y[n] - printed(n)[0], y[SITES + n] - printed(n)[1]]);
    // The least distance of neighbouring beads among samples of a period, and (constraint2).
    let closest = |n: usize| {
        let gap = |k: u32| {
            let t = 2.0 * PI / omega * f64::from(k) / 4000.0;
            loose.site(n, t).u - loose.site(n - 1, t).u
        };
        (0..4000).map(gap).fold(f64::INFINITY, f64::min)
    };
    let slack = |n: usize| loose.means()[n] - loose.means()[n - 1] - least_gap(&loose, n);
    let scale = max_norm((0..SITES).map(|n| loose.swing(n)));
    let sum = |breather: &TrivialBreather, gap: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..breather.means().len()).map(|n| 0.01 * (n / 3) as f64 + (0..=n).map(gap).sum::<f64>()).collect()
    };
    let alternating = |n: usize| {
        let a = antiphase.amplitudes();
        0.01 * (n / 3) as f64 + RHO / (1.0 + RHO) * (a[n] + 2.0 * a[..n].iter().sum::<f64>())
    };
    let simplified: Vec<f64> = (0..SITES).map(alternating).collect();
    let rises = loose.means().windows(2).map(|two| two[1] - two[0]);
    Ok(vec![
        ("s5-uncpl", max_norm(off) / scale),
        ("s5-constraint2", max_norm((1..SITES).map(|n| closest(n) - slack(n))) / scale),
        ("s5-constraint2-if", mean_force(1.0)?),
        ("s5-constraint2-only-if", mean_force(0.9)?),
        ("s5-means", apart(loose.means(), &sum(&loose, &|n| least_gap(&loose, n)))),
        ("s5-kink", rises.fold(f64::INFINITY, f64::min)),
        ("s5-antiphase", apart(antiphase.means(), &simplified)),
    ])
}

/// Theorem nobreath: the steps of its proof, on the chain.
fn no_others(_: &Runs) -> Result<Vec<Quantity>> {
    let shooting = Shooting::default();
    let params = Params::new(ALPHA, 1.0, RHO)?;
    let orbit = DarkBreather { params, center: Center::Site, sites: 41, omega_b: 2.05, c_x: 0.0 }.orbit(&shooting)?;
    let pace = Pace::Tolerance(shooting.tol);
    let dark = orbit.setting.chain()?.mean_contact_forces(&orbit.start(), orbit.setting.period(), pace)?;
    let options = BreatherOptions { method: Method::Collocation, tolerance: TOLERANCE };
    let exact = trivial_breather(&Scene::load("trivial-breather")?, &options, &mut |_| {})?;
    let scene = Scene::load("bright-breather")?;
    let bright = BrightBreather::new(scene.chain().params(), Center::Bond, 0.01, 40)?;
    let (start, pace) = (scene.initial().as_slice(), Pace::Tolerance(TOLERANCE));
    let forces = scene.chain().mean_contact_forces(start, bright.period(), pace)?;
    Ok(vec![
        ("s5-nobreath-constant", dark.spread() / dark.mean()),
        ("s5-nobreath-zero", exact.forces.range().1),
        ("s5-nobreath-exact", max_norm(exact.deviation.iter().copied())),
        ("s5-nobreath-bright", forces.spread() / forces.range().1),
    ])
}

/// The larger value of the two symmetries.
fn worst(of: impl Fn(&Homoclinic) -> f64) -> Result<f64> {
    let [one, two] = CENTERS.map(|center| Homoclinic::new(ALPHA, center));
    Ok(of(&one?).max(of(&two?)))
}

/// The least `n_0` from which on `|a_n| <= beta^{1 + alpha^{n - n_0}}`; infinite if that leaves
/// fewer than four sites.
fn onset(a: &Homoclinic, beta: f64) -> f64 {
    let last = *a.sites().end();
    let bound = |n: i64, n_0: i64| (1.0 + ALPHA.powi((n - n_0) as i32)) * beta.ln();
    let found = (0..=last - 3).find(|&n_0| (n_0..=last).all(|n| a.a(n).abs().ln() <= bound(n, n_0)));
    found.map_or(f64::INFINITY, |n_0| n_0 as f64)
}

/// `|F|^{alpha-1} F`.
fn power(z: Complex64) -> Complex64 {
    z * z.norm().powf(ALPHA - 1.0)
}

/// Theorem homoclinic, and the equations that its sequences solve.
fn homoclinics(_: &Runs) -> Result<Vec<Quantity>> {
    let omega_0 = omega_0(ALPHA);
    // Residual of (eq:DpSlr), i dA/dtau = omega_0 delta^+ [..], for (solper), relative to the left
    // side.
    let modulation = |a: &Homoclinic, epsilon: f64, tau: f64| {
        let rate = omega_0 * epsilon.abs().powf(ALPHA - 1.0);
        let envelope = |n: i64| Complex64::from_polar(epsilon * a.a(n), rate * tau);
        let force = |n: i64| power(envelope(n) - envelope(n - 1));
        let off = |n: i64| {
            let left = -rate * envelope(n);
            (left - omega_0 * (force(n + 1) - force(n))).norm() / left.norm()
        };
        // Forces of the last sites are subnormal; these sites are left out.
        a.sites().filter(|&n| a.a(n).abs() > 1e-280).map(off).fold(0.0, f64::max)
    };
    let sign = |a: &Homoclinic| {
        let positive = |n: i64| if n % 2 == 0 { a.a(n) } else { -a.a(n) };
        -a.sites().map(positive).fold(f64::INFINITY, f64::min)
    };
    let monotone = |a: &Homoclinic| {
        let inner = a.sites().filter(|&n| n <= 0 && n > *a.sites().start());
        inner.map(|n| a.a(n - 1).abs() / a.a(n).abs()).fold(0.0, f64::max)
    };
    let symmetry = |a: &Homoclinic| {
        let image = |n: i64| if a.center() == Center::Site { a.a(-n) } else { -a.a(1 - n) };
        max_norm(a.sites().map(|n| a.a(n) - image(n)))
    };
    let betas = [0.9, 0.5, 0.1, 1e-3, 1e-6];
    Ok(vec![
        ("s5-dpsstat", worst(|a| modulation(a, 1.0, 0.0))?),
        ("s5-solper", worst(|a| modulation(a, -0.3, 0.7))?),
        ("s5-homoclinic-sign", worst(sign)?),
        ("s5-homoclinic-monotone", worst(monotone)?),
        ("s5-homoclinic-symmetry", worst(symmetry)?),
        ("s5-homoclinic-decay", worst(|a| betas.map(|beta| onset(a, beta)).into_iter().fold(0.0, f64::max))?),
    ])
}

/// `omega_0` as printed in (eq:defom0); `per_gamma` is the reciprocal of the Gamma function.
fn omega_0(alpha: f64) -> f64 {
    2f64.powf(alpha - 2.0) * per_gamma(0.5 * (alpha + 1.0) + 1.0) / (PI.sqrt() * per_gamma(0.5 * alpha + 1.0))
}

/// Theorem longlivedb in the norm `l_1`.
fn theorem(_: &Runs) -> Result<Vec<Quantity>> {
    // Growth of sup / epsilon^power over a decade of epsilon, for C_i = C_r = 1.
    let decade = |initial: Initial| -> Result<[f64; 3]> {
        let epsilons = vec![1e-4, 1e-5];
        let options = TheoremOptions { horizon: 2.0, initial, c_i: 1.0, epsilons, ..TheoremOptions::default() };
        let study = study::theorem(&options, None, &|_| {})?;
        let [coarse, fine] = [0, 1].map(|k| study.scaled(&study.runs[k], Norm::One).0);
        Ok([0, 1, 2].map(|k| fine[k] / coarse[k]))
    };
    let (site, bond) = (decade(Initial::Site)?, decade(Initial::Bond)?);
    Ok(vec![
        ("s5-theorem-u", site[0].max(bond[0])),
        ("s5-theorem-v", site[1].max(bond[1])),
        ("s5-theorem-vdot", site[2].max(bond[2])),
    ])
}

/// The frequency of the breather, and the linear frequency at finite `rho`.
fn frequencies(_: &Runs) -> Result<Vec<Quantity>> {
    let shift = |epsilon: f64| -> Result<[f64; 2]> {
        let rho = epsilon.powf(-2.0 * (ALPHA - 1.0));
        let params = Params::new(ALPHA, 1.0, rho)?;
        let bright = BrightBreather::new(params, Center::Bond, epsilon, 40)?;
        let unit = epsilon.powf(ALPHA - 1.0);
        Ok([(bright.omega_b() - 1.0) / unit, (bright.omega_b() - params.omega()) / unit])
    };
    let shifts = [1e-1, 1e-2, 1e-4, 1e-6].map(shift).into_iter().collect::<Result<Vec<_>>>()?;
    Ok(vec![
        ("s5-Omega-b", shifts[1][0] / omega_0(ALPHA)),
        ("s5-omega-rho", 1e6 * (Params::new(ALPHA, 1.0, 1e6)?.omega() - 1.0)),
        ("s5-frequencies", shifts.iter().map(|shift| shift[1]).fold(f64::INFINITY, f64::min)),
    ])
}

/// The printed numbers of the run.
fn numbers(_: &Runs) -> Result<Vec<Quantity>> {
    let breather = BrightBreather::new(Params::new(ALPHA, 1.0, 1000.0)?, Center::Bond, 0.01, 40)?;
    let (t, t_b, horizon) = (breather.slow_period(), breather.period(), breather.horizon());
    Ok(vec![
        ("s5-T", t),
        ("s5-mass-ratio", breather.mass_condition()),
        ("s5-horizon", horizon),
        ("s5-Tb", t_b),
        ("s5-multiples", (horizon / t_b).floor() * t_b / horizon),
        ("s5-caption", 30.0 * t_b / (10.0 * t)),
    ])
}

/// The run of the figure.
fn long_run(_: &Runs) -> Result<Vec<Quantity>> {
    let options = BreatherOptions { method: Method::Collocation, tolerance: 1e-10 };
    let scene = Scene::load("bright-breather")?;
    let study = bright_breather(&scene, &options, 20, &mut |_| {})?;
    let (horizon, end) = (study.breather.horizon(), scene.end());
    let inset = study.largest(0.0, horizon);
    let later = study.largest(horizon, end);
    let layout = scene.chain().layout();
    let largest_v = |k: usize| layout.v(&study.profiles[k].state).map_or(f64::NAN, |v| max_norm(v.iter().copied()));
    let share = |k: usize| study.samples[k].share;
    Ok(vec![
        ("s5-Eu", inset.u),
        ("s5-Eu-dot", inset.u_dot),
        ("s5-Ev", inset.v),
        ("s5-Ev-dot", inset.v_dot),
        ("s5-breakdown", later.u / inset.u),
        ("s5-outlives", study.tenth_left.unwrap_or(f64::NAN) / horizon),
        ("s5-radiated", share(study.samples.len() - 1) / share(0)),
        ("s5-v-grows", largest_v(study.profiles.len() - 1) / largest_v(1)),
        ("s5-run-kink", study.kink.jump_v / largest_v(study.profiles.len() - 1)),
    ])
}
