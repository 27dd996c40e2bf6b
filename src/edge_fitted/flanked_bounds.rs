//! Bounds of the force of a flat with flanks (`force`), on cells of the flat and on rows of its flanks.
//!
//! Where the contact ends is found first, on fewer cells (`flanked_ends`). The rows reach a little farther, so that beside them S p is
//! larger than f and what (5) asks for is shown at a short distance.

use std::f64::consts::FRAC_PI_2;

use super::Limits;
use super::active_set::{factor, solve, solve_on};
use super::discrete::Discretisation;
use super::fade::widened;
use super::flanked::Flat;
use super::flanked_ends::Ends;
use super::flanked_mesh::{Flanked, Lines};
use super::force::{Bounds, Continuation, Pressures, Problem};
use super::line_potential::{BATCH, Points, Scratch};
use super::mesh::{Bilinear, Mesh, Point, cross, dot, minus, norm};
use super::rectilinear::{graded, graded_both};
use super::residual_norm::decay_lengths;
use crate::numeric::geometry::area;

/// A contact with bounds of its force, E* = 1.
pub(crate) struct Bounded {
    pub bounds: Bounds,
    /// dP/dd of the cells under pressure and of all that reach farther.
    pub stiffness: [f64; 2],
    /// The area of the contact, and an estimate of its relative error.
    pub area: f64,
    pub area_error: f64,
    /// Where the contact ends: a closed line.
    pub end: Vec<Point>,
    /// Corners and pressure of the cells.
    pub cells: Vec<([Point; 4], f64)>,
    pub unknowns: usize,
}

/// Cells from the middle to the sides that are mostly enough for an error of 1e-3, where no corner turns by more than a right angle.
const ENOUGH: f64 = 8.8;
/// The order that bounds close with.
const ORDER: f64 = 2.5;
/// Meshes at most.
const ROUNDS: usize = 3;
/// Grading from the middle to the sides; the last cell is cut until it is no thicker than some rows.
const EXPONENT: f64 = 3.0;
const CUT: f64 = 5.0;
const THICKEST: f64 = 10.0;
/// Rows of half of a flank, of those by which its end is found first and then, and their grading.
const ROWS: [usize; 3] = [3, 2, 3];
const ROW_EXPONENT: f64 = 2.0;
/// Rows are no thinner than this, over the size of the flat: pair integrals would not tell them apart.
const THINNEST: f64 = 1e-5;
/// How much farther than the contact they may reach for that: bounds that take more are too wide.
const WIDEST: f64 = 8.0;
/// Cells of the meshes that the end is found on first, and how often.
const FEW: usize = 5;
const MOVES: usize = 2;
/// Rows around the contact, what each is thicker by than the one before, and how far they go, over the end of the contact.
const AROUND: [usize; 2] = [2, 8];
const THICKER: f64 = 1.7;
const FAR: f64 = 1.8;
/// Height of the first of them, where there are enough: by as much as the gap rises there the residual of cells is outweighed.
const FIRST: f64 = 0.008;
/// How much farther the rows reach where no bounds are found, and how often.
const FARTHER: f64 = 0.1;
const TRIES: usize = 3;

/// What the area of the strip beyond the flat may be off by, over it and over growth^(-1/2): 0.78, 0.18, 0.12, 0.08 and 0.015 of it are seen at a
/// growth of 0.003, 0.01, 0.03, 0.1 and 0.3 (three, four and eight sides).
const OF_STRIP: f64 = 0.06;

/// Bounds of the force within the tolerance, or as near as they come. `None` where none are found, and once the time is used up.
pub(crate) fn flanked_bounds(flat: &Flat, limits: &Limits) -> Option<Bounded> {
    let group = flat.group();
    let mesh = |flanked: Flanked| -> Option<(Flanked, Discretisation)> {
        let own = Discretisation::within(flanked.mesh.clone(), &group, limits.unknowns, limits.means())?;
        Some((flanked, own))
    };
    let settled = |ends: &Ends, n: usize, rows: usize| -> Option<Ends> {
        let (flanked, mesh) = mesh(Flanked::new(flat, &coarse(flat, ends, n, rows), ends)?)?;
        let all = vec![true; mesh.orbits.loaded];
        let pressure = solve_on(&factor(&mesh.compliance, &all)?, &all, &integrals(&flanked, &mesh));
        Some(ends.moved(&flanked, &|cell| pressure[mesh.orbits.orbit[cell]]).no_nearer(flat, 2.0 * THINNEST))
    };
    let guess = Ends::guess(flat);
    if 2.0 * THINNEST > WIDEST * guess.nearest(flat) {
        return None;
    }
    let mut ends = guess.no_nearer(flat, 2.0 * THINNEST);
    let enough = ENOUGH * (sharpest(flat.corners) / FRAC_PI_2).max(1.0);
    let mut n = (enough * (1e-3 / limits.tolerance).powf(1.0 / ORDER)).round().max(3.0) as usize;
    let fits = |ends: &Ends, n: usize| {
        let flanked = Flanked::new(flat, &fine(flat, ends, n), ends);
        flanked.is_some_and(|flanked| flanked.mesh.loaded <= limits.unknowns * group.len().max(1))
    };
    if !fits(&ends, n) {
        return None;
    }
    for _ in 0..MOVES {
        ends = settled(&ends, FEW, ROWS[2])?;
    }
    let mut best: Option<Bounded> = None;
    for _ in 0..ROUNDS {
        let Some(own) = settled(&ends, n, ROWS[1]) else { return best };
        ends = own;
        let tries = (0..TRIES).map(|k| reach(flat.growth) + FARTHER * k as f64);
        let found = tries.into_iter().find_map(|reach| {
            let ends = ends.reaching(reach);
            let (flanked, mesh) = mesh(Flanked::new(flat, &fine(flat, &ends, n), &ends)?)?;
            Solved::new(flanked, mesh).bounded(flat)
        });
        let Some(found) = found else { return best };
        let width = found.width();
        if best.as_ref().is_none_or(|best| width < best.width()) {
            best = Some(found);
        }
        if width <= limits.tolerance {
            break;
        }
        n = ((n as f64 * (1.1 * width / limits.tolerance).powf(1.0 / ORDER)).ceil() as usize).clamp(n + 1, 2 * n);
        if !fits(&ends, n) {
            break;
        }
    }
    best
}

/// The largest angle that a convex polygon turns by at a corner.
fn sharpest(corners: &[Point]) -> f64 {
    let count = corners.len();
    let turn = |k: usize| {
        let side = |k: usize| minus(corners[(k + 1) % count], corners[k % count]);
        let (u, v) = (side(k), side(k + 1));
        cross(u, v).atan2(dot(u, v))
    };
    (0..count).map(turn).fold(0.0, f64::max)
}

/// How much farther the rows reach than the contact: what that costs falls with the square of the growth.
fn reach(growth: f64) -> f64 {
    (1.25 - 0.45 * growth.sqrt()).max(1.0)
}

/// tau times the depth.
fn tau(growth: f64) -> f64 {
    6.0 + 50.0 * growth.min(1.0)
}

/// Lines of a mesh that the end is found on.
fn coarse(flat: &Flat, ends: &Ends, n: usize, half_rows: usize) -> Lines {
    lines(flat, ends, n, half_rows, 1)
}

fn fine(flat: &Flat, ends: &Ends, n: usize) -> Lines {
    let [least, most] = AROUND;
    let height = level(ends) - ends.lowest();
    let first = |rows: usize| height * (THICKER - 1.0) / (THICKER.powi(rows as i32) - 1.0);
    let around = (least..=most).rev().find(|&rows| first(rows) >= FIRST).unwrap_or(least);
    lines(flat, ends, n, ROWS[0], around)
}

/// The height of the level line that the rows around the contact go to.
fn level(ends: &Ends) -> f64 {
    (FAR * ends.highest()).min(1.0)
}

fn lines(flat: &Flat, ends: &Ends, n: usize, half_rows: usize, around: usize) -> Lines {
    let thinnest = |half: usize| 0.5 * (half as f64).powf(-ROW_EXPONENT) * ends.nearest(flat);
    let half_rows = (2..=half_rows).rev().find(|&half| thinnest(half) >= THINNEST).unwrap_or(1);
    let rows = graded_both(0.0, 1.0, half_rows, ROW_EXPONENT);
    let mut inside = graded(-1.0, 1.0, n, EXPONENT);
    let thinnest = THICKEST * rows[1] * ends.nearest(flat);
    let mut last = 1.0 - inside[n - 1];
    while last > 2.0 * thinnest {
        last /= CUT;
        inside.insert(inside.len() - 1, 1.0 - last);
    }
    let part = |i: usize| (THICKER.powi(i as i32) - 1.0) / (THICKER.powi(around as i32) - 1.0);
    let mut beyond = vec![level(ends)];
    while beyond[beyond.len() - 1] < 1.0 {
        beyond.push((2.0 * beyond[beyond.len() - 1]).min(1.0));
    }
    Lines { inside, rows, around: (0..=around).map(part).collect(), beyond }
}

/// Of the overlap over each orbit of loaded cells.
fn integrals(flanked: &Flanked, mesh: &Discretisation) -> Vec<f64> {
    let of = |orbit: usize| {
        let cell = mesh.orbits.representatives[orbit];
        let [area, x, y] = Bilinear::new(mesh.mesh.corners(cell)).moments();
        let [c, a, b] = flanked.planes[cell].0;
        mesh.orbits.size[orbit] as f64 * (c * area + a * x + b * y)
    };
    (0..mesh.orbits.loaded).map(of).collect()
}

impl Bounded {
    /// Half of it, relative.
    pub fn width(&self) -> f64 {
        let [low, high] = self.bounds.force;
        (high - low) / (high + low)
    }
}

/// A solved mesh.
struct Solved {
    flanked: Flanked,
    mesh: Discretisation,
    integrals: Vec<f64>,
    pressure: Vec<f64>,
}

impl Solved {
    fn new(flanked: Flanked, mesh: Discretisation) -> Self {
        let integrals = integrals(&flanked, &mesh);
        let pressure = solve(&mesh.compliance, &integrals);
        Self { flanked, mesh, integrals, pressure }
    }

    fn bounded(&self, flat: &Flat) -> Option<Bounded> {
        let Self { flanked, mesh: d, integrals, pressure } = self;
        let mesh = &d.mesh;
        let cells = mesh.cells.len();
        let candidate: Vec<bool> = {
            let mut candidate = vec![false; mesh.loaded];
            for flank in &flanked.flanks {
                flank.cells.last().into_iter().flatten().for_each(|&cell| candidate[cell] = true);
            }
            candidate
        };
        // Beyond the supposed end only what is in contact.
        let set: Vec<bool> = (0..pressure.len())
            .map(|orbit| pressure[orbit] > 0.0 || !candidate[d.orbits.representatives[orbit]])
            .collect();
        let near = widened(mesh, &vec![true; mesh.loaded], cells);
        let off = flanked.off_from(flat.planes, &near) + flat.rounding;
        let problem = Problem {
            mesh: d,
            planes: &flanked.planes,
            integrals,
            material: cells,
            off,
            tau: tau(flat.growth),
            continuation: &|pressures| self.continuation(pressures),
        };
        let mut bounds = problem.bounds(&set)?;
        // A disc around all of an overlap that is higher by `off` adds no less.
        let radius = mesh.nodes.iter().map(|p| norm(*p)).fold(0.0, f64::max);
        let more = 2.1 * radius * off;
        for [low, high] in [&mut bounds.force, &mut bounds.energy] {
            (*low, *high) = (*low - more, *high + more);
        }
        let contact: Vec<bool> = pressure.iter().map(|p| *p > 0.0).collect();
        let stiffness = |set: &[bool]| -> Option<f64> {
            let m = solve_on(&factor(&d.compliance, set)?, set, &d.areas);
            Some(m.iter().zip(&d.areas).map(|(m, a)| m * a).sum())
        };
        let area_of = |set: &[bool]| d.areas.iter().zip(set).filter(|(_, on)| **on).map(|(area, _)| area).sum::<f64>();
        let (within, wider) = (area_of(&contact), area_of(&set));
        let middle = 0.5 * (within + wider);
        let of_strip = (OF_STRIP / flat.growth.sqrt()).min(1.0) * (middle - area(flat.corners)).max(0.0);
        let of = |cell: usize| pressure[d.orbits.orbit[cell]];
        Some(Bounded {
            bounds,
            stiffness: [stiffness(&contact)?, stiffness(&set)?],
            area: middle,
            area_error: (0.5 * (wider - within) + of_strip) / middle,
            end: self.end(&of),
            cells: (0..mesh.loaded).filter(|&cell| of(cell) > 0.0).map(|cell| (mesh.corners(cell), of(cell))).collect(),
            unknowns: d.orbits.loaded,
        })
    }

    /// The middles of the outer sides of the last cells in contact.
    fn end(&self, pressure: &dyn Fn(usize) -> f64) -> Vec<Point> {
        let mut end = Vec::new();
        for flank in &self.flanked.flanks {
            for j in 0..flank.shares.len() - 1 {
                let row = flank.cells.iter().rposition(|cells| pressure(cells[j]) > 0.0).map_or(0, |row| row + 1);
                let [a, b] = [0, 1].map(|i| self.mesh.mesh.nodes[flank.lines[row][j + i]]);
                end.push([0, 1].map(|m| 0.5 * (a[m] + b[m])));
            }
        }
        end
    }

    /// chi' falls along every line up a flank from the cells around the contact to where v is within tau |r|, and l0 rises with the distance
    /// from it. `None` where v is not.
    fn continuation(&self, pressures: Pressures) -> Option<Continuation> {
        let Pressures { contact, strengths, tau } = pressures;
        let Self { flanked, mesh: d, .. } = self;
        let mesh: &Mesh = &d.mesh;
        let nodes_of = |cells: &[bool]| {
            let mut on = vec![false; mesh.nodes.len()];
            let cells = mesh.cells.iter().zip(cells).filter(|(_, on)| **on);
            cells.for_each(|(cell, _)| cell.iter().for_each(|&n| on[n] = true));
            on
        };
        let (touching, around) = (nodes_of(contact), nodes_of(&widened(mesh, contact, mesh.cells.len())));
        let mut chi: Vec<f64> = around.iter().map(|on| if *on { 1.0 } else { 0.0 }).collect();
        let mut decay = decay_lengths(mesh);
        let mut needed = vec![false; mesh.nodes.len()];
        d.orbits.representatives.iter().for_each(|&cell| mesh.cells[cell].iter().for_each(|&n| needed[n] = true));
        let mut scratch = Scratch::default();
        for flank in &flanked.flanks {
            for j in 0..flank.ends.len() {
                let line: Vec<usize> = flank.lines.iter().map(|line| line[j]).collect();
                let (Some(end), Some(last)) = (
                    line.iter().rposition(|&n| touching[n]),
                    line.iter().rposition(|&n| around[n]).filter(|_| line.iter().any(|&n| needed[n])),
                ) else {
                    continue;
                };
                // From the last node where chi' is 1.
                let rest = &line[last..];
                let height = |i: usize| flanked.heights[rest[i]];
                let mut points = Points::EMPTY;
                rest.iter().take(BATCH).for_each(|&n| points.push(mesh.nodes[n]));
                let fields = d.lines.fields(strengths, &points, &mut scratch);
                let part = |i: usize, to: f64| ((height(i) - height(0)) / (to - height(0))).min(1.0);
                let close = |to: f64| {
                    (1..points.len).all(|i| {
                        let (r, v) = (1.0 - height(i) - fields[0].u[i], 1.0 - fields[1].u[i]);
                        part(i, to) * v <= ROOM * tau * -r
                    })
                };
                let to = (1..points.len).map(height).find(|to| close(*to))?;
                (1..rest.len()).for_each(|i| chi[rest[i]] = 1.0 - part(i, to));
                let distance = |n: usize| norm(minus(mesh.nodes[n], mesh.nodes[line[end]]));
                let zero = line.iter().position(|&n| chi[n] == 0.0).unwrap_or(line.len() - 1);
                let most = 0.5 * distance(line[zero]);
                let least = decay[line[end]];
                line[end + 1..].iter().for_each(|&n| decay[n] = least + distance(n).min(most) / OF_CELLS);
            }
        }
        Some(Continuation { chi, decay })
    }
}

/// Room for what nodes do not see.
const ROOM: f64 = 0.6;

/// l over l0 where it is best for residuals on cells.
const OF_CELLS: f64 = 0.3;
