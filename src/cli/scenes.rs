//! `hertzchain scenes`.

use super::{DONE, Exit, print, runner::Runs};
use crate::{
    output::to_json,
    report::text::table,
    scene::Scene,
    study::{Plan, scene_json},
};
use clap::{Args, Subcommand};
use serde_json::json;

#[derive(Args)]
pub(crate) struct ScenesArgs {
    #[command(subcommand)]
    action: Option<ScenesAction>,
    /// Print JSON instead of text.
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
pub(crate) enum ScenesAction {
    /// Print the TOML of a scene: a start for your own.
    #[command(after_long_help = "Example:\n  hertzchain scenes show tw-q15 > my-scene.toml")]
    Show {
        /// Name of a built-in scene, or a TOML file.
        name: String,
    },
    /// Print a scene with every key, each explained: a start for your own.
    #[command(after_long_help = "Example:\n  hertzchain scenes template > my-scene.toml")]
    Template,
}

impl Runs for ScenesArgs {
    fn run(&self) -> Exit {
        let text = match &self.action {
            Some(ScenesAction::Show { name }) => {
                let text = Scene::source(name)?;
                let scene = Scene::parse(&text, name)?;
                if self.json { to_json(&scene_json(&scene)) + "\n" } else { text }
            }
            Some(ScenesAction::Template) => {
                let scene = Scene::parse(Scene::TEMPLATE, "template")?;
                if self.json { to_json(&scene_json(&scene)) + "\n" } else { Scene::TEMPLATE.to_owned() }
            }
            None if self.json => {
                let row = |(name, summary)| json!({"name": name, "summary": summary});
                let [scenes, plans] = [Scene::list(), Plan::list().collect()].map(|all| all.into_iter().map(row));
                to_json(&json!({"scenes": scenes.collect::<Vec<_>>(), "plans": plans.collect::<Vec<_>>()})) + "\n"
            }
            None => {
                let lines = |of: &str, all: Vec<(&str, String)>| {
                    let rows: Vec<_> = all.into_iter().map(|(name, summary)| vec![name.to_owned(), summary]).collect();
                    table(&[of, "what it is"], &rows, 2)
                };
                format!("{}\n{}", lines("scene", Scene::list()), lines("plan of sweep", Plan::list().collect()))
            }
        };
        print(&text).map(|()| DONE)
    }
}
