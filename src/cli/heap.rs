//! How much memory a piece of work takes, counted by the allocator of the program.

use peakmem_alloc::{INSTRUMENTED_SYSTEM, PeakMemAllocTrait};

/// Most bytes of heap that `work` held at once beyond those held before it, from all threads; 0 in a program that does not
/// allocate by [`INSTRUMENTED_SYSTEM`].
pub(super) fn peak_of(work: &mut dyn FnMut()) -> usize {
    INSTRUMENTED_SYSTEM.reset_peak_memory();
    work();
    INSTRUMENTED_SYSTEM.get_peak_memory()
}
