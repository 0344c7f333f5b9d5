//! One strut seen from one of its nodes: its radius along the axis, and what that means for cut and cap.

use std::f64::consts::FRAC_PI_2;

/// A strut end: radius `r + k d` (mm) at distance d (mm) from the node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Radius at the node (mm).
    pub r: f64,
    /// Growth of the radius along the axis (mm per mm); 0 for a cylinder, below 0 where the strut thins away from the node.
    pub k: f64,
}

impl Cone {
    /// The cut (mm) whose rim is seen from the node as a cap of angular radius `cap` (radians): `tan cap = r/d + k`.
    /// 0 from 90° on; infinite where the strut widens too fast for so small a cap.
    pub fn cut(self, cap: f64) -> f64 {
        if cap >= FRAC_PI_2 {
            return 0.0;
        }
        let slope = cap.max(0.0).tan() - self.k;
        if slope > 0.0 { self.r / slope } else { f64::INFINITY }
    }

    /// The cap of the rim at distance `cut` (mm): its angular radius seen from the node, radians.
    pub fn cap(self, cut: f64) -> f64 {
        (self.r / cut + self.k).atan()
    }

    /// A strut of this length (mm) with these radii at its ends a and b (mm), seen from a and from b.
    pub fn pair([ra, rb]: [f64; 2], length: f64) -> [Cone; 2] {
        let growth = (rb - ra) / length;
        [Cone { r: ra, k: growth }, Cone { r: rb, k: if growth == 0.0 { 0.0 } else { -growth } }]
    }
}
