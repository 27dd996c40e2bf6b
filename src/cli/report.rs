//! `contact-patch report`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::outputs::outputs;
use super::progress::Progress;
use super::{Failure, Overrides, checked_threads, inputs, scene};
use crate::compare::Plan;
use crate::report;

/// Write all there is to say about a scene as one page for a browser or a printer
///
/// The page holds the problem, the plan, the answers, pictures, every method with its error and cost, and bounds of the
/// force. It needs no network and no other file.
#[derive(Args)]
pub(super) struct Report {
    /// Scene file; - reads standard input. Of several states of loading the last is shown in detail
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Where to write the page; - is standard output
    #[arg(short, long, value_name = "FILE.html")]
    output: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    /// Threads to use; one by default, so that the methods can be compared
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: usize,
}

impl Report {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        let mut scene = scene(&self.scene)?;
        self.overrides.apply(&mut scene.settings).map_err(|e| Failure::wrong("arguments", &e))?;
        scene.settings.threads = checked_threads("--threads", Some(self.threads))?;
        let unwritable = |e: &std::io::Error| Failure::unwritable(&self.output, e);
        let [output] = outputs([("--output", Some(self.output.as_path()))], &inputs(&self.scene, &scene))?;
        // Finer grids take longer than a reader of a report will wait, and show nothing more.
        let runs = Plan {
            fft_cells: vec![16, 32, 64, 128, 256],
            heap: Some(super::heap::peak_of),
            ..Plan::new(scene.settings)
        };
        let mut progress = Progress::new();
        let page = report::page(&scene, &runs, &mut |what| progress.say(what));
        drop(progress);
        if let Some((_, target)) = output {
            target.write(|to| to.write_all(page.html.as_bytes())).map_err(|e| unwritable(&e))?;
        }
        Ok(if page.solved { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}
