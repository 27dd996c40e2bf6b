//! Work that is spread over threads.

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

/// Does work with this many threads for what it spreads by [`each_here`].
pub(crate) fn with<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    #[cfg(feature = "parallel")]
    if threads > 1
        && let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build()
    {
        return pool.install(work);
    }
    let _ = threads;
    work()
}

/// Does the work for each item, on the threads that work was begun with by [`with`] or [`each`]; in their order where it was not.
pub(crate) fn each_here<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    #[cfg(feature = "parallel")]
    if rayon::current_thread_index().is_some() {
        use rayon::prelude::*;
        return items.par_iter().map(&work).collect();
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
    if threads > 1 && rayon::current_thread_index().is_some() {
        use rayon::prelude::*;
        return items.par_iter().map(&work).collect();
    }
    let _ = threads;
    items.iter().map(work).collect()
}

/// Does the work for parts of so many numbers, as [`all`].
pub(crate) fn parts(numbers: &mut [f64], most: usize, threads: usize, work: impl Fn(&mut [f64]) + Sync) {
    #[cfg(feature = "parallel")]
    if threads > 1 && rayon::current_thread_index().is_some() {
        use rayon::prelude::*;
        return numbers.par_chunks_mut(most).for_each(&work);
    }
    let _ = threads;
    numbers.chunks_mut(most).for_each(work);
}
