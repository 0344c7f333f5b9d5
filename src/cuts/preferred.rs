//! The cuts a node would like to have. Luo & Zou 2025, section 3.2, equations 3-5, carried over to unequal radii and tapers.
//!
//! For a pair of struts the paper's cut is where their silhouettes cross, in the plane of both axes. For equal radii the
//! crossing halves the angle. For unequal ones it runs away as the angle nears 180°; there the rim only has to lie behind the other
//! strut's end plane. The rule is the longer of that and of a shared angle, cap i : cap j = r_i : r_j; so caps never overlap,
//! whatever the radii. Derived in `docs/method/cut.md`.

use super::cone::Cone;
use std::f64::consts::FRAC_PI_2;

/// Least distance between a rim and its highest pairwise cut, in radii of its strut. Measured: at 0.2 the straight and
/// the 160° degree-2 nodes fit like the others; for equal radii it changes nothing below 112.6° (λ = 0.3: 0.3 d ≥ 0.2).
pub const LEAST_ROOM: f64 = 0.2;

/// The cap strut i may have if the angle `theta` to strut j is shared as their radii, radians. What widening struts take up
/// at any distance, the angle of their cones, is taken off first. The two caps of a pair sum to `theta`.
pub fn shared(i: Cone, j: Cone, theta: f64) -> f64 {
    let widening = |c: Cone| c.k.max(0.0).atan();
    widening(i) + (theta - widening(i) - widening(j)) * (i.r / (i.r + j.r))
}

/// Cut of strut i on account of strut j at angle `theta` (radians), in radii of strut i at the node.
fn pairwise(i: Cone, j: Cone, theta: f64) -> f64 {
    let share = i.cut(shared(i, j, theta));
    if is_even(i, j) {
        return share / i.r;
    }
    let (sin, cos) = theta.sin_cos();
    // Where r_i + k_i x and r_j + k_j y meet, x and y along the axes: x = top(i, j) / bottom, y = top(j, i) / bottom.
    let top = |i: Cone, j: Cone| j.r + i.r * cos + j.k * i.r * sin;
    let bottom = sin - (i.k + j.k) * cos - i.k * j.k * sin;
    let clear = if top(j, i) < 0.0 {
        i.cut(theta - FRAC_PI_2) // the crossing is behind strut j's end: stay behind its end plane
    } else if bottom > 0.0 {
        (top(i, j) / bottom).max(0.0)
    } else {
        f64::INFINITY // cones that never part
    };
    clear.max(share) / i.r
}

/// Two cylinders of one radius: the crossing halves the angle.
fn is_even(i: Cone, j: Cone) -> bool {
    i.r == j.r && i.k == 0.0 && j.k == 0.0
}

/// The cut (mm) of strut `i` of a node: equations 3 to 5. `theta(j)` is its angle to strut j, radians.
pub fn cut(cones: &[Cone], i: usize, theta: impl Fn(usize) -> f64, lambda: f64) -> f64 {
    let me = cones[i];
    let mut even = f64::INFINITY; // the nearest strut among those of the same radius
    let mut most = 0.0f64;
    for (j, &other) in cones.iter().enumerate().filter(|&(j, _)| j != i) {
        if is_even(me, other) {
            even = even.min(theta(j));
        } else {
            most = most.max(pairwise(me, other, theta(j)));
        }
    }
    let most = if even.is_finite() { most.max(1.0 / (0.5 * even).tan()) } else { most };
    ((1.0 + lambda) * most).max(most + LEAST_ROOM) * me.r
}
