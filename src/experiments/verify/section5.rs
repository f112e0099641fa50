//! Section 5: bright breathers, the trivial ones that are exact and the small ones that live long.
//!
//! | symbol | meaning |
//! |---|---|
//! | `l_n` | right side of (constraint2), the least `b_n - b_{n-1}` |
//! | `Fbar_n` | mean contact force over a period |
//! | core | fewest sites, symmetric about the centre, that hold a share of 0.999 of `sum a_n^2` |

use super::{
    Group, Item, Rule, Runs,
    item::{claim, formula, number},
};
use crate::{
    breathers::{BrightBreather, DarkBreather, TrivialBreather},
    chain::{Boundary, Chain, Params, State, max_norm},
    dps::{Center, Homoclinic, per_gamma},
    error::Result,
    experiments::{self, BreatherOptions, Initial, Norm, TheoremOptions, bright_breather, trivial_breather},
    orbits::Shooting,
    run::method::Method,
    run::state_at,
    scene::Scene,
};
use hertzchain_integrators::collocation::Pace;
use num_complex::Complex64;
use std::f64::consts::PI;

pub(super) const GROUPS: &[Group] = &[
    Group { section: 5, runs: &[], items: trivial },
    Group { section: 5, runs: &[], items: no_others },
    Group { section: 5, runs: &[], items: homoclinics },
    Group { section: 5, runs: &[], items: theorem },
    Group { section: 5, runs: &[], items: frequencies },
    Group { section: 5, runs: &[], items: numbers },
    Group { section: 5, runs: &[], items: long_run },
];

const CENTERS: [Center; 2] = [Center::Site, Center::Bond];
const ALPHA: f64 = 1.5;
const RHO: f64 = 1.0 / 3.0;
const SITES: usize = 12;
const TOLERANCE: f64 = 1e-12;
/// "Remain small": what the norms are in units that the theorem bounds.
const SMALL: Rule = Rule::AtMost(2.0);

/// A localised breather without a symmetry: `a_n` under a bell, `phi_n = angle n^2`, or in antiphase; `d_n` with steps of `step`.
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

/// The free chain at `t = 0` with all mean positions `scale` times those of the breather.
fn chain_of(breather: &TrivialBreather, scale: f64) -> Result<(Chain<f64>, State<f64>)> {
    let chain = Chain::new(breather.params(), Boundary::Free, SITES)?;
    let state = State::from_fn(&chain, |n| {
        let (site, moved) = (breather.site(n, 0.0), (scale - 1.0) * breather.means()[n]);
        crate::chain::Site { u: site.u + moved, v: site.v + moved, ..site }
    })?;
    Ok((chain, state))
}

/// Mean contact forces over a period of a breather whose gaps are `scale` times the least ones, over the force at an overlap of the largest amplitude.
fn mean_force(scale: f64) -> Result<f64> {
    let breather = breather(irregular, 0.0)?;
    let (chain, state) = chain_of(&breather, scale)?;
    let period = 2.0 * PI / breather.params().omega();
    let forces = chain.mean_contact_forces(state.as_slice(), period, Pace::Tolerance(TOLERANCE))?;
    let swing = max_norm((0..SITES).map(|n| breather.swing(n)));
    Ok(forces.range().1 / swing.powf(ALPHA))
}

/// Largest difference of two sequences over the largest of the second.
fn apart(ours: &[f64], theirs: &[f64]) -> f64 {
    max_norm(ours.iter().zip(theirs).map(|(a, b)| a - b)) / max_norm(theirs.iter().copied())
}

/// (constraint) to the simplified `b_n`.
fn trivial(_: &Runs) -> Result<Vec<Item>> {
    let (loose, antiphase) = (breather(irregular, 0.01)?, breather(|n| PI * n, 0.01)?);
    let omega = loose.params().omega();
    // (uncpl) as printed against the chain, not in step with the oscillation.
    let (chain, state) = chain_of(&loose, 1.0)?;
    let end = 10.3 * 2.0 * PI / omega;
    let mut run = chain.collocation(state.as_slice(), (0.0, end), Pace::Tolerance(TOLERANCE))?;
    let y = state_at(&mut run, end)?;
    let swing = |n: usize| loose.amplitudes()[n] * (omega * end + loose.phases()[n]).cos() / (1.0 + RHO);
    let printed = |n: usize| [loose.means()[n] + RHO * swing(n), loose.means()[n] - swing(n)];
    let off = (0..SITES).flat_map(|n| [y[n] - printed(n)[0], y[SITES + n] - printed(n)[1]]);
    // The closest that beads come, of samples of a period, and (constraint2).
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
        claim(
            "s5-uncpl",
            "uncpl",
            "distance of the chain after 10.3 periods over the largest amplitude",
            "solutions of (eq:linear), omega^2 = kappa (1 + 1/rho)",
            Rule::AtMost(1e-10),
            max_norm(off) / scale,
        ),
        claim(
            "s5-constraint2",
            "constraint, constraint2",
            "least gap in a period less (b_n - b_{n-1} - l_n), largest, over the amplitude",
            "if and only if",
            Rule::AtMost(1e-5),
            max_norm((1..SITES).map(|n| closest(n) - slack(n))) / scale,
        )
        .note("Of 4000 samples a period, which see extremes to 1e-6."),
        claim(
            "s5-constraint2-if",
            "constraint2",
            "largest Fbar_n with equality in (constraint2), over the force of an overlap as large as the amplitude",
            "a solution of (eq:Hertz) if",
            Rule::AtMost(1e-20),
            mean_force(1.0)?,
        )
        .note("Roundings of the positions to the power 3/2."),
        claim(
            "s5-constraint2-only-if",
            "constraint2",
            "the same with gaps of 0.9 l_n",
            "only if",
            Rule::AtLeast(1e-3),
            mean_force(0.9)?,
        ),
        formula(
            "s5-means",
            "below constraint2",
            "largest relative error of the means of a breather against b_n as printed",
            "b_n = d_n + rho/(1+rho) sum_k [a_k^2 + a_{k-1}^2 - 2 a_k a_{k-1} cos(phi_k - phi_{k-1})]^{1/2}",
            Rule::AtMost(1e-14),
            apart(loose.means(), &sum(&loose, &|n| least_gap(&loose, n))),
        ),
        claim(
            "s5-kink",
            "below constraint2",
            "least b_n - b_{n-1}",
            "b_n corresponds to a kink",
            Rule::AtLeast(0.0),
            rises.fold(f64::INFINITY, f64::min),
        ),
        formula(
            "s5-antiphase",
            "below constraint2",
            "the same error with phi_n - phi_{n-1} = pi",
            "b_n = d_n + rho/(1+rho) (a_n + 2 sum_{k<n} a_k)",
            Rule::AtMost(1e-14),
            apart(antiphase.means(), &simplified),
        ),
    ])
}

/// Theorem nobreath: the steps of its proof, on the chain.
fn no_others(_: &Runs) -> Result<Vec<Item>> {
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
        claim(
            "s5-nobreath-constant",
            "nobreath",
            "largest less smallest Fbar_n of a periodic state, the dark breather at omega_b = 2.05, over the mean",
            "Fbar_{n+1} = Fbar_n",
            Rule::AtMost(1e-9),
            dark.spread() / dark.mean(),
        ),
        claim(
            "s5-nobreath-zero",
            "nobreath",
            "largest Fbar_n of the trivial breather of 40 sites",
            "Fbar = 0",
            Rule::AtMost(0.0),
            exact.forces.range().1,
        ),
        claim(
            "s5-nobreath-exact",
            "nobreath",
            "largest distance from (uncpl) in 100 periods, over the largest amplitude",
            "trivial breathers are time-periodic",
            Rule::AtMost(1e-9),
            max_norm(exact.deviation.iter().copied()),
        ),
        claim(
            "s5-nobreath-bright",
            "nobreath, erreurb",
            "largest less smallest Fbar_n of the long-lived breather over T_b, over the largest",
            "nontrivial ones are not time-periodic",
            Rule::AtLeast(0.9),
            forces.spread() / forces.range().1,
        ),
    ])
}

/// The worst of both kinds.
fn worst(of: impl Fn(&Homoclinic) -> f64) -> Result<f64> {
    let [one, two] = CENTERS.map(|center| Homoclinic::new(ALPHA, center));
    Ok(of(&one?).max(of(&two?)))
}

/// The least `n_0` from which on `|a_n| <= beta^{1 + alpha^{n - n_0}}`; infinite if that leaves fewer than four sites.
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
fn homoclinics(_: &Runs) -> Result<Vec<Item>> {
    let omega_0 = omega_0(ALPHA);
    // Of (eq:DpSlr), i dA/dtau = omega_0 delta^+ [..], with (solper), relative to the left side.
    let modulation = |a: &Homoclinic, epsilon: f64, tau: f64| {
        let rate = omega_0 * epsilon.abs().powf(ALPHA - 1.0);
        let envelope = |n: i64| Complex64::from_polar(epsilon * a.a(n), rate * tau);
        let force = |n: i64| power(envelope(n) - envelope(n - 1));
        let off = |n: i64| {
            let left = -rate * envelope(n);
            (left - omega_0 * (force(n + 1) - force(n))).norm() / left.norm()
        };
        // In the last ones forces are subnormal.
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
        claim(
            "s5-dpsstat",
            "dpsstat",
            "largest relative residual of (dpsstat), both i, alpha = 3/2, all sites above 1e-280",
            "has solutions",
            Rule::AtMost(2e-14),
            worst(|a| modulation(a, 1.0, 0.0))?,
        ),
        claim(
            "s5-solper",
            "solper",
            "the same of (eq:DpSlr) with (solper), epsilon = -0.3, tau = 0.7",
            "time-periodic solutions, epsilon any real number",
            Rule::AtMost(2e-14),
            worst(|a| modulation(a, -0.3, 0.7))?,
        ),
        claim(
            "s5-homoclinic-sign",
            "homoclinic",
            "least (-1)^n a_n, with its sign changed",
            "(-1)^n a_n > 0",
            Rule::AtMost(-f64::MIN_POSITIVE),
            worst(sign)?,
        )
        .note("On all sites whose a_n is a normal double."),
        claim(
            "s5-homoclinic-monotone",
            "homoclinic",
            "largest |a_{n-1}| / |a_n| for n <= 0",
            "|a_n| > |a_{n-1}|",
            Rule::AtMost(0.99),
            worst(monotone)?,
        ),
        claim(
            "s5-homoclinic-symmetry",
            "homoclinic",
            "largest |a_n^1 - a_{-n}^1| and |a_n^2 + a_{1-n}^2|",
            "symmetries",
            Rule::AtMost(0.0),
            worst(symmetry)?,
        )
        .note("Half of the sites are stored: that they solve (dpsstat) on all of them is above."),
        claim(
            "s5-homoclinic-decay",
            "homoclinic",
            "largest n_0 that beta = 0.9, 0.5, 0.1, 1e-3, 1e-6 need, on all sites to 1e-308",
            "|a_n| <= beta^{1 + alpha^{n - n_0}}",
            Rule::AtMost(10.0),
            worst(|a| betas.map(|beta| onset(a, beta)).into_iter().fold(0.0, f64::max))?,
        ),
    ])
}

/// `omega_0` as printed in (eq:defom0), with the Gamma functions the right way up.
fn omega_0(alpha: f64) -> f64 {
    2f64.powf(alpha - 2.0) * per_gamma(0.5 * (alpha + 1.0) + 1.0) / (PI.sqrt() * per_gamma(0.5 * alpha + 1.0))
}

/// Theorem longlivedb in the largest norm.
fn theorem(_: &Runs) -> Result<Vec<Item>> {
    // Growth of sup / epsilon^power over a decade of epsilon, C_i = C_r = 1.
    let decade = |initial: Initial| -> Result<[f64; 3]> {
        let epsilons = vec![1e-4, 1e-5];
        let options = TheoremOptions { horizon: 2.0, initial, c_i: 1.0, epsilons, ..TheoremOptions::default() };
        let study = experiments::theorem(&options, None, &|_| {})?;
        let [coarse, fine] = [0, 1].map(|k| study.scaled(&study.runs[k], Norm::One).0);
        Ok([0, 1, 2].map(|k| fine[k] / coarse[k]))
    };
    let (site, bond) = (decade(Initial::Site)?, decade(Initial::Bond)?);
    let bounded = Rule::AtMost(1.1);
    let line = |id, label, quantity, paper, k: usize| claim(id, label, quantity, paper, bounded, site[k].max(bond[k]));
    Ok(vec![
        line(
            "s5-theorem-u",
            "erreurb",
            "growth of sup |u - breather|_1 / epsilon^alpha, epsilon 1e-4 to 1e-5, both i",
            "O(epsilon^alpha)",
            0,
        )
        .note("With C_i = C_r = 1, T = 2, and a departure from the breather on the boundary of (condic)."),
        line("s5-theorem-v", "estimv2", "growth of sup |v|_1 / epsilon^alpha", "O(epsilon^alpha)", 1),
        line("s5-theorem-vdot", "estimv2", "growth of sup |v'|_1 / epsilon^{2 alpha-1}", "O(epsilon^{2 alpha-1})", 2),
    ])
}

/// The two frequencies.
fn frequencies(_: &Runs) -> Result<Vec<Item>> {
    let shift = |epsilon: f64| -> Result<[f64; 2]> {
        let rho = epsilon.powf(-2.0 * (ALPHA - 1.0));
        let params = Params::new(ALPHA, 1.0, rho)?;
        let bright = BrightBreather::new(params, Center::Bond, epsilon, 40)?;
        let unit = epsilon.powf(ALPHA - 1.0);
        Ok([(bright.omega_b() - 1.0) / unit, (bright.omega_b() - params.omega()) / unit])
    };
    let shifts = [1e-1, 1e-2, 1e-4, 1e-6].map(shift).into_iter().collect::<Result<Vec<_>>>()?;
    Ok(vec![
        formula(
            "s5-Omega-b",
            "longlivedb",
            "(Omega_b - 1) / (omega_0 epsilon^{alpha-1}) at epsilon = 1e-2, omega_0 by (eq:defom0)",
            "Omega_b = 1 + omega_0 epsilon^{alpha-1}",
            Rule::Equal { to: 1.0, within: 1e-12 },
            shifts[1][0] / omega_0(ALPHA),
        ),
        claim(
            "s5-omega-rho",
            "below estimv2",
            "rho (omega - 1) at rho = 1e6",
            "0 < omega - 1 = O(1/rho)",
            Rule::Equal { to: 0.5, within: 1e-6 },
            1e6 * (Params::new(ALPHA, 1.0, 1e6)?.omega() - 1.0),
        )
        .note("Of any amplitude: see s5-uncpl."),
        claim(
            "s5-frequencies",
            "below estimv2",
            "least (Omega_b - omega) / epsilon^{alpha-1} for epsilon = 1e-1 .. 1e-6, C_r = 1",
            "Omega_b > omega for epsilon small",
            Rule::AtLeast(0.05),
            shifts.iter().map(|shift| shift[1]).fold(f64::INFINITY, f64::min),
        ),
    ])
}

/// The numbers of the run.
fn numbers(_: &Runs) -> Result<Vec<Item>> {
    let breather = BrightBreather::new(Params::new(ALPHA, 1.0, 1000.0)?, Center::Bond, 0.01, 40)?;
    let (t, t_b, horizon) = (breather.slow_period(), breather.period(), breather.horizon());
    Ok(vec![
        number("s5-T", "below estimv2", "T = 2 pi/omega_0", "19.4158", t),
        claim(
            "s5-mass-ratio",
            "below estimv2",
            "1 / (rho epsilon^{2(alpha-1)}), rho = 1000, epsilon = 0.01",
            "at most C_r = 1",
            Rule::AtMost(1.0),
            breather.mass_condition(),
        ),
        number("s5-horizon", "below time-periodic_osc", "T epsilon^{1-alpha}", "194.158", horizon),
        number("s5-Tb", "below time-periodic_osc", "T_b = 2 pi/Omega_b", "6.0862", t_b),
        claim(
            "s5-multiples",
            "below time-periodic_osc",
            "last multiple of T_b up to T epsilon^{1-alpha} over it",
            "compared at multiples of T_b in the interval",
            Rule::AtMost(1.0),
            (horizon / t_b).floor() * t_b / horizon,
        )
        .note("31 T_b: T epsilon^{1-alpha} itself, 31.9 T_b, is not a multiple."),
        claim(
            "s5-caption",
            "fig:long_lived_bb",
            "30 T_b over 10 T",
            "30 T_b < 10 T",
            Rule::AtMost(1.0),
            30.0 * t_b / (10.0 * t),
        ),
    ])
}

/// The run of the figure.
fn long_run(_: &Runs) -> Result<Vec<Item>> {
    let options = BreatherOptions { method: Method::Collocation, tolerance: 1e-10 };
    let scene = Scene::load("bright-breather")?;
    let study = bright_breather(&scene, &options, 20, &mut |_| {})?;
    let (horizon, end) = (study.breather.horizon(), scene.end());
    let inset = study.largest(0.0, horizon);
    let later = study.largest(horizon, end);
    let layout = scene.chain().layout();
    let largest_v = |k: usize| layout.v(&study.profiles[k].state).map_or(f64::NAN, |v| max_norm(v.iter().copied()));
    let share = |k: usize| study.samples[k].share;
    let line = |id, quantity, value| claim(id, "diff_u_l1norm, diff_v_l1norm", quantity, "remain small", SMALL, value);
    Ok(vec![
        line("s5-Eu", "largest E_u up to T epsilon^{1-alpha}", inset.u),
        line("s5-Eu-dot", "largest E_u' up to there", inset.u_dot),
        line("s5-Ev", "largest E_v up to there", inset.v),
        line("s5-Ev-dot", "largest E_v' up to there", inset.v_dot),
        claim(
            "s5-breakdown",
            "fig:long_lived_bb",
            "largest E_u between T epsilon^{1-alpha} and 80 T over that before",
            "breakdown of the localized structure",
            Rule::AtLeast(2.0),
            later.u / inset.u,
        ),
        claim(
            "s5-outlives",
            "fig:long_lived_bb",
            "time at which a tenth of the core's energy has left, over T epsilon^{1-alpha}",
            "part of the energy is radiated away at larger time",
            Rule::AtLeast(1.0),
            study.tenth_left.unwrap_or(f64::NAN) / horizon,
        ),
        claim(
            "s5-radiated",
            "fig:long_lived_bb",
            "share of the energy that the core has at 80 T over that at 0",
            "part of the energy is radiated away",
            Rule::AtMost(0.9),
            share(study.samples.len() - 1) / share(0),
        ),
        claim(
            "s5-v-grows",
            "fig:long_lived_bb",
            "largest |v_n| at 80 T over that at 30 T_b",
            "growing magnitude of v_n",
            Rule::AtLeast(1.5),
            largest_v(study.profiles.len() - 1) / largest_v(1),
        ),
        claim(
            "s5-run-kink",
            "fig:long_lived_bb",
            "rise of v across the middle at 80 T over its largest |v_n|",
            "approaches a kink-type structure",
            Rule::AtLeast(1.0),
            study.kink.jump_v / largest_v(study.profiles.len() - 1),
        )
        .note("v is below zero on the left of the middle and above on the right: a step, and zero at the ends, where nothing has arrived yet."),
    ])
}
