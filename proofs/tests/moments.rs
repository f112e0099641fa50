//! Coefficients of contact forces are enclosed.

use hertzchain_proofs::{
    check::{NARROWEST, moments},
    interval::Interval,
};

/// Coefficients of `X`, `alpha`; harmonics 0, 1, 2 and 7 of `N` and of `D`, and the means of their
/// squares and of those of `N'`. Truth: quadrature between the zeros of `X`, with 40 digits (mpmath). The first has zeros
/// of first order, the third touches zero, the fourth has none.
type Case = (&'static [f64], &'static str, [f64; 11]);
const CASES: &[Case] = &[
    (
        &[0.0, 1.0],
        "3/2",
        [
            0.2782089472246911,
            -0.4576558581010879,
            0.23846481190687804,
            -0.004831962302726418,
            0.5720698226263599,
            -0.8346268416740732,
            0.22882792905054394,
            0.03251792889639246,
            0.2122065907891938,
            0.716197243913529,
            0.238732414637843,
        ],
    ),
    (
        &[0.05, -0.4, 0.2, 0.05],
        "3/2",
        [
            0.053691550923473934,
            0.05835674643180156,
            -0.026264526213849834,
            -0.0033825588942616907,
            0.3732463987359345,
            0.4113269827033926,
            -0.1178562968779969,
            -0.025329371628609914,
            0.006482501164758195,
            0.25547020386553054,
            0.020205631308873514,
        ],
    ),
    (
        &[0.25, 0.5, 0.25],
        "3/2",
        [
            0.010387730957349081,
            -0.011230902793954127,
            -0.006738541676372476,
            -0.000828073823852191,
            0.17989669639183242,
            -0.20761978468793735,
            -0.06920659489597912,
            0.03581672756702123,
            0.0003440510854073569,
            0.0768486219567645,
            0.002287642684867577,
        ],
    ),
    (
        &[-3.0, 0.5, -0.125],
        "6/5",
        [
            3.743725349763339,
            -0.7501042565352114,
            0.1928987447051975,
            -1.9457185865234567e-07,
            1.4931577759337031,
            -0.04926275060182328,
            0.010902468231075274,
            1.456087002418365e-07,
            14.315417093260596,
            2.2307932638921475,
            0.35578829715622,
        ],
    ),
    (
        &[0.05, 0.7, 0.0, 0.1],
        "5/2",
        [
            0.08201571060679107,
            -0.15078933905368003,
            0.11670997976757339,
            -0.0012396693395496634,
            0.344572016280749,
            -0.6068174753721449,
            0.4079303576760048,
            -0.0031624143786737834,
            0.028657279145914153,
            0.4073314705973483,
            0.0803400381539604,
        ],
    ),
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
