//! Orbits as files: what the commands write as JSON, read back.

use super::{
    setting::Setting,
    shooting::{Orbit, Shooting},
};
use crate::{
    chain::Params,
    error::{Error, Result},
};
use serde::Deserialize;
use std::path::Path;

/// The keys of such a file that determine the orbit.
#[derive(Deserialize)]
struct OrbitFile {
    alpha: f64,
    kappa: f64,
    rho: f64,
    sites: usize,
    omega_b: f64,
    turns: u32,
    c_x: f64,
    x: Vec<f64>,
    y: Vec<f64>,
}

/// A residual above this is no orbit; rounded files have less.
const ORBIT: f64 = 1e-8;

impl Orbit {
    /// The orbit in a file that `dark` has written, after checks: numbers within their rules, and a residual that is an orbit's.
    ///
    /// # Errors
    /// A file that cannot be read, lacks a key or has a wrong one; numbers outside their rules; strains that are no orbit.
    pub fn load(path: &Path, shooting: &Shooting) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|source| Error::File { path: path.to_owned(), source })?;
        let file: OrbitFile = serde_json::from_str(&text)
            .map_err(|error| Error::File { path: path.to_owned(), source: std::io::Error::other(error) })?;
        let OrbitFile { alpha, kappa, rho, sites, omega_b, turns, c_x, x, y } = file;
        let setting = Setting { params: Params { alpha, kappa, rho }, sites, omega_b, c_x, turns };
        setting.chain()?;
        for (name, strains) in [("x", &x), ("y", &y)] {
            if strains.len() != sites {
                return Err(Error::parameter(name, format!("{} numbers", strains.len()), "a number for every site"));
            }
        }
        let z = [x, y].concat();
        let size = crate::chain::max_norm(z.iter().copied());
        let residual = shooting.equations(&setting, &z, false)?.residual.amax() / size;
        if residual <= ORBIT {
            return Ok(Self { setting, z, residual, newton: Vec::new() });
        }
        let rule =
            "strains that come back after a period have a residual of at most 1e-8: the file is not that of an orbit";
        Err(Error::parameter("residual", residual, rule))
    }
}
