//! Captions, tables and pictures of the figures of Sec. 7.

use super::{DoublingData, FloquetData, MassRatioData, OrbitData, ProfileData};
use crate::{
    chain::max_norm,
    dps::Center,
    number::written,
    orbits::{Bifurcation, BifurcationKind, Branch, Kind, Multiplier, Orbit, Parameter, Spectrum},
    output::csv,
    paper::figures::{Tables, heavy::version},
    study::{Evolution, OrbitStudy, center_word, shown},
};

/// Tables of a figure: `(part of the file name, tables)`.
pub(in super::super) fn orbit_tables(data: &OrbitData) -> Vec<(String, Tables)> {
    let branch = |branch: &Branch| {
        vec![("branch.csv", branch.table().csv().into_bytes()), ("multipliers.csv", off_circle_csv(branch))]
    };
    match data {
        OrbitData::Profiles(profiles) => profiles.iter().map(|one| (tag(one.center), profile_csv(one))).collect(),
        OrbitData::Floquet(families, _) => {
            let tables =
                |one: &FloquetData| [branch(&one.branch), vec![("spectrum.csv", spectrum_csv(&one.one))]].concat();
            families.iter().map(|one| (tag(one.center), tables(one))).collect()
        }
        OrbitData::ReturnErrors(family, errors, until) => {
            let tables = [branch(family), vec![("errors.csv", errors_csv(family, errors, *until))]].concat();
            vec![(String::new(), tables)]
        }
        OrbitData::Evolutions(runs, _) => {
            let tables = |run: &Evolution| {
                let tables = run.tables().map(|table| table.csv().into_bytes());
                ["errors.csv", "x.csv", "y.csv"].into_iter().zip(tables).collect()
            };
            runs.iter().map(|(center, run)| (evolution_tag(*center, run), tables(run))).collect()
        }
        OrbitData::Doubling(one) => vec![(String::new(), doubling_csv(one))],
        OrbitData::Doubled(one, later, family) => {
            let columns: [&[f64]; 3] = [&one.orbit.z, &later[0], &later[1]];
            let profile = strains_csv(&one.orbit, &["", "_half", "_whole"], &columns);
            let tables = vec![("profile.csv", profile), ("spectrum.csv", spectrum_csv(one))];
            vec![(String::new(), [tables, branch(&family.branch)].concat())]
        }
        OrbitData::MassRatios(families) => {
            let name = |one: &MassRatioData| format!("{}-{:.2}", center_word(one.center), one.omega_b);
            families.iter().map(|one| (name(one), branch(&one.branch))).collect()
        }
    }
}

/// The name of a family at the beginning of a sentence.
fn family(center: Center) -> &'static str {
    match center {
        Center::Bond => "Bond-centred",
        Center::Site => "Site-centred",
    }
}

fn tag(center: Center) -> String {
    center_word(center).to_owned()
}

fn evolution_tag(center: Center, run: &Evolution) -> String {
    let kicked = if run.kick.is_some() { "-kicked" } else { "" };
    format!("{}-{}{kicked}", center_word(center), run.orbit.setting.omega_b)
}

/// The sites `n = -N .. N` of an orbit.
fn sites(orbit: &Orbit) -> impl Iterator<Item = f64> + use<> {
    let half = orbit.setting.sites as f64 / 2.0 - 0.5;
    (0..orbit.setting.sites).map(move |i| i as f64 - half)
}

/// A table with `n`, and with `x` and `y` of every `Z`.
fn strains_csv(orbit: &Orbit, marks: &[&str], all: &[&[f64]]) -> Vec<u8> {
    let names = marks.iter().flat_map(|mark| [format!("x{mark}"), format!("y{mark}")]);
    let names: Vec<String> = std::iter::once("n".to_owned()).chain(names).collect();
    let count = orbit.setting.sites;
    let row = |(i, n): (usize, f64)| std::iter::once(n).chain(all.iter().flat_map(|z| [z[i], z[count + i]])).collect();
    csv(&names.iter().map(String::as_str).collect::<Vec<_>>(), sites(orbit).enumerate().map(row))
}

fn profile_csv(one: &ProfileData) -> Tables {
    let orbit = &one.study.orbit;
    vec![("profile.csv", strains_csv(orbit, &["", "_after", "_dps"], &[&orbit.z, &one.after, &one.seed]))]
}

fn doubling_csv(one: &DoublingData) -> Tables {
    let all: [&[f64]; 3] = [&one.orbit.z, &one.seed, &one.birth.critical.mode];
    vec![("profile.csv", strains_csv(&one.orbit, &["", "_seed", "_mode"], &all))]
}

fn off_circle_csv(branch: &Branch) -> Vec<u8> {
    let parameter = branch.continuation.parameter;
    let rows = branch.points.iter().flat_map(|point| {
        let p = point.orbit.setting.get(parameter);
        let off = point.spectrum.multipliers.iter().filter(|one| one.modulus != 1.0);
        off.map(move |one| vec![p, one.re, one.im, one.modulus, one.error])
    });
    csv(&[parameter.name(), "re", "im", "modulus", "error"], rows)
}

fn spectrum_csv(study: &OrbitStudy) -> Vec<u8> {
    let rows = study.spectrum.multipliers.iter();
    let rows = rows.map(|one| vec![one.re, one.im, one.modulus, one.error, f64::from(one.krein)]);
    csv(&["re", "im", "modulus", "error", "krein"], rows)
}

/// A table of `E_b` and of the growth `|lambda|^m` of rounding errors, at each point of a branch.
fn errors_csv(branch: &Branch, errors: &[f64], until: f64) -> Vec<u8> {
    let row = |((omega_b, growth), e_b): ((f64, f64), &f64)| vec![omega_b, *e_b, growth];
    csv(&["omega_b", "e_b", "growth"], amplifications(branch, until).zip(errors).map(row))
}

/// `omega_b` and `|lambda|^m` at each point, with the largest multiplier and the whole periods up
/// to a time.
fn amplifications(branch: &Branch, until: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
    branch.points.iter().map(move |point| {
        let periods = (until / point.orbit.setting.period()).floor();
        (point.orbit.setting.omega_b, point.spectrum.largest().powf(periods))
    })
}

/// The parameters that all these figures share, as text.
fn ring(orbit: &Orbit) -> String {
    let params = orbit.setting.params;
    format!(
        "Ring of {} sites, α = {}, κ = {}, C_x = {}",
        orbit.setting.sites, params.alpha, params.kappa, orbit.setting.c_x
    )
}

/// Two digits, as a power of ten where that is short, with a typographic minus sign.
fn power(value: f64) -> String {
    let plain = (0.1..1e3).contains(&value.abs());
    (if plain { format!("{value:.1}") } else { format!("{value:.1e}") }).replace('-', "−")
}

/// The largest modulus of a kind, if above 1.
fn strongest(spectrum: &Spectrum, wanted: Kind) -> Option<f64> {
    let off = |one: &&Multiplier| one.kind == wanted && one.modulus > 1.0;
    spectrum.multipliers.iter().filter(off).map(|one| one.modulus).reduce(f64::max)
}

/// The largest moduli, such as “real 1.08, quartet 1.01”.
fn strongest_words(spectrum: &Spectrum) -> String {
    let words = KINDS.iter().filter_map(|(kind, word)| Some(format!("{word} {:.4}", strongest(spectrum, *kind)?)));
    words.collect::<Vec<_>>().join(", ")
}

/// Kinds of multipliers off the circle, and their names in legends.
const KINDS: [(Kind, &str); 3] = [(Kind::Real, "real"), (Kind::Negative, "negative"), (Kind::Quartet, "quartet")];

pub(in super::super) fn orbit_caption(data: &OrbitData) -> String {
    let (orbit, words) = match data {
        OrbitData::Profiles(all) => (&all[0].study.orbit, profiles_words(all)),
        OrbitData::Floquet(all, zoom) => (&all[0].one.orbit, floquet_words(all, *zoom)),
        OrbitData::ReturnErrors(branch, errors, until) => {
            (&branch.points[0].orbit, errors_words(branch, errors, *until))
        }
        OrbitData::Evolutions(all, profiles) => (&all[0].1.orbit, evolutions_words(all, *profiles)),
        OrbitData::Doubling(one) => (&one.orbit, doubling_words(one)),
        OrbitData::Doubled(one, later, family) => {
            let apart =
                |z: &[f64]| power(max_norm(z.iter().zip(&one.orbit.z).map(|(a, b)| a - b)) / one.orbit.amplitude());
            let points = &family.branch.points;
            let omega_b = |k: usize| shown_digits(points[k].orbit.setting.omega_b);
            let words = format!(
                "Orbit of period T = 2π/ω_b = {:.6}, ω_b = {}: max |Z(T/2) − Z(0)| = {}, max |S Z(T/2) − Z(0)| = {}, S: n → 1 − n, and max |Z(T) − Z(0)| = {} of its amplitude; largest |λ|: {}. \
                 Branch from {} to {}, {} points, born at ω_b = {:.9} of the main branch; the paper's stops at 1.051",
                one.orbit.setting.period(),
                one.orbit.setting.omega_b,
                apart(&later[0]),
                apart(&reflected(&later[0], one.orbit.setting.sites)),
                apart(&later[1]),
                strongest_words(&one.spectrum),
                omega_b(0),
                omega_b(points.len() - 1),
                points.len(),
                family.birth.parameter,
            );
            (&one.orbit, words)
        }
        OrbitData::MassRatios(all) => (&all[0].branch.points[0].orbit, mass_ratios_words(all)),
    };
    let rho = match data {
        OrbitData::MassRatios(_) => String::new(),
        _ => format!(", ρ = {}", written(orbit.setting.params.rho)),
    };
    format!("{words}. {}{rho}. {}.", ring(orbit), version())
}

/// The reflected strains `x_{1-n}` and `y_{1-n}`.
fn reflected(z: &[f64], sites: usize) -> Vec<f64> {
    z.chunks(sites).flat_map(|strains| (0..sites).map(|i| strains[(sites - i) % sites])).collect()
}

/// A number with six decimals, without zeros at the end.
fn shown_digits(value: f64) -> String {
    format!("{value:.6}").trim_end_matches('0').to_owned()
}

fn profiles_words(all: &[ProfileData]) -> String {
    let words = |one: &ProfileData| {
        let study = &one.study;
        format!(
            "{}: K_x = {:.6}, K_y = {:.6}, Newton steps {}, E_b(T) = {}, largest |λ| {}",
            family(one.center),
            study.extent.k_x,
            study.extent.k_y,
            study.orbit.newton.len(),
            power(study.e_b),
            strongest_words(&study.spectrum)
        )
    };
    let seed = "Squares: exact orbit at t = 0; stars: at t = T; crosses: DpS profile (eq:xy_sw), from which Newton's method starts. ";
    seed.to_owned() + &all.iter().map(words).collect::<Vec<_>>().join(". ")
}

/// The number of orbits of a branch, such as “110 orbits”.
fn orbits_word(branch: &Branch) -> String {
    let gaps = match branch.gaps.len() {
        0 => String::new(),
        gaps => format!(" and {gaps} without multipliers, which are left out"),
    };
    format!("{} orbits{gaps}", branch.points.len())
}

fn bifurcation_words(all: &[Bifurcation]) -> String {
    let word = |kind| match kind {
        BifurcationKind::PeriodDoubling => "through −1",
        BifurcationKind::PlusOne => "through 1",
        BifurcationKind::KreinCollision => "meet on the circle",
        BifurcationKind::RealCollision => "meet on the real axis",
        BifurcationKind::Fold => "fold",
        BifurcationKind::Torus => "torus",
    };
    let words: Vec<String> = all.iter().map(|one| format!("{:.7} ({})", one.parameter, word(one.kind))).collect();
    if words.is_empty() { "none stronger than 0.01".to_owned() } else { words.join(", ") }
}

fn floquet_words(all: &[FloquetData], zoom: Option<f64>) -> String {
    let events = |one: &FloquetData| {
        // Where bifurcations were not located, the list is empty.
        let events = &one.branch.bifurcations;
        if events.is_empty() { String::new() } else { format!("; bifurcations {}", bifurcation_words(events)) }
    };
    let words = |one: &FloquetData| {
        let points = &one.branch.points;
        format!(
            "{}: {}, K_x from {} to {}; at the one frequency largest |λ| {}, symplectic defect {}{}",
            family(one.center),
            orbits_word(&one.branch),
            shown(points[0].measures.extent.k_x),
            shown(points[points.len() - 1].measures.extent.k_x),
            strongest_words(&one.one.spectrum),
            power(one.one.spectrum.quality.symplectic_defect),
            events(one)
        )
    };
    let zoomed = zoom.map_or(String::new(), |_| " Below: the site-centred family near ω, enlarged.".to_owned());
    format!(
        "Left: moduli of all multipliers; right: all multipliers at ω_b = {}.{zoomed} {}. Number and size of the weak quartets depend on the length of the ring",
        all[0].one.orbit.setting.omega_b,
        all.iter().map(words).collect::<Vec<_>>().join(". ")
    )
}

fn errors_words(branch: &Branch, errors: &[f64], until: f64) -> String {
    let below = branch.points.iter().zip(errors).filter(|(point, _)| point.orbit.setting.omega_b <= 2.077);
    let most = below.map(|(_, e_b)| *e_b).fold(0.0, f64::max);
    format!(
        "E_b at the last whole period before t = {until}; dashed: 10⁻¹⁶ |λ|^m, the growth of a rounding over the m periods. Largest E_b up to ω_b = 2.077: {} (the paper: \
         7·10⁻⁷, grown from the errors of its own orbits). Bifurcations: {}. A logarithmic ordinate takes the place of the paper's inset",
        power(most),
        bifurcation_words(&branch.bifurcations)
    )
}

fn evolutions_words(all: &[(Center, Evolution)], profiles: bool) -> String {
    let words = |(center, run): &(Center, Evolution)| {
        let kick = run.kick.map_or(String::new(), |(kick, _)| {
            format!(", kicked by {} of its amplitude along the mode of its largest λ", kick.size)
        });
        let motion = |one: &crate::study::Motion| shown(one.velocity).replace('-', "−");
        let velocity = if *center == Center::Bond && run.orbit.setting.omega_b < 2.06 {
            let [first, last] = [0, 2].map(|k| run.motion.get(k));
            first.zip(last).map_or(String::new(), |(first, last)| {
                format!(
                    "; velocity of the kink {} from t = {:.0} to {:.0} and {} from {:.0} to {:.0}",
                    motion(first),
                    first.window.0,
                    first.window.1,
                    motion(last),
                    last.window.0,
                    last.window.1
                )
            })
        } else {
            String::new()
        };
        let last = run.times.len() - 1;
        format!(
            "{}, ω_b = {}{kick}: E_b({:.0}) = {}, roundings grow by {} if they stay small{velocity}",
            family(*center),
            run.orbit.setting.omega_b,
            run.times[last],
            power(run.e_b[last]),
            power(run.amplification),
        )
    };
    let shows = if profiles { "Above: xₙ and yₙ at the start and after the last whole period. " } else { "" };
    format!(
        "{shows}Colours: largest strain of each period, beads above, resonators below; the scale ends at twice the largest strain of the orbit, and magenta is beyond it. {}. Integrator collocation, tol 1e-13",
        all.iter().map(words).collect::<Vec<_>>().join(". ")
    )
}

fn doubling_words(one: &DoublingData) -> String {
    let orbit = &one.orbit;
    format!(
        "Left: strains of the mode at the period doubling, ω_b = {:.10}, the largest 1. Right: orbit of frequency {} (squares) and its seed (stars), the breather at the period doubling with a \
         tenth of its amplitude along the mode; Newton's method takes {} steps to a residual of {}",
        one.birth.parameter,
        orbit.setting.omega_b,
        orbit.newton.len(),
        power(orbit.residual)
    )
}

fn mass_ratios_words(all: &[MassRatioData]) -> String {
    let words = |one: &MassRatioData| {
        let points = &one.branch.points;
        let last = &points[points.len() - 1];
        format!(
            "ω_b = {}, {}: {}, ρ from {} to {}, there {}",
            one.omega_b,
            center_word(one.center),
            orbits_word(&one.branch),
            shown(points[0].orbit.setting.get(Parameter::Rho)),
            shown(last.orbit.setting.get(Parameter::Rho)),
            strongest_words(&last.spectrum)
        )
    };
    "Moduli of all multipliers; number and size of the quartets depend on the length of the ring. A branch begins where ω = ω_b/1.004, since no dark breather has a frequency below ω. ".to_owned()
        + &all.iter().map(words).collect::<Vec<_>>().join("; ")
}

#[cfg(feature = "plot")]
pub(in super::super) use pictures::orbit_panels;

#[cfg(feature = "plot")]
mod pictures {
    use super::*;
    use crate::figures::{Column, Kind as Axes, Line, Panel, Panels, Plot};

    fn line(name: &str, points: impl Iterator<Item = (f64, f64)>) -> Line {
        Line { name: name.to_owned(), points: points.collect() }
    }

    pub(in super::super::super) fn orbit_panels(title: &str, data: &OrbitData, caption: String) -> Panels {
        let heading = |center: Center| format!("{}-centred", center_word(center));
        let columns = match data {
            OrbitData::Profiles(all) => {
                let column = |one: &ProfileData| {
                    let lines = [("at t = 0", &one.study.orbit.z), ("at t = T", &one.after), ("DpS", &one.seed)];
                    Column::new(heading(one.center), profiles(&one.study.orbit, &lines))
                };
                all.iter().map(column).collect()
            }
            OrbitData::Floquet(all, zoom) => floquet(all, *zoom),
            OrbitData::ReturnErrors(branch, errors, until) => {
                let points = branch.points.iter().map(|point| point.orbit.setting.omega_b);
                let rounding = amplifications(branch, *until).map(|(omega_b, growth)| (omega_b, 1e-16 * growth));
                let e_b = Panel {
                    kind: Axes::LogParameter,
                    x_label: FREQUENCY.into(),
                    y_label: format!("return error E_b({until})"),
                    lines: vec![line("E_b", points.zip(errors.iter().copied())), line("10⁻¹⁶ |λ|^m", rounding)],
                    ..Panel::default()
                };
                let moduli = Panel { title: "moduli along the branch".into(), ..moduli(branch, |_| true) };
                vec![Column::new("", [moduli]), Column::new("", [e_b])]
            }
            OrbitData::Evolutions(all, profile) => {
                let column = |(center, run): &(Center, Evolution)| {
                    let kicked = run.kick.map_or(String::new(), |(kick, _)| format!(", kicked by {}", kick.size));
                    let heading = format!("{}, ω_b = {}{kicked}", heading(*center), run.orbit.setting.omega_b);
                    let lines = [("at t = 0", &run.orbit.z), ("at the end", &run.end)];
                    let above = if *profile { profiles(&run.orbit, &lines) } else { Vec::new() };
                    let above = above.into_iter().map(Plot::from);
                    Column::new(heading, above.chain(run.maps().into_iter().map(Plot::from)))
                };
                all.iter().map(column).collect()
            }
            OrbitData::Doubling(one) => {
                let mode = Column::new(
                    "mode at the multiplier −1",
                    profiles(&one.orbit, &[("mode", &one.birth.critical.mode)]),
                );
                let lines = [("exact orbit", &one.orbit.z), ("seed", &one.seed)];
                vec![mode, Column::new(format!("ω_b = {}", one.orbit.setting.omega_b), profiles(&one.orbit, &lines))]
            }
            OrbitData::Doubled(one, [half, whole], family) => {
                let above = |name: &str, z: &Vec<f64>| profiles(&one.orbit, &[("at t = 0", &one.orbit.z), (name, z)]);
                let below = |panel: Panel, title: String| [Panel { title, ..panel }];
                let branch = below(moduli(&family.branch, |_| true), "moduli along the branch".to_owned());
                let at = format!("multipliers at ω_b = {}", one.orbit.setting.omega_b);
                vec![
                    Column::new("", above("at t = T/2", half).into_iter().chain(branch)),
                    Column::new("", above("at t = T", whole).into_iter().chain(below(plane(one), at))),
                ]
            }
            OrbitData::MassRatios(all) => {
                let column = |pair: &[MassRatioData]| {
                    let panel = |one: &MassRatioData| {
                        let panel = moduli(&one.branch, |_| true);
                        Panel { y_label: format!("|λ|, {}", heading(one.center)), ..panel }
                    };
                    Column::new(format!("ω_b = {:.2}", pair[0].omega_b), pair.iter().map(panel))
                };
                all.chunks(2).map(column).collect()
            }
        };
        Panels { title: title.to_owned(), columns, caption }
    }

    const FREQUENCY: &str = "frequency ω_b";

    /// Panels of `x_n` and `y_n` of several `Z`.
    fn profiles(orbit: &Orbit, lines: &[(&str, &Vec<f64>)]) -> Vec<Panel> {
        let count = orbit.setting.sites;
        let panel = |(k, symbol): (usize, &str)| {
            let strains = |z: &Vec<f64>| z[k * count..(k + 1) * count].to_vec();
            Panel {
                x_label: "site n".into(),
                y_label: format!("strain {symbol}"),
                lines: lines.iter().map(|(name, z)| line(name, sites(orbit).zip(strains(z)))).collect(),
                ..Panel::default()
            }
        };
        ["xₙ", "yₙ"].into_iter().enumerate().map(panel).collect()
    }

    /// The multipliers on the circle, then each kind off it.
    fn by_kind(multipliers: impl Fn(&dyn Fn(&Multiplier) -> bool) -> Vec<(f64, f64)>) -> Vec<Line> {
        let off = KINDS.map(|(kind, name)| line(name, multipliers(&|one| one.kind == kind).into_iter()));
        let circle = line("on the circle", multipliers(&|one| one.modulus == 1.0).into_iter());
        // Lines without points are kept, so that a kind has the same colour in every panel.
        std::iter::once(circle).chain(off).collect()
    }

    /// Moduli against the parameter of the branch, for those values that `within` accepts.
    fn moduli(branch: &Branch, within: impl Fn(f64) -> bool) -> Panel {
        let parameter = branch.continuation.parameter;
        let of = |wanted: &dyn Fn(&Multiplier) -> bool| {
            let mut all = Vec::new();
            for point in &branch.points {
                let p = point.orbit.setting.get(parameter);
                let here = point.spectrum.multipliers.iter().filter(|one| within(p) && wanted(one));
                all.extend(here.map(|one| (p, one.modulus)));
            }
            all.dedup();
            all
        };
        let (kind, x_label) =
            if parameter == Parameter::Rho { (Axes::LogCloud, "mass ratio ρ") } else { (Axes::Cloud, FREQUENCY) };
        Panel { kind, x_label: x_label.into(), y_label: "|λ|".into(), lines: by_kind(of), ..Panel::default() }
    }

    /// All multipliers of an orbit.
    fn plane(study: &OrbitStudy) -> Panel {
        let of = |wanted: &dyn Fn(&Multiplier) -> bool| {
            study.spectrum.multipliers.iter().filter(|one| wanted(one)).map(|one| (one.re, one.im)).collect()
        };
        Panel {
            kind: Axes::Plane,
            x_label: "Re λ".into(),
            y_label: "Im λ".into(),
            lines: by_kind(of),
            ..Panel::default()
        }
    }

    /// Branches at the left and spectra at the right, with an enlarged part of the site-centred
    /// family below.
    fn floquet(all: &[FloquetData], zoom: Option<f64>) -> Vec<Column> {
        let titled = |one: &FloquetData, words: &str, panel: Panel| Panel {
            title: format!("{}-centred: {words}", center_word(one.center)),
            ..panel
        };
        let whole = |one: &FloquetData| titled(one, "moduli along the branch", moduli(&one.branch, |_| true));
        let at = |one: &FloquetData| format!("multipliers at ω_b = {}", one.one.orbit.setting.omega_b);
        let mut left: Vec<Panel> = all.iter().map(whole).collect();
        if let (Some(zoom), Some(site)) = (zoom, all.iter().find(|one| one.center == Center::Site)) {
            let enlarged = titled(site, "near ω, enlarged", moduli(&site.branch, |p| p <= zoom));
            // A panel with the same label would get the range of the panel above.
            left.push(Panel { x_label: "frequency ω_b near ω".into(), ..enlarged });
        }
        let right: Vec<Panel> = all.iter().map(|one| titled(one, &at(one), plane(&one.one))).collect();
        vec![Column::new("", left), Column::new("", right)]
    }
}
