//! `hertzchain integrators`.

use super::{DONE, Exit, args::IntegratorsArgs, print};
use crate::{output::to_json, present::table, run::Method};
use serde_json::json;

pub(super) fn main(args: &IntegratorsArgs) -> Exit {
    let all = Method::all();
    if args.json {
        let list: Vec<_> = all
            .iter()
            .map(|method| {
                json!({
                    "name": method.name(),
                    "order": method.order(),
                    "stages": method.stages(),
                    "family": method.family(),
                    "source": method.source(),
                })
            })
            .collect();
        return print(&(to_json(&json!({"integrators": list})) + "\n")).map(|()| DONE);
    }
    let rows: Vec<_> = all
        .iter()
        .map(|method| {
            vec![
                method.name(),
                method.order().to_string(),
                method.stages().to_string(),
                method.family().to_owned(),
                method.source().to_owned(),
            ]
        })
        .collect();
    print(&table(&["integrator", "order", "stages", "family", "source"], &rows)).map(|()| DONE)
}
