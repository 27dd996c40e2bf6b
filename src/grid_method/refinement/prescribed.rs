//! A grid that is prescribed.

use super::super::refined::Refined;
use super::super::single_grid::{GridOptions, GridState, laid};
use super::{AS_A_BRACKET, PRECISE, Refinement};
use crate::gap::Gap;
use crate::grid::{Grid, shape};
use crate::numeric::geometry::Rect;
use crate::solution::{Unsolved, Verdict};

/// Shares of a cell by which rounding may move a line of the grid.
const ON_LINE: f64 = 1e-6;

/// The cells of a grid that a rectangle touches.
fn part_of(nodes: &Grid, window: &Rect) -> Grid {
    let [x, y] = [0, 1].map(|m| {
        let place = |v: f64| (v - nodes.origin[m]) / nodes.spacing[m];
        let most = nodes.shape[m] as f64;
        let first = (place(window.min[m]) + ON_LINE).floor().clamp(0.0, most - 1.0);
        let end = (place(window.max[m]) - ON_LINE).ceil().clamp(first + 1.0, most);
        (first, (end - first) as usize)
    });
    let origin = [0, 1].map(|m| nodes.origin[m] + [x.0, y.0][m] * nodes.spacing[m]);
    Grid { origin, spacing: nodes.spacing, shape: [x.1, y.1] }
}

impl Refinement<'_> {
    /// A prescribed grid. Two coarser ones go before it, for the estimate of the error; each costs a quarter of the next or less.
    pub(super) fn prescribed(mut self, cells: usize) -> Result<Option<Refined>, Unsolved> {
        let mut best: Option<Refined> = None;
        // Of a map the window covers a part.
        let cells = self.nodes().map_or(cells, |nodes| {
            let [nx, ny] = part_of(&nodes, &self.window).shape;
            nx.max(ny)
        });
        for coarser in [cells.div_ceil(4), cells.div_ceil(2)].into_iter().filter(|&n| n >= 6 && n != cells) {
            let state = self.grid(|window| shape(window, coarser), PRECISE[1], None)?;
            let error = self.limit(&state).error;
            best = Some(Refined::of(state, error));
        }
        let finest = match self.nodes() {
            Some(nodes) => self.on_nodes(&nodes),
            None => self.grid(|window| shape(window, cells), PRECISE[1], None),
        };
        let state = match finest {
            Err(e) if e.verdict == Verdict::TimeLimit && best.is_some() => {
                return Ok(best.map(|b| Refined { stopped: Some(e), ..b }));
            }
            other => other?,
        };
        if state.force() <= 0.0 {
            return Ok(None);
        }
        let estimate = self.limit(&state);
        let estimated = self.error_as_given(&state, estimate)?;
        let coarser = best.map(|b| Box::new(b.state));
        // Who prescribes the grid wants the force of that grid, whether or not the bounds hold it.
        let Some(Ok([lower, upper])) = self.proved(&state, AS_A_BRACKET) else {
            return Ok(Some(Refined { coarser, ..Refined::of(state, estimated) }));
        };
        let force = state.force();
        let proved = (upper - force).abs().max((force - lower).abs());
        // Bounds wider than the estimate leave it, but for what they show it to miss.
        let shown = (lower - force).max(force - upper);
        let error = proved.min(estimated.max(shown));
        Ok(Some(Refined { proved: Some([lower, upper]), coarser, ..Refined::of(state, error) }))
    }

    /// The cells around the nodes of the height map, where those are asked for.
    fn nodes(&self) -> Option<Grid> {
        let nodes = self.scaled.gap.nodes().filter(|_| self.settings.nodes)?;
        (self.settings.cells == Some(nodes.shape[0].max(nodes.shape[1]))).then_some(nodes)
    }

    /// The contact on cells around the nodes of a height map.
    fn on_nodes(&mut self, nodes: &Grid) -> Result<GridState, Unsolved> {
        let options = GridOptions { tolerance: PRECISE[1], ..GridOptions::precise(self.settings, self.method) };
        let state = laid(self.scaled, &mut self.window, |window| part_of(nodes, window), options)?;
        Ok(self.with_spent(state))
    }
}
