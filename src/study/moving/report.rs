//! Moving breathers as text, JSON, files and pictures.

use super::{MovingPoint, MovingStudy};
use crate::{
    chain::Params,
    error::Result,
    number::shown,
    output::csv,
    present::table,
    study::{File, Report, exact::nearness, params_words},
};
use serde_json::{Value, json};
use std::f64::consts::PI;

impl MovingPoint {
    /// The numbers of the breather, in the order of [`NAMES`].
    fn numbers(&self) -> [f64; 18] {
        let (breather, envelope) = (&self.orbit.breather, &self.envelope);
        [
            breather.omega_b,
            f64::from(breather.turns),
            breather.passage(),
            breather.velocity(),
            self.orbit.residual,
            self.return_error,
            envelope.background,
            envelope.depth,
            envelope.tail,
            self.spectrum.largest(),
            self.real(),
            self.tail.twist,
            self.tail.wave_number,
            self.tail.share,
            self.resonant_wave(),
            self.energy.energy,
            self.energy.free,
            self.kantorovich.and_then(|found| found.radius).unwrap_or(f64::NAN),
        ]
    }
}

const NAMES: [&str; 18] = [
    "omega_b",
    "turns",
    "passage",
    "velocity",
    "residual",
    "return_error",
    "background",
    "depth",
    "tail",
    "max_modulus",
    "real",
    "twist",
    "tail_wave",
    "tail_share",
    "resonant_wave",
    "energy",
    "free_energy",
    "radius",
];

impl MovingStudy {
    fn params(&self) -> Params {
        let options = &self.options;
        Params { alpha: options.alpha, kappa: options.kappa, rho: options.rho }
    }

    /// Velocities of the kicked run in the second, third and fourth quarter.
    fn quarters(&self) -> Option<[f64; 3]> {
        let kicked = self.kicked.as_ref()?;
        let end = *kicked.times.last()?;
        Some([1.0, 2.0, 3.0].map(|k| kicked.mean_velocity(0.25 * k * end, 0.25 * (k + 1.0) * end)))
    }

    fn words(&self) -> String {
        let least = self.points.iter().min_by(|a, b| a.envelope.tail.total_cmp(&b.envelope.tail));
        let tail = least.map_or(String::new(), |point| {
            let (breather, tail) = (&point.orbit.breather, 100.0 * point.envelope.tail);
            format!("The smallest tail is {tail:.2} % of the background, at v = {:.5}.", breather.velocity())
        });
        let kicked = self.quarters().map_or(String::new(), |v| {
            let v = v.map(|v| format!("{v:.5}"));
            format!(" The kicked breather has the velocities {}, {}, {} in the last three quarters.", v[0], v[1], v[2])
        });
        let apart = self.apart().map_or(String::new(), |apart| {
            format!(" Its depth differs from that of the moving breather of its velocity by at most {apart:.3}.")
        });
        tail + &kicked + &apart
    }
}

impl Report for MovingStudy {
    fn json(&self) -> Value {
        let point = |point: &MovingPoint| {
            let mut row: serde_json::Map<String, Value> =
                NAMES.iter().zip(point.numbers()).map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
            row["turns"] = json!(point.orbit.breather.turns);
            row.insert("growth".to_owned(), json!(point.growth()));
            row.insert("quality".to_owned(), json!(point.spectrum.quality));
            row.insert("newton".to_owned(), json!(point.orbit.newton));
            row.insert("tail_amplitude".to_owned(), json!(point.tail.amplitude));
            row.insert("resonant".to_owned(), json!(point.resonant));
            row.insert("kantorovich".to_owned(), json!(point.kantorovich));
            Value::Object(row)
        };
        let kicked = self.kicked.as_ref().map(|run| {
            json!({
                "omega_b": run.omega_b,
                "kick": self.options.kick,
                "t": run.times,
                "position": run.position,
                "passages": run.passages,
                "velocities": self.quarters(),
                "depth_apart": self.apart(),
            })
        });
        let missing = self
            .missing
            .iter()
            .map(|(omega_b, turns, why)| json!({ "omega_b": omega_b, "turns": turns, "reason": why }));
        json!({
            "alpha": self.options.alpha,
            "kappa": self.options.kappa,
            "rho": self.options.rho,
            "sites": self.options.sites,
            "points": self.points.iter().map(point).collect::<Vec<_>>(),
            "missing": missing.collect::<Vec<_>>(),
            "kicked": kicked,
            "tol": self.options.tol,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let row = |point: &MovingPoint| {
            let (breather, envelope) = (&point.orbit.breather, &point.envelope);
            vec![
                format!("{:.6}", breather.omega_b),
                breather.turns.to_string(),
                format!("{:.6}", breather.velocity()),
                format!("{:.1e}", point.orbit.residual),
                format!("{:.1e}", point.return_error),
                format!("{:.6}", envelope.background),
                format!("{:.5}", envelope.depth),
                format!("{:.5}", envelope.tail),
                format!("{:.3}", point.tail.wave_number / PI),
                format!("{:.3}", point.resonant_wave() / PI),
                format!("{:.3e}", point.energy.energy),
                format!("{:.4e}", point.energy.free),
                format!("{:.6}", point.spectrum.largest()),
                format!("{:.2e}", point.growth()),
            ]
        };
        let rows: Vec<Vec<String>> = self.points.iter().map(row).collect();
        let head = [
            "omega_b",
            "turns",
            "velocity",
            "residual",
            "return",
            "background",
            "depth",
            "tail",
            "p/pi",
            "resonant",
            "energy",
            "E-wJ-vP",
            "max |l|",
            "growth",
        ];
        let bounds: String = if self.options.bound {
            let line = |point: &MovingPoint| {
                format!(
                    "{} turns at {}: {}\n",
                    point.orbit.breather.turns,
                    point.orbit.breather.omega_b,
                    nearness(point.kantorovich)
                )
            };
            self.points.iter().map(line).collect()
        } else {
            String::new()
        };
        format!(
            "Moving dark breathers on {} sites; depth and tail in units of the background, growth per unit of time.\n\
             Wave number p of the tail, and of the modulation of the background that keeps its phase in the frame of the kink; energy of the kink.\n\n\
             {}\n{}\n{bounds}",
            self.options.sites,
            table(&head, &rows),
            self.words()
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let mut files = vec![("moving.json".to_owned(), format!("{json}\n").into_bytes())];
        files.extend(tables(self).into_iter().map(|(name, table)| (name.to_owned(), table)));
        Ok(files)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        use crate::figures::{Panels, panels};
        let caption = format!("{} hertzchain {}.", caption(self), env!("CARGO_PKG_VERSION"));
        let title = "Moving dark breathers".to_owned();
        Ok(crate::study::named([("moving.png", panels(&Panels { title, columns: columns(self), caption })?)]))
    }

    fn remark(&self) -> Option<String> {
        let places: Vec<String> =
            self.missing.iter().map(|(omega_b, turns, _)| format!("{} with {turns} turns", shown(*omega_b))).collect();
        (!places.is_empty()).then(|| format!("error: no moving breather was found at omega_b = {}", places.join(", ")))
    }

    /// The breathers that were found are written, but one that was not found is a failure.
    fn succeeded(&self) -> bool {
        self.missing.is_empty()
    }
}

/// `moving.csv`: a row for each breather; `envelope.csv`: a row for each of its sites;
/// `passages.csv`: a row for each bond that the kicked breather passes.
pub(crate) fn tables(study: &MovingStudy) -> Vec<(&'static str, Vec<u8>)> {
    let middle = (study.options.sites / 2) as f64;
    let sites = |point: &MovingPoint| {
        let (breather, envelope) = (point.orbit.breather, point.envelope.clone());
        (0..breather.sites).map(move |i| {
            let [amplitude, phase, mean] = [&envelope.amplitude, &envelope.phase, &envelope.mean].map(|all| all[i]);
            vec![breather.omega_b, f64::from(breather.turns), i as f64 - middle, amplitude, phase, mean]
        })
    };
    let rows = study.points.iter().map(|point| point.numbers().to_vec());
    let mut tables = vec![
        ("moving.csv", csv(&NAMES, rows)),
        (
            "envelope.csv",
            csv(&["omega_b", "turns", "n", "amplitude", "phase", "mean"], study.points.iter().flat_map(sites)),
        ),
    ];
    if let Some(run) = &study.kicked {
        let row = |one: &super::Passage| {
            let family = one.velocity.and_then(|velocity| study.depth(velocity));
            vec![one.t, one.bond as f64, one.velocity.unwrap_or(f64::NAN), one.depth, family.unwrap_or(f64::NAN)]
        };
        let names = ["t", "bond", "velocity", "depth", "depth_of_moving"];
        tables.push(("passages.csv", csv(&names, run.passages.iter().map(row))));
    }
    tables
}

/// What the picture shows, with all numbers.
pub(crate) fn caption(study: &MovingStudy) -> String {
    let residual = study.points.iter().map(|point| point.orbit.residual).fold(0.0, f64::max);
    format!(
        "{}, N = {}: {} moving breathers, largest residual {residual:.0e}. {}",
        params_words(study.params()),
        study.options.sites,
        study.points.len(),
        study.words()
    )
}

/// Local amplitudes of the slowest and of the fastest breather; tails and depths over velocities, a
/// line for each frequency, or over frequencies where all have the same turns.
#[cfg(feature = "plot")]
pub(crate) fn columns(study: &MovingStudy) -> Vec<crate::figures::Column> {
    use crate::figures::{Column, Kind, Line, Panel};
    let middle = (study.options.sites / 2) as f64;
    let velocity = |point: &MovingPoint| point.orbit.breather.velocity();
    let by_velocity = |a: &&MovingPoint, b: &&MovingPoint| velocity(a).total_cmp(&velocity(b));
    let ends = [study.points.iter().min_by(by_velocity), study.points.iter().max_by(by_velocity)];
    let profile = |of: &dyn Fn(&MovingPoint, usize) -> f64| -> Vec<Line> {
        let line = |point: &MovingPoint| {
            let values = (0..study.options.sites).map(|i| (i as f64 - middle, of(point, i)));
            Line::new(&format!("v = {:.5}", velocity(point)), values)
        };
        ends.into_iter().flatten().map(line).collect()
    };
    let amplitudes = profile(&|point, i| point.envelope.amplitude[i] / point.envelope.background);
    let phases = profile(&|point, i| point.envelope.phase[i] / std::f64::consts::PI);
    let one = study.options.turns.len() == 1;
    let families = |of: &dyn Fn(&MovingPoint) -> f64| -> Vec<Line> {
        let line = |points: &[MovingPoint]| {
            let first = &points[0].orbit.breather;
            let name = if one { format!("{} turns", first.turns) } else { format!("ω_b = {}", shown(first.omega_b)) };
            let place = |point: &MovingPoint| if one { point.orbit.breather.omega_b } else { velocity(point) };
            let mut family: Vec<(f64, f64)> = points.iter().map(|point| (place(point), of(point))).collect();
            family.sort_by(|a, b| a.0.total_cmp(&b.0));
            Line::new(&name, family)
        };
        let same = |a: &MovingPoint, b: &MovingPoint| one || a.orbit.breather.omega_b == b.orbit.breather.omega_b;
        study.points.chunk_by(same).map(line).collect()
    };
    let mut depths = families(&|point| point.envelope.depth);
    if let (Some(run), false) = (&study.kicked, one) {
        let passages = run.passages.iter().filter_map(|one| Some((one.velocity?, one.depth)));
        depths.push(Line::new("kicked", passages));
    }
    let named = |what: &str, lines: Vec<Line>| -> Vec<Line> {
        lines.into_iter().map(|line| Line { name: format!("{what}, {}", line.name), ..line }).collect()
    };
    let waves = [
        named("tail", families(&|point| point.tail.wave_number / PI)),
        named("resonant", families(&|point| point.resonant_wave() / PI)),
    ]
    .concat();
    let over = if one { "ω_b" } else { "velocity, sites per unit of time" };
    vec![
        Column::new(
            "",
            [
                Panel::new(Kind::Sites, ["site n", "amplitude / background"], amplitudes),
                Panel::new(Kind::Sites, ["site n", "phase / π"], phases),
                Panel::new(Kind::Parameter, [over, "wave number of the tail / π"], waves),
            ],
        ),
        Column::new(
            "",
            [
                Panel::new(Kind::LogParameter, [over, "tail / background"], families(&|point| point.envelope.tail)),
                Panel::new(Kind::Parameter, [over, "depth of the kink"], depths),
                Panel::new(Kind::Parameter, [over, "E − ωJ − vP of the kink"], families(&|point| point.energy.free)),
            ],
        ),
    ]
}
