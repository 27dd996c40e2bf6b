//! A fan of rays about one centre: the state that the boundary solvers share.

use std::cell::Cell;

use nalgebra::Matrix2;

use super::facets::Facets;
use super::kink_detection;
use super::radial::{RadialPosition, RadialRule};
use super::ray::{Along, RayLine, ScaledOverlap};
use super::sectors::{QuadratureNode, SIXTH, Sectors};
use super::symmetry::ridge_directions;
use crate::gap::Gap;
use crate::numeric::scalar::{TO_THE_LAST_DIGIT, bisected};

/// Evaluations of the gap after which a solve is given up: many times what a gap takes whose boundary is one smooth curve.
const MOST_EVALUATIONS: usize = 1_500_000;

/// The clock is read once in so many rays, or evaluations on one: over planes a ray costs less than a look at it.
pub(crate) const CHECKED: usize = 16;

/// Kinks closer to the centre than this, in units of the problem, lie on it but for rounding.
const AT_CENTRE: f64 = 1e-13;

/// One ray and the boundary on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub node: QuadratureNode,
    pub direction: [f64; 2],
    /// Range in the shared lists of kinks and jumps.
    pub kinks: (usize, usize),
    /// Slope of the gap on the first piece, where it is made of planes.
    pub slope: f64,
    /// Radius of the boundary.
    pub a: f64,
    /// The same to all digits, once evaluated.
    pub position: RadialPosition,
    /// Where the material ends.
    pub limit: f64,
    /// Whether the safe search found G_a below D everywhere on the ray.
    pub stuck: bool,
    /// Whether `along` is up to date.
    pub measured: bool,
    /// G and its derivatives at `a`.
    pub along: Along,
}

impl Ray {
    /// Whether the boundary lies at the edge of the punch.
    pub fn at_edge(&self) -> bool {
        self.a >= self.limit
    }
}

/// The rays about a centre with the quadrature over them. Built once a layout; sweeps over it allocate nothing.
pub(crate) struct RayFan<'a> {
    pub overlap: &'a ScaledOverlap,
    pub centre: [f64; 2],
    /// f at the centre.
    pub f0: f64,
    pub sectors: Sectors,
    pub rays: Vec<Ray>,
    /// The ridges in order, where they are many; and what a ray meets of them.
    facets: Option<Facets>,
    met: Vec<(f64, f64)>,
    kinks: Vec<f64>,
    /// Jumps of the slope at the kinks, where the gap is made of planes.
    jumps: Vec<f64>,
    /// Where the gap says that it is not smooth.
    pub directions: Vec<f64>,
    /// Where the boundary was found to run over a ridge.
    pub crossings: Vec<f64>,
    pub(super) nodes: Vec<QuadratureNode>,
    pub(super) values: Vec<f64>,
    /// Level of the radial rule.
    pub rule_level: usize,
    /// Inverse of the derivative of the centroid's offset by the centre, negative: what the moves of the centre learn.
    pub recentring: Matrix2<f64>,
    /// Whether the centre has had to move.
    pub moved: bool,
    /// Whether every step checks that there is material at the boundary, not only along the rays.
    pub checks_material: bool,
    /// How far kinks that the gap does not name are searched for along every ray.
    pub search: Option<f64>,
    /// Evaluations of the gap after which the solve is given up.
    pub budget: usize,
    /// Evaluations of the gap so far, nearly.
    pub(super) spent: Cell<usize>,
}

impl<'a> RayFan<'a> {
    /// Rays about `centre`, the boundary a circle of radius `start`; `turns`: how many turns about the centre leave boundary and gap
    /// as they are.
    pub fn about(overlap: &'a ScaledOverlap, centre: [f64; 2], start: f64, rule_level: usize, turns: usize) -> Self {
        let mut directions = Vec::new();
        ridge_directions(overlap, centre, &mut directions);
        let mut fan = Self {
            overlap,
            centre,
            f0: overlap.at(centre),
            facets: Facets::about(overlap, centre, AT_CENTRE),
            met: Vec::new(),
            sectors: Sectors::repeated(&directions, SIXTH, turns),
            rays: Vec::new(),
            kinks: Vec::new(),
            jumps: Vec::new(),
            directions,
            crossings: Vec::new(),
            nodes: Vec::new(),
            values: Vec::new(),
            rule_level,
            recentring: Matrix2::identity() * (8.0 / (3.0 * std::f64::consts::PI)),
            moved: false,
            checks_material: false,
            search: None,
            // A step over planes is a few operations.
            budget: if overlap.has_planes() { 6 * MOST_EVALUATIONS } else { MOST_EVALUATIONS },
            spent: Cell::new(0),
        };
        fan.lay(&[[0.0, start]]);
        fan
    }

    /// The rule in use along the rays.
    pub fn rule(&self) -> &'static RadialRule {
        RadialRule::level(self.rule_level).unwrap_or_else(RadialRule::finest)
    }

    /// The next finer rule, if there is one.
    pub fn finer_rule(&self) -> Option<&'static RadialRule> {
        RadialRule::level(self.rule_level + 1)
    }

    /// The geometry of one ray.
    pub fn line(&self, ray: &Ray) -> RayLine<'_> {
        let range = ray.kinks.0..ray.kinks.1;
        let planes = self.overlap.has_planes().then(|| (ray.slope, &self.jumps[range.clone()]));
        RayLine { centre: self.centre, direction: ray.direction, kinks: &self.kinks[range], planes }
    }

    /// Angles and radii of the present boundary within one period, ascending.
    pub fn outline(&self) -> Vec<[f64; 2]> {
        let period = self.sectors.period();
        let mut outline: Vec<_> = self.rays.iter().map(|r| [r.node.angle.rem_euclid(period), r.a]).collect();
        outline.sort_by(|p, q| p[0].total_cmp(&q[0]));
        outline
    }

    /// Lays the rays of the present sectors, with the boundary taken over from `outline`.
    pub fn lay(&mut self, outline: &[[f64; 2]]) {
        let mut nodes = std::mem::take(&mut self.nodes);
        self.sectors.nodes(&mut nodes);
        self.rays.clear();
        self.kinks.clear();
        self.jumps.clear();
        for &node in &nodes {
            let ray = self.new_ray(node, radius_in(outline, node.angle, self.sectors.period()));
            self.rays.push(ray);
        }
        self.nodes = nodes;
        self.values.resize(self.rays.len(), 0.0);
    }

    /// A ray that is not part of the quadrature.
    pub fn extra_ray(&mut self, angle: f64, a: f64) -> Ray {
        self.new_ray(QuadratureNode { angle, fine: 0.0, coarse: 0.0 }, a)
    }

    fn new_ray(&mut self, node: QuadratureNode, a: f64) -> Ray {
        let (sin, cos) = node.angle.sin_cos();
        let from = self.kinks.len();
        let mut slope = 0.0;
        if let Some(facets) = &self.facets {
            slope = facets.read([cos, sin], AT_CENTRE, &mut self.met, &mut self.kinks, &mut self.jumps);
        } else {
            self.find_kinks([cos, sin]);
            if self.overlap.has_planes() {
                let kinks = &self.kinks[from..];
                let line = RayLine { centre: self.centre, direction: [cos, sin], kinks, planes: None };
                slope = line.read_planes(self.overlap, &mut self.jumps);
            }
        }
        let kinks = (from, self.kinks.len());
        let (position, along) = Default::default();
        Ray {
            node,
            direction: [cos, sin],
            kinks,
            slope,
            a,
            position,
            limit: f64::INFINITY,
            stuck: false,
            measured: false,
            along,
        }
    }

    /// Appends the kinks along a ray, ascending.
    fn find_kinks(&mut self, direction: [f64; 2]) {
        let from = self.kinks.len();
        self.overlap.gap.ray_kinks(self.centre, direction, &mut self.kinks);
        if let Some(range) = self.search {
            let line = RayLine { centre: self.centre, direction, kinks: &[], planes: None };
            kink_detection::find(&line, self.overlap, range, from, &mut self.kinks);
            self.spent.set(self.spent.get() + kink_detection::PRICE);
        }
        self.kinks[from..].sort_unstable_by(f64::total_cmp);
        // On an apex but for rounding.
        let at_centre = self.kinks[from..].partition_point(|&k| k < AT_CENTRE);
        self.kinks.drain(from..from + at_centre);
    }

    /// Moves the centre and keeps the boundary, as far as it can.
    pub fn move_to(&mut self, centre: [f64; 2]) {
        let outline = self.outline();
        self.centre = centre;
        self.f0 = self.overlap.at(centre);
        self.facets = Facets::about(self.overlap, centre, AT_CENTRE);
        self.directions.clear();
        ridge_directions(self.overlap, centre, &mut self.directions);
        self.move_sectors();
        self.lay(&outline);
    }

    /// Lays the rays anew between the present directions and crossings.
    pub fn lay_sectors(&mut self) {
        let outline = self.outline();
        self.move_sectors();
        self.lay(&outline);
    }

    fn move_sectors(&mut self) {
        let told = self.directions.len();
        self.directions.extend_from_slice(&self.crossings);
        self.sectors.move_to(&self.directions);
        self.directions.truncate(told);
    }

    /// The number of kinks listed so far: [`Self::release_kinks`] forgets those of rays made since.
    pub fn kinks_held(&self) -> usize {
        self.kinks.len()
    }

    /// Forgets the kinks of the rays made since there were so many.
    pub fn release_kinks(&mut self, mark: usize) {
        self.kinks.truncate(mark);
        self.jumps.truncate(mark.min(self.jumps.len()));
    }

    /// Evaluates G at the boundary of one ray, which is pulled back to the edge of the material if it lies beyond.
    pub fn measure(&self, mut ray: Ray) -> Ray {
        ray.a = ray.a.min(ray.limit);
        for attempt in 0..400 {
            if attempt % CHECKED == CHECKED - 1 && self.overlap.deadline.has_passed() {
                break;
            }
            if ray.position.a != ray.a {
                ray.position = RadialPosition::at(self.line(&ray).kinks, ray.a);
            }
            ray.along = self.line(&ray).along(self.overlap, self.f0, &ray.position, self.rule());
            self.spent.set(self.spent.get() + self.price(&ray));
            let Along { g, g_a, g_aa } = ray.along;
            if (g + g_a + g_aa).is_finite() && (!self.checks_material || self.has_material(&ray)) {
                return ray;
            }
            let inside = |r: f64| self.overlap.at(self.line(&ray).at(r)).is_finite();
            if inside(ray.a) {
                // Material everywhere, but its slope is infinite here (the rim of a sphere).
                ray.a *= 1.0 - 1e-3;
            } else {
                ray.limit = bisected(inside, [0.0, ray.a], TO_THE_LAST_DIGIT)[0] * (1.0 - f64::EPSILON);
                ray.a = ray.limit;
            }
        }
        ray
    }

    /// Evaluations of the gap that one measurement takes.
    pub(super) fn price(&self, ray: &Ray) -> usize {
        let pieces = 1 + ray.position.inner;
        match (self.overlap.has_planes(), self.overlap.has_gradient()) {
            (true, _) => pieces,
            (false, true) => pieces * self.rule().whole.len(),
            // Two for the slope and one for the value.
            (false, false) => 3 * pieces * self.rule().whole.len(),
        }
    }

    /// The evaluations spent, when they are more than a solve may take or the time is used up.
    pub fn out_of_budget(&self) -> Option<usize> {
        Some(self.spent.get()).filter(|&spent| spent > self.budget || self.overlap.deadline.has_passed())
    }

    fn has_material(&self, ray: &Ray) -> bool {
        self.overlap.at(self.line(ray).at(ray.a)).is_finite()
    }

    /// Whether there is material at the boundary on every ray; when not, each step is checked from now on.
    pub fn on_material(&mut self) -> bool {
        // Planes have no edge.
        if self.overlap.has_planes() {
            return true;
        }
        self.checks_material = self.checks_material || !self.rays.iter().all(|ray| self.has_material(ray));
        !self.checks_material || self.rays.iter().all(|ray| self.has_material(ray))
    }

    /// Evaluates G on every ray that has moved since it was last evaluated.
    pub fn measure_all(&mut self) {
        let mut late = false;
        for k in 0..self.rays.len() {
            late = late || k % CHECKED == 0 && self.overlap.deadline.has_passed();
            // Out of time what was measured last stays: who asks for the force asks for the budget, too.
            if !self.rays[k].measured && !late {
                self.rays[k] = self.measure(self.rays[k]);
            }
            self.rays[k].measured = false;
        }
    }
}

/// Radius at an angle of the outline (angle, radius), which repeats itself after `period`; 1/a linear in between.
pub(crate) fn radius_in(outline: &[[f64; 2]], angle: f64, period: f64) -> f64 {
    let n = outline.len();
    if n == 1 {
        return outline[0][1];
    }
    let angle = angle.rem_euclid(period);
    let after = outline.partition_point(|p| p[0] < angle);
    let (p, q) = (outline[(after + n - 1) % n], outline[after % n]);
    let span = (q[0] - p[0]).rem_euclid(period);
    if span < 1e-14 {
        return q[1];
    }
    let s = ((angle - p[0]).rem_euclid(period) / span).clamp(0.0, 1.0);
    1.0 / ((1.0 - s) / p[1] + s / q[1])
}
