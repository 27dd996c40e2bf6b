//! The factor chi: 1 on the cells in contact, falling to 0 over half of the cells around, bilinear in quarters of cells.

use std::collections::HashSet;

use super::mesh::{Bilinear, Mesh};
use super::subcell::Subcell;

/// Where chi is 1: nodes and sides of the cells in contact, besides those cells themselves.
pub(crate) struct Fade<'a> {
    contact: &'a [bool],
    node: Vec<bool>,
    /// Sides of cells in contact, by their nodes in rising order.
    side: HashSet<[usize; 2]>,
}

/// A subcell over which chi is bilinear, with the values at its corners.
pub(crate) struct Panel {
    pub subcell: Subcell,
    pub chi: [f64; 4],
}

impl<'a> Fade<'a> {
    pub fn new(mesh: &Mesh, contact: &'a [bool]) -> Self {
        let mut node = vec![false; mesh.nodes.len()];
        let mut side = HashSet::new();
        for (nodes, _) in mesh.cells.iter().zip(contact).filter(|(_, on)| **on) {
            for k in 0..4 {
                let (a, b) = (nodes[k], nodes[(k + 1) % 4]);
                node[a] = true;
                side.insert([a.min(b), a.max(b)]);
            }
        }
        Self { contact, node, side }
    }

    /// chi at the corners, the middles of the sides and the centre of a cell without contact.
    fn beyond(&self, mesh: &Mesh, cell: usize) -> [f64; 9] {
        let nodes = mesh.cells[cell];
        let one = |b: bool| if b { 1.0 } else { 0.0 };
        let corner = [0, 1, 2, 3].map(|k| one(self.node[nodes[k]]));
        let middle = [0, 1, 2, 3].map(|k| {
            let (a, b) = (nodes[k], nodes[(k + 1) % 4]);
            one(if a == b { self.node[a] } else { self.side.contains(&[a.min(b), a.max(b)]) })
        });
        [corner[0], corner[1], corner[2], corner[3], middle[0], middle[1], middle[2], middle[3], 0.0]
    }

    /// The parts of a cell where chi is positive, over each of which it is bilinear.
    pub fn panels<const K: usize>(&self, mesh: &Mesh, cell: usize, strengths: [&[f64]; K]) -> Vec<Panel> {
        let whole = whole(mesh, cell, strengths);
        if self.contact.get(cell) == Some(&true) {
            return vec![Panel { subcell: whole, chi: [1.0; 4] }];
        }
        let chi = self.beyond(mesh, cell);
        // Values 0 to 3 at the corners, 4 to 7 at the middles of the sides, 8 at the centre.
        let quarters = [
            ([0, 4, 8, 7], [-1.0, -1.0]),
            ([4, 1, 5, 8], [0.0, -1.0]),
            ([8, 5, 2, 6], [0.0, 0.0]),
            ([7, 8, 6, 3], [-1.0, 0.0]),
        ];
        let part = |(corners, [s, t]): ([usize; 4], [f64; 2])| Panel {
            subcell: whole.part(0, s, s + 1.0).part(1, t, t + 1.0),
            chi: corners.map(|c| chi[c]),
        };
        quarters.into_iter().map(part).filter(|panel| panel.chi != [0.0; 4]).collect()
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
