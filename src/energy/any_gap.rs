//! The force of any gap from one pressure: without a law the energy alone does not tell it.
//!
//! p is the exact pressure, P its force, p_h >= 0 the one at hand, u_h = S p_h, r = f - u_h, gamma the width of its energy bracket; a_v
//! stands for any bound of a(w, w) with w = v where that is asked for.
//!
//! **Below.** On the cells A under pressure let m be any function and m_A the exact pressure of a flat punch, S m_A = 1 on A. Then
//! P >= <f, m_A> (Barber 1974), and with <u_h, m_A> = P_h and m_A - m = S^-1 (1 - S m) on A
//!
//!   P >= P_h + <r, m> - sqrt(a_r a_m),   w = r and w = 1 - S m on A.                                                     (4)
//!
//! **Above.** For 0 <= m <= tau p_h, and A' all that is under p or p_h,
//!
//!   P <= P_h + <r, m> + B,   w = 1 - S m on A',                                                                         (5)
//!   B = sqrt(2 gamma a_m) if tau <= sqrt(a_m/(2 gamma)), else tau gamma + a_m/(2 tau).
//!
//! For P = <S p, m> + <p_h, 1 - S m> + <p - p_h, 1 - S m>, S p = f + (S p - f) with <S p - f, m> <= tau X, X = <S p - f, p_h>, and
//! |p - p_h|^2 = 2 (U - U_low - X) <= 2 (gamma - X) in the energy norm; B is the largest over X. The same m shows
//! P >= P_h + <r, m> - sqrt(2 gamma a_m).
//!
//! A' follows from domination: u_h less the most by which it lies above f under p_h is nowhere more than S p
//! ([`super::residual::Residual::may_touch`]).
//!
//! **Without m.** P is convex in the depth and 0 up to the least gap g0: P (d - g0) >= 2 U. It grows with the contact:
//! P <= (d - g0) K(A'), K the force of a flat punch on A' at unit depth.
//!
//! Where f is smooth another way is often the better one ([`dilation`]); what both leave is the answer.
//!
//! m comes from a solve on the cells in contact ([`crate::matrix_free::growth`]); a poor one widens the bounds, no more.

use super::bracket::{Trial, evened, lower};
use super::dilation;
use super::extension::Extension;
use super::field::{COEFFICIENTS, Field};
use super::of_gap::GapOverlap;
use super::overlap::{Interval, Plane};
use super::residual::{Halves, Quarter, Residual};
use crate::discrete::Discrete;
use crate::grid::{Grid, Kernel};
use crate::matrix_free::{self, growth};

/// How well flat punches are solved: their residual counts by its square in a_m.
const FLAT: f64 = 1e-4;

/// The same where their pressure was cut to tau p_h.
const CUT: f64 = 3e-3;

/// a_m over K, per share of the contact that may touch besides: chooses tau, where the bound is flat, and proves nothing.
const RING: f64 = 2.5;

/// Why there are no bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Missing {
    /// What lies beyond the grid, or beyond the displacement that is known.
    Beyond,
    /// Nothing narrow enough to be worth its time, on a larger grid either.
    TooWide,
}

/// Bounds of the force (E* = 1) of any gap at this depth, by a pressure on a grid.
/// `above_least`: the depth above what the gap is nowhere less than.
/// Bounds no wider than `enough`, relative to the force, are not made narrower.
pub(super) fn bounds(overlap: &GapOverlap, above_least: f64, trial: &Trial, enough: f64) -> Result<[f64; 2], Missing> {
    if trial.displacement_reaches() {
        let found = by_trial(overlap, above_least, trial, true, enough);
        if found != Err(Missing::Beyond) {
            return found;
        }
    }
    by_trial(overlap, above_least, trial, false, enough)
}

fn by_trial(
    overlap: &GapOverlap,
    above_least: f64,
    trial: &Trial,
    known: bool,
    enough: f64,
) -> Result<[f64; 2], Missing> {
    let (field, halves) = trial.field(overlap, known).ok_or(Missing::TooWide)?;
    let residual = Residual { field: &field, overlap, halves };
    if enough > 0.0 && is_rough(&residual) {
        return Err(Missing::TooWide);
    }
    let mut means = vec![[0.0; 2]; field.grid.len()];
    let [below, open] = lower(&residual, |i, j, mean| {
        images([i, j], field.grid.shape, halves).for_each(|k| means[k] = mean);
    });
    let set = residual.admissible().ok_or(Missing::Beyond)?;
    let mut dips = vec![f64::INFINITY; field.grid.len()];
    let of_residual = residual.norms_and_dips(&set, Some(&mut dips)).energy();
    let gamma = 0.5 * of_residual + open;
    if !(below > 0.0 && gamma.is_finite()) {
        return Err(Missing::Beyond);
    }
    // The contact alone, with all that may touch: where that is more than is under pressure, bounds are too wide for use.
    let loaded = trial.pressure.iter().filter(|p| **p > 0.0).count() as f64;
    let most = if enough > 0.0 { loaded } else { f64::INFINITY };
    let (touch, cells) = residual.may_touch(residual.deepest_dip(&dips), most).ok_or(Missing::Beyond)?;
    if cells > most {
        return Err(Missing::TooWide);
    }
    let dilated = dilation::bounds(&residual, &touch, below, gamma);
    if let Some([low, high]) = dilated.filter(|[low, high]| high - low <= enough * high) {
        return Ok([low, high]);
    }
    let ring = cells / loaded;
    if enough > 0.0 && !is_hopeful(&residual, ring, loaded, gamma, below / above_least, enough) {
        return dilated.ok_or(Missing::TooWide);
    }
    let cut = Cut::around(&field, &touch, halves);
    let contact = Contact { residual: &residual, means, cut, of_residual, gamma, ring };
    let any = contact.bounds(&touch, 2.0 * below / above_least * (1.0 - ROUNDING), above_least);
    let both = [dilated, any].into_iter().flatten().reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])]);
    both.filter(|[low, high]| low <= high).ok_or(Missing::Beyond)
}

/// Whether (5) may leave no more than what is enough, or a few times that: by the punch of a disc of the area of the contact. `force`: the
/// energy over the depth, between 1/3 and 1/2 of it.
fn is_hopeful(residual: &Residual, ring: f64, loaded: f64, gamma: f64, force: f64, enough: f64) -> bool {
    let punch = 2.0 * (loaded * residual.field.grid.cell_area() / std::f64::consts::PI).sqrt();
    (2.0 * gamma * RING * ring * punch).sqrt() <= HOPE * enough * 2.5 * force
}

/// How many times as wide as enough bounds may be expected to be and still be looked for.
const HOPE: f64 = 3.0;

/// Cells that are looked at for kinks.
const LOOKED_AT: usize = 64;

/// Share of cells with kinks from which on bounds are too wide to be worth their time.
const KINKED: f64 = 0.4;

/// Whether f has kinks in so many cells under pressure that little can be shown.
fn is_rough(residual: &Residual) -> bool {
    let field = residual.field;
    let [nx, ny] = field.grid.shape;
    let loaded: Vec<usize> =
        (0..nx * ny).filter(|k| field.pressure((k % nx) as isize, (k / nx) as isize) > 0.0).collect();
    let step = loaded.len().div_ceil(LOOKED_AT).max(1);
    let looked_at = || loaded.iter().step_by(step);
    let kinked = looked_at().filter(|k| {
        let rect = residual.rect((*k % nx) as isize, (*k / nx) as isize);
        residual.overlap.jet(&rect).is_none()
    });
    kinked.count() as f64 > KINKED * looked_at().count() as f64
}

/// What a few products change a bound by.
const ROUNDING: f64 = 1e-13;

/// Places of a cell and its images.
fn images([i, j]: [usize; 2], [nx, ny]: [usize; 2], halves: Halves) -> impl Iterator<Item = usize> {
    let columns = [Some(i), halves[0].then_some(nx - 1 - i)];
    let rows = [Some(j), halves[1].then_some(ny - 1 - j)];
    rows.into_iter().flatten().flat_map(move |j| columns.into_iter().flatten().map(move |i| j * nx + i))
}

/// A part of the cells of a grid, or some more around it.
#[derive(Clone, Copy)]
struct Cut {
    /// Its first cell, in the other grid.
    first: [isize; 2],
    shape: [usize; 2],
}

impl Cut {
    /// Around the cells under pressure and others, with one more on every side; in the middle where there are mirrors.
    fn around(field: &Field, others: &[Quarter], halves: Halves) -> Self {
        let [nx, ny] = field.grid.shape;
        let (mut low, mut high) = ([isize::MAX; 2], [isize::MIN; 2]);
        let mut hold = |at: [isize; 2]| {
            for m in 0..2 {
                let image = if halves[m] { field.grid.shape[m] as isize - 1 - at[m] } else { at[m] };
                low[m] = low[m].min(at[m]).min(image);
                high[m] = high[m].max(at[m]).max(image);
            }
        };
        for j in 0..ny as isize {
            let row = &field.pressures(0, j)[..nx];
            let loaded = |p: &f64| *p != 0.0;
            if let (Some(from), Some(to)) = (row.iter().position(loaded), row.iter().rposition(loaded)) {
                hold([from as isize, j]);
                hold([to as isize, j]);
            }
        }
        others.iter().for_each(|(i, j, _)| hold([*i, *j]));
        let first = low.map(|n| n - 1);
        Self { first, shape: [0, 1].map(|m| (high[m] + 2 - first[m]) as usize) }
    }

    fn grid(&self, of: &Grid) -> Grid {
        let at = |m: usize| of.origin[m] + self.first[m] as f64 * of.spacing[m];
        Grid { origin: [at(0), at(1)], spacing: of.spacing, shape: self.shape }
    }

    /// The cell of the other grid that cell k of this one is.
    fn cell(&self, k: usize) -> [isize; 2] {
        [(k % self.shape[0]) as isize + self.first[0], (k / self.shape[0]) as isize + self.first[1]]
    }
}

/// A pressure with its residual, and the part of its grid that flat punches are solved on.
struct Contact<'a> {
    residual: &'a Residual<'a>,
    /// Bounds of the means of f in the cells under pressure.
    means: Vec<Interval>,
    cut: Cut,
    /// a(w, w) with w = r under pressure.
    of_residual: f64,
    gamma: f64,
    /// What may touch besides, over what is under pressure.
    ring: f64,
}

/// The constant 1.
const ONE: Plane = Plane { level: 1.0, slope: [0.0; 2] };

impl Contact<'_> {
    fn field(&self) -> &Field {
        self.residual.field
    }

    /// (4) and (5); `at_least` and the flat punch are bounds besides.
    fn bounds(&self, touch: &[Quarter], at_least: f64, above_least: f64) -> Option<[f64; 2]> {
        let flat = self.flat()?;
        let below = self.below(&flat)?.max(at_least);
        let [from_below, from_above] = self.above(&flat, touch, above_least)?;
        Some([below.max(from_below), from_above])
    }

    /// Pressures on the cells of the cut.
    fn pressure(&self) -> Vec<f64> {
        (0..self.cut.shape[0] * self.cut.shape[1])
            .map(|k| self.cut.cell(k))
            .map(|[i, j]| self.field().pressure(i, j))
            .collect()
    }

    /// P_h + <r, m>, from below and from above.
    fn force_with(&self, m: &[f64]) -> [f64; 2] {
        let field = self.field();
        let (mut force, mut work, mut size, mut loads) = (0.0, [0.0; 2], 0.0, 0.0);
        for (k, m) in m.iter().enumerate() {
            let [i, j] = self.cut.cell(k);
            let p = field.pressure(i, j);
            force += p;
            if *m == 0.0 || p == 0.0 {
                continue;
            }
            let f = self.means[j as usize * field.grid.shape[0] + i as usize];
            let u = field.displacements(i, j)[0] * field.scale;
            let ends = f.map(|f| m * (f - u));
            work[0] += ends[0].min(ends[1]);
            work[1] += ends[0].max(ends[1]);
            size += m.abs() * (f[0].abs().max(f[1].abs()) + u.abs());
            loads += m.abs();
        }
        let terms = f64::EPSILON * (m.len() + 8) as f64;
        let off = size * (terms + 2.0 * COEFFICIENTS) + loads * field.rounding * field.scale + force * terms;
        let area = field.grid.cell_area();
        [area * (force + work[0] - off) * (1.0 - ROUNDING), area * (force + work[1] + off) * (1.0 + ROUNDING)]
    }

    /// The pressure of a flat punch on the cells under pressure, nearly.
    fn flat(&self) -> Option<Vec<f64>> {
        let pressure = self.pressure();
        self.grown(&pressure, &vec![1.0; pressure.len()], FLAT)
    }

    /// S m = rates where `cells` are positive, nearly; m = 0 elsewhere.
    fn grown(&self, cells: &[f64], rates: &[f64], tolerance: f64) -> Option<Vec<f64>> {
        let grid = self.cut.grid(&self.field().grid);
        let problem = Discrete { grid, kernel: Kernel::Galerkin, overlap: vec![1.0; grid.len()] };
        let settings = matrix_free::Settings { tolerance, ..matrix_free::Settings::default() };
        let grown = growth(&problem, cells, rates, &settings).ok()?;
        Some(evened(&grown, grid.shape, self.residual.halves))
    }

    /// The displacement by m, and a bound of a(w, w) for w = 1 - S m on the cells under pressure and on quarters besides.
    fn flatness(&self, m: &[f64], besides: &[Quarter]) -> Option<(Field, f64)> {
        let field = Field::new(&self.cut.grid(&self.field().grid), m)?;
        let (halves, first) = (self.residual.halves, self.cut.first);
        let loaded = |i: usize, j: usize| self.field().pressure(i as isize + first[0], j as isize + first[1]) > 0.0;
        let mut set = Extension::of_cells(self.cut.shape, loaded);
        besides.iter().for_each(|(i, j, q)| set.cover(i - first[0], j - first[1], *q, halves));
        if set.reaches_border() {
            return None;
        }
        let energy = Residual { field: &field, overlap: &ONE, halves }.norms(&set).energy();
        energy.is_finite().then_some((field, energy))
    }

    /// (4).
    fn below(&self, m: &[f64]) -> Option<f64> {
        let (_, of_flat) = self.flatness(m, &[])?;
        Some(self.force_with(m)[0] - (self.of_residual * of_flat).sqrt() * (1.0 + ROUNDING))
    }

    /// (5), and what the same m shows from below.
    fn above(&self, flat: &[f64], touch: &[Quarter], above_least: f64) -> Option<[f64; 2]> {
        let p = self.pressure();
        let area = self.field().grid.cell_area();
        let stiffness = flat.iter().sum::<f64>() * area;
        let loaded = p.iter().filter(|p| **p > 0.0).count() as f64;
        let tau = (RING * (self.ring + 1.0 / loaded.sqrt()) * stiffness / (2.0 * self.gamma)).sqrt();
        let cut = |m: &[f64]| -> Vec<f64> { m.iter().zip(&p).map(|(m, p)| m.clamp(0.0, tau * p)).collect() };
        let mut m = cut(flat);
        // What was cut off is made good by the cells that are not.
        let kept: Vec<f64> =
            flat.iter().zip(&p).map(|(m, p)| if *p > 0.0 && *m < tau * p { 1.0 } else { 0.0 }).collect();
        if kept.iter().zip(&p).any(|(kept, p)| *kept == 0.0 && *p > 0.0) {
            let field = Field::new(&self.cut.grid(&self.field().grid), &m)?;
            let [nx, ny] = self.cut.shape;
            let left = |k: usize| 1.0 - field.displacements((k % nx) as isize, (k / nx) as isize)[0] * field.scale;
            let rates: Vec<f64> = (0..nx * ny).map(left).collect();
            let more = self.grown(&kept, &rates, CUT)?;
            m = cut(&m.iter().zip(&more).map(|(m, more)| m + more).collect::<Vec<f64>>());
        }
        let (field, of_flat) = self.flatness(&m, touch)?;
        let gamma = self.gamma;
        let best = (of_flat / (2.0 * gamma)).sqrt();
        let inside = (2.0 * gamma * of_flat).sqrt();
        let tau = tau * (1.0 + ROUNDING);
        let missed = if tau <= best { inside } else { tau * gamma + of_flat / (2.0 * tau) };
        let [low, high] = self.force_with(&m);
        let above = high + missed * (1.0 + ROUNDING);
        // K(A') <= 2 <1, m> - <m, S m> + a(w, w), with <m, S m> from below.
        let [nx, _] = self.cut.shape;
        let (mut punch, mut size) = (0.0, 0.0);
        for (k, m) in m.iter().enumerate().filter(|(_, m)| **m != 0.0) {
            let u = field.displacements((k % nx) as isize, (k / nx) as isize)[0] * field.scale;
            punch += m * (2.0 - u);
            size += m * (2.0 + u + field.rounding * field.scale);
        }
        let off = size * (f64::EPSILON * (m.len() + 8) as f64 + 2.0 * COEFFICIENTS)
            + m.iter().sum::<f64>() * field.rounding * field.scale;
        let punch = area * (punch + off) + of_flat;
        let simple = above_least * punch * (1.0 + ROUNDING);
        Some([low - inside * (1.0 + ROUNDING), above.min(simple)])
    }
}
