//! Figures: the same bytes for the same numbers, every letter drawn, and no input that breaks them.
#![cfg(feature = "plot")]

use hertzchain::figures::*;

const CAPTION: &str = "N = 64, κ = 1, ρ = ½, α = 3/2; τ = 10⁻³, Störmer–Verlet, hertzchain 0.1.0";

fn diagram(curves: usize) -> WorkPrecision {
    let curve = |k: usize| Curve {
        name: format!("method {k}"),
        family: k % 6,
        points: (0..8)
            .map(|j| {
                let error = 10_f64.powf(-1.0 - 0.2 * k as f64 * f64::from(j)).max(1e-13);
                Point { work: 1e-4 * 4_f64.powi(j) * (1.0 + k as f64), error, below_reference: error < 2e-13 }
            })
            .collect(),
        slope: (k < 3).then_some(2.0),
    };
    WorkPrecision {
        title: "Work and precision".into(),
        work_label: "wall time (s)".into(),
        error_label: "relative error of xₙ at t = 100".into(),
        curves: (0..curves).map(curve).collect(),
        floor: Some(2e-13),
        caption: CAPTION.into(),
        families: ["Splittings", "Runge–Kutta", "Exponential", "Event-aware"].map(String::from).into(),
    }
}

fn line(name: &str, values: &[f64]) -> Line {
    Line { name: name.into(), points: values.iter().enumerate().map(|(n, &v)| (n as f64, v)).collect() }
}

fn chain(values: &[f64]) -> Profile {
    let panel = |label: &str| Panel {
        label: label.into(),
        lines: ["numerical", "approximation", "linear"].map(|name| line(name, values)).into(),
    };
    Profile {
        title: "Strain at t = 100".into(),
        site_label: "site n".into(),
        panels: vec![panel("strain xₙ"), panel("resonator strain yₙ")],
        caption: CAPTION.into(),
    }
}

fn map(values: Vec<f64>, sites: usize) -> SpaceTime {
    SpaceTime {
        title: "Travelling wave".into(),
        site_label: "bond n".into(),
        time_label: "time t".into(),
        value_label: "strain xₙ".into(),
        values,
        sites,
        first_site: 1.0,
        times: (0.0, 10.0),
        signed: true,
        caption: CAPTION.into(),
    }
}

fn energies(values: &[f64], log: bool) -> TimeSeries {
    TimeSeries {
        title: "Energy".into(),
        time_label: "time t".into(),
        value_label: "relative error of H(t)".into(),
        log,
        lines: vec![line("Störmer–Verlet", values), line("τ = 10⁻³", values)],
        caption: CAPTION.into(),
    }
}

/// The pixels of a figure, row by row, and its caption as the file keeps it.
fn decode(bytes: &[u8]) -> (Vec<[u8; 3]>, String) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    assert_eq!(reader.info().size(), SIZE);
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    reader.finish().unwrap();
    let info = reader.info();
    assert!(info.uncompressed_latin1_text.iter().any(|c| c.keyword == "Software" && c.text.starts_with("hertzchain")));
    let caption = info.utf8_text.iter().find(|chunk| chunk.keyword == "Description").unwrap();
    (pixels.chunks(3).map(|p| [p[0], p[1], p[2]]).collect(), caption.get_text().unwrap())
}

#[test]
fn the_same_numbers_give_the_same_bytes_and_keep_their_caption() {
    let wave: Vec<f64> = (0..64).map(|n| (-((n - 30) as f64 / 5.0).powi(2)).exp()).collect();
    let draw = || {
        [
            work_precision(&diagram(6)).unwrap(),
            profile(&chain(&wave)).unwrap(),
            space_time(&map(wave.clone(), 8)).unwrap(),
            series(&energies(&wave, true)).unwrap(),
        ]
    };
    let first = draw();
    assert_eq!(first, draw());
    for bytes in first {
        let (pixels, caption) = decode(&bytes);
        assert_eq!(caption, CAPTION);
        assert!(pixels.iter().any(|&p| p != pixels[0]));
    }
}

#[test]
fn the_font_has_the_letters_of_the_labels() {
    assert_eq!(
        missing_glyphs("0123456789 ×·±−–≤≥≈½ ⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺ ₀₁₂₃₄₅₆₇₈₉ xₙ yₙ Eₓ eₙ αβγδεζκλμνρτφψω ΔΣ ö é ∞ ∂ √ …"),
        []
    );
    assert_eq!(missing_glyphs("ok\n日\t日"), ['\t', '日']);
    let wrong = |text: &str| TimeSeries { title: text.into(), ..energies(&[1.0, 2.0], false) };
    assert!(series(&wrong("日")).unwrap_err().to_string().contains('日'));
    let wrong = TimeSeries { caption: "日".into(), ..energies(&[1.0, 2.0], false) };
    assert!(series(&wrong).is_err());
}

#[test]
fn figures_of_nothing_are_errors() {
    assert!(work_precision(&diagram(0)).is_err());
    let mut unusable = diagram(2);
    for point in unusable.curves.iter_mut().flat_map(|curve| &mut curve.points) {
        point.error = 0.0;
    }
    assert!(work_precision(&unusable).is_err());
    assert!(profile(&chain(&[])).is_err());
    assert!(profile(&Profile { panels: vec![], ..chain(&[1.0]) }).is_err());
    assert!(space_time(&map(vec![], 3)).is_err());
    assert!(space_time(&map(vec![1.0; 4], 3)).is_err());
    assert!(space_time(&map(vec![1.0; 4], 0)).is_err());
    assert!(series(&energies(&[0.0, -1.0, f64::NAN], true)).is_err());
}

#[test]
fn odd_numbers_are_drawn_without_panic() {
    let cases = [
        vec![1.0],
        vec![0.0; 5],
        vec![-7.5; 300],
        vec![1.0, f64::NAN, 2.0, f64::INFINITY, 3.0],
        vec![f64::MAX, 1e300, -1e300, 5e-324],
        vec![1e-17, 2e-17],
        vec![1.0, 1.0 + f64::EPSILON],
    ];
    let draw = |values: &[f64]| {
        profile(&chain(values)).unwrap();
        space_time(&map(values.to_vec(), 1)).unwrap();
        let one_moment = SpaceTime { times: (3.0, 3.0), signed: false, ..map(values.to_vec(), values.len()) };
        space_time(&one_moment).unwrap();
        assert_eq!(series(&energies(values, true)).is_ok(), values.iter().any(|&v| v > 0.0));
        let mut figure = diagram(1);
        let point = |&value: &f64| Point { work: value, error: value, below_reference: false };
        figure.curves[0].points = values.iter().map(point).chain([point(&1.0)]).collect();
        figure.floor = values.first().copied();
        work_precision(&figure).unwrap();
    };
    std::thread::scope(|scope| cases.iter().for_each(|values| drop(scope.spawn(|| draw(values)))));
}

#[test]
fn a_narrow_wave_survives_a_large_matrix() {
    let mut values = vec![0.0; 3000 * 1000];
    values[345 * 3000 + 2345] = 1.0;
    let red = |p: &[u8; 3]| p[0] > 80 && p[1] < 30;
    let count = |values: Vec<f64>, sites| {
        let (pixels, _) = decode(&space_time(&map(values, sites)).unwrap());
        let rows = pixels.chunks(SIZE.0 as usize);
        rows.map(|row| row[..1000].iter().filter(|p| red(p)).count()).sum::<usize>()
    };
    assert!(count(values, 3000) >= 1);
    assert_eq!(count(vec![0.0; 4], 2), 0);
}

#[test]
fn the_legend_of_many_curves_stands_apart_from_the_axes() {
    let mut figure = diagram(25);
    figure.curves[3].name =
        "a method whose name is so long that it has to be broken into two lines or even three".into();
    let (pixels, _) = decode(&work_precision(&figure).unwrap());
    let row = |y: usize| &pixels[y * SIZE.0 as usize..(y + 1) * SIZE.0 as usize];
    let blank: Vec<bool> = (0..SIZE.0 as usize).map(|x| (60..680).all(|y| row(y)[x] == [255; 3])).collect();
    // From the right: a margin, the legend, at least eight blank columns, then the frame of the axes.
    let legend_end = (0..blank.len()).rev().find(|&x| !blank[x]).unwrap();
    let gap = (8..legend_end).rev().find(|&x| blank[x - 8..x].iter().all(|&b| b)).unwrap();
    assert!(legend_end < blank.len() - 5 && legend_end - gap > 150);
    let frame = (0..gap).rev().find(|&x| !blank[x]).unwrap();
    assert!((60..680).all(|y| row(y)[frame - 1..=frame].iter().any(|p| p[0] < 200)));
}
