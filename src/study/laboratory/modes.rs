//! Linear modes of a scene: of the finite chain about its static state.

use crate::study::{
    Changes, ResultUnits, Study, Work,
    options::options,
    orbits::normal_modes::{linear_modes, numbered},
    scene_caption, scene_json,
    si::Scale,
};
use crate::{
    error::Result,
    orbits::{LinearMode, NormalModes},
    report::{Column, Hidden, Kind, Line, Panel, Panels, Report, Table},
    scene::{Scene, Units},
};

/// Most modes that the text shows.
const SHOWN: usize = 20;
/// Lowest modes whose shapes the picture shows, beside the most localised one.
const DRAWN: usize = 3;

options! {
    /// The linear modes of a scene.
    pub struct Modes {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// Its contacts hold every bead at rest: a static overlap, between walls or on a ring.
        /// Damping does not matter; a bead that a drive moves is held. `[initial]` may be left out.
        scene: String = "defect".to_owned();
        /// Changes to the scene.
        changes: Changes = Changes::default();
        /// The units of results.
        results: ResultUnits = ResultUnits::default();
    }
}

impl Study for Modes {
    fn outline() -> Option<Report> {
        Some(Report::new("modes").table(linear_modes(&[], 0, None)).table(shapes(&[], &[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let scene = Scene::load_at_rest(&self.scene, &self.changes.set)?;
        let (si, modes) = (self.results.of(&scene), NormalModes::held(scene.chain(), &[])?);
        Ok(Box::new(move |_, _| Ok(told(&scene, &modes, si.as_ref()))))
    }
}

/// The shapes: a row for each bead and each resonator that moves, a column for each mode.
fn shapes(places: &[(usize, bool)], modes: &[LinearMode]) -> Table {
    let rows: Vec<usize> = (0..places.len()).collect();
    let mut table = Table::of("mode-shapes", &rows)
        .key("")
        .in_text(None)
        .col("site", Hidden, "", |row| places[*row].0)
        .col("resonator", Hidden, "whether the row is that of its resonator", |row| places[*row].1);
    // The help has the first column.
    let columns: Vec<Option<&LinearMode>> =
        if modes.is_empty() { vec![None] } else { modes.iter().map(Some).collect() };
    for (k, mode) in columns.into_iter().enumerate() {
        let about = if k == 0 { "displacement in the first mode, 1 where it moves most, and so on" } else { "" };
        let shape = |row: &usize| mode.map_or(0.0, |mode| mode.shape[*row]);
        table = table.col(format!("mode_{}", k + 1), Hidden, about, shape);
    }
    table.done()
}

fn told(scene: &Scene, modes: &NormalModes, si: Option<&Units>) -> Report {
    let (linear, scale) = (modes.linear(), Scale(si));
    let places: Vec<(usize, bool)> = (0..modes.coordinates()).map(|c| modes.place(c)).collect();
    let all = numbered(modes);
    let (kind, label) = scale.frequency();
    let omega = |mode: &LinearMode| scale.reported(kind, mode.omega);
    let frequencies = (1..).map(f64::from).zip(linear.iter().map(omega));
    let shares = linear.iter().map(|mode| (omega(mode), mode.participation));
    let left = [
        Panel::new(Kind::Cloud, ["number of the mode", &label], vec![Line::new("modes", frequencies)]),
        Panel::new(Kind::Cloud, [&label, "participation number"], vec![Line::new("modes", shares)]),
    ];
    let localised = modes.most_localised();
    let drawn = (0..linear.len().min(DRAWN)).chain((localised >= DRAWN).then_some(localised));
    let shape = |k: usize| {
        let beads = places.iter().zip(&linear[k].shape).filter(|((_, resonator), _)| !resonator);
        Line::new(&format!("mode {}", k + 1), beads.map(|((site, _), s)| (*site as f64, *s)))
    };
    let right = [Panel::new(Kind::Sites, ["site n", "shape of beads"], drawn.map(shape).collect())];
    let how = format!("{} linear modes about the static state.", linear.len());
    let few = if linear.len() > SHOWN { format!(" The table shows the first {SHOWN}.") } else { String::new() };
    let report = Report::new("modes")
        .si(si)
        .fact("scene", scene.name())
        .fact("modes", linear.len())
        .words(format!("{how} The most localised one is mode {}.{few}", localised + 1))
        .table(linear_modes(&all, 0, si).in_text(0..SHOWN))
        .table(shapes(&places, linear));
    let columns = vec![Column::new("", left), Column::new("", right)];
    let title = format!("Linear modes of {}", scene.name());
    let report = report.fact("scene_file", scene_json(scene)).warnings(scene.doubts());
    report.picture(Panels { title, columns, caption: scene_caption(scene, &how) })
}
