//! Figures: the same bytes for the same numbers, every letter drawn, and no input that breaks them.
#![cfg(feature = "plot")]

use hertzchain::{
    Method,
    figures::{
        palette::{APART, BEYOND, Style},
        *,
    },
    plain::Loop,
};

const CAPTION: &str = "N = 64, κ = 1, ρ = ½, α = 3/2; τ = 10⁻³, Störmer–Verlet, hertzchain 0.1.0";

fn diagram(curves: usize) -> WorkPrecision {
    let curve = |k: usize| Curve {
        name: format!("method {k}"),
        note: if k < 3 { ", order 2".into() } else { String::new() },
        group: ["Splittings", "Runge–Kutta", "Exponential", "Event-aware"][k.min(3)].into(),
        points: (0..8)
            .map(|j| {
                let error = 10_f64.powf(-1.0 - 0.2 * k as f64 * f64::from(j)).max(1e-13);
                Point { work: 1e-4 * 4_f64.powi(j) * (1.0 + k as f64), error, below_reference: error < 2e-13 }
            })
            .collect(),
    };
    WorkPrecision {
        title: "Work and precision".into(),
        work_label: "wall time (s)".into(),
        error_label: "relative error of xₙ at t = 100".into(),
        curves: (0..curves).map(curve).collect(),
        floor: Some(2e-13),
        caption: CAPTION.into(),
    }
}

fn line(name: &str, values: &[f64]) -> Line {
    Line::new(name, values.iter().enumerate().map(|(n, &v)| (n as f64, v)))
}

fn chain(values: &[f64]) -> Panels {
    let lines = || ["numerical", "approximation", "linear"].map(|name| line(name, values)).into();
    let panel = |label: &str| Panel::new(Kind::Sites, ["site n", label], lines());
    Panels::column("Strain at t = 100", vec![panel("strain xₙ"), panel("resonator strain yₙ")], CAPTION)
}

fn map(values: Vec<f64>, sites: usize) -> SpaceTime {
    SpaceTime {
        site_label: "bond n".into(),
        time_label: "time t".into(),
        value_label: "strain xₙ".into(),
        values,
        sites,
        first_site: 1.0,
        times: (0.0, 10.0),
        most: None,
        signed: true,
    }
}

/// A page with one plot.
fn one(plot: impl Into<Plot>) -> Result<Picture, Error> {
    panels(&Panels::column("Plot", vec![plot.into()], CAPTION))
}

/// Contacts as (bond, start, end, largest overlap), on bonds 1 to 9 and from time 0 to 100.
fn contacts(bars: &[(f64, f64, f64, f64)]) -> Raster {
    Raster {
        title: "Contacts".into(),
        bond_label: "bond n".into(),
        time_label: "time t".into(),
        bars: bars.iter().map(|&(bond, start, end, shade)| Bar { bond, start, end, shade }).collect(),
        shade_label: "largest overlap".into(),
        bonds: (1.0, 9.0),
        times: (0.0, 100.0),
        caption: CAPTION.into(),
    }
}

fn energies(values: &[f64], log: bool) -> Panels {
    let lines = vec![line("Störmer–Verlet", values), line("τ = 10⁻³", values)];
    let kind = if log { Kind::LogTime } else { Kind::Time };
    let panel = Panel::new(kind, ["time t", "relative error of H(t)"], lines);
    Panels::column("Energy", vec![panel], CAPTION)
}

/// The pixels of a figure, row by row, and its caption as the file keeps it.
fn decode(picture: &Picture) -> (Vec<[u8; 3]>, String) {
    let bytes = picture.file(Format::Png).unwrap();
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
            panels(&chain(&wave)).unwrap(),
            one(map(wave.clone(), 8)).unwrap(),
            panels(&energies(&wave, true)).unwrap(),
            raster(&contacts(&[(2.0, 10.0, 20.0, 1.0), (7.0, 15.0, 60.0, 2.0)])).unwrap(),
        ]
    };
    let files = |format: Format| draw().map(|picture| picture.file(format).unwrap());
    for format in Format::ALL {
        assert_eq!(files(format), files(format));
    }
    for picture in draw() {
        let (pixels, caption) = decode(&picture);
        assert_eq!(caption, CAPTION);
        assert!(pixels.iter().any(|&p| p != pixels[0]));
        let svg = String::from_utf8(picture.file(Format::Svg).unwrap()).unwrap();
        let (title, caption) = (&picture.title, CAPTION.replace('&', "&amp;"));
        assert!(svg.contains(&format!("<title>{title}</title>\n<desc>{caption}</desc>")));
        assert_eq!(unclosed(&svg), Vec::<&str>::new());
        // Nothing is fetched from elsewhere.
        assert_eq!(svg.matches("http").count(), 1);
        assert_eq!(svg.matches("href=").count(), svg.matches("href=\"data:image/png;base64,").count());
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
}

/// The elements of an XML text that are not closed in their order.
fn unclosed(xml: &str) -> Vec<&str> {
    let mut open = Vec::new();
    for tag in xml.split('<').skip(1).map(|part| part.split_once('>').expect("a tag ends").0) {
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None if tag.ends_with('/') => {}
            None => open.push(tag.split(' ').next().unwrap()),
        }
    }
    open
}

#[test]
fn the_font_has_the_letters_of_the_labels() {
    assert_eq!(
        missing_glyphs("0123456789 ×·±−–≤≥≈½ ⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺ ₀₁₂₃₄₅₆₇₈₉ xₙ yₙ Eₓ eₙ αβγδεζκλμνρτφψω ΔΣ ö é ∞ ∂ √ …"),
        []
    );
    assert_eq!(missing_glyphs("ok\n日\t日"), ['\t', '日']);
    // Truth: the picture of a text with U+FFFD in their place.
    let pixels = |title: &str| decode(&panels(&Panels { title: title.into(), ..chain(&[1.0, 2.0]) }).unwrap()).0;
    assert!(pixels("日本 \u{1b}") == pixels("\u{fffd}\u{fffd} \u{fffd}") && pixels("日") != pixels("a"));
}

#[test]
fn figures_of_nothing_are_errors() {
    assert!(work_precision(&diagram(0)).is_err());
    let mut unusable = diagram(2);
    for point in unusable.curves.iter_mut().flat_map(|curve| &mut curve.points) {
        point.error = 0.0;
    }
    assert!(work_precision(&unusable).is_err());
    assert!(panels(&chain(&[])).is_err());
    assert!(panels(&Panels { columns: vec![], ..chain(&[1.0]) }).is_err());
    assert!(one(map(vec![], 3)).is_err());
    assert!(one(map(vec![1.0; 4], 3)).is_err());
    assert!(one(map(vec![1.0; 4], 0)).is_err());
    assert!(panels(&energies(&[0.0, -1.0, f64::NAN], true)).is_err());
}

#[test]
fn contacts_that_run_backwards_or_nowhere_are_errors() {
    let nowhere = f64::NAN;
    for bar in [(2.0, 20.0, 10.0, 1.0), (nowhere, 10.0, 20.0, 1.0), (2.0, nowhere, 20.0, 1.0), (2.0, 1.0, 1e301, 1.0)] {
        assert!(raster(&contacts(&[bar])).is_err(), "{bar:?}");
    }
    for bounds in [(2.0, 1.0), (nowhere, 1.0), (0.0, f64::INFINITY)] {
        assert!(raster(&Raster { bonds: bounds, ..contacts(&[]) }).is_err(), "{bounds:?}");
        assert!(raster(&Raster { times: bounds, ..contacts(&[]) }).is_err(), "{bounds:?}");
    }
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
        panels(&chain(values)).unwrap();
        one(map(values.to_vec(), 1)).unwrap();
        let one_moment = SpaceTime { times: (3.0, 3.0), signed: false, ..map(values.to_vec(), values.len()) };
        one(one_moment).unwrap();
        assert_eq!(panels(&energies(values, true)).is_ok(), values.iter().any(|&v| v > 0.0));
        let bars: Vec<_> = values.iter().enumerate().map(|(n, &shade)| (n as f64, n as f64, n as f64, shade)).collect();
        raster(&contacts(&bars)).unwrap();
        raster(&Raster { times: (3.0, 3.0), bonds: (2.0, 2.0), ..contacts(&bars) }).unwrap();
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
        let (pixels, _) = decode(&one(map(values, sites)).unwrap());
        let rows = pixels.chunks(SIZE.0 as usize);
        rows.map(|row| row[..1000].iter().filter(|p| red(p)).count()).sum::<usize>()
    };
    assert!(count(values, 3000) >= 1);
    assert_eq!(count(vec![0.0; 4], 2), 0);
}

#[test]
fn every_integrator_has_a_look_of_its_own() {
    let loops = Loop::ALL.into_iter().map(|plain| plain.name.to_owned());
    let names: Vec<String> = Method::all().iter().map(Method::name).chain(loops).collect();
    let looks: Vec<Style> = names.iter().map(|name| Style::of_method(name).expect(name)).collect();
    for (k, look) in looks.iter().enumerate() {
        let same = looks[..k].iter().position(|other| other == look);
        assert!(same.is_none(), "{} looks like {}", names[k], names[same.unwrap()]);
    }
}

#[test]
fn the_legend_of_many_curves_stands_apart_from_the_axes() {
    let mut figure = diagram(25);
    figure.curves[3].name =
        "a method whose name is so long that it has to be broken into two lines or even three".into();
    let (pixels, _) = decode(&work_precision(&figure).unwrap());
    let row = |y: usize| &pixels[y * SIZE.0 as usize..(y + 1) * SIZE.0 as usize];
    let blank: Vec<bool> = (0..SIZE.0 as usize).map(|x| (60..680).all(|y| row(y)[x] == [255; 3])).collect();
    // From the right: a margin, the legend, at least eight blank columns, then the frame of the
    // axes.
    let legend_end = (0..blank.len()).rev().find(|&x| !blank[x]).unwrap();
    let gap = (8..legend_end).rev().find(|&x| blank[x - 8..x].iter().all(|&b| b)).unwrap();
    assert!(legend_end < blank.len() - 5 && legend_end - gap > 150);
    let frame = (0..gap).rev().find(|&x| !blank[x]).unwrap();
    assert!((60..680).all(|y| row(y)[frame - 1..=frame].iter().any(|p| p[0] < 200)));
}

/// The pixels between the axes of a figure: from the frame, found by its ink, inwards.
fn inside(picture: &Picture) -> Vec<Vec<[u8; 3]>> {
    let (pixels, _) = decode(picture);
    let rows: Vec<&[[u8; 3]]> = pixels.chunks(SIZE.0 as usize).collect();
    let ink = |p: &[u8; 3]| p.iter().all(|&c| c < 200);
    let framed = |y: &usize| rows[*y].iter().filter(|p| ink(p)).count() > 800;
    let (top, bottom) = ((0..rows.len()).find(framed).unwrap(), (0..rows.len()).rfind(framed).unwrap());
    let upright = |x: &usize| rows[top..bottom].iter().all(|row| ink(&row[*x]));
    // Each line of the frame lies on two pixels; a colour bar has its own, further right.
    let left = (0..rows[0].len()).find(upright).unwrap() + 2;
    let right = (left..rows[0].len()).find(upright).unwrap();
    rows[top + 2..bottom - 1].iter().map(|row| row[left..right].to_vec()).collect()
}

/// The ranges of columns in which a row is not white.
fn runs(row: &[[u8; 3]]) -> Vec<(usize, usize)> {
    let drawn = |x: usize| row.get(x).is_some_and(|&p| p != [255; 3]);
    let starts = (0..row.len()).filter(|&x| drawn(x) && (x == 0 || !drawn(x - 1)));
    starts.map(|start| (start, (start..).find(|&x| !drawn(x)).unwrap())).collect()
}

#[test]
fn a_contact_lies_where_and_when_it_was() {
    let picture =
        inside(&raster(&contacts(&[(2.0, 10.0, 30.0, 1.0), (2.0, 50.0, 55.0, 3.0), (8.0, 95.0, 300.0, 2.0)])).unwrap());
    let (high, wide) = (picture.len() as f64, picture[0].len() as f64);
    let row = |bond: f64| &picture[((9.5 - bond) / 9.0 * high) as usize];
    let near = |found: &[(usize, usize)], times: &[(f64, f64)]| {
        assert_eq!(found.len(), times.len(), "{found:?}");
        for (&(from, to), &(start, end)) in found.iter().zip(times) {
            assert!((from as f64 - start / 100.0 * wide).abs() < 3.0 && (to as f64 - end / 100.0 * wide).abs() < 3.0);
        }
    };
    near(&runs(row(2.0)), &[(10.0, 30.0), (50.0, 55.0)]);
    near(&runs(row(8.0)), &[(95.0, 100.0)]);
    for empty in [1.0, 3.0, 5.0, 7.0, 9.0] {
        near(&runs(row(empty)), &[]);
    }
    // The largest overlap is the darkest, and each contact has one colour.
    let brightness = |time: f64| row(2.0)[(time / 100.0 * wide) as usize].iter().map(|&c| u32::from(c)).sum::<u32>();
    assert!(brightness(52.0) < brightness(12.0) && brightness(12.0) == brightness(28.0));
}

#[test]
fn contacts_smaller_than_a_pixel_survive() {
    let drawn = |figure: &Raster| inside(&raster(figure).unwrap()).iter().flat_map(|row| runs(row)).collect::<Vec<_>>();
    let brief: Vec<_> = (1..10).map(|n| (5.0, 10.0 * f64::from(n), 10.0 * f64::from(n), 1.0)).collect();
    let one_row = inside(&raster(&contacts(&brief)).unwrap());
    assert_eq!(runs(&one_row[one_row.len() / 2]).iter().map(|(from, to)| to - from).collect::<Vec<_>>(), [1; 9]);
    let many_bonds =
        Raster { bonds: (0.0, 1e5), ..contacts(&[(777.0, 20.0, 80.0, 1.0), (50_000.0, 50.0, 50.0, 1e-9)]) };
    let runs = drawn(&many_bonds);
    assert!(runs.len() == 2 && runs.iter().any(|(from, to)| to - from == 1), "{runs:?}");
    // Of two on one pixel the larger is seen, whatever their order.
    let pair = [(5.0, 50.0, 50.0, 1.0), (5.0, 50.0, 50.0, 2.0)];
    assert_eq!(raster(&contacts(&pair)), raster(&contacts(&[pair[1], pair[0]])));
}

fn chart(values: Vec<f64>) -> GrowthMap {
    let nothing = Line::new("this wave", []);
    GrowthMap {
        labels: ["q / π", "b / (2κa)", "fastest growth"].map(String::from),
        x: (0.0, 1.0),
        y: (-3.0, 1.0),
        values,
        columns: 2,
        lines: vec![Line::new("edge", [(0.5, -3.0), (0.5, 1.0)])],
        points: nothing,
    }
}

/// Whether a pixel of a colour lies within so many pixels of a place, in shares of the width and,
/// upwards, the height.
fn has(picture: &[Vec<[u8; 3]>], (x, y): (f64, f64), near: usize, colour: impl Fn(&[u8; 3]) -> bool) -> bool {
    let (x, y) = ((x * picture[0].len() as f64) as usize, ((1.0 - y) * picture.len() as f64) as usize);
    let rows = &picture[y.saturating_sub(near)..(y + near).min(picture.len())];
    rows.iter().any(|row| row[x.saturating_sub(near)..(x + near).min(row.len())].iter().any(&colour))
}

fn blue(p: &[u8; 3]) -> bool {
    p[2] > p[0].saturating_add(40)
}

fn orange(p: &[u8; 3]) -> bool {
    p[0] > p[2].saturating_add(40)
}

#[test]
fn a_map_of_growth_has_its_lowest_row_at_the_bottom_and_whole_rows_only() {
    let (pixels, _) = decode(&one(chart(vec![0.0, 0.0, 1.0, 1.0])).unwrap());
    let yellow = |p: &[u8; 3]| p[0] > 240 && p[1] > 220 && p[2] < 60;
    // Half of the map, and the end of the colour bar beside it.
    let places = pixels.iter().enumerate().filter(|(_, p)| yellow(p)).map(|(k, _)| k / SIZE.0 as usize);
    let rows: Vec<usize> = places.collect();
    let (top, bottom) = (rows[0], rows[rows.len() - 1]);
    assert!(rows.len() > 20_000 && top < 130 && (300..450).contains(&bottom), "{top} {bottom} {}", rows.len());

    assert!(one(chart(vec![1.0; 3])).is_err() && one(chart(vec![])).is_err());
    assert!(one(GrowthMap { columns: 0, ..chart(vec![1.0; 4]) }).is_err());
}

/// Two lines over time: at 0, and at `high` until the middle.
fn two_lines(high: f64) -> Panel {
    let line = |name: &str, points: &[(f64, f64)]| Line::new(name, points.to_vec());
    let lines = vec![line("E_x", &[(0.0, 0.0), (1.0, 0.0)]), line("E_y", &[(0.0, high), (0.5, high), (1.0, 0.0)])];
    Panel::new(Kind::Time, ["time t", "E (%)"], lines)
}

#[test]
fn columns_stand_side_by_side_and_none_is_empty() {
    let column = |heading: &str, panels: Vec<Panel>| Column::new(heading, panels);
    let figure = |columns: Vec<Column>| Panels { columns, ..chain(&[]) };
    let (left, right) = (two_lines(5.0), two_lines(0.0));
    let bytes = panels(&figure(vec![column("one", vec![left.clone(), left]), column("ζ = 0.1", vec![right])])).unwrap();
    let (pixels, _) = decode(&bytes);
    // Below the legends, E_y is high in the panels at the left, low in the one at the right.
    let (wide, size) = (SIZE.0 as usize, (SIZE.0 as usize / 2, SIZE.1 as usize));
    let count = |from: (usize, usize), to: (usize, usize)| {
        let inside = |k: usize| (from.0..to.0).contains(&(k % wide)) && (from.1..to.1).contains(&(k / wide));
        pixels.iter().enumerate().filter(|(k, p)| inside(*k) && orange(p)).count()
    };
    let (left, right) = (count((0, 100), (size.0, 250)), count((size.0, 100), (wide, 250)));
    assert!(left > 300 && right == 0, "{left} {right}");
    assert!(count((size.0, 250), (wide, size.1)) > 300);
    assert!(panels(&figure(vec![])).is_err());
    assert!(panels(&figure(vec![column("empty", vec![])])).is_err());
    assert!(panels(&figure(vec![column("no lines", vec![Panel::default()])])).is_err());
}

// A row of fine pixels lost to rounding would make one line lighter than the other.
#[test]
fn a_text_is_as_dark_wherever_its_line_falls() {
    let caption = ["Hlll", "Hlll", "Hlll", "Hlll", "Hlll", "Hlll"].join("\n");
    let mut figure = energies(&[1.0, 2.0], false);
    figure.caption = caption;
    let (pixels, _) = decode(&panels(&figure).unwrap());
    let rows: Vec<u64> = pixels
        .chunks(SIZE.0 as usize)
        .map(|row| row[..60].iter().map(|p| u64::from(255 - p[0])).sum::<u64>())
        .collect();
    // From the bottom: six lines of letters without descenders.
    let lines: Vec<u64> =
        rows[670..].split(|&ink| ink == 0).filter(|line| !line.is_empty()).map(|line| line.iter().sum()).collect();
    assert_eq!(lines.len(), 6);
    let (least, most) = (*lines.iter().min().unwrap(), *lines.iter().max().unwrap());
    assert!(most < least + least / 20, "{lines:?}");
}

fn cells(values: &[f64], columns: usize) -> CellMap {
    let ascending = |count: usize| (0..count).map(|k| 10_f64.powi(k as i32)).collect::<Vec<_>>();
    CellMap {
        labels: ["size ε", "mass ratio ρ", "lifetime"].map(String::from),
        x: ascending(columns),
        y: ascending(values.len() / columns.max(1)),
        values: values.to_vec(),
        notes: vec![String::new(); values.len()],
        ..CellMap::default()
    }
}

#[test]
fn a_map_of_cells_has_its_first_row_at_the_bottom_and_a_word_in_every_cell() {
    let bytes = one(cells(&[1.0, 100.0, 100.0, 100.0], 2)).unwrap();
    assert_eq!(decode(&bytes).1, CAPTION);
    let picture = inside(&bytes);
    let yellow = |p: &[u8; 3]| p[0] > 240 && p[1] > 220 && p[2] < 60;
    assert!(!has(&picture, (0.25, 0.25), 3, yellow));
    for at in [(0.75, 0.75), (0.25, 0.75), (0.75, 0.25)] {
        assert!(has(&picture, at, 3, yellow), "{at:?}");
    }
    // What has no logarithm is grey.
    let grey = |p: &[u8; 3]| *p == [160; 3];
    let picture = inside(&one(cells(&[0.0, 1.0, 10.0], 1)).unwrap());
    assert!(has(&picture, (0.5, 0.17), 3, grey) && !has(&picture, (0.5, 0.5), 3, grey));
    for odd in [vec![f64::NAN], vec![-1.0], vec![5e-324, 1e300], vec![3.0; 4]] {
        one(cells(&odd, 1)).unwrap();
    }

    let changed = |change: &dyn Fn(&mut CellMap)| {
        let mut figure = cells(&[1.0; 4], 2);
        change(&mut figure);
        one(figure)
    };
    assert!(changed(&|map| map.lines.push(Line::new("edge", [(1.0, 1.0), (10.0, 10.0)]))).is_ok());
    assert!(changed(&|map| map.notes.truncate(3)).is_err());
    assert!(changed(&|map| map.values.push(1.0)).is_err());
    assert!(changed(&|map| map.x.reverse()).is_err());
    assert!(changed(&|map| map.y[0] = 0.0).is_err());
    assert!(one(cells(&[], 0)).is_err());
}

#[test]
fn kinds_of_cells_off_the_scale_have_colours_of_their_own() {
    let mut figure = cells(&[1.0, 1e9, 10.0, 1e9], 2);
    figure.apart = vec![("open".into(), vec![1]), ("none".into(), vec![3])];
    let picture = inside(&one(figure).unwrap());
    for (at, colour) in [((0.75, 0.25), APART[0]), ((0.75, 0.75), APART[1])] {
        assert!(has(&picture, at, 3, |p| (p[0], p[1], p[2]) == colour), "{at:?}");
    }
    // The scale ends at the largest of the others.
    assert!(has(&picture, (0.25, 0.75), 3, |p| p[0] > 240 && p[1] > 220 && p[2] < 60));
}

#[test]
fn values_beyond_the_scale_are_marked_on_the_map_and_above_the_bar() {
    let figure = |signed, most| SpaceTime { signed, most, ..map(vec![0.0, 0.2, 0.4, 1.0], 2) };
    let is = |pixel: [u8; 3], signed: bool| (pixel[0], pixel[1], pixel[2]) == BEYOND[usize::from(signed)];
    let marked = |most: Option<f64>| {
        let (pixels, _) = decode(&one(figure(true, most)).unwrap());
        let places = (0..pixels.len()).filter(|&k| is(pixels[k], true));
        places.partition::<Vec<usize>, _>(|k| k % (SIZE.0 as usize) < 1070)
    };
    let (on_map, on_bar) = marked(Some(0.5));
    // A quarter of the map, and a triangle of 22 by 12 pixels.
    assert!((100_000..160_000).contains(&on_map.len()), "{}", on_map.len());
    assert!((60..140).contains(&on_bar.len()), "{}", on_bar.len());
    assert!(marked(None).0.is_empty() && marked(Some(2.0)).1.is_empty());
    // Without signs values beyond are lighter than the scale, which is that of viridis.
    let light = |most| inside(&one(figure(false, most)).unwrap()).concat();
    let beyond = light(Some(0.5)).into_iter().filter(|&pixel| is(pixel, false)).count();
    assert!((100_000..160_000).contains(&beyond) && light(None).into_iter().all(|pixel| !is(pixel, false)), "{beyond}");
}

#[test]
fn logarithmic_panels_place_points_by_their_logarithms() {
    let panel = |points: &[(f64, f64)]| Panel::new(Kind::LogLog, [""; 2], vec![Line::new("suprema", points.to_vec())]);
    let draw = |panel: Panel| panels(&Panels::column("Suprema", vec![panel], CAPTION));
    // Axes end at the next 1, 2 or 5: 0.5e-4 to 2 and 0.5e-2 to 2e4, on which these lie in the
    // middle.
    let picture = inside(&draw(panel(&[(1e-4, 1e-2), (1e-2, 10.0), (1.0, 1e4)])).unwrap());
    let from = |x: f64, low: f64, high: f64| (x / low).log10() / (high / low).log10();
    assert!(has(&picture, (from(1e-2, 0.5e-4, 2.0), from(10.0, 0.5e-2, 2e4)), 5, blue));
    assert!(!has(&picture, (0.8, 0.2), 20, blue));
    assert!(draw(panel(&[(0.0, 1.0), (1.0, -1.0)])).is_err());
    draw(panel(&[(0.0, 1.0), (1.0, 1.0)])).unwrap();
}

#[test]
fn panels_of_another_label_have_a_range_of_their_own() {
    let norm = |end| vec![Line::new("norm", [(0.0, 0.0), (end, end)])];
    let panel = |label: &str, end: f64| Panel::new(Kind::Time, [label, ""], norm(end));
    let draw = |labels: [&str; 2]| {
        panels(&Panels::column("Norms", vec![panel(labels[0], 10.0), panel(labels[1], 100.0)], CAPTION)).unwrap()
    };
    // The first of them ends a tenth of the way if it shares the range of the second.
    let right = |bytes: &Picture| {
        let (pixels, _) = decode(bytes);
        let rows: Vec<_> = pixels.chunks(SIZE.0 as usize).take(SIZE.1 as usize / 3).collect();
        (700..1150).any(|x| rows.iter().skip(80).any(|row| blue(&row[x])))
    };
    assert!(right(&draw(["time t", "time s"])) && !right(&draw(["time t", "time t"])));
}

/// The four points `(+-1, 0), (0, +-1)`, as values or as a law.
fn cross(kind: Kind, law: bool) -> Vec<Vec<[u8; 3]>> {
    let line = Line { law, ..Line::new("", [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]) };
    let panel = Panel::new(kind, ["Re λ", "Im λ"], vec![line]);
    inside(&panels(&Panels::column("Cross", vec![panel], "four points")).unwrap())
}

#[test]
fn a_plane_has_one_scale_a_cloud_is_not_joined_and_a_law_has_no_markers() {
    // First and last index at which there is blue, of columns and of rows.
    let extent = |picture: &[Vec<[u8; 3]>]| {
        let columns: Vec<usize> = (0..picture[0].len()).filter(|&x| picture.iter().any(|row| blue(&row[x]))).collect();
        let rows: Vec<usize> = (0..picture.len()).filter(|&y| picture[y].iter().any(blue)).collect();
        [columns, rows].map(|at| at[at.len() - 1] as f64 - at[0] as f64)
    };
    let [wide, high] = extent(&cross(Kind::Plane, false));
    assert!((wide / high - 1.0).abs() < 0.02, "{wide} {high}");
    let [wide, high] = extent(&cross(Kind::Cloud, false));
    assert!(wide / high > 1.3, "{wide} {high}");
    let count = |kind, law| cross(kind, law).iter().flatten().filter(|p| blue(p)).count();
    // Four markers have some 300 pixels, and the lines between them some 4000.
    let [marks, law, both] =
        [(Kind::Cloud, false), (Kind::Cloud, true), (Kind::Parameter, false)].map(|(k, l)| count(k, l));
    assert!(marks < 500 && law > 3000 && both > law && both < law + marks, "{marks} {law} {both}");
}

#[test]
fn a_line_breaks_between_words_and_not_within_formulas() {
    let formula = "E = a + b ≤ T ε^(1−α)";
    for words in 1..60 {
        let figure = Panels { caption: "so ".repeat(words) + formula, ..energies(&[1.0, 2.0], false) };
        let svg = String::from_utf8(panels(&figure).unwrap().file(Format::Svg).unwrap()).unwrap();
        assert!(svg.contains("E = a + b ≤ T ε"), "{words}");
    }
}
