//! `contact-patch plan`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::outputs::MainOutput;
use super::{Failure, Threads, inputs, scene};
use crate::scene::SolveOptions;

/// Say what would run, why, and what is left out, without running it
#[derive(Args)]
pub(super) struct Plan {
    /// Scene file; - reads standard input
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    #[command(flatten)]
    options: SolveOptions,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    output: MainOutput,
}

impl Plan {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        let mut scene = scene(&self.scene)?;
        self.options.apply("--", &mut scene.settings).map_err(|e| Failure::wrong("arguments", &e))?;
        scene.settings.threads = self.threads.checked()?;
        let output = self.output.target(&inputs(&self.scene, &scene))?;
        match crate::plan(&scene.contact, &scene.settings) {
            Ok(plan) => {
                output.write(|to| write!(to, "{plan}"))?;
                Ok(ExitCode::SUCCESS)
            }
            Err(unsolved) => {
                output.write(|to| writeln!(to, "method: none\n  {unsolved}"))?;
                Ok(ExitCode::from(1))
            }
        }
    }
}
