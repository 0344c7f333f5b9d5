//! Minimum cutting. Luo & Zou 2025, section 3.2, equations 3-5.
//!
//! Differs from the paper in one point: a cut is never nearer than `LEAST_ROOM` to the highest pairwise cut.
//! With struts more than 112.6° apart equation 5 leaves next to no room (none at 180°) between the rim and
//! the neighbouring cell, and the skin needs some.

use crate::node::star::angle;
use glam::DVec3;

/// Least distance between a rim and its highest pairwise cut, in node radii. Measured: at 0.2 the straight
/// and the 160° degree-2 nodes fit like the others; it changes nothing below 112.6° (λ = 0.3: 0.3 d ≥ 0.2).
pub const LEAST_ROOM: f64 = 0.2;

/// The cut of each strut: distance from the node to its end circle, in node radii. Equations 3, 4 and 5.
/// A single strut is not cut.
pub fn cuts(axes: &[DVec3], lambda: f64) -> Vec<f64> {
    if axes.len() < 2 {
        return vec![0.0; axes.len()];
    }
    axes.iter()
        .enumerate()
        .map(|(i, &a)| {
            let nearest = axes.iter().enumerate().filter(|&(j, _)| j != i).map(|(_, &b)| angle(a, b)).fold(f64::INFINITY, f64::min);
            let dm = 1.0 / (0.5 * nearest).tan(); // eq. 3 and 4: the nearest neighbour gives the longest cut
            ((1.0 + lambda) * dm).max(dm + LEAST_ROOM) // eq. 5
        })
        .collect()
}
