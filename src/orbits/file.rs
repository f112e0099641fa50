//! Files of orbits and branches, read back to the bit.
//!
//! A branch is an NPZ file: `settings.json` with the numbers that hold for the whole branch, and
//! arrays with a row for each orbit. The arrays `parameter`, `residual` and those of the unknowns
//! are read back; other arrays, such as `multipliers_re`, are for readers of the file. A single
//! orbit is the JSON that `breather dark` writes.

use super::{
    arclength::{End, Solution},
    bifurcation::BifurcationKind,
    branch::{Branch, Problem},
    setting::{Parameter, Setting},
    shooting::{Formulation, Orbit, Shooting},
};
use crate::{
    chain::Params,
    dps::Center,
    error::{Error, Result},
    numerics::{extremes, least_by},
    output::{Archive, Array, FileFormat, PROGRAM, SETTINGS, npz_with, read, to_json},
};
use hertzchain_integrators::Tolerance;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::error::Category;
use std::{fs::File, io::Read, path::Path};

/// Longest file of one orbit, in bytes.
const MOST_BYTES: u64 = 1 << 26;
/// First bytes of a zip archive that has a member.
const ZIP: &[u8] = b"PK\x03\x04";

/// The settings of a branch.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "the settings of a branch")]
struct Settings<P, S> {
    format: String,
    version: u64,
    program: String,
    #[serde(deserialize_with = "Option::deserialize")]
    center: Option<Center>,
    /// What determines the setting of the first orbit.
    setting: S,
    continuation: P,
    #[serde(deserialize_with = "Option::deserialize")]
    weak: Option<f64>,
    /// Given if it is not the parameter of the first orbit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    back: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    birth: Option<BifurcationKind>,
    points: u64,
    ds: f64,
    #[serde(deserialize_with = "Option::deserialize")]
    end: Option<End>,
}

/// Names of the arrays of multipliers.
const MULTIPLIERS: [&str; 3] = ["multipliers_re", "multipliers_im", "modulus_error"];

/// Format and version in the JSON of an orbit.
pub(crate) const ORBIT_FORMAT: FileFormat = FileFormat("hertzchain orbit", 1);

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

impl<P: Problem> Branch<P> {
    /// The settings in the file, of a branch whose setting has this `source`.
    fn settings_of<S: Serialize>(&self, source: S) -> impl Serialize {
        let FileFormat(format, version) = P::FORMAT;
        Settings {
            format: format.to_owned(),
            version,
            program: PROGRAM.to_owned(),
            center: self.center,
            setting: source,
            continuation: self.continuation,
            weak: self.weak,
            back: self.birth.map(|_| self.back),
            birth: self.birth,
            points: self.orbits.len() as u64,
            ds: self.ds,
            end: self.end,
        }
    }

    /// The bytes of the file of a branch whose setting has this `source`, with the arrays `more`
    /// added.
    pub(crate) fn npz_of(&self, source: impl Serialize, more: Vec<Array<'_>>) -> Result<Vec<u8>> {
        let (continuation, setting) = (&self.continuation, &self.setting);
        let all: Vec<Solution> = self.orbits.iter().map(|orbit| continuation.numbers(setting, orbit)).collect();
        let mut arrays = vec![
            Array::vector("parameter", all.iter().map(|one| one.p).collect()),
            Array::vector("residual", all.iter().map(|one| one.residual).collect()),
        ];
        let mut from = 0;
        for (name, width) in P::arrays(setting) {
            arrays.push(Array::matrix(name, all.iter().map(|one| &one.z[from..from + width])));
            from += width;
        }
        arrays.extend(more);
        arrays.extend(self.multipliers());
        npz_with(SETTINGS, &to_json(&self.settings_of(source)), &arrays)
    }

    /// The arrays of multipliers, with rows of NaN for orbits without them; none if no multipliers
    /// are known.
    fn multipliers(&self) -> Vec<Array<'static>> {
        let Some(first) = self.points.first() else { return Vec::new() };
        let unknown = vec![[f64::NAN; 3]; P::multipliers(&first.spectrum).len()];
        let mut points = self.points.iter().peekable();
        let rows: Vec<Vec<[f64; 3]>> = (self.orbits.iter().map(|orbit| self.parameter(orbit)))
            .map(|p| points.next_if(|point| self.parameter(&point.orbit) == p))
            .map(|point| point.map_or(unknown.clone(), |point| P::multipliers(&point.spectrum)))
            .collect();
        let part = |k: usize| rows.iter().map(|row| row.iter().map(|one| one[k]).collect()).collect::<Vec<Vec<f64>>>();
        let arrays = MULTIPLIERS.iter().enumerate();
        arrays.map(|(k, name)| Array::matrix(name, part(k).iter().map(Vec::as_slice))).collect()
    }

    /// Reads a branch from an archive, with all checks that need no integration; `made` makes the
    /// setting from its source, for a branch that begins at such a bifurcation.
    pub(crate) fn read<S: DeserializeOwned, A>(
        file: &Archive,
        made: impl Fn(S, Option<BifurcationKind>) -> Result<(A, P::Setting)>,
    ) -> Result<(A, Self)> {
        let refused = |why: &dyn std::fmt::Display| file.refused(SETTINGS, why.to_string());
        let settings: Settings<P, S> = P::FORMAT.read(file)?;
        let Settings { center, setting: source, continuation, weak, back, birth, points, ds, end, .. } = settings;
        for (name, value, good, rule) in [
            ("points", points as f64, points > 0, "at least one"),
            ("ds", ds, ds.is_finite() && ds > 0.0, "finite and positive"),
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
        let (about, setting) = made(source, birth).map_err(|why| refused(&why))?;
        let numbers = |name: &str, shape: &[u64]| {
            let (values, width) = (file.array(name, shape)?, shape.get(1).map_or(1, |width| *width as usize));
            match values.iter().position(|value| !value.is_finite()) {
                None => Ok(values),
                Some(k) => {
                    let place = format!("{} at point {}, entry {}", values[k], k / width, k % width);
                    Err(file.refused(name, format!("{place}: numbers of an orbit are finite")))
                }
            }
        };
        let (parameter, residual) = (file.array("parameter", &[points])?, numbers("residual", &[points])?);
        let arrays = P::arrays(&setting);
        let read = |&(name, width): &(_, usize)| Ok((width, numbers(name, &[points, width as u64])?));
        let z = arrays.iter().map(read).collect::<Result<Vec<_>>>()?;
        let mut orbits = Vec::new();
        for (k, (&p, &residual)) in parameter.iter().zip(&residual).enumerate() {
            let value = continuation.check_value(&setting, p);
            value.map_err(|why| file.refused("parameter", format!("point {k}: {why}")))?;
            let z = z.iter().flat_map(|(width, all)| &all[k * width..(k + 1) * width]).copied().collect();
            orbits.push(continuation.restored(&setting, Solution { z, p, residual, newton: Vec::new() }));
        }
        let branch = Self::new(continuation, setting, orbits[0].clone()).map_err(|why| refused(&why))?;
        let back = back.unwrap_or(branch.back);
        let branch = Self { back, birth, center, weak, orbits, ds, end, ..branch };
        branch.check().map_err(|why| refused(&why))?;
        Ok((about, branch))
    }

    /// Refuses a branch from a file if its numbers are not those of orbits.
    pub(crate) fn verified(self, file: &Archive) -> Result<Self> {
        for (k, orbit) in self.orbits.iter().enumerate() {
            let verified = self.continuation.verify(&self.setting, orbit);
            verified.map_err(|why| file.refused(P::arrays(&self.setting)[0].0, format!("point {k}: {why}")))?;
        }
        Ok(self)
    }
}

impl Branch {
    /// The settings in the file.
    pub(crate) fn settings(&self) -> impl Serialize {
        self.settings_of(self.source())
    }

    /// The setting of the first orbit.
    pub(crate) fn source(&self) -> Setting {
        self.orbits.first().map_or(self.setting, |orbit| orbit.setting)
    }

    /// Frequencies and mass ratios, for readers of the file.
    pub(crate) fn values(&self) -> Vec<Array<'static>> {
        let of = |parameter: Parameter| self.orbits.iter().map(|orbit| orbit.setting.get(parameter)).collect();
        [Parameter::OmegaB, Parameter::Rho].map(|one| Array::vector(one.name(), of(one))).to_vec()
    }

    /// Reads a branch: the orbits have the bits they had when written; their Newton steps are not
    /// in the file.
    ///
    /// # Errors
    /// A file that cannot be read; [`Error::Content`], with the key and the rule, for a file with
    /// another structure or version, or with numbers outside their rules.
    pub fn load(path: &Path) -> Result<Self> {
        let file = Archive::read(path)?;
        let made = |setting: Setting, _| setting.checked().map(|()| ((), setting));
        Self::read(&file, made)?.1.verified(&file)
    }
}

impl<P: Problem> Branch<P> {
    /// The chosen orbit.
    ///
    /// # Errors
    /// A number or a value that is not on the branch.
    pub fn pick(&self, pick: Pick) -> Result<&P::Orbit> {
        let p = |orbit: &P::Orbit| self.parameter(orbit);
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
                let (least, most) = extremes(self.orbits.iter().map(p));
                let nearest = least_by(&self.orbits, |orbit| (p(orbit) - value).abs());
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
    /// Reads an orbit that `breather dark` has written, or the picked orbit of a branch file; none
    /// is picked where there is only one.
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
            (true, Some(pick)) => return Branch::load(path)?.pick(pick).cloned(),
            (true, None) => match &Branch::load(path)?.orbits[..] {
                [orbit] => return Ok(orbit.clone()),
                _ => "it is a branch: say which of its orbits, by --point or --at".to_owned(),
            },
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
        ORBIT_FORMAT.check(&read.format, read.format_version)?;
        read.orbit().map_err(|why| why.to_string())
    }

    /// The orbit with its residual measured again.
    ///
    /// An orbit that starts at rest is at rest after half a period, so the half-period equations
    /// apply to both formulations.
    pub(super) fn measured(self, shooting: &Shooting) -> Result<Self> {
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
        setting.checked()?;
        for (name, strains) in [("x", &x), ("y", &y)] {
            if strains.len() != sites {
                let value = format!("{} numbers for {sites} sites", strains.len());
                return Err(Error::parameter(name, value, "a number for every site"));
            }
        }
        Ok(Orbit { setting, z: [x, y].concat(), residual: f64::INFINITY, newton: Vec::new() })
    }
}

impl Setting {
    /// Refuses a setting outside its rules; a ring for orbits has an odd number of sites.
    pub(crate) fn checked(&self) -> Result<()> {
        self.chain()?;
        if self.sites.is_multiple_of(2) {
            return Err(Error::parameter("sites", self.sites, "an odd number: n = -N .. N"));
        }
        Ok(())
    }
}
