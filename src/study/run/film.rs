//! The film of a run.

use super::RunView;
use crate::{
    chain::{Boundary, max_norm},
    error::{Result, require},
    figures::{Film, Moment},
    number::format_short,
    numerics::{extremes, largest_by},
    scene::{Quantity, Scene, Units},
    study::{provenance, si::Scale},
};

/// Most frames after the first, ten seconds, and most beads: more would be specks.
const FRAMES: usize = 250;
const BEADS: usize = 100;
/// Part of a diameter by which beads overlap in the film at the largest overlap, and by which a
/// resonator is off the middle of its bead at most.
const DRAWN: f64 = 0.3;
/// The largest way of a bead in the film, as a share of the length that is seen.
const WAY: f64 = 0.25;
/// Share of the largest overlap from which on a contact is lit. The log of contacts dates their
/// ends no later than at this share of their own largest overlap.
const FAINT: f64 = 1e-3;

/// A sample for a film: time, displacements of beads (strains on a strain ring), and those of
/// resonators or nothing.
pub type FilmSample<'a> = (f64, &'a [f64], &'a [f64]);

/// The film of a run, with the name of its file.
///
/// # Errors
/// As of [`film`].
pub fn run_film(ran: &RunView<'_>) -> Result<crate::study::File> {
    let (layout, how) = (ran.scene.chain().layout(), format!("Integrator {}, {}.", ran.integrator, ran.setting));
    let states = ran.outcome.profiles.iter().map(|one| (one.t, layout.u(&one.state), layout.v(&one.state)));
    let samples: Vec<FilmSample<'_>> = states.map(|(t, u, v)| (t, u, v.unwrap_or_default())).collect();
    Ok(("film.gif".to_owned(), film(ran.scene, &how, &samples, ran.si)?))
}

/// A film of samples of a run as the bytes of a GIF file, at 25 frames a second. Of more than 250
/// samples after the first every second, third, .. is a frame.
///
/// `how` tells in a sentence how they were computed; `si` are the units of samples in SI units.
///
/// # Errors
/// Fewer than two samples; a film that cannot be drawn.
pub fn film(scene: &Scene, how: &str, samples: &[FilmSample<'_>], si: Option<&Units>) -> Result<Vec<u8>> {
    Ok(crate::figures::film(&of_samples(scene, how, samples, si)?)?)
}

/// A sample in the units of the chain: displacements of beads from places at which all just touch,
/// and of resonators from their beads; overlaps of all bonds, `-inf` where there is none, and
/// strains.
struct Row {
    t: f64,
    beads: Vec<f64>,
    resonators: Vec<f64>,
    overlaps: Vec<f64>,
    strains: Vec<f64>,
}

impl Row {
    fn new(scene: &Scene, &(t, u, v): &FilmSample<'_>, length: f64) -> Self {
        let [u, v] = [u, v].map(|values| values.iter().map(|value| value / length).collect::<Vec<_>>());
        let overlaps = scene.chain().overlaps(&u);
        // Strains determine places but for a constant.
        let ring = scene.chain().boundary() == Boundary::StrainRing;
        let sums = |first: f64, steps: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
            let sums: Vec<f64> = steps.scan(first, |at, step| Some(std::mem::replace(at, *at + step))).collect();
            let mean = if ring { sums.iter().sum::<f64>() / sums.len() as f64 } else { 0.0 };
            sums.into_iter().map(|sum| sum - mean).collect()
        };
        let steps = overlaps[1..].iter().map(|overlap| -overlap).chain([0.0]);
        let beads = sums(if ring { 0.0 } else { u[0] }, &mut steps.take(u.len()));
        let apart = v.iter().zip(&u).map(|(v, u)| v - u);
        let resonators = if ring { sums(0.0, &mut apart.skip(1).chain([0.0])) } else { apart.collect() };
        Self { t, beads, resonators, strains: scene.strains(&u), overlaps }
    }
}

fn of_samples(scene: &Scene, how: &str, samples: &[FilmSample<'_>], si: Option<&Units>) -> Result<Film> {
    require(samples.len() > 1, "samples", samples.len(), "a film needs two or more")?;
    let (chain, scale, sites) = (scene.chain(), Scale(si), scene.chain().sites());
    let every = (samples.len() - 1).div_ceil(FRAMES);
    let length = si.map_or(1.0, |si| si.length_m);
    let rows: Vec<Row> = samples.iter().step_by(every).map(|sample| Row::new(scene, sample, length)).collect();
    // The bond whose overlap grows most is seen.
    let growth = |&bond: &usize| rows.iter().map(|row| row.overlaps[bond] - rows[0].overlaps[bond]).fold(0.0, f64::max);
    let busiest = largest_by(chain.touching(), growth).unwrap_or(0);
    let count = sites.min(BEADS);
    let first = busiest.saturating_sub(count / 2).min(sites - count);
    let seen = first..first + count;
    let bonds: Vec<usize> = chain.touching().filter(|bond| (first..=seen.end).contains(bond)).collect();

    // Displacements are exaggerated, those of resonators from their beads by another factor.
    let overlap = rows.iter().flat_map(|row| bonds.iter().map(|&bond| row.overlaps[bond])).fold(0.0, f64::max);
    let centre = rows[0].beads[seen.clone()].iter().sum::<f64>() / count as f64;
    let way = max_norm(rows.iter().flat_map(|row| &row.beads[seen.clone()]).map(|bead| bead - centre));
    let far = max_norm(rows.iter().flat_map(|row| row.resonators.iter().copied()));
    let finite = |factor: f64| if factor.is_finite() { factor } else { 1.0 };
    let (exaggerated, apart) =
        (finite((DRAWN / overlap).min((WAY * count as f64).max(1.0) / way)), finite(DRAWN / far));
    let place = |row: &Row, n: usize| n as f64 + exaggerated * (row.beads[n] - centre);
    // Bond n is before site n; that of a ring stands at the first site.
    let contact = |row: &Row, bond: usize| match bond {
        _ if bond == first => place(row, first) - 0.5,
        _ if bond == seen.end => place(row, bond - 1) + 0.5,
        _ => 0.5 * (place(row, bond - 1) + place(row, bond)),
    };
    let strain = |row: &Row, bond: usize| scale.reported(Quantity::Length, row.strains[bond - chain.touching().start]);
    let strains = rows.iter().flat_map(|row| bonds.iter().map(|&bond| strain(row, bond)));
    let (low, high) = extremes(strains.chain([0.0]));
    // Gaps are often far wider than overlaps.
    let top = if low < 0.0 { high.min(-3.0 * low) } else { high };
    let decimals = (2.0 - (rows[1].t - rows[0].t).log10().floor()).clamp(0.0, 9.0) as usize;
    let moment = |row: &Row| Moment {
        time: if si.is_some() { format!("t = {:.4e} s", row.t) } else { format!("t = {:.decimals$}", row.t) },
        beads: seen.clone().map(|n| place(row, n)).collect(),
        resonators: seen.clone().filter_map(|n| Some(place(row, n) + apart * row.resonators.get(n)?)).collect(),
        contacts: bonds
            .iter()
            .filter(|bond| row.overlaps[**bond] > FAINT * overlap)
            .map(|&bond| (contact(row, bond), row.overlaps[bond] / overlap))
            .collect(),
        line: bonds.iter().map(|&bond| (bond as f64 - 0.5, strain(row, bond).min(top))).collect(),
    };
    let frames: Vec<Moment> = rows.iter().map(moment).collect();
    let places = frames.iter().flat_map(|frame| &frame.beads).copied();
    let (left_most, right_most) = extremes(places.chain([first as f64, seen.end as f64 - 1.0]));
    let [left, right] = chain.boundary().walls();
    let wall = |bond: usize, sign: f64| contact(&rows[0], bond) + sign * exaggerated * rows[0].overlaps[bond];
    let walls = [(left && first == 0).then(|| wall(0, 1.0)), (right && seen.end == sites).then(|| wall(sites, -1.0))];

    let window = if count < sites { format!(" Beads {first} to {} of {sites}.", seen.end - 1) } else { String::new() };
    let caption = format!(
        "Beads, all drawn alike: a bead's diameter stands for a displacement of {}{}. Orange: contacts, the larger the larger the \
         overlap.{}{window}{} Below: strain{}. {}",
        format_short(scale.reported(Quantity::Length, 1.0 / exaggerated)),
        if si.is_some() { " m" } else { "" },
        if far > 0.0 { " Dots: resonators, their distance from the bead on a scale of its own." } else { "" },
        if every > 1 { format!(" A frame is one of {every} samples.") } else { String::new() },
        if top < high { ", wider gaps at the upper edge" } else { "" },
        provenance(scene, how)
    );
    let margin = 0.06 * (top - low).max(f64::MIN_POSITIVE);
    Ok(Film {
        title: format!("{}: beads and contacts", scene.name()),
        caption,
        labels: ["site n".to_owned(), scale.label("strain xₙ", Quantity::Length)],
        x: (left_most - 1.0, right_most + 1.0),
        y: (low - margin, top + margin),
        walls: walls.into_iter().flatten().collect(),
        frames,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        chain::Contact,
        run::{Method, Records},
    };

    // Truth: the log of contacts, which the search for events makes and no sample.
    #[test]
    fn a_contact_is_lit_in_the_frames_between_its_onset_and_its_release() {
        for name in ["cradle", "tw-q15", "dimer"] {
            let scene = Scene::load_with(name, &["record.samples=200".to_owned()]).unwrap().until(9.0).unwrap();
            let run = scene.run().method(Method::named("collocation").unwrap()).records(Records::Profiles).contacts();
            let outcome = run.start().unwrap();
            let (layout, chain_bonds) = (scene.chain().layout(), scene.chain().touching().len());
            let samples: Vec<FilmSample<'_>> = outcome
                .profiles
                .iter()
                .map(|one| (one.t, layout.u(&one.state), layout.v(&one.state).unwrap_or_default()))
                .collect();
            let film = of_samples(&scene, "", &samples, None).unwrap();
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
}
