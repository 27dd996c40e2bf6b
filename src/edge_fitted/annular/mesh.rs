//! Rings graded to the ends of the material, of the contact, and to corners of the gap.

use super::super::rectilinear::{graded, graded_both};
use super::Span;
use super::rings::Rings;

/// The rings of the spans: graded to the edges of the material and, in the last contact, to kinks; beside a free end of it finer, and
/// coarser away from it.
pub(super) fn mesh(spans: &[Span], contact: &[[f64; 2]], kinks: &[f64], n: usize) -> Rings {
    let (mut rings, mut loaded) = (Vec::new(), Vec::new());
    for (index, span) in spans.iter().enumerate() {
        let [a, b] = span.radii;
        // The fades of neighbours do not meet.
        let before = if index > 0 { 0.5 * (a - spans[index - 1].radii[1]) } else { a };
        let beyond = spans.get(index + 1).map_or(f64::INFINITY, |next| 0.5 * (next.radii[0] - b));
        let inside: Vec<[f64; 2]> = contact.iter().copied().filter(|c| c[1] > a && c[0] < b).collect();
        let mut nodes = vec![a];
        if span.edges == [true, true] && inside.is_empty() {
            nodes = graded_both(a, b, n, AT_EDGES);
        } else if inside.is_empty() {
            // The last one ends where the span does, to the last digit: the material may end there.
            let even = (1..2 * n).map(|i| a + (b - a) * i as f64 / (2 * n) as f64).chain([b]);
            nodes.extend(even.chain(kinks.iter().copied().filter(|k| *k > a && *k < b)));
            nodes.sort_by(f64::total_cmp);
            nodes.dedup();
        }
        for (k, c) in inside.iter().enumerate() {
            let edge = |high: bool| {
                let (end, limit) = if high { (c[1], b) } else { (c[0], a) };
                span.edges[usize::from(high)] && end == limit
            };
            let apart = APART * (c[1] - c[0]);
            let at_kink = |r: f64| kinks.iter().any(|k| (k - r).abs() <= apart);
            let inner = kinks.iter().copied().filter(|k| *k > c[0] + apart && *k < c[1] - apart);
            let cuts: Vec<f64> = std::iter::once(c[0]).chain(inner).chain([c[1]]).collect();
            let parts: Vec<[f64; 2]> = cuts.windows(2).map(|pair| [pair[0], pair[1]]).collect();
            let length = |[from, to]: [f64; 2]| to - from;
            let mut own = vec![c[0]];
            for (m, &part) in parts.iter().enumerate() {
                let exponent = |high: bool| {
                    let beside = if high { parts.get(m + 1) } else { m.checked_sub(1).and_then(|m| parts.get(m)) };
                    let steep = match beside {
                        Some(beside) => length(*beside) < SHORT * length(part),
                        None => edge(high) || at_kink(part[usize::from(high)]),
                    };
                    if steep { AT_EDGES } else { AT_FREE_ENDS }
                };
                let middle = 0.5 * (part[0] + part[1]);
                own.extend(graded(middle, part[0], n, exponent(false)).into_iter().rev().skip(1));
                own.extend(graded(middle, part[1], n, exponent(true)).into_iter().skip(1));
            }
            // From what is there to the contact: rings that grow away from it.
            let from = *nodes.last().unwrap_or(&a);
            if own[0] > from {
                let outer = away(own[0], from, own[1] - own[0]);
                nodes.extend(outer.into_iter().rev().skip(1));
                nodes.push(own[0]);
            }
            let last = own[own.len() - 1];
            let step = last - own[own.len() - 2];
            nodes.extend(own.into_iter().skip(1));
            let until = inside.get(k + 1).map_or(b, |next| 0.5 * (c[1] + next[0]));
            if until > last {
                nodes.extend(away(last, until, step));
            }
        }
        if span.edges[0] || a > 0.0 {
            let width = (nodes[1] - nodes[0]).min(before);
            if width > 0.0 {
                rings.push([a - width, a]);
                loaded.push(false);
            }
        }
        for pair in nodes.windows(2) {
            rings.push([pair[0], pair[1]]);
            loaded.push(true);
        }
        let last = nodes.len() - 1;
        rings.push([nodes[last], nodes[last] + (nodes[last] - nodes[last - 1]).min(beyond)]);
        loaded.push(false);
    }
    Rings::new(rings, loaded)
}

/// Grading of the rings towards edges, and towards free ends and kinks inside the contact.
const AT_EDGES: f64 = 4.0;
const AT_FREE_ENDS: f64 = 2.0;

/// Distance of a kink from the end of a contact, over the width of that, below which they are one.
const APART: f64 = 1e-6;

/// A part of a contact, over its neighbour, at which that ends as at an edge: pressure grows towards a corner that it passes by little.
const SHORT: f64 = 0.2;

/// Nodes after `from` up to `to`, steps growing by a half from `step`.
fn away(from: f64, to: f64, step: f64) -> Vec<f64> {
    let sign = (to - from).signum();
    let (mut nodes, mut at, mut step) = (Vec::new(), from, step);
    while (to - at) * sign > 1.5 * step {
        at += sign * step;
        nodes.push(at);
        step *= 1.5;
    }
    nodes.push(to);
    nodes
}
