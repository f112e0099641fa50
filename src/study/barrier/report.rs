//! The barrier as text, JSON, files and pictures.

use super::{BarrierPoint, BarrierStudy, CenteredKink};
use crate::{
    error::Result,
    number::shown,
    output::csv,
    present::table,
    study::{File, Report, named, params_words},
};
use serde_json::{Value, json};

impl BarrierStudy {
    /// Frequencies at which a difference changes its sign, interpolated linearly between
    /// neighbouring points.
    pub fn zeros(&self, of: fn(&BarrierPoint) -> f64) -> Vec<f64> {
        let change = |pair: &[BarrierPoint]| {
            let [a, b] = [&pair[0], &pair[1]];
            let [left, right] = [of(a), of(b)];
            (left * right < 0.0).then(|| a.omega_b + (b.omega_b - a.omega_b) * left / (left - right))
        };
        self.points.windows(2).filter_map(change).collect()
    }

    fn words(&self) -> String {
        let say = |what: &str, zeros: &[f64]| {
            let places: Vec<String> = zeros.iter().map(|zero| format!("{zero:.5}")).collect();
            match places.as_slice() {
                [] => format!("At the same {what} the difference keeps its sign."),
                places => format!("At the same {what} it changes its sign at omega_b = {}.", places.join(", ")),
            }
        };
        let both = [self.zeros(BarrierPoint::at_frequency), self.zeros(BarrierPoint::barrier)];
        if both.iter().all(Vec::is_empty) {
            return "Neither difference changes its sign.".to_owned();
        }
        format!("{} {}", say("frequency", &both[0]), say("action and length", &both[1]))
    }
}

impl Report for BarrierStudy {
    fn json(&self) -> Value {
        let kink = |kink: &CenteredKink| {
            json!({
                "energy": kink.kink_energy,
                "action": kink.kink_action,
                "length": kink.kink_length,
                "ring_energy": kink.energy,
                "ring_action": kink.action,
                "ring_length": kink.length,
                "real": kink.real,
                "max_modulus": kink.largest,
                "residual": kink.orbit.residual,
            })
        };
        let row = |point: &BarrierPoint| {
            json!({
                "omega_b": point.omega_b,
                "background": point.background,
                "site": kink(&point.kinks[0]),
                "bond": kink(&point.kinks[1]),
                "at_frequency": point.at_frequency(),
                "at_action_and_length": point.barrier(),
            })
        };
        let ring = &self.options.ring;
        json!({
            "alpha": ring.alpha,
            "kappa": ring.kappa,
            "rho": ring.rho,
            "sites": ring.sites,
            "c_x": ring.c_x,
            "points": self.points.iter().map(row).collect::<Vec<_>>(),
            "sign_changes": {
                "at_frequency": self.zeros(BarrierPoint::at_frequency),
                "at_action_and_length": self.zeros(BarrierPoint::barrier),
            },
            "missing": self.missing,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let row = |point: &BarrierPoint| {
            let [site, bond] = &point.kinks;
            let number = |value: f64| format!("{value:.6e}");
            let modulus = |value: f64| format!("{value:.6}");
            vec![
                format!("{:.6}", point.omega_b),
                number(site.kink_energy),
                number(bond.kink_energy),
                number(point.at_frequency()),
                number(point.barrier()),
                modulus(site.real),
                modulus(bond.real),
                modulus(site.largest),
                modulus(bond.largest),
            ]
        };
        let rows: Vec<Vec<String>> = self.points.iter().map(row).collect();
        let head = [
            "omega_b",
            "energy, site",
            "energy, bond",
            "bond - site",
            "same action, length",
            "real, site",
            "real, bond",
            "|l|, site",
            "|l|, bond",
        ];
        format!(
            "Energies of kinks relative to their background on {} sites, and their largest multipliers: real, and in modulus |l|\n\n{}\n{}\n",
            self.options.ring.sites,
            table(&head, &rows),
            self.words()
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let mut files = named([("barrier.json", json.into())]);
        files.extend(tables(self).into_iter().map(|(name, bytes)| (name.to_owned(), bytes)));
        Ok(files)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        use crate::figures::{Panels, panels};
        let caption = format!("{} hertzchain {}.", caption(self), env!("CARGO_PKG_VERSION"));
        let title = "Peierls–Nabarro barrier of dark breathers".to_owned();
        Ok(named([("barrier.png", panels(&Panels { title, columns: vec![columns(self)], caption })?)]))
    }

    fn remark(&self) -> Option<String> {
        let places: Vec<String> = self.missing.iter().map(|omega_b| shown(*omega_b)).collect();
        (!places.is_empty()).then(|| format!("error: no pair of orbits was found at omega_b = {}", places.join(", ")))
    }

    /// The points that were found are written, but a frequency without orbits is a failure.
    fn succeeded(&self) -> bool {
        self.missing.is_empty()
    }
}

/// `barrier.csv`: a row for each frequency.
pub(crate) fn tables(study: &BarrierStudy) -> Vec<(&'static str, Vec<u8>)> {
    let names = [
        "omega_b",
        "background_energy",
        "background_action",
        "background_length",
        "background_force",
        "site_energy",
        "site_action",
        "site_length",
        "bond_energy",
        "bond_action",
        "bond_length",
        "at_frequency",
        "at_action_and_length",
        "site_real",
        "bond_real",
        "site_largest",
        "bond_largest",
    ];
    let row = |point: &BarrierPoint| {
        let [site, bond] = &point.kinks;
        vec![
            point.omega_b,
            point.background.energy,
            point.background.action,
            point.background.length,
            point.background.force,
            site.kink_energy,
            site.kink_action,
            site.kink_length,
            bond.kink_energy,
            bond.kink_action,
            bond.kink_length,
            point.at_frequency(),
            point.barrier(),
            site.real,
            bond.real,
            site.largest,
            bond.largest,
        ]
    };
    vec![("barrier.csv", csv(&names, study.points.iter().map(row)))]
}

/// What the picture shows, with all numbers.
pub(crate) fn caption(study: &BarrierStudy) -> String {
    let ring = &study.options.ring;
    let params = crate::chain::Params { alpha: ring.alpha, kappa: ring.kappa, rho: ring.rho };
    let ends = [study.points.first(), study.points.last()].map(|point| {
        point.map_or(String::new(), |point| {
            format!("{} at {}", shown(point.barrier()), shown(point.omega_b)).replace('-', "−")
        })
    });
    format!(
        "{}, N = {}: energy of the bond-centred breather less that of the site-centred one, at the same action and length {} and {}. {}",
        params_words(params),
        ring.sites,
        ends[0],
        ends[1],
        study.words().replace("omega_b", "ω_b")
    )
}

/// Panels against frequency: energies of the kinks over the background's energy per site, their
/// differences over the energy of the kink about a site, and largest multipliers.
#[cfg(feature = "plot")]
pub(crate) fn columns(study: &BarrierStudy) -> crate::figures::Column {
    use crate::figures::{Column, Kind, Line, Panel};
    let line = |name: &str, of: &dyn Fn(&BarrierPoint) -> f64| {
        Line::new(name, study.points.iter().map(|point| (point.omega_b, of(point))))
    };
    let panel = |label: &str, lines| Panel::new(Kind::Parameter, ["ω_b", label], lines);
    let per_site = |value: f64, point: &BarrierPoint| value / point.background.energy;
    let energies = vec![
        line("site", &|point| per_site(point.kinks[0].kink_energy, point)),
        line("bond", &|point| per_site(point.kinks[1].kink_energy, point)),
    ];
    let share = |value: f64, point: &BarrierPoint| value / point.kinks[0].kink_energy.abs();
    let differences = vec![
        line("same frequency", &|point| share(point.at_frequency(), point)),
        line("same action and length", &|point| share(point.barrier(), point)),
    ];
    let moduli = vec![
        line("site, any", &|point| point.kinks[0].largest),
        line("bond, any", &|point| point.kinks[1].largest),
        line("site, real", &|point| point.kinks[0].real),
        line("bond, real", &|point| point.kinks[1].real),
    ];
    Column::new(
        format!("ρ = {}", crate::number::written(study.options.ring.rho)),
        [
            panel("energy of a kink / e", energies),
            Panel::new(Kind::LogParameter, ["ω_b", "bond − site, share of kink"], differences),
            panel("largest |λ|", moduli),
        ],
    )
}
