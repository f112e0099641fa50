//! The equations of perturbations, and what is proved of their multipliers.

use hertzchain_proofs::{
    certificate::{Certificate, Multiplier},
    check::{NARROWEST, Refused, moments},
    exact::Exact,
    internals::{Equations, Perturbed, System, multipliers},
    interval::{Interval, norm},
};

/// A breather of one harmonic on a ring.
fn certificate(sites: usize, center: &str) -> Certificate {
    let rows: String = (0..=sites / 2)
        .map(|n| format!("a 0000000000000000 {}\n", if n % 2 == 0 { "bfc8000000000000" } else { "3fc8000000000000" }))
        .collect();
    let text = format!(
        "hertzchain certificate 2\nkind breather\nalpha 3/2\nkappa 2\nrho 1/3\nomega 41/20\nmean 0\nblock 1\n\
         enclosed 64\nsites {sites}\ncenter {center}\n{rows}"
    );
    text.parse().unwrap()
}

/// Its equations, with its moments.
fn system(certificate: &Certificate) -> System {
    let of_site = |a: &Vec<Interval>| moments(a, certificate.model.alpha, 64, NARROWEST, &|| false).unwrap();
    let mut system = System::new(certificate).unwrap();
    system.known = system.a.iter().map(of_site).collect();
    system
}

// Truth: L = s^2 (kappa (1 + rho) + rho s^2)/(kappa + rho s^2) with the matrix S of the
// derivative of e^{lambda t} (c cos + s sin) in place of s.
#[test]
fn blocks_of_cosine_and_sine_are_inverses_of_l() {
    let certificate = certificate(5, "bond");
    let system = system(&certificate).perturbed();
    let it = Equations::new(&certificate, &system, [2, 64], &Multiplier::Growing([Exact::ONE; 2]));
    let (lambda, kappa, rho) = (0.3, 2.0, 1.0 / 3.0);
    let l = it.factors([Interval::exact(lambda), Interval::ZERO]);
    type Square = [[f64; 2]; 2];
    let product = |a: Square, b: Square| [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]));
    let linear = |x: f64, y: f64, a: Square| [0, 1].map(|i| [0, 1].map(|j| y * a[i][j] + if i == j { x } else { 0.0 }));
    for k in 1..4 {
        let omega = 2.05 * k as f64;
        let square = product([[lambda, omega], [-omega, lambda]], [[lambda, omega], [-omega, lambda]]);
        let own = |sine: bool| {
            let forces = it.forces(&l, (0, k, sine));
            [false, true]
                .map(|part| forces.iter().filter(|(place, _)| *place == (0, k, part)).map(|it| it.1.mid()).sum())
        };
        // Two from the second difference, and one from the image of this site.
        let block = [own(false), own(true)];
        let found = product(block, product(square, linear(kappa * (1.0 + rho), rho, square)));
        let truth = linear(kappa, rho, square).map(|row| row.map(|x| 3.0 * x));
        let apart =
            found.as_flattened().iter().zip(truth.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-12 * omega * omega, "{found:?} {truth:?}");
    }
}

/// The certificate with a multiplier, as if all its contacts had the stiffness
/// `sum_l d_l cos l omega t`, with `K'` harmonics.
fn stiff(
    certificate: &Certificate,
    multiplier: Multiplier,
    d: &[(usize, f64)],
    enclosed: usize,
) -> (Certificate, System) {
    let mut known = system(certificate).known;
    for one in &mut known {
        one.stiffness = vec![Interval::ZERO; enclosed + 1];
        d.iter().for_each(|(l, d)| one.stiffness[*l] = Interval::exact(*d));
        let squares =
            |(l, d): &(usize, f64)| Interval::exact(*d).square() / Interval::exact(if *l == 0 { 1.0 } else { 2.0 });
        one.stiffness_square = d.iter().map(squares).sum();
        let most: f64 = d.iter().map(|(_, d)| d.abs()).sum();
        one.overlap = Interval::exact(most * most / 2.25);
    }
    let (block, multiplier) = (enclosed / 8, Some(multiplier));
    let certificate = Certificate { enclosed, block, multiplier, ..certificate.clone() };
    let mut system = System::new(&certificate).unwrap();
    system.known = known;
    (certificate, system)
}

/// What is proved of it.
fn found((certificate, system): &(Certificate, System)) -> Result<[f64; 2], Refused> {
    let changes = vec![Interval::ZERO; system.a.len()];
    multipliers(certificate, &certificate.multiplier.unwrap(), (system, &changes), &|| Ok(()))
}

/// Bounds of `g` for -1.
fn g(certificate: &Certificate, sine: bool, d: &[(usize, f64)], enclosed: usize) -> [f64; 2] {
    found(&stiff(certificate, Multiplier::Doubling { sine }, d, enclosed)).unwrap()
}

/// A wave of one harmonic.
fn wave() -> Certificate {
    let text = "hertzchain certificate 2\nkind wave\nalpha 3/2\nkappa 2\nrho 1/3\nomega 41/20\nmean 0\n\
                block 1\nenclosed 64\nq_over_pi 2/5\na 3fc8000000000000\n";
    text.parse().unwrap()
}

/// A multiplier of a wave with `p = pi/3`, and `lambda` within `radius` of this one.
fn bloch([growth, frequency]: [f64; 2], radius: f64) -> Multiplier {
    let [growth, frequency, radius] =
        [growth, frequency, radius].map(|x| Exact::of_double((x * 1e15).round() / 1e15).unwrap());
    Multiplier::Bloch { p_over_pi: Exact::new(1, 3).unwrap(), rate: [growth, frequency], radius }
}

/// A growth rate of no perturbation.
const RATE: [f64; 2] = [0.2, 0.7];

/// The wave with this rate, as if all its contacts had the stiffness `sum_l d_l cos l phi`.
fn driven(d: &[(usize, f64)], enclosed: usize) -> (Certificate, System) {
    let (certificate, system) = stiff(&wave(), bloch(RATE, 1e-9), d, enclosed);
    (certificate, system.perturbed())
}

fn equations((certificate, system): &(Certificate, System)) -> Equations<'_> {
    let sizes = [certificate.enclosed / 8, certificate.enclosed];
    Equations::new(certificate, system, sizes, &certificate.multiplier.unwrap())
}

fn rate() -> [Interval; 2] {
    RATE.map(Interval::exact)
}

/// Those of strains that differ by at most `change`.
fn terms(it: &(Certificate, System), change: f64) -> Perturbed<'_> {
    Perturbed::new(equations(it), rate(), &[Interval::exact(change); 2])
}

/// Bounds of `g` of a wave.
fn of_wave(terms: &Perturbed) -> Vec<Interval> {
    terms.g(rate(), &terms.derivative(&|| Ok(())).unwrap())
}

/// Adds a multiple of a row of `A` to one.
fn add(terms: &mut Perturbed, factor: f64, [from, to]: [usize; 2]) {
    for matrix in [&mut terms.block.inverse, &mut terms.block.product] {
        let row = matrix[from].clone();
        matrix[to].iter_mut().zip(row).for_each(|(a, b)| *a = *a + Interval::exact(factor) * b);
    }
}

// Truth: contacts that pull with the constant stiffness D have perturbations e^{i k phi} alone,
// whose s = lambda + i k omega solves L(s) = -4 sin^2((p - k q)/2) D and is real.
#[test]
fn a_wave_grows_as_one_harmonic_does() {
    let (d, kappa, rho) = (-0.3, 2.0, 1.0 / 3.0);
    let of = |k: f64| {
        let lattice = 4.0 * (0.5 * std::f64::consts::PI * (1.0 / 3.0 - 0.4 * k)).sin().powi(2);
        let half = 0.5 * (kappa * (1.0 + rho) + lattice * d * rho) / rho;
        let square = -half + f64::sqrt(half * half - lattice * d * kappa / rho);
        [square.sqrt(), -2.05 * k]
    };
    for k in [1.0, -1.0] {
        let [growth, frequency] = of(k);
        let proved = |apart: [f64; 2]| {
            let multiplier = bloch([growth + apart[0], frequency + apart[1]], 1e-9);
            found(&stiff(&wave(), multiplier, &[(0, d)], 64))
        };
        let [from, to] = proved([0.0; 2]).unwrap();
        let truth = (growth * 2.0 * std::f64::consts::PI / 2.05).exp();
        assert!(from < truth && truth < to && to - from < 1e-6, "{k}: {from} {truth} {to}");
        for apart in [[3e-9, 0.0], [-3e-9, 0.0], [0.0, 3e-9], [0.0, -3e-9]] {
            let refused = proved(apart);
            let Err(Refused::Multiplier { g: Some([[at, _], [change, _]]), .. }) = refused else {
                panic!("{refused:?}")
            };
            // Three radii away. At the corners of the square g is 256 sqrt 2 times its change
            // over the radius, so that Cauchy's bound takes away more than one percent of this
            // change.
            assert!(at > 3.03 * change, "{k} {apart:?}: {refused:?}");
        }
    }
}

// Truth: the sums of |l_k|^2 of eight times as many harmonics, of each sign.
#[test]
fn tails_of_a_wave_hold_both_signs() {
    for p in [1, -1] {
        let rate = [1, 3].map(|share| Exact::new(share, 5).unwrap());
        let p_over_pi = Exact::new(p, 3).unwrap();
        let multiplier = Multiplier::Bloch { p_over_pi, rate, radius: Exact::new(1, 1000).unwrap() };
        let [few, many] = [8, 64].map(|enclosed| {
            let (certificate, system) = stiff(&wave(), multiplier, &[(0, 0.3)], enclosed);
            let it = Equations::new(&certificate, &system, [1, enclosed], &multiplier);
            let l = it.factors(rate.map(Exact::enclosed));
            let of_sign = |sign: usize| 2_f64.sqrt() * norm(l[3..].iter().map(|l| norm(l[sign]))).mid();
            (it.beyond(&l, 2).lo(), of_sign(0).max(of_sign(1)))
        });
        // Each harmonic has the larger one of both.
        assert!(many.1 < few.0 && few.0 < 1.5 * many.1, "{p}: {few:?} {many:?}");
    }
}

// Truth: contacts of constant stiffness D have modes sin q (n - 1/2) with the frequency Omega,
// -L(i Omega) = 4 sin^2(q/2) D. The multiplier is -1 where Omega is half of omega.
#[test]
fn minus_one_is_where_a_linear_mode_has_twice_the_period() {
    let certificate = certificate(7, "bond");
    let (square, rho, kappa) = (f64::powi(0.5 * 2.05, 2), 1.0 / 3.0, 2.0);
    for turns in 1..=3 {
        let lattice = 4.0 * (std::f64::consts::PI / 7.0 * f64::from(turns)).sin().powi(2);
        let critical = square * (1.0 + kappa * rho / (kappa - rho * square)) / lattice;
        for sine in [false, true] {
            let near = |factor: f64| g(&certificate, sine, &[(0, factor * critical)], 64);
            let [below, at, above] = [1.0 - 1e-9, 1.0, 1.0 + 1e-9].map(near);
            assert!(at[0] < 0.0 && 0.0 < at[1], "{turns} {sine}: {at:?}");
            let [first, last] = [below, above].map(|g| if g[0] * g[1] > 0.0 { g[0].signum() } else { 0.0 });
            assert!(first * last < 0.0, "{turns} {sine}: {below:?} {above:?}");
        }
    }
}

// Truth: g with 64 harmonics. With 8, D couples the harmonics 0 to 2 of the approximate
// solution to those that it lacks: to some of the equations up to 5 that are computed, and only
// to others.
#[test]
fn bounds_of_g_hold_for_the_harmonics_that_are_left_out() {
    let certificate = certificate(7, "bond");
    for (d, sine) in [(3, false), (3, true), (8, false), (8, true)].map(|(l, sine)| ([(0, 0.3), (l, 0.1)], sine)) {
        let [few, many] = [8, 64].map(|enclosed| g(&certificate, sine, &d, enclosed));
        assert!(few[0] < many[0] && many[1] < few[1], "{d:?} {sine}: {few:?} {many:?}");
        assert!(many[1] - many[0] < 1e-6 * (few[1] - few[0]), "{d:?} {sine}: {few:?} {many:?}");
    }
    for l in [3, 8] {
        let [few, many] = [8, 64].map(|enclosed| of_wave(&terms(&driven(&[(0, 0.3), (l, 0.1)], enclosed), 0.0)));
        for (few, many) in few.iter().zip(&many) {
            assert!(few.lo() < many.lo() && many.hi() < few.hi(), "{l}: {few:?} {many:?}");
            assert!(many.hi() - many.lo() < 1e-6 * (few.hi() - few.lo()), "{l}: {few:?} {many:?}");
        }
    }
}

// Truth: if A is the inverse with twice its row of g added to a row, 1 - A M has -2 where this
// row meets the column of g. The row of g also has -2 in the first column: without it, eta is
// so large that the column of g counts at no site.
#[test]
fn z1_has_the_rows_and_columns_of_g() {
    let it = driven(&[(0, 0.3)], 64);
    let block = terms(&it, 0.0).block;
    let (all, pinned) = (block.all.len(), [0, 1].map(|n| block.index(equations(&it).pinned[n]).unwrap()));
    for g in [all, all + 1] {
        for row in [pinned[0], pinned[1], all, all + 1] {
            let mut terms = terms(&it, 0.0);
            add(&mut terms, 2.0, [g, row]);
            add(&mut terms, 2.0, [0, g]);
            let derivative = terms.derivative(&|| Ok(())).unwrap();
            let rows = derivative.within(&terms.changed);
            let (weight, own) = (derivative.weights[2], rows[2]);
            let entry = if row < all { 2.0 * weight.mid() } else { 2.0 };
            assert!(derivative.norm(&rows).hi() > (1.0 - 1e-9) * entry, "{row} {g}: {rows:?} {entry}");
            assert!(row < all || (own / weight).hi() > 2.0 - 1e-9, "{row} {g}: {own:?}");
        }
    }
}

// Truth: g with the inverse as A. Half of its row of g leaves an eighth of g after three
// corrections.
#[test]
fn bounds_of_g_hold_it_where_the_row_of_g_is_not_the_inverse() {
    let it = driven(&[(0, 0.3)], 64);
    let truth = of_wave(&terms(&it, 0.0));
    for which in 0..2 {
        let mut terms = terms(&it, 0.0);
        let g = terms.block.all.len() + which;
        add(&mut terms, -0.5, [g, g]);
        let (bounds, truth) = (of_wave(&terms)[which], truth[which]);
        assert!(bounds.lo() < truth.lo() && truth.hi() < bounds.hi(), "{which}: {bounds:?} {truth:?}");
    }
}

// Truth: g and 1 - A M of the stiffness d +- mu/sqrt 2, whose change has the size mu.
#[test]
fn bounds_of_g_and_z1_hold_for_the_changes_of_a_wave() {
    let it = driven(&[(0, 0.3)], 64);
    for sign in [1.0, -1.0] {
        let wider = terms(&it, 1e-3);
        let moved = driven(&[(0, 0.3 + sign * wider.changed[0].lo() / 2_f64.sqrt())], 64);
        for (bounds, truth) in of_wave(&wider).iter().zip(of_wave(&terms(&moved, 0.0))) {
            assert!(bounds.lo() < truth.lo() && truth.hi() < bounds.hi(), "{sign}: {bounds:?} {truth:?}");
        }
        let z1 = |terms: &Perturbed| {
            let derivative = terms.derivative(&|| Ok(())).unwrap();
            let rows = derivative.within(&terms.changed);
            [rows[2], derivative.norm(&rows)]
        };
        let bounds = z1(&wider);
        let truth = z1(&Perturbed { it: equations(&moved), changed: vec![Interval::ZERO; 2], ..wider });
        assert!((0..2).all(|i| truth[i].hi() < bounds[i].hi()), "{sign}: {bounds:?} {truth:?}");
    }
}
