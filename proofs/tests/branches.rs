//! Branches: pieces that are proved and connected, and what is refused.

use super::{bounds::bounds, check, check_text, exact};
use hertzchain_proofs::{
    certificate::{Center, Certificate, Model, Orbit, pieces},
    check::{Bounds, Gap, Proof, Refused, connected, turns},
    exact::Exact,
    untrusted::solve::{self, Sizes, Strip},
};

type Pieces = Vec<(Certificate, Result<Proof, Refused>)>;

/// A wave of `q = pi/5` near one harmonic.
pub(super) fn wave([omega, mean]: [&str; 2], a: f64) -> Certificate {
    super::wave(super::model(["3/2", "1/3", omega]), ["1/5", mean], [1, 4], &[a])
}

/// A breather on a ring of 15 of mean strain 0, near the profile of a kink.
pub(super) fn breather(omega: &str, center: Center, a: f64) -> Certificate {
    super::kink(super::model(["3/2", "1/3", omega]), 15, center, a)
}

/// An orbit of doubled period, seen from the far site. Its first harmonic decays from the bond on.
fn doubled(omega: &str) -> Certificate {
    let mut near = breather(omega, Center::Bond, -0.26);
    near.a.iter_mut().zip(0..).for_each(|(a, n)| a.insert(1, 0.1 * f64::from(-2 * n).exp()));
    near.a.reverse();
    near.orbit = Orbit::Breather { sites: 15, center: Center::Site };
    near
}

fn strip([from, to]: [&Certificate; 2]) -> Strip {
    let sizes = match from.background() {
        _ if from.is_wave() => Sizes::WAVE_PIECE,
        2 => Sizes::DOUBLED_PIECE,
        _ => Sizes::BREATHER_PIECE,
    };
    solve::strip([from, to], sizes, &|piece| check(piece)).unwrap()
}

fn proved(ends: [&Certificate; 2]) -> Pieces {
    let strip = strip(ends);
    assert!(strip.stop.is_none(), "{:?}", strip.stop);
    strip.pieces.into_iter().map(|(piece, proof)| (piece, Ok(proof))).collect()
}

/// A certificate at a share of a piece, with its cosine sum.
fn within(piece: &Certificate, share: f64) -> Certificate {
    let [omega, mean] = piece.to.unwrap();
    let between = |from: Exact, to: Exact| {
        let [from, to] = [from, to].map(|x| x.enclosed().mid());
        Exact::of_double(from + share * (to - from)).unwrap()
    };
    let model = Model { omega: between(piece.model.omega, omega), ..piece.model };
    Certificate { model, mean: between(piece.mean, mean), to: None, ..piece.clone() }
}

/// The distance of two cosine sums in the norm of a proof.
fn distance(a: &Certificate, b: &Certificate, weights: &[f64]) -> f64 {
    let of_site = |((a, b), w): ((&Vec<f64>, &Vec<f64>), &f64)| {
        let apart = |k: usize| (a.get(k).unwrap_or(&0.0) - b.get(k).unwrap_or(&0.0)).abs();
        (2.0_f64.sqrt() * apart(0) + (1..a.len().max(b.len())).map(apart).sum::<f64>()) / w
    };
    a.a.iter().zip(&b.a).zip(weights).map(of_site).fold(0.0, f64::max)
}

/// Four branches: waves of mean strain 0, and waves and breathers, also of doubled period, whose
/// mean strain grows.
fn branches() -> [Pieces; 4] {
    let end = Certificate { mean: exact("1/10000"), ..breather("2.0502", Center::Site, 0.148) };
    let further = Certificate { mean: exact("1/100000"), ..doubled("1.03303") };
    [
        proved([&wave(["2.001", "0"], 0.0083), &wave(["2.00105", "0"], 0.009)]),
        proved([&wave(["2.001", "0.0571"], 0.114), &wave(["2.00105", "0.063"], 0.126)]),
        proved([&breather("2.05", Center::Site, 0.147), &end]),
        proved([&doubled("1.033"), &further]),
    ]
}

// Truth: solutions with more harmonics at single parameters.
#[test]
fn solutions_of_a_branch_lie_in_its_balls() {
    for (pieces, most) in branches().iter().zip([10, 10, 16, 10]) {
        assert!(pieces.len() > 1 && pieces.len() < most, "{}", pieces.len());
        assert_eq!(connected(pieces), (pieces.len(), None));
        for (piece, proof) in [&pieces[0], &pieces[pieces.len() - 1]] {
            let proof = proof.as_ref().unwrap();
            for share in [0.0, 0.3, 1.0] {
                let near = within(piece, share);
                let better = solve::near(&near, Sizes { block: 12, harmonics: 64, enclosed: 64 }).unwrap();
                let apart = distance(&near, &better, &proof.weights);
                assert!(apart < proof.radius, "{share}: {apart:e} {proof:?}");
                // Measured at the ends: radii are 1.6 to 4.1 distances.
                assert!(share == 0.3 || proof.radius < 6.0 * apart, "{share}: {apart:e} {proof:?}");
            }
        }
    }
}

// Truth: the bounds of single parameters, of which those of a piece are suprema.
#[test]
fn bounds_of_a_piece_hold_at_all_its_points() {
    for pieces in &branches() {
        let (piece, proof) = &pieces[0];
        let most = proof.as_ref().unwrap().bounds;
        let mut least = [f64::INFINITY; 2];
        for share in [0.0, 0.25, 0.5, 1.0] {
            let Bounds { y0, z1 } = bounds(&within(piece, share));
            // A is the inverse at this point, not in the middle of the piece: up to 0.2 percent.
            let holds = y0 < 1.004 * most.y0 && z1 < 1.004 * most.z1;
            assert!(holds, "{share}: {y0:e} {z1} {most:?}");
            if share == 0.0 || share == 1.0 {
                least = [least[0].min(y0), least[1].min(z1)];
            }
        }
        // The mean strain of a wave is that of the cosine sum at a single parameter only.
        let [start, end] = piece.ends().map(|end| end[1].enclosed().mid());
        let means = if piece.is_wave() { (end - start).abs() / 2_f64.sqrt() } else { 0.0 };
        // Measured: up to 1.013 and 1.16.
        assert!(most.y0 < 1.03 * least[0] + means && most.z1 < 1.25 * least[1], "{least:?} {most:?}");
    }
}

#[test]
fn a_gap_is_refused() {
    let [all, ..] = branches();
    let gap = |change: &dyn Fn(&mut Pieces)| {
        let mut pieces = all.clone();
        change(&mut pieces);
        connected(&pieces)
    };
    // A piece is missing; nodes that do not meet, in the frequency or in the mean strain; a single
    // wave is its own end; another chain, a piece that is not proved.
    type Change<'a> = &'a dyn Fn(&mut Pieces);
    let cases: [(Change, usize, Gap); 7] = [
        (&|it| drop(it.remove(1)), 1, Gap::Nodes),
        (&|it| it[0].0.to = Some([exact("2.00100001"), exact("0")]), 1, Gap::Nodes),
        (&|it| it[1].0.mean = exact("1/100000000"), 1, Gap::Nodes),
        (&|it| it[0].0.to = None, 1, Gap::Nodes),
        (&|it| it[1].0.to = None, 2, Gap::Nodes),
        (&|it| it[1].0.model.kappa = exact("2"), 1, Gap::Other),
        (&|it| it[1].1 = Err(Refused::Moments), 1, Gap::Refused(Refused::Moments)),
    ];
    for (i, (change, at, why)) in cases.into_iter().enumerate() {
        assert_eq!(gap(change), (at, Some(why)), "{i}");
    }
    // Waves of about the same first harmonics, but of another mean strain.
    let (at, why) = gap(&|pieces| pieces[1].0.to = pieces[1].0.to.map(|[omega, _]| [omega, exact("1")]));
    assert!(at == 1 && matches!(why, Some(Gap::Apart(needed, _)) if needed > 0.7), "{at} {why:?}");
    // Balls that overlap: both are wider than the other's ball of uniqueness.
    let (at, why) = gap(&|pieces| {
        for (_, proof) in &mut pieces[..2] {
            let proof = proof.as_mut().unwrap();
            proof.radius = 0.99 * proof.uniqueness_radius;
        }
    });
    assert!(at == 1 && matches!(why, Some(Gap::Apart(needed, unique)) if needed > unique), "{at} {why:?}");
    // The distance of mean strains has the factor sqrt 2: of one site, and of the middle of a
    // piece.
    let [_, _, breathers, _] = branches();
    for (apart, joined) in [(0.7e-3, true), (0.72e-3, false)] {
        let mut both = [breathers[..2].to_vec(), all[..2].to_vec()];
        for (_, proof) in both.iter_mut().flatten() {
            let proof = proof.as_mut().unwrap();
            (proof.radius, proof.uniqueness_radius) = (0.0, 1e-3);
            proof.weights.fill(1.0);
        }
        for pieces in &mut both {
            pieces[1].0.a = pieces[0].0.a.clone();
        }
        both[0][1].0.a[3][0] += apart;
        both[1][0].0.mean = Exact::of_double(-apart).unwrap();
        both[1][1].0.to = both[1][1].0.to.map(|[omega, _]| [omega, Exact::of_double(apart).unwrap()]);
        for pieces in &both {
            assert_eq!(connected(pieces).1.is_none(), joined, "{apart}");
        }
    }
    // Under load there are two waves of the same frequency, on both sides of a fold.
    let high = proved([&wave(["2.0104", "-0.1"], 0.35), &wave(["2.01041", "-0.1"], 0.352)]);
    let low = proved([&wave(["2.01041", "-0.1"], 0.163), &wave(["2.01042", "-0.1"], 0.162)]);
    assert_eq!((connected(&high).1, connected(&low).1), (None, None));
    let count = high.len();
    let (at, why) = connected(&[high, low].concat());
    assert!(at == count && matches!(why, Some(Gap::Apart(needed, unique)) if needed > 2.0 * unique), "{at} {why:?}");
}

// Truth: one harmonic has its fold at 2.01018, where -C_1 = a/n_1 is largest.
#[test]
fn a_fold_is_refused() {
    let strip = strip([&wave(["2.0103", "-0.1"], 0.315), &wave(["2.01", "-0.1"], 0.2)]);
    let (stop, why) = strip.stop.unwrap();
    let stop = stop.enclosed().mid();
    assert!(stop > 2.01015 && stop < 2.0103 && strip.pieces.len() > 3, "{stop} {why}");
    let (last, _) = strip.pieces.last().unwrap();
    assert_eq!(last.to.unwrap()[0].enclosed().mid(), stop);
    // A piece over the fold, about a wave beside it.
    let wave = solve::near(&wave(["2.0103", "-0.1"], 0.315), Sizes::WAVE_PIECE).unwrap();
    let piece = Certificate { to: Some([exact("2.01"), exact("-0.1")]), ..wave };
    assert!(matches!(check(&piece), Err(Refused::Bounds(_))));
}

/// A wave of mean strain -0.1 near this first harmonic, of which the frequency is near 2.0102.
fn of_first(a: &str) -> Certificate {
    Certificate { first: Some([exact(a); 2]), ..wave(["2.0102", "-0.1"], a.parse().unwrap()) }
}

// Truth: waves with more harmonics, and the least of their frequencies.
#[test]
fn a_branch_is_proved_past_its_fold() {
    let pieces = proved([&of_first("0.315"), &Certificate { mean: exact("-0.1002"), ..of_first("0.18") }]);
    assert!(pieces.len() > 3 && pieces.len() < 90, "{}", pieces.len());
    assert_eq!(connected(&pieces), (pieces.len(), None));
    let at = |a: f64, mean: f64| {
        let [a, mean] = [a, mean].map(|x| Exact::of_double(x).unwrap());
        let near = Certificate { first: Some([a; 2]), mean, ..of_first("0.24") };
        solve::near(&near, Sizes { block: 12, harmonics: 64, enclosed: 64 }).unwrap()
    };
    let better = |a: f64| at(a, -0.1 - 2e-4 * (0.315 - a) / 0.135);
    let omega = |it: &Certificate| it.model.omega.enclosed().mid();
    for (piece, proof) in pieces.iter().step_by(9) {
        let proof = proof.as_ref().unwrap();
        let [from, to] = piece.ends().map(|end| end[0].enclosed().mid());
        let middle = 0.5 * (omega(piece) + piece.to.unwrap()[0].enclosed().mid());
        for share in [0.0, 0.3, 1.0] {
            let better = better(from + share * (to - from));
            let apart = distance(piece, &better, &proof.weights[..1]);
            let turned = (omega(&better) - middle).abs() / proof.weights[1];
            assert!(apart < proof.radius && turned < proof.radius, "{share}: {apart:e} {turned:e} {proof:?}");
            let [lo, hi] = proof.frequency;
            assert!(lo < omega(&better) && omega(&better) < hi, "{share}: {lo} {hi} {better:?}");
            assert!(share == 0.3 || proof.radius < 6.0 * apart, "{share}: {apart:e} {proof:?}");
        }
    }
    // At one mean strain.
    let least = (0..=40).map(|i| omega(&at(0.22 + 1e-3 * f64::from(i), -0.1))).fold(f64::INFINITY, f64::min);
    let alike = proved([&of_first("0.315"), &of_first("0.18")]);
    let [[lo, hi]] = turns(&alike)[..] else { panic!("{:?}", turns(&alike)) };
    assert!(lo < least && least < hi && hi - lo < 1e-5, "{lo} {least} {hi}");
    // Pieces that go back, and such that vary the mean strain, show no fold of the branch.
    let back = |(piece, proof): &(Certificate, _)| {
        let [start, end] = [[piece.model.omega, piece.mean], piece.to.unwrap()];
        let piece = Certificate {
            model: Model { omega: end[0], ..piece.model },
            mean: end[1],
            to: Some(start),
            first: piece.first.map(|[start, end]| [end, start]),
            ..piece.clone()
        };
        (piece, Clone::clone(proof))
    };
    let there_and_back: Vec<_> = alike.iter().cloned().chain(alike.iter().rev().map(back)).collect();
    assert_eq!(connected(&there_and_back), (2 * alike.len(), None));
    assert!(turns(&there_and_back).is_empty() && turns(&pieces).is_empty());
    // The text, and what only one side of the fold has.
    let (piece, proof) = &pieces[0];
    assert_eq!(check_text(&piece.to_string()), *proof);
    let [waves, _, breathers, _] = branches();
    assert!(turns(&pieces[..2]).is_empty() && turns(&waves).is_empty());
    // Frequencies that the piece needs are left out; another first harmonic; no piece; a breather.
    let narrow = |share: f64| {
        let of = |x: f64| Exact::of_double(x).unwrap();
        let [lo, hi] = [omega(piece), piece.to.unwrap()[0].enclosed().mid()];
        let [middle, half] = [0.5 * (lo + hi), 0.5 * share * (hi - lo)];
        let model = Model { omega: of(middle - half), ..piece.model };
        Certificate { model, to: piece.to.map(|[_, mean]| [of(middle + half), mean]), ..piece.clone() }
    };
    assert!(check(&narrow(1.01)).is_ok() && matches!(check(&narrow(0.05)), Err(Refused::Bounds(_))));
    let moved = Certificate { first: Some([exact("0.3"), exact("0.299")]), ..piece.clone() };
    assert!(matches!(check(&moved), Err(Refused::Bounds(_))));
    for wrong in
        [Certificate { to: None, ..piece.clone() }, Certificate { first: piece.first, ..breathers[0].0.clone() }]
    {
        assert!(matches!(check(&wrong), Err(Refused::Certificate(rule)) if rule.contains("first harmonics")));
    }
    // The distance of frequencies counts where they are unknown.
    let mut moved = pieces[..2].to_vec();
    let shifted = |omega: Exact| Exact::of_double(omega.enclosed().mid() + 1e-3).unwrap();
    moved[1].0.model.omega = shifted(moved[1].0.model.omega);
    moved[1].0.to = moved[1].0.to.map(|[omega, mean]| [shifted(omega), mean]);
    assert!(matches!(connected(&moved), (1, Some(Gap::Apart(..)))));
    // Another parameter is another kind of piece.
    assert_eq!(connected(&[waves[0].clone(), pieces[0].clone()]).1, Some(Gap::Other));
    assert_eq!(connected(&[pieces[0].clone(), pieces[2].clone()]).1, Some(Gap::Nodes));
}

#[test]
fn pieces_are_read_one_by_one() {
    let [_, all, ..] = branches();
    let text: String = all.iter().map(|(piece, _)| piece.to_string()).collect();
    let read = pieces(&text).unwrap();
    assert!(read.iter().eq(all.iter().map(|(piece, _)| piece)));
    // The checker alone, from the text.
    let again: Pieces = read.into_iter().map(|piece| (piece.clone(), check(&piece))).collect();
    assert_eq!(again, all);
    assert!(pieces("").unwrap_err().contains("first line"));
    let line = text.lines().find(|line| line.starts_with("to ")).unwrap();
    assert!(pieces(&text.replacen(line, "to 2", 1)).unwrap_err().contains("is no frequency and mean strain"));
    let negative = text.replacen("to ", "to -", 1);
    let piece = pieces(&negative).unwrap().swap_remove(0);
    assert!(matches!(check(&piece), Err(Refused::Certificate(rule)) if rule.contains("omega must be above 0")));
}

// Resonances inside a piece, of the block and beyond the enclosed harmonics.
#[test]
fn a_resonance_within_a_piece_is_refused() {
    for ([from, to], k) in [(["1.9", "2.1"], 1), (["0.99", "1.01"], 2), (["2/49", "2/51"], 50)] {
        let mut piece = wave([from, "0"], 0.01);
        (piece.enclosed, piece.to) = (49, Some([exact(to), exact("0")]));
        let refused = check(&piece).unwrap_err();
        assert!(matches!(refused, Refused::Resonance(at) if at == k || k == 50 && at >= 49), "{k}: {refused}");
    }
}
