//! Coefficients of contact forces are enclosed.

use hertzchain_proofs::{
    check::{NARROWEST, moments},
    exact::Exact,
    internals::{NARROWEST_ALONG, NODES, Sums, fejer},
    interval::Interval,
};

/// Coefficients of `X`, `alpha`; harmonics 0, 1, 2 and 7 of `N` and of `D`, and the means of their
/// squares and of those of `N'`. Truth: quadrature between the zeros of `X`, with 40 digits (mpmath). The first has zeros
/// of first order, the third touches zero, the fourth has none.
type Case = (&'static [f64], &'static str, [f64; 11]);
#[rustfmt::skip]
const CASES: &[Case] = &[
    (&[0.0, 1.0], "3/2", [
        0.2782089472246911, -0.4576558581010879, 0.23846481190687804, -0.004831962302726418,
        0.5720698226263599, -0.8346268416740732, 0.22882792905054394, 0.03251792889639246,
        0.2122065907891938, 0.716197243913529, 0.238732414637843,
    ]),
    (&[0.05, -0.4, 0.2, 0.05], "3/2", [
        0.053691550923473934, 0.05835674643180156, -0.026264526213849834, -0.0033825588942616907,
        0.3732463987359345, 0.4113269827033926, -0.1178562968779969, -0.025329371628609914,
        0.006482501164758195, 0.25547020386553054, 0.020205631308873514,
    ]),
    (&[0.25, 0.5, 0.25], "3/2", [
        0.010387730957349081, -0.011230902793954127, -0.006738541676372476, -0.000828073823852191,
        0.17989669639183242, -0.20761978468793735, -0.06920659489597912, 0.03581672756702123,
        0.0003440510854073569, 0.0768486219567645, 0.002287642684867577,
    ]),
    (&[-3.0, 0.5, -0.125], "6/5", [
        3.743725349763339, -0.7501042565352114, 0.1928987447051975, -1.9457185865234567e-07,
        1.4931577759337031, -0.04926275060182328, 0.010902468231075274, 1.456087002418365e-07,
        14.315417093260596, 2.2307932638921475, 0.35578829715622,
    ]),
    (&[0.05, 0.7, 0.0, 0.1], "5/2", [
        0.08201571060679107, -0.15078933905368003, 0.11670997976757339, -0.0012396693395496634,
        0.344572016280749, -0.6068174753721449, 0.4079303576760048, -0.0031624143786737834,
        0.028657279145914153, 0.4073314705973483, 0.0803400381539604,
    ]),
];

#[test]
fn moments_are_enclosed() {
    for (a, alpha, truth) in CASES {
        let a: Vec<Interval> = a.iter().map(|a| Interval::exact(*a)).collect();
        let found = moments(&a, alpha.parse().unwrap(), 64, NARROWEST, &|| false).unwrap();
        let at = |series: &[Interval]| [0, 1, 2, 7].map(|k| series[k]);
        let squares = vec![found.force_square, found.stiffness_square, found.slope_square];
        let all = [at(&found.force).to_vec(), at(&found.stiffness).to_vec(), squares].concat();
        for (i, (found, truth)) in all.iter().zip(truth).enumerate() {
            // The truth is rounded to a double.
            let holds = found.lo() <= truth.next_up() && truth.next_down() <= found.hi();
            assert!(holds, "alpha {alpha}, {i}: {truth:e} is not in {found:?}");
            assert!(found.hi() - found.lo() < 2e-10, "alpha {alpha}, {i}: {found:?}");
        }
        // Parseval's equation: the mean square is the sum over all harmonics.
        let known = found.force[0].square()
            + found.force[1..].iter().map(|n| n.square()).sum::<Interval>() / Interval::exact(2.0);
        let share = known.mid() / found.force_square.mid();
        assert!(share > 0.999 && known.lo() <= found.force_square.hi(), "{share}");
        // |X| at pi, where all of these are lowest.
        let overlap: f64 = a.iter().enumerate().map(|(k, a)| if k % 2 == 0 { -a.mid() } else { a.mid() }).sum();
        if *alpha != "3/2" || a.len() == 2 {
            assert!(found.overlap.hi() >= overlap && found.overlap.hi() < 1.1 * overlap, "{:?}", found.overlap);
        }
    }
}

#[test]
fn forces_that_cannot_be_enclosed_are_refused() {
    let alpha = "3/2".parse().unwrap();
    for a in [[0.0, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        assert!(moments(&a.map(Interval::exact), alpha, 16, NARROWEST, &|| false).is_none(), "{a:?}");
    }
    // No contact: no force.
    let free = moments(&[1.0, 0.5].map(Interval::exact), alpha, 16, NARROWEST, &|| false).unwrap();
    assert!(free.force.iter().all(|n| n.holds(0.0) && n.hi() < 1e-300));
}

// Truth: the strains at 21 phases of each piece. Pieces come one after the other, from pi to 0.
#[test]
fn overlaps_are_bounded_on_pieces() {
    let a = [0.01, -0.4, 0.2, 0.05];
    let moments = moments(&a.map(Interval::exact), "3/2".parse().unwrap(), 4, NARROWEST_ALONG, &|| false).unwrap();
    let (mut to, mut least) = (1.0, f64::INFINITY);
    for (share, overlap) in &moments.pieces {
        let at = |j: u32| -> f64 {
            let theta = std::f64::consts::PI * (to - share.mid() * f64::from(j) / 20.0);
            -a.iter().zip(0_u32..).map(|(a, k)| a * (f64::from(k) * theta).cos()).sum::<f64>()
        };
        let all: Vec<f64> = (0..=20).map(at).collect();
        assert!(all.iter().all(|x| overlap.lo() - 1e-15 < *x && *x < overlap.hi() + 1e-15), "{to} {overlap:?}");
        let [low, high] = [f64::min, f64::max].map(|most| all.iter().copied().reduce(most).unwrap());
        least = least.min((high - low + 1e-15) / (overlap.hi() - overlap.lo()));
        to -= share.mid();
    }
    // Measured: 0.40 of the width that is proved.
    assert!(to == 0.0 && least > 0.2, "{to} {least}");
}

// Truth: strains on the ellipse.
#[test]
fn strains_are_bounded_on_ellipses() {
    let a = [0.01, -0.4, 0.2, 0.05];
    let exact = a.map(Interval::exact);
    let sums = Sums::new(&exact, "3/2".parse().unwrap(), 4, NARROWEST);
    for (centre, half) in [(0.3, 0.1), (1.5, 0.2), (1.5, 0.01), (3.1, 0.3)] {
        let [middle, _, bound, growth] = sums.near(Interval::exact(centre), Interval::exact(half));
        let at = |j: u32| -> f64 {
            let (sin, cos) = (f64::from(j) * std::f64::consts::PI / 20.0).sin_cos();
            let (x, y) = (centre + half * 17.0 / 8.0 * cos, half * 15.0 / 8.0 * sin);
            let sum = |of: &dyn Fn(f64) -> f64| -> f64 { a.iter().zip(0..).map(|(a, k)| a * of(f64::from(k))).sum() };
            let re = sum(&|k| (k * x).cos() * (k * y).cosh()) - middle.mid();
            re.hypot(sum(&|k| (k * x).sin() * (k * y).sinh()))
        };
        let most = (0..40).map(at).fold(0.0, f64::max);
        // Measured: 0.13 to 0.98 of the bound, which has the sum of all moduli of X''.
        assert!(most < bound.hi() && most > 0.1 * bound.hi(), "{centre} {half}: {most} {bound:?}");
        assert!((growth.hi().ln() - half * 15.0 / 8.0).abs() < 1e-14, "{growth:?}");
    }
}

// Truth: integrals of Chebyshev's polynomials, 2/(1 - j^2) for even j.
#[test]
fn the_quadrature_is_exact_for_polynomials() {
    let nodes = fejer();
    assert!(nodes.iter().all(|[_, weight]| weight.is_positive()));
    for j in 0..NODES {
        let degree = j as f64;
        let truth = if j % 2 == 0 { 2.0 / (1.0 - degree * degree) } else { 0.0 };
        let term = |[node, weight]: &[Interval; 2]| weight.mid() * (degree * node.mid().acos()).cos();
        let sum: f64 = nodes.iter().map(term).sum();
        assert!((sum - truth).abs() < 1e-13, "{j}: {sum} {truth}");
    }
}

// Truth: X in the complex plane, at 32 points of the ellipse of each piece with contact.
#[test]
fn ellipses_are_free_of_zeros() {
    let mut least = f64::INFINITY;
    let sums = |shift: u32| {
        let shift = f64::from(shift) / 200.0;
        [[shift - 0.7, -0.4, 0.2, 0.05, 0.0, 0.0, 0.0, 0.0], [-1.0 - 4.0 * shift, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]
    };
    for a in (0..200).flat_map(sums) {
        let alpha = "3/2".parse().unwrap();
        let moments = moments(&a.map(Interval::exact), alpha, 4, NARROWEST_ALONG, &|| false).unwrap();
        let mut to = 1.0;
        for (share, overlap) in &moments.pieces {
            let half = 0.5 * std::f64::consts::PI * share.mid();
            let centre = std::f64::consts::PI * to - half;
            let at = |j: u32| -> f64 {
                let (sin, cos) = (f64::from(j) * std::f64::consts::PI / 16.0).sin_cos();
                let [x, y] = [centre + 17.0 / 8.0 * half * cos, 15.0 / 8.0 * half * sin];
                -a.iter()
                    .zip(0_u32..)
                    .map(|(a, k)| a * (f64::from(k) * x).cos() * (f64::from(k) * y).cosh())
                    .sum::<f64>()
            };
            if overlap.hi() > 0.0 && share.mid() >= NARROWEST_ALONG {
                least = least.min((0..32).map(at).fold(f64::INFINITY, f64::min) / overlap.hi());
            }
            to -= share.mid();
        }
    }
    assert!(least > 0.0 && least < 0.1, "{least}");
}

// Truth: 8 4^{-n} e^{15 k h/8}/(1 - 1/4) for n nodes, k = 64, half-widths h = pi/32 and the
// overlap 1.
#[test]
fn the_error_of_the_quadrature_is_added() {
    let moments = moments(&[-Interval::ONE], "3/2".parse().unwrap(), 64, NARROWEST, &|| false).unwrap();
    let error = 8.0 * 0.25_f64.powi(NODES as i32) / 0.75 * (15.0 / 8.0 * 64.0 * std::f64::consts::PI / 32.0).exp();
    for (found, error) in [(moments.force[64], error), (moments.stiffness[64], 1.5 * error)] {
        // The rest is rounding.
        assert!(found.hi() > error && found.hi() < 1.1 * error, "{found:?} {error:e}");
    }
}

// Truth: the moments with pieces as narrow as they can be.
#[test]
fn pieces_that_are_not_integrated_are_bounded() {
    let of = |narrowest: f64| {
        let a = [0.01, -0.4, 0.2, 0.05].map(Interval::exact);
        let found = moments(&a, "3/2".parse().unwrap(), 16, narrowest, &|| false).unwrap();
        let squares = [found.force_square, found.stiffness_square, found.slope_square];
        [found.force, found.stiffness, squares.to_vec()].concat()
    };
    for (wide, near) in of(1.0 / 64.0).iter().zip(of(NARROWEST)) {
        assert!(wide.lo() < near.lo() && near.hi() < wide.hi(), "{wide:?} {near:?}");
    }
}

// Truth: midpoint sums over the half-period, with the change at both ends of the ball. The second
// sum has no zeros.
#[test]
fn changes_of_the_stiffness_are_bounded() {
    const LAWS: [(&str, f64); 4] = [("6/5", 0.2), ("3/2", 0.5), ("2", 1.0), ("5/2", 1.5)];
    for (mean, (text, power)) in [0.01, -1.0].into_iter().flat_map(|mean| LAWS.map(|law| (mean, law))) {
        let a = [mean, -0.4, 0.2, 0.05];
        let alpha: Exact = text.parse().unwrap();
        let moments = moments(&a.map(Interval::exact), alpha, 32, NARROWEST_ALONG, &|| false).unwrap();
        for r in [1e-4, 1e-2, 0.1] {
            let stiffness = |x: f64| if x < 0.0 { (power + 1.0) * (-x).powf(power) } else { 0.0 };
            let square = |j: u32| {
                let theta = std::f64::consts::PI * (f64::from(j) + 0.5) / 20_000.0;
                let x: f64 = a.iter().zip(0_u32..).map(|(a, k)| a * (f64::from(k) * theta).cos()).sum();
                let change = |y: f64| (stiffness(y) - stiffness(x)).abs();
                change(x - r).max(change(x + r)).powi(2) / 20_000.0
            };
            let truth = (2.0 * (0..20_000).map(square).sum::<f64>()).sqrt();
            let bound = moments.change(alpha, Interval::exact(r)).hi();
            // Measured: up to 2.1, where the change is far below its largest one on a piece.
            assert!(bound > truth && bound < 2.5 * truth, "{text} {r}: {bound:e} {truth:e}");
        }
    }
}
