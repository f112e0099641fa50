//! One HTML page of reports: findings, then pictures, then tables. All of these are inside, and
//! nothing is fetched from elsewhere; the data are in an archive beside the page.

use super::{machine, machine_json};
use crate::{
    figures::Format::{Png, Svg},
    letters::{Level, runs},
    output::{NpzWriter, PROGRAM, in_memory},
    report::{self, Block, Fixed, Json, Report, Short, Table},
};
use base64::{Engine, engine::general_purpose::STANDARD};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::json;
use std::{collections::BTreeMap, time::Duration};

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
    /// What was found, for the top of the page.
    pub found: Option<String>,
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

/// Title, caption and file of a picture, and whether it has colours for values, which stay as they
/// are on a dark page; without a file in builds without pictures. The file has no caption of its
/// own.
type Picture = (String, String, Vec<u8>, bool);

/// Size of an SVG file, in bytes, above which a picture is a PNG file if that is smaller.
const DENSE: usize = 100_000;
/// The names of the page and of the archive of data.
const FILES: [&str; 2] = ["report.html", "report.zip"];

impl Shown {
    /// Draws the pictures of a report.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn new(report: Report) -> crate::error::Result<Self> {
        let drawn = |(_, figure): &(String, report::Figure)| {
            let mut figure = figure.clone();
            let [title, caption] = figure.words();
            let (title, caption) = (title.clone(), std::mem::take(caption));
            let (drawn, mut file) = (figure.draw()?, Vec::new());
            let svg = drawn.file(Svg)?;
            let mapped = String::from_utf8_lossy(&svg).contains("<image");
            if svg.len() > DENSE {
                file = drawn.file(Png)?;
            }
            let file = if file.is_empty() || svg.len() < file.len() { svg } else { file };
            Ok((title, caption, file, mapped))
        };
        let pictures = report.pictures().iter().map(drawn).collect::<crate::error::Result<_>>()?;
        Ok(Self { report, pictures })
    }

    /// Paragraphs about a row of a table of verdicts, by the first cell of the row, with which they
    /// begin.
    fn notes(&self) -> BTreeMap<String, String> {
        let judged = self.report.tables().filter(|table| judged(table));
        let ids: Vec<String> =
            judged.flat_map(|table| table.cells().1).filter_map(|row| row.into_iter().next()).collect();
        let words = self
            .report
            .blocks()
            .filter_map(|(block, _)| if let Block::Words(words) = block { Some(words) } else { None });
        let note = |words: &String| words.split_once(": ").map(|(id, note)| (id.to_owned(), note.trim().to_owned()));
        words.filter_map(note).filter(|(id, _)| ids.contains(id)).collect()
    }

    /// Findings, or all else; of a table of verdicts among the findings those that are bad, then
    /// all of it. Of a large table it says the name in the archive, which begins with `place`.
    fn blocks(&self, findings: bool, place: &str) -> impl Iterator<Item = Markup> {
        let notes = self.notes();
        let noted = |words: &str| words.split_once(": ").is_some_and(|(id, _)| notes.contains_key(id));
        let html = |(block, finding): (&Block, bool)| match block {
            Block::Words(words) => (finding == findings && !noted(words)).then(|| html! { p.words { (words.trim()) } }),
            Block::Table(table) => {
                let (judged, count) = (judged(table), table.cells().1.len());
                let html = || match judged || count <= LARGE {
                    true => table_html(table, judged && findings, &notes),
                    false => {
                        html! { p.data { "Table of " (count) " rows: " (place) (table.name()) ".csv in " (archive()) } }
                    }
                };
                (finding == findings || (judged && !findings)).then(html)
            }
        };
        self.report.blocks().filter_map(html).collect::<Vec<_>>().into_iter()
    }

    fn pictures(&self) -> Markup {
        html! {
            @for (title, caption, file, mapped) in &self.pictures {
                figure {
                    @if !file.is_empty() {
                        button.zoom type="button" title="Show large" { img.map[*mapped] alt=(title) src=(uri(file)); }
                    }
                    figcaption { strong { (title) ". " } (caption) }
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

    /// The reports, each with what its files in the archive begin with.
    fn shown(&self) -> impl Iterator<Item = (String, &Shown)> {
        self.results.iter().enumerate().filter_map(|(k, result)| {
            let number = if self.results.len() > 1 { format!("{}-", k + 1) } else { String::new() };
            Some((format!("{}/{number}", self.name), result.as_ref().ok()?))
        })
    }

    fn count(&self) -> usize {
        self.shown().flat_map(|(_, shown)| &shown.pictures).filter(|picture| !picture.2.is_empty()).count()
    }

    fn findings(&self) -> Markup {
        html! {
            @for why in self.failures() { p.failure { "Failed: " (why) } }
            @for (place, shown) in self.shown() { @for block in shown.blocks(true, &place) { (block) } }
        }
    }

    fn pictures(&self) -> Markup {
        html! { @for (_, shown) in self.shown() { (shown.pictures()) } }
    }

    fn tables(&self) -> Markup {
        html! {
            @for (place, shown) in self.shown() {
                @for block in shown.blocks(false, &place) { (block) }
                @let names: Vec<String> = shown.report.tables().map(|table| format!("{place}{}.csv", table.name())).collect();
                @if !names.is_empty() {
                    p.data {
                        @if let Some((title, ..)) = shown.pictures.first() { (title) ". " }
                        "Data in " (archive()) ": " (names.join(", "))
                    }
                }
            }
            p { small { "Made in " (format!("{:.1}", self.wall.as_secs_f64())) " s." } }
        }
    }
}

/// A chapter of the page: anchor, title, and what it has of a section.
type Chapter = (&'static str, &'static str, fn(&Section) -> Markup);

const CHAPTERS: [Chapter; 3] = [
    ("findings", "Findings", Section::findings),
    ("figures", "Figures", Section::pictures),
    ("tables", "Tables", Section::tables),
];

/// Style sheet: for screens of any width (tables scroll), dark mode and print.
const STYLE: &str = include_str!("style.css");
/// Script that sorts tables and shows pictures large. The page is complete without it.
const SCRIPT: &str = include_str!("page.js");

impl Page {
    /// The files: the page, and the archive of data.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn files(&self) -> crate::error::Result<[(&'static str, Vec<u8>); 2]> {
        let archive = in_memory(|bytes| {
            let mut archive = NpzWriter::new(bytes, None)?.compress(true);
            for (place, shown) in self.sections.iter().flat_map(Section::shown) {
                shown.report.csv().try_for_each(|(name, bytes)| archive.file(&format!("{place}{name}"), &bytes))?;
            }
            archive.finish()
        })?;
        Ok([(FILES[0], self.html().into_bytes()), (FILES[1], archive)])
    }

    /// The page as HTML.
    pub fn html(&self) -> String {
        // Sections that a chapter has something of; the first of each says what it shows.
        let parts = CHAPTERS.map(|(chapter, _, of)| {
            let all =
                self.sections.iter().map(move |section| (format!("{}-{chapter}", section.name), section, of(section)));
            all.filter(|(.., content)| !content.0.is_empty()).collect::<Vec<_>>()
        });
        let first = |id: &str, section: &Section| {
            let mut all = parts.iter().flatten().filter(|part| part.1.name == section.name);
            all.next().is_some_and(|part| part.0 == id)
        };
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
                        ol.found {
                            @for (words, section) in self.sections.iter().filter_map(|one| Some((one.found.as_ref()?, one))) {
                                @let place = parts.iter().flatten().find(|part| part.1.name == section.name);
                                li { (words) @if let Some((id, ..)) = place { " " a href={ "#" (id) } { (section.title) } } }
                            }
                        }
                        (self.summary())
                    }
                    div.columns {
                        nav aria-label="Contents" {
                            @for ((chapter, title, _), parts) in CHAPTERS.iter().zip(&parts) {
                                @if !parts.is_empty() {
                                    a href={ "#" (chapter) } { (title) }
                                    ul { @for (id, section, _) in parts { li { a href={ "#" (id) } { (section.title) } } } }
                                }
                            }
                        }
                        main {
                            @for ((chapter, title, _), parts) in CHAPTERS.iter().zip(&parts) {
                                @if !parts.is_empty() { h2 id=(chapter) { (title) } }
                                @for (id, section, content) in parts {
                                    section id=(id) {
                                        h3 { (section.title) }
                                        @if first(id, section) { p.shows { (section.shows) } }
                                        (content)
                                    }
                                }
                            }
                        }
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
        let pictures: usize = sections.iter().map(Section::count).sum();
        let failures: usize = sections.iter().map(|section| section.failures().count()).sum();
        let wall: f64 = sections.iter().map(|section| section.wall.as_secs_f64()).sum();
        let ended = if failures == 0 { "good" } else { "bad" };
        html! {
            div.summary {
                dl {
                    dt { "made in" } dd { (format!("{wall:.0}")) " s" }
                    dt { "parts" } dd { (sections.len()) ", " (pictures) " pictures, " span class=(ended) { (failures) " failed" } }
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
            .col("pictures", Short, "", Section::count)
            .col("wall_s", Fixed(1), "", |one| one.wall.as_secs_f64())
            .head("wall (s)")
            .col("shows", Json, "", |one| one.shows.clone())
            .col("title", Json, "", |one| one.title)
            .col("failures", Json, "", move |one| json!(failures(one)));
        let shows = self.sections.iter().map(|one| format!("{}: {}\n", one.title, one.shows)).collect();
        Report::new("report").table(table).lines(shows).fact("machine", machine_json())
    }
}

/// Whether the last column of a table has verdicts.
pub fn judged(table: &Table) -> bool {
    table.cells().0.last().is_some_and(|name| name == VERDICT)
}

/// A link that contains the whole file of a picture. An SVG file stays text, which takes a quarter
/// less than base 64.
fn uri(file: &[u8]) -> String {
    match std::str::from_utf8(file) {
        Ok(svg) => {
            let coded = [("%", "%25"), ("#", "%23"), (":", "%3A"), ("\"", "'")];
            let svg = coded.iter().fold(svg.to_owned(), |svg, (from, to)| svg.replace(from, to));
            format!("data:image/svg+xml;charset=utf-8,{svg}")
        }
        Err(_) => format!("data:image/png;base64,{}", STANDARD.encode(file)),
    }
}

fn archive() -> Markup {
    html! { a href=(FILES[1]) { (FILES[1]) } }
}

/// Words of text output, and what stands for them on the page.
const LETTERS: &str = "alpha α beta β delta δ dtau dτ epsilon ε eps ε zeta ζ kappa κ lambda λ mu μ pi π rho ρ sigma σ tau τ \
                       phi φ psi ψ omega ω Delta Δ Omega Ω sqrt √ <= ≤ >= ≥";

/// A text of the terminal with Greek letters, subscripts and superscripts.
fn set(text: &str) -> Markup {
    let (mut words, mut rest) = (String::new(), text);
    while let Some(first) = rest.chars().next() {
        let same = |c: char| (c.is_ascii_alphabetic(), "<>=".contains(c));
        let (word, after) = rest.split_at(rest.find(|c| same(c) != same(first)).unwrap_or(rest.len()));
        // Not within names such as tw-rho3 and large_rho.
        let digit = |c: char| c.is_ascii_digit();
        let long = words.ends_with('_') && words.chars().nth_back(2).is_some_and(char::is_alphanumeric);
        let named = long || words.ends_with(digit) || after.starts_with(digit);
        let letter = LETTERS.split(' ').skip_while(|name| *name != word).nth(1);
        words += letter.filter(|_| !(named && first.is_ascii_alphabetic())).unwrap_or(word);
        rest = after;
    }
    html! {
        @for (level, part) in runs(&words) {
            @match level { Level::Line => (part), Level::Sub => sub { (part) }, Level::Super => sup { (part) } }
        }
    }
}

/// Rows of the largest table on the page.
const LARGE: usize = 40;
/// Longest cell that is never cut into lines, in characters.
const SHORT: usize = 24;
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

/// A table with its legend; nothing if it has no column or no row for people. Of verdicts only the
/// bad ones, if asked for. Below a row stands its note, by its first cell.
pub fn table_html(table: &Table, bad: bool, notes: &BTreeMap<String, String>) -> Markup {
    let (head, mut rows) = table.cells();
    rows.retain(|row| !bad || row.last().is_some_and(|cell| class(cell) == "bad"));
    if head.is_empty() || rows.is_empty() {
        return html! {};
    }
    let noted = rows.iter().any(|row| notes.contains_key(&row[0]));
    let mut columns: Vec<usize> = (0..head.len()).collect();
    columns.sort_by_key(|&column| head[column] != VERDICT);
    let numbers = |column: usize| {
        let mut cells = rows.iter().map(|row| &row[column]).filter(|cell| !cell.is_empty());
        cells.all(|cell| cell == "–" || cell.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
    };
    let class = |row: &[String], column: usize| match class(&row[column]) {
        _ if numbers(column) => "number",
        // Short cells are not cut into lines.
        "" if row[column].chars().count() <= SHORT => "short",
        class => class,
    };
    // The first cell is a name.
    let cell = |row: &[String], column: usize| {
        if noted && column > 0 {
            set(&row[column])
        } else {
            html! { (row[column]) }
        }
    };
    let told = |column: usize| noted.then(|| &head[column]);
    html! {
        div.wide tabindex="0" {
            table class=[noted.then_some("noted")] {
                thead { tr { @for &column in &columns { th scope="col" { button type="button" { (head[column]) } } } } }
                @for row in &rows {
                    tbody {
                        tr { @for &column in &columns { td class=(class(row, column)) data-head=[told(column)] { (cell(row, column)) } } }
                        @if let Some(note) = notes.get(&row[0]) { tr.note { td colspan=(columns.len()) { div { (set(note)) } } } }
                    }
                }
            }
        }
        @if !table.legend().is_empty() { p.words { (table.legend()) } }
    }
}
