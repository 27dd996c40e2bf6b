//! How a command speaks: tables on standard output, remarks on standard error, with colour on a terminal.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};

use clap::Args;
use serde::Serialize;

use super::Failure;
use super::progress::Progress;
use crate::report::write::Target;
use crate::scene::Json;

/// Options of every command.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(super) struct Voice {
    /// Print no table, no remarks and no progress: files, the exit code and what is wrong are left
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Indent JSON
    #[arg(long, global = true)]
    json_pretty: bool,
}

/// Bold, dim, red, yellow; and the end of each.
const BOLD: &str = "\x1b[1m";
const DIM: &str = "\x1b[2m";
const RED: &str = "\x1b[31m";
const YELLOW: &str = "\x1b[33m";
const PLAIN: &str = "\x1b[0m";

impl Voice {
    /// A table for people on standard output.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn table(self, text: &str, named: bool) -> Result<(), Failure> {
        if self.quiet {
            return Ok(());
        }
        let coloured = has_colour();
        let text = if coloured { in_colour(text, named) } else { text.to_owned() };
        Ok(Target::Stdout.write(|to| to.write_all(text.as_bytes()))?)
    }

    /// A line on standard error; a closed one does not make an answer worse.
    pub fn remark(self, text: &str) {
        if !self.quiet {
            let _ = writeln!(io::stderr().lock(), "{text}");
        }
    }

    /// What is going on, for work that takes longer than a second.
    pub fn progress(self, what: &str) -> Progress {
        Progress::new(what, self.quiet)
    }

    /// A JSON document with the end of its line.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn json(self, to: &mut dyn Write, document: &impl Serialize) -> io::Result<()> {
        if self.json_pretty {
            serde_json::to_writer_pretty(&mut *to, document)?;
        } else {
            serde_json::to_writer(&mut *to, document)?;
        }
        to.write_all(b"\n")
    }

    /// A text that is JSON, indented where that is asked for.
    ///
    /// # Errors
    /// When it is no JSON.
    pub fn json_text(self, text: String) -> Result<String, Failure> {
        if !self.json_pretty {
            return Ok(text);
        }
        let failed = |e: &dyn Display| Failure::Message(e.to_string());
        let document = Json::parse(text.as_bytes()).map_err(|e| failed(&e))?;
        Ok(serde_json::to_string_pretty(&document).map_err(|e| failed(&e))? + "\n")
    }
}

/// Whether standard output is a terminal that takes colours (no-color.org, bixense.com/clicolors).
fn has_colour() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if set("NO_COLOR") {
        return false;
    }
    if std::env::var_os("CLICOLOR_FORCE").is_some_and(|value| value != "0" && !value.is_empty()) {
        return true;
    }
    io::stdout().is_terminal() && std::env::var_os("TERM").is_some_and(|term| term != "dumb")
}

/// A table with its title in bold, verdicts in red, remarks in yellow, and what was left out pale.
fn in_colour(text: &str, named: bool) -> String {
    let lines = text.lines().enumerate().map(|(k, line)| {
        let colour = match line.split_whitespace().next() {
            _ if k == 0 && named => BOLD,
            Some("verdict" | "reason") => RED,
            Some("note:" | "hint" | "hint:") => YELLOW,
            Some("left") if line.starts_with("left out:") => DIM,
            _ => return format!("{line}\n"),
        };
        format!("{colour}{line}{PLAIN}\n")
    });
    lines.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_matters_has_a_colour() {
        let text = in_colour("ball\nverdict  unbounded\nforce    1\nnote: so it is\nleft out: much\n", true);
        let plain = ["\x1b[1m", "\x1b[2m", "\x1b[31m", "\x1b[33m", "\x1b[0m"]
            .iter()
            .fold(text.clone(), |t, c| t.replace(c, ""));
        assert_eq!(plain, "ball\nverdict  unbounded\nforce    1\nnote: so it is\nleft out: much\n");
        assert_eq!(text.matches(PLAIN).count(), 4);
        assert!(text.contains("\nforce    1\n") && text.contains("\x1b[31mverdict"));
    }
}
