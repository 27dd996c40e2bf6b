//! What the approximate methods allocate while they evaluate the gap. One test, so that no other thread is counted.
#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used)]

use std::alloc::System;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use contact_patch::fabrikant::{Family, Settings};
use contact_patch::gap::{Gap, Reach};
use contact_patch::geometry::Rect;
use contact_patch::{EffectiveModulus, approximate};
use peakmem_alloc::{INSTRUMENTED_SYSTEM, PeakMemAlloc, PeakMemAllocTrait};

#[global_allocator]
static ALLOCATOR: &PeakMemAlloc<System> = &INSTRUMENTED_SYSTEM;

/// A paraboloid that looks, at every evaluation, whether anything was allocated since the last one.
#[derive(Default)]
struct Watching {
    evaluations: AtomicUsize,
    after_allocation: AtomicUsize,
}

impl Watching {
    fn look(&self) {
        self.evaluations.fetch_add(1, Relaxed);
        if ALLOCATOR.get_peak_memory() > 0 {
            self.after_allocation.fetch_add(1, Relaxed);
        }
        ALLOCATOR.reset_peak_memory();
    }
}

#[derive(Clone)]
struct Watched(Arc<Watching>);

impl Gap for Watched {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.0.look();
        x * x + 0.7 * y * y
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.0.look();
        Some([2.0 * x, 1.4 * y])
    }

    fn reach(&self, depth: f64) -> Reach {
        Reach::Within(Rect::around([0.0; 2], [1.2 * depth.sqrt(); 2]))
    }
}

/// Between two evaluations of one sweep nothing is allocated; between sweeps and layouts a few small things are.
#[test]
fn the_inner_loops_allocate_nothing() {
    let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
    // Once before: tables that are made once for all.
    for family in [Family::Stationary, Family::Ellipse, Family::Circle, Family::Fourier(4), Family::PlanForm] {
        let mut counts = Vec::new();
        for tolerance in [1e-6, 1e-6, 1e-13] {
            let settings = Settings::with_tolerance(tolerance);
            let watching = Arc::new(Watching::default());
            let gap = Watched(watching.clone());
            approximate::solve(&gap, modulus, 1.0, family, &settings).unwrap();
            counts.push([&watching.evaluations, &watching.after_allocation].map(|n| n.load(Relaxed)));
        }
        println!("{family:?}: [evaluations, after an allocation] {counts:?}");
        for [evaluations, after_allocation] in &counts[1..] {
            assert!(after_allocation * 100 < *evaluations, "{family:?}: {counts:?}");
        }
    }
}
