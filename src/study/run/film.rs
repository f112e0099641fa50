//! The film of a run.

use super::RunView;
use crate::{
    chain::{Boundary, max_norm},
    error::{Result, require},
    figures::{self, Film, Moment},
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
/// Share of the largest overlap from which on a contact is lit.
const FAINT: f64 = 1e-3;

/// The film of a run, with the name of its file.
///
/// # Errors
/// As of [`film`].
pub fn run_film(ran: &RunView<'_>) -> Result<crate::study::File> {
    let (layout, how) = (ran.scene.chain().layout(), format!("Integrator {}, {}.", ran.integrator, ran.setting));
    let states = ran.outcome.profiles.iter().map(|one| (one.t, layout.u(&one.state), layout.v(&one.state)));
    let samples: Vec<_> = states.map(|(t, u, v)| (t, u, v.unwrap_or_default())).collect();
    Ok(("film.gif".to_owned(), figures::film(&film(ran.scene, &how, &samples, ran.si)?)?))
}

/// A sample in the units of the chain: displacements of beads from places at which all just touch,
/// and of resonators from their beads; overlaps of all bonds, `-inf` where there is none; strains.
struct Row {
    t: f64,
    beads: Vec<f64>,
    resonators: Vec<f64>,
    overlaps: Vec<f64>,
    strains: Vec<f64>,
}

/// A film of samples of a run: times, displacements of beads (strains on a strain ring), and those
/// of resonators or nothing. Of more than 250 samples after the first every second, third, .. is a
/// frame.
///
/// `how` tells in a sentence how they were computed; `si` are the units of samples in SI units.
///
/// # Errors
/// Fewer than two samples.
pub fn film(scene: &Scene, how: &str, samples: &[(f64, &[f64], &[f64])], si: Option<&Units>) -> Result<Film> {
    require(samples.len() > 1, "samples", samples.len(), "a film needs two or more")?;
    let (chain, scale, every) = (scene.chain(), Scale(si), (samples.len() - 1).div_ceil(FRAMES));
    let (touching, sites, ring) = (chain.touching(), chain.sites(), chain.boundary() == Boundary::StrainRing);
    // Strains determine places but for a constant.
    let places = |first: f64, steps: Vec<f64>| -> Vec<f64> {
        let sums = steps.iter().scan(first, |at, step| Some(std::mem::replace(at, *at + step)));
        let mean = if ring { sums.clone().sum::<f64>() / steps.len() as f64 } else { 0.0 };
        sums.map(|sum| sum - mean).collect()
    };
    let row = |&(t, u, v): &(f64, &[f64], &[f64])| {
        let [u, v] = [u, v].map(|all| all.iter().map(|x| scale.read(Quantity::Length, *x)).collect::<Vec<_>>());
        let (overlaps, apart) = (chain.overlaps(&u), v.iter().zip(&u).map(|(v, u)| v - u));
        let beads = places(u[0], overlaps.iter().map(|overlap| -overlap).chain([0.0]).skip(1).take(sites).collect());
        let steps = apart.clone().chain([0.0]).skip(1).take(v.len());
        let resonators = if ring { places(0.0, steps.collect()) } else { apart.collect() };
        Row { t, beads, resonators, strains: scene.strains(&u), overlaps }
    };
    let rows: Vec<Row> = samples.iter().step_by(every).map(row).collect();
    // The bond whose overlap grows most is seen.
    let growth = |&bond: &usize| rows.iter().map(|row| row.overlaps[bond] - rows[0].overlaps[bond]).fold(0.0, f64::max);
    let (busiest, count) = (largest_by(touching.clone(), growth).unwrap_or(0), sites.min(BEADS));
    let first = busiest.saturating_sub(count / 2).min(sites - count);
    let seen = first..first + count;
    let bonds: Vec<usize> = touching.clone().filter(|bond| (first..=seen.end).contains(bond)).collect();
    // Displacements are exaggerated, those of resonators from their beads by another factor.
    let overlap = rows.iter().flat_map(|row| bonds.iter().map(|&bond| row.overlaps[bond])).fold(0.0, f64::max);
    let centre = rows[0].beads[seen.clone()].iter().sum::<f64>() / count as f64;
    let way = max_norm(rows.iter().flat_map(|row| &row.beads[seen.clone()]).map(|bead| bead - centre));
    let far = max_norm(rows.iter().flat_map(|row| row.resonators.iter().copied()));
    let [exaggerated, apart] = [(DRAWN / overlap).min((WAY * count as f64).max(1.0) / way), DRAWN / far]
        .map(|factor| if factor.is_finite() { factor } else { 1.0 });
    let shift = |row: &Row, n: usize| exaggerated * (row.beads[n] - centre);
    // Bond n is before site n; that of a ring stands at the first site. Outer ones have one bead.
    let both = |row: &Row, bond: usize| shift(row, bond.max(first + 1) - 1) + shift(row, bond.min(seen.end - 1));
    let contact = |row: &Row, bond: usize| bond as f64 - 0.5 + 0.5 * both(row, bond);
    let strain = |row: &Row, bond: usize| scale.reported(Quantity::Length, row.strains[bond - touching.start]);
    let (low, high) = extremes(rows.iter().flat_map(|row| bonds.iter().map(|&bond| strain(row, bond))).chain([0.0]));
    // Gaps are often far wider than overlaps.
    let top = if low < 0.0 { high.min(-3.0 * low) } else { high };
    let decimals = (2.0 - (rows[1].t - rows[0].t).log10().floor()).clamp(0.0, 9.0) as usize;
    let moment = |row: &Row| Moment {
        time: if si.is_some() { format!("t = {:.4e} s", row.t) } else { format!("t = {:.decimals$}", row.t) },
        centres: [&vec![0.0; sites], &row.resonators].map(|inside| {
            seen.clone().filter_map(|n| Some(n as f64 + shift(row, n) + apart * inside.get(n)?)).collect()
        }),
        contacts: bonds.iter().map(|&k| (contact(row, k), row.overlaps[k] / overlap)).filter(|x| x.1 > FAINT).collect(),
        line: bonds.iter().map(|&bond| (bond as f64 - 0.5, strain(row, bond).min(top))).collect(),
    };
    let wall = |bond: usize, sign: f64| contact(&rows[0], bond) + sign * exaggerated * rows[0].overlaps[bond];
    let [left, right] = chain.boundary().walls();
    let walls = [(left && first == 0, 0, 1.0), (right && seen.end == sites, sites, -1.0)].into_iter();
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
    Ok(Film {
        title: format!("{}: beads and contacts", scene.name()),
        caption,
        labels: ["site n".to_owned(), scale.label("strain xₙ", Quantity::Length)],
        walls: walls.filter(|it| it.0).map(|(_, bond, sign)| wall(bond, sign)).collect(),
        frames: rows.iter().map(moment).collect(),
    })
}
