//! `contact-patch plan`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::{Failure, Overrides, scene};
use crate::report::write::Target;

/// Say what would run, why, and what is left out, without running it
#[derive(Args)]
pub(super) struct Plan {
    /// Scene file; - reads standard input
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
}

impl Plan {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        let mut scene = scene(&self.scene)?;
        self.overrides.apply(&mut scene.settings).map_err(|e| Failure::wrong("arguments", &e))?;
        match crate::plan(&scene.contact, &scene.settings) {
            Ok(plan) => {
                Target::Stdout.write(|to| write!(to, "{plan}"))?;
                Ok(ExitCode::SUCCESS)
            }
            Err(unsolved) => {
                Target::Stdout.write(|to| writeln!(to, "method: none\n  {unsolved}"))?;
                Ok(ExitCode::from(1))
            }
        }
    }
}
