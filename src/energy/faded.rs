//! The energy norm of a smooth function on the contact that is let fade over several cells beyond it.

use super::overlap::OverlapBounds;
use super::residual::{Quarter, Residual};

/// Width of the fade over the extent of the contact, and the fewest cells.
const WIDTH: f64 = 0.06;
const FEWEST: usize = 2;

/// A bound of a(w, w) <= |w| |grad w|/2 for w = chi T, chi = 1 on the cells under pressure and those of `touch`, and 0 a few cells beyond:
/// by the largest values of T and of its slopes in each cell.
pub(super) fn faded(residual: &Residual, target: &dyn OverlapBounds, touch: &[Quarter]) -> Option<f64> {
    let field = residual.field;
    let [nx, ny] = field.grid.shape;
    let pressed = |k: usize| field.pressure((k % nx) as isize, (k / nx) as isize) > 0.0;
    let rows = (0..ny).filter(|j| (0..nx).any(|i| pressed(j * nx + i))).count();
    let columns = (0..nx).filter(|i| (0..ny).any(|j| pressed(j * nx + i))).count();
    let width = ((WIDTH * rows.max(columns) as f64) as usize).max(FEWEST);
    let steps = Steps::from(residual, touch, width);
    let [hx, hy] = field.grid.spacing;
    let fall = 1.0 / (width as f64 * hx.min(hy));
    let (mut value, mut slope) = (0.0, 0.0);
    for (i, j, step) in steps.cells(residual) {
        let rect = residual.rect(i, j);
        let [low, high] = target.bounds(&rect, [0.0; 2]);
        let largest = low.abs().max(high.abs());
        let [sx, sy] = target.slopes(&rect).map(|[low, high]| low.abs().max(high.abs()));
        // The nearest point of a cell n steps away is n - 1 cells away.
        let chi = 1.0 - step.saturating_sub(1) as f64 / width as f64;
        let steep = chi * sx.hypot(sy) + if step > 0 { fall * largest } else { 0.0 };
        let images = residual.images(i, j);
        value += images * (chi * largest).powi(2);
        slope += images * steep * steep;
    }
    let bound = 0.5 * field.grid.cell_area() * (value * slope).sqrt() * (1.0 + 1e-8);
    bound.is_finite().then_some(bound)
}

/// Of each cell of a grid and of a frame around it, the steps to the next cell of a set, as a king goes.
struct Steps {
    frame: usize,
    wide: [usize; 2],
    steps: Vec<usize>,
    most: usize,
}

impl Steps {
    fn from(residual: &Residual, touch: &[Quarter], most: usize) -> Self {
        let shape = residual.field.grid.shape;
        let frame = most + 2;
        let wide = shape.map(|n| n + 2 * frame);
        let mut all = Self { frame, wide, steps: vec![usize::MAX - 1; wide[0] * wide[1]], most };
        for (j, i) in (0..shape[1]).flat_map(|j| (0..shape[0]).map(move |i| (j, i))) {
            if residual.field.pressure(i as isize, j as isize) > 0.0 {
                let place = all.place(i as isize, j as isize);
                all.steps[place] = 0;
            }
        }
        for (i, j, _) in touch {
            for image in 0..4 {
                if (0..2).all(|m| image >> m & 1 == 0 || residual.halves[m]) {
                    let at = |m: usize, n: isize| if image >> m & 1 == 1 { shape[m] as isize - 1 - n } else { n };
                    let place = all.place(at(0, *i), at(1, *j));
                    all.steps[place] = 0;
                }
            }
        }
        all.spread();
        all
    }

    fn place(&self, i: isize, j: isize) -> usize {
        let frame = self.frame as isize;
        (j + frame) as usize * self.wide[0] + (i + frame) as usize
    }

    /// Forwards and backwards (Rosenfeld & Pfaltz 1968).
    fn spread(&mut self) {
        let [w, h] = self.wide;
        let step = |steps: &mut [usize], k: usize, others: [usize; 4]| {
            let near = others.into_iter().map(|other| steps[other] + 1).min().unwrap_or(usize::MAX);
            steps[k] = steps[k].min(near);
        };
        for k in (1..h - 1).flat_map(|j| (1..w - 1).map(move |i| j * w + i)) {
            step(&mut self.steps, k, [k - 1, k - w - 1, k - w, k - w + 1]);
        }
        for k in (1..h - 1).rev().flat_map(|j| (1..w - 1).rev().map(move |i| j * w + i)) {
            step(&mut self.steps, k, [k + 1, k + w + 1, k + w, k + w - 1]);
        }
    }

    /// Cells of the set and around it that are worked out.
    fn cells<'a>(&'a self, residual: &'a Residual) -> impl Iterator<Item = (isize, isize, usize)> + 'a {
        let frame = self.frame as isize;
        let first = [0, 1].map(|m| if residual.halves[m] { residual.field.grid.shape[m] as isize / 2 } else { -frame });
        let cells = (0..self.steps.len())
            .map(move |k| ((k % self.wide[0]) as isize - frame, (k / self.wide[0]) as isize - frame, self.steps[k]));
        cells.filter(move |(i, j, step)| *step <= self.most && *i >= first[0] && *j >= first[1])
    }
}
