//! Work that is spread over threads.

/// Does the work for each item, on several threads where there are several; the first error in their order.
pub(crate) fn each<T: Sync, R: Send, E: Send>(
    items: &[T],
    threads: usize,
    work: impl Fn(&T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    #[cfg(feature = "parallel")]
    if threads > 1
        && items.len() > 1
        && let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads.min(items.len())).build()
    {
        use rayon::prelude::*;
        let found: Vec<_> = pool.install(|| items.par_iter().map(&work).collect());
        return found.into_iter().collect();
    }
    let _ = threads;
    items.iter().map(work).collect()
}
