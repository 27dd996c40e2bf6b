//! Time: the only module that reads a clock.
//!
//! Limits count CPU time, so that a busy machine does not change an answer. With one thread that of the calling thread
//! counts, with several that of the process. On systems other than Unix elapsed time stands for both; on targets without a
//! clock nothing is measured and no limit is ever reached.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

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
    interrupt: Option<Watched>,
}

/// A switch by which another thread ends a solve: that of a user who has waited long enough.
///
/// It counts for a [`Deadline`] as long as it lives.
///
/// ```
/// use contact_patch::{Deadline, Interrupt};
/// let interrupt = Interrupt::new();
/// let deadline = Deadline::NEVER.unless(&interrupt);
/// assert!(!deadline.has_passed());
/// std::thread::scope(|scope| scope.spawn(|| interrupt.set()).join()).unwrap();
/// assert!(deadline.has_passed());
/// ```
#[derive(Debug)]
pub struct Interrupt(Watched);

/// A counter, and its reading at which nothing has happened yet.
#[derive(Debug, Clone, Copy)]
struct Watched {
    counter: &'static AtomicU64,
    quiet: u64,
}

/// Counters that no interrupt uses at present: there are never more than interrupts at one time.
static IDLE: Mutex<Vec<&'static AtomicU64>> = Mutex::new(Vec::new());

impl Interrupt {
    /// One that is not set.
    #[must_use]
    pub fn new() -> Self {
        let idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let counter = idle.unwrap_or_else(|| Box::leak(Box::new(AtomicU64::new(0))));
        Self(Watched { counter, quiet: counter.load(Ordering::Relaxed) })
    }

    /// Ends what was solved [`Deadline::unless`] this is set, and what will be.
    pub fn set(&self) {
        self.0.counter.store(self.0.quiet.wrapping_add(1), Ordering::Relaxed);
    }

    /// Whether it was set.
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.0.is_set()
    }
}

impl Default for Interrupt {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        IDLE.lock().unwrap_or_else(PoisonError::into_inner).push(self.0.counter);
    }
}

impl Watched {
    fn is_set(self) -> bool {
        self.counter.load(Ordering::Relaxed) != self.quiet
    }
}

impl PartialEq for Watched {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.counter, other.counter) && self.quiet == other.quiet
    }
}

/// Whose time is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Clock {
    Thread,
    Process,
}

impl Deadline {
    /// No limit.
    pub const NEVER: Self = Self { seconds: 0.0, clock: Clock::Thread, end: f64::INFINITY, interrupt: None };

    /// So many CPU seconds from now, on `threads` threads (1: the time of this thread counts; else that of the process).
    /// 0 and numbers that are not greater: no limit.
    #[must_use]
    pub fn after(seconds: f64, threads: usize) -> Self {
        let clock = Clock::of(threads);
        match clock.seconds() {
            Some(now) if seconds > 0.0 => Self { seconds, clock, end: now + seconds, interrupt: None },
            _ => Self::NEVER,
        }
    }

    /// The same, and over as soon as the interrupt is set.
    #[must_use]
    pub fn unless(self, interrupt: &Interrupt) -> Self {
        Self { interrupt: Some(interrupt.0), ..self }
    }

    /// The same where it has a limit of time; else so many seconds from now, as [`Deadline::after`], with the same interrupt.
    pub(crate) fn or_after(self, seconds: f64, threads: usize) -> Self {
        if self.end < f64::INFINITY { self } else { self.extended(seconds, threads) }
    }

    /// So many seconds from now, as [`Deadline::after`], with the same interrupt.
    pub(crate) fn extended(self, seconds: f64, threads: usize) -> Self {
        Self { interrupt: self.interrupt, ..Self::after(seconds, threads) }
    }

    fn is_interrupted(&self) -> bool {
        self.interrupt.is_some_and(Watched::is_set)
    }

    /// Whether the time is used up or the interrupt is set.
    #[must_use]
    pub fn has_passed(&self) -> bool {
        self.is_interrupted() || self.end < f64::INFINITY && self.clock.seconds().is_some_and(|now| now >= self.end)
    }

    /// CPU seconds that are left; infinite without a limit.
    #[must_use]
    pub fn remaining(&self) -> f64 {
        if self.is_interrupted() {
            return 0.0;
        }
        match self.clock.seconds() {
            Some(now) if self.end < f64::INFINITY => (self.end - now).max(0.0),
            _ => f64::INFINITY,
        }
    }

    /// # Errors
    /// Once the time is used up, or a user has interrupted.
    pub fn check(&self) -> Result<(), OutOfTime> {
        if !self.has_passed() {
            return Ok(());
        }
        Err(if self.is_interrupted() { OutOfTime::Interrupted } else { OutOfTime::UsedUp { seconds: self.seconds } })
    }
}

/// Why a solve had to stop.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OutOfTime {
    /// The allowance is gone.
    #[error("the time allowed, {seconds} CPU seconds, is used up")]
    UsedUp {
        /// The allowance, CPU seconds.
        seconds: f64,
    },
    /// By an [`Interrupt`].
    #[error("the solve was interrupted")]
    Interrupted,
}

impl Default for Deadline {
    fn default() -> Self {
        Self::NEVER
    }
}

impl Clock {
    /// The clock of work on so many threads.
    fn of(threads: usize) -> Self {
        if threads == 1 { Self::Thread } else { Self::Process }
    }

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

/// CPU seconds since a moment, as a [`Deadline`] counts them; 0 on a target without a clock.
#[cfg(all(feature = "plot", feature = "scene"))]
#[derive(Debug, Clone, Copy)]
pub(crate) struct CpuTime(Clock, Option<f64>);

#[cfg(all(feature = "plot", feature = "scene"))]
impl CpuTime {
    pub fn start(threads: usize) -> Self {
        let clock = Clock::of(threads);
        Self(clock, clock.seconds())
    }

    pub fn seconds(self) -> f64 {
        self.1.zip(self.0.seconds()).map_or(0.0, |(start, now)| now - start)
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

/// The date and time in words, UTC: "2026-11-23 09:30 UTC"; that of `SOURCE_DATE_EPOCH` where it is set, so that what is made can be made
/// again byte by byte.
#[cfg(feature = "cli")]
pub(crate) fn date() -> Option<String> {
    let fixed = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse().ok());
    let now = || std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).ok().map(|since| since.as_secs());
    fixed.or_else(now).map(in_words)
}

/// Seconds since 1970 as a date of the Gregorian calendar (days to civil date after Hinnant 2013).
#[cfg(feature = "cli")]
fn in_words(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    // Years begin in March, eras of 400 years in the year 0.
    let day = days + 719_468;
    let (era, day) = (day / 146_097, day % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let (day, month) = (day - (153 * month + 2) / 5 + 1, if month < 10 { month + 3 } else { month - 9 });
    let year = year + 400 * era + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02} {:02}:{:02} UTC", second / 3600, second / 60 % 60)
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

    #[cfg(feature = "cli")]
    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(in_words(0), "1970-01-01 00:00 UTC");
        assert_eq!(in_words(951_825_599), "2000-02-29 11:59 UTC");
        assert_eq!(in_words(1_795_392_000), "2026-11-23 00:00 UTC");
        assert_eq!(in_words(4_107_542_399), "2100-02-28 23:59 UTC");
    }

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
        assert!(error.to_string().contains("0.05 CPU seconds"), "{error}");
    }

    #[test]
    fn an_interrupt_counts_for_its_own_deadlines() {
        let (one, other) = (Interrupt::new(), Interrupt::new());
        let mine = Deadline::after(1e6, 1).unless(&one);
        let theirs = Deadline::NEVER.unless(&other).or_after(1e6, 2);
        assert!(!mine.has_passed() && !theirs.has_passed() && mine != theirs);
        one.set();
        one.set();
        assert!(mine.has_passed() && mine.remaining() == 0.0 && !theirs.has_passed());
        assert!(mine.check().unwrap_err().to_string().contains("interrupted"));
        // A counter that is used again starts quiet.
        drop(one);
        let next = Interrupt::new();
        assert!(!Deadline::NEVER.unless(&next).has_passed());
        other.set();
        assert!(theirs.has_passed() && !next.is_set());
    }

    #[test]
    fn a_deadline_of_nothing_is_none() {
        for seconds in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!Deadline::after(seconds, 2).has_passed());
            assert_eq!(Deadline::after(seconds, 1).check(), Ok(()));
        }
    }
}
