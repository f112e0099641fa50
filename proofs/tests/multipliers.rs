//! The equations of perturbations, and what is proved of their multipliers.

use hertzchain_proofs::{
    certificate::{Bloch, Certificate, Multiplier},
    check::{NARROWEST, Refused, moments},
    exact::Exact,
    internals::{
        Derivative, Equations, Perturbations, Perturbed, System, bloch, g as of_terms, modulated, multipliers, rate,
        rated,
    },
    interval::{Interval, norm},
};
use std::rc::Rc;

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
    let of_site = |a: &Vec<Interval>| moments(a, certificate.model.alpha, 64, NARROWEST).unwrap();
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
    let it = Perturbations::new(&certificate, &system, None, None);
    let (lambda, kappa, rho) = (0.3, 2.0, 1.0 / 3.0);
    let l = rated(&certificate, &it, Interval::exact(lambda));
    type Square = [[f64; 2]; 2];
    let product = |a: Square, b: Square| [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]));
    let linear = |x: f64, y: f64, a: Square| [0, 1].map(|i| [0, 1].map(|j| y * a[i][j] + if i == j { x } else { 0.0 }));
    for k in [1, 2, 3] {
        let omega = 2.05 * k as f64;
        let square = product([[lambda, omega], [-omega, lambda]], [[lambda, omega], [-omega, lambda]]);
        // Cosines are functions 0 to 2, sines 3 to 5.
        let of = |n, m| it.coupled((n, k)).iter().filter(|it| it.0 == m).map(|(_, i, e)| e * l[*i][k].mid()).sum();
        // Two from the second difference, and one from the image of this site.
        let block = [0, 3].map(|n| [0, 3].map(|m| of(n, m)));
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
    multiplier: Option<Multiplier>,
    d: &[(usize, f64)],
    enclosed: usize,
) -> (Certificate, System) {
    let mut known = system(certificate).known;
    for one in &mut known {
        one.stiffness = vec![Interval::ZERO; enclosed + 1];
        d.iter().for_each(|(l, d)| one.stiffness[*l] = Interval::exact(*d));
        let squares =
            |(l, d): &(usize, f64)| Interval::exact(*d).square() / Interval::exact(if *l == 0 { 1.0 } else { 2.0 });
        one.squares[1] = d.iter().map(squares).sum();
        let most: f64 = d.iter().map(|(_, d)| d.abs()).sum();
        one.pieces = vec![(Interval::ONE, Interval::exact(most * most / 2.25))];
    }
    let block = enclosed / 8;
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
    found(&stiff(certificate, Some(Multiplier::Doubling { sine }), d, enclosed)).unwrap()
}

/// A wave of one harmonic.
fn wave() -> Certificate {
    let text = "hertzchain certificate 2\nkind wave\nalpha 3/2\nkappa 2\nrho 1/3\nomega 41/20\nmean 0\n\
                block 1\nenclosed 64\nq_over_pi 2/5\na 3fc8000000000000\n";
    text.parse().unwrap()
}

/// A number as an exact decimal.
fn exact(x: f64) -> Exact {
    Exact::of_double((x * 1e15).round() / 1e15).unwrap()
}

/// Perturbations of a wave with `p/pi` between these, `lambda` linear, and a radius.
fn piece(p_over_pi: [f64; 2], [rate, change]: [[f64; 2]; 2], radius: f64) -> Bloch {
    let [p_over_pi, rate, change] = [p_over_pi, rate, change].map(|it| it.map(exact));
    Bloch { p_over_pi, rate, change, radius: exact(radius) }
}

/// `lambda` of harmonic `k` of the wave with `kappa = 2`, `rho = 1/3`, `q = 2 pi/5` if its contacts
/// have the constant stiffness `D`: `s = lambda + i k omega` solves
/// `L(s) = -4 sin^2((p - k q)/2) D` and is real.
fn harmonic(d: f64, k: f64, p_over_pi: f64) -> [f64; 2] {
    let (kappa, rho) = (2.0, 1.0 / 3.0);
    let lattice = 4.0 * (0.5 * std::f64::consts::PI * (p_over_pi - 0.4 * k)).sin().powi(2);
    let half = 0.5 * (kappa * (1.0 + rho) + lattice * d * rho) / rho;
    let square = -half + f64::sqrt(half * half - lattice * d * kappa / rho);
    [square.sqrt(), -2.05 * k]
}

/// What is proved of a piece of the wave whose contacts have this stiffness.
fn grown(d: f64, piece: &Bloch) -> Result<[f64; 2], Refused> {
    let (certificate, system) = stiff(&wave(), None, &[(0, d)], 64);
    bloch(&certificate, piece, (&system.perturbed(), &[Interval::ZERO]), &|| Ok(()))
}

// Truth: contacts that pull with the constant stiffness D have perturbations e^{i k phi} alone.
// Along a piece lambda is as far from the linear one as it bends.
#[test]
fn a_wave_grows_as_one_harmonic_does() {
    for (k, half) in [(1.0, 0.0), (-1.0, 0.0), (1.0, 5e-4), (-1.0, 5e-4), (1.0, 1e-3)] {
        let at = |s: f64| harmonic(-0.3, k, 1.0 / 3.0 + s * half);
        let (middle, ends) = (at(0.0), [-1.0, 1.0].map(|s| at(s)[0]));
        let (change, bend) = (0.5 * (ends[1] - ends[0]), (0.5 * (ends[0] + ends[1]) - middle[0]).abs());
        let proved = |apart: [f64; 3], radius: f64| {
            let rate = [[middle[0] + apart[0], middle[1] + apart[1]], [change + apart[2], 0.0]];
            grown(-0.3, &piece([1.0 / 3.0 - half, 1.0 / 3.0 + half], rate, radius))
        };
        let radius = 200.0 * half * half + 1e-9;
        let [needed, _] = proved([0.0; 3], radius).unwrap_or_else(|why| panic!("{k} {half}: {why}"));
        assert!(needed > bend, "{k} {half}: {needed:e} {bend:e}");
        let far = 1.01 * radius;
        let still = if half > 0.0 { [0.0, 0.0, far + bend] } else { [far; 3] };
        for apart in [[far, 0.0, 0.0], [-far, 0.0, 0.0], [0.0, far, 0.0], [0.0, -far, 0.0], still] {
            let refused = proved(apart, radius);
            assert!(matches!(refused, Err(Refused::Bloch { .. })), "{k} {half} {apart:?}: {refused:?}");
        }
    }
}

// Truth: the factors at single wave numbers of a piece, and those of other lambda near them.
#[test]
fn factors_along_a_piece_hold_those_of_its_wave_numbers() {
    let (certificate, system) = stiff(&wave(), None, &[(0, 0.3)], 16);
    let at = |ends: [f64; 2], rate: [[f64; 2]; 2], radius: f64| {
        modulated(&certificate, &system, &piece(ends, rate, radius), rate.map(|it| it.map(Interval::exact)))
    };
    let (rate, change, half) = ([0.2, 0.6], [0.0, 0.0], 5e-3);
    let [start, slope, rest, steep, all] = at([0.4 - half, 0.4 + half], [rate, change], 1e-4);
    let mut filled: f64 = 0.0;
    for s in [-1.0, -0.5, 0.5, 1.0] {
        let [there, ..] = at([0.4 + s * half; 2], [rate, [0.0; 2]], 1e-4);
        let moved = at([0.4 + s * half; 2], [[rate[0] + 1e-4, rate[1] - 1e-4], [0.0; 2]], 1e-12);
        for (k, part) in (0..16).flat_map(|k| [0, 1, 2, 3].map(|part| (k, part))) {
            let of = |l: &[Vec<Interval>; 4]| l[part][k];
            let left = of(&there) - (of(&start) + Interval::exact(s) * of(&slope));
            let bounds = of(&rest);
            assert!(bounds.lo() <= left.hi() && left.lo() <= bounds.hi(), "{k} {part} {s}: {left:?} {bounds:?}");
            assert!(of(&all).holds(of(&moved[0]).mid()), "{k} {part} {s}: {:?} {:?}", of(&all), of(&moved[0]));
            assert!(of(&steep).holds(of(&moved[3]).mid()), "{k} {part} {s}: {:?} {:?}", of(&steep), of(&moved[3]));
            if s.abs() == 1.0 {
                filled = filled.max(left.mid().abs() / bounds.hi());
            }
        }
    }
    // Half of the rest would not hold them.
    assert!(filled > 0.6, "{filled}");
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
}

// Truth: lambda with 64 harmonics, and the sums of |l_k|^2 and |l'_k|^2 of eight times as many, of
// each sign.
#[test]
fn bounds_of_a_wave_hold_for_the_harmonics_that_are_left_out() {
    for l in [3, 8] {
        let [few, many] = [16, 64].map(|enclosed| {
            let (certificate, system) = stiff(&wave(), None, &[(0, -0.3), (l, 0.01)], enclosed);
            let (system, near) = (system.perturbed(), harmonic(-0.3, 1.0, 1.0 / 3.0));
            let about = |rate: [f64; 2], radius: f64| piece([1.0 / 3.0; 2], [rate, [0.0; 2]], radius);
            let [rate, _] = rate(&certificate, &system, &about(near, 1e-15)).unwrap();
            let proved = bloch(&certificate, &about(rate, 1e-3), (&system, &[Interval::ZERO]), &|| Ok(()));
            (rate, proved.unwrap_or_else(|why| panic!("{l} {enclosed}: {why}"))[0])
        });
        let apart = (few.0[0] - many.0[0]).hypot(few.0[1] - many.0[1]);
        assert!(apart <= few.1 && many.1 < 1e-3 * few.1, "{l}: {apart:e} {few:?} {many:?}");
    }
    for p in [1.0, -1.0].map(|sign| sign / 3.0) {
        let [few, many] = [8, 64].map(|enclosed| {
            let (certificate, system) = stiff(&wave(), None, &[(0, 0.3)], enclosed);
            let (system, near) = (system.perturbed(), piece([p, p], [[0.2, 0.6], [0.0; 2]], 1e-3));
            let all = modulated(&certificate, &system, &near, [[0.2, 0.6], [0.0; 2]].map(|it| it.map(Interval::exact)));
            let (omega, it) = (system.omega(), Perturbations::new(&certificate, &system, None, Some(&near)));
            [(4, Interval::exact(1.0)), (3, omega)].map(|(i, over)| {
                let bounds = &it.far(&all[i], 2, system.tails()[0] / over)[0];
                [0, 1, 2, 3].map(|part| (bounds[part].lo(), norm(all[i][part][3..].iter().copied()).mid()))
            })
        });
        for (few, many) in few.iter().zip(&many) {
            let most = many.iter().fold(0.0, |most: f64, part| most.max(part.1));
            assert!((0..4).all(|i| many[i].1 < few[i].0 && few[i].0 < 2.0 * most), "{p}: {few:?} {many:?}");
        }
    }
}

// Truth: lambda of the stiffness d +- mu/sqrt 2, whose change has the size mu.
#[test]
fn bounds_of_a_wave_hold_for_the_changes_of_its_strains() {
    let (certificate, system) = stiff(&wave(), None, &[(0, -0.3)], 64);
    let change = Interval::exact(1e-10);
    let size = system.known[0].change(certificate.model.alpha, change).lo() / 2_f64.sqrt();
    let near = harmonic(-0.3, 1.0, 1.0 / 3.0);
    let piece = piece([1.0 / 3.0; 2], [near, [0.0; 2]], 1e-3);
    let [needed, _] = bloch(&certificate, &piece, (&system.perturbed(), &[change]), &|| Ok(())).unwrap();
    for sign in [1.0, -1.0] {
        let apart = (harmonic(-0.3 + sign * size, 1.0, 1.0 / 3.0)[0] - near[0]).abs();
        assert!(apart < needed, "{sign}: {apart:e} {needed:e}");
    }
}

/// A breather as if all its contacts had this constant stiffness.
fn driven(d: f64) -> (Certificate, Rc<System>) {
    let (certificate, system) = stiff(&certificate(5, "bond"), None, &[(0, d)], 64);
    (certificate, system.perturbed())
}

/// A growth rate of no perturbation.
const RATE: Interval = Interval::ONE;

/// The terms of its equations, for strains that differ by at most `change`.
fn terms((certificate, system): &(Certificate, Rc<System>), change: f64) -> Perturbed {
    let it = Perturbations::new(certificate, system, None, None);
    let l = rated(certificate, &it, RATE);
    Perturbed::new(&it, l, &|i, place| it.column(i, place), &[Interval::exact(change)])
}

fn derivative(terms: &Perturbed) -> Derivative {
    let mut derivative = terms.derivative(&|| Ok(())).unwrap();
    derivative.push(terms.block.column(0), Interval::ONE);
    derivative
}

/// The norm of `1 - A M`, and its row of `g`.
fn z1(terms: &Perturbed) -> [Interval; 2] {
    let (derivative, rows) = (derivative(terms), derivative(terms).within(&terms.changed));
    [derivative.norm(&rows), *rows.last().unwrap()]
}

/// Bounds of `g`.
fn of_breather(terms: &Perturbed) -> Interval {
    of_terms(terms, &terms.l, &derivative(terms))
}

/// Adds a multiple of a row of `A` to one.
fn add(terms: &mut Perturbed, factor: f64, [from, to]: [usize; 2]) {
    let row = terms.block.inverse[from].clone();
    terms.block.inverse[to].iter_mut().zip(row).for_each(|(a, b)| *a = *a + Interval::exact(factor) * b);
}

// Truth: if A is the inverse with twice its row of g added to a row, 1 - A M has -2 where this
// row meets the column of g.
#[test]
fn z1_has_the_rows_and_columns_of_g() {
    let it = driven(0.3);
    let (g, pinned) = (terms(&it, 0.0).block.all.len(), terms(&it, 0.0).it.pinned[0]);
    for row in [terms(&it, 0.0).block.index(pinned).unwrap(), g] {
        let mut terms = terms(&it, 0.0);
        add(&mut terms, 2.0, [g, row]);
        let [norm, last] = z1(&terms);
        assert!(norm.hi() > 2.0 - 1e-9 && (row < g || last.hi() > 2.0 - 1e-9), "{row}: {norm:?} {last:?}");
    }
}

// Truth: g with the inverse as A. Half of its row of g leaves an eighth of g after three
// corrections.
#[test]
fn bounds_of_g_hold_it_where_the_row_of_g_is_not_the_inverse() {
    let it = driven(0.3);
    let (truth, mut terms) = (of_breather(&terms(&it, 0.0)), terms(&it, 0.0));
    let g = terms.block.all.len();
    add(&mut terms, -0.5, [g, g]);
    let bounds = of_breather(&terms);
    assert!(bounds.lo() < truth.lo() && truth.hi() < bounds.hi(), "{bounds:?} {truth:?}");
}

// Truth: g and 1 - A M of the stiffness d +- mu/sqrt 2, whose change has the size mu.
#[test]
fn bounds_of_g_and_z1_hold_for_the_changes() {
    let it = driven(0.3);
    for sign in [1.0, -1.0] {
        let wider = terms(&it, 1e-3);
        let moved = driven(0.3 + sign * wider.changed[0].lo() / 2_f64.sqrt());
        let (bounds, truth) = (of_breather(&wider), of_breather(&terms(&moved, 0.0)));
        assert!(bounds.lo() < truth.lo() && truth.hi() < bounds.hi(), "{sign}: {bounds:?} {truth:?}");
        // With the same A.
        let mut other = self::terms(&moved, 0.0);
        other.block.inverse.clone_from(&wider.block.inverse);
        let [bounds, truth] = [&wider, &other].map(z1);
        assert!((0..2).all(|i| truth[i].hi() < bounds[i].hi()), "{sign}: {bounds:?} {truth:?}");
    }
}
