//! `contact-patch batch`
//!
//! Lines go to the workers through a short queue; the writer takes the answers in the order of the lines. Memory
//! holds the lines of that window and nothing else.

use std::fs::File;
use std::io::{self, BufRead, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use clap::Args;
use serde_json::json;

use super::outputs::outputs;
use super::progress::Progress;
use super::table::TableOptions;
use super::voice::Voice;
use super::{Failure, checked_threads};
use crate::clock::Deadline;
use crate::error::InputError;
use crate::problem::Settings;
use crate::report;
use crate::scene::settings::checked_seconds;
use crate::scene::{Scene, SolveOptions};

/// Lines in flight for each worker: enough that none waits for a slow neighbour.
const WINDOW: usize = 32;

/// Longest line that is read, in bytes.
const LONGEST: usize = crate::scene::LONGEST as usize;

/// Solve one scene a line from standard input, one result a line on standard output, in order
///
/// A line that is not a scene is answered by {"error": {path, given, allowed}, "line": n} and the rest goes on; blank lines are passed
/// over.
/// With --table FILE.csv --template SCENE each row of a table is a scene, and the table comes back with the answers.
/// Exit code 0 once every line has its answer; with --strict 1 when one of them is not solved.
#[derive(Args)]
pub(super) struct Batch {
    #[command(flatten)]
    options: SolveOptions,
    /// Scenes solved at the same time; by default as many as there are cores
    #[arg(long, visible_alias = "threads", value_name = "N")]
    jobs: Option<usize>,
    /// CPU seconds that each scene may take; those of the scene stand when this is left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Read the files that scenes name from inside this directory only
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// Exit with 1 when a line is wrong or not solved
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    table: TableOptions,
    /// Where to write the results, line by line; - is standard output
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
}

/// Cells along the longer side of any scene of a batch: about 1.1 GB each, where one alone may take 17.
const MOST_CELLS: usize = 4096;

/// A line, its number from 1, and where its answer is waited for.
type Job = (usize, Result<Vec<u8>, InputError>, SyncSender<Answer>);

/// A whole line of output, and whether the scene was solved.
type Answer = (Vec<u8>, bool);

impl Batch {
    pub(super) fn run(&self, voice: Voice) -> Result<ExitCode, Failure> {
        // Wrong options are wrong for every line: say so once.
        self.options.apply("--", &mut Default::default()).map_err(|e| Failure::wrong("arguments", &e))?;
        let jobs = checked_threads("--jobs", self.jobs)?;
        let wrong = |e: &InputError| Failure::wrong("arguments", e);
        if let Some(seconds) = self.seconds {
            checked_seconds("--seconds", seconds).map_err(|e| wrong(&e))?;
        }
        if let Some(root) = self.root.as_deref().filter(|root| !root.is_dir()) {
            return Err(wrong(&InputError::new("--root", root.display(), "a directory")));
        }
        // The file that standard input is read from, where it is one.
        let read = self.table.files().into_iter().flatten().map(PathBuf::from);
        let read: Vec<PathBuf> = read.chain([PathBuf::from("/dev/stdin")]).collect();
        outputs([("--output", Some(self.output.as_path()))], &read)?;
        let to: Box<dyn Write + Send> = match self.output.as_os_str().to_str() {
            Some("-") => Box::new(io::stdout()),
            _ => Box::new(File::create(&self.output).map_err(|e| Failure::unwritable(&self.output, &e))?),
        };
        if let Some(files) = self.table.files() {
            return self.rows(files, jobs, to);
        }
        let (to_workers, work) = sync_channel::<Job>(jobs);
        let (to_writer, ordered) = sync_channel::<Receiver<Answer>>(WINDOW * jobs);
        let work = Mutex::new(work);
        let (read, written) = std::thread::scope(|scope| {
            for _ in 0..jobs {
                scope.spawn(|| self.work(&work));
            }
            let progress = voice.progress("the first scenes");
            let writer = scope.spawn(move || write_in_order(to, &ordered, progress));
            let read = read_lines(&mut io::stdin().lock(), &to_workers, &to_writer);
            // Without senders the workers and the writer come to their end.
            drop((to_workers, to_writer));
            (read, writer.join().unwrap_or_else(|_| Err(io::Error::other("the writer stopped"))))
        });
        read.map_err(|e| Failure::Message(format!("standard input: cannot be read: {e}")))?;
        let all_solved = written?;
        Ok(if self.strict && !all_solved { ExitCode::from(1) } else { ExitCode::SUCCESS })
    }

    /// The rows of a table.
    fn rows(&self, files: [&Path; 2], jobs: usize, mut to: Box<dyn Write + Send>) -> Result<ExitCode, Failure> {
        let (options, seconds) = (self.options.clone(), self.seconds);
        let adjust = move |settings: &mut Settings| {
            options.apply("--", settings)?;
            settings.seconds = seconds.unwrap_or(settings.seconds);
            few_cells(settings)
        };
        let all_solved = self.table.answer(files, self.root.as_deref(), adjust, jobs, &mut to)?;
        Ok(if self.strict && !all_solved { ExitCode::from(1) } else { ExitCode::SUCCESS })
    }

    /// Answers lines until there are none.
    fn work(&self, work: &Mutex<Receiver<Job>>) {
        loop {
            let job = match work.lock() {
                Ok(work) => work.recv(),
                Err(_) => return,
            };
            let Ok((number, line, reply)) = job else { return };
            // A fault in one scene must not take the others with it.
            let answered = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| self.answer(number, line)));
            let fault = || {
                let error = InputError::new("$", "a scene that stopped the solver", "please report this scene");
                (error_line(number, &error), false)
            };
            // The writer may be gone: nobody reads any more.
            let _ = reply.send(answered.unwrap_or_else(|_| fault()));
        }
    }

    fn answer(&self, number: usize, line: Result<Vec<u8>, InputError>) -> Answer {
        let scene = line.and_then(|line| {
            let deadline = self.seconds.map_or(Deadline::NEVER, |seconds| Deadline::after(seconds, 1));
            let mut scene = match &self.root {
                Some(root) => Scene::from_json_within(&line, root)?,
                None => Scene::from_json(&line)?,
            };
            self.options.apply("--", &mut scene.settings)?;
            let settings = &mut scene.settings;
            settings.deadline = deadline;
            if self.seconds == Some(0.0) {
                settings.seconds = 0.0;
            }
            few_cells(settings)?;
            Ok(scene)
        });
        let scene = match scene {
            Ok(scene) => scene,
            Err(error) => return (error_line(number, &error), false),
        };
        let steps = crate::solve(&scene.contact, &scene.settings);
        let mut text = match serde_json::to_vec(&report::json(&scene, &steps)) {
            Ok(text) => text,
            Err(e) => {
                let error = InputError::new("$", e, "a result that can be written");
                return (error_line(number, &error), false);
            }
        };
        text.push(b'\n');
        (text, steps.iter().all(Result::is_ok))
    }
}

/// # Errors
/// When a scene of a batch asks for more cells than it may.
fn few_cells(settings: &Settings) -> Result<(), InputError> {
    match settings.cells {
        Some(cells) if cells > MOST_CELLS => {
            let allowed = format!("at most {MOST_CELLS} in a batch");
            Err(InputError::new("solve.cells", cells, allowed))
        }
        _ => Ok(()),
    }
}

fn error_line(number: usize, error: &InputError) -> Vec<u8> {
    let InputError { path, given, allowed } = error;
    format!("{}\n", json!({"error": {"path": path, "given": given, "allowed": allowed}, "line": number})).into_bytes()
}

/// Hands out lines until there are no more, or nobody takes them.
fn read_lines(
    from: &mut impl BufRead,
    to_workers: &SyncSender<Job>,
    to_writer: &SyncSender<Receiver<Answer>>,
) -> io::Result<()> {
    for number in 1.. {
        let Some(line) = read_line(from)? else { break };
        // Nothing was asked; the line is counted.
        if line.as_ref().is_ok_and(|line| line.iter().all(u8::is_ascii_whitespace)) {
            continue;
        }
        let (reply, answer) = sync_channel(1);
        if to_writer.send(answer).is_err() || to_workers.send((number, line, reply)).is_err() {
            break;
        }
    }
    Ok(())
}

/// The next line without its end; `None` after the last. Too long a line is read past, not kept.
fn read_line(from: &mut impl BufRead) -> io::Result<Option<Result<Vec<u8>, InputError>>> {
    let mut line = Vec::new();
    let (mut seen, mut length) = (false, 0usize);
    loop {
        let piece = from.fill_buf()?;
        if piece.is_empty() {
            break;
        }
        seen = true;
        let end = piece.iter().position(|&b| b == b'\n');
        let part = &piece[..end.unwrap_or(piece.len())];
        length += part.len();
        if length <= LONGEST {
            line.extend_from_slice(part);
        } else {
            line = Vec::new();
        }
        let taken = part.len() + usize::from(end.is_some());
        from.consume(taken);
        if end.is_some() {
            break;
        }
    }
    if !seen {
        return Ok(None);
    }
    if length > LONGEST {
        return Ok(Some(Err(InputError::new("$", format!("a line of {length} bytes"), format!("at most {LONGEST}")))));
    }
    Ok(Some(Ok(line)))
}

/// Writes each answer as one whole line; says whether all were solved.
fn write_in_order(
    mut to: Box<dyn Write + Send>,
    ordered: &Receiver<Receiver<Answer>>,
    mut progress: Progress,
) -> io::Result<bool> {
    let mut all_solved = true;
    for (count, answer) in ordered.iter().enumerate() {
        progress.say(&format!("scenes so far: {count}"));
        let Ok((line, solved)) = answer.recv() else { continue };
        all_solved &= solved;
        // One call a line, straight through: killed between two calls, only whole lines are left.
        to.write_all(&line)?;
        to.flush()?;
    }
    Ok(all_solved)
}
