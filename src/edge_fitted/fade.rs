//! The factor chi: 1 on a set of cells, falling to 0 over half of the cells around, bilinear in quarters of cells; and a wider one, bilinear
//! in the cells of the material.

use std::collections::HashSet;

use super::mesh::{Bilinear, Mesh};
use super::subcell::Subcell;

/// Where chi is 1: nodes and sides of the cells of the set, besides those cells themselves.
struct Fade<'a> {
    set: &'a [bool],
    node: Vec<bool>,
    /// Sides of cells of the set, by their nodes in rising order.
    side: HashSet<[usize; 2]>,
}

/// The factors of the cells in contact, and a wider one that is 1 on all cells around these.
pub(crate) struct Fades<'a> {
    contact: Fade<'a>,
    /// At the nodes.
    wider: Option<&'a [f64]>,
    /// Cells from here on lie beyond the material.
    material: usize,
}

/// A subcell over which both factors are bilinear, with the values at its corners.
pub(crate) struct Panel {
    pub subcell: Subcell,
    /// Of the cells in contact, and of the wider set.
    pub chi: [[f64; 4]; 2],
    /// Whether bodies may touch there.
    pub material: bool,
}

impl<'a> Fade<'a> {
    fn new(mesh: &Mesh, set: &'a [bool]) -> Self {
        let mut node = vec![false; mesh.nodes.len()];
        let mut side = HashSet::new();
        for (nodes, _) in mesh.cells.iter().zip(set).filter(|(_, on)| **on) {
            for k in 0..4 {
                let (a, b) = (nodes[k], nodes[(k + 1) % 4]);
                node[a] = true;
                side.insert([a.min(b), a.max(b)]);
            }
        }
        Self { set, node, side }
    }

    fn holds(&self, cell: usize) -> bool {
        self.set.get(cell) == Some(&true)
    }

    /// chi at the corners, the middles of the sides and the centre of a cell without contact.
    fn values(&self, mesh: &Mesh, cell: usize) -> [f64; 9] {
        let nodes = mesh.cells[cell];
        let one = |b: bool| if b { 1.0 } else { 0.0 };
        let corner = [0, 1, 2, 3].map(|k| one(self.node[nodes[k]]));
        let middle = [0, 1, 2, 3].map(|k| {
            let (a, b) = (nodes[k], nodes[(k + 1) % 4]);
            one(if a == b { self.node[a] } else { self.side.contains(&[a.min(b), a.max(b)]) })
        });
        [corner[0], corner[1], corner[2], corner[3], middle[0], middle[1], middle[2], middle[3], 0.0]
    }
}

/// The cells of a set and all of the first `material` that have a node with one of them.
pub(crate) fn widened(mesh: &Mesh, set: &[bool], material: usize) -> Vec<bool> {
    let fade = Fade::new(mesh, set);
    mesh.cells[..material].iter().map(|nodes| nodes.iter().any(|&n| fade.node[n])).collect()
}

impl<'a> Fades<'a> {
    /// One factor for a contact everywhere.
    pub fn of(mesh: &Mesh, contact: &'a [bool]) -> Self {
        Self { contact: Fade::new(mesh, contact), wider: None, material: mesh.loaded }
    }

    /// `wider`: at the nodes; zero at those beyond the material.
    pub fn new(mesh: &Mesh, contact: &'a [bool], wider: &'a [f64], material: usize) -> Self {
        Self { contact: Fade::new(mesh, contact), wider: Some(wider), material }
    }

    /// The wider factor at the corners, the middles of the sides and the centre of a cell: beyond the material it falls to 0 over half of
    /// the cell.
    fn wider(&self, mesh: &Mesh, cell: usize) -> Option<[f64; 9]> {
        let corner = mesh.cells[cell].map(|n| self.wider.map(|wider| wider[n]));
        let [a, b, c, d] = [corner[0]?, corner[1]?, corner[2]?, corner[3]?];
        let within = cell < self.material;
        let mean = |a: f64, b: f64| if within || (a > 0.0 && b > 0.0) { 0.5 * (a + b) } else { 0.0 };
        let centre = if within { 0.25 * (a + b + c + d) } else { 0.0 };
        Some([a, b, c, d, mean(a, b), mean(b, c), mean(c, d), mean(d, a), centre])
    }

    /// The parts of a cell, over each of which chi is bilinear, where it is positive or bodies may touch.
    pub fn panels<const K: usize>(&self, mesh: &Mesh, cell: usize, strengths: [&[f64]; K]) -> Vec<Panel> {
        let whole = whole(mesh, cell, strengths);
        let material = cell < self.material;
        if self.contact.holds(cell) {
            return vec![Panel { subcell: whole, chi: [[1.0; 4]; 2], material }];
        }
        let own = self.contact.values(mesh, cell);
        let chi = [own, self.wider(mesh, cell).unwrap_or(own)];
        if chi[0] == [0.0; 9] && (material || chi[1] == [0.0; 9]) {
            let chi = chi.map(|chi| [chi[0], chi[1], chi[2], chi[3]]);
            return if material { vec![Panel { subcell: whole, chi, material }] } else { Vec::new() };
        }
        // Values 0 to 3 at the corners, 4 to 7 at the middles of the sides, 8 at the centre.
        let quarters = [
            ([0, 4, 8, 7], [-1.0, -1.0]),
            ([4, 1, 5, 8], [0.0, -1.0]),
            ([8, 5, 2, 6], [0.0, 0.0]),
            ([7, 8, 6, 3], [-1.0, 0.0]),
        ];
        let part = |(corners, [s, t]): ([usize; 4], [f64; 2])| Panel {
            subcell: whole.part(0, s, s + 1.0).part(1, t, t + 1.0),
            chi: chi.map(|chi| corners.map(|c| chi[c])),
            material,
        };
        quarters.into_iter().map(part).filter(|panel| material || panel.chi != [[0.0; 4]; 2]).collect()
    }
}

/// A cell with the edges at which some pressure jumps.
fn whole<const K: usize>(mesh: &Mesh, cell: usize, strengths: [&[f64]; K]) -> Subcell {
    let nodes = mesh.cells[cell];
    let jumps = |e: usize| strengths.iter().any(|c| c[e] != 0.0);
    let sides = [0, 1, 2, 3].map(|k| {
        let (a, b) = (nodes[k], nodes[(k + 1) % 4]);
        // A cell of the strip shares the edges of its loaded neighbours.
        mesh.edge_between(a, b).filter(|&e| jumps(e))
    });
    Subcell { map: Bilinear::new(mesh.corners(cell)), range: [[-1.0, 1.0]; 2], sides, nodes: nodes.map(Some) }
}
