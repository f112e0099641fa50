//! The equations of perturbations, and what is proved of their multipliers.

use hertzchain_proofs::{
    certificate::{Bloch, Certificate, Multiplier},
    check::{NARROWEST, Refused, moments},
    exact::Exact,
    internals::{Bent, Equations, Perturbed, Piece, System, bloch, doubling, equations, factors, perturbation, rate},
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
    let of_site = |a: &Vec<Interval>| moments(a, certificate.model.alpha, 64, NARROWEST).unwrap();
    let mut system = System::new(certificate).unwrap();
    system.known = system.a.iter().map(of_site).collect();
    system
}

// Truth: L = s^2 (kappa (1 + rho) + rho s^2)/(kappa + rho s^2).
#[test]
fn factors_are_inverses_of_l() {
    let certificate = certificate(5, "bond");
    let piece = Piece {
        p_over_pi: None,
        rate: [[0.3, 0.0], [0.0; 2]].map(|it| it.map(Interval::exact)),
        radius: Interval::ZERO,
    };
    let l = &factors(&certificate, &system(&certificate).perturbed(), &piece)[0];
    let (kappa, rho) = (2.0, 1.0 / 3.0);
    let times = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c - b * d, a * d + b * c];
    for k in -3..4 {
        let omega = 2.05 * f64::from(k);
        let square = times([0.3, omega], [0.3, omega]);
        let found = l[(l.len() / 2).wrapping_add_signed(k as isize)].map(Interval::mid);
        let found = times(found, times(square, [kappa * (1.0 + rho) + rho * square[0], rho * square[1]]));
        let truth = [kappa + rho * square[0], rho * square[1]];
        let apart = (found[0] - truth[0]).hypot(found[1] - truth[1]);
        assert!(apart < 1e-12 * (1.0 + omega * omega), "{found:?} {truth:?}");
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
    }
    let block = enclosed / 8;
    let certificate = Certificate { enclosed, block, multiplier, ..certificate.clone() };
    let mut system = System::new(&certificate).unwrap();
    system.known = known;
    (certificate, system)
}

/// Bounds of `g` for -1.
fn g(certificate: &Certificate, d: &[(usize, f64)], enclosed: usize) -> [f64; 2] {
    let (certificate, system) = stiff(certificate, Some(Multiplier::Doubling), d, enclosed);
    doubling(&certificate, (&system, &vec![Interval::ZERO; system.a.len()]), &|| Ok(())).unwrap()
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
fn modulated(d: f64, piece: &Bloch) -> Result<[f64; 2], Refused> {
    let (certificate, system) = stiff(&wave(), None, &[(0, d)], 64);
    bloch(&certificate, &Piece::of_wave(piece), (&system.perturbed(), &[Interval::ZERO]), &|| Ok(()))
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
            modulated(-0.3, &piece([1.0 / 3.0 - half, 1.0 / 3.0 + half], rate, radius))
        };
        let radius = 200.0 * half * half + 1e-9;
        let [needed, _] = proved([0.0; 3], radius).unwrap_or_else(|why| panic!("{k} {half}: {why}"));
        assert!(needed > bend, "{k} {half}: {needed:e} {bend:e}");
        let far = 1.01 * radius;
        let still = if half > 0.0 { [0.0, 0.0, far + bend] } else { [far; 3] };
        for apart in [[far, 0.0, 0.0], [-far, 0.0, 0.0], [0.0, far, 0.0], [0.0, -far, 0.0], still] {
            let refused = proved(apart, radius);
            assert!(matches!(refused, Err(Refused::Perturbation { .. })), "{k} {half} {apart:?}: {refused:?}");
        }
    }
}

// Truth: the factors at single wave numbers of a piece, and those of other lambda near them.
#[test]
fn factors_along_a_piece_hold_those_of_its_wave_numbers() {
    let (certificate, system) = stiff(&wave(), None, &[(0, 0.3)], 16);
    let at = |ends: [f64; 2], rate: [[f64; 2]; 2], radius: f64| {
        let rate = rate.map(|it| it.map(Interval::exact));
        factors(&certificate, &system, &Piece { rate, ..Piece::of_wave(&piece(ends, [[0.0; 2]; 2], radius)) })
    };
    let (rate, change, half) = ([0.2, 0.6], [0.0, 0.0], 5e-3);
    let [start, slope, rest, steep, all] = at([0.4 - half, 0.4 + half], [rate, change], 1e-4);
    let mut filled: f64 = 0.0;
    for s in [-1.0, -0.5, 0.5, 1.0] {
        let [there, ..] = at([0.4 + s * half; 2], [rate, [0.0; 2]], 1e-4);
        let moved = at([0.4 + s * half; 2], [[rate[0] + 1e-4, rate[1] - 1e-4], [0.0; 2]], 1e-12);
        for (k, part) in (3..34).flat_map(|k| [0, 1].map(|part| (k, part))) {
            let of = |l: &[[Interval; 2]]| l[k][part];
            let left = of(&there) - (of(&start) + Interval::exact(s) * of(&slope));
            let bounds = of(&rest);
            assert!(bounds.lo() <= left.hi() && left.lo() <= bounds.hi(), "{k} {s}: {left:?} {bounds:?}");
            assert!(of(&all).holds(of(&moved[0]).mid()), "{k} {s}: {:?} {:?}", of(&all), of(&moved[0]));
            assert!(of(&steep).holds(of(&moved[3]).mid()), "{k} {s}: {:?} {:?}", of(&steep), of(&moved[3]));
            if s.abs() == 1.0 {
                filled = filled.max(left.mid().abs() / bounds.hi());
            }
        }
    }
    // Half of the rest would not hold them.
    assert!(filled > 0.6, "{filled}");
}

// Truth: contacts of the stiffness D (1 + cos(omega t)/10) have modes sin q (n - 1/2), of which the
// cosines (k + 1/2) omega t, or the sines, obey equations with three terms. The multiplier is -1
// where their determinant is 0.
#[test]
fn minus_one_is_where_a_linear_mode_has_twice_the_period() {
    let (certificate, rho, kappa) = (certificate(7, "bond"), 1.0 / 3.0, 2.0);
    for (turns, sign) in (1..=3).flat_map(|turns| [-1.0, 1.0].map(|sign| (turns, sign))) {
        let lattice = 4.0 * (std::f64::consts::PI / 7.0 * f64::from(turns)).sin().powi(2);
        // The first entry of the triangular factor, from the last row on.
        let pivot = |d: f64| {
            (0..20).rev().fold(f64::INFINITY, |next, k| {
                let square = -(2.05 * (f64::from(k) + 0.5)).powi(2);
                let l = square * (1.0 + kappa * rho / (kappa + rho * square));
                let own = if k == 0 { 1.0 + 0.05 * sign } else { 1.0 };
                l + lattice * d * own - (0.05 * lattice * d).powi(2) / next
            })
        };
        let (mut low, mut high) = (0.0, 20.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            (low, high) = if pivot(middle) < 0.0 { (middle, high) } else { (low, middle) };
        }
        let near = |factor: f64| g(&certificate, &[(0, factor * low), (1, 0.1 * factor * low)], 64);
        let [below, at, above] = [1.0 - 1e-9, 1.0, 1.0 + 1e-9].map(near);
        assert!(at[0] < 0.0 && 0.0 < at[1], "{turns} {sign}: {at:?}");
        let [first, last] = [below, above].map(|g| if g[0] * g[1] > 0.0 { g[0].signum() } else { 0.0 });
        assert!(first * last < 0.0, "{turns} {sign}: {below:?} {above:?}");
    }
}

// Truth: g with 64 harmonics. With 16, D couples the harmonics of the approximate solution to those
// that it lacks: to some of the equations that are computed, and only to others.
#[test]
fn bounds_of_g_hold_for_the_harmonics_that_are_left_out() {
    let certificate = certificate(7, "bond");
    for d in [6, 16].map(|l| [(0, 0.1), (l, 0.03)]) {
        let [few, many] = [16, 64].map(|enclosed| g(&certificate, &d, enclosed));
        assert!(few[0] < many[0] && many[1] < few[1], "{d:?}: {few:?} {many:?}");
        assert!(many[1] - many[0] < 1e-4 * (few[1] - few[0]), "{d:?}: {few:?} {many:?}");
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
            let [rate, _] = rate(&certificate, &system, &Piece::of_wave(&about(near, 1e-15))).unwrap();
            let proved =
                bloch(&certificate, &Piece::of_wave(&about(rate, 1e-3)), (&system, &[Interval::ZERO]), &|| Ok(()));
            (rate, proved.unwrap_or_else(|why| panic!("{l} {enclosed}: {why}"))[0])
        });
        let apart = (few.0[0] - many.0[0]).hypot(few.0[1] - many.0[1]);
        assert!(apart <= few.1 && many.1 < 1e-3 * few.1, "{l}: {apart:e} {few:?} {many:?}");
    }
    for p in [1.0, -1.0].map(|sign| sign / 3.0) {
        let [few, many] = [8, 64].map(|enclosed| {
            let (certificate, system) = stiff(&wave(), None, &[(0, 0.3)], enclosed);
            let near = Piece::of_wave(&piece([p, p], [[0.2, 0.6], [0.0; 2]], 1e-3));
            let it = Equations::new(&system, certificate.model.alpha, [1, enclosed], (false, vec![Vec::new(); 2]));
            let all = factors(&certificate, &system, &near);
            [(4, Interval::ONE), (3, system.omega())].map(|(i, over)| {
                let far = all[i].iter().enumerate().filter(|(k, _)| k.abs_diff(all[i].len() / 2) > 2);
                let far = norm(far.map(|(_, l)| norm(*l)));
                (it.beyond(&all[i], 2, system.tails()[0] / over).lo(), far.mid())
            })
        });
        assert!((0..2).all(|i| many[i].1 < few[i].0 && few[i].0 < 2.0 * many[i].1), "{p}: {few:?} {many:?}");
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
    let [needed, _] =
        bloch(&certificate, &Piece::of_wave(&piece), (&system.perturbed(), &[change]), &|| Ok(())).unwrap();
    for sign in [1.0, -1.0] {
        let apart = (harmonic(-0.3 + sign * size, 1.0, 1.0 / 3.0)[0] - near[0]).abs();
        assert!(apart < needed, "{sign}: {apart:e} {needed:e}");
    }
}

/// A breather as if all its contacts had this constant stiffness.
fn driven(d: f64) -> (Certificate, System) {
    let (certificate, system) = stiff(&certificate(5, "bond"), None, &[(0, d)], 64);
    (certificate, system.perturbed())
}

/// The terms of its equations at the growth rate 1 of no perturbation, for strains that differ by
/// at most `change`.
fn terms((certificate, system): &(Certificate, System), change: f64) -> Perturbed<'_> {
    let rate = [[Interval::ONE, Interval::ZERO], [Interval::ZERO; 2]];
    let piece = Piece { p_over_pi: None, rate, radius: Interval::ZERO };
    let l = factors(certificate, system, &piece)[4].clone();
    Perturbed::new(equations(certificate, system, &piece), l, None, &[Interval::exact(change)])
}

/// Bounds of `g`, and `q`.
fn found(terms: &Perturbed) -> (Interval, f64) {
    let (p, g) = perturbation(terms, &terms.l, None);
    let straight = Bent { value: &|_, _| Interval::ZERO, contacts: Vec::new(), late: Interval::ZERO };
    let value = |place| terms.it.defect(&terms.l, (&p, &g), place);
    let solved = terms.solved((&p, &value, &terms.it.given(&p)), (&straight, Interval::ZERO), &|| Ok(()));
    let [radius, q] = solved.unwrap();
    (if q.hi() < 1.0 { g[0] + radius.ball() } else { g[0] }, q.hi())
}

/// Adds a multiple of a row of `A` to one.
fn add(terms: &mut Perturbed, factor: f64, [from, to]: [usize; 2]) {
    for matrix in [&mut terms.block.inverse, &mut terms.block.product] {
        let row = matrix[from].clone();
        matrix[to].iter_mut().zip(row).for_each(|(a, b)| *a = *a + Interval::exact(factor) * b);
    }
}

// Truth: if A is the inverse with twice its row of g added to this row, 1 - A M has -2 where this
// row meets the column of g. And g with the inverse as A: half of its row of g leaves an eighth of
// g after three corrections.
#[test]
fn bounds_have_the_row_and_the_column_of_g() {
    let it = driven(0.3);
    let (truth, _) = found(&terms(&it, 0.0));
    let g = terms(&it, 0.0).block.all.len();
    let [mut twice, mut half] = [terms(&it, 0.0), terms(&it, 0.0)];
    add(&mut twice, 2.0, [g, g]);
    assert!(found(&twice).1 > 2.0 - 1e-9, "{:?}", found(&twice));
    add(&mut half, -0.5, [g, g]);
    let (bounds, _) = found(&half);
    assert!(bounds.lo() < truth.lo() && truth.hi() < bounds.hi(), "{bounds:?} {truth:?}");
}

// Truth: g of the stiffness d +- mu/sqrt 2, whose change has the size mu.
#[test]
fn bounds_of_g_hold_for_the_changes() {
    let it = driven(0.3);
    for sign in [1.0, -1.0] {
        let wider = terms(&it, 1e-3);
        let moved = driven(0.3 + sign * wider.changed[0].lo() / 2_f64.sqrt());
        let ((bounds, q), (truth, own)) = (found(&wider), found(&terms(&moved, 0.0)));
        assert!(
            bounds.lo() < truth.lo() && truth.hi() < bounds.hi() && own < q && q < 1.0,
            "{sign}: {bounds:?} {truth:?}"
        );
    }
}
