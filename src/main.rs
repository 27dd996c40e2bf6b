//! The command line.

use peakmem_alloc::{INSTRUMENTED_SYSTEM, PeakMemAlloc};

/// The allocator of the system, counting: `compare` tells what each method needs.
#[global_allocator]
static HEAP: &PeakMemAlloc<std::alloc::System> = &INSTRUMENTED_SYSTEM;

fn main() -> std::process::ExitCode {
    contact_patch::cli::run()
}
