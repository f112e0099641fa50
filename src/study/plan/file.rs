//! The file of a plan in TOML, and the points that it gives.

use crate::{
    error::{Error, Result, listed, nearest, one_line},
    memory::lacking,
    output::read,
    scene::{Scene, builtin, held, read_table},
};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json, json};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};
use toml::{Table, Value, de::DeTable};

/// `(name, TOML)` of each plan that comes with the program.
const BUILTIN: &[(&str, &str)] = builtin! { "dimer" "impurity" "taper" "disorder" };
/// Longest plan in bytes.
const MOST_BYTES: u64 = 1 << 26;
/// A plan has fewer points.
const MOST_POINTS: usize = 1 << 32;
/// Most axes of a plan, those that move along with others included.
const MOST_AXES: usize = 1000;
/// Most values of all axes together: these are in memory, about 100 bytes each.
const MOST_VALUES: usize = 1 << 22;
/// Quantities that are kept if the plan names none.
const KEPT: [&str; 2] = ["energy_error", "force_evaluations"];
/// What a run reports as a number, or as a table or an array of numbers.
const REPORTED: &str = "t period u v pu pv x y vx vy energy energy_error energies dissipated driven e_x_final e_y_final \
    contacts bonds speed largest_force largest_speed recorded force_evaluations steps rejected";

/// The quantity that is computed from two bonds.
const SPEED: &str = "speed";

/// A sweep over a scene, as a file says it.
#[derive(Clone, Debug)]
pub struct Plan {
    path: PathBuf,
    /// Name of the plan; that of its file if it says none.
    pub name: String,
    /// The scene as TOML, and how messages call it.
    scene: (String, String),
    set: Vec<String>,
    /// The quantities that are kept.
    pub keep: Vec<Reported>,
    /// The axes, the first one slowest.
    pub axes: Vec<Axis>,
    /// Index in `keep` of the quantity of the picture.
    pub picture: usize,
    /// What pictures say in place of keys and quantities.
    words: BTreeMap<String, String>,
    /// In words: sizes in the scenes at the ends of the axes that are hardly meant, and keys that
    /// change nothing in any of these scenes.
    pub doubts: Vec<String>,
}

/// A number or an array of numbers of the report of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Reported {
    /// Its name, such as `contacts.impulse` or `u[3]`.
    pub name: String,
    /// The name as a pointer into the JSON of a run.
    pointer: String,
}

/// Keys of the scene that change together.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The keys.
    pub keys: Vec<String>,
    /// A row for each place on the axis, with a value for each key.
    pub values: Vec<Vec<Value>>,
}

/// A point of the grid: the values of all keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Point(pub Vec<(String, Value)>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table of keys")]
struct PlanFile {
    name: Option<String>,
    scene: Value,
    #[serde(default)]
    set: Vec<String>,
    keep: Option<Vec<String>>,
    picture: Option<String>,
    #[serde(default)]
    words: BTreeMap<String, String>,
    #[serde(default, rename = "axis")]
    axes: Vec<AxisFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table of keys")]
struct AxisFile {
    key: Option<String>,
    values: Option<Vec<Value>>,
    from: Option<Value>,
    to: Option<Value>,
    count: Option<usize>,
    #[serde(default)]
    scale: Scale,
    seeds: Option<usize>,
    #[serde(default)]
    zip: bool,
}

#[derive(Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Scale {
    #[default]
    Linear,
    Log,
}

impl Plan {
    /// A template with every key and an explanation of each.
    pub const TEMPLATE: &str = include_str!("template.toml");

    /// Names and titles of the plans that come with the program.
    pub fn list() -> impl Iterator<Item = (&'static str, String)> {
        let title = |text: &str| text.parse::<Table>().ok()?.get("name")?.as_str().map(str::to_owned);
        BUILTIN.iter().map(move |(name, text)| (*name, title(text).unwrap_or_default()))
    }

    /// The TOML of a plan that comes with the program, or of a file.
    ///
    /// # Errors
    /// An unknown name (with the nearest one), or a file that cannot be read.
    pub fn source(path: &Path) -> Result<String> {
        if let Some((_, text)) = BUILTIN.iter().find(|(name, _)| path == Path::new(name)) {
            return Ok((*text).to_owned());
        }
        if path.extension().is_none() && path.components().count() == 1 && !path.exists() {
            return Err(Error::unknown("plan", &path.to_string_lossy(), BUILTIN.iter().map(|(name, _)| *name)));
        }
        let text = String::from_utf8(read(path, MOST_BYTES)?);
        text.map_err(|why| refused(path, "text", format!("not valid UTF-8: {why}")))
    }

    /// A plan that comes with the program, by name, or the plan in a file.
    ///
    /// # Errors
    /// As [`source`](Self::source) and [`parse`](Self::parse).
    pub fn load(path: &Path) -> Result<Self> {
        Self::parse(&Self::source(path)?, path)
    }

    /// The plan in `text`; messages call it `path`, and files of scenes are looked for beside it.
    ///
    /// # Errors
    /// The place and the rule that the plan breaks; scenes at the ends of the axes that cannot be
    /// read or built.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let line = |at: usize| format!("line {}", 1 + text.bytes().take(at).filter(|&byte| byte == b'\n').count());
        let told = |(at, rule)| refused(path, &line(at), rule);
        let broken = |error: toml::de::Error| (error.span().map_or(0, |span| span.start), error.message().to_owned());
        let table = DeTable::parse(text).map_err(|error| told(broken(error)))?;
        held(table.get_ref()).map_err(told)?;
        let file: PlanFile = read_table(&table).map_err(|(rule, span)| told((span.start, rule)))?;
        let keep = file.keep.unwrap_or_else(|| KEPT.map(str::to_owned).into());
        let keep = keep.iter().map(|name| Reported::named(name, path)).collect::<Result<Vec<_>>>()?;
        let twice = keep.iter().enumerate().find(|(k, kept)| keep[..*k].contains(kept));
        let wrong = keep.is_empty().then(|| "name at least one quantity".to_owned());
        let wrong = wrong.or(twice.map(|(_, twice)| format!("`{}` is named twice", twice.name)));
        wrong.map_or(Ok(()), |rule| Err(refused(path, "`keep`", rule)))?;
        let of = |name: &String| keep.iter().position(|kept| kept.name == *name);
        let unkept = |name: &String| refused(path, "`picture`", format!("`{}` is not kept", one_line(name)));
        let picture = file.picture.as_ref().map_or(Ok(0), |name| of(name).ok_or_else(|| unkept(name)))?;
        let stem = path.file_stem().map_or("sweep".into(), |stem| one_line(&stem.to_string_lossy()));
        let mut plan = Self {
            path: path.to_owned(),
            name: file.name.unwrap_or(stem),
            scene: scene_source(&file.scene, path)?,
            set: file.set,
            keep,
            axes: axes(file.axes, path)?,
            picture,
            words: file.words,
            doubts: Vec::new(),
        };
        let known = |name: &&String| plan.keys().chain(plan.keep.iter().map(|kept| &kept.name)).any(|one| one == *name);
        let short = |word: &str| !word.trim().is_empty() && word.chars().count() <= 200;
        let wrong = |(name, word): (&String, &String)| match (known(&name), short(word)) {
            (true, true) => None,
            (false, _) => Some(format!("`{}` is no key of an axis and is not kept", one_line(name))),
            (true, false) => Some(format!("`{}`: from 1 to 200 letters", one_line(name))),
        };
        if let Some(rule) = plan.words.iter().find_map(wrong) {
            return Err(refused(path, "`words`", rule));
        }
        plan.check()?;
        Ok(plan)
    }

    /// Refuses more points than the memory has room for, scenes at the ends of the axes that cannot
    /// be built, quantities that runs do not report, and a method that can run no point.
    fn check(&mut self) -> Result<()> {
        // Hash, place and entry of the store, and a number of each column.
        let bytes = self.points() as u64 * 8 * (7 + self.keys().count() + self.keep.len()) as u64;
        if let Some(words) = lacking(bytes) {
            return Err(refused(&self.path, "`axis`", format!("{} points need {words}", self.points())));
        }
        let (mut stride, mut corners) = (self.points(), vec![self.point(0)]);
        for axis in &self.axes {
            stride /= axis.values.len();
            corners.push(self.point(stride * (axis.values.len() - 1)));
        }
        let first = self.scene(&corners[0])?;
        self.on_the_boundary_of(&first)?;
        // What a run reports is known before its first step; sites may differ between corners.
        let (mut lost, mut idle) = (vec![Some(String::new()); self.keep.len()], first.idle());
        for corner in &corners {
            let scene = self.scene(corner)?;
            let sizes = scene.file().doubts().into_iter().filter(|size| !self.doubts.contains(size));
            self.doubts.extend(sizes.collect::<Vec<_>>());
            // A key that acts at one corner acts in this plan.
            if !idle.is_empty() {
                let here = scene.idle();
                idle.retain(|key| here.contains(key));
            }
            let report = super::before_its_first_step(&scene);
            let why = self.keep.iter().map(|kept| kept.of(&report).err().map(|why| why.to_string()));
            lost = lost.into_iter().zip(why).map(|(before, here)| before.and(here)).collect();
        }
        self.doubts.append(&mut idle);
        if let Some(why) = lost.into_iter().flatten().next() {
            return Err(refused(&self.path, "`keep`", why));
        }
        let refusal = |k: usize| {
            let (scene, run) = super::run_of(self, &self.point(k)).ok()?;
            Some(run.choice().ok()?.0.runs(scene.chain()).err()?.to_string())
        };
        match refusal(0) {
            Some(why) if (1..self.points()).all(|k| refusal(k).as_ref() == Some(&why)) => {
                Err(refused(&self.path, "all points", why))
            }
            _ => Ok(()),
        }
    }

    /// Refuses strains of a chain of displacements, and the other way round.
    fn on_the_boundary_of(&self, scene: &Scene) -> Result<()> {
        let ring = scene.chain().boundary() == crate::chain::Boundary::StrainRing;
        let (others, words) = match ring {
            true => (["u", "v", "pu", "pv"], "strains are x, y, vx and vy"),
            false => (["x", "y", "vx", "vy"], "states are u, v, pu and pv"),
        };
        let wrong = self.keep.iter().find(|kept| others.contains(&kept.root()));
        let rule = wrong.map(|kept| format!("`{}`: {words} on this boundary", kept.name));
        rule.map_or(Ok(()), |rule| Err(refused(&self.path, "`keep`", rule)))
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// The point with this number, from 0; the last axis goes fastest.
    pub fn point(&self, mut number: usize) -> Point {
        let mut places = Vec::with_capacity(self.axes.len());
        for axis in self.axes.iter().rev() {
            places.push(number % axis.values.len());
            number /= axis.values.len();
        }
        let values = self.axes.iter().zip(places.into_iter().rev());
        Point(values.flat_map(|(axis, k)| axis.keys.iter().cloned().zip(axis.values[k].iter().cloned())).collect())
    }

    /// The scene of a point.
    ///
    /// # Errors
    /// The key and the rule that it breaks.
    pub fn scene(&self, point: &Point) -> Result<Scene> {
        let at = point.0.iter().map(|(key, value)| format!("{key}={value}"));
        let changes: Vec<String> = self.set.iter().cloned().chain(at).collect();
        Scene::parse_with(&self.scene.0, &self.scene.1, &changes)
    }

    /// All that results depend on besides the point.
    pub(super) fn settings(&self) -> Json {
        let scene: Option<Table> = self.scene.0.parse().ok();
        let keep: Vec<&str> = self.keep.iter().map(|kept| kept.name.as_str()).collect();
        json!({"scene": scene.map(|scene| in_json(&Value::Table(scene))), "set": self.set, "keep": keep})
    }

    /// What pictures call a key or a quantity.
    pub(super) fn word<'a>(&'a self, name: &'a str) -> &'a str {
        self.words.get(name).map_or(name, String::as_str)
    }

    /// The keys of all axes.
    pub fn keys(&self) -> impl Iterator<Item = &String> {
        self.axes.iter().flat_map(|axis| &axis.keys)
    }

    /// Whether contacts are logged.
    pub(super) fn contacts(&self) -> bool {
        let logged = ["contacts", "bonds", "largest_force", SPEED];
        self.keep.iter().any(|kept| logged.contains(&kept.root()))
    }
}

impl Reported {
    fn named(name: &str, path: &Path) -> Result<Self> {
        let pointer = format!("/{}", name.replace(['.', '['], "/").replace(']', ""));
        let quantity = Self { name: name.to_owned(), pointer };
        if REPORTED.split(' ').any(|known| known == quantity.root()) {
            return Ok(quantity);
        }
        let hint = match nearest(quantity.root(), REPORTED.split(' ')) {
            Some(known) => format!("did you mean `{known}`?"),
            None => format!("a run reports {}", listed(REPORTED.split(' '))),
        };
        Err(refused(path, "`keep`", format!("unknown quantity `{}`; {hint}", one_line(name))))
    }

    fn root(&self) -> &str {
        self.pointer[1..].split('/').next().unwrap_or_default()
    }

    /// The quantity in the report of a run.
    ///
    /// # Errors
    /// A report that does not have it.
    pub(super) fn of(&self, report: &Json) -> Result<Json> {
        if self.root() == SPEED {
            return self.speed(report).map(|speed| json!(speed));
        }
        let why = match report.pointer(&self.pointer) {
            Some(Json::Object(table)) if !table.is_empty() => {
                let members: Vec<&str> = table.keys().map(String::as_str).collect();
                format!("name one of its numbers: {}", members.join(", "))
            }
            None | Some(Json::Object(_)) => format!("the report of this run has no `{}`", self.name),
            Some(value) => return Ok(value.clone()),
        };
        Err(Error::Point { point: self.name.clone(), why })
    }

    /// The speed of the largest force from a bond to another, `speed[20..30]`; none where it has
    /// not arrived.
    fn speed(&self, report: &Json) -> Result<Option<f64>> {
        // The name as a pointer: /speed/20//30.
        let bonds = self.pointer.split_once("d/").and_then(|(_, range)| range.split_once("//"));
        let bonds = bonds.filter(|(from, to)| from != to);
        let number = |bond: &str, name: &str| report.pointer(&format!("/bonds/{name}/{bond}")).map(Json::as_f64);
        let of = |name: &str| bonds.and_then(|(from, to)| Some((number(from, name)?, number(to, name)?)));
        let Some(((x0, x1), (t0, t1))) = of("position").zip(of("t_peak")) else {
            let why = "a speed is that from a bond of the chain to another, such as speed[20..30]".to_owned();
            return Err(Error::Point { point: self.name.clone(), why });
        };
        Ok((|| Some((x1? - x0?) / (t1? - t0?)))().filter(|speed| speed.is_finite()))
    }
}

impl Serialize for Point {
    fn serialize<S: serde::Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        let values: Map<String, Json> = self.0.iter().map(|(key, value)| (key.clone(), in_json(value))).collect();
        values.serialize(to)
    }
}

/// A value of TOML as JSON; numbers that are not finite, which JSON lacks, as text.
pub(super) fn in_json(value: &Value) -> Json {
    match value {
        Value::Float(number) if !number.is_finite() => json!(number.to_string()),
        Value::Array(values) => values.iter().map(in_json).collect(),
        Value::Table(table) => Json::Object(table.iter().map(|(key, value)| (key.clone(), in_json(value))).collect()),
        value => json!(value),
    }
}

/// The TOML of the scene, and how messages call it.
fn scene_source(scene: &Value, path: &Path) -> Result<(String, String)> {
    match scene {
        Value::String(name) => {
            let beside = path.parent().map(|folder| folder.join(name)).filter(|file| file.is_file());
            let name = beside.map_or_else(|| name.clone(), |file| file.display().to_string());
            Ok((Scene::source(&name)?, name))
        }
        Value::Table(table) => {
            let text = toml::to_string(table).map_err(|why| refused(path, "`scene`", why.to_string()))?;
            Ok((text, format!("{} [scene]", path.display())))
        }
        _ => Err(refused(path, "`scene`", "the name of a scene, a file, or a table with all keys of one")),
    }
}

/// The axes, with those that move along with the one above them joined to it.
fn axes(files: Vec<AxisFile>, path: &Path) -> Result<Vec<Axis>> {
    if files.is_empty() {
        return Err(refused(path, "`axis`", "a plan has at least one axis: [[axis]] with key and values"));
    }
    if files.len() > MOST_AXES {
        return Err(refused(path, "`axis`", format!("{} axes: a plan has at most {MOST_AXES}", files.len())));
    }
    let mut axes: Vec<Axis> = Vec::new();
    // All that a plan asks for is counted before any of it is made.
    let (mut points, mut all) = (1, 0usize);
    for (k, file) in files.into_iter().enumerate() {
        let at = |what: &str, rule: String| refused(path, &format!("axis {}, `{what}`", k + 1), rule);
        let key = match (&file.key, file.seeds) {
            (Some(key), _) => key.clone(),
            (None, Some(_)) => "initial.seed".to_owned(),
            (None, None) => return Err(at("key", "name a key of the scene, as in chain.rho".to_owned())),
        };
        if axes.iter().any(|axis| axis.keys.contains(&key)) {
            return Err(at("key", format!("{key} has an axis above")));
        }
        let (zip, (what, places)) = (file.zip, file.places());
        all = all.saturating_add(places);
        if all > MOST_VALUES {
            return Err(at(what, format!("{places}: the axes of a plan have at most 2^22 values together")));
        }
        points *= if zip { 1 } else { places };
        if points >= MOST_POINTS {
            return Err(at(what, format!("{places}: a plan has fewer than 2^32 points")));
        }
        let values = file.values().map_err(|(what, rule)| at(what, rule))?;
        match (zip, axes.last_mut()) {
            (false, _) => {
                axes.push(Axis { keys: vec![key], values: values.into_iter().map(|one| vec![one]).collect() })
            }
            (true, None) => return Err(at("zip", "the first axis has none above to move along with".to_owned())),
            (true, Some(above)) if above.values.len() != values.len() => {
                let rule = format!("{} values here and {} on the axis above", values.len(), above.values.len());
                return Err(at("zip", rule));
            }
            (true, Some(above)) => {
                above.keys.push(key);
                above.values.iter_mut().zip(values).for_each(|(row, value)| row.push(value));
            }
        }
    }
    Ok(axes)
}

/// The key that breaks a rule, and the rule.
type Refusal = (&'static str, String);

impl AxisFile {
    /// The key that says how many values the axis has, and that number.
    fn places(&self) -> (&'static str, usize) {
        match (&self.values, self.count, self.seeds) {
            (Some(values), ..) => ("values", values.len()),
            (_, Some(count), _) => ("count", count),
            (.., seeds) => ("seeds", seeds.unwrap_or(0)),
        }
    }

    fn values(self) -> std::result::Result<Vec<Value>, Refusal> {
        let Self { values, from, to, count, seeds, scale, .. } = self;
        let values = match (values, from, to, count, seeds) {
            (Some(values), None, None, None, None) => values,
            (None, Some(from), Some(to), Some(count), None) => range(&from, &to, count, scale)?,
            (None, from, None, None, Some(seeds)) => {
                let first = from.map_or(Some(1), |from| from.as_integer());
                let first = first.ok_or_else(|| ("from", "the first seed is a whole number".to_owned()))?;
                let end = first.checked_add_unsigned(seeds as u64);
                let end = end.ok_or_else(|| ("from", format!("{first}: the last seed is less than 2^63")))?;
                (first..end).map(Value::Integer).collect()
            }
            _ => return Err(("values", "give `values`, or `from`, `to` and `count`, or `seeds`".to_owned())),
        };
        if values.is_empty() {
            return Err(("values", "an axis has at least one value".to_owned()));
        }
        let mut texts: Vec<String> = values.iter().map(Value::to_string).collect();
        texts.sort_unstable();
        match texts.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(("values", format!("{} is there twice", pair[0]))),
            None => Ok(values),
        }
    }
}

/// `count` values from `from` to `to`, both included; whole numbers if both ends and the step are.
fn range(from: &Value, to: &Value, count: usize, scale: Scale) -> std::result::Result<Vec<Value>, Refusal> {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    let end = |name, value| number(value).filter(|end| end.is_finite()).ok_or((name, "a finite number".to_owned()));
    let (first, last) = (end("from", from)?, end("to", to)?);
    if count < 2 {
        return Err(("count", "at least 2".to_owned()));
    }
    if scale == Scale::Log && !(first > 0.0 && last > 0.0) {
        return Err(("scale", "both ends of a logarithmic axis are positive".to_owned()));
    }
    let far = match scale {
        Scale::Linear => last - first,
        Scale::Log => (last / first).ln(),
    };
    if !far.is_finite() {
        return Err(("to", format!("{last:e}: too far from {first:e} for a double")));
    }
    let steps = count as i64 - 1;
    if let (&Value::Integer(from), &Value::Integer(to), Scale::Linear) = (from, to, scale)
        && let Some(far) = to.checked_sub(from)
        && far % steps == 0
    {
        return Ok((0..=steps).map(|k| Value::Integer(from + far / steps * k)).collect());
    }
    let at = |k: i64| {
        let share = k as f64 / steps as f64;
        match scale {
            _ if k == 0 => first,
            _ if k == steps => last,
            Scale::Linear => first + far * share,
            Scale::Log => (first.ln() + far * share).exp(),
        }
    };
    Ok((0..=steps).map(|k| Value::Float(at(k))).collect())
}

fn refused(path: &Path, place: &str, rule: impl Into<String>) -> Error {
    Error::Content { path: path.to_owned(), place: place.to_owned(), rule: rule.into() }
}
