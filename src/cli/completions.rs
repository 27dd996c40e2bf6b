//! `contact-patch completions`

use std::process::ExitCode;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Arguments, Failure};
use crate::report::write::Target;

/// Print the completions of a shell
#[derive(Args)]
pub(super) struct Completions {
    /// Which shell
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

impl Completions {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut Arguments::command(), "contact-patch", &mut text);
        Target::Stdout.write(|to| to.write_all(&text))?;
        Ok(ExitCode::SUCCESS)
    }
}
