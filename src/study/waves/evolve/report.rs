//! What the evolution of an orbit reports.

use super::{Evolution, Motion};
use crate::{
    chain::max_norm,
    report::{Column, Fixed, Kind, Panels, Power, Report, SpaceTime, Table, fields},
    study::{format_short, params_words},
};
use serde_json::json;

/// Time, return error and position of each period.
fn periods(rows: &[(usize, [f64; 3])]) -> Table {
    Table::of("evolution", rows)
        .key("")
        .few(20)
        .col("t", Fixed(4), "time", |(_, row)| row[0])
        .col("e_b", Power(6), "largest change of a strain over the largest strain (eq:relerr)", |(_, row)| row[1])
        .col("position", Fixed(6), "site of the kink", |(_, row)| row[2])
        .col("period", Fixed(0), "number of periods from the start", |(m, _)| *m)
        .done()
}

/// How the kink moves.
fn motion(rows: &[Motion]) -> Table {
    Table::of("motion", rows)
        .key("motion")
        .col("from", Fixed(1), "", |one| one.window.0)
        .col("to", Fixed(1), "", |one| one.window.1)
        .col("velocity", Power(6), "sites per unit of time, of a line fitted to the positions", |one| one.velocity)
        .col("misfit", Power(1), "largest distance of a position from the line, in sites", |one| one.misfit)
        .done()
}

pub(super) fn outline() -> Report {
    Report::new("evolution").table(periods(&[])).table(motion(&[]))
}

impl Evolution {
    /// The report. In JSON, times, return errors and positions are lists with one number a period.
    pub fn report(&self) -> Report {
        let (setting, [periods, x, y]) = (self.orbit.setting, self.tables());
        let json = |(kick, lambda): (super::Kick, nalgebra::Complex<f64>)| json!({ "size": kick.size, "mode": kick.mode, "re": lambda.re, "im": lambda.im });
        let kicked = self.kick.map_or("not kicked".to_owned(), |(kick, lambda)| {
            let number = if lambda.im == 0.0 { format!("{:.9}", lambda.re) } else { format!("{lambda:.9}") };
            format!("kicked by {} of its amplitude along the mode of λ = {number}", kick.size)
        });
        let time = |kind, label: &str, column| periods.panel(kind, ["time t", label], "t", &[(label, column)]);
        let mut lines = [time(Kind::LogTime, "return error E_b", "e_b"), time(Kind::Time, "kink at n", "position")];
        // A zero has no place on a logarithmic axis: it is drawn below every rounding.
        lines[0].lines[0].points.iter_mut().for_each(|point| point.1 = point.1.max(1e-17));
        let end = self.times.last().zip(self.e_b.last());
        let end = end.map_or(String::new(), |(t, e_b)| {
            format!(" Return error after {} periods E_b({t:.0}) = {e_b:.1e};", self.e_b.len() - 1)
        });
        let white = self.maps().any(|map| map.most.is_some()).then_some(", white above twice that of the orbit");
        let caption = format!(
            "N = {}, {}. ω_b = {}, {kicked}. Colours: largest strain in each {} of time{}.{end} in linear theory roundings would \
             grow by a factor of {:.1e}.",
            setting.sites,
            params_words(setting.params),
            setting.omega_b,
            format_short(self.swing.span),
            white.unwrap_or_default(),
            self.amplification,
        );
        let columns = vec![Column::new("", self.maps()), Column::new("", lines)];
        Report::new("evolution")
            .fact("alpha", setting.params.alpha)
            .fact("kappa", setting.params.kappa)
            .fact("omega_b", setting.omega_b)
            .fact("rho", setting.params.rho)
            .fact("sites", setting.sites)
            .fact("period", setting.period())
            .fact("kick", self.kick.map(json))
            .fact("t", &self.times)
            .facts(fields!(self => e_b, position, amplification, failure))
            .fact("integrator", "collocation")
            .fact("tol", self.tol)
            .table(periods)
            .words(format!(
                "{kicked}; small perturbations, also rounding errors, grow by a factor of at least {:.1e} in this run",
                self.amplification
            ))
            .table(motion(&self.motion))
            .table(x)
            .table(y)
            .failure(self.failure.as_ref().map(|why| format!("the run ended early: {why}")))
            .picture(Panels { title: "Run from a periodic orbit".into(), columns, caption })
    }

    /// Return error and position with a row a period; largest strains of beads and of resonators
    /// in time, with a column a site.
    fn tables(&self) -> [Table; 3] {
        let (sites, span) = (self.orbit.setting.sites, self.swing.span);
        let rows = self.times.iter().zip(&self.e_b).zip(&self.position).map(|((t, e_b), place)| [*t, *e_b, *place]);
        let t: Vec<f64> = (0..self.swing.x.len() / sites).map(|row| (row as f64 + 0.5) * span).collect();
        let strains = |symbol: &str, values: &[f64]| {
            let t = &t[..values.len() / sites];
            Table::matrix(format!("evolution-{symbol}"), (symbol, -((sites / 2) as i64)), t, values)
        };
        let rows: Vec<_> = rows.enumerate().collect();
        [periods(&rows), strains("x", &self.swing.x), strains("y", &self.swing.y)]
    }

    /// Largest strains over space and time, beads and resonators; the scale of colours ends at
    /// twice the largest of the first row at most: the motion before a break-up stays visible.
    fn maps(&self) -> impl Iterator<Item = SpaceTime> {
        let (sites, span) = (self.orbit.setting.sites, self.swing.span);
        let centre = if self.orbit.setting.c_x == 0.0 { "" } else { " − Cₓ" };
        let map = move |(symbol, values): (&str, &[f64])| SpaceTime {
            site_label: "site n".into(),
            time_label: "time t".into(),
            value_label: format!("largest |{symbol}{centre}|"),
            values: values.to_vec(),
            most: Some(2.0 * max_norm(values[..sites].iter().copied())).filter(|most| values.iter().any(|x| x > most)),
            sites,
            first_site: -((sites / 2) as f64),
            times: (0.5 * span, ((values.len() / sites) as f64 - 0.5) * span),
            ..Default::default()
        };
        let all = [("xₙ", &self.swing.x[..]), ("yₙ", &self.swing.y[..])];
        all.into_iter().filter(|(_, values)| !values.is_empty()).map(map)
    }
}
