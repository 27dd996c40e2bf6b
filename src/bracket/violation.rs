//! How far a pressure is from being admissible, cell by cell, as suprema over the whole cell.

use super::field::Field;
use super::mirrors::Mirrors;
use super::problem::BracketProblem;
use super::tables::Tables;

/// Suprema over each cell, cells as in the grid. Where a cell has nothing to say a supremum is minus infinity.
pub(super) struct Violation {
    /// Of f - u over the part of the cell where f > 0.
    pub over: Vec<f64>,
    /// Of f/u over the same part.
    pub short: Vec<f64>,
    /// Of u - f over a loaded cell; infinite where a part of it has no material.
    pub under: Vec<f64>,
    /// Of u/f over a loaded cell; infinite where f <= 0 somewhere.
    pub long: Vec<f64>,
    /// Least displacement in the cell.
    pub least: Vec<f64>,
}

/// What is looked at, and how.
pub(super) struct BoundInput<'a> {
    pub problem: &'a BracketProblem,
    pub field: &'a Field,
    pub tables: &'a Tables,
    pub q: &'a [f64],
    pub side: Side,
    pub mirrors: Mirrors,
}

/// The side of the bracket that a look is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Both,
    Upper,
    Lower,
}

/// What was seen in one cell so far: bounds of r = f - u and of u.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellBounds {
    /// Largest r where f may be positive.
    over: f64,
    /// Least r anywhere.
    least: f64,
    u: [f64; 2],
}

impl CellBounds {
    pub const NOTHING: Self =
        Self { over: f64::NEG_INFINITY, least: f64::INFINITY, u: [f64::INFINITY, f64::NEG_INFINITY] };

    /// A part of the cell.
    pub fn add(&mut self, part: Part) {
        self.u = [self.u[0].min(part.u[0]), self.u[1].max(part.u[1])];
        self.least = self.least.min(part.r[0]);
        self.over = self.over.max(part.over());
    }
}

/// Bounds of r = f - u and of u over a part of a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub r: [f64; 2],
    pub u: [f64; 2],
}

impl Part {
    pub const NOTHING: Self = Self { r: [f64::INFINITY, f64::NEG_INFINITY], u: [f64::INFINITY, f64::NEG_INFINITY] };

    /// Supremum of r where f = r + u may be positive.
    pub fn over(&self) -> f64 {
        if self.r[1] + self.u[1] > 0.0 { self.r[1] } else { f64::NEG_INFINITY }
    }

    /// With what is known of a larger part.
    pub fn narrowed(&self, whole: &Self) -> Self {
        let both = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        Self { r: both(self.r, whole.r), u: both(self.u, whole.u) }
    }
}

impl Violation {
    pub fn empty(cells: usize) -> Self {
        let none = vec![f64::NEG_INFINITY; cells];
        Self {
            over: none.clone(),
            short: none.clone(),
            under: none.clone(),
            long: none,
            least: vec![f64::INFINITY; cells],
        }
    }

    /// What was seen in some cells of what their images are known to be alike.
    pub fn unfold(mut self, mirrors: &Mirrors) -> Self {
        for field in [&mut self.over, &mut self.short, &mut self.under, &mut self.long, &mut self.least] {
            mirrors.unfold(field);
        }
        self
    }

    /// Notes what was seen in a cell in place of what was known.
    pub fn note(&mut self, cell: usize, loaded: bool, seen: &CellBounds) {
        let [u_low, u_high] = seen.u;
        self.least[cell] = u_low;
        (self.over[cell], self.short[cell]) = (seen.over, f64::NEG_INFINITY);
        if seen.over > f64::NEG_INFINITY {
            let by = if seen.over > 0.0 { u_low } else { u_high };
            self.short[cell] = if by > 0.0 { 1.0 + seen.over / by } else { f64::INFINITY };
        }
        (self.under[cell], self.long[cell]) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        if loaded && seen.least < f64::INFINITY {
            self.under[cell] = -seen.least;
            // inf f/u = 1 + inf r/u.
            let by = if seen.least < 0.0 { u_low } else { u_high };
            let least = if by > 0.0 { 1.0 + seen.least / by } else { f64::NEG_INFINITY };
            self.long[cell] = if least > 0.0 { 1.0 / least } else { f64::INFINITY };
        }
    }

    /// Notes what was seen where it is narrower than what was known: both bound the same suprema.
    pub fn narrow(&mut self, cell: usize, loaded: bool, seen: &CellBounds) {
        let known = [self.over[cell], self.short[cell], self.under[cell], self.long[cell], self.least[cell]];
        self.note(cell, loaded, seen);
        self.over[cell] = self.over[cell].min(known[0]);
        self.short[cell] = self.short[cell].min(known[1]);
        self.under[cell] = self.under[cell].min(known[2]);
        self.long[cell] = self.long[cell].min(known[3]);
        self.least[cell] = self.least[cell].max(known[4]);
    }

    /// A cell without load that is covered: f is at most `highest`, u at least `least`.
    pub fn clear(&mut self, cell: usize, highest: f64, least: f64) {
        (self.least[cell], self.short[cell]) = (least, highest / least);
    }

    /// Adds the cells with the largest violations to those that are looked at more closely: at first about as many as lie
    /// along the edge of the contact and its ridges, then some more. A cell that was corrected by what was seen closely must be
    /// seen so again: from further away it would seem to be violated still.
    pub fn add_worst(&self, input: &BoundInput, looked: &[bool], closely: &mut [u8], level: u8) {
        let height = |k: usize| match input.side {
            Side::Both => self.over[k].max(self.under[k]),
            Side::Upper => self.over[k],
            Side::Lower => self.under[k],
        };
        let first = !closely.contains(&level);
        let mut cells: Vec<(f64, usize)> = (0..looked.len())
            .filter(|&k| looked[k] && closely[k] + 1 == level)
            .map(|k| (height(k), k))
            .filter(|c| c.0 > 0.0)
            .collect();
        let loaded = input.q.iter().filter(|&&q| q > 0.0).count();
        let lines = LINES[usize::from(level) - 1] * if first { 1.0 } else { MORE };
        let most = (lines * (loaded as f64).sqrt()) as usize / input.mirrors.fold() + 16;
        if most < cells.len() {
            cells.select_nth_unstable_by(most, |a, b| b.0.total_cmp(&a.0));
            cells.truncate(most);
        }
        let all = cells.into_iter().flat_map(|c| input.mirrors.images(c.1));
        all.for_each(|image| closely[image.cell] = level);
    }
}

/// Cells looked at in quarters, closely, and more closely, in roots of the number of loaded ones; and the share of that by
/// which a later look may add to them.
const LINES: [f64; 3] = [15.0, 12.0, 6.0];
const MORE: f64 = 0.2;
