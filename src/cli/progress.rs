//! What is going on, on stderr: only on a terminal, only for work longer than a second.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::clock::Stopwatch;

/// Seconds of work before anything is shown.
const SILENCE: f64 = 1.0;

/// A line that is there while work goes on, and then is not.
pub(super) struct Progress {
    bar: ProgressBar,
    started: Stopwatch,
    shown: bool,
}

impl Progress {
    pub fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        bar.set_style(ProgressStyle::default_spinner());
        Self { bar, started: Stopwatch::start(), shown: false }
    }

    /// Says what begins now.
    pub fn say(&mut self, what: &str) {
        if !self.shown && self.started.seconds() > SILENCE && std::io::stderr().is_terminal() {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.shown = true;
        }
        self.bar.set_message(what.to_owned());
        self.bar.tick();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
