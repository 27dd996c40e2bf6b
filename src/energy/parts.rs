//! A gap as a sum of what is smooth and of what follows laws about one point: dilated about it, every part stays what it is.

use super::of_gap::GapOverlap;
use super::on_cells::OnCells;
use super::overlap::OverlapBounds;
use crate::gap::{AnyGap, Degree, Gap, Sum};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;

/// The terms of a gap.
struct Terms {
    /// The sum of those without a law, where there are others.
    smooth: Option<AnyGap>,
    /// Those of a degree about the centre, and the value there.
    laws: Vec<(AnyGap, f64, f64)>,
    centre: [f64; 2],
}

impl Terms {
    /// Of a gap that is the sum of several, some of which are not smooth and follow laws about one point.
    fn of(gap: &AnyGap) -> Option<Self> {
        let mut centre = None;
        let (mut laws, mut smooth) = (Vec::new(), Vec::new());
        for term in gap.terms()? {
            let known = term.known();
            let law = known.law.filter(|_| known.quadratic.is_none());
            match (law.map(|law| (law.degree, law.lowest)), centre) {
                (Some((Degree::Power(k), lowest)), None) => {
                    centre = Some(known.centre);
                    laws.push((term, k, lowest));
                }
                (Some((Degree::Power(k), lowest)), Some(at)) if at == known.centre => laws.push((term, k, lowest)),
                _ => smooth.push(term),
            }
        }
        let smooth = if smooth.is_empty() { None } else { Some(AnyGap::new(Sum::new(smooth).ok()?)) };
        Some(Self { smooth, laws, centre: centre? })
    }

    /// Their overlaps on the cells of a grid.
    fn overlaps<'a>(&'a self, of: &GapOverlap) -> (Option<GapOverlap<'a>>, Vec<GapOverlap<'a>>) {
        let part = |gap: &'a AnyGap| of.of_part(gap);
        (self.smooth.as_ref().map(part), self.laws.iter().map(|(gap, ..)| part(gap)).collect())
    }
}

/// A part of the overlap that follows a law: f_j = d - g_j.
pub(super) struct Law<'a> {
    pub overlap: OnCells<'a>,
    pub degree: f64,
    /// d, and d less the value of g_j at the centre.
    pub depth: f64,
    pub above: f64,
}

impl Law<'_> {
    /// f_j in the middle of a rectangle, nearly.
    pub fn nearly(&self, rect: &Rect) -> f64 {
        let [x, y] = rect.centre();
        self.depth - self.overlap.gap().gap(x, y)
    }

    /// Bounds of `above`, a difference.
    pub fn above_ends(&self) -> [f64; 2] {
        [self.above.next_down(), self.above.next_up()]
    }
}

/// Nothing: the smooth part where every term has a law.
struct Nothing(f64);

impl OverlapBounds for Nothing {
    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> [f64; 2] {
        let [w, h] = rect.size();
        let swing = (0.5 * (slope[0].abs() * w + slope[1].abs() * h)).next_up();
        [(self.0 - swing).next_down(), (self.0 + swing).next_up()]
    }

    fn slopes(&self, _rect: &Rect) -> [[f64; 2]; 2] {
        [[0.0; 2]; 2]
    }

    fn jet(&self, _rect: &Rect) -> Option<super::overlap::Jet> {
        Some(super::overlap::Jet { value: [self.0; 2], ..Default::default() })
    }

    fn mean(&self, _rect: &Rect) -> [f64; 2] {
        [self.0; 2]
    }

    fn ends(&self) -> bool {
        false
    }

    fn reach(&self) -> Option<Rect> {
        None
    }
}

/// The overlap in parts: f = `smooth` + sum of (f_j - d).
pub(super) struct Parts<'a> {
    pub smooth: &'a dyn OverlapBounds,
    pub laws: Vec<Law<'a>>,
    /// What the laws are about.
    pub centre: Option<[f64; 2]>,
}

impl<'a> Parts<'a> {
    /// Of an overlap that is in one piece.
    pub fn whole(overlap: &'a dyn OverlapBounds) -> Self {
        Self { smooth: overlap, laws: Vec::new(), centre: None }
    }

    /// Whether there may be a rectangle without material: false is certain.
    pub fn ends(&self) -> bool {
        self.smooth.ends() || self.laws.iter().any(|law| law.overlap.ends())
    }

    /// Of terms with their overlaps, on the cells of a grid.
    fn of(terms: &Terms, smooth: &'a dyn OverlapBounds, laws: &'a [GapOverlap<'a>], grid: &Grid, depth: f64) -> Self {
        let law = |((_, degree, lowest), overlap): (&(AnyGap, f64, f64), &'a GapOverlap<'a>)| Law {
            overlap: OnCells::new(overlap, grid),
            degree: *degree,
            depth,
            above: depth - lowest,
        };
        Self { smooth, laws: terms.laws.iter().zip(laws).map(law).collect(), centre: Some(terms.centre) }
    }
}

/// Calls `work` with the parts of an overlap, or with the overlap in one piece.
pub(super) fn in_parts<T>(gap: &GapOverlap, whole: &OnCells, grid: &Grid, work: impl FnOnce(&Parts) -> T) -> T {
    let Some(terms) = Terms::of(gap.gap()) else { return work(&Parts::whole(whole)) };
    let (smooth, laws) = terms.overlaps(gap);
    let depth = gap.depth();
    match &smooth {
        Some(smooth) => work(&Parts::of(&terms, &OnCells::new(smooth, grid), &laws, grid, depth)),
        None => work(&Parts::of(&terms, &Nothing(depth), &laws, grid, depth)),
    }
}
