//! `hertzchain paper verify`.

use super::{DONE, Exit, FAILED, args::VerifyArgs, print, progress_bar, runner::part_text, say};
use crate::{
    output::to_json,
    paper::{verify, verify_report},
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
    let verification = verify(args.section, &engine, &|share, _| bar.set_position((1000.0 * share) as u64));
    bar.finish_and_clear();
    if let Some(part) = engine.part().filter(|part| part.kept == part.points) {
        return print(&part_text(&part, args.json)).map(|()| DONE);
    }
    let verification = verification?;
    let report = verify_report(&verification);
    let printed = print(&if args.json { to_json(&report.json()) + "\n" } else { report.text() });
    if let Some(folder) = folder {
        for (name, bytes) in report.files()? {
            folder.write(&name, &bytes)?;
        }
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
