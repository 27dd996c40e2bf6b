//! `contact-patch compare`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::outputs::outputs;
use super::voice::Voice;
use super::{Failure, TimedThreads, inputs, scene};
use crate::compare::{Plan, compare};
use crate::error::InputError;
use crate::plot::{Format, error_against_time};
use crate::report::{comparison_csv, comparison_json, comparison_table};
use crate::scene::settings::checked_cells;

/// Run every method on a scene and tabulate error and cost
#[derive(Args)]
pub(super) struct Compare {
    /// Scene file; - reads standard input. Of several states of loading the last is compared
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Cells along the longer side for fft, separated by commas
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    cells: Vec<usize>,
    /// Cells along the longer side for qp, separated by commas
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    qp_cells: Vec<usize>,
    /// Cells along the longer side of the grid that brackets the force; 0 for no bracket
    #[arg(long, value_name = "N", default_value_t = 64)]
    bracket_cells: usize,
    /// Timed runs of each; the median stands
    #[arg(long, value_name = "N", default_value_t = 3)]
    repeats: usize,
    #[command(flatten)]
    threads: TimedThreads,
    /// Write the comparison as JSON; - prints it alone
    #[arg(short = 'o', long, visible_alias = "output", value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a line a run as CSV; - prints it alone
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw error against run time
    #[arg(long, value_name = "FILE.svg|.png")]
    plot: Option<PathBuf>,
}

impl Compare {
    pub(super) fn run(&self, voice: Voice) -> Result<ExitCode, Failure> {
        let wrong = |e: &InputError| Failure::wrong("arguments", e);
        let scene = scene(&self.scene)?;
        let mut plan = Plan::new(scene.settings);
        plan.settings.threads = self.threads.checked()?;
        plan.repeats = self.repeats.max(1);
        plan.heap = Some(super::heap::peak_of);
        let chosen = |name: &str, given: &[usize]| {
            given.iter().map(|&n| checked_cells(name, n)).collect::<Result<Vec<_>, _>>().map_err(|e| wrong(&e))
        };
        if !self.cells.is_empty() {
            plan.fft_cells = chosen("--cells", &self.cells)?;
        }
        if !self.qp_cells.is_empty() {
            plan.qp_cells = chosen("--qp-cells", &self.qp_cells)?;
        }
        plan.bracket_cells = match self.bracket_cells {
            0 => None,
            cells => Some(checked_cells("--bracket-cells", cells).map_err(|e| wrong(&e))?),
        };
        let format = self.plot.as_deref().map(Format::of).transpose().map_err(|e| wrong(&e.within("--plot")))?;
        let paths = [&self.json, &self.csv, &self.plot].map(|path| path.as_deref());
        let options = [("--json", paths[0]), ("--csv", paths[1]), ("--plot", paths[2])];
        let targets = outputs(options, &inputs(&self.scene, &scene))?;
        let progress = voice.progress("every method, at several resolutions");
        let comparison = compare(&scene.contact, &plan);
        drop(progress);
        let json = comparison_json(&scene, &comparison).map_err(|e| Failure::Message(e.to_string()))?;
        let json = voice.json_text(json + "\n")?;
        let picture = match format {
            Some(format) if comparison.reference.is_some() => {
                error_against_time(scene.name.as_deref().unwrap_or("error against run time"), &comparison, format)
                    .map_err(|e| Failure::Message(e.to_string()))?
            }
            _ => Vec::new(),
        };
        for (target, bytes) in
            targets.iter().zip([json.into_bytes(), comparison_csv(&comparison).into_bytes(), picture])
        {
            if let Some((path, target)) = target.as_ref().filter(|_| !bytes.is_empty()) {
                target.write(|to| to.write_all(&bytes)).map_err(|e| Failure::unwritable(path, &e))?;
            }
        }
        if ![&self.json, &self.csv].into_iter().flatten().any(|p| p.as_os_str() == "-") {
            let table = comparison_table(scene.name.as_deref(), &comparison);
            voice.table(&table, scene.name.is_some())?;
        }
        Ok(if comparison.reference.is_some() { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}
