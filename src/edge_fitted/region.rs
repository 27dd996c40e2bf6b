//! The separate regions of the cells in contact, with their outlines.

use std::collections::HashMap;

use super::mesh::{Bilinear, Mesh, Point};

/// Cells in contact that hang together by sides.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Region {
    /// Closed lines with the contact on the left.
    pub boundary: Vec<Vec<Point>>,
    /// Its area.
    pub area: f64,
    /// Area of its cells that have a neighbour without contact on the same material, or may lift off in part: where contact ends among
    /// them is not known.
    pub doubt: f64,
    /// The centroid of its area.
    pub centroid: Point,
    /// The integral of the pressure.
    pub force: f64,
}

impl Region {
    /// The same in other axes, turned and moved.
    pub fn map(&mut self, to: impl Fn(Point) -> Point) {
        self.boundary.iter_mut().flatten().for_each(|p| *p = to(*p));
        self.centroid = to(self.centroid);
    }
}

/// The regions of the loaded cells with `contact`; `partly`: those that may lift off in part though none beside them does.
pub(crate) fn regions(mesh: &Mesh, contact: &[bool], pressure: &[f64], partly: &dyn Fn(usize) -> bool) -> Vec<Region> {
    let on = |side: Option<usize>| side.filter(|&c| contact[c]);
    let mut label = vec![usize::MAX; contact.len()];
    let mut count = 0;
    for start in 0..contact.len() {
        if !contact[start] || label[start] != usize::MAX {
            continue;
        }
        let mut stack = vec![start];
        label[start] = count;
        while let Some(cell) = stack.pop() {
            for (edge, _) in mesh.cell_edges[cell].iter().flatten() {
                for other in mesh.edges[*edge].sides.into_iter().filter_map(on) {
                    if label[other] == usize::MAX {
                        label[other] = count;
                        stack.push(other);
                    }
                }
            }
        }
        count += 1;
    }
    let mut regions: Vec<Region> = (0..count)
        .map(|_| Region { boundary: Vec::new(), area: 0.0, doubt: 0.0, centroid: [0.0; 2], force: 0.0 })
        .collect();
    for cell in (0..contact.len()).filter(|&c| contact[c]) {
        let [area, x, y] = Bilinear::new(mesh.corners(cell)).moments();
        let region = &mut regions[label[cell]];
        region.area += area;
        region.centroid = [region.centroid[0] + x, region.centroid[1] + y];
        region.force += pressure[cell] * area;
        let ends = |edge: usize| mesh.edges[edge].sides.into_iter().flatten().any(|c| !contact[c]);
        if mesh.cell_edges[cell].iter().flatten().any(|(edge, _)| ends(*edge)) || partly(cell) {
            region.doubt += area;
        }
    }
    for (k, region) in regions.iter_mut().enumerate() {
        region.centroid = region.centroid.map(|c| c / region.area);
        region.boundary = boundary(mesh, &|side| on(side).is_some_and(|c| label[c] == k));
    }
    regions
}

/// The lines between cells that are `inside` and others, without nodes on straight stretches.
fn boundary(mesh: &Mesh, inside: &dyn Fn(Option<usize>) -> bool) -> Vec<Vec<Point>> {
    let mut leaving: HashMap<usize, Vec<usize>> = HashMap::new();
    let mut starts = Vec::new();
    for edge in &mesh.edges {
        let [a, b] = match edge.sides.map(inside) {
            [true, false] => edge.ends,
            [false, true] => [edge.ends[1], edge.ends[0]],
            _ => continue,
        };
        leaving.entry(a).or_default().push(b);
        starts.push(a);
    }
    let mut lines = Vec::new();
    for start in starts {
        let mut line = Vec::new();
        let mut at = start;
        while let Some(next) = leaving.get_mut(&at).and_then(Vec::pop) {
            line.push(mesh.nodes[at]);
            at = next;
        }
        if line.len() > 2 {
            lines.push(super::polygon::straightened(line));
        }
    }
    lines
}
