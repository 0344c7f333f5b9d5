//! Struts that come closer than their radii without sharing a node.
//!
//! A strut is taken as the capsule of its larger radius: exact for cylinders and their nodes, too careful for tapered struts.
//! Candidates come from a bounding-volume tree (parry3d); each is measured by the exact distance between two segments
//! (Ericson, Real-Time Collision Detection, 5.1.9, with all four end-to-segment distances besides: parallel segments
//! then need no special case). Touching counts as too close. Not promised: struts that share a node are not looked at.

use super::Graph;
use crate::error::{Fault, Note};
use crate::ids::StrutId;
use glam::DVec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use rayon::prelude::*;

/// Struts closer than the sum of their radii times one plus this touch (relative). Reason: round-off of the distance. Guessed.
const TOUCHING: f64 = 1e-9;

/// A strut as a segment with a radius (mm).
#[derive(Clone, Copy, Debug)]
pub struct Capsule {
    pub strut: StrutId,
    /// The places of its two ends: capsules with a common place share a node.
    pub ends: [u32; 2],
    pub p: DVec3,
    pub q: DVec3,
    pub radius: f64,
}

/// Two struts that come too close without sharing a node; `a < b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearMiss {
    pub a: StrutId,
    pub b: StrutId,
    /// Distance between the axes (mm).
    pub distance: f64,
    /// The sum of the radii: what the distance has to exceed (mm).
    pub wanted: f64,
    /// Half-way between the closest points of the axes (mm).
    pub at: DVec3,
}

impl NearMiss {
    /// As a fault of the second strut.
    pub fn fault(&self) -> Fault {
        let wanted = format!("more than {} mm, the sum of the radii, or a common node", self.wanted);
        Fault::new(format!("struts[{}]", self.b.0), self.found(), wanted)
    }

    /// As a note on the second strut.
    pub fn note(&self) -> Note {
        let what = format!("{}, sum of the radii {} mm: kept, and the solid crosses itself there", self.found(), self.wanted);
        Note::new(format!("struts[{}]", self.b.0), what)
    }

    fn found(&self) -> String {
        let NearMiss { a, distance, at, .. } = self;
        format!("its axis {distance:.6} mm from that of struts[{}] at [{:.6}, {:.6}, {:.6}]", a.0, at.x, at.y, at.z)
    }
}

/// All pairs that come too close, ordered by `(b, a)`.
pub fn near_misses(graph: &Graph) -> Vec<NearMiss> {
    let capsule = |(k, s): (usize, &super::Strut)| Capsule {
        strut: StrutId(k as u32),
        ends: [s.a.0, s.b.0],
        p: graph.nodes()[s.a.index()],
        q: graph.nodes()[s.b.index()],
        radius: s.ra.max(s.rb),
    };
    among(&graph.struts().iter().enumerate().map(capsule).collect::<Vec<_>>())
}

/// All pairs of capsules that come too close, ordered by `(b, a)`. The capsules are ordered by strut.
pub fn among(capsules: &[Capsule]) -> Vec<NearMiss> {
    let boxes: Vec<Aabb> = capsules.iter().map(bounds).collect();
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let with_earlier = |k: usize| {
        let mut earlier: Vec<u32> = tree.intersect_aabb(&boxes[k]).filter(|&j| (j as usize) < k).collect();
        earlier.sort_unstable();
        earlier.into_iter().filter_map(move |j| near_miss(&capsules[j as usize], &capsules[k]))
    };
    (0..capsules.len()).into_par_iter().flat_map_iter(with_earlier).collect()
}

fn bounds(c: &Capsule) -> Aabb {
    let reach = DVec3::splat(c.radius * (1.0 + 2.0 * TOUCHING));
    let corner = |p: DVec3| Vector::from_array(p.to_array());
    Aabb::new(corner(c.p.min(c.q) - reach), corner(c.p.max(c.q) + reach))
}

fn near_miss(a: &Capsule, b: &Capsule) -> Option<NearMiss> {
    if a.ends.iter().any(|end| b.ends.contains(end)) {
        return None;
    }
    let wanted = a.radius + b.radius;
    let (on_a, on_b) = closest_points([a.p, a.q], [b.p, b.q]);
    let distance = on_a.distance(on_b);
    (distance <= wanted * (1.0 + TOUCHING)).then(|| NearMiss { a: a.strut, b: b.strut, distance, wanted, at: on_a.midpoint(on_b) })
}

/// The closest points of two segments, one on each.
pub fn closest_points(a: [DVec3; 2], b: [DVec3; 2]) -> (DVec3, DVec3) {
    let mut best = (a[0], closest_on(b, a[0]));
    let mut consider = |pair: (DVec3, DVec3)| {
        if pair.0.distance_squared(pair.1) < best.0.distance_squared(best.1) {
            best = pair;
        }
    };
    consider((a[1], closest_on(b, a[1])));
    consider((closest_on(a, b[0]), b[0]));
    consider((closest_on(a, b[1]), b[1]));
    // Inside both: where the lines are closest. Feasible points all, so the nearest of the five pairs is the answer.
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let determinant = uu * vv - uv * uv;
    if determinant > 0.0 {
        let s = ((uv * v.dot(w) - vv * u.dot(w)) / determinant).clamp(0.0, 1.0);
        let on_a = a[0] + s * u;
        consider((on_a, closest_on(b, on_a)));
    }
    best
}

/// The point of a segment closest to `x`.
fn closest_on(segment: [DVec3; 2], x: DVec3) -> DVec3 {
    let u = segment[1] - segment[0];
    let t = (u.dot(x - segment[0]) / u.length_squared()).clamp(0.0, 1.0);
    if t.is_nan() { segment[0] } else { segment[0] + t * u }
}
