//! An upper bound of a(w, w) for w = f - S p on the cells in contact, continued and faded beyond them.
//!
//! With Phi = w(x) exp(-z/l(x)), l > 0 Lipschitz, in the half-space's Dirichlet principle (E* = 1):
//!
//! ```text
//! a(w, w) <= 1/4 int [ l |grad w|^2 + w grad w . grad l + w^2 (1 + |grad l|^2/2)/l ] dx.                              (2)
//! ```
//!
//! l = c l0 with l0 bilinear in every cell, so the right side is (c alpha + beta/c)/4. alpha and beta are sums over subcells of
//! the squares of interpolants, plus what interpolation leaves out (`interpolation`), joined by the triangle inequality:
//! (2) is the square of a norm of the pair (w, grad w).

use super::Means;
use super::fade::{Fades, Panel};
use super::group::{Group, Sources, groups};
use super::integrand::Sums;
use super::line_potential::{Lines, Scratch};
use super::mesh::{Bilinear, Mesh, cross, norm};
use super::subdivision::{Context, Shares, Work};
use super::surroundings::Surroundings;
use super::symmetry::Orbits;
use crate::threads::all;

/// A pressure, and the displacement that it is meant to make.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target<'a> {
    /// Of the loaded cells; zero without contact.
    pub pressure: &'a [f64],
    pub overlap: Overlap<'a>,
}

/// f as value + slope . x.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Overlap<'a> {
    /// The same on all cells.
    Plane([f64; 3]),
    /// One for each cell, continuous from cell to cell, with what is left out of its slope and its value.
    Planes(&'a [([f64; 3], [f64; 2])]),
}

impl<'a> Target<'a> {
    /// A level punch at depth 1.
    pub fn level(pressure: &'a [f64]) -> Self {
        Self { pressure, overlap: Overlap::Plane([1.0, 0.0, 0.0]) }
    }
}

impl Overlap<'_> {
    fn of(&self, cell: usize) -> ([f64; 3], [f64; 2]) {
        match self {
            Self::Plane(plane) => (*plane, [0.0; 2]),
            Self::Planes(planes) => planes[cell],
        }
    }
}

/// Where there is no contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beyond<'a> {
    /// The loaded cells in contact.
    pub contact: &'a [bool],
    /// chi' of `beyond` at the nodes.
    pub wider: &'a [f64],
    /// l0 of v at the nodes, where chi' is positive beyond the cells in contact.
    pub decay: &'a [f64],
    /// Cells up to here may touch; the others lie beyond the material.
    pub material: usize,
    /// tau of `beyond`.
    pub tau: f64,
}

/// What `beyond` and `force` need of two pressures, p and m: the sums of w, and those of v, faded from the cells in contact and from the
/// wider set.
pub(crate) struct Parted {
    pub residual: Sums,
    pub punch: Sums,
    pub wider: Sums,
}

/// The sums of (2) for pressures on the cells in `contact`, w = f - S p there, over one cell of each orbit; `None` once the
/// time is used up, and where a panel has no end of subcells.
pub(crate) fn norms<const K: usize>(
    mesh: &Mesh,
    lines: &Lines,
    orbits: &Orbits,
    decay: &[f64],
    contact: &[bool],
    targets: [Target; K],
    means: Means,
) -> Option<[Sums; K]> {
    let scan = Scan { mesh, lines, orbits, decay, targets, pairs: &[], beyond: None, means };
    let norms = scan.sums(&Fades::of(mesh, contact))?;
    Some(norms.own.map(|[own, _]| own))
}

/// The same with those of the sums w_i + w_j of some pairs, at most [`super::subdivision::PAIRS`], over cells that are all in contact; what
/// interpolation leaves out of these is not told.
pub(crate) fn norms_of_pairs<const K: usize>(
    mesh: &Mesh,
    lines: &Lines,
    orbits: &Orbits,
    decay: &[f64],
    targets: [Target; K],
    pairs: &[[usize; 2]],
    means: Means,
) -> Option<([Sums; K], Vec<Sums>)> {
    let scan = Scan { mesh, lines, orbits, decay, targets, pairs, beyond: None, means };
    let Shares { own, joint } = scan.sums(&Fades::of(mesh, &vec![true; mesh.loaded]))?;
    Some((own.map(|[own, _]| own), joint[..pairs.len()].to_vec()))
}

/// The same for p, and m of the flat punch, where there is material without contact; `None` too where its signs cannot be shown.
pub(crate) fn parted(
    mesh: &Mesh,
    lines: &Lines,
    orbits: &Orbits,
    decay: &[f64],
    beyond: Beyond,
    targets: [Target; 2],
    means: Means,
) -> Option<Parted> {
    let fades = Fades::new(mesh, beyond.contact, beyond.wider, beyond.material);
    let scan = Scan { mesh, lines, orbits, decay, targets, pairs: &[], beyond: Some(beyond), means };
    let [[residual, _], [punch, wider]] = scan.sums(&fades)?.own;
    Some(Parted { residual, punch, wider })
}

/// What the sums are taken of.
struct Scan<'a, const K: usize> {
    mesh: &'a Mesh,
    lines: &'a Lines,
    orbits: &'a Orbits,
    decay: &'a [f64],
    targets: [Target<'a>; K],
    pairs: &'a [[usize; 2]],
    beyond: Option<Beyond<'a>>,
    means: Means,
}

impl<const K: usize> Scan<'_, K> {
    /// Of every target, faded from the cells in contact and from the wider set.
    fn sums(&self, fades: &Fades) -> Option<Shares<K>> {
        let Self { mesh, lines, orbits, targets, .. } = self;
        let pressures = targets.map(|target| target.pressure);
        let strengths: Vec<Vec<f64>> = pressures.iter().map(|p| Lines::strengths(mesh, p)).collect();
        let strengths: [&[f64]; K] = std::array::from_fn(|k| strengths[k].as_slice());
        let mut sources = Sources::new(mesh, lines, pressures, strengths);
        let mut panels: Vec<Vec<Panel>> = (0..mesh.cells.len()).map(|_| Vec::new()).collect();
        for &cell in &orbits.representatives {
            panels[cell] = fades.panels(mesh, cell, strengths);
        }
        let cells: Vec<usize> = orbits.representatives.iter().copied().filter(|&c| !panels[c].is_empty()).collect();
        let signs = |cell: usize| self.beyond.is_some() && panels[cell].iter().any(|panel| panel.chi[0] != [1.0; 4]);
        let (beyond, inside): (Vec<usize>, Vec<usize>) = cells.into_iter().partition(|&cell| signs(cell));
        beyond.iter().for_each(|&cell| sources.signs[cell] = true);
        let allowances = sources.allowances(self.decay);
        // What may fail comes first.
        let wide: Vec<Vec<Vec<usize>>> = groups(mesh, beyond).into_iter().chain(groups(mesh, inside)).collect();
        let threads = self.means.of(wide.iter().flatten().flatten().count());
        let everything = Group::of_all(&sources);
        let within = |outer, cells: &[usize]| Group::within(outer, &sources, cells, &mut Scratch::default());
        let outer = all(&wide, threads, |cells| Some(within(&everything, &cells.concat())))?;
        let inner: Vec<(&Group<K>, &[usize])> = outer
            .iter()
            .zip(&wide)
            .flat_map(|(outer, wide)| wide.iter().map(move |cells| (outer, cells.as_slice())))
            .collect();
        // Added up group by group: the number of threads does not change the sums.
        let of_groups = all(&inner, threads, |&(outer, cells)| {
            let (group, mut work, mut own) = (within(outer, cells), Work::default(), Shares::zero());
            for &cell in cells {
                if self.means.deadline.has_passed() {
                    return None;
                }
                let size = orbits.size[orbits.orbit[cell]] as f64;
                let of_cell = self.of_cell(cell, &sources, &group, allowances[cell], &panels[cell], &mut work)?;
                own.add(size, &of_cell);
            }
            Some(own)
        })?;
        let mut sums = Shares::zero();
        of_groups.iter().for_each(|own| sums.add(1.0, own));
        Some(sums)
    }

    /// Of one cell.
    fn of_cell(
        &self,
        cell: usize,
        sources: &Sources<K>,
        group: &Group<K>,
        allowance: f64,
        panels: &[Panel],
        work: &mut Work<K>,
    ) -> Option<Shares<K>> {
        let Self { mesh, lines, targets, pairs, beyond, .. } = self;
        let context = Context {
            lines,
            decay: mesh.cells[cell].map(|n| self.decay[n]),
            wider: mesh.cells[cell].map(|n| beyond.map_or(self.decay[n], |beyond| beyond.decay[n])),
            extent: mesh.extent(),
            allowance,
            strengths: sources.strengths,
            pairs,
            overlap: targets.map(|target| target.overlap.of(cell)),
            tau: beyond.map(|beyond| beyond.tau),
            surroundings: Surroundings::new(sources, group, cell, &mut work.scratch),
        };
        let mut own = Shares::zero();
        for panel in panels {
            context.subdivide(panel, &mut own, work)?;
        }
        context.flush(&mut own, work, &mut Vec::new())?;
        Some(own)
    }
}

/// l0 at the nodes: the geometric mean of (h_s^-2 + h_t^-2)^(-1/2) over the cells that meet there.
pub(crate) fn decay_lengths(mesh: &Mesh) -> Vec<f64> {
    // Sums of logarithms, and of how many.
    let mut sums = vec![(0.0, 0.0); mesh.nodes.len()];
    for (cell, nodes) in mesh.cells.iter().enumerate() {
        let map = Bilinear::new(mesh.corners(cell));
        let [u, v] = map.along;
        let area = cross(u, v).abs();
        // Distances between opposite sides.
        let (hs, ht) = (2.0 * area / norm(v), 2.0 * area / norm(u));
        for &n in nodes {
            sums[n].0 -= 0.5 * (hs.powi(-2) + ht.powi(-2)).ln();
            sums[n].1 += 1.0;
        }
    }
    sums.into_iter().map(|(sum, count): (f64, f64)| (sum / count.max(1.0)).exp()).collect()
}
