//! Numbers of neighbouring cells side by side, as vector units take them.

use pulp::Simd;

/// Cells of a row that are worked out side by side.
pub(super) const LANES: usize = 8;

/// One number for each of them.
pub(super) type Lane = [f64; LANES];

/// to += c x, N a multiple of what the vector unit takes.
#[inline(always)]
pub(super) fn add<S: Simd, const N: usize>(simd: S, to: &mut [f64; N], c: f64, x: &[f64; N]) {
    let c = simd.splat_f64s(c);
    for (to, x) in S::as_mut_simd_f64s(to).0.iter_mut().zip(S::as_simd_f64s(x).0) {
        *to = simd.mul_add_e_f64s(c, *x, *to);
    }
}

/// to += a b.
#[inline(always)]
pub(super) fn add_product<S: Simd>(simd: S, to: &mut Lane, a: &Lane, b: &Lane) {
    for ((to, a), b) in S::as_mut_simd_f64s(to).0.iter_mut().zip(S::as_simd_f64s(a).0).zip(S::as_simd_f64s(b).0) {
        *to = simd.mul_add_e_f64s(*a, *b, *to);
    }
}

/// to += c x^2.
#[inline(always)]
pub(super) fn add_square<S: Simd>(simd: S, to: &mut Lane, c: f64, x: &Lane) {
    let c = simd.splat_f64s(c);
    for (to, x) in S::as_mut_simd_f64s(to).0.iter_mut().zip(S::as_simd_f64s(x).0) {
        *to = simd.mul_add_e_f64s(simd.mul_f64s(c, *x), *x, *to);
    }
}

#[inline(always)]
pub(super) fn sum<S: Simd, const N: usize>(simd: S, a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    let mut to = [0.0; N];
    for ((to, a), b) in S::as_mut_simd_f64s(&mut to).0.iter_mut().zip(S::as_simd_f64s(a).0).zip(S::as_simd_f64s(b).0) {
        *to = simd.add_f64s(*a, *b);
    }
    to
}

#[inline(always)]
pub(super) fn difference<S: Simd, const N: usize>(simd: S, a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    let mut to = [0.0; N];
    for ((to, a), b) in S::as_mut_simd_f64s(&mut to).0.iter_mut().zip(S::as_simd_f64s(a).0).zip(S::as_simd_f64s(b).0) {
        *to = simd.sub_f64s(*a, *b);
    }
    to
}

/// Sum of c_k times the k-th row.
#[inline(always)]
pub(super) fn combination<S: Simd, const K: usize, const N: usize>(
    simd: S,
    c: &[f64; K],
    rows: &[[f64; N]; K],
) -> [f64; N] {
    let mut to = [0.0; N];
    for (c, row) in c.iter().zip(rows) {
        add(simd, &mut to, *c, row);
    }
    to
}
