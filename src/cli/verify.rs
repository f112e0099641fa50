//! `hertzchain paper verify`.

use super::{DONE, Exit, FAILED, args::VerifyArgs, print, progress_bar, runner::part_text, say};
use crate::{
    paper::{verify, verify_csv, verify_json, verify_table},
    sweep::Engine,
};

pub(super) fn main(args: &VerifyArgs) -> Exit {
    let engine = args.spread.engine(Engine::threads)?;
    if engine.serves() {
        // Rank 0 reports errors.
        let _ = verify(args.section, &engine, &|_, _| ());
        return Ok(DONE);
    }
    let folder = args.out.as_ref().map(|out| args.spread.own(out)).transpose()?;
    let engine = args.spread.keeping(engine, folder.as_ref())?;
    let bar = progress_bar();
    let verification = verify(args.section, &engine, &|done, total| bar.set_position(1000 * done / total));
    bar.finish_and_clear();
    if let Some(part) = engine.part().filter(|part| part.kept == part.points) {
        return print(&part_text(&part, args.json)).map(|()| DONE);
    }
    let verification = verification?;
    let (json, table) = (verify_json(&verification), verify_table(&verification));
    let printed = print(&if args.json { json.clone() + "\n" } else { table.clone() });
    if let Some(folder) = folder {
        folder.write("verify.txt", table.as_bytes())?;
        folder.write("verify.csv", &verify_csv(&verification))?;
        folder.write("verify.json", json.as_bytes())?;
        say(&format!("written to {}", folder.path().display()));
    }
    printed?;
    let unexpected: Vec<&str> = verification.unexpected().map(|item| item.claim.id.as_str()).collect();
    if unexpected.is_empty() {
        return Ok(DONE);
    }
    say(&format!("not as known: {}", unexpected.join(", ")));
    Ok(FAILED)
}
