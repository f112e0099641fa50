//! The one way in which studies run: folder, progress bar, signals, what is printed, files, exit
//! code.

use super::{DONE, Exit, FAILED, columns, formats::Formats, print, progress_bar, say};
use crate::{
    error::{Error, Result},
    interrupt,
    output::{Folder, to_json},
    report::Report,
    study::{
        Progress, Study, Work,
        options::{Field, Flag, one, options},
    },
    sweep::{Engine, Part, Shard},
};
use clap::{
    Arg, ArgAction, ArgGroup, ArgMatches, Command,
    builder::{PossibleValuesParser, TypedValueParser},
    value_parser,
};
use std::path::PathBuf;

const SHARD_NEEDS: &str = "a shard keeps its points in a folder: give --out DIR, the same for all shards";

/// The engine of MPI jobs, by name.
pub(super) const MPI: &str = "mpi";

options! {
    /// Where the points of a sweep are computed.
    struct EngineArgs {
        /// Compute only part K of N of the points; needs --out.
        ///
        /// The points are kept in a store of their own in the folder of --out. Parts may run at any
        /// time and on any machine that has this folder; start a part again if it was killed. Once
        /// all have ended, the same command without --shard merges what they have kept, computes
        /// what is missing, and ends with the same files as one process.
        shard: Option<Shard> = None, "K/N";
        /// Where points are computed: threads or mpi.
        ///
        /// threads: on the cores of this machine, or RAYON_NUM_THREADS of them. mpi: on the ranks
        /// of the job of mpirun, each with RAYON_NUM_THREADS threads, one without it; rank 0 has
        /// store, output and progress, the others print nothing. Results have the same bytes. Needs
        /// a build with the feature mpi.
        mpi: bool = false, "E", [long = "engine", action = ArgAction::Set, value_parser = engines(),
            default_value = "threads", hide_short_help = true];
    }
}
one!(Shard: |text: &str| text.parse::<Shard>());

fn engines() -> impl TypedValueParser<Value = bool> {
    PossibleValuesParser::new(["threads", MPI]).map(|name| name == MPI)
}

impl EngineArgs {
    /// The engine that the command says, without a folder.
    fn engine(&self) -> Result<Engine> {
        if self.mpi { over_ranks() } else { Ok(Engine::threads()) }
    }

    /// The folder of the results. Shards share it.
    fn own(&self, out: impl Into<PathBuf>) -> Result<Folder> {
        Folder::own(out, self.shard.map(|shard| shard.to_string()).as_deref())
    }

    /// The engine with the folder of the store, for the shard if one is given.
    fn keeping(&self, engine: Engine, folder: Option<&Folder>) -> Result<Engine> {
        let engine = folder.into_iter().fold(engine, Engine::keeping);
        match self.shard {
            Some(shard) if folder.is_none() => Err(Error::parameter("shard", shard, SHARD_NEEDS)),
            Some(shard) => Ok(engine.shard(shard)),
            None => Ok(engine),
        }
    }
}

#[cfg(feature = "mpi")]
fn over_ranks() -> Result<Engine> {
    Ok(Engine::new(Box::new(crate::sweep::Mpi::new()?)))
}

#[cfg(not(feature = "mpi"))]
fn over_ranks() -> Result<Engine> {
    let rule = "this build has no MPI: build with `cargo build --release --features mpi`, or take --shard K/N";
    Err(Error::parameter("engine", MPI, rule))
}

/// The name of a group of flags that only studies have.
pub(super) const STUDY: &str = "study";

/// A command.
pub(super) trait Runs {
    /// Runs it: prints, writes files, and returns the exit code.
    fn run(&self) -> Exit;

    /// Does the work of a study, writes the files to the folder that it names, and prints nothing.
    fn report(&self, _: Progress<'_>) -> Result<Report> {
        Err(Error::Options("it is a command, but no study".to_owned()))
    }
}

/// A command with its flags.
pub(super) trait Asked: Runs + Sized + 'static {
    /// The command with the flags.
    fn flags(command: Command) -> Command;

    /// What the command line says.
    fn read(matches: &ArgMatches) -> Self;
}

impl<T: Runs + Field + Default + 'static> Asked for T {
    fn flags(command: Command) -> Command {
        Self::default().add(command, &Flag::GROUP)
    }

    fn read(matches: &ArgMatches) -> Self {
        Self::default().read(matches, "")
    }
}

/// A study as a command: its options, and the flags that say where it runs and where results go.
pub(super) struct StudyCommand<S> {
    study: S,
    flags: Flags,
}

/// The flags of a study, and what it says of itself; not generic, so that it is compiled once.
struct Flags {
    out: Option<PathBuf>,
    engine_args: EngineArgs,
    json: bool,
    formats: Option<Formats>,
    interruptible: bool,
    sweeps: bool,
    optional_files: fn() -> Vec<String>,
}

/// [`Study::begin`] of a study.
type Begin<'a> = &'a dyn Fn() -> Result<Work<'a>>;

impl Flags {
    /// The engine with the folder for the results, the one of --out or another one, and the work,
    /// once the options are checked.
    fn begun<'a>(&self, begin: Begin<'a>, engine: Engine, otherwise: Option<PathBuf>) -> Result<(Engine, Work<'a>)> {
        let work = begin()?;
        let out = self.out.clone().or(otherwise);
        let folder = out.map(|out| self.engine_args.own(out)).transpose()?;
        Ok((self.engine_args.keeping(engine, folder.as_ref())?, work))
    }

    /// Writes the files of a report, in place of those that an earlier run may have left.
    fn write(&self, engine: &Engine, report: &Report) -> Result<()> {
        let Some(folder) = engine.folder().filter(|_| finished_part(engine).is_none()) else { return Ok(()) };
        let left = (self.optional_files)();
        let left: Vec<String> = left.iter().flat_map(|name| super::formats::names(name)).collect();
        folder.remove(left.iter().map(String::as_str))?;
        for (name, bytes) in report.files()? {
            folder.write(&name, &bytes)?;
        }
        if let Some(formats) = &self.formats {
            formats.write(folder, &report.drawn()?)?;
        }
        Ok(())
    }

    /// Does the work of a study. Of a shard, the report says what it has done.
    fn done(&self, work: Work<'_>, engine: &Engine, progress: Progress<'_>) -> Result<Report> {
        let report = work(engine, progress);
        let report = match (engine.part(), finished_part(engine)) {
            (_, Some(part)) => return Ok(part_report(&part)),
            (Some(_), None) => report,
            (None, _) => report.and_then(|report| whole(report, engine)),
        };
        match report {
            // Parts of this study may have failed since it was asked to end, and it does not know.
            Ok(_) if interrupt::asked() && !self.interruptible => Err(nothing()),
            Err(Error::Parameter { .. } | Error::Integration(_) | Error::Stalled { .. } | Error::Run(_))
                if interrupt::asked() =>
            {
                Err(nothing())
            }
            report => report,
        }
    }

    fn run<'a>(&self, begin: Begin<'a>, otherwise: Option<PathBuf>) -> Exit {
        let engine = self.engine_args.engine()?;
        if engine.serves() {
            // Rank 0 reports errors.
            let _ = begin().and_then(|work| work(&engine, &|_, _| ()));
            return Ok(DONE);
        }
        let (engine, work) = self.begun(begin, engine, otherwise)?;
        let bar = progress_bar();
        let report = self.done(work, &engine, &|share, what| {
            bar.set_position((1000.0 * share.min(1.0)) as u64);
            bar.set_message(what.to_owned());
        });
        bar.finish_and_clear();
        if interrupt::asked() && finished_part(&engine).is_none() {
            say(&stopped(self.sweeps, &engine));
        }
        let report = report?;
        if let Some(remark) = report.remarks() {
            say(remark);
        }
        if let Some(why) = report.error() {
            say(&format!("error: {why}"));
        }
        // Results are printed before files are written, and files are written even if printing
        // fails: a failure of one does not lose the other.
        let printed = print(&if self.json { to_json(&report.json()) + "\n" } else { report.text_in(columns()) });
        self.write(&engine, &report)?;
        if let Some(folder) = engine.folder().filter(|_| finished_part(&engine).is_none()) {
            say(&format!("written to {}", folder.path().display()));
        }
        printed.map(|()| if report.error().is_none() { DONE } else { FAILED })
    }

    fn report<'a>(&self, begin: Begin<'a>, progress: Progress<'_>) -> Result<Report> {
        let engine = self.engine_args.engine()?;
        if engine.serves() {
            return begin()?(&engine, progress);
        }
        let (engine, work) = self.begun(begin, engine, None)?;
        let report = self.done(work, &engine, progress)?;
        self.write(&engine, &report)?;
        Ok(report)
    }
}

/// What a shard has done, once it has all of its points.
fn finished_part(engine: &Engine) -> Option<Part> {
    engine.part().filter(|part| part.kept == part.points)
}

impl<S: Study> Runs for StudyCommand<S> {
    fn run(&self) -> Exit {
        self.flags.run(&|| self.study.begin(), self.study.default_folder())
    }

    fn report(&self, progress: Progress<'_>) -> Result<Report> {
        self.flags.report(&|| self.study.begin(), progress)
    }
}

impl<S: Study + Field + Default + 'static> Asked for StudyCommand<S> {
    fn flags(command: Command) -> Command {
        let command = with_outputs(S::default().add(command, &Flag::GROUP), &files_help::<S>());
        if S::SWEEPS { EngineArgs::default().add(command, &Flag::GROUP) } else { command }
    }

    fn read(matches: &ArgMatches) -> Self {
        let flags = Flags {
            out: None.read(matches, "out"),
            engine_args: EngineArgs::default().read(matches, ""),
            json: false.read(matches, "json"),
            formats: draws(&files_help::<S>()).then(|| Formats::default().read(matches, "")),
            interruptible: S::INTERRUPTIBLE,
            sweeps: S::SWEEPS,
            optional_files: S::optional_files,
        };
        Self { study: S::default().read(matches, ""), flags }
    }
}

/// Adds `--out`, for a study that writes files, and `--json`. `files` are the words on them.
fn with_outputs(command: Command, files: &str) -> Command {
    let out = Arg::new("out").long("out").value_name("DIR").value_parser(value_parser!(PathBuf));
    let help = "Write the results to this folder";
    let json =
        |command| false.add(command, &Flag { id: "json", docs: &["Print JSON instead of text."], ..Flag::GROUP });
    let command = command.group(ArgGroup::new(STUDY));
    if files.is_empty() {
        return json(command);
    }
    let command = if draws(files) { Formats::default().add(command, &Flag::GROUP) } else { command };
    json(command.arg(out.help(help).long_help(format!("{help}.\n\n{files}"))))
}

/// Whether there are pictures among the files of a study.
fn draws(files: &str) -> bool {
    files.contains(".png")
}

/// The files of a study and the columns of its tables, for the help.
fn files_help<S: Study>() -> String {
    let tables = S::outline().map(|outline| outline.files_in_words(S::FILES)).unwrap_or_default();
    let store = match S::STORE {
        "" => String::new(),
        store => {
            format!("{store} keeps every point as soon as it is computed; the same command resumes from it.\n\n")
        }
    };
    format!("{tables}{store}{}", S::FILES)
}

/// Refuses the report of a study that had no grid to take a shard of.
fn whole(report: Report, engine: &Engine) -> Result<Report> {
    let rule = "with these options there is no grid to divide: leave --shard out";
    engine.its_shard().map_or(Ok(report), |shard| Err(Error::parameter("shard", shard, rule)))
}

/// What to do after a signal.
fn stopped(sweeps: bool, engine: &Engine) -> String {
    let next = match (sweeps, engine.folder()) {
        (true, Some(folder)) => format!("the same command goes on with what {} has", folder.path().display()),
        (true, None) => "with --out DIR, the same command goes on where it was stopped".to_owned(),
        (false, _) => "the same command begins again".to_owned(),
    };
    format!("asked to end by a signal; results are of what was done before: {next}")
}

fn nothing() -> Error {
    Error::Stopped { kept: "nothing of this study was finished".to_owned() }
}

fn part_report(part: &Part) -> Report {
    let Part { shard, points, kept, computed, store } = part;
    let report = Report::new("shard").fact("shard", shard.to_string()).fact("points", points).fact("kept", kept);
    report.fact("computed", computed).fact("store", store).lines(format!("shard {shard}: {}\n", part.words()))
}
