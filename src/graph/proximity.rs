//! Struts that come closer than their radii without sharing a node.
//!
//! The body of a strut is the truncated cone between its nodes (a cylinder where both radii are equal) with the ball of its own
//! radius about each node: what the lattice is before any blend. Its distance to another is exact, slope and all:
//!
//! - Along the axis the cone is the union of the balls that touch it from inside, of radius `r(s) cos α` about the point `s` of the
//!   axis, `tan α` the slope of the radius. With the two node balls that is the whole body: what the touching balls leave out at the
//!   wide end lies in its node ball. So a body is one *piece* (a segment with a radius linear along it) if its radii are equal,
//!   else three: the cone and two balls.
//! - Between two pieces `|p(s) - q(t)| - r(s) - r(t)` is convex in (s, t): its least value is at the inner point where the gradient
//!   is zero, where the axes cross, or on a border, where it is the least of one variable; each is a closed form (`closest`).
//!
//! Candidates come from a bounding-volume tree (parry3d) over the boxes of the node balls. Struts of equal radii are measured by the
//! distance between two segments (Ericson, Real-Time Collision Detection, 5.1.9, with all four end-to-segment distances besides:
//! parallel segments then need no special case). Touching counts as too close.
//! Not promised: struts that share a node are not looked at; neither are the blends, which may reach beyond the bodies.

use super::{Graph, Strut};
use crate::error::{Fault, Note};
use crate::ids::StrutId;
use glam::DVec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use rayon::prelude::*;

/// Struts closer than the sum of their radii times one plus this touch (relative). Reason: round-off of the distance. Guessed.
pub const TOUCHING: f64 = 1e-9;

/// The body of a strut: a segment with a radius at each end (mm).
#[derive(Clone, Copy, Debug)]
pub struct Body {
    pub strut: StrutId,
    /// The places of its two ends: bodies with a common place share a node.
    pub ends: [u32; 2],
    pub p: DVec3,
    pub q: DVec3,
    /// The radii at `p` and `q`.
    pub radii: [f64; 2],
}

impl Body {
    /// Where a point of the axis is, as a part of its length from `p`.
    fn part(&self, x: DVec3) -> f64 {
        if self.p == self.q { 0.0 } else { (x.distance(self.p) / self.q.distance(self.p)).min(1.0) }
    }
}

/// Two struts that come too close without sharing a node; `a < b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearMiss {
    pub a: StrutId,
    pub b: StrutId,
    /// Distance between the axes, where the bodies are closest or deepest in each other (mm).
    pub distance: f64,
    /// The sum of the radii there: what the distance has to exceed (mm). Where a strut tapers, its radius square to the cone.
    pub wanted: f64,
    /// Where these points are on the axes: parts of the lengths of `a` and `b`, from their first ends.
    pub along: [f64; 2],
    /// Half-way between those two points of the axes (mm).
    pub at: DVec3,
}

impl NearMiss {
    /// As a fault of the second strut.
    pub fn fault(&self) -> Fault {
        let wanted = format!("more than {} mm, the sum of the radii, or a common node", self.wanted);
        Fault { is_overlap: true, ..Fault::new(format!("struts[{}]", self.b.0), self.found(), wanted) }
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
    among(&bodies(graph))
}

/// The bodies of all struts, in order.
pub fn bodies(graph: &Graph) -> Vec<Body> {
    let body = |(k, s): (usize, &Strut)| Body {
        strut: StrutId(k as u32),
        ends: [s.a.0, s.b.0],
        p: graph.nodes()[s.a.index()],
        q: graph.nodes()[s.b.index()],
        radii: [s.ra, s.rb],
    };
    graph.struts().iter().enumerate().map(body).collect()
}

/// All pairs of bodies that come too close, ordered by `(b, a)`. The bodies are ordered by strut.
pub fn among(bodies: &[Body]) -> Vec<NearMiss> {
    within(bodies, TOUCHING)
}

/// All pairs whose distance is at most `1 + margin` times what it has to exceed, ordered by `(b, a)`. The bodies are ordered by strut.
pub fn within(bodies: &[Body], margin: f64) -> Vec<NearMiss> {
    let boxes: Vec<Aabb> = bodies.iter().map(|b| bounds(b, margin)).collect();
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let with_earlier = |k: usize| {
        let mut earlier: Vec<u32> = tree.intersect_aabb(&boxes[k]).filter(|&j| (j as usize) < k).collect();
        earlier.sort_unstable();
        earlier.into_iter().filter_map(move |j| near_miss(&bodies[j as usize], &bodies[k], margin))
    };
    (0..bodies.len()).into_par_iter().flat_map_iter(with_earlier).collect()
}

/// The box of both node balls, and so of the body: the cone lies in the convex hull of the two.
fn bounds(b: &Body, margin: f64) -> Aabb {
    let corner = |p: DVec3| Vector::from_array(p.to_array());
    let [ra, rb] = b.radii.map(|r| DVec3::splat(r * (1.0 + margin + TOUCHING)));
    Aabb::new(corner((b.p - ra).min(b.q - rb)), corner((b.p + ra).max(b.q + rb)))
}

fn near_miss(a: &Body, b: &Body, margin: f64) -> Option<NearMiss> {
    if a.ends.iter().any(|end| b.ends.contains(end)) {
        return None;
    }
    let Gap { points: [on_a, on_b], radii } = gap(a, b);
    let (distance, wanted) = (on_a.distance(on_b), radii);
    let along = [a.part(on_a), b.part(on_b)];
    (distance <= wanted * (1.0 + margin)).then(|| NearMiss { a: a.strut, b: b.strut, distance, wanted, along, at: on_a.midpoint(on_b) })
}

/// Where two bodies are closest, or deepest in each other.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// The points of the two axes.
    pub points: [DVec3; 2],
    /// The sum of the radii at these points (mm).
    pub radii: f64,
}

impl Gap {
    /// Distance between the surfaces (mm); below zero the depth to which the bodies cross.
    pub fn clearance(&self) -> f64 {
        self.points[0].distance(self.points[1]) - self.radii
    }
}

/// Where the bodies of two struts are closest, or deepest in each other.
pub fn gap(a: &Body, b: &Body) -> Gap {
    if a.radii[0] == a.radii[1] && b.radii[0] == b.radii[1] {
        let (on_a, on_b) = closest_points([a.p, a.q], [b.p, b.q]);
        return Gap { points: [on_a, on_b], radii: a.radii[0] + b.radii[0] };
    }
    let (first, second) = (pieces(a), pieces(b));
    let all = first.iter().flat_map(|f| second.iter().map(move |s| closest(f, s)));
    all.min_by(|g, h| g.clearance().total_cmp(&h.clearance())).expect("a body has a piece")
}

/// A segment with a radius linear along it, whose slope is less than one. A ball has its two ends in one point.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: DVec3,
    along: DVec3,
    radius: f64,
    growth: f64,
}

impl Piece {
    fn at(&self, s: f64) -> DVec3 {
        self.from + s * self.along
    }

    /// The parameter at which the ball comes nearest to `x`, or holds it deepest: least of `|x - p(s)| - r(s)`, which is convex.
    fn nearest_to(&self, x: DVec3) -> f64 {
        let length_sq = self.along.length_squared();
        if length_sq == 0.0 {
            return 0.0;
        }
        let foot = self.along.dot(x - self.from) / length_sq;
        let slope = self.growth / length_sq.sqrt();
        let aside = x.distance(self.at(foot));
        (foot + slope * aside / ((1.0 - slope * slope) * length_sq).sqrt()).clamp(0.0, 1.0)
    }
}

/// The pieces of a body: the cone by the balls that touch it from inside, and the node balls where that leaves them out.
fn pieces(b: &Body) -> Vec<Piece> {
    let [ra, rb] = b.radii;
    let along = b.q - b.p;
    if ra == rb {
        return vec![Piece { from: b.p, along, radius: ra, growth: 0.0 }];
    }
    let cos = along.length() / along.length().hypot(rb - ra);
    let cone = Piece { from: b.p, along, radius: ra * cos, growth: (rb - ra) * cos };
    let ball = |from, radius| Piece { from, along: DVec3::ZERO, radius, growth: 0.0 };
    vec![cone, ball(b.p, ra), ball(b.q, rb)]
}

/// Where two pieces are closest: the least of a convex function over the square of the two parameters.
fn closest(a: &Piece, b: &Piece) -> Gap {
    let gap = |s: f64, t: f64| Gap { points: [a.at(s), b.at(t)], radii: a.radius + s * a.growth + b.radius + t * b.growth };
    let (on_border_of_a, on_border_of_b) = (|s: f64| gap(s, b.nearest_to(a.at(s))), |t: f64| gap(a.nearest_to(b.at(t)), t));
    let mut best = on_border_of_a(0.0);
    let mut consider = |g: Gap| {
        if g.clearance() < best.clearance() {
            best = g;
        }
    };
    consider(on_border_of_a(1.0));
    consider(on_border_of_b(0.0));
    consider(on_border_of_b(1.0));
    // Inside both the direction n of the distance has n · u = growth of a and n · v = -growth of b, u and v along a and b:
    // n = x u + y v + z (u × v). Then the distance follows from its part along u × v, and the parameters from their parts along u, v.
    let (u, v, w) = (a.along, b.along, a.from - b.from);
    let (uu, uv, vv, across) = (u.dot(u), u.dot(v), v.dot(v), u.cross(v));
    let determinant = uu * vv - uv * uv;
    if determinant > 0.0 {
        let in_plane = ((vv * a.growth + uv * b.growth) * u - (uv * a.growth + uu * b.growth) * v) / determinant;
        let rest = 1.0 - in_plane.length_squared();
        if rest > 0.0 {
            let d = (w.dot(across) / across.length()).abs() / rest.sqrt() * in_plane - w;
            let s = ((vv * u.dot(d) - uv * v.dot(d)) / determinant).clamp(0.0, 1.0);
            consider(on_border_of_a(s));
        }
    }
    best
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
