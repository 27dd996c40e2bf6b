//! Work that is spread over threads, which start where the first of it is: what is small works on where it is.

/// Does the work for each item, on several threads where there are several; the first error in their order.
pub(crate) fn each<T: Sync, R: Send, E: Send>(
    items: &[T],
    threads: usize,
    work: impl Fn(&T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let threads = threads.min(items.len());
    if cfg!(feature = "parallel") && threads > 1 {
        return with(threads, || each_here(items, &work)).into_iter().collect();
    }
    items.iter().map(work).collect()
}

/// Does work with this many threads for what it spreads by [`each_here`], [`all`] and [`parts`].
pub(crate) fn with<R>(threads: usize, work: impl FnOnce() -> R) -> R {
    #[cfg(feature = "parallel")]
    if threads > 1 {
        return team::with(threads, work);
    }
    let _ = threads;
    work()
}

/// Does the work for each item, on the threads that work was begun with by [`with`] or [`each`]; in their order where it was not.
pub(crate) fn each_here<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        if let Some(all) = team::run(|| items.par_iter().map(&work).collect()) {
            return all;
        }
    }
    items.iter().map(work).collect()
}

/// The same on `threads` of them, until some of it comes to nothing.
///
/// Whoever works alone has to say so: a deadline of one thread reads the clock of the thread that asks.
pub(crate) fn all<T: Sync, R: Send>(
    items: &[T],
    threads: usize,
    work: impl Fn(&T) -> Option<R> + Sync,
) -> Option<Vec<R>> {
    #[cfg(feature = "parallel")]
    if threads > 1 {
        use rayon::prelude::*;
        if let Some(all) = team::run(|| items.par_iter().map(&work).collect()) {
            return all;
        }
    }
    let _ = threads;
    items.iter().map(work).collect()
}

/// Does the work for parts of so many numbers, as [`all`].
pub(crate) fn parts(numbers: &mut [f64], most: usize, threads: usize, work: impl Fn(&mut [f64]) + Sync) {
    #[cfg(feature = "parallel")]
    if threads > 1 {
        use rayon::prelude::*;
        if team::run(|| numbers.par_chunks_mut(most).for_each(&work)).is_some() {
            return;
        }
    }
    let _ = threads;
    numbers.chunks_mut(most).for_each(work);
}

/// The threads of the work under way.
#[cfg(feature = "parallel")]
mod team {
    use std::cell::{OnceCell, RefCell};
    use std::rc::Rc;

    use rayon::{ThreadPool, ThreadPoolBuilder};

    struct Team {
        threads: usize,
        /// Started by the first work that is spread; none where the system gives none.
        pool: OnceCell<Option<ThreadPool>>,
    }

    thread_local! {
        static TEAM: RefCell<Option<Rc<Team>>> = const { RefCell::new(None) };
    }

    /// Gives a thread back the team that it had before.
    struct Before(Option<Rc<Team>>);

    impl Drop for Before {
        fn drop(&mut self) {
            TEAM.set(self.0.take());
        }
    }

    pub fn with<R>(threads: usize, work: impl FnOnce() -> R) -> R {
        let _before = Before(TEAM.replace(Some(Rc::new(Team { threads, pool: OnceCell::new() }))));
        work()
    }

    /// Does work on the pool of this thread's team, or on the one that it is a thread of; `None` where there is neither.
    pub fn run<R: Send>(work: impl FnOnce() -> R + Send) -> Option<R> {
        match TEAM.with_borrow(Clone::clone) {
            Some(team) => {
                let pool = team.pool.get_or_init(|| ThreadPoolBuilder::new().num_threads(team.threads).build().ok());
                Some(pool.as_ref()?.install(work))
            }
            None => rayon::current_thread_index().map(|_| work()),
        }
    }
}
