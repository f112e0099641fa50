//! `hertzchain scenes`.

use super::{
    DONE, Exit,
    args::{ScenesAction, ScenesArgs},
    print,
};
use crate::{output::to_json, present::table, scene::Scene, study::scene_json};
use serde_json::json;

pub(super) fn main(args: &ScenesArgs) -> Exit {
    let text = match &args.action {
        Some(ScenesAction::Show { name }) => {
            let text = Scene::source(name)?;
            let scene = Scene::parse(&text, name)?;
            if args.json { to_json(&scene_json(&scene)) + "\n" } else { text }
        }
        Some(ScenesAction::Template) => {
            let scene = Scene::parse(Scene::TEMPLATE, "template")?;
            if args.json { to_json(&scene_json(&scene)) + "\n" } else { Scene::TEMPLATE.to_owned() }
        }
        None if args.json => {
            let list: Vec<_> =
                Scene::list().into_iter().map(|(name, summary)| json!({"name": name, "summary": summary})).collect();
            to_json(&json!({"scenes": list})) + "\n"
        }
        None => {
            let rows: Vec<_> =
                Scene::list().into_iter().map(|(name, summary)| vec![name.to_owned(), summary]).collect();
            table(&["scene", "what it is"], &rows)
        }
    };
    print(&text).map(|()| DONE)
}
