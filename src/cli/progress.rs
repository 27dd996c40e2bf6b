//! What is going on, on stderr: only on a terminal, only for work longer than a second.

use std::io::IsTerminal;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work before anything is shown.
const SILENCE: Duration = Duration::from_secs(1);

/// How often the line moves.
const STEP: Duration = Duration::from_millis(120);

/// A line that is there while work goes on, and then is not.
pub(super) struct Progress {
    bar: ProgressBar,
    /// Dropped when the work is done: ends the wait for the first second.
    _working: Option<Sender<()>>,
}

impl Progress {
    /// For work that is called `what`; `quiet`, and where nobody sees it, nothing is shown.
    pub fn new(what: &str, quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{spinner} {elapsed} {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        bar.set_message(what.to_owned());
        if quiet || !std::io::stderr().is_terminal() {
            return Self { bar, _working: None };
        }
        let (working, done) = channel::<()>();
        let shown = bar.clone();
        std::thread::spawn(move || {
            if done.recv_timeout(SILENCE) == Err(RecvTimeoutError::Timeout) {
                shown.set_draw_target(ProgressDrawTarget::stderr());
                shown.enable_steady_tick(STEP);
            }
        });
        Self { bar, _working: Some(working) }
    }

    /// Says what begins now.
    pub fn say(&mut self, what: &str) {
        self.bar.set_message(what.to_owned());
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
