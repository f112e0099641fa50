//! One HTML page of reports: findings, then pictures, then tables. All of these are inside, and
//! nothing is fetched from elsewhere; the data are in an archive beside the page.

use super::{machine, machine_json};
use crate::{
    figures::Format::{Png, Svg},
    output::{NpzWriter, PROGRAM, in_memory},
    report::{
        self, Block,
        Digits::{Fixed, Json, Short},
        Report, Table,
    },
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

/// Title, caption and file of a picture, and whether it has colours for values, which stay as they are
/// on a dark page; without a file in builds without pictures. The file has no caption of its own.
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

    /// Verdicts among the findings: good, bad and open ones.
    fn verdicts(&self) -> [usize; 3] {
        let of = |(block, finding): (&Block, bool)| match block {
            Block::Table(table) if finding => verdicts(table),
            _ => [0; 3],
        };
        // A report has at most one table of verdicts among its findings.
        self.report.blocks().map(of).max().unwrap_or_default()
    }

    /// Paragraphs about a row of a table of verdicts, by the first cell of the row, with which they begin.
    fn notes(&self) -> BTreeMap<String, String> {
        let judged = self.report.tables().filter(|table| verdicts(table) != [0; 3]);
        let ids: Vec<String> =
            judged.flat_map(|table| table.cells().1).filter_map(|row| row.into_iter().next()).collect();
        let words = self
            .report
            .blocks()
            .filter_map(|(block, _)| if let Block::Words(words) = block { Some(words) } else { None });
        let note = |words: &String| words.split_once(": ").map(|(id, note)| (id.to_owned(), note.trim().to_owned()));
        words.filter_map(note).filter(|(id, _)| ids.contains(id)).collect()
    }

    /// Findings, or all else; of a table of verdicts among the findings those that are bad, then all of
    /// it. Large tables are in the archive only.
    fn blocks(&self, findings: bool) -> impl Iterator<Item = Markup> {
        let notes = self.notes();
        let noted = |words: &str| words.split_once(": ").is_some_and(|(id, _)| notes.contains_key(id));
        let html = |(block, finding): (&Block, bool)| match block {
            Block::Words(words) => (finding == findings && !noted(words)).then(|| html! { p.words { (words.trim()) } }),
            Block::Table(table) => {
                let judged = verdicts(table) != [0; 3];
                let small = judged || table.cells().1.len() <= LARGE;
                let here = finding == findings || (judged && !findings);
                (here && small).then(|| table_html(table, judged && findings, &notes))
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

    fn shown(&self) -> impl Iterator<Item = &Shown> {
        self.results.iter().filter_map(|result| result.as_ref().ok())
    }

    fn count(&self) -> usize {
        self.shown().flat_map(|shown| &shown.pictures).filter(|picture| !picture.2.is_empty()).count()
    }

    /// Names of the files of data in the archive, and their contents, report by report.
    fn data(&self) -> impl Iterator<Item = Vec<(String, Vec<u8>)>> {
        self.results.iter().enumerate().filter_map(|(k, result)| {
            let number = if self.results.len() > 1 { format!("{}-", k + 1) } else { String::new() };
            let named = |(name, bytes)| (format!("{}/{number}{name}", self.name), bytes);
            Some(result.as_ref().ok()?.report.csv().map(named).collect())
        })
    }

    fn findings(&self) -> Markup {
        html! {
            @for why in self.failures() { p.failure { "Failed: " (why) } }
            @for block in self.shown().flat_map(|shown| shown.blocks(true)) { (block) }
        }
    }

    fn pictures(&self) -> Markup {
        html! { @for shown in self.shown() { (shown.pictures()) } }
    }

    fn tables(&self) -> Markup {
        html! {
            @for (shown, data) in self.shown().zip(self.data()) {
                @for block in shown.blocks(false) { (block) }
                @if let [(first, _), more @ ..] = &data[..] {
                    p.data {
                        @if let Some((title, ..)) = shown.pictures.first() { (title) ". " }
                        "Data in " a href=(FILES[1]) { (FILES[1]) } ": " (first) @for (name, _) in more { ", " (name) }
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
            let mut all = self.sections.iter().flat_map(Section::data).flatten();
            all.try_for_each(|(name, bytes)| archive.file(&name, &bytes))?;
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
                        @let found: Vec<&String> = self.sections.iter().filter_map(|section| section.found.as_ref()).collect();
                        @if !found.is_empty() { ol.found { @for words in found { li { (words) } } } }
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
        let counts: Vec<_> = sections.iter().flat_map(Section::shown).map(Shown::verdicts).collect();
        let [good, bad, open] = std::array::from_fn(|k| counts.iter().map(|counts| counts[k]).sum::<usize>());
        let ended = if failures == 0 { "good" } else { "bad" };
        html! {
            div.summary {
                dl {
                    dt { "made in" } dd { (format!("{wall:.0}")) " s" }
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

/// Numbers of good, bad and open verdicts in a table. Only tables whose last column has the verdict
/// are counted: others repeat verdicts.
pub fn verdicts(table: &Table) -> [usize; 3] {
    let (head, rows) = table.cells();
    if head.last().is_none_or(|name| name != VERDICT) {
        return [0; 3];
    }
    let classes: Vec<&str> = rows.iter().filter_map(|row| row.last()).map(|cell| class(cell)).collect();
    ["good", "bad", "open"].map(|class| classes.iter().filter(|one| **one == class).count())
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
/// bad ones, if asked for. A row has its note, by its first cell.
pub fn table_html(table: &Table, bad: bool, notes: &BTreeMap<String, String>) -> Markup {
    let (mut head, mut rows) = table.cells();
    rows.retain(|row| !bad || row.last().is_some_and(|cell| class(cell) == "bad"));
    if head.is_empty() || rows.is_empty() {
        return html! {};
    }
    let noted: Vec<&str> = rows.iter().map(|row| notes.get(&row[0]).map_or("", String::as_str)).collect();
    if noted.iter().any(|note| !note.is_empty()) {
        head.push("note".to_owned());
        rows.iter_mut().zip(&noted).for_each(|(row, note)| row.push((*note).to_owned()));
    }
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
