//! The reports of exact waves and of their branches.

use super::{BlochGrowth, ExactStudy, WaveBranchStudy};
use crate::{
    error::Result,
    number::{format_short, of_pi},
    report::{Column, Fixed, Hidden, Json, Kind, Panel, Panels, Power, Report, Rows, Table, fields},
    study::{
        orbits::branches::{self, BranchRow, Kept, branch_npz},
        params_words,
    },
    waves::{
        ExactWave, Profile, TravellingWave, WaveContinuation, WaveMultiplier, WaveParameter, WavePoint, WaveSpectrum,
    },
};
use serde_json::json;
use std::f64::consts::PI;

/// What determines a wave, and how well it is solved.
fn wave_columns<'a, T>(rows: Rows<'a, T>, of: impl Fn(&T) -> &ExactWave + Copy + 'a) -> Rows<'a, T> {
    rows.col("q_over_pi", Hidden, "wave number over pi", move |one| of(one).setting.q.q() / PI)
        .col("alpha", Hidden, "", move |one| of(one).setting.params.alpha)
        .col("kappa", Hidden, "", move |one| of(one).setting.params.kappa)
        .col("rho", Hidden, "", move |one| of(one).setting.params.rho)
        .col("omega_tw", Fixed(9), "frequency", move |one| of(one).setting.omega_tw)
        .col("period", Hidden, "2 pi/omega_tw", move |one| of(one).setting.period())
        .col("amplitude", Power(9), "height of the crest above the mean strain", move |one| of(one).amplitude())
        .col("mean_strain", Power(9), "mean of the strains over a period", move |one| of(one).mean())
        .col("residual", Power(1), "of Newton's method, over the amplitude", move |one| of(one).residual)
}

/// Panels without lines that have no point.
fn filled(mut panel: Panel) -> Panel {
    panel.lines.retain(|line| !line.points.is_empty());
    panel
}

impl ExactStudy {
    /// The report.
    pub fn report(&self) -> Report {
        let (wave, spectrum) = (&self.wave, &self.spectrum);
        let [x, y, vx, vy] = wave.on_ring(spectrum.sites);
        let quality = &spectrum.quality;
        let checks = format!(
            "Contacts are closed for {:.4} of the period. {} of {} multipliers grow. Checks: symplectic defect {:.1e}, \
             eigenvectors {:.1e}, phase shift {:.1e}, linear {:.1e}, pairs {:.1e}.",
            self.profile.closed(),
            spectrum.growing(),
            spectrum.multipliers.len(),
            quality.symplectic_defect,
            quality.eigen_residual,
            quality.phase_shift,
            quality.linear,
            quality.pairing,
        );
        let ansatz = self.ansatz.map(|ansatz| {
            json!({
                "epsilon": ansatz.epsilon(),
                "amplitude": ansatz.amplitude(),
                "omega_tw": ansatz.omega_tw(),
                "mean_strain": ansatz.epsilon() * ansatz.shape().b,
            })
        });
        let row = wave_columns(Table::of("exact", std::slice::from_ref(wave)), |wave| wave).key("").done();
        let title = format!("Exact travelling wave, q = {}", of_pi(wave.setting.q.q()));
        let report = self
            .tables()
            .into_iter()
            .fold(Report::new("exact").words(self.caption()).table(row.clone()), Report::table);
        report
            .facts(&row.json()[0])
            .facts(fields!(self => scene; spectrum => sites; wave.setting.q => cell()))
            .fact("x", x)
            .fact("y", y)
            .fact("vx", vx)
            .fact("vy", vy)
            .fact("newton", &wave.newton)
            .fact("fourier", &self.fourier[0])
            .fact("fourier_y", &self.fourier[1])
            .facts(fields!(self => odd; self.profile => closed()))
            .fact("quality", quality)
            .facts(fields!(spectrum => growing(), fastest()))
            .fact("e_x_ansatz", self.errors.map(|errors| errors[0]))
            .fact("e_y_ansatz", self.errors.map(|errors| errors[1]))
            .fact("ansatz", ansatz)
            .words(checks)
            .picture(Panels { title, columns: self.columns(), caption: self.caption() })
    }

    /// What a picture of the wave shows, with all numbers.
    fn caption(&self) -> String {
        let wave = &self.wave;
        let fastest = self.spectrum.fastest().map_or("no multiplier grows".to_owned(), |fastest| {
            format!(
                "the fastest multiplier grows by {} a unit of time at p = {}",
                format_short(fastest.growth),
                of_pi(fastest.bloch)
            )
        });
        let beside = match (self.ansatz, self.errors) {
            (Some(ansatz), Some([e_x, e_y])) => {
                let [amplitude, e_x, e_y] = [ansatz.amplitude(), e_x, e_y].map(format_short);
                format!(", that of the ansatz {amplitude}, E_x = {e_x}, E_y = {e_y}")
            }
            _ => String::new(),
        };
        format!(
            "{}, q = {}, ω_tw = {}, mean strain {}, N = {}: amplitude {}{beside}, residual {:.0e}; {fastest}.",
            params_words(wave.setting.params),
            of_pi(wave.setting.q.q()),
            wave.setting.omega_tw,
            format_short(wave.mean()),
            self.spectrum.sites,
            format_short(wave.amplitude()),
            wave.residual,
        )
    }

    fn tables(&self) -> [Table; 4] {
        let Profile { x, y } = &self.profile;
        // Without moving resonators there is no y.
        let at = |values: &[f64], k: usize| values.get(k).copied().unwrap_or(f64::NAN);
        let apart = |exact: f64, phi: f64, share: f64| {
            let of = |ansatz: TravellingWave| {
                let (mean, height) = (ansatz.epsilon() * ansatz.shape().b, share * ansatz.amplitude());
                100.0 * (exact - (mean + height * phi.cos())) / height.abs()
            };
            self.ansatz.map_or(f64::NAN, of)
        };
        let rho = self.wave.setting.params.rho;
        let row = |(k, phi): (usize, f64)| {
            let [x, y] = [at(x, k), at(y, k)];
            [phi, x, y, apart(x, phi, 1.0), apart(y, phi, -1.0 / rho)]
        };
        let profile: Vec<[f64; 5]> = self.profile.phases().enumerate().map(row).collect();
        let ([x, y], cell) = (&self.fourier, self.wave.setting.q.cell());
        let steep = -self.wave.setting.params.alpha - 3.0;
        let fourier = |k: usize| {
            // Harmonics that are a multiple of the cell vanish, up to roundings.
            let share = if k.is_multiple_of(cell) { f64::NAN } else { (x[k] / x[1]).abs() };
            (k, [x[k], at(y, k), share, (k as f64).powf(steep)])
        };
        let fourier: Vec<_> = (0..x.len()).map(fourier).collect();
        let period = self.wave.setting.period();
        [
            profile_table(&profile),
            fourier_table(&fourier),
            growth_table(&self.growth, period),
            multipliers(&self.spectrum.multipliers),
        ]
    }

    /// Profiles, and their differences from the ansatz; Fourier coefficients beside the power that
    /// a jump of the contact force's derivatives makes, and growth.
    fn columns(&self) -> Vec<Column> {
        let [profile, fourier, growth, _] = self.tables();
        let over = |label: &str, lines: &[(&str, &str)]| {
            filled(profile.panel(Kind::Time, ["phase φ/π", label], "phi_over_pi", lines))
        };
        let profiles = [
            over("strain", &[("X exact", "x"), ("Y exact", "y")]),
            over("exact − ansatz, % of amplitude", &[("X", "x_apart"), ("Y", "y_apart")]),
        ];
        let law = format!("k^−{}", self.wave.setting.params.alpha + 3.0);
        let lines = [("|f_k|/f₁ of X", "share"), (law.as_str(), "law")];
        let labels = ["Bloch wave number p/π", "growth per unit of time"];
        let rates = [("exact", "exact"), ("DpS", "modulation")];
        let mut growth = growth.panel(Kind::Parameter, labels, "bloch_over_pi", &rates);
        let profiles = profiles.into_iter().filter(|panel| !panel.lines.is_empty());
        let mut fourier = fourier.panel(Kind::LogLog, ["harmonic k", "coefficient"], "k", &lines);
        (growth.lines[1].law, fourier.lines[1].law) = (true, true);
        vec![Column::new("", profiles), Column::new("", [fourier, filled(growth)])]
    }
}

pub(super) fn outline() -> Report {
    let tables = [
        wave_columns(Table::of("exact", &[]), |wave| wave).done(),
        profile_table(&[]),
        fourier_table(&[]),
        growth_table(&[], 0.0),
        multipliers(&[]),
    ];
    tables.into_iter().fold(Report::new("exact"), Report::table)
}

/// Phase, `X` and `Y`, and their differences from the ansatz.
fn profile_table(rows: &[[f64; 5]]) -> Table {
    Table::of("profile", rows)
        .key("")
        .col("phi", Hidden, "phase", |row| row[0])
        .col("phi_over_pi", Hidden, "the same over pi", |row| row[0] / PI)
        .col("x", Hidden, "strain X of beads", |row| row[1])
        .col("y", Hidden, "strain Y of resonators", |row| row[2])
        .col("x_apart", Hidden, "X less that of the ansatz, in percent of its amplitude", |row| row[3])
        .col("y_apart", Hidden, "the same of Y", |row| row[4])
        .done()
}

/// Harmonics, with coefficients of `X` and `Y`, their share of the first, and the law.
fn fourier_table(rows: &[(usize, [f64; 4])]) -> Table {
    Table::of("fourier", rows)
        .key("")
        .col("k", Hidden, "harmonic", |row| row.0)
        .col("x", Hidden, "coefficient f_k of X", |row| row.1[0])
        .col("y", Hidden, "the same of Y", |row| row.1[1])
        .col("share", Hidden, "|f_k|/f_1 of X", |row| row.1[2])
        .col("law", Hidden, "k^-(alpha + 3)", |row| row.1[3])
        .done()
}

fn growth_table(rows: &[BlochGrowth], period: f64) -> Table {
    Table::of("growth", rows)
        .key("growth")
        .col("bloch", Hidden, "Bloch wave number", |row| row.bloch)
        .col("bloch_over_pi", Fixed(4), "Bloch wave number over pi", |row| row.bloch / PI)
        .head("p/pi")
        .col("exact", Power(6), "largest growth of the wave, per unit of time", |row| row.exact)
        .col("modulation", Power(6), "the same by the linearised modulation equations", |row| row.modulation)
        .col("factor", Fixed(6), "growth of the wave in a period", move |row| (row.exact * period).exp())
        .done()
}

fn multipliers(rows: &[WaveMultiplier]) -> Table {
    Table::of("multipliers", rows)
        .key("multipliers")
        .col("bloch", Hidden, "Bloch wave number", |one| one.bloch)
        .col("re", Hidden, "real part of the multiplier", |one| one.re)
        .col("im", Hidden, "imaginary part", |one| one.im)
        .col("modulus", Hidden, "absolute value", |one| one.modulus)
        .col("error", Hidden, "estimated error of the modulus", |one| one.error)
        .col("krein", Hidden, "Krein signature on the circle, 0 elsewhere", |one| f64::from(one.krein))
        .col("growth", Hidden, "per unit of time", |one| one.growth)
        .col("frequency", Hidden, "in radians per unit of time", |one| one.frequency)
        .col("kind", Hidden, "where it lies", |one| one.kind.name())
        .done()
}

pub(super) fn branch(study: &WaveBranchStudy) -> Result<Report> {
    let WaveBranchStudy { scene, branch, .. } = study;
    let (continuation, base, end) = (branch.continuation, branch.setting, branch.ended());
    let fast = |point: &WavePoint| {
        let (growth, modulation) = (point.spectrum.fastest()?.growth, point.measures.modulation?);
        let words = || {
            let (omega_tw, amplitude) = (point.orbit.setting.omega_tw, format_short(point.orbit.amplitude()));
            let (growth, modulation) = (format_short(growth), format_short(modulation));
            format!(
                " Growth first exceeds twice that of DpS at ω_tw = {omega_tw:.5}, amplitude {amplitude}: {growth} against \
                     {modulation}."
            )
        };
        (growth > 2.0 * modulation).then(words)
    };
    let grows = branch.points.iter().find_map(fast).unwrap_or_default();
    let about = format!(
        "{} at the first wave, N = {}. {} waves; the branch ends because {}.{}{grows}",
        params_words(base.setting.params),
        base.sites,
        branches::rows(branch).len(),
        end.words(),
        branches::gaps(branch),
    );
    let title = format!("Branch of exact travelling waves in {}", continuation.parameter.symbol());
    let report = Report::new("waves")
        .fact("scene", scene)
        .facts(fields!(continuation => parameter, to; base => sites))
        .table(study.table())
        .words(&about)
        .fact("end", end)
        .picture(Panels::column(title, study.panels(), about));
    let report = report.file(WaveContinuation::NAMES[0], branch_npz(scene, branch)?);
    Ok(branches::checked(report, branch, &None))
}

impl WaveBranchStudy {
    pub(super) fn table(&self) -> Table {
        waves(&branches::rows(&self.branch), self.branch.continuation.parameter)
    }

    /// Amplitude, and largest growth beside that of the modulation equations.
    pub(crate) fn panels(&self) -> Vec<Panel> {
        let (symbol, table) = (self.branch.continuation.parameter.symbol(), self.table());
        let panel = |kind, label, lines: &[(&str, &str)]| table.panel(kind, [symbol, label], "parameter", lines);
        let mut growth = panel(Kind::LogParameter, "largest growth", &[("exact", "growth"), ("DpS", "modulation")]);
        growth.lines.iter_mut().for_each(|line| line.points.retain(|point| point.1 > 0.0));
        growth.lines[1].law = true;
        branches::filled([
            panel(Kind::Parameter, "amplitude", &[("amplitude", "amplitude")]),
            filled(growth),
            panel(Kind::LogParameter, "error of the ansatz", &[("E_x", "e_x_ansatz"), ("E_y", "e_y_ansatz")]),
        ])
    }
}

/// The waves of a branch in a parameter.
fn waves(rows: &[BranchRow<'_, WaveContinuation>], parameter: WaveParameter) -> Table {
    let beside = matches!(parameter, WaveParameter::Rho | WaveParameter::Kappa | WaveParameter::Alpha);
    let rows = Table::of("waves", rows)
        .key("waves")
        .col("parameter", if beside { Fixed(9) } else { Hidden }, "what varies", move |row| parameter.of(row.orbit))
        .head(parameter.name());
    let fastest = |spectrum: Option<&WaveSpectrum>| spectrum?.fastest().copied();
    wave_columns(rows, |row| row.orbit)
        .col("growth", Power(4), "largest growth, per unit of time", move |row| {
            row.spectrum.map(|_| fastest(row.spectrum).map_or(0.0, |one| one.growth))
        })
        .col("bloch", Hidden, "its Bloch wave number", move |row| Some(fastest(row.spectrum)?.bloch))
        .col("growing", Hidden, "multipliers that grow", |row| Some(row.spectrum?.growing()))
        .col("modulation", Power(3), "largest growth by the linearised modulation equations", |row| {
            row.measures?.modulation
        })
        .col("e_x_ansatz", Power(3), "error of the ansatz, beads", |row| Some(row.measures?.errors?[0]))
        .col("e_y_ansatz", Hidden, "error of the ansatz, resonators", |row| Some(row.measures?.errors?[1]))
        .col("closed", Fixed(4), "share of the period in which a contact is closed", |row| Some(row.measures?.closed))
        .col("quality", Json, "", |row| json!(row.spectrum.map(|spectrum| spectrum.quality)))
        .done()
}

pub(super) fn branch_outline() -> Report {
    Report::new("waves").table(waves(&[], WaveParameter::OmegaTw))
}
