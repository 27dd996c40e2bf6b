//! Time: the only module that reads a clock.
//!
//! Limits count CPU time, so that a busy machine does not change an answer. With one thread that of the calling thread
//! counts, with several that of the process. On systems other than Unix elapsed time stands for both; on targets without a
//! clock nothing is measured and no limit is ever reached.

use crate::error::{Unsolved, Verdict};

/// CPU seconds that one state of loading may take unless said.
pub(crate) const DEFAULT_SECONDS: f64 = 60.0;

/// The moment at which a solve has to stop. Solvers ask for it between products, grids and steps.
///
/// With one thread it is bound to the thread that made it: another thread that asks reads its own clock.
///
/// ```
/// use contact_patch::Deadline;
/// assert!(!Deadline::NEVER.has_passed());
/// assert!(!Deadline::after(0.0, 1).has_passed());
/// let deadline = Deadline::after(1e-9, 1);
/// // Asking takes longer than that.
/// assert!((0..1_000_000).any(|_| deadline.has_passed()));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deadline {
    /// The allowance, CPU seconds; 0: no limit.
    seconds: f64,
    clock: Clock,
    /// Reading of the clock at which it ends.
    end: f64,
}

/// Whose time is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Clock {
    Thread,
    Process,
}

impl Deadline {
    /// No limit.
    pub const NEVER: Self = Self { seconds: 0.0, clock: Clock::Thread, end: f64::INFINITY };

    /// So many CPU seconds from now, on `threads` threads (1: the time of this thread counts; else that of the process).
    /// 0 and numbers that are not greater: no limit.
    #[must_use]
    pub fn after(seconds: f64, threads: usize) -> Self {
        let clock = if threads == 1 { Clock::Thread } else { Clock::Process };
        match clock.seconds() {
            Some(now) if seconds > 0.0 => Self { seconds, clock, end: now + seconds },
            _ => Self::NEVER,
        }
    }

    /// Whether the time is used up.
    #[must_use]
    pub fn has_passed(&self) -> bool {
        self.end < f64::INFINITY && self.clock.seconds().is_some_and(|now| now >= self.end)
    }

    /// CPU seconds that are left; infinite without a limit.
    #[must_use]
    pub fn remaining(&self) -> f64 {
        match self.clock.seconds() {
            Some(now) if self.end < f64::INFINITY => (self.end - now).max(0.0),
            _ => f64::INFINITY,
        }
    }

    /// # Errors
    /// [`Verdict::TimeLimit`] once the time is used up.
    pub fn check(&self) -> Result<(), Unsolved> {
        if !self.has_passed() {
            return Ok(());
        }
        let reason = format!("the time allowed, {} CPU seconds, is used up", self.seconds);
        Err(Unsolved::new(Verdict::TimeLimit, reason))
    }
}

impl Default for Deadline {
    fn default() -> Self {
        Self::NEVER
    }
}

impl Clock {
    /// CPU seconds so far; `None` on a target without a clock.
    #[cfg(unix)]
    fn seconds(self) -> Option<f64> {
        use rustix::time::{ClockId, clock_gettime};
        let time = clock_gettime(match self {
            Self::Thread => ClockId::ThreadCPUTime,
            Self::Process => ClockId::ProcessCPUTime,
        });
        Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
    }

    /// Elapsed seconds; `None` on a target without a clock.
    #[cfg(not(unix))]
    fn seconds(self) -> Option<f64> {
        elapsed::since_first_call()
    }
}

/// Elapsed seconds since a moment; 0 on a target without a clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stopwatch(Option<f64>);

impl Stopwatch {
    pub fn start() -> Self {
        Self(elapsed::since_first_call())
    }

    pub fn seconds(self) -> f64 {
        self.0.zip(elapsed::since_first_call()).map_or(0.0, |(start, now)| now - start)
    }
}

/// Elapsed time.
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
mod elapsed {
    use std::sync::OnceLock;
    use std::time::Instant;

    pub fn since_first_call() -> Option<f64> {
        static FIRST: OnceLock<Instant> = OnceLock::new();
        Some(FIRST.get_or_init(Instant::now).elapsed().as_secs_f64())
    }
}

/// A target without a clock.
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
mod elapsed {
    pub fn since_first_call() -> Option<f64> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cpu_time_counts_and_waiting_does_not() {
        let deadline = Deadline::after(0.05, 1);
        std::thread::sleep(std::time::Duration::from_millis(80));
        assert!(!deadline.has_passed() || cfg!(not(unix)));
        let watch = Stopwatch::start();
        while !deadline.has_passed() {
            assert!(watch.seconds() < 60.0);
        }
        let error = deadline.check().unwrap_err();
        assert_eq!(error.verdict, Verdict::TimeLimit);
        assert!(error.reason.contains("0.05 CPU seconds"), "{error}");
    }

    #[test]
    fn a_deadline_of_nothing_is_none() {
        for seconds in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!Deadline::after(seconds, 2).has_passed());
            assert_eq!(Deadline::after(seconds, 1).check(), Ok(()));
        }
    }
}
