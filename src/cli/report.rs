//! `contact-patch report`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::outputs::outputs;
use super::voice::Voice;
use super::{Failure, TimedThreads, inputs, scene};
use crate::clock::date;
use crate::compare::Plan;
use crate::report::{self, Parts, Provenance};
use crate::scene::SolveOptions;

/// Write all there is to say about a scene as one page for a browser or a printer
///
/// The page holds the answers, pictures that can be asked for numbers, the plan, the cost and the scene. It needs no network and no other
/// file. Of the parts that --with names, those that fit into three times the cost of the answer are there without asking; what is
/// not is listed on it.
#[derive(Args)]
pub(super) struct Report {
    /// Scene file; - reads standard input. Of several states of loading the last is shown in detail
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Where to write the page; - is standard output
    #[arg(short, long, value_name = "FILE.html")]
    output: PathBuf,
    #[command(flatten)]
    options: SolveOptions,
    /// Parts to add, whatever they cost: separated by commas
    #[arg(long, value_enum, value_name = "PARTS", value_delimiter = ',')]
    with: Vec<PartName>,
    /// Who made the page; by default whoever is logged in (USER)
    #[arg(long, value_name = "NAME")]
    author: Option<String>,
    #[command(flatten)]
    threads: TimedThreads,
}

/// Parts of a report that may cost more than the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PartName {
    /// The patch by every method that gives its boundary
    Boundaries,
    /// Force against depth
    Curve,
    /// Every method side by side, with its error and run time
    Methods,
    /// Bounds of the force on several grids
    Bounds,
    /// All of these
    All,
}

impl Report {
    fn parts(&self) -> Parts {
        let has = |part| self.with.contains(&part) || self.with.contains(&PartName::All);
        Parts {
            boundaries: has(PartName::Boundaries),
            curve: has(PartName::Curve),
            methods: has(PartName::Methods),
            bounds: has(PartName::Bounds),
        }
    }

    /// Who, when, and the command as it was given.
    fn provenance(&self) -> Provenance {
        let user = || ["USER", "USERNAME"].into_iter().find_map(|name| std::env::var(name).ok());
        let quoted = |word: String| {
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
            if !word.is_empty() && word.chars().all(plain) {
                word
            } else {
                format!("'{}'", word.replace('\'', "'\\''"))
            }
        };
        // The program may have been started by another, with words of its own before.
        let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
        let words = words.skip_while(|word| word != "report").map(quoted);
        Provenance {
            author: self.author.clone().or_else(user).filter(|name| !name.is_empty()),
            written: date(),
            command: Some(["contact-patch".to_owned()].into_iter().chain(words).collect::<Vec<_>>().join(" ")),
        }
    }

    pub(super) fn run(&self, voice: Voice) -> Result<ExitCode, Failure> {
        let mut scene = scene(&self.scene)?;
        self.options.apply("--", &mut scene.settings).map_err(|e| Failure::wrong("arguments", &e))?;
        scene.settings.threads = self.threads.checked()?;
        let unwritable = |e: &std::io::Error| Failure::unwritable(&self.output, e);
        let [output] = outputs([("--output", Some(self.output.as_path()))], &inputs(&self.scene, &scene))?;
        // Finer grids take longer than a reader of a report will wait, and show nothing more.
        let runs = Plan {
            fft_cells: vec![16, 32, 64, 128, 256],
            heap: Some(super::heap::peak_of),
            ..Plan::new(scene.settings)
        };
        let mut progress = voice.progress("the answer");
        let page = report::page_of(&scene, &runs, self.parts(), &self.provenance(), &mut |what| progress.say(what));
        drop(progress);
        if let Some((_, target)) = output {
            target.write(|to| to.write_all(page.html.as_bytes())).map_err(|e| unwritable(&e))?;
        }
        Ok(if page.solved { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}
