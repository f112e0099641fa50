//! Memory and messages of a run in parts, in words.

use crate::{
    chain::Topology,
    error::{Result, require},
    memory::bytes,
    parts::{Estimate, Motion},
    run::Method,
    scene::{MOST_SITES, SceneFile},
};

/// Most steps that part 0 orders at a time.
const ORDERED: usize = 64;

/// Memory and messages of a scene in `parts` parts, a line each. The scene is not built, so that it
/// may be one that no machine can hold.
///
/// # Errors
/// Parameters outside their rules; no part, or more parts than sites; a method that does not run in
/// parts.
pub fn parts_plan(file: &SceneFile, method: Method, parts: usize) -> Result<Vec<String>> {
    let chain = &file.chain;
    chain.params().validate()?;
    require((1..=chain.sites).contains(&parts), "ranks", parts, "from 1 to the number of sites")?;
    let motion = method.motion()?;
    motion.check("ranks", parts, Topology::new(chain.boundary, chain.sites))?;
    let demand = Estimate::new(chain.params(), chain.boundary, chain.sites, parts, motion);
    let Estimate { sites, ghosts, .. } = demand;
    let [memory, whole, message, sample] = [demand.memory, demand.whole, demand.message, demand.sample].map(bytes);
    let (of_bonds, panels) = match motion {
        Motion::Kicks(_) => ("", ""),
        Motion::Windows => (" bonds", " and the panels of a block"),
    };
    let mut lines = vec![
        format!(
            "{} sites in {parts} parts: at most {sites} each, and {ghosts}{of_bonds} of each neighbour",
            chain.sites
        ),
        format!("memory: {memory}{panels} a part, half of it for samples; the first besides two whole states, {whole}"),
    ];
    if parts > 1 {
        lines.push(match motion {
            Motion::Kicks(_) => {
                let (steps, order) = (ghosts as f64 / method.stages() as f64, bytes(order(method)));
                format!(
                    "messages: every {ghosts} kicks ({steps:.4} steps) a part sends {message} to each neighbour; \
                     every {ORDERED} steps or oftener an order of {order} goes to all"
                )
            }
            Motion::Windows => {
                let [order, verdict] = demand.window.map(bytes);
                format!(
                    "messages: every window an order of {order} goes to all; a part sends {message} to each \
                     neighbour and {verdict} to the first"
                )
            }
        });
        lines.push(format!("samples: each brings {sample} to the first part, which checks, counts and writes"));
    }
    if chain.sites > MOST_SITES {
        lines.push("refused if run: a scene has at most 10^8 sites".to_owned());
    }
    Ok(lines)
}

/// Bytes of an order for [`ORDERED`] steps: two numbers, and three for each kick.
fn order(method: Method) -> u64 {
    (8 * (2 + 3 * ORDERED * method.stages())) as u64
}
