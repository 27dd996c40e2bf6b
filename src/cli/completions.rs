//! `contact-patch completions`

use std::process::ExitCode;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::outputs::MainOutput;
use super::{Arguments, Failure};

/// Print the completions of a shell
#[derive(Args)]
pub(super) struct Completions {
    /// Which shell
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
    #[command(flatten)]
    output: MainOutput,
}

impl Completions {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut Arguments::command(), "contact-patch", &mut text);
        self.output.target(&[])?.write(|to| to.write_all(&text))?;
        Ok(ExitCode::SUCCESS)
    }
}
