//! What the pressure on one mesh of a tilted punch proves, and what it leaves open (`tilted` has the formulas).

use nalgebra::{Matrix3, Vector3};

use super::active_set::Planes;
use super::compliance::known_to;
use super::first_mesh::usual_width;
use super::mesh::Point;
use super::outline::{COARSEST, Outline};
use super::region::{Region, regions};
use super::residual_form::ResidualForm;
use super::tilted_mesh::{FINEST, Frame, Given, Pressed, Punch};

/// gamma over Q, and a'' over K, times n^3, over the usual width of a level punch, as they choose the first mesh, no more; at a given plane
/// the lower bound of the force is sharper than under a load.
const LEFT: [f64; 2] = [0.24, 0.5];

/// That width at least: of many corners, one may all but lift off.
const LEAST: f64 = 0.18;

/// A tilted punch in contact, E* = 1, in the outline's axes.
#[derive(Debug, Clone)]
pub(crate) struct Tilted {
    /// f = plane . (1, x, y).
    pub plane: [f64; 3],
    /// The integrals of p, p x and p y of the computed pressure.
    pub load: [f64; 3],
    /// Their derivatives by the plane.
    pub matrix: [[f64; 3]; 3],
    /// Relative error of its first entry.
    pub stiffness_error: f64,
    /// Bounds of the force at the plane; within its error where it is not proved.
    pub force: [f64; 2],
    /// Whether these are proved: contact everywhere in a polygon.
    pub proved: bool,
    /// Proved bounds of the plane at the origin of the axes that are asked for, under exactly the load.
    pub depth: Option<[f64; 2]>,
    /// Those of its slopes along these axes.
    pub tilts: Option<[[f64; 2]; 2]>,
    /// Proved bounds of the integrals of p x and p y in these axes, at the plane.
    pub moments: Option<[[f64; 2]; 2]>,
    /// Bounds of the stored energy.
    pub energy: [f64; 2],
    /// Corners and pressure of all cells.
    pub cells: Vec<([Point; 4], f64)>,
    /// The separate regions of contact.
    pub regions: Vec<Region>,
    /// Whether it touches everywhere.
    pub everywhere: bool,
    /// Unknowns of the last mesh.
    pub unknowns: usize,
}

impl Punch {
    /// The n for which the error of the force may be within the tolerance, where it touches everywhere.
    pub fn enough(&self, pressed: &Pressed, given: Given, outline: &Outline, tolerance: f64) -> usize {
        let usual = usual_width(outline);
        let of_form = match given {
            Given::Plane(_) => LEFT[0] * usual,
            Given::Load(_) => LEFT[1] * usual.max(LEAST),
        };
        let Pressed { pressure: p, planes, plane: g, .. } = pressed;
        let k = planes.stiffness(&self.weights);
        let [form, load] = [g.dot(&(k * g)), self.load(p)[0]];
        let cuts = self.cuts(&planes.0[0], p, None, k[(0, 0)] / form, 1.0);
        let width = |n: usize| {
            let left = of_form * (n as f64).powi(-3);
            let [gamma, rest] = [left * form, left * k[(0, 0)]];
            0.5 * (missed(&cuts, gamma, rest) + (2.0 * gamma * rest).sqrt()) / load
        };
        (COARSEST..FINEST).find(|n| width(*n) <= tolerance).unwrap_or(FINEST)
    }

    /// Both.
    pub fn answer(&self, given: Given, frame: &Frame, outline: &Outline, proof: bool) -> Option<Tilted> {
        self.bounded(&self.pressed(given)?, given, frame, outline, proof)
    }

    /// What the pressure proves, where that is wanted, and what it leaves open.
    pub fn bounded(
        &self,
        pressed: &Pressed,
        given: Given,
        frame: &Frame,
        outline: &Outline,
        proof: bool,
    ) -> Option<Tilted> {
        let map = self.fitted.basis();
        let Pressed { pressure: p, planes, plane: g, contact, .. } = pressed;
        let added = pressed.added.as_deref();
        let displaced = outline.displaced();
        let proved = proof && !pressed.lifts() && outline.is_covered();
        let matrix = planes.stiffness(&self.weights);
        let unit = &planes.0[0];
        // t that makes both parts of one size.
        let energy = g.dot(&(matrix * g));
        let t2 = (energy / matrix[(0, 0)]).sqrt();
        if !(t2 > 0.0 && t2.is_finite()) {
            return None;
        }
        let t = t2.sqrt();
        let load = self.load(p);
        // What the place of the edges leaves open, of the sizes of both parts.
        let off = displaced * (energy / t2 + matrix[(0, 0)] * g.norm_squared());
        let low = self.form_below(p, g) - off;
        let (mut force, mut bounds_of_energy, mut stiffness_error) = ([load[0]; 2], [low, low], 0.0);
        let (mut asked, mut moments) = (None, None);
        if proved {
            let (inverse, inward) = (matrix.try_inverse()?, map.try_inverse()?);
            let mut most = vec![*g];
            if let Given::Load(_) = given {
                // c of (10) for the depth.
                most.push(inverse * (inward * frame.loads()[0]));
            }
            let form = self.mirrored.residuals(self.mesh(), &self.lines, planes, &most, self.means)?;
            let [rest_of_unit, rest_of_p] = [form.of(&Vector3::x()), form.of(g)];
            // The rests are those of Galerkin pressures, orthogonal to what was added to the one of a given plane.
            let (more, of_added) = added.map_or((0.0, 0.0), |added| (self.rest_of(added, p), self.load(added)[0]));
            let rest_of_p = rest_of_p + more;
            let own = load[0] - of_added;
            // By at most the rests of products gamma and a'' are larger.
            let gamma = 0.5 * rest_of_p + self.compliance.uncertainty(p, p) + off;
            let offs = planes.0.each_ref().map(|p| self.compliance.off(p));
            let products_off = Matrix3::from_fn(|i, j| known_to(&planes.0[i], &offs[j]));
            let rest = rest_of_unit + 2.0 * products_off[(0, 0)] + off;
            let work_off = known_to(p, &offs[0]);
            let rounding = 1e-12 * (load[0] + t2 * matrix[(0, 0)] + energy / t2) + off + work_off;
            let room = 2.0 * rounding + work_off;
            let below = match given {
                Given::Plane(_) => {
                    let plus: Vec<f64> = unit.iter().zip(p).map(|(m, p)| t * m + p / t).collect();
                    let less: Vec<f64> = unit.iter().zip(p).map(|(m, p)| t * m - p / t).collect();
                    let [over, under] = [1.0, -1.0].map(|sign| Vector3::new(t, 0.0, 0.0) + g * (sign / t));
                    let (above, below) = (self.form_below(&plus, &over), self.form_below(&less, &under));
                    let rest_of_less = form.of(&under) + more / t2;
                    // Q of the difference from above: its rounding and the uncertainty of its products counted the other way.
                    let below = below + 2.0 * self.compliance.uncertainty(&less, &less) + rounding + rest_of_less;
                    0.25 * (above - below) - rounding
                }
                Given::Load(_) => {
                    let less: Vec<f64> = unit.iter().map(|m| -m).collect();
                    own - missed(&self.cuts(&less, p, None, rest / gamma, 1.0), gamma, rest) - room
                }
            };
            force = [below, own + missed(&self.cuts(unit, p, added, rest / gamma, 1.0), gamma, rest) + room];
            let known = Known { planes, stiffness: matrix, inverse, form, off: products_off, gamma, displaced };
            match given {
                Given::Plane(_) => {
                    let bounds = |m: usize| {
                        let psi = map.transpose() * frame.coordinate(m);
                        self.moment((p, added), (g, &psi), &known)
                    };
                    moments = Some([bounds(0), bounds(1)]);
                }
                Given::Load(_) => {
                    asked = Some(frame.loads().map(|e| {
                        let e = inward * e;
                        let below = |e: Vector3<f64>| self.depth_below((p, g), &e, &known);
                        [g.dot(&e) - below(e), g.dot(&e) + below(-e)]
                    }));
                }
            }
            bounds_of_energy[1] = low + 2.0 * gamma;
            stiffness_error = 0.5 * rest / matrix[(0, 0)];
        }
        let finite = |ends: &[f64; 2]| ends.iter().all(|end| end.is_finite());
        let both_finite = |bounds: &[[f64; 2]; 2]| bounds.iter().all(finite);
        let ordered = force[1] >= force[0] && bounds_of_energy[0] > 0.0;
        if !(finite(&force) && finite(&bounds_of_energy) && ordered && load[0] > 0.0) {
            return None;
        }
        // In the outline's axes.
        let plane = self.outer_plane(pressed)?;
        let outer = map * matrix * map.transpose();
        let cells = (0..self.mesh().loaded).map(|i| (self.mesh().corners(i).map(|q| self.fitted.to_outline(q)), p[i]));
        let touches = |cell: usize| contact[cell] || self.enclosing(cell, p).is_some();
        let touching: Vec<bool> = (0..contact.len()).map(touches).collect();
        let mut regions = regions(self.mesh(), &touching, p, &|cell| self.may_lift(cell, p, unit));
        regions.iter_mut().for_each(|region| region.map(|q| self.fitted.to_outline(q)));
        Some(Tilted {
            plane,
            load: (map * load).into(),
            matrix: [0, 1, 2].map(|i| [0, 1, 2].map(|j| outer[(i, j)])),
            stiffness_error,
            force,
            proved,
            depth: asked.map(|[depth, ..]| depth).filter(finite),
            tilts: asked.map(|[_, x, y]| [x, y]).filter(both_finite),
            moments: moments.filter(both_finite),
            energy: bounds_of_energy.map(|q| 0.5 * q),
            cells: cells.collect(),
            regions,
            everywhere: !pressed.lifts(),
            unknowns: self.compliance.n,
        })
    }

    /// Bounds of the integral of p psi at the plane g, psi = psi . (1, x, y), as those of the force with psi in place of 1.
    fn moment(
        &self,
        (p, added): (&[f64], Option<&[f64]>),
        (g, psi): (&Vector3<f64>, &Vector3<f64>),
        known: &Known,
    ) -> [f64; 2] {
        let Known { planes, stiffness: k, gamma, displaced, .. } = known;
        let (m, load) = (planes.combined(psi), self.load(p));
        let own = psi.dot(&load) - added.map_or(0.0, |added| psi.dot(&self.load(added)));
        let [work, both] = [psi.dot(&(k * psi)), (psi.dot(&(k * psi)) * g.dot(&(k * g))).sqrt()];
        let rest = known.rest(psi) + displaced * (work + k[(0, 0)] * psi.norm_squared());
        let rounding = 1e-12 * (sizes(psi, &load) + both) + displaced * (both + k[(0, 0)] * psi.norm() * g.norm());
        let room = 2.0 * rounding + 3.0 * self.compliance.uncertainty(p, &m);
        let corners = (0..self.mesh().loaded).flat_map(|cell| self.mesh().corners(cell));
        let size = corners.map(|[x, y]| (psi[0] + psi[1] * x + psi[2] * y).abs()).fold(0.0, f64::max);
        let off_by = |m: &[f64]| missed(&self.cuts(m, p, added, rest / gamma, size), *gamma, rest) + room;
        let less: Vec<f64> = m.iter().map(|m| -m).collect();
        [own - off_by(&less), own + off_by(&m)]
    }

    /// (10): by how much g* . e may fall short of g . e, e the load asked for.
    fn depth_below(&self, (p, g): (&[f64], &Vector3<f64>), e: &Vector3<f64>, known: &Known) -> f64 {
        let Known { planes, inverse, gamma, displaced, .. } = known;
        let w = self.load(p);
        let c = inverse * e;
        let m = planes.combined(&c);
        let off_p = self.compliance.off(p);
        // One load, and orthogonality, but for rounding and what the products are known to.
        let gamma = gamma + 1e-11 * sizes(g, &w);
        let with = |tau: f64| {
            // The others take on the load of what is cut off, and are cut anew.
            let mut q = cut_off(&m, tau, p);
            for _ in 0..CUT_ANEW {
                q = cut_off(&planes.combined(&(inverse * (e + self.load(&q)))), tau, p);
            }
            let load = self.load(&q);
            let more = inverse * load;
            let added = planes.combined(&more);
            let left: Vec<f64> = m.iter().zip(&added).zip(&q).map(|((m, added), q)| m + added - q).collect();
            let (product, off_q) = (self.compliance.product(&q), self.compliance.off(&q));
            let work: f64 = q.iter().zip(&product).map(|(q, u)| q * u).sum();
            // Twice <q, rho> = 0, and <q, S q>.
            let of_q = 1e-11 * (work + sizes(&c, &load) + sizes(&more, &load)) + 2.0 * known_to(&left, &off_q);
            let left_of_q = work + of_q + 3.0 * known_to(&q, &off_q);
            let rest = known.rest(&(c + more)) + displaced * (sizes(&c, e) + sizes(&more, &load));
            let room = (1e-11 + displaced) * (sizes(&c, &w) + sizes(g, e) + sizes(&more, &w) + sizes(g, &load))
                + known_to(&m, &off_p)
                + known_to(&added, &off_p)
                + known_to(&q, &off_p);
            missed(&[Cut { tau: largest(&left, p), left: left_of_q, of_added: 0.0 }], gamma, rest) + room
        };
        halved(largest(&m, p), known.rest(&c) / gamma).map(with).fold(f64::INFINITY, f64::min)
    }

    /// From q = 0 down to where a smaller tau gains nothing, for the pressure m of a plane of at most this `size`; `ratio`: a'' over gamma.
    fn cuts(&self, m: &[f64], p: &[f64], added: Option<&[f64]>, ratio: f64, size: f64) -> Vec<Cut> {
        let left = |tau: f64| {
            let q = cut_off(m, tau, p);
            let product = self.compliance.product(&q);
            let products = q.iter().zip(&product).zip(&self.weights[0]);
            let [work, load] = products.fold([0.0; 2], |[work, load], ((q, u), area)| [work + q * u, load + q * area]);
            let off = self.compliance.off(&q);
            // <q, 1 - S m_h> = 0 but for what the solution and the products are rounded by.
            let rounding = 4e-12 * size * load + 2.0 * known_to(m, &off);
            let of_added = added.map_or(0.0, |d| {
                let (own, size) =
                    product.iter().zip(d).fold((0.0, 0.0), |(s, a), (u, d)| (s + u * d, a + (u * d).abs()));
                own + 1e-12 * size + known_to(d, &off)
            });
            Cut { tau, left: work + rounding + known_to(&q, &off), of_added }
        };
        halved(largest(m, p), ratio).map(left).collect()
    }

    /// <d, S d> from above, and what is left of <w, d> = 0, twice: of what was added to a pressure that is p with it.
    fn rest_of(&self, d: &[f64], p: &[f64]) -> f64 {
        let own: f64 = self.compliance.product(d).iter().zip(d).map(|(u, d)| u * d).sum();
        let size = |p: &[f64]| p.iter().zip(&self.weights[0]).map(|(p, w)| p.abs() * w).sum::<f64>();
        let rounding = 1e-11 * size(d) * size(p);
        own * (1.0 + 1e-12) + self.compliance.uncertainty(d, d) + 2.0 * self.compliance.uncertainty(d, p) + rounding
    }

    /// 2 <f, p> - <p, S p>, from below.
    fn form_below(&self, p: &[f64], g: &Vector3<f64>) -> f64 {
        let work: f64 = p.iter().zip(self.integrals(g)).map(|(p, f)| p * f).sum();
        let size: f64 = p.iter().zip(self.integrals(g)).map(|(p, f)| (p * f).abs()).sum();
        let product: f64 = p.iter().zip(self.compliance.product(p)).map(|(p, u)| p * u).sum();
        2.0 * work - product - self.compliance.uncertainty(p, p) - 4e-12 * size
    }
}

/// What a force is told with: tau, <q, S q> from above for q = max(m_h - tau p_h, 0), and <q, S d> for what was added to p_h.
struct Cut {
    tau: f64,
    left: f64,
    of_added: f64,
}

/// How often what is cut off a pressure is determined anew, after its load was taken on by the rest.
const CUT_ANEW: usize = 2;

/// The largest m/p, 0 at least.
fn largest(m: &[f64], p: &[f64]) -> f64 {
    m.iter().zip(p).map(|(m, p)| m / p).fold(0.0, f64::max)
}

/// q = max(m - tau p, 0).
fn cut_off(m: &[f64], tau: f64, p: &[f64]) -> Vec<f64> {
    m.iter().zip(p).map(|(m, p)| (m - tau * p).max(0.0)).collect()
}

/// tau from the largest down to where a smaller one gains nothing; `ratio`: a'' over gamma.
fn halved(largest: f64, ratio: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(largest), move |tau| (tau * tau > 0.5 * ratio).then_some(0.5 * tau))
}

/// What is known of all planes in contact.
struct Known<'a> {
    planes: &'a Planes,
    /// K and its inverse.
    stiffness: Matrix3<f64>,
    inverse: Matrix3<f64>,
    form: ResidualForm,
    /// By how much products of the pressures of 1, x and y may be off.
    off: Matrix3<f64>,
    gamma: f64,
    /// What the place of the edges leaves open, relative.
    displaced: f64,
}

impl Known<'_> {
    /// a(rho, rho) of a plane, from above.
    fn rest(&self, plane: &Vector3<f64>) -> f64 {
        self.form.of(plane) + 2.0 * plane.abs().dot(&(self.off * plane.abs()))
    }
}

/// sum of |a_k b_k|.
fn sizes(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.component_mul(b).abs().sum()
}

/// max over X in [0, gamma] of tau X + sqrt(2 (gamma - X) (a'' + <q, S q>)) + <q, S d>, with the best of `cuts`; `rest`: a''.
fn missed(cuts: &[Cut], gamma: f64, rest: f64) -> f64 {
    let with = |Cut { tau, left, of_added }: &Cut| {
        let rest = rest + left;
        let balance = (rest / (2.0 * gamma)).sqrt();
        of_added + if *tau <= balance { (2.0 * gamma * rest).sqrt() } else { tau * gamma + rest / (2.0 * tau) }
    };
    cuts.iter().map(with).fold(f64::INFINITY, f64::min)
}
