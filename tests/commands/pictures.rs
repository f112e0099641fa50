//! Parts of pictures: texts, axes, cells and SVG files.

use hertzchain_report::internals::{Axis, Canvas, Level, SMALL, edges, runs, svg, text_width, thin};

#[test]
fn a_text_is_set_to_its_width_with_its_scripts_and_escaped() {
    // Truth: the rules of SVG: three runs of `a_b < c`, the middle one lower and smaller.
    let mut canvas = Canvas::new((100, 50), "1 < 2");
    canvas.text("ω_b < c", (50.0, 20.0), 10.0, (0, 0, 0), (0.5, 1.0));
    let svg = String::from_utf8(svg(&canvas.picture("a & b")).unwrap()).unwrap();
    assert!(svg.contains("<title>1 &lt; 2</title>\n<desc>a &amp; b</desc>"), "{svg}");
    let set = "ω<tspan dy=\"1.6\" font-size=\"7.2\">b</tspan><tspan dy=\"-1.6\" font-size=\"10\"> &lt; c</tspan>";
    assert!(svg.contains(set), "{svg}");
    let width = (100.0 * text_width("ω_b < c", 10.0)).round() / 100.0;
    assert!(svg.contains(&format!("textLength=\"{width}\"")), "{svg}");
}

#[test]
fn shapes_are_written_to_a_hundredth_of_a_pixel() {
    let mut canvas = Canvas::new((9, 9), "t");
    canvas.line(&[(0.0, -0.001), (1.0 / 3.0, 2.0)], (255, 0, 1), 1.5, &[6.0, 4.0]);
    canvas.line(&[(1.0, 1.0), (2.0, 2.0)], (255, 0, 1), 1.5, &[6.0, 4.0]);
    canvas.line(&[(1.0, 1.0), (2.0, 2.0)], (255, 0, 1), 1.0, &[]);
    canvas.image((3, 4), 2, vec![(0, 0, 0); 6]);
    let svg = String::from_utf8(svg(&canvas.picture("c")).unwrap()).unwrap();
    assert!(
        svg.contains(
            "d=\"M0,0 0.33,2M1,1 2,2\" fill=\"none\" stroke=\"#ff0001\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\""
        ),
        "{svg}"
    );
    assert!(svg.contains("<image x=\"3\" y=\"4\" width=\"2\" height=\"3\""), "{svg}");
}

/// Subscripts as `<b>` and superscripts as `[2]`.
fn shown(text: &str) -> String {
    let run = |(level, text): (Level, String)| match level {
        Level::Line => text,
        Level::Sub => format!("<{text}>"),
        Level::Super => format!("[{text}]"),
    };
    runs(text).into_iter().map(run).collect()
}

#[test]
fn marks_of_labels_are_set_and_names_are_not() {
    for (text, set) in [
        ("ω_b = 1.2", "ω<b> = 1.2"),
        ("Ẽ_x, E_b(1200), E_u′", "Ẽ<x>, E<b>(1200), E<u>′"),
        ("t = 10 T_tw.", "t = 10 T<tw>."),
        ("a_{n+1}^2", "a<n+1>[2]"),
        ("ρ ε^(2(α−1)) and |λ|^m", "ρ ε[2(α−1)] and |λ|[m]"),
        ("x^-2 ε^1.5 10^6.", "x[−2] ε[1.5] 10[6]."),
        ("tol 1e-9, 2.5e7; 2.494e0", "tol 10[−9], 2.5·10[7]; 2.494"),
        (
            "fig:tw_r03_q15pi (eq:xytw_app) diff_u_l1norm omega_b",
            "fig:tw_r03_q15pi (eq:xytw_app) diff_u_l1norm omega_b",
        ),
        ("a_, ^, e^(2, 3e, 0.1.0e5, v2e3, T_long", "a_, ^, e^(2, 3e, 0.1.0e5, v2e3, T_long"),
        ("", ""),
    ] {
        assert_eq!(shown(text), set);
    }
}

#[test]
fn any_text_is_cut_without_panic() {
    let letters = ['_', '^', '{', '}', '(', ')', 'a', '1', 'e', '-', '.'];
    for code in 0..letters.len().pow(5) {
        let text: String = (0..5).map(|k| letters[code / letters.len().pow(k) % letters.len()]).collect();
        assert!(runs(&text).iter().all(|(_, part)| !part.is_empty()), "{text}");
    }
}

fn ticks_of(mut axis: Axis) -> (Vec<String>, String) {
    axis.tick(800.0, false);
    let wide: Vec<_> = axis.ticks.iter().map(|(p, l)| (800.0 * p, text_width(l, SMALL))).collect();
    assert!(!wide.is_empty());
    for two in wide.windows(2) {
        assert!(two[0].0 + 0.5 * two[0].1 < two[1].0 - 0.5 * two[1].1, "{:?}", axis.ticks);
    }
    (axis.ticks.into_iter().map(|(_, label)| label).collect(), axis.factor)
}

fn linear(lo: f64, hi: f64) -> (Vec<String>, String) {
    ticks_of(Axis::linear([lo, hi].into_iter(), 0.0))
}

#[test]
fn numbers_of_any_size_have_short_labels() {
    assert_eq!(linear(0.0, 1.0).0[..3], ["0.0", "0.2", "0.4"]);
    assert_eq!(linear(-2e17, 2e17).0[..2], ["−2.0", "−1.5"]);
    assert_eq!(linear(-2e17, 2e17).1, "×10¹⁷");
    assert_eq!(linear(0.0, 4e-17).1, "×10⁻¹⁷");
    assert_eq!(linear(1.0, 1.0 + 4e-9).1, "×10⁻⁹ + 1.000000002");
    assert_eq!(linear(-1.0 - 4e-9, -1.0).1, "×10⁻⁹ − 1.000000002");
}

#[test]
fn extreme_ranges_have_ticks() {
    for (lo, hi) in [(0.0, 0.0), (3.0, 3.0), (-1e300, 1e300), (0.0, 5e-324), (1e300, 1e300), (1.0, 1.0 + 1e-11)] {
        linear(lo, hi);
        ticks_of(Axis::whole([lo, hi].into_iter()));
    }
    for (lo, hi) in [(1.0, 1.0), (5e-324, 1e300), (0.11, 0.13), (3e-4, 8.0), (1e-13, 1.0)] {
        ticks_of(Axis::log([lo, hi].into_iter()));
    }
}

#[test]
fn thinning_keeps_the_extremes() {
    let spike = (0..10_000).map(|k| (f64::from(k) / 1000.0, if k == 5432 { 7.0 } else { f64::from(k % 2) }));
    let kept = thin(spike);
    assert!(kept.len() <= 40);
    assert!(kept.contains(&(5.432, 7.0)));
}

#[test]
fn cells_meet_at_geometric_means() {
    let edges_of = |values: &[f64]| edges(values).unwrap();
    for (edge, truth) in edges_of(&[1.0, 4.0, 64.0]).into_iter().zip([0.5, 2.0, 16.0, 256.0]) {
        assert!((edge / truth - 1.0).abs() < 1e-14, "{edge}");
    }
    assert_eq!(edges_of(&[1.0]).len(), 2);
    assert!(edges(&[]).is_err() && edges(&[2.0, 1.0]).is_err() && edges(&[0.0, 1.0]).is_err());
    assert!(edges(&[f64::NAN]).is_err() && edges(&[1.0, f64::INFINITY]).is_err());
}
