//! Where the boundary runs over a ridge of the gap.
//!
//! On one side of such an angle the ray has one kink more below the boundary than on the other: a(theta) is analytic on
//! both sides, and its slope jumps. With a sector's end there the rules over the angle converge again as for smooth
//! boundaries; without it they halve sector after sector (1.1 to 1.5 times the time of irregular polyhedra).

use super::ray_fan::{Ray, RayFan};

/// Halvings of the angle between two rays.
const HALVINGS: usize = 30;
/// Angles closer than this to an end that is there already are not new.
const APART: f64 = 1e-7;
/// More crossings than this are left to the halving of sectors: the ridges of so many faces are faint.
const MOST: usize = 64;

impl RayFan<'_> {
    /// Finds the crossings of the converged boundary and lays the rays anew when one is new or has moved by more than
    /// `allowed` (radians). Returns whether it did.
    pub(crate) fn follow_crossings(&mut self, d: f64, allowed: f64) -> bool {
        let crossings = self.find_crossings(d);
        if crossings.len() > MOST {
            return false;
        }
        let period = self.sectors.period();
        let close = |a: f64, b: f64, within: f64| apart(a, b, period) <= within;
        let known = |angle: &f64| self.crossings.iter().any(|&c| close(c, *angle, allowed));
        if crossings.iter().all(known) {
            return false;
        }
        // Those that were not found again have sectors of their own on either side, or are gone: those near none stay.
        let kept: Vec<f64> =
            self.crossings.iter().copied().filter(|&c| !crossings.iter().any(|&n| close(c, n, 0.1))).collect();
        self.crossings = crossings;
        self.crossings.extend(kept);
        self.lay_sectors();
        true
    }

    fn find_crossings(&mut self, d: f64) -> Vec<f64> {
        let n = self.rays.len();
        let mut found = Vec::new();
        for k in 0..n {
            let (before, after) = (self.rays[k], self.rays[(k + 1) % n]);
            if differs(&before, &after)
                && let Some(angle) = self.crossing_between(before, after, d)
            {
                found.push(angle);
            }
        }
        found
    }

    fn crossing_between(&mut self, before: Ray, after: Ray, d: f64) -> Option<f64> {
        let from = before.node.angle;
        let (mut lo, mut hi) = (0.0, (after.node.angle - from).rem_euclid(self.sectors.period()));
        let (mut inner, mut outer) = (before, after);
        let held = self.kinks_held();
        for _ in 0..HALVINGS {
            let middle = 0.5 * (lo + hi);
            let ray = self.extra_ray(from + middle, 0.5 * (inner.a + outer.a));
            let ray = self.outer_root(ray, d, 1e-12);
            if ray.stuck {
                break;
            }
            *if differs(&before, &ray) { &mut hi } else { &mut lo } = middle;
            if differs(&before, &ray) {
                outer = ray;
            } else {
                inner = ray;
            }
        }
        self.release_kinks(held);
        let angle = from + 0.5 * (lo + hi);
        // The number of kinks also changes where ridges meet: a known direction.
        let told = |&a: &f64| apart(a, angle, self.sectors.period()) < APART;
        (!self.directions.iter().any(told)).then_some(angle)
    }
}

/// How far apart two angles are but for whole periods.
fn apart(a: f64, b: f64, period: f64) -> f64 {
    ((a - b + 0.5 * period).rem_euclid(period) - 0.5 * period).abs()
}

fn differs(a: &Ray, b: &Ray) -> bool {
    a.position.inner != b.position.inner && !a.stuck && !b.stuck
}
