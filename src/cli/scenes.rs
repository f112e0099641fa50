//! `hertzchain scenes`.

use super::{DONE, Exit, print, runner::Runs};
use crate::{
    output::to_json,
    report::text::table,
    scene::Scene,
    study::{Plan, options, scene_json},
};
use serde_json::json;

options! {
    /// All scenes and plans.
    pub(crate) struct List {
        /// Print JSON instead of text.
        json: bool = false, [global = true];
    }
}

options! {
    /// One scene.
    pub(crate) struct Show {
        /// Name of a built-in scene, or a TOML file.
        name: String = String::new();
        /// Print JSON instead of text.
        json: bool = false;
    }
}

options! {
    /// A scene with every key.
    pub(crate) struct Template {
        /// Print JSON instead of text.
        json: bool = false;
    }
}

/// Prints the text of a scene, or all that it says, as JSON.
fn shown(text: &str, name: &str, json: bool) -> Exit {
    let scene = Scene::parse(text, name)?;
    print(&if json { to_json(&scene_json(&scene)) + "\n" } else { text.to_owned() }).map(|()| DONE)
}

impl Runs for Show {
    fn run(&self) -> Exit {
        shown(&Scene::source(&self.name)?, &self.name, self.json)
    }
}

impl Runs for Template {
    fn run(&self) -> Exit {
        shown(Scene::TEMPLATE, "template", self.json)
    }
}

impl Runs for List {
    fn run(&self) -> Exit {
        let text = if self.json {
            let row = |(name, summary)| json!({"name": name, "summary": summary});
            let [scenes, plans] = [Scene::list(), Plan::list().collect()].map(|all| all.into_iter().map(row));
            to_json(&json!({"scenes": scenes.collect::<Vec<_>>(), "plans": plans.collect::<Vec<_>>()})) + "\n"
        } else {
            let lines = |of: &str, all: Vec<(&str, String)>| {
                let rows: Vec<_> = all.into_iter().map(|(name, summary)| vec![name.to_owned(), summary]).collect();
                table(&[of, "what it is"], &rows, 2)
            };
            format!("{}\n{}", lines("scene", Scene::list()), lines("plan of sweep", Plan::list().collect()))
        };
        print(&text).map(|()| DONE)
    }
}
