//! The part of a grid in which contact is looked for: pressure is nowhere else, and no product over cells that cannot touch is made.

use std::ops::Range;

/// A box of cells of a grid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

/// Share of its sides that a box is wider by than the contact of a coarser grid, and cells at the least: half of them are coarse ones
/// that may have missed half of theirs.
const WIDER: usize = 16;
const AROUND: usize = 6;

impl Region {
    pub(super) fn whole([nx, ny]: [usize; 2]) -> Self {
        Self { columns: 0..nx, rows: 0..ny }
    }

    /// The box of the cells for which `holds`; `None` where there is none.
    pub(super) fn holding(shape: [usize; 2], holds: impl Fn(usize) -> bool) -> Option<Self> {
        let [nx, ny] = shape;
        let mut found: Option<Self> = None;
        for j in 0..ny {
            let mut cells = j * nx..(j + 1) * nx;
            let Some(first) = cells.find(|&k| holds(k)) else { continue };
            let last = cells.rev().find(|&k| holds(k)).unwrap_or(first);
            let here = Self { columns: first - j * nx..last + 1 - j * nx, rows: j..j + 1 };
            found = Some(found.map_or(here.clone(), |found| found.union(&here)));
        }
        found
    }

    /// With room for what was not seen yet, in a grid of this shape; where there is a mirror it begins there.
    pub(super) fn widened(&self, shape: [usize; 2], mirrored: bool) -> Self {
        let wider = |range: &Range<usize>, most: usize| {
            let by = AROUND + range.len() / WIDER;
            range.start.saturating_sub(by)..(range.end + by).min(most)
        };
        let rows = wider(&self.rows, shape[1]);
        Self { columns: wider(&self.columns, shape[0]), rows: if mirrored { 0..rows.end } else { rows } }
    }

    pub(super) fn union(&self, other: &Self) -> Self {
        let both = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        Self { columns: both(&self.columns, &other.columns), rows: both(&self.rows, &other.rows) }
    }

    pub(super) fn shape(&self) -> [usize; 2] {
        [self.columns.len(), self.rows.len()]
    }

    pub(super) fn contains(&self, k: usize, width: usize) -> bool {
        self.rows.contains(&(k / width)) && self.columns.contains(&(k % width))
    }

    /// Its rows of a field over the grid.
    pub(super) fn of<'a, T>(&'a self, field: &'a [T], width: usize) -> impl Iterator<Item = &'a [T]> {
        self.rows.clone().map(move |j| &field[j * width..][self.columns.clone()])
    }

    /// The same, to be changed.
    pub(super) fn of_mut<'a, T>(&'a self, field: &'a mut [T], width: usize) -> impl Iterator<Item = &'a mut [T]> {
        field
            .chunks_exact_mut(width)
            .skip(self.rows.start)
            .take(self.rows.len())
            .map(|row| &mut row[self.columns.clone()])
    }
}
