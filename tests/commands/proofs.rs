//! Proofs of existence on the command line.

use super::program::{command, hertzchain, json, printed};
use hertzchain_proofs::{
    certificate::{Certificate, Orbit},
    exact::Exact,
};
use serde_json::Value;
use std::{f64::consts::PI, fs};

/// The proof that a command prints as JSON before it fails with these words.
fn fails(line: &str, code: i32, words: &str) -> Value {
    let output = hertzchain(line);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(code) && said.contains(words), "{line}: {said}");
    serde_json::from_slice::<Value>(&output.stdout).unwrap_or_default()["proof"].clone()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// The largest distance of strains from their cosine sums.
fn distance(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    pairs.map(|(x, sum)| (x - sum).abs()).fold(0.0, f64::max)
}

/// Coefficients of `y` over those of `x` at a multiple of the frequency, for `kappa = 1`.
fn shared(rho: Exact, omega: f64) -> f64 {
    1.0 / (1.0 - rho.enclosed().mid() * omega * omega)
}

// Truth: the wave as an orbit, by shooting and contact collocation, which know no Fourier series.
fn waves_lie_in_the_ball(cases: &[(&str, usize)]) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("certificates/wave.cert");
    let file = file.to_str().unwrap();
    for &(options, cell) in cases {
        let found = json(&format!("wave exact {options} --sites 10 --prove --certificate {file}"));
        let (proof, amplitude) = (&found["proof"], number(&found["amplitude"]));
        let radius = number(&proof["radius"]);
        assert!(proof["proved"] == true && radius < 1e-10 * amplitude, "{options}: {proof}");
        assert!(number(&proof["uniqueness_radius"]) > 1e6 * radius && number(&proof["z1"]) < 0.2, "{options}: {proof}");
        assert!(proof["rounding"] == "outward" && number(&proof["y0"]) <= radius, "{options}: {proof}");
        let certificate: Certificate = fs::read_to_string(file).unwrap().parse().unwrap();
        assert!(certificate.is_wave(), "{certificate:?}");
        let q = PI * number(&found["q_over_pi"]);
        let mean = certificate.mean.enclosed().mid();
        let (omega, rho) = (certificate.model.omega.enclosed().mid(), certificate.model.rho);
        let resonators = |k: usize| rho.map_or(0.0, |rho| shared(rho, omega * k as f64));
        // Whether these are of resonators, and whether they are velocities.
        for (name, key, below, rate) in [
            ("x", "radius", false, false),
            ("y", "radius_y", true, false),
            ("vx", "radius_velocity", false, true),
            ("vy", "radius_velocity_y", true, true),
        ] {
            let sum = |n: usize| {
                let term = |(a, k): (&f64, usize)| {
                    // The angle of harmonic k, without whole turns of the cell.
                    let (sin, cos) = (q * (k * n % cell) as f64).sin_cos();
                    let factor = if below { resonators(k) } else { 1.0 };
                    a * factor * if rate { omega * k as f64 * sin } else { cos }
                };
                let middle = if rate { 0.0 } else { mean };
                middle + certificate.a[0].iter().zip(0..).map(term).sum::<f64>()
            };
            let values = found[name].as_array().unwrap();
            let apart = distance(values.iter().enumerate().map(|(n, x)| (number(x), sum(n))));
            let radius = number(&proof[key]);
            // Twice what was measured, 6e-15 of the amplitude, for the tolerance of the search.
            assert!(apart < radius + 2e-14 * amplitude, "{options} {name}: {apart:e}, {proof}");
        }
        // The perturbation that grows fastest is that of the tangent map.
        let grows = |one: &Value| number(&one["growth"]);
        let all = found["multipliers"].as_array().unwrap();
        let most = all.iter().map(grows).fold(0.0, f64::max);
        // Without resonators Z1 of the perturbations is 3.4.
        let proved = most > 0.0 && options != "--rho 0";
        assert_eq!(proved, proof["bloch"].is_object(), "{options}: {proof}");
        if proved {
            let bounds = |key: &str| [0, 1].map(|end| number(&proof["bloch"][key][end]));
            let within = |one: &Value| {
                ["growth", "frequency"].iter().all(|key| {
                    let ([from, to], x) = (bounds(key), number(&one[*key]));
                    from < x && x < to && to - from < 1e-6
                })
            };
            let p: Exact = proof["bloch"]["p_over_pi"].as_str().unwrap().parse().unwrap();
            let same = |one: &&Value| (number(&one["bloch"]) - PI * p.enclosed().mid()).abs() < 1e-9 && within(one);
            assert_eq!(all.iter().find(same).map(grows), Some(most), "{options}: {proof}");
        }
        // The same from nothing but the certificate.
        assert_eq!(json(&format!("prove {file}"))["proof"], *proof, "{options}");
    }
}

#[test]
fn exact_waves_are_proved_and_lie_in_the_ball() {
    waves_lie_in_the_ball(&[("tw-q15", 10), ("tw-q45", 5), ("--rho inf --q-over-pi 0.8", 5)]);
}

// The frequency is low, and l_k = 4 sin^2(k q/2)/(omega k)^2 large.
#[test]
#[ignore = "nightly: ten seconds"]
fn a_wave_without_resonators_is_proved_and_lies_in_the_ball() {
    waves_lie_in_the_ball(&[("--rho 0", 10)]);
}

// Truth: the multipliers of the ring, eigenvalues of the tangent map.
fn perturbations_grow_as_on_the_ring(scene: &str, [from, to]: [&str; 2], at_least: usize) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wave.cert");
    let path = file.to_str().unwrap();
    let found = json(&format!("wave exact {scene} --prove --modulation {from},{to} --certificate {path}"));
    let (proof, bloch) = (&found["proof"], &found["proof"]["bloch"]);
    let certificate: Certificate = fs::read_to_string(path).unwrap().parse().unwrap();
    let pieces = &certificate.bloch;
    assert!(proof["proved"] == true && bloch["pieces"] == pieces.len(), "{proof}");
    let ends = [pieces[0].p_over_pi[0], pieces[pieces.len() - 1].p_over_pi[1]];
    assert_eq!(bloch["p_over_pi"], serde_json::json!(ends.map(|p| p.to_string())), "{proof}");
    let double = |x: Exact| x.enclosed().mid();
    assert_eq!(ends.map(double), [from, to].map(|p| p.parse::<f64>().unwrap()));
    let (mut within, mut most) = (0, 0.0_f64);
    for one in found["multipliers"].as_array().unwrap() {
        let (p, growth, frequency) = (number(&one["bloch"]) / PI, number(&one["growth"]), number(&one["frequency"]));
        for piece in pieces.iter().filter(|_| growth > 0.0) {
            let [from, to] = piece.p_over_pi.map(double);
            let s = (2.0 * p - from - to) / (to - from);
            let near = [0, 1].map(|i| double(piece.rate[i]) + s * double(piece.change[i]));
            let apart = (growth - near[0]).hypot(frequency - near[1]);
            // The tangent map is this exact.
            if s.abs() < 1.0 + 1e-9 && apart < double(piece.radius) + 1e-9 {
                (within, most) = (within + 1, most.max(growth));
            }
        }
    }
    let [growth, largest] = ["growth", "largest_growth"].map(|key| [0, 1].map(|end| number(&bloch[key][end])));
    assert!(within >= at_least && growth[1] == largest[1] && most < largest[1], "{within} {most}: {bloch}");
    assert!(largest[1] - largest[0] < 1e-3 * largest[1], "{bloch}");
    assert_eq!(json(&format!("prove {path}"))["proof"], *proof, "{scene}");
}

#[test]
fn perturbations_grow_at_modulations_near_the_fastest() {
    perturbations_grow_as_on_the_ring("tw-q15 --sites 100", ["0.98", "1"], 2);
    // Below the interval of growth nothing grows, and no certificate claims it.
    let proof =
        fails("wave exact tw-q15 --sites 100 --prove --modulation 0.1,0.2 --json", 1, "is not proved for every Bloch");
    assert!(proof["bloch"].is_null(), "{proof}");
    fails("wave exact tw-q15 --prove --modulation 0.3", 2, "two numbers, the first one below the second");
}

#[test]
#[ignore = "nightly: ten minutes"]
fn perturbations_grow_at_all_modulations() {
    perturbations_grow_as_on_the_ring("tw-q15", ["0.21", "1"], 20);
    perturbations_grow_as_on_the_ring("tw-breakdown-q15", ["0.21", "1"], 15);
}

#[test]
fn what_is_not_proved_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wave.cert");
    let path = file.to_str().unwrap();
    json(&format!("wave exact tw-q15 --sites 10 --prove --certificate {path}"));
    let text = fs::read_to_string(&file).unwrap();
    let mut moved: Certificate = text.parse().unwrap();
    moved.a[0][1] *= 1.05;
    fs::write(&file, moved.to_string()).unwrap();
    let proof = fails(&format!("prove {path} --json"), 1, "error: not proved: Y0 = ");
    assert!(proof["proved"] == false && proof["radius"].is_null() && number(&proof["y0"]) > 1e-3, "{proof}");
    // A frequency whose double is the free frequency of the resonators against the beads.
    fs::write(&file, text.replace("omega 2001/1000", "omega 2/3")).unwrap();
    fails(&format!("prove {path}"), 1, "harmonic 3 is not separated");
    for (from, to, words) in [
        ("kappa 1", "kappa one", "\"one\" is no fraction"),
        ("alpha 3/2", "alpha 1/2", "alpha must be above 1"),
        ("hertzchain certificate 2", "", "its first line is not"),
    ] {
        fs::write(&file, text.replacen(from, to, 1)).unwrap();
        fails(&format!("prove {path}"), 2, words);
    }
    // Waves that are no pieces of one branch.
    fs::write(&file, text.repeat(2)).unwrap();
    fails(&format!("prove {path}"), 2, "each is a piece of a branch");
    // The far end of the ring is too near for its strains to be those of a standing wave.
    let short = "breather dark --sites 9 --center bond --omega-b 2.05 --infinite --prove";
    fails(short, 1, "the ring may be too short: --sites");
}

/// Whether an orbit at rest is within the radii of the cosine sums, of which the first one is that
/// of this entry of the ring.
fn start_lies_in_the_ball(found: &Value, proof: &Value, near: &Certificate, first: usize) {
    let (omega, rho) = (near.model.omega.enclosed().mid(), near.model.rho.unwrap());
    let (sites, amplitude) = (found["x"].as_array().unwrap().len(), number(&found["k_x"]));
    for (name, radius) in [("x", "radius"), ("y", "radius_y")] {
        let factor = |k: usize| if name == "x" { 1.0 } else { shared(rho, omega * k as f64) };
        let sum = |a: &Vec<f64>| a.iter().enumerate().map(|(k, a)| factor(k) * a).sum::<f64>();
        let at = |i: usize| number(&found[name][(first + i) % sites]);
        let apart = distance(near.a.iter().enumerate().map(|(i, a)| (at(i), sum(a))));
        assert!(apart < number(&proof[radius]) + 1e-12 * amplitude, "{name}: {apart:e}, {proof}");
    }
}

// Truth: waves by shooting, and the solution of the DpS equation: its first harmonic by bisection
// of the balance of one harmonic, at the frequencies at which this has the first harmonics `eps`.
fn waves_lie_down_to_amplitude_zero(cases: &[(&str, f64)]) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zero.cert");
    let path = file.to_str().unwrap();
    for (options, omega) in cases {
        let options = format!("wave exact {options} --sites 10");
        let proof = &json(&format!("{options} --omega-tw {omega} --prove --to-zero --certificate {path}"))["proof"];
        let [radius, constant, known] =
            [&proof["radius"], &proof["zero"]["constant"], &proof["zero"]["epsilon"]].map(number);
        let mu = [0, 1].map(|end| number(&proof["zero"]["mu"][end]));
        assert!(proof["proved"] == true && proof["to"].is_null() && known > 1e-3, "{options}: {proof}");
        assert_eq!(json(&format!("prove {path}"))["proof"], *proof, "{options}");
        let certificate: Certificate = fs::read_to_string(&file).unwrap().parse().unwrap();
        let (Orbit::Wave { q_over_pi }, [a]) = (&certificate.orbit, &certificate.a[..]) else {
            panic!("{certificate:?}")
        };
        let [mean, q] = [certificate.mean, *q_over_pi].map(|it| it.enclosed().mid());
        // -1/L_1 by the square of the frequency.
        let [other, own, free] = certificate.model.rho.map_or([0.0, 1.0, 1.0], |rho| {
            let rho = rho.enclosed().mid();
            [1.0 / (1.0 + rho), rho / (1.0 + rho), 1.0 + 1.0 / rho]
        });
        let inverse = other / (omega * omega) + own / (omega * omega - free);
        let force = |b: f64| -> f64 {
            let angle = |i: u32| (PI * (f64::from(i) + 0.5) / 4096.0).cos();
            (0..4096).map(|i| (-mean - b * angle(i)).max(0.0).powf(1.5) * angle(i)).sum::<f64>() / 2048.0
        };
        let strength = 4.0 * (0.5 * PI * q).sin().powi(2) * inverse;
        let halved = |[lo, hi]: [f64; 2]| {
            let middle = 0.5 * (lo + hi);
            if middle + strength * force(middle) > 0.0 { [middle, hi] } else { [lo, middle] }
        };
        let first = (0..50).fold([0.5 * a[1], 2.0 * a[1]], |ends, _| halved(ends))[0];
        assert!(known < first && first < 1.02 * known, "{options}: {first} {proof}");
        for eps in [0.999 * known, 1e-4, 1e-6] {
            let share = (eps / first).sqrt();
            let above = (0..50).fold(0.0, |above, _| own / (inverse / share - other / (free + above)));
            let [omega, mean] = [(free + above).sqrt(), share * share * mean];
            let found = json(&format!("{options} --omega-tw {omega} --mean {mean}"));
            let all: Vec<f64> = found["fourier"].as_array().unwrap().iter().map(number).collect();
            let apart = |k: usize| all[k] / (share * share) - a.get(k).unwrap_or(&0.0);
            assert!((1..all.len()).map(|k| apart(k).abs()).sum::<f64>() < radius, "{options} {eps}: {proof}");
            let at = |angle: f64| (1..all.len()).map(|k| all[k] * (k as f64 * angle).cos()).sum::<f64>();
            let angles = (0..64).map(|i| PI * f64::from(i) / 32.0);
            let ratio = distance(angles.map(|angle| (at(angle), eps * angle.cos()))) / eps.powf(1.5);
            // Measured: C is 1.3 to 2.1 times as much.
            assert!(ratio < constant && constant < 3.0 * ratio, "{options} {eps}: {ratio} {proof}");
            let own = above / eps.sqrt();
            assert!(mu[0] < own && own < mu[1] && mu[1] - mu[0] < 0.02 * own, "{options} {eps}: {own} {proof}");
        }
    }
}

#[test]
fn waves_are_proved_down_to_amplitude_zero() {
    waves_lie_down_to_amplitude_zero(&[("tw-q15", 2.001)]);
}

// Branches, of waves from the scene in which the ansatz fails; breathers at their nodes by
// shooting.
#[test]
#[ignore = "nightly: two minutes"]
fn other_solutions_are_proved_down_to_amplitude_zero() {
    let cases = [("--q-over-pi 0.8", 2.001), ("tw-rho3", 1.15687)];
    waves_lie_down_to_amplitude_zero(&cases);
    waves_lie_down_to_amplitude_zero(&[("--rho inf --q-over-pi 0.2", 1.003)]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zero.cert");
    let path = file.to_str().unwrap();
    for line in [
        "wave continue tw-q15 --omega-tw 2.00013 --to 2.003 --multipliers=false",
        "breather continue --center bond --from 2.005 --to 2.0055",
        "breather continue --center site --from 2.004 --to 2.0043",
    ] {
        let proof = &json(&format!("{line} --prove --to-zero --certificate {path}"))["proof"];
        assert!(proof["proved"] == true && number(&proof["zero"]["epsilon"]) > 1e-3, "{proof}");
        assert_eq!(json(&format!("prove {path}"))["proof"], *proof, "{line}");
    }
    for center in ["site", "bond"] {
        let line = format!("breather dark --center {center} --omega-b 2.004 --prove --to-zero --certificate {path}");
        let found = json(&line);
        let certificate: Certificate = fs::read_to_string(&file).unwrap().parse().unwrap();
        let at = |i: usize| number(&found["x"][(20 + usize::from(center == "bond") + i) % 41]);
        let rows = certificate.a.iter().enumerate();
        let apart = distance(rows.map(|(i, a)| (at(i), a.iter().sum())));
        assert!(apart < number(&found["proof"]["radius"]), "{center}: {apart:e} {}", found["proof"]);
    }
    fails("breather dark --center bond --omega-b 2.05 --prove --to-zero", 1, "not proved: Y0 = ");
    fails("wave exact --rho 0 --sites 10 --prove --to-zero", 1, "rho must be above 0");
}

// Truth: the orbit of doubled period by shooting, and its tangent map.
#[test]
#[ignore = "nightly: a minute"]
fn a_breather_of_doubled_period_is_proved_and_lies_in_the_ball() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("doubled.cert");
    let path = file.to_str().unwrap();
    let line = "breather doubled --sites 21 --step 0.02 --most 2.066 --omega-b 1.034 --prove";
    let found = json(&format!("{line} --certificate {path} --out {}", folder.path().display()));
    let (orbit, proof) = (&found["orbit"], &found["proof"]);
    assert!(proof["proved"] == true && number(&proof["radius"]) < 1e-8 * number(&orbit["k_x"]), "{proof}");
    let real = orbit["multipliers"].as_array().unwrap().iter().find(|one| one["kind"] == "real").unwrap();
    let [from, to] = [0, 1].map(|end| number(&proof["multiplier"][end]));
    assert!(from < number(&real["re"]) && number(&real["re"]) < to && to - from < 1e-6, "{proof} {real}");
    let certificate: Certificate = fs::read_to_string(&file).unwrap().parse().unwrap();
    assert!(!certificate.is_wave(), "{certificate:?}");
    // About the far site, which is the first entry.
    start_lies_in_the_ball(orbit, proof, &certificate, 0);
    let again = json(&format!("prove {path}"));
    assert!(again["proof"] == *proof && again["solution"].as_str().unwrap().contains("about a site"));
    // The branch, from its end to near the period doubling.
    let line = format!("breather continue --resume {} --multipliers=false --prove --json", folder.path().display());
    let proof = fails(&line, 1, "proved up to the frequency 1.032");
    assert!(number(&proof["from"]) == 1.034 && number(&proof["to"]) < 1.0325, "{proof}");
}

// Truth: the orbit by shooting. The ends of the ring are 20 sites from its kink, at which the
// strains of the infinite chain are those of the standing wave to all digits.
#[test]
fn dark_breathers_are_proved_and_lie_in_the_ball() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("breather.cert");
    let path = file.to_str().unwrap();
    for options in [
        "--center bond --omega-b 2.05",
        "--center site --rho 3 --omega-b 1.2547",
        "--center site --omega-b 2.05 --infinite",
    ] {
        let found = json(&format!("breather dark {options} --prove --certificate {path}"));
        let (proof, amplitude) = (&found["proof"], number(&found["k_x"]));
        let radius = number(&proof["radius"]);
        assert!(proof["proved"] == true && radius < 1e-9 * amplitude, "{options}: {proof}");
        // The largest real multiplier is that of the tangent map.
        let real = found["multipliers"].as_array().unwrap().iter().find(|one| one["kind"] == "real");
        let bounds = proof["multiplier"].as_array().map(|ends| [number(&ends[0]), number(&ends[1])]);
        assert_eq!(bounds.is_some(), options.contains("bond"), "{options}: {proof}");
        if let Some(([from, to], real)) = bounds.zip(real) {
            let real = number(&real["re"]);
            assert!(1.0 < from && from < real && real < to && to - from < 1e-6, "{options}: {proof} {real}");
        }
        let certificate: Certificate = fs::read_to_string(&file).unwrap().parse().unwrap();
        let decay = ["decay", "decay_constant"].map(|key| number(&proof[key]));
        // Half of the rate that is seen, 3.26.
        let known = decay[0] > 1.5 && decay[0] < 1.7 && decay[1] < 10.0 * amplitude;
        assert!(if options.contains("infinite") { known } else { decay[0].is_nan() }, "{options}: {proof}");
        start_lies_in_the_ball(&found, proof, &certificate, 20 + usize::from(options.contains("bond")));
        assert_eq!(json(&format!("prove {path}"))["proof"], *proof, "{options}");
        // A multiplier that it does not have: the breather is proved all the same.
        let text = fs::read_to_string(&file).unwrap();
        let Some(line) = text.lines().find(|line| line.starts_with("multiplier")) else { continue };
        fs::write(&file, text.replace(line, "multiplier growing 1/1000 1/500")).unwrap();
        let other = fails(&format!("prove {path} --json"), 1, "not proved: the multiplier: ");
        assert!(other["radius"] == proof["radius"] && other["multiplier"].is_null(), "{other}");
        let reason = other["reason"].as_str().unwrap_or_default();
        assert!(other["proved"] == false && reason.starts_with("not proved: the multiplier: "), "{other}");
    }
}

/// The check of a line of a store: FNV-1a, from the check of what is before it.
fn fnv(basis: u64, text: &str) -> u64 {
    text.bytes().fold(basis, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

// Truth: the waves of the branch by shooting, at the nodes.
#[test]
fn branches_are_proved_without_a_gap() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("branch.cert");
    let path = file.to_str().unwrap();
    let line = "wave continue --sites 10 --to 2.00102 --step 1e-5 --multipliers=false --prove --certificate";
    let found = json(&format!("{line} {path}"));
    let (proof, points) = (&found["proof"], found["points"].as_array().map_or(0, Vec::len));
    let count = proof["pieces"].as_u64().unwrap_or(0) as usize;
    assert!(proof["proved"] == true && count >= points.max(2), "{proof}");
    assert!(number(&proof["from"]) == 2.001 && number(&proof["to"]) == 2.00102, "{proof}");
    // Balls are at most a third as wide as those of uniqueness.
    assert!(number(&proof["radius"]) < 0.5 * number(&proof["uniqueness_radius"]), "{proof}");
    assert_eq!(json(&format!("prove {path}"))["proof"], *proof);
    let text = fs::read_to_string(&file).unwrap();
    // On one thread, and again with one of the two strips in the store, it has the same bits.
    let out = folder.path().join("branch");
    let store = out.join("proof.store");
    let mut lines = Vec::new();
    for _ in 0..2 {
        fs::remove_file(&file).unwrap();
        let mut again = command(&format!("{line} {path} --json --out {}", out.display()));
        let again: Value =
            serde_json::from_str(&printed(again.env("RAYON_NUM_THREADS", "1").output().unwrap())).unwrap();
        assert!(again["proof"] == *proof && fs::read_to_string(&file).unwrap() == text, "{again}");
        let all = fs::read_to_string(&store).unwrap();
        assert!(all.lines().count() == 3 && lines.iter().all(|line: &String| all.contains(line)), "{all}");
        lines = all.lines().take(2).map(|line| format!("{line}\n")).collect();
        fs::write(&store, lines.concat()).unwrap();
    }
    // A strip of the store that is not whole, of another chain, or without a proof, is proved anew;
    // what the store tells of its proof is not believed.
    let kept = fs::read_to_string(&store).unwrap();
    let [head, row] = [0, 1].map(|k| kept.lines().nth(k).unwrap().split_once(' ').unwrap().1);
    let (pieces, told) = row.split_at(row.find("\",[[").unwrap());
    let short = format!("{}{told}", &pieces[..pieces.rfind("hertzchain certificate").unwrap()]);
    let far = row.replacen("na 3f", "na 3e", 1);
    let mut wider: Value = serde_json::from_str(row).unwrap();
    for told in wider["row"]["value"][1].as_array_mut().unwrap() {
        told[0] = (1.2 * number(&told[0])).into();
    }
    let mut before = None;
    for row in [row, &short, &row.replace("alpha 3/2", "alpha 8/5"), &far, &wider.to_string()] {
        let check = fnv(fnv(0xcbf2_9ce4_8422_2325, head), row);
        fs::write(&store, format!("{}\n{check:016x} {row}\n", kept.lines().next().unwrap())).unwrap();
        fs::remove_file(&file).unwrap();
        let words = printed(hertzchain(&format!("{line} {path} --out {}", out.display())));
        assert!(words.contains("1 of 2 strips were in proof.store") && words.contains("Proved: one curve"), "{words}");
        assert_eq!(fs::read_to_string(&file).unwrap(), text, "{row}");
        let proved = words.split_once("Proved:").map(|(_, proved)| proved.to_owned());
        assert!(before.is_none() || before == proved, "{row}: {words}");
        before = proved;
    }
    let mut pieces = hertzchain_proofs::certificate::pieces(&text).unwrap();
    assert_eq!(pieces.len(), count);
    pieces.remove(1);
    fs::write(&file, pieces.iter().map(ToString::to_string).collect::<String>()).unwrap();
    let words = "piece 2: it does not begin where the piece before it ends";
    let proof = fails(&format!("prove {path} --json"), 1, words);
    assert!(proof["proved"] == false && proof["pieces"] == 1, "{proof}");
    // The head is that of the pieces before one of another chain.
    pieces.truncate(2);
    pieces[1].model.alpha = Exact::new(8, 5).unwrap();
    fs::write(&file, format!("{}{}", pieces[0], pieces[1])).unwrap();
    let output = hertzchain(&format!("prove {path}"));
    let words = String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    let [from, to] = pieces[0].ends().map(|end| end[0]);
    assert!(words.contains(&format!("frequency {from} to {to}, mean")) && words.contains("in 1 piece;"), "{words}");
    let up_to = format!("proved up to the frequency {}: piece 2: ", proof["to"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains(&up_to), "{up_to}");
}

// Truth: the waves of the branch by shooting. By the parabola through the one of least frequency
// and its neighbours, its fold.
#[test]
fn a_branch_of_waves_is_proved_past_its_fold() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("fold.cert");
    let path = file.to_str().unwrap();
    let line = "wave continue --sites 10 --mean -0.05 --amplitude 0.125 --to 2.0071 --step 4e-5 --multipliers=false";
    let found = json(&format!("{line} --prove --certificate {path}"));
    let proof = &found["proof"];
    assert!(proof["proved"] == true && proof["parameter"] == "first harmonic", "{proof}");
    let points = found["waves"].as_array().unwrap();
    let [omega, a] =
        ["omega_tw", "amplitude"].map(|key| points.iter().map(|one| number(&one[key])).collect::<Vec<_>>());
    let least = (1..points.len() - 1).min_by(|i, j| omega[*i].total_cmp(&omega[*j])).unwrap();
    let [x, y] = [&a, &omega].map(|all| [0, 1, 2].map(|i| all[least - 1 + i]));
    let slope = |i: usize, j: usize| (y[j] - y[i]) / (x[j] - x[i]);
    let bend = (slope(1, 2) - slope(0, 1)) / (x[2] - x[0]);
    let at = 0.5 * (x[0] + x[1] - slope(0, 1) / bend);
    let fold = y[0] + slope(0, 1) * (at - x[0]) + bend * (at - x[0]) * (at - x[1]);
    let [from, to] = [0, 1].map(|end| number(&proof["turns_back"][0][end]));
    // Twice what was measured.
    assert!(from < fold && fold < to && to - from < 5e-7, "{proof} {fold}");
    assert_eq!(json(&format!("prove {path}"))["proof"], *proof);
}

// Truth: the bifurcation of the branch by shooting, from a change of sign of the multipliers.
#[test]
#[ignore = "nightly: half a minute"]
fn a_period_doubling_is_proved() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("doubling.cert");
    let path = file.to_str().unwrap();
    let line = "breather continue --center bond --from 2.0632 --to 2.0633 --step 1e-4 --bifurcations --prove";
    let found = json(&format!("{line} --certificate {path}"));
    let (proof, at) = (&found["proof"], number(&found["bifurcations"][0]["parameter"]));
    let [from, to] = [0, 1].map(|end| number(&proof["period_doublings"][0][end]));
    assert!(proof["proved"] == true && from < at && at < to && to - from < 1e-6, "{proof} {at}");
    // Perturbations by sines have the multiplier -1 there, those by cosines do not.
    let text = fs::read_to_string(&file).unwrap();
    let (is, other) = if text.contains("-1 sine") { ("-1 sine", "-1 cosine") } else { ("-1 cosine", "-1 sine") };
    fs::write(&file, text.replace(is, other)).unwrap();
    let proof = fails(&format!("prove {path} --json"), 1, "have a line for -1, along which g does not change");
    assert!(proof["proved"] == false && proof["reason"].as_str().unwrap().contains("have a line for -1"), "{proof}");
}

#[test]
#[cfg(unix)]
fn a_pipe_is_no_certificate() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    fails(&format!("prove {}", pipe.display()), 2, "it is no file");
}
