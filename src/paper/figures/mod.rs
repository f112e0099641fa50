//! The figures of the paper, and some additional ones.
//!
//! A figure is a row of [`FIGURES`]: studies, each of which makes a report, and the panels of their
//! pictures that it shows. Its own report has their tables, and a picture with the numbers of their
//! captions.

pub mod orbits;
mod rows;
mod studies;

pub use rows::FIGURES;
pub(super) use studies::{limit_wave, wave_study};

use crate::{
    error::{Error, Result},
    report::{self, Column, Panels, Report},
    study::Progress,
    sweep::map,
};
use std::sync::{Mutex, PoisonError};

/// Runs a study and makes its report.
type Make = fn(Progress<'_>) -> Result<Report>;

/// A figure of the paper.
#[derive(Debug)]
pub struct Figure {
    /// Short name of the figure on the command line and in file names.
    pub name: &'static str,
    /// Figure or section of the paper.
    pub source: &'static str,
    /// Title.
    pub title: &'static str,
    /// What the figure shows, in a sentence or two.
    pub claim: &'static str,
    /// Its studies, each with its part of the names of files, which may be empty.
    studies: &'static [(&'static str, Make)],
    /// Its columns: heading, and for each plot the numbers of its study and of the plot among those
    /// of the study. Without any, all columns of all studies.
    columns: &'static [(&'static str, &'static [(usize, usize)])],
}

/// Shorter sentences may be parts of others.
const SENTENCE: usize = 20;

/// The name of a study among those of its figure, in words.
fn told_apart(tag: &str) -> String {
    let word = |part: &str| match part {
        "bond" | "site" => format!("about a {part}"),
        "q15" => "q = π/5".to_owned(),
        "q45" => "q = 4π/5".to_owned(),
        "dps" => "first order".to_owned(),
        // Their captions say what they are, and the mass ratio.
        part if part == "mode" || part == "tw" || part.starts_with("rho") => String::new(),
        number if number.parse::<f64>().is_ok() => format!("ω_b = {number}"),
        other => other.strip_prefix("alpha").map_or(other.to_owned(), |value| format!("α = {value}")),
    };
    let words: Vec<String> = tag.split('-').map(word).filter(|word| !word.is_empty()).collect();
    if words.is_empty() { String::new() } else { format!("[{}] ", words.join(", ")) }
}

impl Figure {
    /// The figure with the given name.
    ///
    /// # Errors
    /// An unknown name; the message has the nearest known one.
    pub fn named(name: &str) -> Result<&'static Self> {
        let known = || FIGURES.iter().map(|figure| figure.name);
        FIGURES.iter().find(|figure| figure.name == name).ok_or_else(|| Error::unknown("figure", name, known()))
    }

    /// Runs the studies, on all cores, and makes the report: tables, picture with its caption, and
    /// as facts the origin of both. Its numbers do not depend on the number of cores.
    ///
    /// `progress` is called with the finished share of the work.
    ///
    /// # Errors
    /// A run that fails.
    pub fn report(&self, progress: Progress<'_>) -> Result<Report> {
        let shares = Mutex::new(vec![0.0; self.studies.len()]);
        let numbered: Vec<_> = self.studies.iter().enumerate().collect();
        let reports = map(&numbered, |(k, (_, make))| {
            make(&|share, _| {
                let mut shares = shares.lock().unwrap_or_else(PoisonError::into_inner);
                shares[*k] = share;
                progress(shares.iter().sum::<f64>() / shares.len() as f64, "");
            })
        });
        let (mut tables, mut pictures, mut caption) = (Vec::new(), Vec::new(), self.claim.to_owned());
        for ((tag, _), report) in self.studies.iter().zip(reports) {
            let report = report?;
            if let Some(why) = report.error() {
                return Err(Error::Point {
                    point: format!("{} {tag}", self.name).trim_end().to_owned(),
                    why: why.to_owned(),
                });
            }
            let (its_tables, mut its_pictures) = report.parts(&[self.name, tag]);
            tables.extend(its_tables);
            let told: Vec<&str> = its_pictures.iter_mut().map(|picture| picture.words()[1].as_str()).collect();
            // What an earlier study has said is not said again.
            let told = told.join(" ").replace("  ", " ");
            let new =
                told.split_inclusive(". ").filter(|one| one.len() < SENTENCE || !caption.contains(one.trim_end()));
            let new = new.collect::<String>();
            caption += &format!(" {}{}", told_apart(tag), new.trim_end());
            pictures.push(its_pictures);
        }
        let section = self.source.split([',', ';']).next().unwrap_or_default();
        caption += &format!(" Paper: {section}.");
        let mut picture = self.layout(pictures);
        *picture.words()[0] = self.title.to_owned();
        *picture.words()[1] = caption.clone();
        let report =
            Report::new(self.name).fact("name", self.name).fact("source", self.source).fact("title", self.title);
        Ok(tables.into_iter().fold(report.picture(picture), Report::table).fact("caption", caption))
    }

    /// The picture, from those of the studies.
    fn layout(&self, mut pictures: Vec<Vec<report::Figure>>) -> report::Figure {
        if !matches!(pictures[0][0], report::Figure::Panels(_)) {
            return pictures.remove(0).remove(0);
        }
        let columns = |picture| if let report::Figure::Panels(panels) = picture { panels.columns } else { Vec::new() };
        let all: Vec<Vec<Column>> =
            pictures.into_iter().map(|pictures| pictures.into_iter().flat_map(columns).collect()).collect();
        let plot = |&(study, number): &(usize, usize)| {
            let mut plots = all[study].iter().flat_map(|column| &column.panels);
            plots.nth(number).expect("a row names plots that there are").clone()
        };
        let chosen = |(heading, plots): &(&str, &[(usize, usize)])| Column::new(*heading, plots.iter().map(plot));
        let columns = match self.columns {
            [] => all.concat(),
            some => some.iter().map(chosen).collect(),
        };
        Panels { columns, ..Panels::default() }.into()
    }
}
