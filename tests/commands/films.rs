//! Films of runs: their frames, their size, and when contacts are lit.
#![cfg(feature = "plot")]

use super::program::{names, refusals, refused, stdout};
use hertzchain::{
    Scene,
    chain::Contact,
    figures::{FILM_SIZE, LIT},
    run::{Method, Records},
    study::film,
};
use std::{fs, path::Path};

/// Two beads that fly at each other and apart.
const SCENE: &str = "name = \"two\"\n[chain]\nsites = 2\nalpha = 1.5\nkappa = 0.0\nrho = 0.0\nboundary = \"free\"\n\
    [initial]\nkind = \"state\"\nu = [-0.53, 0.53]\nu_dot = [1.0, -1.0]\n[span]\nuntil = 4.0\nperiod = 1.0\n[record]\nsamples = 40\n";

/// The frames of a film as indices of colours, and its colours.
fn frames(path: &Path) -> (Vec<Vec<u8>>, Vec<[u8; 3]>) {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::Indexed);
    let mut decoder = options.read_info(fs::File::open(path).unwrap()).unwrap();
    let palette = decoder.global_palette().unwrap().chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
    let (width, mut all) = (FILM_SIZE.0 as usize, Vec::<Vec<u8>>::new());
    let mut screen = vec![0; width * FILM_SIZE.1 as usize];
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert_eq!(frame.delay, 4);
        for (k, &index) in frame.buffer.iter().enumerate().filter(|(_, index)| Some(**index) != frame.transparent) {
            let (row, column) = (k / frame.width as usize, k % frame.width as usize);
            screen[(row + frame.top as usize) * width + column + frame.left as usize] = index;
        }
        all.push(screen.clone());
    }
    (all, palette)
}

// Truth: the log of contacts, which the search for events makes and no sample.
#[test]
fn a_contact_is_lit_in_the_frames_between_its_onset_and_its_release() {
    let folder = tempfile::tempdir().unwrap();
    let [scene, out] = ["scene.toml", "out"].map(|name| folder.path().join(name));
    fs::write(&scene, SCENE).unwrap();
    let line = format!("run {} --tol 1e-10 --events --format svg,gif --out {}", scene.display(), out.display());
    stdout(&line);
    let film = fs::read(out.join("film.gif")).unwrap();
    let (all, palette) = frames(&out.join("film.gif"));
    let lit = palette.iter().position(|&[r, g, b]| (r, g, b) == LIT).unwrap() as u8;
    let log = fs::read_to_string(out.join("contacts.csv")).unwrap();
    let row: Vec<f64> = log.lines().nth(1).unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    let (onset, release) = (row[1], row[2]);
    assert!(log.lines().count() == 2 && 0.3 < onset && onset < release && release < 3.0, "{log}");
    assert_eq!(all.len(), 41);
    for (k, frame) in all.iter().enumerate() {
        let t = 0.1 * k as f64;
        assert_eq!(frame.contains(&lit), onset < t && t < release, "frame {k}, t = {t}, contact {onset} to {release}");
    }
    // Pictures beside it, in the format that is asked for; the same bytes again; none if not asked
    // for.
    let there = names(&out);
    assert!(there.contains("spacetime.svg") && !there.contains("spacetime.png"), "{there:?}");
    stdout(&line);
    assert!(fs::read(out.join("film.gif")).unwrap() == film);
    stdout(&line.replace("svg,gif", "png"));
    assert!(!names(&out).contains("film.gif"));
}

// Every frame of these films has moved beads and contacts.
#[test]
fn ten_seconds_take_at_most_five_megabytes() {
    for line in ["run impact --samples 40", "run tw-q15 --samples 40 --set span.periods=4"] {
        let folder = tempfile::tempdir().unwrap();
        stdout(&format!("{line} --format gif --out {}", folder.path().display()));
        let path = folder.path().join("film.gif");
        assert_eq!(frames(&path).0.len(), 41, "{line}");
        let a_frame = fs::metadata(&path).unwrap().len() / 41;
        assert!(250 * a_frame < 5_000_000, "{line}: {a_frame} bytes a frame");
    }
}

#[test]
fn of_many_samples_some_are_frames() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display();
    // The start is a sample of its own.
    for (samples, most) in [(250, 251), (501, 168)] {
        stdout(&format!("run cradle --until 1 --set chain.sites=3 --samples {samples} --format gif --out {out}"));
        assert_eq!(frames(&folder.path().join("film.gif")).0.len(), most, "{samples}");
    }
}

// Truth: the solitary wave has run over 17 bonds; among 20000 it is a column of pixels.
#[test]
fn a_short_wave_on_a_long_chain_fills_the_picture_over_space_and_time() {
    let folder = tempfile::tempdir().unwrap();
    let line = "run impact --set chain.sites=20000 --until 20 --samples 40 --integrator verlet --steps-per-period 40";
    stdout(&format!("{line} --format svg,png --out {}", folder.path().display()));
    let svg = fs::read_to_string(folder.path().join("spacetime.svg")).unwrap();
    assert!(svg.contains("The other bonds of 19999 move by less than 0.001 of the largest strain."), "{svg:.999}");
    let file = fs::File::open(folder.path().join("spacetime.png")).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    // The blue of contacts left of the colour bar.
    let blue = |(k, p): &(usize, &[u8])| k % 1200 < 1000 && p[2] > 120 && p[0] < 80;
    assert!(pixels.chunks(3).enumerate().filter(blue).count() > 5000);
}

#[test]
fn a_film_that_cannot_be_is_refused_before_the_run() {
    refusals(
        2,
        &[
            ("run impact --format gif", "format = gif is not valid: it is written to the folder of --out"),
            ("run impact --plan --format gif", "format = gif is not valid: it is written to the folder of --out"),
            ("run impact --format mat", "format = mat is not valid: it is written to the folder of --out"),
            ("run impact --samples 0 --format gif --out nowhere", "format = gif is not valid: a film needs samples"),
            ("run impact --set record.sites=[1] --format gif --out nowhere", "[record] keeps a part of it"),
            ("study order --format gif", "gif"),
        ],
    );
    assert!(refused("run impact --format jpg --out nowhere", 2).contains("png, svg, gif"));
    assert!(!Path::new("nowhere").exists());
    // One sample after the start makes two frames.
    let folder = tempfile::tempdir().unwrap();
    stdout(&format!("run impact --until 1 --samples 1 --format gif --out {}", folder.path().display()));
    assert_eq!(frames(&folder.path().join("film.gif")).0.len(), 2);
}

#[test]
fn a_run_that_ends_before_its_second_sample_has_pictures_and_no_film() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display().to_string();
    let line = ["run", "impact", "--until", "5", "--samples", "4", "--stop", "u[0]>0.05", "--format", "png,gif"];
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(line).args(["--out", &out]).output();
    let ran = ran.unwrap();
    let said = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.success() && said.contains("no film: it needs two samples"), "{said}");
    let there = names(folder.path());
    assert!(there.contains("profile.png") && !there.contains("film.gif"), "{there:?}");
}

// Truth: the log of contacts, which the search for events makes and no sample.
#[test]
fn contacts_of_built_in_scenes_are_lit_as_logged() {
    for name in ["cradle", "tw-q15", "dimer"] {
        let scene = Scene::load_with(name, &["record.samples=200".to_owned()]).unwrap().until(9.0).unwrap();
        let run = scene.run().method(Method::named("collocation").unwrap()).records(Records::Profiles).contacts();
        let outcome = run.start().unwrap();
        let (layout, chain_bonds) = (scene.chain().layout(), scene.chain().touching().len());
        let samples: Vec<(f64, &[f64], &[f64])> = outcome
            .profiles
            .iter()
            .map(|one| (one.t, layout.u(&one.state), layout.v(&one.state).unwrap_or_default()))
            .collect();
        let film = film(&scene, "", &samples, None).unwrap();
        assert_eq!(film.frames.len(), samples.len());
        let contacts = outcome.contacts.unwrap();
        let largest = contacts.iter().map(|one| one.largest_overlap).fold(0.0, f64::max);
        let (mut lit, mut dark) = (0, 0);
        for (frame, &(t, ..)) in film.frames.iter().zip(&samples) {
            // Surely lit: large contacts away from their ends; at most: all that are open
            // nearly then.
            let open = |room: f64, least: f64| {
                let open = |one: &&Contact| {
                    let [from, to] = [one.onset.unwrap_or(-1.0), one.release.unwrap_or(99.0)];
                    from < t - room && t + room < to && one.largest_overlap >= least * largest
                };
                contacts.iter().filter(open).count()
            };
            let range = open(0.3, 0.3)..=open(-0.02, 0.0);
            assert!(range.contains(&frame.contacts.len()), "{name}: {} at {t}, {range:?}", frame.contacts.len());
            lit += range.start();
            dark += chain_bonds - range.end();
        }
        assert!(lit > 50 && dark > 50, "{name}: {lit} lit, {dark} dark");
    }
}
