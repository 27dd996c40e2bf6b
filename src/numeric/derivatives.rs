//! Forward differentiation (Wengert 1964) to first, second and third order, on numbers and on intervals.

use super::real::Real;

/// A quantity with its derivatives with respect to x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dual<T> {
    pub value: T,
    pub gradient: [T; 2],
}

/// The same to second order: xx, xy, yy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jet<T> {
    pub value: T,
    pub gradient: [T; 2],
    pub hessian: [T; 3],
}

/// The same to third order: xxx, xxy, xyy, yyy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cube<T> {
    pub jet: Jet<T>,
    pub third: [T; 4],
}

/// What does not change has no share, however steep the function: x^y at constant y asks for ln x, which may not exist. Nor has
/// anything in what a function is level in.
fn share<T: Real>(slope: T, change: impl FnOnce() -> T) -> T {
    if slope.is_zero() {
        return T::from(0.0);
    }
    let change = change();
    if change.is_zero() { T::from(0.0) } else { slope * change }
}

/// The derivatives of a function of one quantity.
pub(crate) trait OfOne<T> {
    fn slope(&self) -> T;
    fn curvature(&self) -> T;
    fn third(&self) -> T;
}

/// The derivatives of a function of two: (f_a, f_b), (f_aa, f_ab, f_bb), (f_aaa, f_aab, f_abb, f_bbb).
pub(crate) trait OfTwo<T> {
    fn slopes(&self) -> [T; 2];
    fn curvatures(&self) -> [T; 3];
    fn thirds(&self) -> [T; 4];
}

/// A function of one or two quantities with derivatives: those of higher order are asked for where they are needed.
pub(crate) trait Chain<T: Real>: Copy {
    fn constant(value: f64) -> Self;
    /// f(a) from its value.
    fn chain(self, value: T, f: &impl OfOne<T>) -> Self;
    /// f(a, b) from its value.
    fn chain2(self, b: Self, value: T, f: &impl OfTwo<T>) -> Self;
    /// One of two, whichever it may be, with this value.
    fn either(self, b: Self, value: T) -> Self;
    /// a + b.
    fn plus(self, b: Self) -> Self;
    /// -a.
    fn minus(self) -> Self;
    /// Whether no derivative is other than 0.
    fn is_constant(self) -> bool;
    /// Value and derivatives by a map that is linear.
    fn linear(self, f: impl Fn(T) -> T) -> Self;
}

impl<T: Real> Chain<T> for Dual<T> {
    fn constant(value: f64) -> Self {
        Self { value: T::from(value), gradient: [T::from(0.0); 2] }
    }

    fn chain(self, value: T, f: &impl OfOne<T>) -> Self {
        let slope = f.slope();
        Self { value, gradient: self.gradient.map(|g| share(slope, || g)) }
    }

    fn chain2(self, b: Self, value: T, f: &impl OfTwo<T>) -> Self {
        let [fa, fb] = f.slopes();
        Self { value, gradient: [0, 1].map(|m| share(fa, || self.gradient[m]) + share(fb, || b.gradient[m])) }
    }

    fn either(self, b: Self, value: T) -> Self {
        Self { value, gradient: [0, 1].map(|m| self.gradient[m].hull(b.gradient[m])) }
    }

    fn plus(self, b: Self) -> Self {
        Self { value: self.value + b.value, gradient: [0, 1].map(|m| self.gradient[m] + b.gradient[m]) }
    }

    fn minus(self) -> Self {
        self.linear(|v| -v)
    }

    fn is_constant(self) -> bool {
        self.gradient.iter().all(|g| g.is_zero())
    }

    fn linear(self, f: impl Fn(T) -> T) -> Self {
        Self { value: f(self.value), gradient: self.gradient.map(f) }
    }
}

/// The pairs (i, j) of the entries xx, xy, yy.
const PAIRS: [(usize, usize); 3] = [(0, 0), (0, 1), (1, 1)];

/// g_i g_j; the square of one quantity is not negative.
fn product<T: Real>(g: [T; 2], n: usize) -> T {
    let (i, j) = PAIRS[n];
    if i == j { g[i].powi(2) } else { g[i] * g[j] }
}

impl<T: Real> Jet<T> {
    /// f(a) from its value, slope and curvature.
    fn chained(self, value: T, slope: T, curvature: T) -> Self {
        let g = self.gradient;
        let entry = |n: usize| share(curvature, || product(g, n)) + share(slope, || self.hessian[n]);
        Self { value, gradient: g.map(|g| share(slope, || g)), hessian: [entry(0), entry(1), entry(2)] }
    }

    /// f(a, b) from its value, slopes and curvatures.
    fn chained2(self, b: Self, value: T, [fa, fb]: [T; 2], [faa, fab, fbb]: [T; 3]) -> Self {
        let (p, q) = (self.gradient, b.gradient);
        let entry = |n: usize| {
            let (i, j) = PAIRS[n];
            share(faa, || product(p, n))
                + share(fab, || p[i] * q[j] + p[j] * q[i])
                + share(fbb, || product(q, n))
                + share(fa, || self.hessian[n])
                + share(fb, || b.hessian[n])
        };
        Self {
            value,
            gradient: [0, 1].map(|m| share(fa, || p[m]) + share(fb, || q[m])),
            hessian: [entry(0), entry(1), entry(2)],
        }
    }
}

impl<T: Real> Chain<T> for Jet<T> {
    fn constant(value: f64) -> Self {
        Self { value: T::from(value), gradient: [T::from(0.0); 2], hessian: [T::from(0.0); 3] }
    }

    fn chain(self, value: T, f: &impl OfOne<T>) -> Self {
        self.chained(value, f.slope(), f.curvature())
    }

    fn chain2(self, b: Self, value: T, f: &impl OfTwo<T>) -> Self {
        self.chained2(b, value, f.slopes(), f.curvatures())
    }

    fn either(self, b: Self, value: T) -> Self {
        Self { value, gradient: [0, 1].map(|m| self.gradient[m].hull(b.gradient[m])), hessian: [T::unknown(); 3] }
    }

    fn plus(self, b: Self) -> Self {
        Self {
            value: self.value + b.value,
            gradient: [0, 1].map(|m| self.gradient[m] + b.gradient[m]),
            hessian: [0, 1, 2].map(|n| self.hessian[n] + b.hessian[n]),
        }
    }

    fn minus(self) -> Self {
        self.linear(|v| -v)
    }

    fn is_constant(self) -> bool {
        self.gradient.iter().chain(&self.hessian).all(|d| d.is_zero())
    }

    fn linear(self, f: impl Fn(T) -> T) -> Self {
        Self { value: f(self.value), gradient: self.gradient.map(&f), hessian: self.hessian.map(&f) }
    }
}

/// How often x stands in the entries xxx, xxy, xyy, yyy.
const OF_X: [i32; 4] = [3, 2, 1, 0];

/// p_i p_j p_k; even powers are not negative.
fn triple<T: Real>([x, y]: [T; 2], n: usize) -> T {
    match OF_X[n] {
        3 => x.powi(3),
        2 => x.powi(2) * y,
        1 => x * y.powi(2),
        _ => y.powi(3),
    }
}

/// p_i p_j q_k + p_i q_j p_k + q_i p_j p_k.
fn mixed<T: Real>(p: [T; 2], q: [T; 2], n: usize) -> T {
    let (two, three) = (T::from(2.0), T::from(3.0));
    match OF_X[n] {
        3 => three * p[0].powi(2) * q[0],
        2 => p[0].powi(2) * q[1] + two * (p[0] * p[1] * q[0]),
        1 => p[1].powi(2) * q[0] + two * (p[0] * p[1] * q[1]),
        _ => three * p[1].powi(2) * q[1],
    }
}

/// p_i H_jk + p_j H_ik + p_k H_ij.
fn bent<T: Real>(p: [T; 2], [xx, xy, yy]: [T; 3], n: usize) -> T {
    let (two, three) = (T::from(2.0), T::from(3.0));
    match OF_X[n] {
        3 => three * p[0] * xx,
        2 => two * p[0] * xy + p[1] * xx,
        1 => two * p[1] * xy + p[0] * yy,
        _ => three * p[1] * yy,
    }
}

impl<T: Real> Chain<T> for Cube<T> {
    fn constant(value: f64) -> Self {
        Self { jet: Jet::constant(value), third: [T::from(0.0); 4] }
    }

    fn chain(self, value: T, f: &impl OfOne<T>) -> Self {
        let (slope, curvature, third) = (f.slope(), f.curvature(), f.third());
        let Jet { gradient: g, hessian: h, .. } = self.jet;
        let entry = |n: usize| {
            share(third, || triple(g, n)) + share(curvature, || bent(g, h, n)) + share(slope, || self.third[n])
        };
        Self { jet: self.jet.chained(value, slope, curvature), third: [entry(0), entry(1), entry(2), entry(3)] }
    }

    fn chain2(self, b: Self, value: T, f: &impl OfTwo<T>) -> Self {
        let (slopes, curvatures, [faaa, faab, fabb, fbbb]) = (f.slopes(), f.curvatures(), f.thirds());
        let ([fa, fb], [faa, fab, fbb]) = (slopes, curvatures);
        let (Jet { gradient: p, hessian: a, .. }, Jet { gradient: q, hessian: c, .. }) = (self.jet, b.jet);
        let entry = |n: usize| {
            let by_thirds = share(faaa, || triple(p, n))
                + share(faab, || mixed(p, q, n))
                + share(fabb, || mixed(q, p, n))
                + share(fbbb, || triple(q, n));
            let by_curvatures = share(faa, || bent(p, a, n))
                + share(fab, || bent(p, c, n) + bent(q, a, n))
                + share(fbb, || bent(q, c, n));
            by_thirds + by_curvatures + share(fa, || self.third[n]) + share(fb, || b.third[n])
        };
        Self {
            jet: self.jet.chained2(b.jet, value, slopes, curvatures),
            third: [entry(0), entry(1), entry(2), entry(3)],
        }
    }

    fn either(self, b: Self, value: T) -> Self {
        Self { jet: self.jet.either(b.jet, value), third: [T::unknown(); 4] }
    }

    fn plus(self, b: Self) -> Self {
        Self { jet: self.jet.plus(b.jet), third: [0, 1, 2, 3].map(|n| self.third[n] + b.third[n]) }
    }

    fn minus(self) -> Self {
        self.linear(|v| -v)
    }

    fn is_constant(self) -> bool {
        self.jet.is_constant() && self.third.iter().all(|d| d.is_zero())
    }

    fn linear(self, f: impl Fn(T) -> T) -> Self {
        Self { jet: self.jet.linear(&f), third: self.third.map(f) }
    }
}
