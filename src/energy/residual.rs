//! The energy norm of the residual: a trial displacement w, continued beyond the contact, and the integrals of w^2 and |grad w|^2.

use super::cut::{Cell, left_out, scaled};
use super::expansion::{Expansions, Workspace};
use super::extension::Extension;
use super::field::{Field, RING};
use super::lane::{LANES, Lane};
use super::outside::{Loads, clear_beyond, near};
use super::overlap::{OverlapBounds, Raised, Taylor};
use super::pressed::{self, Pressed};
use super::tables::MOST_SLENDER;
use super::whole::integrals;
use super::{basis, whole};
use crate::numeric::geometry::Rect;

/// Which halves of the grid are worked out: the upper one along an axis where pressure and overlap are their own images.
pub(super) type Halves = [bool; 2];

/// A quarter of a cell: i, j and its number.
pub(super) type Quarter = (isize, isize, usize);

/// Integrals over the plane, in the units of the grid, and what each cell and what belongs to it contributes.
#[derive(Debug, Clone)]
pub(super) struct Norms {
    /// Bound of the integral of |grad w|^2.
    pub gradient: f64,
    /// Bound of the integral of w^2.
    pub value: f64,
    /// Both, cell by cell of the grid, without what was not worked out cell by cell.
    pub cells: Vec<[f64; 2]>,
}

impl Norms {
    /// Where no bound is known: of the cells as far as they were worked out.
    fn unbounded(cells: Vec<[f64; 2]>) -> Self {
        Self { gradient: f64::INFINITY, value: f64::INFINITY, cells }
    }

    /// Bound of a(w, w) <= |w| |grad w|/2.
    pub fn energy(&self) -> f64 {
        0.5 * (self.gradient * self.value).sqrt() * (1.0 + 1e-14)
    }
}

/// What some of the cells tell of all.
pub(super) struct Seen {
    /// About what a(w, w) is bounded by.
    pub energy: f64,
    /// Share of cells that are worked out in parts.
    pub divided: f64,
}

/// Share of |grad r| and |r| in a cell that f may leave open before it is looked at more closely.
const CLOSE: f64 = 0.05;

/// As many times as many rows of cells are worth a look at some of them first.
const SEVERAL: usize = 4;

/// What sums in floating point may add to integrals, and the quadrature of [`super::tables`], relative.
const ROUNDING: f64 = 1e-6;

pub(super) struct Residual<'a> {
    pub field: &'a Field,
    pub overlap: &'a dyn OverlapBounds,
    pub halves: Halves,
}

impl Residual<'_> {
    /// The cells under pressure.
    pub fn pressed(&self) -> Pressed {
        Pressed::new(&self.field.grid, self.halves, |i, j| self.field.pressure(i as isize, j as isize))
    }

    pub fn rect(&self, i: isize, j: isize) -> Rect {
        self.field.rect(i, j)
    }

    /// First cell along each axis that is worked out.
    fn first(&self) -> [isize; 2] {
        [0, 1].map(|m| if self.halves[m] { (self.field.grid.shape[m] / 2) as isize } else { -(RING as isize) })
    }

    /// How many cells a cell stands for.
    pub fn images(&self, i: isize, j: isize) -> f64 {
        pressed::images(&self.field.grid, self.halves, i, j)
    }

    /// The extension with w >= f - u wherever there is material; `None` where the contact may reach beyond the grid.
    pub fn admissible(&self) -> Option<Extension> {
        let field = self.field;
        let loaded = |i: usize, j: usize| field.pressure(i as isize, j as isize) > 0.0;
        let mut set = Extension::of_cells(field.grid.shape, loaded);
        let (open, _) = self.open(self.overlap, |i, j, q| set.holds(i, j, q), |_, _| false, f64::INFINITY)?;
        open.into_iter().for_each(|(i, j, quarter)| set.open(i, j, quarter));
        Some(set)
    }

    /// The quarters of cells without pressure in which an exact pressure may act, and how many cells they and their images are: u, less the
    /// most by which it lies above f under pressure, is no more than the exact displacement (domination), and where that lies above f
    /// there is no contact. `dip`: that most. Once there are more than `most` cells no more are looked for. `None` where they may lie
    /// beyond the grid.
    pub fn may_touch(&self, dip: f64, most: f64) -> Option<(Vec<Quarter>, f64)> {
        let raised = Raised { overlap: self.overlap, by: dip * (1.0 + 1e-12) };
        self.open(&raised, |_, _, _| false, |cell, quarter| cell.range(quarter)[1] < 0.0, most)
    }

    /// Quarters of cells without pressure in which `overlap` <= u could not be shown, but for those that are known. `closer` looks at
    /// one again, with the overlap.
    fn open(
        &self,
        overlap: &dyn OverlapBounds,
        known: impl Fn(isize, isize, usize) -> bool,
        closer: impl Fn(&Cell, usize) -> bool,
        most: f64,
    ) -> Option<(Vec<Quarter>, f64)> {
        let field = self.field;
        let loads = Loads::new(&field.grid, |j| &field.pressures(0, j as isize)[..field.grid.shape[0]]);
        if !clear_beyond(&field.grid, overlap, &loads) {
            return None;
        }
        let loaded = |i: isize, j: isize| field.pressure(i, j) > 0.0;
        let (mut open, mut cells) = (Vec::new(), 0.0);
        let mut room = Workspace::new();
        let left_out = left_out(field);
        near(field, overlap, &loads, self.first(), loaded, |from, count, j| {
            for start in (0..count).step_by(LANES) {
                if cells > most {
                    return;
                }
                let first = from + start as isize;
                let lanes = LANES.min(count - start);
                let wanted = |k: usize| {
                    let i = first + k as isize;
                    let open = k < lanes && !loaded(i, j) && (0..4).any(|q| !known(i, j, q));
                    open && (!overlap.ends() || overlap.material(&self.rect(i, j)))
                };
                if !(0..lanes).any(wanted) {
                    continue;
                }
                let expansions = Expansions::new(field, first, j, &mut room);
                let clear = self.clear(overlap, &expansions, [first, j], left_out, &wanted);
                for k in (0..lanes).filter(|k| wanted(*k)) {
                    let i = first + k as isize;
                    if clear[k] {
                        continue;
                    }
                    let expansion = expansions.cell(field, first, j, k);
                    let cell = Cell::new(field, overlap, self.rect(i, j), expansion);
                    let beyond = (0..4).filter(|q| !known(i, j, *q));
                    let left: Vec<usize> = beyond.filter(|q| !cell.clear_quarter(*q)).collect();
                    if !left.is_empty() {
                        let cell = cell.with_overlap();
                        let before = open.len();
                        open.extend(left.into_iter().filter(|q| !closer(&cell, *q)).map(|q| (i, j, q)));
                        cells += 0.25 * self.images(i, j) * (open.len() - before) as f64;
                    }
                }
            }
        });
        Some((open, cells))
    }

    /// Of cells side by side, those over which r <= 0 by the corners of the cell alone. (No cell that touches may be loaded.)
    fn clear(
        &self,
        overlap: &dyn OverlapBounds,
        u: &Expansions,
        [i, j]: [isize; 2],
        most: f64,
        wanted: &impl Fn(usize) -> bool,
    ) -> [bool; LANES] {
        let h = self.field.tables.h;
        let mut sums = [[0.0; LANES]; 4];
        let mut bend = [0.0; LANES];
        for (k, (c, [a, b])) in u.polynomial.iter().zip(basis::DEGREES).enumerate() {
            let class = basis::CLASSES[1..].iter().filter(|first| k >= **first).count();
            let bends = 0.125 * (basis::BENDS[a] + basis::BENDS[b]);
            for n in 0..LANES {
                sums[class][n] += c[n];
                bend[n] += bends * c[n].abs();
            }
        }
        let mut clear = [false; LANES];
        for k in 0..LANES {
            if u.singular.iter().any(|z| z[k] != 0.0) || !wanted(k) {
                continue;
            }
            // u at the corners is even +- x +- y +- xy.
            let [even, x, y, xy] = [0, 1, 2, 3].map(|class: usize| sums[class][k]);
            let lowest = even - xy.abs() - bend[k] - most;
            let [_, high] = overlap.bounds(&self.rect(i + k as isize, j), [2.0 * x / h[0], 2.0 * y / h[1]]);
            clear[k] = high / self.field.scale <= lowest;
        }
        clear
    }

    /// The integrals for an extension: of w = max(r, chi r).
    pub fn norms(&self, set: &Extension) -> Norms {
        self.norms_and_dips(set, None)
    }

    /// The same, and for each loaded cell a bound of u - f in it, in the units of the grid; infinite where that has to be looked for.
    pub fn norms_and_dips(&self, set: &Extension, mut dips: Option<&mut [f64]>) -> Norms {
        let field = self.field;
        let shape = field.grid.shape;
        let first = self.first();
        let mut total = [0.0; 2];
        let mut room = Workspace::new();
        let mut cells = vec![[0.0; 2]; field.grid.len()];
        let end = shape.map(|n| (n + RING) as isize);
        for j in first[1]..end[1] {
            if !self.overlap.has_time() {
                return Norms::unbounded(cells);
            }
            let mut i = first[0];
            while i < end[0] {
                if !set.touches(i, j) {
                    i += 1;
                    continue;
                }
                let lanes = LANES.min((end[0] - i) as usize);
                let mut deepest = dips.is_some().then_some([f64::INFINITY; LANES]);
                let (found, _) = self.lanes(set, i, j, lanes, &mut room, deepest.as_mut());
                if !found.as_flattened().iter().all(|v| v.is_finite()) {
                    return Norms::unbounded(cells);
                }
                if let (Some(dips), Some(deepest)) = (&mut dips, deepest) {
                    for (k, dip) in
                        deepest.into_iter().enumerate().take(lanes).filter(|(k, _)| set.whole(i + *k as isize, j))
                    {
                        dips[j as usize * shape[0] + (i + k as isize) as usize] = dip * field.scale;
                    }
                }
                for (k, found) in found.iter().enumerate().take(lanes) {
                    let images = self.images(i + k as isize, j);
                    let at = |n: isize, m: usize| n.clamp(0, shape[m] as isize - 1) as usize;
                    let place = at(j, 1) * shape[0] + at(i + k as isize, 0);
                    for m in 0..2 {
                        total[m] += images * found[m];
                        cells[place][m] += found[m];
                    }
                }
                i += lanes as isize;
            }
        }
        self.unfold(&mut cells);
        let rest = self.rest();
        let [gradient, value] = [0, 1].map(|m| ((total[m] * (1.0 + ROUNDING)).sqrt() + rest[m]).powi(2));
        let (two, four) = (field.scale.powi(2), field.scale.powi(4));
        cells.iter_mut().for_each(|[a, b]| (*a, *b) = (*a * two, *b * four));
        Norms { gradient: gradient * two, value: value * four, cells }
    }

    /// What at most `count` rows of cells side by side tell, spread over all; `None` where there are not several times the fewest.
    pub fn seen(&self, count: usize, fewest: usize) -> Option<Seen> {
        let (field, shape) = (self.field, self.field.grid.shape.map(|n| n as isize));
        let set = Extension::of_cells(field.grid.shape, |i, j| field.pressure(i as isize, j as isize) > 0.0);
        let first = self.first().map(|n| n.max(0));
        let rows = (first[1]..shape[1]).flat_map(|j| (first[0]..shape[0]).step_by(LANES).map(move |i| (i, j)));
        let lanes = |i: isize| LANES.min((shape[0] - i) as usize);
        let all: Vec<_> = rows.filter(|(i, j)| (0..lanes(*i)).any(|k| set.touches(i + k as isize, *j))).collect();
        if all.len() < SEVERAL * fewest {
            return None;
        }
        let step = (all.len() / count).max(SEVERAL);
        let (mut total, mut room, mut cells, mut divided) = ([0.0; 2], Workspace::new(), 0, 0);
        for &(i, j) in all.iter().step_by(step) {
            let (found, in_parts) = self.lanes(&set, i, j, lanes(i), &mut room, None);
            cells += (0..lanes(i)).filter(|k| set.whole(i + *k as isize, j)).count();
            divided += in_parts;
            for (k, found) in found.iter().enumerate().take(lanes(i)) {
                let images = self.images(i + k as isize, j);
                (0..2).for_each(|m| total[m] += step as f64 * images * found[m]);
            }
        }
        let energy = 0.5 * (total[0] * total[1]).sqrt() * field.scale.powi(3);
        Some(Seen { energy, divided: divided as f64 / cells.max(1) as f64 })
    }

    /// The integrals of |grad w|^2 and w^2 over cells side by side, and how many of those in the set were worked out in parts.
    fn lanes(
        &self,
        set: &Extension,
        i: isize,
        j: isize,
        lanes: usize,
        room: &mut Workspace,
        deepest: Option<&mut Lane>,
    ) -> ([[f64; 2]; LANES], usize) {
        let field = self.field;
        let expansions = Expansions::new(field, i, j, room);
        let mut found = [[0.0; 2]; LANES];
        let mut overlaps: whole::Overlaps = [[0.0; LANES]; basis::POLYNOMIALS];
        let mut rests = [None; LANES];
        let mut most = [0.0; LANES];
        let half = field.grid.spacing.map(|h| 0.5 * h);
        for k in 0..lanes {
            let i = i + k as isize;
            if !set.whole(i, j) {
                continue;
            }
            let Some(jet) = self.overlap.jet(&self.rect(i, j)) else { continue };
            let taylor = scaled(&Taylor::of(&jet, half), field.scale);
            for (n, c) in basis::of_taylor(&taylor.terms, field.tables.h) {
                overlaps[n][k] = c;
            }
            rests[k] = Some(taylor.rest);
            most[k] = taylor.most[0];
        }
        if let Some(deepest) = deepest {
            let bound = dip(field, &expansions, &overlaps);
            for k in (0..lanes).filter(|k| rests[*k].is_some()) {
                deepest[k] = bound[k] + most[k];
            }
        }
        let area = field.tables.h[0] * field.tables.h[1];
        let [slopes, values] = if rests.iter().any(Option::is_some) {
            integrals(&field.tables, &expansions, &overlaps)
        } else {
            [[0.0; LANES]; 2]
        };
        let mut in_parts = 0;
        for k in 0..lanes {
            let i = i + k as isize;
            if let Some([value, gradient]) = rests[k] {
                let (a, b) = (slopes[k].max(0.0).sqrt(), values[k].max(0.0).sqrt());
                let (da, db) = (area.sqrt() * gradient, area.sqrt() * value);
                if da <= CLOSE * a && db <= CLOSE * b || !self.overlap.is_worth_parts() {
                    found[k] = [(a + da).powi(2), (b + db).powi(2)];
                    continue;
                }
            }
            if !set.touches(i, j) {
                continue;
            }
            in_parts += usize::from(set.whole(i, j));
            let cell = Cell::new(field, self.overlap, self.rect(i, j), expansions.cell(field, i - k as isize, j, k))
                .with_overlap();
            for quarter in 0..4 {
                if set.holds(i, j, quarter) {
                    let part = cell.integrals(quarter, set.fade(i, j, quarter));
                    (0..2).for_each(|m| found[k][m] += part[m]);
                }
            }
        }
        (found, in_parts)
    }

    /// The most by which u lies above f under pressure, from bounds in each cell: the largest of them are looked at closely.
    pub fn deepest_dip(&self, dips: &[f64]) -> f64 {
        let field = self.field;
        let [nx, _] = field.grid.shape;
        let worked_out = |k: usize| {
            let (at, first) = ([(k % nx) as isize, (k / nx) as isize], self.first());
            at[0] >= first[0] && at[1] >= first[1] && field.pressure(at[0], at[1]) > 0.0
        };
        let mut cells: Vec<usize> = (0..dips.len()).filter(|k| worked_out(*k)).collect();
        cells.sort_unstable_by(|a, b| dips[*b].total_cmp(&dips[*a]));
        let mut room = Workspace::new();
        let mut deepest = 0.0_f64;
        for k in cells {
            if dips[k] <= deepest {
                break;
            }
            let (i, j) = ((k % nx) as isize, (k / nx) as isize);
            let expansion = Expansions::new(field, i, j, &mut room).cell(field, i, j, 0);
            let cell = Cell::new(field, self.overlap, self.rect(i, j), expansion).with_overlap();
            let least = (0..4).map(|q| cell.range(q)[0]).fold(f64::INFINITY, f64::min);
            deepest = deepest.max((-least * field.scale).min(dips[k]));
        }
        deepest
    }

    /// What is left out of every cell, in the norms of the gradient and of the value: the cells beyond the near block, and the error of
    /// the cell means.
    fn rest(&self) -> [f64; 2] {
        let field = self.field;
        let tables = &field.tables;
        let [along, across] = field.differences;
        let [gradient, value] = [tables.rest.gradient, tables.rest.value].map(|[x, y]| x * along + y * across);
        let around = field.grid.shape.map(|n| (n + 8) as f64);
        let nodes = (around[0] * around[1]).sqrt() * field.rounding;
        let one = basis::GROWTH[0] * nodes;
        let slope = (2.0 * basis::GROWTH[0] * basis::GROWTH[1]).sqrt() * MOST_SLENDER * nodes;
        [gradient + slope + 2.0 * MOST_SLENDER * one, value + one]
    }

    /// Copies what was found to the images.
    fn unfold(&self, cells: &mut [[f64; 2]]) {
        let [nx, ny] = self.field.grid.shape;
        for j in 0..ny {
            for i in 0..nx {
                let from = [
                    if self.halves[0] { i.max(nx - 1 - i) } else { i },
                    if self.halves[1] { j.max(ny - 1 - j) } else { j },
                ];
                cells[j * nx + i] = cells[from[1] * nx + from[0]];
            }
        }
    }
}

/// Of cells side by side, a bound of u - f in each, in longer sides: |P_k| <= 1. What f leaves open is not in it.
fn dip(field: &Field, u: &Expansions, overlap: &whole::Overlaps) -> Lane {
    let mut bound = [left_out(field); LANES];
    for (n, (u, f)) in u.polynomial.iter().zip(overlap).enumerate() {
        for k in 0..LANES {
            let less = u[k] - f[k];
            bound[k] += if n == 0 { less } else { less.abs() };
        }
    }
    for (z, most) in u.singular.iter().zip(field.tables.rule.suprema) {
        (0..LANES).for_each(|k| bound[k] += most * z[k].abs());
    }
    bound
}
