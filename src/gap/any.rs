//! A gap of any kind, wherever it was put: what is known of it is found once.

use std::sync::{Arc, OnceLock};

use nalgebra::{Rotation2, Vector2};

use super::transform::{Transform, quarter_exact};
use super::{Cubic, Gap, Growth, Known, LeftOpen, Material, Reach, Ridges, Taylor, enclosure, mean, range};
use crate::error::{InputError, finite};
use crate::grid::Grid;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// A gap behind a shared pointer, moved, turned, tilted or seen in other units, so that gaps of different kinds can stand side by side.
#[derive(Clone)]
pub struct AnyGap {
    inner: Arc<dyn Gap>,
    transform: Transform,
    known: Arc<Known>,
    /// The planes whose highest it is, turned but not moved, where they are few and it is turned.
    turned: Option<Arc<[[f64; 3]]>>,
    /// The lowest point and the gap there, once they have been searched.
    first_touch: Arc<OnceLock<([f64; 2], f64)>>,
}

impl AnyGap {
    /// Any gap, its kind forgotten.
    pub fn new(gap: impl Gap + 'static) -> Self {
        gap.into_any()
    }

    pub(super) fn of(inner: Arc<dyn Gap>) -> Self {
        let known = Arc::new(inner.describe());
        Self { inner, transform: Transform::identity(), known, turned: None, first_touch: Arc::default() }
    }

    /// What is known of it at no depth in particular.
    #[must_use]
    pub fn known(&self) -> &Known {
        &self.known
    }

    /// What `search` finds as lowest point, and the gap there; searched once.
    pub(crate) fn first_touch(&self, search: impl FnOnce(&Self) -> ([f64; 2], f64)) -> ([f64; 2], f64) {
        *self.first_touch.get_or_init(|| search(self))
    }

    fn under(&self, transform: Transform) -> Self {
        let turned = if transform.is_upright() {
            None
        } else {
            self.inner.planes().filter(|planes| planes.len() <= mean::MOST_PLANES).map(|planes| {
                let turn = |p: &[f64; 3]| {
                    let [a, b] = transform.direction_outward([p[0], p[1]]);
                    [a, b, p[2]]
                };
                planes.iter().map(turn).collect()
            })
        };
        let known = Arc::new(transform.known_outward(&self.inner.describe()));
        let mut gap = Self { inner: self.inner.clone(), transform, known, turned, first_touch: Arc::default() };
        // A tilted body that ends somewhere is lowest there.
        if let (f64::NEG_INFINITY, Material::Within(rect)) = (gap.known.floor, gap.known.material)
            && let Some([floor, _]) = gap.bounds(&rect, [0.0; 2])
        {
            gap.known = Arc::new(Known { floor, ..(*gap.known).clone() });
        }
        gap
    }

    /// Put with its origin at `at` and turned about it, counter-clockwise, by `rotation` (radians): the value at x is the gap's own at
    /// R(-rotation)(x - at).
    ///
    /// # Errors
    /// Names `at` or `rotate` when not finite.
    pub fn placed(&self, at: [f64; 2], rotation: f64) -> Result<Self, InputError> {
        finite("at[0]", at[0])?;
        finite("at[1]", at[1])?;
        let turn = quarter_exact(finite("rotate", rotation)?);
        // A gap of revolution that is drawn about its axis is moved, and no turn stands between it and the axes.
        if let Some(axis) = self.known().axis.filter(|axis| axis.at == self.known().reference) {
            let [x, y] = (turn * Vector2::from(axis.at)).into();
            let at = [at[0] + (x - axis.at[0]), at[1] + (y - axis.at[1])];
            return Ok(self.through(&Transform::place(at, Rotation2::identity())));
        }
        Ok(self.through(&Transform::place(at, turn)))
    }

    /// Under a body tilted by (ax, ay), radians, small: with depth d the overlap is d + ax x + ay y - g.
    #[must_use]
    pub fn tilted(&self, tilt: [f64; 2]) -> Self {
        if tilt == [0.0; 2] { self.clone() } else { self.through(&Transform::tilt(tilt)) }
    }

    /// Seen in other units: its value at xi is g(origin + length xi)/depth.
    #[must_use]
    pub fn scaled(&self, origin: [f64; 2], length: f64, depth: f64) -> Self {
        self.through(&Transform::units(origin, length, depth))
    }

    /// Turned about the origin, counter-clockwise, by an angle in radians; a gap of several parts part by part, so that those that are
    /// drawn along the axes afterwards are known to be.
    pub(crate) fn turned(&self, angle: f64) -> Self {
        self.put([0.0; 2], quarter_exact(angle))
    }

    /// Moved, with this point of it at the origin; part by part as well, so that what was put there is where it was drawn.
    pub(crate) fn about(&self, [x, y]: [f64; 2]) -> Self {
        self.put([-x, -y], Rotation2::identity())
    }

    fn put(&self, at: [f64; 2], turn: Rotation2<f64>) -> Self {
        let each = |parts: Vec<Self>| parts.iter().map(|part| part.put(at, turn)).collect();
        let sum = self.addends().and_then(|parts| super::Sum::new(each(parts)).ok()).map(Self::new);
        let least = || self.alternatives().and_then(|parts| super::Minimum::new(each(parts)).ok()).map(Self::new);
        sum.or_else(least).unwrap_or_else(|| self.through(&Transform::place(at, turn)))
    }

    /// The same gap seen through a transform, its own one before it.
    fn through(&self, outer: &Transform) -> Self {
        self.under(outer.after(&self.transform))
    }

    /// Terms of a sum in this frame, which must neither tilt nor lift them.
    fn through_level(&self, parts: Option<Vec<Self>>) -> Option<Vec<Self>> {
        let level = !self.transform.is_tilted() && self.transform.height_outward(0.0, [0.0; 2]) == 0.0;
        Some(parts.filter(|_| level)?.iter().map(|part| part.through(&self.transform)).collect())
    }

    /// The gap's own values at outer points.
    fn own_gaps(&self, points: &[[f64; 2]], to: &mut [f64]) {
        let mut own = [[0.0; 2]; AT_ONCE];
        for (points, to) in points.chunks(AT_ONCE).zip(to.chunks_mut(AT_ONCE)) {
            let own = &mut own[..points.len()];
            points.iter().zip(own.iter_mut()).for_each(|(p, own)| *own = self.transform.inward(*p));
            self.inner.gaps(own, to);
        }
    }

    /// A rectangle in the frame in which planes are turned but not moved.
    fn unturned(&self, rect: &Rect) -> Rect {
        Rect { min: self.transform.unturned(rect.min), max: self.transform.unturned(rect.max) }
    }

    /// {f > 0} of a tilted gap: where its material is, or inside a disc beyond which it has risen above the depth.
    fn tilted_reach(&self, depth: f64) -> Reach {
        let outer = match self.known.material {
            Material::Within(rect) => Reach::Within(rect),
            _ => super::growth::reach(|sector, from| self.growth(sector, from), depth, self.mirrors_at_origin()),
        };
        match outer {
            Reach::Within(rect) => self.tightened(depth, &rect),
            other => other,
        }
    }

    fn mirrors_at_origin(&self) -> [bool; 2] {
        [0, 1].map(|m| self.known.mirrors[m] && self.known.centre[m] == 0.0)
    }

    fn tightened(&self, depth: f64, rect: &Rect) -> Reach {
        if self.bounds(rect, [0.0; 2]).is_none() {
            return Reach::Within(*rect);
        }
        let lower = |rect: &Rect| self.bounds(rect, [0.0; 2]).map_or(f64::NEG_INFINITY, |b| b[0]);
        enclosure::tightened(&lower, depth, rect, (self.known.centre, self.known.mirrors))
    }
}

/// Points that are seen in the gap's own frame at once.
const AT_ONCE: usize = 16;

impl<G: Gap + Clone + 'static> From<&G> for AnyGap {
    fn from(gap: &G) -> Self {
        gap.clone().into_any()
    }
}

impl std::fmt::Debug for AnyGap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("AnyGap")
    }
}

#[warn(clippy::missing_trait_methods)]
impl Gap for AnyGap {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let [u, v] = self.transform.inward([x, y]);
        self.transform.height_outward(self.inner.gap(u, v), [x, y])
    }

    fn gaps(&self, points: &[[f64; 2]], to: &mut [f64]) {
        self.own_gaps(points, to);
        points.iter().zip(to).for_each(|(p, to)| *to = self.transform.height_outward(*to, *p));
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let [u, v] = self.transform.inward([x, y]);
        self.inner.gradient(u, v).map(|g| self.transform.gradient_outward(g))
    }

    fn describe(&self) -> Known {
        (*self.known).clone()
    }

    fn reach(&self, depth: f64) -> Reach {
        if self.transform.is_identity() {
            return self.inner.reach(depth);
        }
        if let Some(reach) = self.known.quadratic.and_then(|q| q.reach(depth)) {
            return reach;
        }
        if self.transform.is_tilted() {
            return self.tilted_reach(depth);
        }
        match self.transform.reach_outward(self.inner.reach(self.transform.depth_inward(depth))) {
            Reach::Within(rect) => {
                Reach::Within(self.transform.within_ends(self.inner.describe().ends.as_deref(), rect))
            }
            other => other,
        }
    }

    fn components(&self, depth: f64) -> Option<Vec<Rect>> {
        let outward = |found: Vec<Rect>| found.iter().map(|rect| self.transform.rect_outward(rect)).collect();
        if !self.transform.is_tilted() {
            return self.inner.components(self.transform.depth_inward(depth)).map(outward);
        }
        // As for the reach: the pieces at a depth that is larger by the largest rise over them hold those of the tilted gap.
        let Reach::Within(all) = self.reach(depth) else { return None };
        let rise = all.corners().map(|c| self.transform.rise(c)).into_iter().fold(0.0, f64::max);
        let level = self.inner.components(self.transform.depth_inward(depth + rise)).map(outward)?;
        Some(level.iter().filter_map(|rect: &Rect| rect.intersection(&all)).collect())
    }

    fn mean(&self, cell: &Rect) -> f64 {
        let own = if self.transform.is_upright() {
            // Quarter turns take rectangles to rectangles.
            let corners = [self.transform.inward(cell.min), self.transform.inward(cell.max)];
            Rect::holding(corners).map_or(f64::INFINITY, |cell| self.inner.mean(&cell))
        } else if let Some(planes) = &self.turned {
            mean::of_planes(planes, &self.unturned(cell))
        } else {
            mean::by_values(&|points, to| self.own_gaps(points, to), cell)
        };
        self.transform.height_outward(own, cell.centre())
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        if self.transform.is_identity() {
            return self.inner.bounds(rect, slope);
        }
        if let Some(planes) = &self.turned {
            let unturned = self.unturned(rect);
            let steep = self.transform.direction_outward(self.transform.slope_inward(slope));
            return Some(self.transform.bounds_outward(range::of_planes(planes, &unturned, steep), steep, rect));
        }
        let steep = self.transform.slope_inward(slope);
        let own = self.inner.bounds(&self.transform.rect_inward(rect), steep)?;
        let [low, high] = self.transform.bounds_outward(own, steep, rect);
        if self.transform.is_upright() {
            return Some([low, high]);
        }
        // The turned rectangle has less room than the upright one around it.
        let [a, b] = self.taylor(rect).map_or([low, high], |taylor| taylor.bounds(rect.size(), slope));
        Some([low.max(a), high.min(b)])
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        if self.transform.is_identity() {
            return self.inner.taylor(rect);
        }
        self.inner.taylor(&self.transform.rect_inward(rect)).and_then(|own| self.transform.taylor_outward(&own, rect))
    }

    fn cubic(&self, rect: &Rect) -> Option<Cubic> {
        if self.transform.is_identity() {
            return self.inner.cubic(rect);
        }
        self.inner.cubic(&self.transform.rect_inward(rect)).and_then(|own| self.transform.cubic_outward(&own, rect))
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        if self.transform.is_identity() {
            return self.inner.slopes(rect);
        }
        self.inner.slopes(&self.transform.rect_inward(rect)).map(|own| self.transform.slopes_outward(own))
    }

    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        if self.transform.is_identity() {
            return self.inner.mean_bounds(rect);
        }
        if let Some(planes) = &self.turned {
            let own = mean::of_planes_enclosed(planes, &self.unturned(rect));
            return Some(self.transform.bounds_outward(own, [0.0; 2], rect));
        }
        if self.transform.is_upright() {
            let own = self.inner.mean_bounds(&self.transform.rect_inward(rect))?;
            return Some(self.transform.bounds_outward(own, [0.0; 2], rect));
        }
        enclosure::mean(self, rect)
    }

    fn growth(&self, sector: Interval, from: f64) -> Option<Growth> {
        if self.transform.is_identity() {
            return self.inner.growth(sector, from);
        }
        self.transform.growth_outward(sector, from, |sector, from| self.inner.growth(sector, from))
    }

    fn is_measured(&self) -> bool {
        self.inner.is_measured()
    }

    fn sampling_error(&self, rect: &Rect) -> f64 {
        self.transform.height_scale() * self.inner.sampling_error(&self.transform.rect_inward(rect))
    }

    fn left_open(&self, places: &[Rect]) -> Vec<LeftOpen> {
        let inward: Vec<Rect> = places.iter().map(|place| self.transform.rect_inward(place)).collect();
        let scale = self.transform.height_scale();
        self.inner.left_open(&inward).into_iter().map(|open| open * scale).collect()
    }

    fn restricted(&self, rect: &Rect) -> Option<AnyGap> {
        let simpler = self.inner.restricted(&self.transform.rect_inward(rect))?;
        Some(simpler.through(&self.transform))
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        let known = kinks.len();
        self.inner.ray_kinks(self.transform.inward(from), self.transform.direction_inward(direction), kinks);
        kinks[known..].iter_mut().for_each(|r| *r = self.transform.length_outward(*r));
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        let known = angles.len();
        self.inner.kink_directions(self.transform.inward(from), angles);
        angles[known..].iter_mut().for_each(|a| *a += self.transform.angle());
    }

    fn ridges(&self) -> Option<Ridges> {
        // A plane taken off all planes moves no ridge.
        let t = &self.transform;
        self.inner.ridges().map(|r| r.seen(|p| t.outward(p), |v| t.direction_outward(v), |j| t.jump_outward(j)))
    }

    fn planes(&self) -> Option<Vec<[f64; 3]>> {
        let outward = |p: &[f64; 3]| {
            let [a, b] = self.transform.gradient_outward([p[0], p[1]]);
            let [u, v] = self.transform.inward([0.0; 2]);
            [a, b, self.transform.height_outward(p[0] * u + p[1] * v + p[2], [0.0; 2])]
        };
        self.inner.planes().map(|planes| planes.iter().map(outward).collect())
    }

    fn end_of_data(&self, x: f64, y: f64) -> Option<super::DataEdge> {
        let [u, v] = self.transform.inward([x, y]);
        self.inner.end_of_data(u, v)
    }

    fn nodes(&self) -> Option<Grid> {
        let own = self.inner.nodes().filter(|_| self.transform.is_upright())?;
        let [a, b] = [own.extent().min, own.extent().max].map(|p| self.transform.outward(p));
        let rect = Rect::holding([a, b])?;
        // A quarter turn takes columns to rows.
        let across = self.transform.direction_outward([1.0, 0.0])[0] == 0.0;
        let shape = if across { [own.shape[1], own.shape[0]] } else { own.shape };
        Some(Grid::over(&rect, shape))
    }

    fn is_composed(&self) -> bool {
        self.inner.is_composed()
    }

    fn addends(&self) -> Option<Vec<AnyGap>> {
        self.through_level(self.inner.addends())
    }

    fn terms(&self) -> Option<Vec<AnyGap>> {
        self.through_level(self.inner.terms())
    }

    fn alternatives(&self) -> Option<Vec<AnyGap>> {
        self.inner.alternatives().map(|parts| parts.iter().map(|part| part.through(&self.transform)).collect())
    }

    fn without_end(&self, depth: f64) -> Option<AnyGap> {
        if self.transform.is_tilted() {
            return None;
        }
        let own = self.inner.without_end(self.transform.depth_inward(depth))?;
        Some(own.through(&self.transform))
    }

    fn into_any(self) -> AnyGap {
        self
    }
}
