//! CPU time of a call, which other work on the machine does not lengthen.

use std::time::Instant;

/// CPU seconds of this process so far; where they cannot be read, seconds.
fn cpu(start: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    match text.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok()) {
        Some(ns) => 1e-9 * ns,
        None => start.elapsed().as_secs_f64(),
    }
}

/// CPU seconds of a call: least mean of so many batches of at least `long` seconds, after one call that warms up.
/// (The clock ticks in milliseconds: one call would be too short.)
pub fn seconds(batches: usize, long: f64, mut call: impl FnMut()) -> f64 {
    call();
    let clock = Instant::now();
    let mut batch = || {
        let (before, mut calls) = (cpu(clock), 0.0);
        loop {
            call();
            calls += 1.0;
            let spent = cpu(clock) - before;
            if spent > long {
                return spent / calls;
            }
        }
    };
    (0..batches).map(|_| batch()).fold(f64::INFINITY, f64::min)
}
