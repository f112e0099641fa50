//! One self-contained HTML page of reports: tables, pictures and their data are inside, and nothing
//! is fetched from elsewhere.

use super::{machine, machine_json};
use crate::{
    output::PROGRAM,
    report::{
        self, Block,
        Digits::{Fixed, Json, Short},
        Report, Table,
    },
};
use base64::{Engine, engine::general_purpose::STANDARD};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::json;
use std::time::{Duration, SystemTime};

/// A page.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// The parts of the page, from the top.
    pub sections: Vec<Section>,
}

/// A part of a page.
#[derive(Clone, Debug)]
pub struct Section {
    /// Name of the part on the command line, and of its anchor.
    pub name: &'static str,
    /// Title.
    pub title: &'static str,
    /// What it shows, in one sentence.
    pub shows: String,
    /// Its contents, from the top, or why there are none.
    pub results: Vec<Result<Shown, String>>,
    /// Wall time that the part took.
    pub wall: Duration,
}

/// A report with its pictures.
#[derive(Clone, Debug)]
pub struct Shown {
    report: Report,
    pictures: Vec<Picture>,
}

/// Title, caption and SVG file of a picture; without a file in builds without pictures.
type Picture = (String, String, Vec<u8>);

impl Shown {
    /// Draws the pictures of a report.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn new(report: Report) -> crate::error::Result<Self> {
        let drawn = |(_, figure): &(String, report::Figure)| {
            let [title, caption] = figure.clone().words().map(|words| words.clone());
            #[cfg(feature = "plot")]
            let svg = figure.draw()?.file(crate::figures::Format::Svg)?;
            #[cfg(not(feature = "plot"))]
            let svg = Vec::new();
            Ok((title, caption, svg))
        };
        let pictures = report.pictures().iter().map(drawn).collect::<crate::error::Result<_>>()?;
        Ok(Self { report, pictures })
    }

    fn tables(&self) -> impl Iterator<Item = &Table> {
        self.report.tables()
    }

    fn html(&self) -> Markup {
        let block = |block: &Block| match block {
            Block::Words(words) => html! { p.words { (words.trim()) } },
            Block::Table(table) => table_html(table),
        };
        html! {
            @for (title, caption, svg) in &self.pictures {
                figure {
                    @if !svg.is_empty() {
                        button.zoom type="button" title="Show large" { img alt=(title) src=(uri("image/svg+xml", svg)); }
                    }
                    figcaption { strong { (title) ". " } (caption) }
                }
            }
            @for one in self.report.blocks() { (block(one)) }
            @if self.report.csv().next().is_some() {
                p.data { "Data: "
                    @for (k, (name, bytes)) in self.report.csv().enumerate() {
                        @if k > 0 { ", " }
                        a download=(name) href=(uri("text/plain", &bytes)) { (name) }
                    }
                }
            }
        }
    }
}

impl Section {
    /// Why results are missing, and what their reports say that failed.
    pub fn failures(&self) -> impl Iterator<Item = &str> {
        self.results.iter().filter_map(|result| match result {
            Ok(shown) => shown.report.error(),
            Err(why) => Some(why),
        })
    }

    fn shown(&self) -> impl Iterator<Item = &Shown> {
        self.results.iter().filter_map(|result| result.as_ref().ok())
    }

    fn pictures(&self) -> usize {
        self.shown().flat_map(|shown| &shown.pictures).filter(|picture| !picture.2.is_empty()).count()
    }

    fn html(&self) -> Markup {
        html! {
            section id=(self.name) {
                h2 { (self.title) }
                p.shows { (self.shows) }
                @for shown in self.shown() { (shown.html()) }
                @for why in self.failures() { p.failure { "Failed: " (why) } }
                p { small { "Made in " (format!("{:.1}", self.wall.as_secs_f64())) " s." } }
            }
        }
    }
}

/// Style sheet: for screens of any width (tables scroll), dark mode and print.
const STYLE: &str = include_str!("style.css");
/// Script that sorts tables and shows pictures large. The page is complete without it.
const SCRIPT: &str = include_str!("page.js");

impl Page {
    /// The page as HTML.
    pub fn html(&self) -> String {
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content=(PROGRAM);
                    title { "Report of " (PROGRAM) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    header {
                        h1 { "Report of " (PROGRAM) }
                        p { "Nonlinear waves in locally resonant Hertzian chains: what this program computes on this machine, and how well." }
                        (self.summary())
                    }
                    div.columns {
                        nav aria-label="Contents" {
                            ul { @for section in &self.sections { li { a href={ "#" (section.name) } { (section.title) } } } }
                        }
                        main { @for section in &self.sections { (section.html()) } }
                    }
                    dialog aria-label="A picture, large" { button type="button" { "Close" } }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        };
        page.into_string()
    }

    /// Date, machine, and what was made.
    fn summary(&self) -> Markup {
        let sections = &self.sections;
        let pictures: usize = sections.iter().map(Section::pictures).sum();
        let failures: usize = sections.iter().map(|section| section.failures().count()).sum();
        let wall: f64 = sections.iter().map(|section| section.wall.as_secs_f64()).sum();
        let tables = sections.iter().flat_map(Section::shown).flat_map(Shown::tables).map(verdicts);
        let [good, bad, open] = tables.fold([0; 3], |sums, counts| std::array::from_fn(|k| sums[k] + counts[k]));
        let ended = if failures == 0 { "good" } else { "bad" };
        html! {
            div.summary {
                dl {
                    dt { "made on" } dd { (date(SystemTime::now())) ", in " (format!("{wall:.0}")) " s" }
                    dt { "parts" } dd { (sections.len()) ", " (pictures) " pictures, " span class=(ended) { (failures) " failed" } }
                    @if good + bad + open > 0 {
                        dt { "verdicts" }
                        dd {
                            span.good { (good) " agree or hold" } ", " span.bad { (bad) " differ or fail" } ", "
                            span.open { (open) " open" }
                        }
                    }
                    @for (name, value) in machine() { dt { (name) } dd { (value) } }
                }
            }
        }
    }

    /// What was made.
    pub fn report(&self) -> Report {
        let failures = |one: &Section| one.failures().map(str::to_owned).collect::<Vec<_>>();
        let outcome = move |one: &Section| match failures(one).len() {
            0 => "ok".to_owned(),
            failures => format!("{failures} FAILED"),
        };
        let table = Table::of("sections", &self.sections)
            .key("sections")
            .col("name", Short, "", |one| one.name)
            .head("section")
            .col("outcome", Short, "", outcome)
            .col("pictures", Short, "", Section::pictures)
            .col("wall_s", Fixed(1), "", |one| one.wall.as_secs_f64())
            .head("wall (s)")
            .col("shows", Json, "", |one| one.shows.clone())
            .col("title", Json, "", |one| one.title)
            .col("failures", Json, "", move |one| json!(failures(one)));
        let shows = self.sections.iter().map(|one| format!("{}: {}\n", one.title, one.shows)).collect();
        Report::new("report").table(table).lines(shows).fact("machine", machine_json())
    }
}

/// Numbers of good, bad and open verdicts in a table. Only tables whose last column has the verdict
/// are counted: others repeat verdicts.
fn verdicts(table: &Table) -> [usize; 3] {
    let (head, rows) = table.cells();
    if head.last().is_none_or(|name| name != VERDICT) {
        return [0; 3];
    }
    let classes: Vec<&str> = rows.iter().filter_map(|row| row.last()).map(|cell| class(cell)).collect();
    ["good", "bad", "open"].map(|class| classes.iter().filter(|one| **one == class).count())
}

/// A link that contains the whole file.
fn uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// The column that is shown first, and in colour.
const VERDICT: &str = "verdict";

/// The style class of a verdict; empty for any other cell.
fn class(cell: &str) -> &'static str {
    match cell {
        "agrees" | "holds" | "bounded" | "ok" => "good",
        "differs" | "fails" | "violated" | "FAILED" => "bad",
        "not decidable" | "undecided" => "open",
        _ => "",
    }
}

/// A table with its legend; nothing if it has no column or no row for people.
fn table_html(table: &Table) -> Markup {
    let (head, rows) = table.cells();
    if head.is_empty() || rows.is_empty() {
        return html! {};
    }
    let mut columns: Vec<usize> = (0..head.len()).collect();
    columns.sort_by_key(|&column| head[column] != VERDICT);
    let numbers = |column: usize| {
        let mut cells = rows.iter().map(|row| &row[column]).filter(|cell| !cell.is_empty());
        cells.all(|cell| cell == "–" || cell.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
    };
    let class = |row: &[String], column: usize| if numbers(column) { "number" } else { class(&row[column]) };
    html! {
        div.wide tabindex="0" {
            table {
                thead { tr { @for &column in &columns { th scope="col" { button type="button" { (head[column]) } } } } }
                tbody {
                    @for row in &rows {
                        tr { @for &column in &columns { td class=(class(row, column)) { (row[column]) } } }
                    }
                }
            }
        }
        @if !table.legend().is_empty() { p.words { (table.legend()) } }
    }
}

/// A time as date and time of day, in UTC.
///
/// Days are counted from 0000-03-01 and years from March, so that the leap day is the last day of a
/// year.
fn date(time: SystemTime) -> String {
    let seconds = time.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_secs());
    // Days since 0000-03-01.
    let days = seconds / 86_400 + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let from_march = (5 * of_year + 2) / 153;
    let of_month = of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = 400 * era + year + u64::from(month <= 2);
    let (hour, minute) = (seconds / 3600 % 24, seconds / 60 % 60);
    format!("{year}-{month:02}-{of_month:02} {hour:02}:{minute:02} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_fetches_nothing_and_escapes_what_it_is_given() {
        let line = report::Line::new("one", [(1.0, 2.0)]);
        let panel = report::Panel::new(report::Kind::Sites, ["n", "x"], vec![line]);
        let picture = report::Panels::column("a \"b\"", vec![panel], "α < 2");
        let shown = Shown::new(Report::new("one").words("1 < 2 & <script>").picture(picture)).unwrap();
        let results = vec![Ok(shown), Err("no <reason>".into())];
        let section = Section { name: "one", title: "One", shows: "nothing".into(), results, wall: Duration::ZERO };
        let page = Page { sections: vec![section] };
        let html = page.html();
        for wanted in [
            "1 &lt; 2 &amp; &lt;script&gt;",
            "a &quot;b&quot;",
            "α &lt; 2",
            "data:image/svg+xml;base64,",
            "no &lt;reason&gt;",
            "href=\"#one\"",
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
    fn verdicts_are_counted_and_stand_first_in_colour() {
        let rows = [["a", "holds"], ["b", "differs"], ["c", "not decidable"], ["d", "agrees"]];
        let table = report::Table::of("t", &rows).col("item", report::Digits::Short, "what it is", |row| row[0]).col(
            "verdict",
            report::Digits::Short,
            "",
            |row| row[1],
        );
        let table = table.done();
        assert_eq!(verdicts(&table), [2, 1, 1]);
        let html = table_html(&table).into_string();
        assert!(html.contains("<td class=\"bad\">differs</td><td class=\"\">b</td>"), "{html}");
        assert!(html.contains("item: what it is."), "{html}");
    }
}
