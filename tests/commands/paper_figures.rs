//! `hertzchain paper figures`: every file is there, the numbers are those of `wave`, and one
//! failure does not cost the others.

use super::program::{self, json, names, read_json, stdout};
use hertzchain::{
    breathers::DarkBreather,
    chain::Params,
    dps::Center,
    orbits::{Orbit, Pick, Shooting},
    paper::orbits,
    report::Report,
    study::evolve,
};
use serde_json::Value;
use std::{collections::BTreeSet, path::Path, process::Command};

fn figures(only: &str, out: &Path) -> Value {
    json(&["paper", "figures", "--only", only, "--out", out.to_str().unwrap()])
}

#[test]
fn figures_have_the_same_bytes_twice_in_the_order_of_the_paper() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    // Asked for out of order: drawn in the order of the paper.
    let runs = folders.each_ref().map(|folder| figures("tw-breakdown, tw-q15", folder.path()));
    let drawn = runs[0]["figures"].as_array().unwrap();
    let order: Vec<&str> = drawn.iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(order, ["tw-q15", "tw-breakdown"]);
    let [one, other] = folders.each_ref().map(|folder| folder.path());
    let listed = drawn.iter().flat_map(|one| one["files"].as_array().unwrap());
    let listed: BTreeSet<String> = listed.map(|name| name.as_str().unwrap().to_owned()).collect();
    assert!(names(one) == listed && names(other) == listed && listed.contains("tw-breakdown-q45-summary.csv"));
    for name in listed {
        let [first, second] = [one, other].map(|folder| std::fs::read(folder.join(&name)).unwrap());
        assert!(first == second, "{name} differs");
    }
    let origin = read_json(&one.join("tw-q15.json"));
    assert!(origin["version"] == env!("CARGO_PKG_VERSION") && origin["caption"] == drawn[0]["caption"], "{origin}");
    let caption = drawn[0]["caption"].as_str().unwrap();
    for told in ["N = 50", "ρ = 1/3", "q = π/5", "b = 1", "collocation, tol 1e-10", "Sec. 4.1"] {
        assert!(caption.contains(told), "{told}: {caption}");
    }
}

// Truth: the command `wave`, and the definition of tilde E from the two profiles.
#[test]
fn the_numbers_of_a_perturbed_figure_are_those_of_wave() {
    let folder = tempfile::tempdir().unwrap();
    figures("tw-rho3", folder.path());
    let wave = json("wave tw-rho3 --zeta 0.01 --seed 1");
    let rows = |table: &str| read(folder.path(), &format!("tw-rho3-{table}.csv")).1;

    let errors = rows("errors");
    assert_eq!(errors.len() as u64, wave["samples"].as_u64().unwrap());
    let last = errors.last().unwrap();
    let of = |value: &Value, name: &str| value[name].as_f64().unwrap();
    let perturbed = &wave["perturbed"];
    let truth = [
        of(&wave, "t"),
        of(&wave, "e_x_final"),
        of(&wave, "e_y_final"),
        of(perturbed, "e_x_final"),
        of(perturbed, "e_y_final"),
        of(perturbed, "tilde_e_x_final"),
        of(perturbed, "tilde_e_y_final"),
    ];
    // Equal but for the rounding of who reads it.
    assert!(last.iter().zip(truth).all(|(a, b)| (a / b - 1.0).abs() < 1e-15), "{last:?} is not {truth:?}");

    let profile = rows("profile");
    assert_eq!(profile.len(), 50);
    // 2 epsilon kappa a = 0.02, rho = 3.
    let distance = |one: usize, other: usize, scale: f64| {
        scale * profile.iter().map(|row| (row[one] - row[other]).abs()).fold(0.0, f64::max) / 0.02
    };
    for (value, truth) in [
        (distance(1, 3, 1.0), last[1]),
        (distance(2, 4, 3.0), last[2]),
        (distance(5, 7, 1.0), last[3]),
        (distance(6, 8, 3.0), last[4]),
        (distance(5, 1, 1.0), last[5]),
        (distance(6, 2, 3.0), last[6]),
    ] {
        assert!((value / truth - 1.0).abs() < 1e-12, "{value} is not {truth}");
    }

    // Every seed from 1 on, the one shown among them: it lies within the range at each time.
    let spread = rows("spread");
    assert_eq!((spread.len(), rows("ensemble").len()), (errors.len(), 12));
    assert!(errors.iter().zip(&spread).all(|(at, range)| range[1] <= at[5] && at[5] <= range[5]));
}

// Truth: the command `dps dark`, at c = 0 with 41 sites.
#[test]
fn the_dark_profiles_are_those_of_dps_dark() {
    let (folder, captions) = drawn("dark-profiles");
    for told in ["α = 1.5", "κ = 1", "N = 41", "background is ±0.1492", "Sec. 6", "K_x = 0.149645, K_y = 0.372598"] {
        assert!(captions[0].contains(told), "{told}: {}", captions[0]);
    }
    for center in ["site", "bond"] {
        let dark = json(&["dps", "dark", "--center", center]);
        let (_, rows) = read(folder.path(), &format!("dark-profiles-dps-{center}-dark.csv"));
        assert_eq!(rows.len(), 41);
        for (k, row) in rows.into_iter().enumerate() {
            for (value, name) in row.into_iter().zip(["n", "a", "b"]) {
                let truth = dark[name][k].as_f64().unwrap();
                assert!((value - truth).abs() <= 2.0 * f64::EPSILON * truth.abs(), "{center} {name} {k}");
            }
        }
    }
    // The exact profiles are those of `breather dark`, and come back.
    let (_, bond) = read(folder.path(), "dark-profiles-bond-profile.csv");
    let dark = json("breather dark --center bond --rho 0.3333333333333333 --omega-b 2.05");
    for (i, row) in bond.iter().enumerate() {
        assert_eq!((row[1], row[2]), (dark["x"][i].as_f64().unwrap(), dark["y"][i].as_f64().unwrap()));
        assert!((row[3] - row[1]).abs() < 1e-15 && (row[4] - row[2]).abs() < 1e-15, "{row:?}");
    }
    // (eq:xy_sw) where the mean strain is c = 0: x = -rho y; too high by what the figure says.
    let [.., x, y] = bond[0][..] else { panic!() };
    assert!((x + y / 3.0).abs() < 1e-15, "{x} {y}");
    assert!((1.2..1.35).contains(&(x / bond[0][1])) && (1.45..1.6).contains(&(y / bond[0][2])), "{x} {y}");
}

/// Draws figures and returns their folder and their captions.
fn drawn(only: &str) -> (tempfile::TempDir, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let study = figures(only, folder.path());
    let captions = study["figures"].as_array().unwrap().iter();
    (folder, captions.map(|one| one["caption"].as_str().unwrap().to_owned()).collect())
}

/// The header of a table and its rows.
fn read(folder: &Path, name: &str) -> (String, Vec<Vec<f64>>) {
    program::table(&folder.join(name))
}

/// `b_n` of `tests/reference/homoclinic.csv` at `alpha = 3/2`: shooting with 1000 digits.
fn reference(center: &str) -> Vec<(i64, f64)> {
    let table = include_str!("../reference/homoclinic.csv").lines().skip(1);
    let cells = table.map(|line| line.split(',').collect::<Vec<_>>());
    let mine = cells.filter(|cells| cells[0].parse() == Ok(1.5) && cells[1] == center);
    mine.map(|cells| (cells[2].parse().unwrap(), cells[3].parse().unwrap())).collect()
}

// Truth: the numbers that Sec. 5 quotes, the homoclinic from shooting with 1000 digits; norms as
// two methods agree on them in tests/experiments/breathers.rs.
#[test]
fn the_long_lived_breather_has_the_numbers_of_the_paper() {
    let (folder, captions) = drawn("long-lived-breather");
    for told in ["N = 40", "ρ = 1000", "ε = 0.01", "T_b = 6.0862", "T = 2π/ω₀ = 19.4158", "T ε^(1−α) = 194.158"]
    {
        assert!(captions[0].contains(told), "{told}: {}", captions[0]);
    }
    let (_, periods) = read(folder.path(), "long-lived-breather-periods.csv");
    // 80 T are 255.2 periods.
    assert_eq!((periods.len(), format!("{:.4}", periods[1][0])), (256, "6.0862".to_owned()));
    let at_30: Vec<String> = periods[30][1..5].iter().map(|norm| format!("{norm:.8}")).collect();
    assert_eq!(at_30, ["1.02785521", "0.89666508", "0.69036562", "0.07529224"]);

    let (_, profiles) = read(folder.path(), "long-lived-breather-profiles.csv");
    assert_eq!(profiles.len(), 120);
    assert_eq!([0, 40, 80].map(|k| format!("{:.2}", profiles[k][0])), ["0.00", "182.59", "1553.27"]);
    // a^2_1 is at site 20. The state at 0 is one of the dense output: v = 0 up to rounding.
    for (n, b) in reference("bond").into_iter().take(8) {
        let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
        let (u, v) = (profiles[19 + n as usize][2], profiles[19 + n as usize][3]);
        assert!((u - 0.02 * sign * b).abs() <= 4e-16 * u.abs() && v.abs() <= 4e-16 * u.abs(), "{n}: {u}");
    }
}

// Truth: the symmetry about the bond, and the long-lived breather of the command `breather bright`,
// whose v at the end is no more than half a period of drift from the mean: v' is at most epsilon^2
// E_v', that is 1.3e-5. At first the swing is that of the ansatz, 2 epsilon a^2. Measured: 2.4 %
// off in the first period, at the outer sites.
#[test]
fn the_bright_breather_over_space_and_time_is_that_of_breather_bright() {
    let (folder, _) = drawn("bright-breather-spacetime");
    let (head, swing) = read(folder.path(), "bright-breather-spacetime-swing.csv");
    let (_, v) = read(folder.path(), "bright-breather-spacetime-v.csv");
    assert!(head.starts_with("t,swing_0,swing_1,") && head.ends_with(",swing_39"), "{head}");
    assert_eq!((swing.len(), v.len(), swing[0].len()), (255, 255, 41));
    for (n, b) in reference("bond").into_iter().take(3) {
        let relative = swing[0][20 + n as usize] / (0.02 * b) - 1.0;
        println!("{n}: {relative:e}");
        assert!(relative.abs() < 0.05, "{n}: {relative:e}");
    }
    for (swing, v) in swing.iter().zip(&v) {
        for n in 1..=20 {
            assert!((swing[n] - swing[41 - n]).abs() < 1e-15 && (v[n] + v[41 - n]).abs() < 1e-15, "{n}");
        }
    }
    let bright = json("breather bright");
    let end = &bright["profiles"].as_array().unwrap().last().unwrap()["v"];
    let apart = |n: usize| (v[254][n + 1] - end[n].as_f64().unwrap()).abs();
    let worst = (0..40).map(apart).fold(0.0, f64::max);
    println!("{worst:e}");
    // Half a period, and the 0.2 periods that are left after the last: at most 5.5e-5. Measured:
    // 5.1e-6.
    assert!(worst < 1e-5, "{worst:e}");
}

/// A table of a report.
fn table(report: &Report, name: &str) -> Vec<Vec<f64>> {
    let csv = report.csv().find(|(file, _)| *file == format!("{name}.csv")).unwrap().1;
    let lines = String::from_utf8(csv).unwrap();
    let numbers = |line: &str| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
    lines.lines().skip(1).map(numbers).collect()
}

/// The last orbit of the branch of a report, to the bit.
fn last(report: &Report) -> Orbit {
    let folder = tempfile::tempdir().unwrap();
    let (name, npz) = report.files().unwrap().into_iter().find(|one| one.0 == "branch.npz").unwrap();
    let file = folder.path().join(name);
    std::fs::write(&file, npz).unwrap();
    Orbit::load(&file, Some(Pick::Point(-1))).unwrap()
}

#[test]
fn figures_of_orbits_have_the_numbers_of_their_commands() {
    let shooting = Shooting::default();
    let breather = |rho: f64, center: Center, omega_b: f64| {
        let params = Params::new(1.5, 1.0, rho).unwrap();
        DarkBreather { params, center, sites: 41, omega_b, c_x: 0.0 }.orbit(&shooting).unwrap()
    };
    let report = orbits::return_errors([2.085, 2.086], 1, 100.0, &|_, _| {}).unwrap();
    let [omega_b, e_b, _] = table(&report, "errors").last().unwrap()[..] else { panic!() };
    let orbit = last(&report);
    assert_eq!((omega_b, orbit.setting.omega_b), (2.086, 2.086));
    let run = evolve(&orbit, 100.0, None, &shooting, &|_, _| {}).unwrap();
    assert_eq!(run.e_b.last(), Some(&e_b));
    // The largest strain of the background in every period is K_x, but for the time between
    // samples.
    let (sites, k_x) = (orbit.setting.sites, orbit.extent(shooting.tol).unwrap().k_x);
    assert_eq!(run.swing.x.len(), sites * (run.times.len() - 1));
    for row in run.swing.x.chunks(sites) {
        assert!((0.98..1.0 + 1e-9).contains(&(row[0] / k_x)), "{} {k_x}", row[0]);
    }
    for center in [Center::Bond, Center::Site] {
        let report = orbits::mass_ratios(center, 2.05, 0.34, [3, 1], &|_, _| {}).unwrap();
        let branch = table(&report, "branch");
        let rhos: Vec<f64> = branch.iter().map(|row| row[0]).collect();
        assert!(rhos.is_sorted_by(|a, b| a < b) && rhos.len() > 3 && rhos.last() == Some(&0.34), "{rhos:?}");
        let (exact, last) = (breather(0.34, center, 2.05), last(&report));
        let apart = exact.z.iter().zip(&last.z).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1.5e-15, "{apart:e}");
    }
}

/// Every point of the branch has multipliers, and the last is where it should end.
fn reaches_its_end(report: &Report, end: f64) {
    let (json, branch) = (report.json(), table(report, "branch"));
    assert_eq!(json["gaps"], Value::Array(vec![]));
    assert_eq!(branch.last().unwrap()[0], end);
    assert!(branch.iter().all(|row| row[5] >= 1.0), "{branch:?}");
}

#[test]
fn short_branches_of_figures_reach_their_ends() {
    let omega = Params::new(1.5, 1.0, 10.0).unwrap().omega();
    for center in [Center::Bond, Center::Site] {
        let floquet = orbits::family(10.0, center, [0.001, 0.0011], (2, false, None), &|_, _| {});
        reaches_its_end(&floquet.unwrap(), omega + 0.0011);
    }
    reaches_its_end(&orbits::doubled_branch(1.0322, &|_, _| {}).unwrap(), 1.0322);
}

// Truth: what the paper says of Fig. r3evol, and the symmetry of the mode about the bond between
// n = 0 and 1.
#[test]
fn figures_of_sec_7_show_what_their_captions_say() {
    let (folder, captions) = drawn("rho3-evolution");
    let doubling = orbits::doubling(1.032).unwrap();
    let (mode, caption) = (table(&doubling, "profile"), doubling.drawn().unwrap()[0].1.caption.clone());
    for row in &mode[1..] {
        let [n, .., x, y] = row[..] else { panic!() };
        let other = &mode[(1.0 - n + 20.0) as usize];
        assert!((x + other[5]).abs() < 1e-12 && (y + other[6]).abs() < 1e-12, "{row:?} {other:?}");
    }
    assert!(mode.iter().any(|row| row[5].abs() == 1.0 || row[6].abs() == 1.0), "the largest is 1");
    let largest = |of: &dyn Fn(&Vec<f64>) -> f64| mode.iter().map(of).fold(0.0, f64::max);
    let far = |row: &Vec<f64>| if row[0].abs() > 8.0 { row[5].abs().max(row[6].abs()) } else { 0.0 };
    assert!(largest(&far) < 2e-6);
    // An orbit of the main branch is even about the bond: this one is not.
    let uneven =
        |row: &Vec<f64>| if row[0] == -20.0 { 0.0 } else { (row[2] - mode[(21.0 - row[0]) as usize][2]).abs() };
    assert!(largest(&uneven) > 0.15 * largest(&|row| row[1].abs().max(row[2].abs())));
    let told = |before: &str| -> f64 {
        let word = caption.split(before).nth(1).unwrap().split(' ').next().unwrap();
        word.trim_end_matches('.').parse().unwrap()
    };
    assert!(told("residual of ") < 1e-15 && told("takes ") <= 9.0, "{caption}");
    for (center, returns) in [("site", true), ("bond", false)] {
        let (_, errors) = read(folder.path(), &format!("rho3-evolution-{center}-1.2547-evolution.csv"));
        let last = errors.last().unwrap();
        let told = format!("E_b({:.0}) = {:.1e}", last[0], last[1]);
        assert!(captions[0].contains(&told), "{told}: {}", captions[0]);
        // The paper has the site-centred one at t = 1500 and the other on its way. Measured:
        // 1.5e-11, and 2.
        assert!(if returns { last[1] < 3e-11 } else { last[1] > 1.0 }, "{center}: {last:?}");
        let (_, swing) = read(folder.path(), &format!("rho3-evolution-{center}-1.2547-evolution-x.csv"));
        assert_eq!((swing.len(), swing[0].len()), (errors.len() - 1, 42));
    }
}

#[test]
fn a_report_has_findings_first_then_pictures_then_tables_and_its_data_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("report");
    stdout(&format!("paper report --only theorem --out {}", out.display()));
    assert_eq!(read_json(&out.join("report.json"))["sections"][0]["failures"], Value::Array(vec![]));
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    // Both laws are decided, and what looks like a tag is none.
    assert!([">violated<", ">bounded<", "0 &lt;= t"].iter().all(|words| page.contains(words)), "{page}");
    assert!(!page.contains(">undecided<"), "{page}");
    assert!(!page.contains("http:") && !page.contains("https:") && !page.contains("<script src"));
    let places = ["<h2 id=\"findings\">", "bounded: as Theorem 1 says.", "<h2 id=\"figures\">", "<figure>"]
        .into_iter()
        .chain(["<h2 id=\"tables\">", "<table>"])
        .map(|mark| page.find(mark).unwrap_or_else(|| panic!("{mark}")));
    assert!(places.is_sorted(), "{page}");
    // Measured: 137 kB, of which 107 are two pictures.
    assert!(page.len() < 300_000, "{}", page.len());
    let mut archive = zip::ZipArchive::new(std::fs::File::open(out.join("report.zip")).unwrap()).unwrap();
    let names: Vec<String> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
    assert_eq!(names.len(), 6, "{names:?}");
    assert!(names.iter().all(|name| page.contains(name)), "{names:?}");
    let csv = std::io::read_to_string(archive.by_name("theorem/2-limits.csv").unwrap()).unwrap();
    assert!(csv.starts_with("norm,quantity,") && csv.contains(",violated\n"), "{csv}");
}

#[test]
#[ignore = "nightly: the whole report, minutes"]
fn a_whole_report_is_at_most_five_megabytes() {
    let folder = tempfile::tempdir().unwrap();
    stdout(&format!("paper report --out {}", folder.path().display()));
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.len() < 5_000_000, "{}", page.len());
    // Findings: a row for each decade of error, both verdicts of the theorem, differences from the
    // paper with their reasons, and nothing that agrees.
    let findings = page.split_once("<h2 id=\"findings\">").unwrap().1.split_once("<h2").unwrap().0;
    let findings = findings.replace('\n', " ");
    for wanted in ["plain loop", "bounded: as Theorem 1 says.", "violated: Theorem 1", "bad\">differs<", "all as known"]
    {
        assert!(findings.contains(wanted), "{wanted}: {findings}");
    }
    assert!(!findings.contains(">agrees<") && !findings.contains("undecided"), "{findings}");
}

/// A browser without a window, if one is installed.
fn browser() -> Option<&'static str> {
    ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok())
}

#[test]
fn a_browser_finds_no_error_in_a_report() {
    let Some(browser) = browser() else {
        println!("SKIPPED: no Chromium here");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    stdout(&["paper", "report", "--only", "order,theorem", "--out", out]);
    // Errors of scripts, pictures that are not drawn, links that lead nowhere; then a table is
    // sorted by its second column, and a picture is shown large.
    let (early, late) = include_str!("../reference/watch.html").split_once('\n').unwrap();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    let watched = folder.path().join("watched.html");
    std::fs::write(&watched, page.replacen("<head>", &format!("<head>{early}"), 1).replacen("</body>", late, 1))
        .unwrap();
    let data = format!("--user-data-dir={}", folder.path().join("browser").display());
    let flags = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=10000", "--dump-dom"];
    let flags = flags.into_iter().chain(["--window-size=500,900"]);
    let output =
        Command::new(browser).args(flags).arg(data).arg(format!("file://{}", watched.display())).output().unwrap();
    let seen = String::from_utf8_lossy(&output.stdout).into_owned();
    let title = seen.split_once("<title>").and_then(|(_, rest)| rest.split_once("</title>")).map(|(title, _)| title);
    assert_eq!(title, Some("0 wrong, 5 pictures: "), "{}", String::from_utf8_lossy(&output.stderr));
}
