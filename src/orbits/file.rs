//! Files of orbits and branches, read back to the bit.
//!
//! A branch is an NPZ file: `settings.json` with the numbers that hold for the whole branch, and
//! arrays with a row for each orbit. The arrays `parameter`, `x`, `y` and `residual` are read back;
//! other arrays are for readers of the file. A single orbit is the JSON that `breather dark`
//! writes.

use super::{
    arclength::End,
    continuation::{Continuation, Trail},
    setting::Setting,
    shooting::{Formulation, Orbit, Shooting},
};
use crate::{
    chain::Params,
    dps::Center,
    error::{Error, Result},
    output::{Archive, Array, SETTINGS, npz_with, read, to_json},
};
use hertzchain_integrators::Tolerance;
use serde::{Deserialize, Serialize};
use serde_json::error::Category;
use std::{fs::File, io::Read, path::Path};

/// Format and version of a branch file.
const FORMAT: &str = "hertzchain branch";
const VERSION: u64 = 1;
/// Longest file of one orbit, in bytes.
const MOST_BYTES: u64 = 1 << 26;
/// First bytes of a zip archive that has a member.
const ZIP: &[u8] = b"PK\x03\x04";

/// Format and version of a file.
#[derive(Deserialize)]
#[serde(expecting = "the settings of a branch")]
struct Stamp {
    format: String,
    version: u64,
}

/// The settings of a branch.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "the settings of a branch")]
struct Settings {
    format: String,
    version: u64,
    program: String,
    #[serde(deserialize_with = "Option::deserialize")]
    center: Option<Center>,
    /// Setting of the first orbit.
    setting: Setting,
    continuation: Continuation,
    #[serde(deserialize_with = "Option::deserialize")]
    weak: Option<f64>,
    points: u64,
    ds: f64,
    #[serde(deserialize_with = "Option::deserialize")]
    end: Option<End>,
}

/// Format and version in the JSON of an orbit.
pub(crate) const ORBIT_FORMAT: (&str, u64) = ("hertzchain orbit", 1);

/// The keys of the JSON of an orbit that determine it.
#[derive(Deserialize)]
#[serde(expecting = "an orbit")]
struct OrbitFile {
    #[serde(default = "orbit_format")]
    format: String,
    #[serde(default = "orbit_version")]
    format_version: u64,
    alpha: f64,
    kappa: f64,
    rho: f64,
    sites: usize,
    omega_b: f64,
    turns: u32,
    c_x: f64,
    /// The centre that the orbit was solved for; the measured centre `c_x` is near it.
    c_x_asked: Option<f64>,
    x: Vec<f64>,
    y: Vec<f64>,
}

fn orbit_format() -> String {
    ORBIT_FORMAT.0.to_owned()
}

fn orbit_version() -> u64 {
    ORBIT_FORMAT.1
}

/// The rule that a file breaks if it holds anything else than an orbit or a branch.
const NO_ORBIT: &str = "neither an orbit of `breather dark` nor a branch.npz";

/// Choice of an orbit on a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pick {
    /// By number: from 0 on, or from the last one back, -1, if negative.
    Point(i64),
    /// The orbit with the parameter nearest to this value, within the range of the branch.
    At(f64),
}

/// Largest residual, relative to the strains, of an orbit in a file. The rounding of printed
/// numbers leaves a smaller one.
const ORBIT: f64 = 1e-8;

/// Largest frequency of contacts and resonators in units of that of the orbit.
const FASTEST: f64 = 1e3;

impl Trail {
    /// The settings in the file.
    pub(crate) fn settings(&self) -> Result<impl Serialize> {
        let first = self.orbits.first().ok_or_else(|| Error::parameter("orbits", 0, "at least one"))?;
        Ok(Settings {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: concat!("hertzchain ", env!("CARGO_PKG_VERSION")).to_owned(),
            center: self.center,
            setting: first.setting,
            continuation: self.continuation,
            weak: self.weak,
            points: self.orbits.len() as u64,
            ds: self.ds,
            end: self.end,
        })
    }

    /// The bytes of the branch's file, with the arrays `more` added.
    ///
    /// # Errors
    /// A branch without orbits, and errors of the archive writer.
    pub fn npz(&self, more: Vec<Array<'_>>) -> Result<Vec<u8>> {
        let of = |value: &dyn Fn(&Orbit) -> f64| self.orbits.iter().map(value).collect::<Vec<f64>>();
        let mut arrays = vec![
            Array::vector("parameter", of(&|orbit| orbit.setting.get(self.continuation.parameter))),
            Array::vector("omega_b", of(&|orbit| orbit.setting.omega_b)),
            Array::vector("rho", of(&|orbit| orbit.setting.params.rho)),
            Array::vector("residual", of(&|orbit| orbit.residual)),
            Array::matrix("x", self.orbits.iter().map(Orbit::x)),
            Array::matrix("y", self.orbits.iter().map(Orbit::y)),
        ];
        arrays.extend(more);
        npz_with(SETTINGS, &to_json(&self.settings()?), &arrays)
    }

    /// Reads a branch: the orbits have the bits they had when written; their Newton steps are not
    /// in the file.
    ///
    /// # Errors
    /// A file that cannot be read; [`Error::Content`], with the key and the rule, for a file with
    /// another structure or version, or with numbers outside their rules.
    pub fn load(path: &Path) -> Result<Self> {
        let file = Archive::read(path)?;
        let trail = Self::from_archive(&file)?;
        for (k, orbit) in trail.orbits.iter().enumerate() {
            let measured = orbit.clone().measured(&trail.continuation.shooting);
            measured.map_err(|why| file.refused("x", format!("point {k}: {why}")))?;
        }
        Ok(trail)
    }

    /// Reads a branch from an archive, with all checks that need no integration.
    ///
    /// [`load`](Self::load) checks in addition that the strains are those of orbits.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_archive(file: &Archive) -> Result<Self> {
        let refused = |why: &dyn std::fmt::Display| file.refused(SETTINGS, why.to_string());
        let text = file.text(SETTINGS)?;
        let stamp: Stamp = serde_json::from_str(text).map_err(|why| refused(&why))?;
        if (stamp.format.as_str(), stamp.version) != (FORMAT, VERSION) {
            let Stamp { format, version } = stamp;
            return Err(refused(&format!("{format}, version {version}; read is {FORMAT}, version {VERSION}")));
        }
        let settings: Settings = serde_json::from_str(text).map_err(|why| refused(&why))?;
        let Settings { center, setting, continuation, weak, points, ds, end, .. } = settings;
        if points == 0 {
            return Err(refused(&Error::parameter("points", points, "at least one")));
        }
        let length = |value: f64| value.is_finite() && value > 0.0;
        for (name, value, good, rule) in [
            ("ds", ds, length(ds), "finite and positive"),
            (
                "weak",
                weak.unwrap_or(0.0),
                weak.is_none_or(|weak| weak.is_finite() && weak >= 0.0),
                "finite and at least zero",
            ),
        ] {
            if !good {
                return Err(refused(&Error::parameter(name, value, rule)));
            }
        }
        checked(&setting).map_err(|why| refused(&why))?;
        continuation.validate(setting.get(continuation.parameter)).map_err(|why| refused(&why))?;
        let (shape, sites) = ([points, setting.sites as u64], setting.sites);
        let [parameter, residual] = [file.array("parameter", &shape[..1])?, file.array("residual", &shape[..1])?];
        let [x, y] = [file.array("x", &shape)?, file.array("y", &shape)?];
        for (name, strains) in [("x", &x), ("y", &y)] {
            if let Some(k) = strains.iter().position(|z| !z.is_finite()) {
                let rule = format!("{} at point {}, entry {}: strains are finite", strains[k], k / sites, k % sites);
                return Err(file.refused(name, rule));
            }
        }
        let mut orbits = Vec::new();
        for (k, (x, y)) in x.chunks_exact(sites).zip(y.chunks_exact(sites)).enumerate() {
            let setting = setting.with(continuation.parameter, parameter[k]);
            checked(&setting).map_err(|why| file.refused("parameter", format!("point {k}: {why}")))?;
            orbits.push(Orbit { setting, z: [x, y].concat(), residual: residual[k], newton: Vec::new() });
        }
        Ok(Self { continuation, orbits, ds, end, center, weak })
    }

    /// The chosen orbit.
    ///
    /// # Errors
    /// A number or a value that is not on the branch.
    pub fn pick(&self, pick: Pick) -> Result<&Orbit> {
        let p = |orbit: &Orbit| orbit.setting.get(self.continuation.parameter);
        match pick {
            Pick::Point(k) => {
                let count = self.orbits.len() as i64;
                let index = usize::try_from(if k < 0 { k.saturating_add(count) } else { k }).ok();
                index.and_then(|index| self.orbits.get(index)).ok_or_else(|| {
                    let value = format!("{k} of {count} points");
                    Error::parameter("point", value, "counted from 0, or from the last, -1")
                })
            }
            Pick::At(value) => {
                let (least, most) = self
                    .orbits
                    .iter()
                    .map(p)
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
                let nearest = self.orbits.iter().min_by(|a, b| (p(a) - value).abs().total_cmp(&(p(b) - value).abs()));
                nearest.filter(|_| (least..=most).contains(&value)).ok_or_else(|| {
                    Error::parameter(
                        "at",
                        format!("{value}, of {least} .. {most}"),
                        "a value of the parameter on the branch",
                    )
                })
            }
        }
    }
}

impl Orbit {
    /// Reads an orbit that `breather dark` has written, or the picked orbit of a branch file.
    ///
    /// The numbers are checked, and the residual is measured again.
    ///
    /// # Errors
    /// A file that cannot be read; [`Error::Content`] for a missing or wrong key, numbers outside
    /// their rules, and strains that are not those of an orbit; a branch without a pick, or a pick
    /// that is not on the branch.
    pub fn load(path: &Path, pick: Option<Pick>, shooting: &Shooting) -> Result<Self> {
        Tolerance::RUN.check(shooting.tol)?;
        let fail = |source| Error::File { path: path.to_owned(), source };
        let mut start = Vec::new();
        File::open(path).map_err(fail)?.take(ZIP.len() as u64).read_to_end(&mut start).map_err(fail)?;
        let rule = match (start == ZIP, pick) {
            (true, Some(pick)) => return Trail::load(path)?.pick(pick).cloned(),
            (true, None) => "it is a branch: say which of its orbits, by --point or --at".to_owned(),
            (false, Some(_)) => "it is no branch.npz: only a branch has points".to_owned(),
            (false, None) => match Self::from_json(&read(path, MOST_BYTES)?).map(|orbit| orbit.measured(shooting)) {
                Ok(Ok(orbit)) => return Ok(orbit),
                Ok(Err(rule)) => rule.to_string(),
                Err(rule) => rule,
            },
        };
        Err(Error::Content { path: path.to_owned(), place: "orbit".to_owned(), rule })
    }

    /// Reads the JSON of an orbit, with all checks that need no integration.
    ///
    /// The residual is unknown and set to infinity; [`load`](Self::load) measures it.
    ///
    /// # Errors
    /// The key, and the rule that it breaks.
    pub fn from_json(text: &[u8]) -> std::result::Result<Self, String> {
        let read: OrbitFile = serde_json::from_slice(text).map_err(|why| match why.classify() {
            Category::Data if String::from_utf8_lossy(text).contains("\"bifurcations\"") => {
                format!("{why}; the orbits of a branch are in branch.npz")
            }
            Category::Data => why.to_string(),
            _ => format!("{NO_ORBIT}: no JSON, {why}"),
        })?;
        let (format, version) = ORBIT_FORMAT;
        if (read.format.as_str(), read.format_version) != ORBIT_FORMAT {
            let OrbitFile { format: other, format_version, .. } = read;
            return Err(format!(
                "{other}, format_version {format_version}; read is {format}, format_version {version}"
            ));
        }
        read.orbit().map_err(|why| why.to_string())
    }

    /// The orbit with its residual measured again.
    ///
    /// An orbit that starts at rest is at rest after half a period, so the half-period equations
    /// apply to both formulations.
    fn measured(self, shooting: &Shooting) -> Result<Self> {
        // The integration of strains far from any orbit may take too long.
        if self.setting.fastest_rate(&self.z) > FASTEST {
            let rule = "contacts and resonators of an orbit are at most 1000 times as fast as it is";
            return Err(Error::parameter("strains", self.amplitude(), rule));
        }
        let shooting = Shooting { formulation: Formulation::HalfPeriod, ..*shooting };
        let velocities = shooting.equations(&self.setting, &self.z, false)?.residual;
        let residual = velocities.rows(0, self.z.len()).amax() / self.amplitude();
        if residual <= ORBIT {
            return Ok(Self { residual, ..self });
        }
        let rule = "the velocities of an orbit vanish after half a period, to 1e-8: this is none";
        Err(Error::parameter("residual", residual, rule))
    }
}

impl OrbitFile {
    fn orbit(self) -> Result<Orbit> {
        let Self { alpha, kappa, rho, sites, omega_b, turns, c_x, c_x_asked, x, y, .. } = self;
        let params = Params { alpha, kappa, rho };
        let setting = Setting { params, sites, omega_b, c_x: c_x_asked.unwrap_or(c_x), turns };
        checked(&setting)?;
        for (name, strains) in [("x", &x), ("y", &y)] {
            if strains.len() != sites {
                let value = format!("{} numbers for {sites} sites", strains.len());
                return Err(Error::parameter(name, value, "a number for every site"));
            }
        }
        Ok(Orbit { setting, z: [x, y].concat(), residual: f64::INFINITY, newton: Vec::new() })
    }
}

/// Checks a setting; a ring for orbits has an odd number of sites.
fn checked(setting: &Setting) -> Result<()> {
    setting.chain()?;
    if setting.sites.is_multiple_of(2) {
        return Err(Error::parameter("sites", setting.sites, "an odd number: n = -N .. N"));
    }
    Ok(())
}
