//! Studies. Each has a folder with its options, its work, its rows and its pictures.
//!
//! A [`Study`] is a set of options, read by the command line or set by a program. Its result is a
//! [`Report`], which has the text that is printed, the files and the pictures. The command line
//! runs all studies in one way.

pub(crate) mod breathers;
pub(crate) mod integrators;
mod keeper;
pub(crate) mod laboratory;
pub(crate) mod options;
pub(crate) mod orbits;
mod plan;
pub(crate) mod run;
mod si;
pub(crate) mod waves;

pub use breathers::*;
pub use integrators::*;
pub use laboratory::*;
pub use options::{Adaptive, ChainParams};
pub use orbits::*;
pub use plan::{Axis as PlanAxis, NumberColumn, Plan, PlanFile, PlanStudy, Point as PlanPoint, Reported, planned};
pub use run::*;
pub use si::ResultUnits;
pub use waves::*;

pub use crate::sweep::Progress;
use crate::{
    chain::Params, dps::Center, error::Result, number::format_parameter, report::Report, run::Method, scene::Scene,
    sweep::Engine,
};
pub(crate) use crate::{number::format_short, numerics::fit_line};
pub(crate) use options::options;
use serde_json::{Value, json};
use std::path::PathBuf;

/// The name of a file and what is in it.
pub type File = (String, Vec<u8>);

/// The name of the PNG file of a picture, and the picture.
#[cfg(feature = "plot")]
pub type Drawing = (String, crate::figures::Picture);

/// The computation of a study whose options were checked. It gets the engine for its grid, which
/// knows the folder for the results, if there is one.
pub type Work<'a, T = Report> = Box<dyn FnOnce(&Engine, Progress<'_>) -> Result<T> + 'a>;

/// The progress of a part of the work, from one share of it to another.
fn part<'a>(progress: Progress<'a>, from: f64, to: f64) -> impl Fn(f64, &str) + Sync + 'a {
    move |share, what| progress(from + (to - from) * share, what)
}

/// A study by its options.
pub trait Study {
    /// The files it writes besides its store and those of its [`outline`](Self::outline), in words
    /// for the help.
    const FILES: &'static str = "";
    /// The name of the store of its grid, which keeps every point; empty without one.
    const STORE: &'static str = "";
    /// Whether its report says what is missing after the process was asked to end. That of another
    /// study is dropped then.
    const INTERRUPTIBLE: bool = !Self::STORE.is_empty();
    /// Whether it sweeps a grid, so that it takes a shard.
    const SWEEPS: bool = !Self::STORE.is_empty();

    /// Names of the files that only some runs of it write. Those of an earlier run are removed from
    /// the folder. All other files are written anew by every run.
    fn optional_files() -> Vec<String> {
        Vec::new()
    }

    /// Its report without rows, which tells the help the names of files and columns.
    fn outline() -> Option<Report> {
        None
    }

    /// Checks the options as far as possible before a folder is made, and returns the work.
    ///
    /// # Errors
    /// Options outside their rules; a scene or a file that cannot be read.
    fn begin(&self) -> Result<Work<'_>>;

    /// The folder for its files if the command names none.
    fn default_folder(&self) -> Option<PathBuf> {
        None
    }
}

/// A scene by its name, with changes, for studies of uniform chains.
fn scene(name: &str, changes: &Changes) -> Result<Scene> {
    let scene = Scene::load_with(name, &changes.set)?;
    scene.chain().uniform("this study")?;
    Ok(scene)
}

/// What the tolerance of collocation aims at, for the help of options.
#[cfg(feature = "cli")]
const OF_WINDOWS: &str = "\
Tolerance.

The run aims at errors of all windows whose sum is at most T, relative to the size of the state; 4.5 T is \
the most that was measured. Where small changes grow, the error at the end is larger by the same factor.";
/// The same of the flow of an exact wave.
#[cfg(feature = "cli")]
const OF_WAVE: &str = "Tolerance.\n\nThe flow over a relative period aims at errors whose sum is at most T.";

/// The help of the tolerance of a run, with what else it may mean.
#[cfg(feature = "cli")]
pub(crate) fn tolerance_help(more: &str) -> String {
    format!("{OF_WINDOWS} {more}This is for collocation; dop853 aims at an error of T a step.")
}

/// The integrators that are named; all for `all`; those of `unnamed` if none is.
fn methods(names: &[String], unnamed: fn() -> Vec<Method>) -> Result<Vec<Method>> {
    match names {
        [] => Ok(unnamed()),
        [all] if all.trim() == "all" => Ok(Method::all()),
        names => names.iter().map(|name| Method::named(name.trim())).collect(),
    }
}

options! {
    /// Changes to a scene.
    pub struct Changes {
        /// Change a key of the scene, as in chain.rho=3; may be repeated.
        ///
        /// KEY is a key of the scene's TOML with its table (`hertzchain scenes template` has all of
        /// them), or an entry of a list, from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a
        /// name needs no quotation marks, as in chain.boundary=ring.
        set: Vec<String> = vec![], "KEY=VALUE", [value_delimiter = None::<char>];
    }
}

/// All of a scene as it runs, with the seed of what it draws, as JSON; an infinite mass ratio,
/// which JSON has no number for, as `"inf"`.
pub fn scene_json(scene: &Scene) -> Value {
    let mut value = json!(scene.file());
    if scene.chain().params().rho.is_infinite() {
        value["chain"]["rho"] = json!("inf");
    }
    if let Some(rho) = value.pointer_mut("/beads/rho") {
        infinite(rho);
    }
    value
}

/// Puts `"inf"` where JSON has no number: a scene has no other number that is not finite.
fn infinite(value: &mut Value) {
    match value {
        Value::Null => *value = json!("inf"),
        Value::Array(list) => list.iter_mut().for_each(infinite),
        Value::Object(table) => table.values_mut().for_each(infinite),
        _ => {}
    }
}

/// The end of a caption: the scene with its parameters.
fn scene_caption(scene: &Scene, how: &str) -> String {
    let params = scene.chain().params();
    let params = Params { kappa: scene.in_file(crate::scene::Quantity::Stiffness, params.kappa), ..params };
    let unit = scene.units().filter(|_| params.kappa != 0.0).map_or("", |_| " (κ in N/m)");
    let details = scene.details_in_words().map(|words| format!(" Beads differ: {words}.")).unwrap_or_default();
    format!("Scene {}. N = {}, {}{unit}.{details} {how}", scene.title(), scene.chain().sites(), params_words(params),)
}

/// Exponent, spring constant and mass ratio, for captions.
pub(crate) fn params_words(params: Params) -> String {
    let [alpha, kappa, rho] = [params.alpha, params.kappa, params.rho].map(format_parameter);
    format!("α = {alpha}, κ = {kappa}, ρ = {rho}")
}

/// The centre of a kink, as a word.
pub(crate) fn center_word(center: Center) -> &'static str {
    match center {
        Center::Site => "site",
        Center::Bond => "bond",
    }
}
