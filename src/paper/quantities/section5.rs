//! Section 5: bright breathers, both the exact trivial ones and the small long-lived ones.
//!
//! | symbol | meaning |
//! |---|---|
//! | `l_n` | right side of (constraint2), the least `b_n - b_{n-1}` |
//! | `Fbar_n` | mean contact force over a period |
//! | core | fewest sites, symmetric about the centre, that hold a share of 0.999 of `sum a_n^2` |

use super::{
    Group, Quantity, Runs,
    measure::{off_beat, sampled, started},
    section3::decade,
};
use crate::{
    breathers::{BrightBreather, DarkBreather, TrivialBreather},
    chain::{Boundary, Chain, Params, Site, State, max_norm},
    dps::{Center, Homoclinic, per_gamma},
    error::Result,
    orbits::Shooting,
    random::uniform,
    run::{Method, state_at},
    scene::Scene,
    study::{Adaptive, Initial, Norm, RhoLaw, bright_breather, fit_line},
};
use hertzchain_integrators::collocation::StepControl;
use nalgebra::{DMatrix, DVector};
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
/// Increase of the `d_n` at every third site.
const STEP: f64 = 0.01;

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

/// A site at `t = 0`, moved by some length.
fn moved(breather: &TrivialBreather, n: usize, by: f64) -> Site<f64> {
    let site = breather.site(n, 0.0);
    Site { u: site.u + by, v: site.v + by, ..site }
}

/// The free chain at `t = 0`, with the mean positions of the breather times `scale`.
fn chain_of(breather: &TrivialBreather, scale: f64) -> Result<(Chain<f64>, State<f64>)> {
    let chain = Chain::new(breather.params(), Boundary::Free, SITES)?;
    let state = State::from_fn(&chain, |n| moved(breather, n, (scale - 1.0) * breather.means()[n]))?;
    Ok((chain, state))
}

/// The largest mean contact force over a period, for mean positions times `scale`, divided by the
/// force at an overlap `l_n` of the same bond.
///
/// Beads that swing freely about the same mean position have 0.278, the mean of
/// `(cos t)_+^{3/2}`, in each bond.
fn mean_force(scale: f64) -> Result<f64> {
    let breather = breather(irregular, 0.0)?;
    let (chain, state) = chain_of(&breather, scale)?;
    let period = 2.0 * PI / breather.params().omega();
    let forces = chain.mean_contact_forces(state.as_slice(), period, StepControl::Tolerance(TOLERANCE))?;
    let least = max_norm((1..SITES).map(|n| least_gap(&breather, n)));
    Ok(forces.range().1 / least.powf(ALPHA))
}

/// The mean positions at which neighbours just touch, measured on the chain.
///
/// The breather's beads swing far from each other for a period; the least gaps of neighbours are
/// added, with a resting bead before the first, and the `d_n`.
fn touching(breather: &TrivialBreather, step: f64) -> Result<Vec<f64>> {
    const FAR: f64 = 1.0;
    const SAMPLES: u32 = 4000;
    let site = |n| moved(breather, n, FAR * n as f64 - breather.means()[n]);
    let period = 2.0 * PI / breather.params().omega();
    let run = started(breather.params(), (Boundary::Free, SITES), &site, (period, TOLERANCE))?;
    let mut least = [0.0f64; SITES];
    sampled(run, (period, SAMPLES), |_, y| {
        let swing = |n: usize| y[n] - FAR * n as f64;
        for (n, least) in least.iter_mut().enumerate() {
            *least = least.max(if n == 0 { 0.0 } else { swing(n - 1) } - swing(n));
        }
        Ok(())
    })?;
    Ok((0..SITES).map(|n| step * (n / 3) as f64 + least[..=n].iter().sum::<f64>()).collect())
}

/// Largest difference of two sequences divided by the largest entry of the second.
fn apart(ours: &[f64], theirs: &[f64]) -> f64 {
    max_norm(ours.iter().zip(theirs).map(|(a, b)| a - b)) / max_norm(theirs.iter().copied())
}

/// The formulas from (constraint) to the simplified `b_n`.
fn trivial(_: &Runs) -> Result<Vec<Quantity>> {
    let (loose, antiphase) = (breather(irregular, STEP)?, breather(|n| PI * n, STEP)?);
    let omega = loose.params().omega();
    // (uncpl) as printed compared with the chain, at a time that is no multiple of the period.
    let end = 10.3 * 2.0 * PI / omega;
    let mut run = started(loose.params(), (Boundary::Free, SITES), &|n| moved(&loose, n, 0.0), (end, TOLERANCE))?;
    let y = state_at(&mut run, end)?;
    let swing = |n: usize| loose.amplitudes()[n] * (omega * end + loose.phases()[n]).cos() / (1.0 + RHO);
    let uncpl = |n: usize| [loose.means()[n] + RHO * swing(n), loose.means()[n] - swing(n)];
    let off = (0..SITES).flat_map(|n| [y[n] - uncpl(n)[0], y[SITES + n] - uncpl(n)[1]]);
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
    let offset = |n: usize| STEP * (n / 3) as f64;
    let printed: Vec<f64> =
        (0..SITES).map(|n| offset(n) + (0..=n).map(|k| least_gap(&loose, k)).sum::<f64>()).collect();
    let alternating = |n: usize| {
        let a = antiphase.amplitudes();
        offset(n) + RHO / (1.0 + RHO) * (a[n] + 2.0 * a[..n].iter().sum::<f64>())
    };
    let simplified: Vec<f64> = (0..SITES).map(alternating).collect();
    Ok(vec![
        ("s5-uncpl", max_norm(off) / scale),
        ("s5-constraint2", max_norm((1..SITES).map(|n| closest(n) - slack(n))) / scale),
        ("s5-constraint2-if", mean_force(1.0)?),
        ("s5-constraint2-only-if", mean_force(0.9)?),
        ("s5-means", apart(&touching(&loose, STEP)?, &printed)),
        ("s5-kink", mean_force(0.0)?),
        ("s5-antiphase", apart(&touching(&antiphase, STEP)?, &simplified)),
    ])
}

/// Theorem nobreath: the steps of its proof, on the chain.
fn no_others(_: &Runs) -> Result<Vec<Quantity>> {
    let shooting = Shooting::default();
    let params = Params::new(ALPHA, 1.0, RHO)?;
    let orbit = DarkBreather { params, center: Center::Site, sites: 41, omega_b: 2.05, c_x: 0.0 }.orbit(&shooting)?;
    let control = StepControl::Tolerance(shooting.tol);
    let dark = orbit.setting.chain()?.mean_contact_forces(&orbit.start(), orbit.setting.period(), control)?;
    let forces = |scene: &Scene| {
        let (start, control) = (scene.initial().as_slice(), StepControl::Tolerance(TOLERANCE));
        scene.chain().mean_contact_forces(start, scene.period(), control)
    };
    let [exact, bright] = ["trivial-breather", "bright-breather"].map(Scene::load);
    let (exact, bright) = (exact?, forces(&bright?)?);
    Ok(vec![
        ("s5-nobreath-constant", dark.spread() / dark.mean()),
        ("s5-nobreath-zero", forces(&exact)?.range().1),
        ("s5-nobreath-exact", off_the_closed_form(&exact)?),
        ("s5-nobreath-bright", bright.spread() / bright.range().1),
    ])
}

/// The largest distance of a run of an exact scene from its closed form at the sample times, over
/// the amplitude.
fn off_the_closed_form(scene: &Scene) -> Result<f64> {
    let Some(breather) = scene.exact() else { return Ok(f64::NAN) };
    let (samples, layout) = (scene.samples(), scene.chain().layout());
    let t: Vec<f64> = (0..=samples).map(|k| scene.end() * (k as f64 / samples as f64)).collect();
    let mut most = 0.0_f64;
    for (&t, state) in t.iter().zip(scene.run().method(Method::Collocation).tolerance(TOLERANCE)?.at(&t)?) {
        let state = state?;
        let v = layout.v(state.as_slice()).unwrap_or_default();
        let off = (0..layout.sites()).map(|n| (breather.site(n, t), n));
        most = off.fold(most, |most, (site, n)| most.max((state.u()[n] - site.u).abs()).max((v[n] - site.v).abs()));
    }
    Ok(most / max_norm((0..layout.sites()).map(|n| breather.swing(n))))
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

/// Largest difference of the mirror images of a solution of (dpsstat), over its largest entry.
///
/// Newton's method on all sites, without symmetry, starts from the homoclinic with each entry
/// changed by up to 1 % at random.
fn symmetry(a: &Homoclinic) -> f64 {
    // |a_n| is below 1e-13 beyond these sites.
    const LAST: i64 = 8;
    const STEPS: u32 = 30;
    let mut random = uniform(1);
    let (count, first) = (2 * LAST as usize + 1, -LAST);
    let mut z = DVector::from_fn(count, |i, _| a.a(first + i as i64) * (1.0 + 0.01 * random()));
    let strain = |z: &DVector<f64>, i: usize| {
        let at = |i: usize| z.get(i).copied().unwrap_or(0.0);
        at(i) - if i == 0 { 0.0 } else { at(i - 1) }
    };
    for _ in 0..STEPS {
        let force = |i: usize| strain(&z, i).abs().powf(ALPHA) * strain(&z, i).signum();
        let stiffness = |i: usize| ALPHA * strain(&z, i).abs().powf(ALPHA - 1.0);
        let residual = DVector::from_fn(count, |i, _| z[i] + force(i + 1) - force(i));
        let jacobian = DMatrix::from_fn(count, count, |i, j| match j as i64 - i as i64 {
            0 => 1.0 - stiffness(i) - stiffness(i + 1),
            1 => stiffness(j),
            -1 => stiffness(i),
            _ => 0.0,
        });
        let Some(step) = jacobian.lu().solve(&residual) else { return f64::NAN };
        z -= step;
    }
    let at = |n: i64| usize::try_from(n - first).ok().and_then(|i| z.get(i)).copied().unwrap_or(0.0);
    let image = |n: i64| if a.center() == Center::Site { at(-n) } else { -at(1 - n) };
    max_norm((-LAST..=LAST).map(|n| at(n) - image(n))) / z.amax()
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
    // For C_r = 1 and a start on the breather itself: a departure with C_i = 1 would exceed what
    // the dynamics adds.
    let of = |initial| decade(RhoLaw::Heavy, initial, Norm::One);
    let (site, bond) = (of(Initial::Site)?, of(Initial::Bond)?);
    Ok(vec![
        ("s5-theorem-u", site[0].max(bond[0])),
        ("s5-theorem-v", site[1].max(bond[1])),
        ("s5-theorem-vdot", site[2].max(bond[2])),
    ])
}

/// The frequency of the breather, and the linear frequency at finite `rho`.
fn frequencies(_: &Runs) -> Result<Vec<Quantity>> {
    let shift = |epsilon: f64| -> Result<f64> {
        let rho = epsilon.powf(-2.0 * (ALPHA - 1.0));
        let params = Params::new(ALPHA, 1.0, rho)?;
        let bright = BrightBreather::new(params, Center::Bond, epsilon, 40)?;
        let unit = epsilon.powf(ALPHA - 1.0);
        Ok((bright.omega_b() - params.omega()) / unit)
    };
    let shifts = [1e-1, 1e-2, 1e-4, 1e-6].map(shift).into_iter().collect::<Result<Vec<_>>>()?;
    Ok(vec![
        ("s5-Omega-b", measured_shift(1e-6)? / omega_0(ALPHA)),
        ("s5-omega-rho", 1e6 * (Params::new(ALPHA, 1.0, 1e6)?.omega() - 1.0)),
        ("s5-frequencies", shifts.into_iter().fold(f64::INFINITY, f64::min)),
    ])
}

/// `(Omega_b - 1) / epsilon^{alpha-1}` of the breather about a bond, measured on the chain with
/// `rho = epsilon^{-2(alpha-1)}` up to the slow time 4: the slope of the phase of
/// `sum a_n (u_n - i u_n')`.
fn measured_shift(epsilon: f64) -> Result<f64> {
    const SITES: usize = 16;
    let (unit, params) = (epsilon.powf(ALPHA - 1.0), Params::new(ALPHA, 1.0, epsilon.powf(-2.0 * (ALPHA - 1.0)))?);
    let bright = BrightBreather::new(params, Center::Bond, epsilon, SITES)?;
    let (end, mut points) = (4.0 / unit, Vec::new());
    let run = started(params, (Boundary::Free, SITES), &|n| bright.site(n, 0.0), (end, 1e-10))?;
    sampled(run, (end, off_beat(1.0, end, 1.0)), |t, y| {
        let turned = (0..SITES).map(|n| bright.a(n) * Complex64::new(y[n], -y[2 * SITES + n])).sum::<Complex64>();
        points.push((unit * t, (turned * Complex64::from_polar(1.0, -t)).arg()));
        Ok(())
    })?;
    Ok(fit_line(&points).map_or(f64::NAN, |line| line.0))
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
        ("s5-caption", 30.0 * t_b / (10.0 * t)),
    ])
}

/// The run of the figure.
fn long_run(_: &Runs) -> Result<Vec<Quantity>> {
    let options = Adaptive::default();
    let scene = Scene::load("bright-breather")?;
    let study = bright_breather(&scene, &options, 20, &|_, _| {})?;
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
