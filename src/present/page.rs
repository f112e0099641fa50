//! One self-contained HTML page of everything: tables and pictures inside, nothing fetched from
//! elsewhere.

use super::{machine, machine_json};
use crate::output::to_json;
use base64::{Engine, engine::general_purpose::STANDARD};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::json;
use std::time::Duration;

/// A page.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Its parts.
    pub sections: Vec<Section>,
}

/// A part of a page.
#[derive(Clone, Debug)]
pub struct Section {
    /// Name, of its anchor and on the command line.
    pub name: &'static str,
    /// Title.
    pub title: &'static str,
    /// What it shows, in one sentence.
    pub shows: String,
    /// What stands in it.
    pub blocks: Vec<Block>,
    /// Wall time of its making.
    pub wall: Duration,
}

/// What stands in a part.
#[derive(Clone, Debug)]
pub enum Block {
    /// A table as plain text.
    Table(String),
    /// A picture.
    Picture {
        /// Title, also for those who do not see it.
        title: String,
        /// What can be seen.
        caption: String,
        /// The file.
        svg: Vec<u8>,
    },
    /// What could not be made, and why.
    Failure(String),
}

impl Section {
    /// What failed in it.
    pub fn failures(&self) -> impl Iterator<Item = &str> {
        self.blocks.iter().filter_map(|block| if let Block::Failure(why) = block { Some(why.as_str()) } else { None })
    }

    fn pictures(&self) -> usize {
        self.blocks.iter().filter(|block| matches!(block, Block::Picture { .. })).count()
    }
}

/// Legible on a phone, where tables scroll, and on paper, where they shrink.
const STYLE: &str = "
:root { color-scheme: light; }
body { font: 1rem/1.5 system-ui, sans-serif; color: #1e1e1e; background: #fff; max-width: 72rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; }
h2 { font-size: 1.25rem; border-bottom: 1px solid #ccc; margin-top: 2.5rem; }
nav ul { display: flex; flex-wrap: wrap; gap: .3rem 1.2rem; padding: 0; list-style: none; }
a { color: #0060a0; }
pre { overflow-x: auto; font-size: .72rem; line-height: 1.35; background: #f6f6f6; padding: .6rem; border-radius: .3rem; }
figure { margin: 1.5rem 0; }
img { max-width: 100%; height: auto; border: 1px solid #ddd; }
figcaption { font-size: .85rem; color: #444; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0 1rem; font-size: .9rem; }
dt { color: #555; } dd { margin: 0; overflow-wrap: anywhere; }
.failure { border-left: .3rem solid #b00020; padding-left: .7rem; }
.shows { font-size: 1.05rem; }
@media print {
  body { max-width: none; padding: 0; font-size: 9pt; }
  nav { display: none; }
  pre { font-size: 5.5pt; overflow: visible; white-space: pre-wrap; background: none; }
  figure { break-inside: avoid; }
  h2, .shows { break-after: avoid; }
  img { max-height: 20cm; }
}
";

impl Page {
    /// The page as HTML.
    pub fn html(&self) -> String {
        let version = concat!("hertzchain ", env!("CARGO_PKG_VERSION"));
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content=(version);
                    title { "Report of " (version) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    h1 { "Report of " (version) }
                    p { "Nonlinear waves in locally resonant Hertzian chains: what this program computes on this machine, and how well." }
                    dl { @for (name, value) in machine() { dt { (name) } dd { (value) } } }
                    nav { ul { @for section in &self.sections { li { a href={ "#" (section.name) } { (section.title) } } } } }
                    main { @for section in &self.sections { (section.html()) } }
                }
            }
        };
        page.into_string()
    }

    /// What was made, as JSON: `sections: [{name, title, shows, pictures, wall_s, failures}]`,
    /// `machine`, `version`.
    pub fn json(&self) -> String {
        let section = |one: &Section| {
            json!({
                "name": one.name,
                "title": one.title,
                "shows": one.shows,
                "pictures": one.pictures(),
                "wall_s": one.wall.as_secs_f64(),
                "failures": one.failures().collect::<Vec<_>>(),
            })
        };
        to_json(&json!({
            "sections": self.sections.iter().map(section).collect::<Vec<_>>(),
            "machine": machine_json(),
            "version": env!("CARGO_PKG_VERSION"),
        }))
    }

    /// What was made, as a table.
    pub fn table(&self) -> String {
        let row = |one: &Section| {
            let failures = one.failures().count();
            let outcome = if failures == 0 { "ok".to_owned() } else { format!("{failures} FAILED") };
            vec![
                one.name.to_owned(),
                outcome,
                one.pictures().to_string(),
                format!("{:.1}", one.wall.as_secs_f64()),
                one.shows.clone(),
            ]
        };
        crate::present::table(
            &["section", "outcome", "pictures", "wall (s)", "what it shows"],
            &self.sections.iter().map(row).collect::<Vec<_>>(),
        )
    }
}

impl Section {
    fn html(&self) -> Markup {
        html! {
            section id=(self.name) {
                h2 { (self.title) }
                p.shows { (self.shows) }
                @for block in &self.blocks { (block.html()) }
                p { small { "Made in " (format!("{:.1}", self.wall.as_secs_f64())) " s." } }
            }
        }
    }
}

impl Block {
    fn html(&self) -> Markup {
        match self {
            Self::Table(text) => html! { pre { (text) } },
            Self::Failure(why) => html! { p.failure { "Failed: " (why) } },
            Self::Picture { title, caption, svg } => html! {
                figure {
                    img alt=(title) src={ "data:image/svg+xml;base64," (STANDARD.encode(svg)) };
                    figcaption { strong { (title) ". " } (caption) }
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_fetches_nothing_and_escapes_what_it_is_given() {
        let blocks = vec![
            Block::Table("1 < 2 & <script>".into()),
            Block::Picture { title: "a \"b\"".into(), caption: "α < 2".into(), svg: vec![1, 2, 3] },
            Block::Failure("no <reason>".into()),
        ];
        let section = Section { name: "one", title: "One", shows: "nothing".into(), blocks, wall: Duration::ZERO };
        let page = Page { sections: vec![section] };
        let html = page.html();
        for wanted in [
            "1 &lt; 2 &amp; &lt;script&gt;",
            "a &quot;b&quot;",
            "α &lt; 2",
            "data:image/png;base64,AQID",
            "no &lt;reason&gt;",
            "href=\"#one\"",
        ] {
            assert!(html.contains(wanted), "{wanted}");
        }
        for foreign in ["<script", "http:", "https:", "@import", "url("] {
            assert!(!html.contains(foreign), "{foreign}");
        }
        assert_eq!(page.sections[0].failures().collect::<Vec<_>>(), ["no <reason>"]);
    }
}
