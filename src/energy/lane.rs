//! Numbers of neighbouring cells side by side, as vector units take them.

/// Cells of a row that are worked out side by side.
pub(super) const LANES: usize = 8;

/// One number for each of them.
pub(super) type Lane = [f64; LANES];

/// to += c x.
#[inline(always)]
pub(super) fn add(to: &mut Lane, c: f64, x: &Lane) {
    for (to, x) in to.iter_mut().zip(x) {
        *to += c * x;
    }
}
