//! Scenes in SI units, and the dimensionless scenes that follow from them.
//!
//! | symbol | meaning |
//! |---|---|
//! | `R, rho_s, E, nu` | radius, density, Young's modulus, Poisson's ratio of a sphere |
//! | `A` | constant of a contact, `F = A delta^alpha`; by Hertz `A = 4/3 E* sqrt(R*)`, `alpha = 3/2` |
//! | `E*` | `1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2` |
//! | `R*` | `1/R* = 1/R_1 + 1/R_2`; a flat body, such as a wall, has `1/R = 0` |
//! | `L, M, A_0` | units of length, mass and contact constants |
//!
//! `L` and `M` are the radius and the mass of the first sphere, and `A_0` is the constant of two
//! such spheres; the unit of time is `(M/(A_0 L^{1/2}))^{1/2}`. Where no bead has a radius, `L` is
//! 1 mm and `M` the mass of the first bead; where Hertz gives no constant, `A_0` is the first one
//! that is given, and `(M/(A_0 L^{alpha - 1}))^{1/2}` the unit of time.
//!
//! K. L. Johnson, *Contact Mechanics*, Cambridge University Press 1985, section 4.2.

use super::{
    Quantity, SceneFile, UnitsSection,
    details::BondsSection,
    values::{Numbers, Values},
};
use crate::{
    chain::{Boundary, Chain},
    error::{Error, Iterate, NOTHING, Result, brief, refuse, require},
    number::{format_short, rounded},
    numerics::extremes,
    report::Units,
};
use std::f64::consts::PI;

/// The unit of length where no bead has a radius, in metres.
const LENGTH: f64 = 1e-3;

/// A sphere or, with an infinite radius, a flat body; what is not given or known is not-a-number.
#[derive(Clone, Copy, Debug)]
struct Body {
    radius: f64,
    density: f64,
    young: f64,
    poisson: f64,
}

impl Body {
    fn mass(&self) -> f64 {
        let mass = 4.0 / 3.0 * PI * self.radius.powi(3) * self.density;
        if self.radius.is_finite() { mass } else { f64::NAN }
    }

    /// `(1 - nu^2)/E`.
    fn compliance(&self) -> f64 {
        (1.0 - self.poisson * self.poisson) / self.young
    }

    /// The contact constant `A` of two bodies; not-a-number if both are flat.
    fn hertz(&self, other: &Self) -> f64 {
        let (modulus, radius) =
            ((self.compliance() + other.compliance()).recip(), (self.radius.recip() + other.radius.recip()).recip());
        if radius.is_finite() { 4.0 / 3.0 * modulus * radius.sqrt() } else { f64::NAN }
    }
}

impl SceneFile {
    /// The scene with dimensionless numbers, and its units, if it has `[units]`.
    ///
    /// # Errors
    /// A value outside its rule; a mass or a contact constant that neither is given nor follows
    /// from spheres.
    pub(super) fn dimensionless(&self) -> Result<Option<(Self, Units)>> {
        let Some(section) = &self.units else { return Ok(None) };
        section.check()?;
        let chain = Chain::<f64>::new(self.chain.params(), self.chain.boundary, self.chain.sites)?;
        let rule = "waves in strains are those of the paper, without units: \"ring\" with [units]";
        require(self.chain.boundary != Boundary::StrainRing, "boundary", self.chain.boundary, rule)?;
        let mut file = Self { units: None, ..self.clone() };
        let (beads, bonds) = (file.beads.get_or_insert_default(), file.bonds.get_or_insert_default());

        let mut bodies = section.bodies(chain.sites())?;
        let mut masses = bodies.iter().map(Body::mass).collect();
        if let Some(values) = &beads.mass {
            masses = values.over("beads.mass", masses)?;
        }
        for drive in &self.drives {
            let (site, wall) = drive.place(&chain)?;
            if wall {
                bodies[site] = section.wall(bodies[site]);
            }
        }
        let odd = masses.iter().position(|mass| !(mass.is_finite() && *mass > 0.0));
        let rule = "a mass is finite and positive: give it, or `radius` and `density` of [units]";
        refuse("beads.mass", odd.map(|i| at(masses[i], i)), rule)?;

        let touching = chain.touching();
        let alphas = bonds.alpha.as_ref().map(|values| values.of("bonds.alpha", touching.len())).transpose()?;
        let alpha = |k: usize| alphas.as_ref().map_or(self.chain.alpha, |alphas| alphas[k]);
        let hertz = |(k, bond): (usize, usize)| match chain.topology().ends(bond) {
            _ if bonds.table.is_some() => 1.0,
            _ if alpha(k) != 1.5 => f64::NAN,
            [Some(a), Some(b)] => bodies[a].hertz(&bodies[b]),
            [Some(a), None] | [None, Some(a)] => bodies[a].hertz(&section.wall(bodies[a])),
            [None, None] => f64::NAN,
        };
        let mut contacts: Vec<f64> = touching.clone().enumerate().map(hertz).collect();
        if let Some(values) = &bonds.contact {
            contacts = values.over("bonds.contact", contacts)?;
        }
        bonds.walls(self.chain.boundary, &mut contacts)?;
        let rule = "a contact constant is finite and at least zero: give it, or `radius`, `young` and `poisson` of \
                    [units], not of two flat bodies, for alpha = 1.5";
        constants("bonds.contact", &contacts, rule)?;

        let first = bodies.iter().position(|body| body.radius.is_finite());
        let length = first.map_or(LENGTH, |i| bodies[i].radius);
        let sphere = first.map(|i| bodies[i].hertz(&bodies[i])).filter(|constant| constant.is_finite());
        let given = || contacts.iter().position(|one| *one > 0.0).map(|k| (contacts[k], alpha(k)));
        let reference = sphere.map(|constant| (constant, 1.5)).or_else(given).unwrap_or((1.0, 1.5));
        // Of a table, the slope from its first row to the last.
        let last = bonds.table.as_ref().and_then(|table| table.force.last().zip(table.overlap.last()));
        let slope = last.map(|(force, overlap)| force / overlap).filter(|slope| *slope > 0.0 && slope.is_finite());
        let reference = slope.map_or(reference, |slope| (slope, 1.0));
        let units = Units::new(length, masses[first.unwrap_or(0)], reference);

        if let Some(load) = section.static_load.filter(|load| *load > 0.0) {
            let rule = "of contacts with `terms` or a `table` give the static overlaps: `overlap` of [bonds]";
            require(bonds.terms.is_none() && bonds.table.is_none(), "units.static_load", load, rule)?;
            let other = bonds.overlap.is_some() || self.chain.precompression != 0.0;
            bonds.overlap = Some(Values::List(pressed(load, &contacts, &alpha, other)?));
        }
        let list = |values: Vec<f64>| values.iter().any(|value| *value != 1.0).then_some(Values::List(values));
        beads.mass = list(masses.iter().map(|mass| mass / units.mass_kg).collect());
        let scaled = |(k, constant): (usize, &f64)| match bonds.table {
            Some(_) => *constant,
            None => constant * length.powf(alpha(k)) / units.force_n,
        };
        (bonds.contact, bonds.wall) = (list(contacts.iter().enumerate().map(scaled).collect()), None);
        for term in bonds.terms.iter_mut().flatten() {
            let given = term.contact.of("bonds.terms.contact", touching.len())?;
            constants("bonds.terms.contact", &given, "a contact constant is finite and at least zero")?;
            term.contact.each(&mut |x| *x *= length.powf(term.alpha) / units.force_n);
        }
        let powers = bonds.powers(&units);
        bonds.dashpot.each(&mut |x| *x *= powers);
        // Equal spheres are a chain of equal beads.
        file.beads = file.beads.filter(|beads| *beads != Default::default());
        file.bonds = file.bonds.filter(|bonds| *bonds != BondsSection::default());
        file.quantities(&mut |_, quantity, x| *x = units.from_si(quantity, *x));
        Ok(Some((file, units)))
    }

    /// An error of the dimensionless scene, with the numbers that are given or else in SI units.
    pub(crate) fn restated(&self, error: Error, units: &Units) -> Error {
        match error {
            Error::Parameter { name, value, rule } => Error::parameter(name, self.told(name, &value, units), rule),
            Error::Stalled { steps, best: Some(best) } => {
                let place = self.told("", &best.place, units);
                Error::Stalled { steps, best: Some(Box::new(Iterate { place, ..*best })) }
            }
            other => other,
        }
    }

    /// Words with the numbers of a key, or of another one that is named before them with an equals
    /// sign. Places, such as `at site 3`, and counts, such as `3 numbers for 4`, are no such
    /// numbers.
    fn told(&self, name: &'static str, words: &str, units: &Units) -> String {
        let powers = match &self.bonds {
            Some(bonds) if name == "bonds.dashpot" => bonds.powers(units),
            _ => 1.0,
        };
        let given = |of: &str, number: f64| {
            let (mut own, mut kind) = match of {
                "position" | "u" | "v" | "x" => (None, Some(Quantity::Length)),
                "velocity" | "u_dot" | "v_dot" => (None, Some(Quantity::Velocity)),
                "t" => (None, Some(Quantity::Time)),
                "load" => (None, Some(Quantity::Force)),
                _ => (None, None),
            };
            self.clone().quantities(&mut |key, quantity, x| {
                if key == of {
                    kind = kind.or(Some(quantity));
                    own = own.or((units.from_si(quantity, *x * powers) == number).then_some(*x));
                }
            });
            own.or_else(|| Some(rounded(units.to_si(kind?, number) / powers)))
        };
        let words: Vec<&str> = words.split(' ').collect();
        let (mut key, mut place) = (name.rsplit('.').next().unwrap_or(name), false);
        let told = words.iter().enumerate().map(|(i, word)| {
            let next = words.get(i + 1).copied().unwrap_or_default();
            if next == "=" {
                (key, place) = (word, false);
            }
            place |= ["(entry", "bead", "beads", "bond", "for", "site"].contains(word);
            let count = place || ["for", "numbers", "of", "times"].contains(&next);
            let number = word.trim_matches(['[', ']', ',']);
            match number.parse().ok().filter(|_| !count).and_then(|x| given(key, x)) {
                Some(given) => word.replace(number, &given.to_string()),
                None => (*word).to_owned(),
            }
        });
        told.collect::<Vec<_>>().join(" ")
    }

    /// Sizes of numbers in SI units that are hardly meant, each with the unit that is likely.
    pub(crate) fn doubts(&self) -> Vec<String> {
        let Some(UnitsSection { radius, density, young, wall_young, .. }) = &self.units else { return Vec::new() };
        let n = self.chain.sites;
        // The least and the largest; infinite if nothing is known, as of a flat body.
        let range = |values: &Option<Values>| {
            let list = values.as_ref().and_then(|values| values.of("", n).ok()).unwrap_or_default();
            if list.is_empty() { [f64::INFINITY; 2] } else { extremes(list).into() }
        };
        let mut all = Vec::new();
        let mut doubt = |name: &str, value: f64, unit: &str, bad: bool, rule: &str, [likely, factor]: [&str; 2]| {
            if bad {
                let (text, times) = (brief(&value.to_string()), format!("1{factor}").parse().unwrap_or(1.0));
                let write =
                    if text.contains('e') { brief(&rounded(value * times).to_string()) } else { text.clone() + factor };
                all.push(format!("{name} = {text} {unit}: {rule}; if it is in {likely}, write {write}"));
            }
        };
        let ([_, size], [lightest, _], [softest, stiffest]) = (range(radius), range(density), range(young));
        doubt("units.radius", size, "m", size > 1.0 && size.is_finite(), "more than 1 m", ["mm", "e-3"]);
        let likely = if lightest < 0.03 { ["g/mm^3", "e6"] } else { ["g/cm^3", "e3"] };
        doubt("units.density", lightest, "kg/m^3", lightest < 30.0, "lighter than solids", likely);
        for (name, modulus) in [("units.young", softest), ("units.wall_young", wall_young.unwrap_or(f64::INFINITY))] {
            let likely = if modulus < 1e4 { ["GPa", "e9"] } else { ["MPa", "e6"] };
            doubt(name, modulus, "Pa", modulus < 1e6, "softer than solids", likely);
        }
        // No speed of sound follows from a modulus or a density that is hardly meant.
        let meant = softest >= 1e6 && (30.0..f64::INFINITY).contains(&lightest);
        let sound = if meant { (stiffest / lightest).sqrt() } else { f64::INFINITY };
        let rule = format!(
            "above 2 % of the speed of sound in the beads, (E/density)^(1/2) = {} m/s, where contacts yield",
            format_short(sound)
        );
        let long = self.span.until.map_or(f64::INFINITY, |until| 100.0 * until);
        let mut hertz = Vec::new();
        self.clone().quantities(&mut |key, quantity, x| match quantity {
            Quantity::Velocity => doubt(key, *x, "m/s", x.abs() > 0.02 * sound, &rule, ["mm/s", "e-3"]),
            Quantity::Time if key == "tau" && x.is_finite() => {
                doubt("beads.tau", *x, "s", *x > long, "it damps by less than 1 % in the run", ["ms", "e-3"]);
            }
            Quantity::Omega if key == "omega" && *x != 0.0 && format!("{x:e}").as_bytes()[1] == b'e' => {
                let words = format!("{} Hz; if it is in Hz, write frequency = {x}", format_short(*x / (2.0 * PI)));
                hertz.push(format!("drive.omega = {x} rad/s: {words}"));
            }
            Quantity::Length if ["displacement", "amplitude"].contains(&key) => {
                doubt(key, *x, "m", x.abs() > size, "more than a radius", ["mm", "e-3"]);
            }
            Quantity::Length if ["overlap", "precompression"].contains(&key) => {
                let rule = "more than a radius; a load in N is units.static_load";
                doubt(key, *x, "m", *x > size, rule, ["mm", "e-3"]);
            }
            _ => {}
        });
        all.extend(hertz);
        // One sentence for all beads.
        all.dedup_by(|a, b| a.split(" = ").next() == b.split(" = ").next());
        all
    }
}

impl BondsSection {
    /// The units of overlap and rate, by which constants of dashpots are multiplied as well.
    fn powers(&self, units: &Units) -> f64 {
        units.powers(self.beta.unwrap_or(0.0), self.rate_power.unwrap_or(1.0))
    }
}

/// Refuses contact constants that are not known or break the rule.
fn constants(name: &'static str, given: &[f64], rule: &'static str) -> Result<()> {
    let odd = given.iter().position(|constant| !(constant.is_finite() && *constant >= 0.0));
    refuse(name, odd.map(|k| at(given[k], k)), rule)
}

/// The static overlaps by a load, of contacts with these constants and exponents; `other`: whether
/// they are given.
fn pressed(load: f64, contacts: &[f64], alpha: &dyn Fn(usize) -> f64, other: bool) -> Result<Vec<f64>> {
    let rule = "a static load gives the static overlaps: leave `overlap` and `precompression` out";
    require(!other, "units.static_load", load, rule)?;
    let open = contacts.iter().position(|constant| *constant == 0.0);
    let rule = "no load where beads have no contact: give `overlap` of [bonds]";
    refuse("units.static_load", open.map(|k| at(load, k)), rule)?;
    Ok(contacts.iter().enumerate().map(|(k, a)| (load / a).powf(alpha(k).recip())).collect())
}

/// A value with the place in its list.
fn at(value: f64, i: usize) -> String {
    if value.is_nan() { format!("{NOTHING} (entry {i})") } else { format!("{value} (entry {i})") }
}

impl UnitsSection {
    fn check(&self) -> Result<()> {
        if self.system.as_deref() != Some("SI") {
            let rule = "all numbers of a scene with [units] are in SI units; before version 0.1 only those of [units] and \
                        [[drive]] were: convert the others (radius, mass and contact of the first sphere are 1 there), \
                        and write system = \"SI\"";
            return Err(Error::parameter("units.system", self.system.as_deref().unwrap_or(NOTHING), rule));
        }
        self.wall_young.map(|young| crate::error::positive("units.wall_young", young)).transpose()?;
        refuse("units.wall_poisson", self.wall_poisson.filter(|&poisson| !ratio(poisson)), RATIO)?;
        let odd = self.static_load.filter(|load| !(load.is_finite() && *load >= 0.0));
        refuse("units.static_load", odd, "a load is finite and at least zero")
    }

    fn bodies(&self, sites: usize) -> Result<Vec<Body>> {
        let list = |name, values: &Option<Values>, good: fn(f64) -> bool, rule| {
            let Some(values) = values else { return Ok(vec![f64::NAN; sites]) };
            let values = values.of(name, sites)?;
            refuse(name, values.iter().find(|&&value| !good(value)), rule).map(|()| values)
        };
        let (positive, rule): (fn(f64) -> bool, _) = (|x| x.is_finite() && x > 0.0, "finite and positive");
        let radius = list("units.radius", &self.radius, |x| x > 0.0, "positive; inf for a flat body")?;
        let density = list("units.density", &self.density, positive, rule)?;
        let young = list("units.young", &self.young, positive, rule)?;
        let poisson = list("units.poisson", &self.poisson, ratio, RATIO)?;
        let body = |i| Body { radius: radius[i], density: density[i], young: young[i], poisson: poisson[i] };
        Ok((0..sites).map(body).collect())
    }

    /// The wall beside a bead.
    fn wall(&self, beside: Body) -> Body {
        let (young, poisson) = (self.wall_young.unwrap_or(beside.young), self.wall_poisson.unwrap_or(beside.poisson));
        Body { radius: f64::INFINITY, young, poisson, ..beside }
    }
}

fn ratio(x: f64) -> bool {
    x > -1.0 && x <= 0.5
}

const RATIO: &str = "Poisson's ratio is above -1 and at most 1/2";
