//! `contact-patch schema`

use std::process::ExitCode;

use clap::Args;

use super::Failure;
use super::outputs::MainOutput;

/// Print the JSON Schema of a scene
#[derive(Args)]
pub(super) struct SchemaCommand {
    #[command(flatten)]
    output: MainOutput,
}

impl SchemaCommand {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        self.output.target(&[])?.write(|to| to.write_all(crate::scene::schema().as_bytes()))?;
        Ok(ExitCode::SUCCESS)
    }
}
