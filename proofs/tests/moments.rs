//! Coefficients of contact forces are enclosed.

use hertzchain_proofs::{
    check::{Moments, NARROWEST, moments},
    exact::Exact,
    internals::{NARROWEST_ALONG, NODES, Sums, fejer},
    interval::Interval,
};
use std::f64::consts::PI;

/// Coefficients of `X`, `alpha`; harmonics 0, 1, 2 and 7 of `N` and of `D`, and the means of their
/// squares and of those of `N'`. Truth: quadrature between the zeros of `X`, with 40 digits
/// (mpmath). The first has zeros of first order, the third touches zero, the fourth has none.
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
        let found = found(a, alpha, 64, NARROWEST);
        let at = |series: &[Interval]| [0, 1, 2, 7].map(|k| series[k]);
        let all = [at(&found.force).to_vec(), at(&found.stiffness).to_vec(), found.squares.to_vec()].concat();
        for (i, (found, truth)) in all.iter().zip(truth).enumerate() {
            // The truth is rounded to a double.
            let holds = found.lo() <= truth.next_up() && truth.next_down() <= found.hi();
            assert!(holds, "alpha {alpha}, {i}: {truth:e} is not in {found:?}");
            assert!(found.hi() - found.lo() < 2e-10, "alpha {alpha}, {i}: {found:?}");
        }
        // Parseval's equation: the mean square is the sum over all harmonics.
        let known = found.force[0].square()
            + found.force[1..].iter().map(|n| n.square()).sum::<Interval>() / Interval::exact(2.0);
        let share = known.mid() / found.squares[0].mid();
        assert!(share > 0.999 && known.lo() <= found.squares[0].hi(), "{share}");
        // |X| at pi, where all of these are lowest.
        let overlap = -strain(a, [PI, 0.0])[0];
        if *alpha != "3/2" || a.len() == 2 {
            assert!(found.overlap().hi() >= overlap && found.overlap().hi() < 1.1 * overlap, "{:?}", found.overlap());
        }
    }
}

#[test]
fn forces_that_cannot_be_enclosed_are_refused() {
    let alpha = "3/2".parse().unwrap();
    for a in [[0.0, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        assert!(moments(&a.map(Interval::exact), alpha, 16, NARROWEST).is_none(), "{a:?}");
    }
    // No contact: no force.
    let free = found(&[1.0, 0.5], "3/2", 16, NARROWEST);
    assert!(free.force.iter().all(|n| n.holds(0.0) && n.hi() < 1e-300));
}

/// `X` at `x + i y`, and those of these coefficients.
fn strain(a: &[f64], [x, y]: [f64; 2]) -> [f64; 2] {
    let sum = |of: &dyn Fn(f64) -> f64| a.iter().zip(0..).map(|(a, k)| a * of(f64::from(k))).sum();
    [sum(&|k| (k * x).cos() * (k * y).cosh()), -sum(&|k| (k * x).sin() * (k * y).sinh())]
}

fn found(a: &[f64], alpha: &str, count: usize, narrowest: f64) -> Moments {
    let a: Vec<Interval> = a.iter().map(|a| Interval::exact(*a)).collect();
    moments(&a, alpha.parse().unwrap(), count, narrowest).unwrap()
}

const WAVE: [f64; 4] = [0.01, -0.4, 0.2, 0.05];

/// A point of the ellipse of a piece.
fn on_ellipse([centre, half]: [f64; 2], share: f64) -> [f64; 2] {
    let (sin, cos) = (share * PI).sin_cos();
    [centre + 17.0 / 8.0 * half * cos, 15.0 / 8.0 * half * sin]
}

// Truth: the strains at 21 phases of each piece, and on its ellipse, where they have no zeros.
// Pieces come one after the other, from pi to 0.
#[test]
fn strains_are_bounded_on_pieces_and_ellipses_are_free_of_zeros() {
    let mut least = [f64::INFINITY; 2];
    let more = |shift: u32| {
        let shift = f64::from(shift) / 200.0;
        let last = [-1.0 - 4.0 * shift, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        [vec![shift - 0.7, -0.4, 0.2, 0.05], last.to_vec()]
    };
    for (i, a) in [WAVE.to_vec()].into_iter().chain((0..200).flat_map(more)).enumerate() {
        let (moments, mut to) = (found(&a, "3/2", 4, NARROWEST_ALONG), 1.0);
        for (share, overlap) in &moments.pieces {
            let half = 0.5 * PI * share.mid();
            let piece = [PI * to - half, half];
            let phases = (-10..=10).map(|j| -strain(&a, [piece[0] + half * f64::from(j) / 10.0, 0.0])[0]);
            let [low, high] = phases.fold([f64::INFINITY, -f64::INFINITY], |[low, high], x| [x.min(low), x.max(high)]);
            assert!(overlap.lo() - 1e-14 < low && high < overlap.hi() + 1e-14, "{to} {overlap:?}");
            if i == 0 {
                least[0] = least[0].min((high - low + 1e-15) / (overlap.hi() - overlap.lo()));
            }
            if overlap.hi() > 0.0 && share.mid() >= NARROWEST_ALONG {
                let all = (0..32).map(|j| -strain(&a, on_ellipse(piece, f64::from(j) / 16.0))[0]);
                least[1] = least[1].min(all.fold(f64::INFINITY, f64::min) / overlap.hi());
            }
            to -= share.mid();
        }
        assert!(to == 0.0);
    }
    // Measured: 0.40 of the width that is proved.
    assert!(least[0] > 0.2 && least[1] > 0.0 && least[1] < 0.1, "{least:?}");
}

// Truth: strains on the ellipse.
#[test]
fn strains_are_bounded_on_ellipses() {
    let exact = WAVE.map(Interval::exact);
    let sums = Sums::new(&exact, "3/2".parse().unwrap(), 4, NARROWEST);
    for piece in [[0.3, 0.1], [1.5, 0.2], [1.5, 0.01], [3.1, 0.3]] {
        let [middle, _, bound, growth] = sums.near(Interval::exact(piece[0]), Interval::exact(piece[1]));
        let at = |j: u32| -> f64 {
            let [re, im] = strain(&WAVE, on_ellipse(piece, f64::from(j) / 20.0));
            (re - middle.mid()).hypot(im)
        };
        let most = (0..40).map(at).fold(0.0, f64::max);
        // Measured: 0.13 to 0.98 of the bound, which has the sum of all moduli of X''.
        assert!(most < bound.hi() && most > 0.1 * bound.hi(), "{piece:?}: {most} {bound:?}");
        assert!((growth.hi().ln() - piece[1] * 15.0 / 8.0).abs() < 1e-14, "{growth:?}");
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

// Truth: 8 4^{-n} e^{15 k h/8}/(1 - 1/4) for n nodes, k = 64, half-widths h = pi/32 and the
// overlap 1.
#[test]
fn the_error_of_the_quadrature_is_added() {
    let moments = found(&[-1.0], "3/2", 64, NARROWEST);
    let error = 8.0 * 0.25_f64.powi(NODES as i32) / 0.75 * (15.0 / 8.0 * 64.0 * PI / 32.0).exp();
    for (found, error) in [(moments.force[64], error), (moments.stiffness[64], 1.5 * error)] {
        // The rest is rounding.
        assert!(found.hi() > error && found.hi() < 1.1 * error, "{found:?} {error:e}");
    }
}

// Truth: the moments with pieces as narrow as they can be.
#[test]
fn pieces_that_are_not_integrated_are_bounded() {
    let of = |narrowest: f64| {
        let found = found(&WAVE, "3/2", 16, narrowest);
        [found.force, found.stiffness, found.squares.to_vec()].concat()
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
        let moments = found(&a, text, 32, NARROWEST_ALONG);
        for r in [1e-4, 1e-2, 0.1] {
            let stiffness = |x: f64| if x < 0.0 { (power + 1.0) * (-x).powf(power) } else { 0.0 };
            let square = |j: u32| {
                let x = strain(&a, [PI * (f64::from(j) + 0.5) / 20_000.0, 0.0])[0];
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
