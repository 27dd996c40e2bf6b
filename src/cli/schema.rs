//! `contact-patch schema`

use std::process::ExitCode;

use clap::Args;

use super::Failure;
use crate::report::write::Target;

/// Print the JSON Schema of a scene
#[derive(Args)]
pub(super) struct SchemaCommand {}

impl SchemaCommand {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        Target::Stdout.write(|to| {
            serde_json::to_writer_pretty(&mut *to, &crate::scene::schema())?;
            to.write_all(b"\n")
        })?;
        Ok(ExitCode::SUCCESS)
    }
}
