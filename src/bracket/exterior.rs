//! The part of {f > 0} that the grid does not cover: where the bodies could overlap unseen.

use super::problem::BracketProblem;
use crate::numeric::geometry::Rect;

/// Blocks a side into which the load is gathered.
const BLOCKS: usize = 16;

/// Rectangles looked at before the rest is taken as it is.
const MOST: usize = 100_000;

/// A rectangle where f may exceed u.
pub(super) struct UncoveredCell {
    pub rect: Rect,
    /// Supremum of f less infimum of u.
    pub over: f64,
    /// Supremum of f over infimum of u.
    pub short: f64,
    /// Infimum of u.
    pub least: f64,
}

/// What lies beyond the grid.
pub(super) struct Exterior {
    /// Rectangles, as small as a cell, that cover every point with f > 0 and f > u.
    pub uncovered: Vec<UncoveredCell>,
    /// Whether there may be points with 0 < f <= u: then no pressure may be scaled down.
    pub covered: bool,
}

pub(super) fn uncovered(problem: &BracketProblem, q: &[f64]) -> Exterior {
    let (inner, outer) = (problem.grid.extent(), problem.reach);
    let mut waiting = Vec::new();
    let strips = [
        Rect { min: outer.min, max: [inner.min[0], outer.max[1]] },
        Rect { min: [inner.max[0], outer.min[1]], max: outer.max },
        Rect { min: [inner.min[0], outer.min[1]], max: [inner.max[0], inner.min[1]] },
        Rect { min: [inner.min[0], inner.max[1]], max: [inner.max[0], outer.max[1]] },
    ];
    waiting.extend(
        strips.into_iter().filter_map(|s| s.intersection(&outer)).filter(|s| s.size().iter().all(|&w| w > 0.0)),
    );
    let loads = gathered(problem, q);
    let smallest = problem.grid.spacing[0].max(problem.grid.spacing[1]);
    let mut exterior = Exterior { uncovered: Vec::new(), covered: false };
    let mut seen = 0;
    while let Some(rect) = waiting.pop() {
        seen += 1;
        let f = problem.most_overlap(&rect);
        if f <= 0.0 {
            continue;
        }
        let u = loads.iter().map(|load| load.least(&rect)).sum::<f64>() * (1.0 - 1e-12);
        if f <= u {
            exterior.covered = true;
            continue;
        }
        let [w, h] = rect.size();
        if w.max(h) <= smallest || seen > MOST {
            let short = if u > 0.0 { f / u } else { f64::INFINITY };
            exterior.uncovered.push(UncoveredCell { rect, over: f - u, short, least: u });
            continue;
        }
        let c = rect.centre();
        let (mut low, mut high) = (rect, rect);
        let axis = usize::from(h > w);
        (low.max[axis], high.min[axis]) = (c[axis], c[axis]);
        waiting.extend([low, high]);
    }
    exterior
}

/// The load of a block of cells: its force, where it acts, and its mean square distance from there.
struct Load {
    force: f64,
    at: [f64; 2],
    spread: f64,
}

impl Load {
    /// Lower bound of the displacement over a rectangle: 1/r is a convex function of r^2, so that its mean over the load is at
    /// least that of the mean of r^2 (Jensen).
    fn least(&self, rect: &Rect) -> f64 {
        let along = |m: usize| (rect.max[m] - self.at[m]).max(self.at[m] - rect.min[m]);
        let square = along(0).powi(2) + along(1).powi(2) + self.spread;
        self.force / square.sqrt() * std::f64::consts::FRAC_1_PI
    }
}

fn gathered(problem: &BracketProblem, q: &[f64]) -> Vec<Load> {
    let (grid, [nx, ny]) = (&problem.grid, problem.grid.shape);
    let [bx, by] = [nx.div_ceil(BLOCKS), ny.div_ceil(BLOCKS)];
    let own = (grid.spacing[0].powi(2) + grid.spacing[1].powi(2)) / 12.0;
    let mut loads = Vec::new();
    for j in (0..ny).step_by(by) {
        for i in (0..nx).step_by(bx) {
            let cells = || {
                (j..(j + by).min(ny))
                    .flat_map(move |b| (i..(i + bx).min(nx)).map(move |a| (a, b)))
                    .map(|(a, b)| (q[b * nx + a], grid.centre(a, b)))
                    .filter(|c| c.0 > 0.0)
            };
            let sum: f64 = cells().map(|c| c.0).sum();
            if sum <= 0.0 {
                continue;
            }
            let at = [0, 1].map(|m| cells().map(|(q, c)| q / sum * c[m]).sum::<f64>());
            let square = |c: [f64; 2]| (c[0] - at[0]).powi(2) + (c[1] - at[1]).powi(2);
            let spread = cells().map(|(q, c)| q / sum * square(c)).sum::<f64>() + own;
            loads.push(Load { force: sum * grid.cell_area(), at, spread });
        }
    }
    loads
}
