//! Work without Python's lock: interrupted by Ctrl-C, and panics kept inside.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use contact_patch::Interrupt;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// How often signals are looked for.
const LOOK: Duration = Duration::from_millis(50);

/// Stack of the thread that works: that of a main thread.
const STACK: usize = 8 << 20;

/// What ends a piece of work early.
#[derive(Clone, Default)]
pub(crate) struct Watch(Arc<Inner>);

#[derive(Default)]
struct Inner {
    interrupt: Interrupt,
    /// What a function of the user's raised first.
    raised: Mutex<Option<PyErr>>,
}

impl Watch {
    pub fn is_over(&self) -> bool {
        self.0.interrupt.is_set()
    }

    /// Ends the work with this exception, unless it ended before.
    pub fn raise(&self, error: PyErr) {
        self.0.raised.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        self.0.interrupt.set();
    }

    /// # Errors
    /// What was raised.
    pub fn check(&self) -> PyResult<()> {
        self.0.raised.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }
}

/// # Errors
/// RuntimeError in place of a panic.
pub(crate) fn protected<T>(work: impl FnOnce() -> T) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| fault())
}

fn fault() -> PyErr {
    PyRuntimeError::new_err("this scene stopped the solver: a fault of contact-patch, please report it")
}

/// Runs `work` on another thread, while this one waits for it and looks for signals.
///
/// # Errors
/// What a signal raised (KeyboardInterrupt), what a function of the user's raised, RuntimeError in place of a panic.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    watch: &Watch,
    work: impl FnOnce(&Interrupt) -> T + Send,
) -> PyResult<T> {
    let answer = py.detach(|| {
        std::thread::scope(|scope| {
            let (done, is_done) = sync_channel::<()>(1);
            let inner = watch.0.clone();
            let worker = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, move || {
                // Dropped when the work ends, however it ends.
                let _done = done;
                catch_unwind(AssertUnwindSafe(|| work(&inner.interrupt)))
            });
            let worker = worker.map_err(|e| PyRuntimeError::new_err(format!("no thread to work on: {e}")))?;
            while let Err(RecvTimeoutError::Timeout) = is_done.recv_timeout(LOOK) {
                if let Err(signal) = Python::attach(|py| py.check_signals()) {
                    watch.raise(signal);
                }
            }
            match worker.join() {
                Ok(Ok(answer)) => Ok(answer),
                _ => Err(fault()),
            }
        })
    });
    watch.check()?;
    answer
}
