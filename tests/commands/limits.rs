//! Limits that the machine, the terminal and other processes set: what cannot be done is refused
//! before the work, in words that name the cause, and leaves nothing behind.
#![cfg(unix)]

use super::program::{PROGRAM, command, hertzchain, limited, names, refused};
use hertzchain::output::Folder;
use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
    thread::sleep,
    time::Duration,
};

#[test]
fn no_control_character_reaches_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let scene = "[chain]\nsites = 4\nalpha = 1.5\nboundary = \"free\"\n[initial]\nkind = \"single-bead\"\nsite = 0\n\
                 velocity = 1.0\n[span]\nuntil = 1.0\n";
    let write = |name: &str, text: &str| {
        fs::write(path(name), text).unwrap();
        path(name)
    };
    let named = write("named.toml", &format!("name = \"x\\u001b]0;title\\u0007\"\n{scene}"));
    let summed = write("summed.toml", &format!("summary = \"\"\"two\nlines\"\"\"\n{scene}"));
    let odd = write("odd\u{1b}[31m\u{7}.toml", scene);
    let plan =
        write("plan.toml", "scene = \"impact\"\n[[axis]]\nkey = \"name\"\nvalues = [\"a\", \"\\u001b\", \"c\"]\n");
    let none = path("none\u{9b}.toml");
    for (args, code, words) in [
        (&["run", &named][..], 2, "line 1: `name`: \"x\\u{1b}]0;title\\u{7}\": a text here has no control characters"),
        (&["run", &summed], 2, "line 1: `summary`: \"two\\nlines\""),
        (&["run", "impact", "--set", "name=\u{1b}[1m"], 2, "`name`: \"\\u{1b}[1m\""),
        (&["run", "impact", "--set", "na\u{1b}me=1"], 2, "na\u{fffd}me"),
        (&["run", &odd], 0, "odd\u{fffd}[31m\u{fffd}"),
        (&["sweep", &plan], 2, "line 4: `axis`: \"\\u{1b}\""),
        (&["run", &none], 1, "none\u{fffd}.toml"),
        (&["run", "a\u{1b}b"], 2, "unknown scene \"a\u{fffd}b\""),
        (&["run", "impact", "--integrator", "\u{1b}"], 2, "unknown integrator"),
        (&["run", "impact", "--tol", "\u{1b}\u{7}"], 2, "not a number"),
        (&["\u{1b}\u{7}"], 2, "unrecognized subcommand"),
        (&["run", "impact", "--\u{1b}\u{7}"], 2, "unexpected argument"),
    ] {
        let output = hertzchain(args);
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert!(output.status.code() == Some(code) && text.contains(words), "{args:?}: {text:?}");
        assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{args:?}: {text:?}");
    }
}

#[cfg(feature = "plot")]
#[test]
fn a_scene_whose_name_the_font_lacks_has_its_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("链\u{1f600}");
    let scene = folder.path().join("链\u{1f600}.toml");
    let text = "chain={sites=2,alpha=1.5,boundary=\"free\"}\ninitial={kind=\"single-bead\",site=0,velocity=1.0}\n\
                span={until=3.0}\nsummary=\"链 & <b>\"\n";
    fs::write(&scene, text).unwrap();
    let args = [Path::new("run"), &scene, Path::new("--format"), Path::new("png,svg"), Path::new("--out"), &out];
    let output = Command::new(PROGRAM).args(args).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(out.join("profile.png").exists() && out.join("energy.png").exists());
    // A viewer of SVG may have the glyph: the text is there as it was given.
    assert!(fs::read_to_string(out.join("profile.svg")).unwrap().contains("链\u{1f600}: strain profile"));
}

#[test]
fn what_stands_where_a_file_must_go_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.toml");
    fs::write(&plan, "scene = \"impact\"\nset = [\"span.until=1\"]\n[[axis]]\nkey = \"chain.rho\"\nvalues = [1]\n")
        .unwrap();
    let run = "run impact --until 1 --out".to_owned();
    let sweep = format!("sweep {} --out", plan.display());
    let pipe = |path: &Path| assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
    let link = |path: &Path| std::os::unix::fs::symlink("nowhere", path).unwrap();
    let round = |path: &Path| std::os::unix::fs::symlink(path, path).unwrap();
    let below = |path: &Path| fs::create_dir(path).unwrap();
    type Obstacle<'a> = &'a dyn Fn(&Path);
    let cases: [(&str, &str, Obstacle<'_>); 8] = [
        (&run, "summary.json", &below),
        (&run, "profiles.npz", &link),
        (&run, "energy.png", &round),
        (&run, "checkpoint.npz", &pipe),
        (&sweep, "sweep.store", &pipe),
        (&sweep, "sweep.csv", &below),
        (&sweep, "sweep.store", &round),
        ("run --resume", "checkpoint.npz", &pipe),
    ];
    for (k, (line, name, make)) in cases.into_iter().enumerate() {
        let out = folder.path().join(k.to_string());
        fs::create_dir(&out).unwrap();
        make(&out.join(name));
        let said = refused(&format!("{line} {}", out.display()), 1);
        assert!(said.contains(&format!("{name}: in the place of a file of results, and no file")), "{line}: {said}");
        assert_eq!(names(&out), [name.to_owned()].into());
    }
    for make in [link, round] {
        let out = folder.path().join("out");
        make(&out);
        let said = refused(&format!("{run} {}/below", out.display()), 1);
        assert!(said.contains("results are written to a folder, and") && said.contains("out is none"), "{said}");
        fs::remove_file(&out).unwrap();
    }
}

#[test]
fn a_folder_belongs_to_one_process_and_its_lock_ends_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let line = |until: &str| format!("run impact --until {until} --out {}", out.display());
    let mut long = command(&line("1e6")).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let who = format!("process {} on ", long.id());
    let lock = out.join(".hertzchain-lock");
    while !fs::read_to_string(&lock).is_ok_and(|text| text.starts_with(&who)) {
        sleep(Duration::from_millis(5));
    }
    for line in
        [line("1"), format!("run --resume {}", out.display()), format!("dps dark --sites 5 --out {}", out.display())]
    {
        let said = refused(&line, 2);
        assert!(
            said.contains(&format!("in use by another run ({who}")) && said.contains("until it has ended"),
            "{said}"
        );
    }
    long.kill().unwrap();
    long.wait().unwrap();
    assert!(lock.exists() && hertzchain(&line("1")).status.success() && !lock.exists());
    // Shards share a folder, one process each.
    let own = |part: Option<&str>| Folder::own(&out, part).map_err(|why| why.to_string());
    let one = own(Some("1-of-2")).unwrap();
    let (two, again, whole) = (own(Some("2-of-2")), own(Some("1-of-2")), own(None));
    let who = format!("process {} on ", std::process::id());
    assert!(two.is_ok() && again.is_err_and(|why| why.contains(&who)));
    assert!(whole.is_err_and(|why| why.matches(&who).count() == 2));
    let before = names(&out);
    drop(one);
    assert!(own(None).is_err(), "part 2 has an owner");
    drop(two);
    assert!(own(None).is_ok());
    assert!(before.len() == names(&out).len() + 3 && !names(&out).iter().any(|name| name.starts_with('.')));
}

#[test]
fn a_limit_of_files_is_an_error_of_one_line_that_leaves_no_half_file_and_no_summary() {
    let folder = tempfile::tempdir().unwrap();
    let line = format!("run tw-q15 --until 3 --samples 60 --out {}", folder.path().display());
    assert!(hertzchain(&line).status.success());
    let limited = limited("ulimit -f 16", &line);
    let said = String::from_utf8(limited.stderr).unwrap();
    // Its first line is the choice of the method.
    let errors: Vec<&str> = said.lines().skip(1).collect();
    assert!(limited.status.code() == Some(1) && errors.len() == 1, "{:?}: {said}", limited.status);
    assert!(errors[0].starts_with("error: ") && errors[0].contains(".npz: File too large"), "{said}");
    let left = names(folder.path());
    assert!(!left.iter().any(|name| name.starts_with('.') || name == "summary.json"), "{left:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_is_not_there_is_said_before_the_run_and_a_plan_needs_none() {
    // A state of 5 10^7 sites without resonators has 0.8 GB.
    let line = "run impact --set chain.sites=50000000 --until 1 --integrator verlet --step 0.1";
    let ended = limited("ulimit -v 1000000", line);
    let said = String::from_utf8(ended.stderr).unwrap();
    assert!(ended.status.code() == Some(2) && ended.stdout.is_empty() && said.starts_with("error: "), "{said}");
    let words = [
        "--set chain.sites=50000000: `chain.sites`: sites = 50000000, which need 2.400 GB of memory where ",
        "are available",
    ];
    assert!(words.iter().all(|words| said.contains(words)), "{said}");
    // What beads have, and what a run keeps, counts too; a driven orbit is refused as a run is.
    for (line, key) in [
        ("orbit driven granular-crystal --set chain.sites=100000000", "sites"),
        ("run end-driven --set chain.sites=100000000 --plan", "sites"),
        ("run impact --until 0.1 --samples 1000000 --out none", "samples"),
        ("run impact --until 0.1 --samples 1000000 --checkpoint 0.05 --out none", "samples"),
    ] {
        let ended = limited("ulimit -v 300000", line);
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.code() == Some(2) && ended.stdout.is_empty() && !Path::new("none").exists(), "{said}");
        assert!(
            said.contains(&format!("{key} = 100"))
                && said.contains(", which need ")
                && said.contains(" GB of memory where "),
            "{line}: {said}"
        );
    }
    assert!(hertzchain("run impact --plan").stdout.ends_with(b"memory: at least 4.800 kB, for three states\n"));
}

#[test]
fn a_pipe_without_a_writer_is_waited_for_until_the_first_signal() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let pipe = pipe.to_str().unwrap();
    let driven = format!("run impact --set drive=[{{site=0,kind=\"pushed\",file={pipe:?}}}]");
    for (line, signal, code) in [
        (format!("run {pipe}"), "INT", 130),
        (format!("sweep {pipe}"), "TERM", 143),
        (driven, "TERM", 143),
        (format!("breather evolve {pipe}"), "INT", 130),
    ] {
        let waits = command(&line).stderr(Stdio::piped()).spawn().unwrap();
        sleep(Duration::from_millis(300));
        let kill = format!("kill -{signal} {}", waits.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
        let ended = waits.wait_with_output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.code() == Some(code), "{line}: {:?}", ended.status);
        assert!(said.contains(&format!("{pipe}: stopped by a signal before it was read")), "{line}: {said}");
    }
    // With a writer it is read.
    let write = format!("{PROGRAM} scenes show impact > {pipe} & {PROGRAM} run {pipe} --until 1");
    assert!(Command::new("sh").args(["-c", &write]).output().unwrap().status.success());
}

#[test]
fn a_number_of_threads_that_is_none_is_refused() {
    for (threads, code) in [("abc", 2), ("-1", 2), ("1.5", 2), ("2", 0), ("0", 0), ("", 0)] {
        let output = command("scenes").env("RAYON_NUM_THREADS", threads).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{said}");
        let words = format!("error: RAYON_NUM_THREADS = {threads} is not valid: a whole number of threads");
        assert!(code == 0 || said.starts_with(&words), "{said}");
    }
}
