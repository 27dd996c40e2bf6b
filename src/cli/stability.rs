//! `contact-patch stability`

use std::process::ExitCode;

use clap::Args;

use super::outputs::MainOutput;
use super::voice::Voice;
use super::{Failure, TimedThreads};
use crate::clock::Stopwatch;
use crate::error::InputError;
use crate::report::table::{aligned, figure};
use crate::stability::{Check, cases};

/// Run stiff and extreme cases and tabulate them; exit code 1 if any misses its bound
#[derive(Args)]
pub(super) struct Stability {
    /// Only the cases whose name holds this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    #[command(flatten)]
    threads: TimedThreads,
    #[command(flatten)]
    output: MainOutput,
}

impl Stability {
    pub(super) fn run(&self, voice: Voice) -> Result<ExitCode, Failure> {
        let threads = self.threads.checked()?;
        let output = self.output.target(&[])?;
        let heads =
            ["case", "method", "at", "verdict", "force", "error", "bound", "residual", "condition", "seconds", ""];
        let mut rows = vec![heads.map(str::to_owned)];
        let (mut run, mut missed) = (0, Vec::new());
        let started = Stopwatch::start();
        let all = cases().map_err(|e| Failure::wrong("stability", &e))?;
        let mut progress = voice.progress("stiff and extreme cases");
        let chosen = all.iter().filter(|c| self.only.as_ref().is_none_or(|text| c.name.contains(text.as_str())));
        for case in chosen {
            let mut name = case.name.as_str();
            progress.say(name);
            for check in case.run(threads) {
                run += 1;
                if !check.passed {
                    let why = match &check.outcome {
                        Ok(solution) => format!(": {} patches", solution.patch.regions),
                        Err(e) => format!(": {}", e.reason),
                    };
                    missed.push(format!("missed: {}, {}{why}", case.name, check.settings.method.name()));
                }
                rows.push(row(name, &check));
                name = "";
            }
        }
        drop(progress);
        if run == 0 {
            let given = self.only.as_deref().unwrap_or_default();
            let error = InputError::new("--only", format!("{given:?}"), "text that the name of a case holds");
            return Err(Failure::wrong("arguments", &error));
        }
        let mut lines = aligned(&rows);
        lines.extend(missed.iter().cloned());
        lines.push(format!("{run} runs, {} missed, {:.1} s\n", missed.len(), started.seconds()));
        output.write(|to| to.write_all(lines.join("\n").as_bytes()))?;
        Ok(if missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}

fn row(name: &str, check: &Check) -> [String; 11] {
    let small = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.1e}"));
    let solution = check.outcome.as_ref().ok();
    [
        name.to_owned(),
        check.settings.method.name().to_owned(),
        check.settings.cells.map_or(String::new(), |n| format!("{n} cells")),
        check.outcome.as_ref().err().map_or("solved", |e| e.verdict.word()).to_owned(),
        solution.map_or("-".to_owned(), |s| figure(s.force)),
        small(check.error),
        small(Some(check.bound)),
        small(check.residual),
        small(check.condition),
        solution.map_or("-".to_owned(), |s| format!("{:.1e}", s.cost.seconds)),
        if check.passed { String::new() } else { "MISSED".to_owned() },
    ]
}
