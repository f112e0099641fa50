//! One long chain on several threads: the files of one, also where a run goes on with another
//! number; and what is refused.

use super::program::{command, files};
use hertzchain::{
    output::Folder,
    run::method::{Method, Setting},
    scene::Scene,
    study::LongRun,
};
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    process::Output,
};

/// Chains with ends and rings, with resonators and without, on both splits; and seven blocks of
/// bonds by contact collocation. Bitmaps would take more time than the runs.
const RUNS: [&str; 6] = [
    "run impact --set chain.sites=1000 --integrator verlet --until 20 --samples 7 --format svg",
    "run tw-q15 --integrator strang-linear --until 30 --samples 7 --format svg",
    "run cradle --integrator aba864-linear --until 5 --samples 7 --events --format svg",
    "run tw-q15 --integrator yoshida4 --until 3 --samples 7 --checkpoint 1 --format svg",
    "run impact --set chain.sites=1800 --tol 1e-6 --until 20 --samples 7 --events --format svg",
    "run tw-q15 --set chain.sites=1800 --tol 1e-5 --until 1.5 --samples 7 --checkpoint 0.6 --format svg",
];

/// Runs a command line with a folder and more flags.
fn output(line: &str, folder: &Path, more: &[&str]) -> Output {
    command(line).arg("--out").arg(folder).args(more).output().unwrap()
}

#[test]
fn threads_have_the_files_of_one() {
    for line in RUNS {
        let whole = tempfile::tempdir().unwrap();
        assert!(output(line, whole.path(), &[]).status.success(), "{line}");
        for threads in ["2", "7"] {
            let parts = tempfile::tempdir().unwrap();
            let ended = output(line, parts.path(), &["--threads", threads]);
            assert!(ended.status.success(), "{line}: {}", String::from_utf8_lossy(&ended.stderr));
            assert!(files(whole.path()) == files(parts.path()), "{line} in {threads}");
        }
    }
}

/// Begins a run, breaks it off three times on other numbers of threads, and ends it in two.
fn goes_on(begin: impl Fn() -> LongRun) {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let [whole, broken] = folders.each_ref().map(|folder| Folder::create(folder.path()).unwrap());
    let want = begin().run(&whole, &mut |_| ()).unwrap();
    for (threads, limit) in [(3, 2.5), (1, 4.0), (5, 7.0)] {
        let begun = LongRun::load(broken.path(), None).unwrap_or_else(|_| begin());
        let begun = begun.threads(threads).unwrap();
        let breaks = catch_unwind(AssertUnwindSafe(|| begun.run(&broken, &mut |t| assert!(t < limit, "enough"))));
        assert!(breaks.is_err() && LongRun::load(broken.path(), None).unwrap().time() > 0.0);
    }
    let last = LongRun::load(broken.path(), None).unwrap().threads(2).unwrap();
    let got = last.run(&broken, &mut |_| ()).unwrap();
    assert!((got.t, got.state, got.samples, got.stats) == (want.t, want.state, want.samples, want.stats));
    assert!(got.contacts == want.contacts);
}

#[test]
fn a_run_goes_on_with_another_number_of_threads() {
    // Truth: the same legs in one process, not interrupted.
    let long = |scene: Scene, name, setting| {
        let (scene, method) = (scene.until(8.0).unwrap(), Method::named(name).unwrap());
        LongRun::new(scene, method, setting, "words".to_owned(), 1.5, None).unwrap()
    };
    goes_on(|| long(Scene::load("tw-q15").unwrap(), "strang-linear", Setting::Steps(1000)));
    let impact = || Scene::load_with("impact", &["chain.sites=1300".to_owned()]).unwrap();
    goes_on(|| long(impact(), "collocation", Setting::Tolerance(1e-6)).with_contacts());
}
