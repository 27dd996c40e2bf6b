//! A mesh with its compliance: the flat punch that its cells cover, and the bracket of its stiffness.

use super::Means;
use super::active_set::{factor, solve_on};
use super::compliance::Compliance;
use super::line_potential::Lines;
use super::mesh::{Bilinear, Mesh};
use super::residual_norm::{Target, decay_lengths, norms};
use super::symmetry::{Isometry, Orbits};

/// A mesh ready to be solved on.
pub(crate) struct Discretisation {
    pub mesh: Mesh,
    pub orbits: Orbits,
    pub lines: Lines,
    pub compliance: Compliance,
    /// Area of each orbit of loaded cells.
    pub areas: Vec<f64>,
    pub means: Means,
}

/// What one mesh says of a flat punch, E* = 1.
pub(crate) struct Stiffness {
    /// Bounds of K = P/d.
    pub bounds: [f64; 2],
    /// Half of what pair integrals leave open of it, relative: more with thinner cells.
    pub open: f64,
    /// Pressure of the loaded cells at depth 1.
    pub pressure: Vec<f64>,
}

/// What the pressure of one mesh says of a flat punch from below, E* = 1.
pub(crate) struct Below {
    /// 2 U_low, from below.
    pub stiffness: f64,
    /// By how much more that may be: what pair integrals and rounding leave open.
    pub open: f64,
    /// Pressure of the loaded cells at depth 1.
    pub pressure: Vec<f64>,
}

impl Below {
    /// Half of what is open, relative.
    pub fn half_open(&self) -> f64 {
        0.5 * self.open / self.stiffness
    }
}

impl Discretisation {
    /// `group`: symmetries of the outline; those of the mesh among them are used. `None` once the time is used up.
    pub fn new(mesh: Mesh, group: &[Isometry], means: Means) -> Option<Self> {
        Self::within(mesh, group, usize::MAX, means)
    }

    /// The same with at most so many unknowns.
    pub fn within(mesh: Mesh, group: &[Isometry], unknowns: usize, means: Means) -> Option<Self> {
        let lines = Lines::new(&mesh);
        let orbits = Orbits::new(&mesh, group);
        if orbits.loaded > unknowns {
            return None;
        }
        let compliance = Compliance::new(&mesh, &lines, &orbits, means)?;
        let areas = (0..orbits.loaded)
            .map(|a| orbits.size[a] as f64 * Bilinear::new(mesh.corners(orbits.representatives[a])).area())
            .collect();
        Some(Self { mesh, orbits, lines, compliance, areas, means })
    }

    /// 2 U_low, which is K from below, by the p >= 0 with S p = 1 in the mean over every cell. `None` where the matrix has no factor.
    pub fn stiffness_below(&self) -> Option<Below> {
        let all = vec![true; self.orbits.loaded];
        let factor = factor(&self.compliance, &all)?;
        let p: Vec<f64> = solve_on(&factor, &all, &self.areas).iter().map(|p| p.max(0.0)).collect();
        // <1, p> - <p, S p>/2.
        let work: f64 = p.iter().zip(&self.areas).map(|(p, a)| p * a).sum();
        let product: f64 = p.iter().zip(self.compliance.product(&p)).map(|(p, u)| p * u).sum();
        let off = 0.5 * self.compliance.uncertainty(&p, &p) + 1e-12 * (work.abs() + product.abs());
        let (stiffness, open) = (2.0 * (work - 0.5 * product - off), 4.0 * off);
        let pressure = self.orbits.expand(&p, self.mesh.loaded);
        (stiffness.is_finite() && stiffness > 0.0).then_some(Below { stiffness, open, pressure })
    }

    /// U_low <= U <= U_low + a(w, w)/2 with U_low = <1, p> - <p, S p>/2 for the p of `stiffness_below`,
    /// w = 1 - S p on the material and anything beyond it; K = 2 U at depth 1. `None` where the matrix has no factor, and once the
    /// time is used up.
    pub fn stiffness(&self) -> Option<Stiffness> {
        let below = self.stiffness_below()?;
        let (low, open) = (below.stiffness, below.half_open());
        let decay = decay_lengths(&self.mesh);
        let everywhere = vec![true; self.mesh.loaded];
        let target = [Target::level(&below.pressure)];
        let [norm] = norms(&self.mesh, &self.lines, &self.orbits, &decay, &everywhere, target, self.means)?;
        let bounds = [low, (low + below.open + norm.bound()) * (1.0 + 1e-11)];
        bounds.iter().all(|k| k.is_finite()).then_some(Stiffness { bounds, open, pressure: below.pressure })
    }
}

#[cfg(test)]
mod tests {
    use super::super::outline::Outline;
    use super::*;

    /// Pair integrals of thin cells with nearly parallel sides cancel: both bounds hold what that leaves open.
    #[test]
    fn nearly_parallel_sides() {
        // K of the rectangle 2 x 0.51 is 1.2805 to 2e-4, and the wedge adds at most half of its own width.
        for wedge in [1e-3, 1e-4, 1e-5] {
            let outline = Outline::polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0 + wedge, 0.51], [0.0, 0.51]]).unwrap();
            let fitted = outline.mesh_within(12, f64::INFINITY).unwrap();
            let found = Discretisation::new(fitted.mesh, &fitted.group, Means::PLAIN).unwrap().stiffness().unwrap();
            let [low, high] = found.bounds;
            assert!(
                low < 1.280_5 * (1.0 + 0.5 * wedge + 2e-4) && high > 1.280_5 * (1.0 - 2e-4),
                "{wedge} {low} {high}"
            );
        }
    }
}
