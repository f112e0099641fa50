//! Files of orbits and branches, read back to the bit.
//!
//! A branch is an NPZ file: `settings.json` with the numbers that hold for the whole branch, and
//! arrays with a row for each orbit. The arrays `parameter`, `residual` and those of the unknowns
//! are read back; other arrays, such as `multipliers_re`, are for readers of the file.

use super::{
    arclength::{End, Solution},
    branch::{BifurcationKind, Branch, Problem},
    continuation::Continuation,
    setting::{Parameter, Setting},
    shooting::Orbit,
};
use crate::{
    error::{Error, Result, require},
    numerics::{extremes, least_by},
    output::{Archive, Array, FileFormat, PROGRAM, SETTINGS, npz_with, to_json},
};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::path::Path;

/// The settings of a branch.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "the settings of a branch")]
struct Settings<P, S> {
    format: String,
    version: u64,
    program: String,
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

/// Choice of an orbit on a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pick {
    /// By number: from 0 on, or from the last one back, -1, if negative.
    Point(i64),
    /// The orbit with the parameter nearest to this value, within the range of the branch.
    At(f64),
}

impl<P: Problem> Branch<P> {
    /// The settings in the file, of a branch whose setting has this `source`.
    fn settings_of<S: Serialize>(&self, source: S) -> impl Serialize {
        let FileFormat(format, version) = P::FORMAT;
        Settings {
            format: format.to_owned(),
            version,
            program: PROGRAM.to_owned(),
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
    pub fn npz_of(&self, source: impl Serialize, more: Vec<Array<'_>>) -> Result<Vec<u8>> {
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
    pub fn read<S: DeserializeOwned, A>(
        file: &Archive,
        made: impl Fn(S, Option<BifurcationKind>) -> Result<(A, P::Setting)>,
    ) -> Result<(A, Self)> {
        let refused = |why: &dyn std::fmt::Display| file.refused(SETTINGS, why.to_string());
        let settings: Settings<P, S> = P::FORMAT.read(file)?;
        let Settings { setting: source, continuation, weak, back, birth, points, ds, end, .. } = settings;
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
        let branch = Self { back, birth, weak, orbits, ds, end, ..branch };
        branch.check().map_err(|why| refused(&why))?;
        Ok((about, branch))
    }

    /// Refuses a branch from a file if its numbers are not those of orbits.
    pub fn verified(self, file: &Archive) -> Result<Self> {
        for (k, orbit) in self.orbits.iter().enumerate() {
            let verified = self.continuation.verify(&self.setting, orbit);
            verified.map_err(|why| file.refused(P::arrays(&self.setting)[0].0, format!("point {k}: {why}")))?;
        }
        Ok(self)
    }
}

impl Branch<Continuation> {
    /// The settings in the file.
    pub fn settings(&self) -> impl Serialize {
        self.settings_of(self.source())
    }

    /// The setting of the first orbit.
    pub fn source(&self) -> Setting {
        self.orbits.first().map_or(self.setting, |orbit| orbit.setting)
    }

    /// Frequencies and mass ratios, for readers of the file.
    pub fn values(&self) -> Vec<Array<'static>> {
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
    /// Reads the picked orbit of a branch file; none is picked where there is only one.
    ///
    /// # Errors
    /// As `Branch::load`; several orbits without a pick, or a pick that is not on the branch.
    pub fn load(path: &Path, pick: Option<Pick>) -> Result<Self> {
        let branch = Branch::load(path)?;
        match (pick, &branch.orbits[..]) {
            (Some(pick), _) => branch.pick(pick).cloned(),
            (None, [orbit]) => Ok(orbit.clone()),
            (None, _) => {
                let rule = "it is a branch: say which of its orbits, by --point or --at".to_owned();
                Err(Error::Content { path: path.to_owned(), place: "orbit".to_owned(), rule })
            }
        }
    }
}

impl Setting {
    /// Refuses a setting outside its rules; a ring for orbits has an odd number of sites.
    pub fn checked(&self) -> Result<()> {
        self.chain()?;
        require(!self.sites.is_multiple_of(2), "sites", self.sites, "an odd number: n = -N .. N")?;
        Ok(())
    }
}
