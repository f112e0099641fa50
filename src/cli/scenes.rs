//! `hertzchain scenes`.

use super::{
    Exit,
    args::{ScenesAction, ScenesArgs},
    print,
};
use crate::{
    output::to_json,
    report::table,
    scene::{Scene, SceneFile},
};
use serde_json::{Value, json};
use std::process::ExitCode;

pub(super) fn main(args: &ScenesArgs) -> Exit {
    match &args.action {
        Some(ScenesAction::Show { name }) => {
            let text = Scene::source(name)?;
            let scene = Scene::build(SceneFile::parse(&text, name)?)?;
            print(&if args.json { to_json(&scene_json(scene.file())) + "\n" } else { text });
        }
        None if args.json => {
            let list: Vec<_> =
                Scene::list().into_iter().map(|(name, summary)| json!({"name": name, "summary": summary})).collect();
            print(&(to_json(&json!({"scenes": list})) + "\n"));
        }
        None => {
            let rows: Vec<_> =
                Scene::list().into_iter().map(|(name, summary)| vec![name.to_owned(), summary]).collect();
            print(&table(&["scene", "what it is"], &rows));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The scene as JSON; an infinite mass ratio, which JSON has no number for, as `"inf"`.
fn scene_json(file: &SceneFile) -> Value {
    let mut value = json!(file);
    if file.chain.rho.is_infinite() {
        value["chain"]["rho"] = json!("inf");
    }
    value
}
