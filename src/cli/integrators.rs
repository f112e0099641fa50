//! `hertzchain integrators`.

use super::{DONE, Exit, print, runner::Runs};
use crate::{
    output::to_json,
    report::{fields, text::table},
    run::{Method, method::MethodInfo},
    study::options,
};
use serde_json::json;

options! {
    pub(crate) struct IntegratorsArgs {
        /// Print JSON instead of text.
        json: bool = false;
    }
}

impl Runs for IntegratorsArgs {
    fn run(&self) -> Exit {
        let all = Method::all();
        if self.json {
            let told = |info: MethodInfo| fields!(info => name, order, stages, family, source);
            let list: Vec<_> = all.iter().map(Method::info).map(told).collect();
            return print(&(to_json(&json!({"integrators": list})) + "\n")).map(|()| DONE);
        }
        let rows: Vec<_> = all
            .iter()
            .map(|method| {
                // As the number of nodes a panel is.
                let nodes = (*method == Method::Collocation).then(|| ["8 to 24", "4 to 12"].map(str::to_owned));
                let info = method.info();
                let [order, stages] = nodes.unwrap_or([info.order.to_string(), info.stages.to_string()]);
                vec![info.name, order, stages, info.family.to_owned(), info.source.to_owned()]
            })
            .collect();
        print(&table(&["integrator", "order", "stages", "family", "source"], &rows, 2)).map(|()| DONE)
    }
}
