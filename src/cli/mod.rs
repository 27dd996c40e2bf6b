//! The command line: arguments in, exit codes out. One file a command.
//!
//! Exit codes: 0 solved; 1 not solved, with the result still written; 2 the scene or the arguments are wrong: one
//! message on stderr, nothing written.

mod batch;
mod check;
mod compare;
mod completions;
mod curve;
mod fmu;
mod heap;
mod manual;
mod outputs;
mod picture;
mod plan;
mod progress;
mod report;
mod schema;
mod solve;
mod stability;
mod table;
mod voice;

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::error::InputError;
use crate::scene::Scene;

/// Contact patch, force, stiffness and pressure of two bodies pressed together.
#[derive(Parser)]
#[command(name = "contact-patch", version, propagate_version = true)]
struct Arguments {
    #[command(flatten)]
    voice: voice::Voice,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Solve(solve::Solve),
    Plan(plan::Plan),
    Check(check::Check),
    Compare(compare::Compare),
    Report(report::Report),
    Stability(stability::Stability),
    Batch(batch::Batch),
    Curve(curve::CurveCommand),
    Schema(schema::SchemaCommand),
    Completions(completions::Completions),
    Man(manual::Manual),
}

/// What ends a command without an answer.
enum Failure {
    /// The scene or the arguments are wrong, or a file cannot be written: exit code 2.
    Message(String),
    /// Nobody reads what is written any more.
    Closed,
}

impl Failure {
    fn wrong(place: impl std::fmt::Display, error: &InputError) -> Self {
        Self::Message(format!("{place}: {}: given {}; allowed: {}", error.path, error.given, error.allowed))
    }

    fn unwritable(path: &Path, error: &io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            return Self::Closed;
        }
        Self::Message(format!("{}: cannot be written: {error}", path.display()))
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::unwritable(Path::new("standard output"), &error)
    }
}

/// Runs the command that the arguments of the process name.
#[must_use]
pub fn run() -> ExitCode {
    run_with(std::env::args_os())
}

/// Runs the command that these arguments name, the name of the program first; returns the exit code.
#[must_use]
pub fn run_with<A: Into<OsString> + Clone>(arguments: impl IntoIterator<Item = A>) -> ExitCode {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(help_or_error) => {
            // A closed stream leaves only the exit code to speak.
            let _ = help_or_error.print();
            return u8::try_from(help_or_error.exit_code()).unwrap_or(2).into();
        }
    };
    let voice = arguments.voice;
    let result = match arguments.command {
        Command::Solve(command) => command.run(voice),
        Command::Plan(command) => command.run(),
        Command::Check(command) => command.run(),
        Command::Compare(command) => command.run(voice),
        Command::Report(command) => command.run(voice),
        Command::Stability(command) => command.run(voice),
        Command::Batch(command) => command.run(voice),
        Command::Curve(command) => command.run(voice),
        Command::Schema(command) => command.run(),
        Command::Completions(command) => command.run(),
        Command::Man(command) => command.run(),
    };
    match result {
        Ok(code) => code,
        Err(Failure::Closed) => ExitCode::SUCCESS,
        Err(Failure::Message(message)) => {
            // A closed stderr leaves only the exit code to speak.
            let _ = writeln!(io::stderr().lock(), "{message}");
            ExitCode::from(2)
        }
    }
}

/// The files that a command reads for a scene: its own, and those that it names.
fn inputs(path: &Path, scene: &Scene) -> Vec<PathBuf> {
    let own = (path.as_os_str() != "-").then(|| path.to_owned());
    own.into_iter().chain(scene.files.iter().cloned()).collect()
}

/// The scene in this file; `-` is standard input.
fn scene(path: &Path) -> Result<Scene, Failure> {
    if path.as_os_str() != "-" {
        return Scene::from_file(path).map_err(|e| Failure::wrong(path.display(), &e));
    }
    let text = crate::scene::read_all(io::stdin().lock())
        .map_err(|e| Failure::Message(format!("standard input: cannot be read: {e}")))?;
    Scene::from_json(&text).map_err(|e| Failure::wrong("standard input", &e))
}

/// Threads to use when nobody says how many.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// How many threads may work.
#[derive(Args)]
struct Threads {
    /// Threads to use; by default all cores
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

impl Threads {
    fn checked(&self) -> Result<usize, Failure> {
        checked_threads("--threads", self.threads)
    }
}

/// The same where run times are shown.
#[derive(Args)]
struct TimedThreads {
    /// Threads of each run; one by default, so that run times can be compared
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: usize,
}

impl TimedThreads {
    fn checked(&self) -> Result<usize, Failure> {
        checked_threads("--threads", Some(self.threads))
    }
}

/// A number of threads given at `path`; all cores where none is given.
fn checked_threads(path: &str, threads: Option<usize>) -> Result<usize, Failure> {
    /// More threads than machines have cores; each takes memory.
    const MOST: usize = 1024;
    match threads {
        None => Ok(cores()),
        Some(n @ 1..=MOST) => Ok(n),
        Some(n) => {
            let error = InputError::new(path, n, format!("a whole number from 1 to {MOST}"));
            Err(Failure::wrong("arguments", &error))
        }
    }
}
