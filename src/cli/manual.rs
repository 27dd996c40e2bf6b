//! `contact-patch man`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, CommandFactory};

use super::outputs::MainOutput;
use super::{Arguments, Failure};
use crate::error::InputError;

/// Print the manual page (roff): contact-patch man | man -l -
///
/// Without a command that of the program; with --directory one for it and one for every command.
#[derive(Args)]
pub(super) struct Manual {
    /// The command whose page is printed
    #[arg(value_name = "COMMAND")]
    command: Option<String>,
    /// Write all pages into this directory, contact-patch.1, contact-patch-solve.1 and so on
    #[arg(long, value_name = "DIR", conflicts_with_all = ["command", "output"])]
    directory: Option<PathBuf>,
    #[command(flatten)]
    output: MainOutput,
}

impl Manual {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        let mut program = Arguments::command();
        // Names of sub-commands are whole ones, and global options are theirs.
        program.build();
        if let Some(directory) = &self.directory {
            clap_mangen::generate_to(program, directory).map_err(|e| Failure::unwritable(directory, &e))?;
            return Ok(ExitCode::SUCCESS);
        }
        let page = match self.command.as_deref() {
            None => program,
            Some(name) => program.find_subcommand(name).cloned().ok_or_else(|| {
                let names: Vec<&str> = program.get_subcommands().map(clap::Command::get_name).collect();
                let error = InputError::new("COMMAND", format!("{name:?}"), names.join(", "));
                Failure::wrong("arguments", &error)
            })?,
        };
        let mut text = Vec::new();
        clap_mangen::Man::new(page).render(&mut text)?;
        self.output.target(&[])?.write(|to| to.write_all(&text))?;
        Ok(ExitCode::SUCCESS)
    }
}
