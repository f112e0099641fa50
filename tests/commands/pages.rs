//! Tables of reports, and the page of a report.

use hertzchain::{
    present::{Page, Section, Shown},
    report::{Fixed, Hidden, Json, Kind, Line, Panel, Panels, Power, Quantity, Report, Short, Table, Units},
};
use hertzchain_report::internals::{date, judged, table_html};
use std::{
    collections::BTreeMap,
    time::{Duration, SystemTime},
};

#[test]
fn a_field_with_a_point_is_nested_in_json_and_joined_in_csv() {
    let table = Table::of("t", &[1.0, 2.0])
        .col("site.energy", Power(1), "of the site", |x| *x)
        .col("site.real", Hidden, "", |_| true)
        .col("list", Json, "", |x| vec![*x])
        .done();
    assert_eq!(table.json()[0].to_string(), r#"{"site":{"energy":1.0,"real":true},"list":[1.0]}"#);
    assert_eq!(table.csv(), "site_energy,site_real\n1e0,1\n2e0,1\n");
}

#[test]
fn what_rounds_to_zero_has_no_sign_in_the_text() {
    let table = Table::of("t", &[-0.0, -1e-9, -0.5])
        .col("fixed", Fixed(2), "", |x| *x)
        .col("power", Power(1), "", |x| *x)
        .col("short", Short, "", |x| *x)
        .done();
    let cells = [["0.00", "0.0e0", "0"], ["0.00", "-1.0e-9", "-0.000000001"], ["-0.50", "-5.0e-1", "-0.5"]];
    let text = table.text();
    let shown: Vec<Vec<&str>> = text.lines().skip(2).map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(shown, cells);
}

#[test]
fn numbers_are_told_in_si_units_and_frequencies_in_hertz_as_well() {
    // Truth: 3 m a unit of length, 0.5 s a unit of time.
    let units = Units { length_m: 3.0, mass_kg: 1.0, time_s: 0.5, velocity_m_per_s: 6.0, force_n: 1.0, energy_j: 1.0 };
    let table = Table::of("t", &[(2.0, 4.0)])
        .si(Some(&units))
        .col("a", Fixed(2), "", |row| row.0)
        .kind(Quantity::Length)
        .col("omega", Fixed(3), "", |row| row.1)
        .kind(Quantity::Omega)
        .done();
    assert_eq!(table.json()[0]["a"], 6.0);
    assert_eq!(table.json()[0]["omega"], 8.0);
    assert_eq!(table.json()[0]["frequency"], 8.0 / std::f64::consts::TAU);
    assert_eq!(table.csv().lines().next().unwrap(), "a,omega,frequency");
    assert!(table.text().starts_with(" a (m)  frequency (Hz)\n"), "{}", table.text());
    assert!(table.text().contains("6.00e0         1.273e0"), "{}", table.text());
    assert_eq!(table.line("", ["a", "omega"]).points, [(6.0, 8.0)]);
}

#[test]
fn a_wide_table_is_cut_into_two_with_its_first_column_twice() {
    let mut table = Table::of("t", &["first"]).col("name", Short, "", |name| *name);
    for k in 0..12 {
        table = table.col(format!("a_long_name_{k}"), Fixed(1), "", move |_| f64::from(k));
    }
    let text = table.done().text();
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    assert_eq!(text.matches("first").count(), 2);
    assert_eq!(text.matches("a long name").count(), 12);
}

#[test]
fn on_a_narrow_terminal_headings_and_words_are_cut_into_lines_and_no_column_is_lost() {
    let rows = [("takahashi-imada-linear", 1e-3), ("plain rotation and a kick", f64::NAN)];
    let mut table = Table::of("t", &rows).col("name", Short, "", |row| row.0);
    for k in 0..5 {
        table = table.col(format!("error_of_energy_{k}"), Power(1), "", |row| row.1);
    }
    let report = Report::new("t").words("word ".repeat(40)).table(table);
    for width in [70, 80, 119] {
        let text = report.text_in(width);
        assert!(text.lines().all(|line| line.chars().count() <= width), "{width}: {text}");
        assert_eq!((text.matches("1.0e-3").count(), text.matches('–').count()), (5, 5), "{width}: {text}");
        assert_eq!(text.matches("takahashi-imada-linear").count(), 1, "{width}: {text}");
        assert!(text.contains("plain rotation and a kick") || width == 70, "{width}: {text}");
    }
    assert_eq!(report.text_in(500), report.text());
}

#[test]
fn a_page_fetches_nothing_and_escapes_what_it_is_given() {
    let line = Line::new("one", [(1.0, 2.0)]);
    let panel = Panel::new(Kind::Sites, ["n", "x"], vec![line]);
    let picture = Panels::column("a \"b\"", vec![panel], "α < 2");
    let shown = Shown::new(Report::new("one").words("1 < 2 & <script>").picture(picture)).unwrap();
    let results = vec![Ok(shown), Err("no <reason>".into())];
    let section =
        Section { name: "one", title: "One", shows: "nothing".into(), found: None, results, wall: Duration::ZERO };
    let page = Page { sections: vec![section] };
    let html = page.html();
    for wanted in [
        "1 &lt; 2 &amp; &lt;script&gt;",
        "a &quot;b&quot;",
        "α &lt; 2",
        "data:image/svg+xml;charset=utf-8,&lt;svg",
        "no &lt;reason&gt;",
        "href=\"#one-findings\"",
    ] {
        assert!(html.contains(wanted) || (cfg!(not(feature = "plot")) && wanted.contains("svg")), "{wanted}");
    }
    for foreign in ["<script src", "1 < 2", "http:", "https:", "@import", "url("] {
        assert!(!html.contains(foreign), "{foreign}");
    }
    assert_eq!(page.sections[0].failures().collect::<Vec<_>>(), ["no <reason>"]);
    assert!(page.report().text().contains("1 FAILED"));
}

#[test]
fn dates_are_those_of_the_calendar() {
    // Truth: dates of known numbers of seconds, leap days and ends of centuries among them.
    for (seconds, expected) in [
        (0, "1970-01-01 00:00 UTC"),
        (951_782_399, "2000-02-28 23:59 UTC"),
        (951_782_400, "2000-02-29 00:00 UTC"),
        (1_709_251_199, "2024-02-29 23:59 UTC"),
        (1_767_225_600, "2026-01-01 00:00 UTC"),
        (4_107_542_400, "2100-03-01 00:00 UTC"),
    ] {
        assert_eq!(date(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds)), expected);
    }
}

#[test]
fn verdicts_stand_first_in_colour() {
    let rows = [["a", "holds"], ["b", "differs"], ["c", "not decidable"], ["d", "agrees"]];
    let table =
        Table::of("t", &rows).col("item", Short, "what it is", |row| row[0]).col("verdict", Short, "", |row| row[1]);
    let table = table.done();
    assert!(judged(&table));
    let html = table_html(&table, false, &BTreeMap::new()).into_string();
    assert!(html.contains("<td class=\"bad\">differs</td><td class=\"short\">b</td>"), "{html}");
    assert!(html.contains("item: what it is."), "{html}");
    let bad = table_html(&table, true, &BTreeMap::new()).into_string();
    assert!(bad.contains("differs") && !bad.contains("holds") && !bad.contains("agrees"), "{bad}");
}
