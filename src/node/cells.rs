//! Spherical Voronoi cells of the strut directions. Luo & Zou 2025, section 3.3.1, figure 6; with unequal radii
//! a Laguerre diagram, the project's own step.
//!
//! Each strut has a weight `A`; its cell is where `A c·u` is largest, so cells meet in planes through the node. Weights 1 give
//! Voronoi cells. `A = 1 / cos ρ` gives the Laguerre diagram of caps of radius ρ, whose cells contain their caps as long as
//! these are disjoint (`weights`).
//!
//! Differs from the paper (Fortune's algorithm) and from the dual of the convex hull: each side is found by
//! itself, as the part of the plane's circle between two cells where no third strut is nearer. On that circle
//! each other strut rules out one half circle, so a side is an intersection of half circles; that holds for
//! flat, half-space, cubic and two-strut nodes alike, with no special case. Corners that fall together become one,
//! so the corner of a cubic lattice, where four cells meet, stays one corner; so do the ends of short sides (`join`).
//! Tests hold the result against the convex hull.
//!
//! Each side is written in its own frame: `y(φ) = cos φ M + sin φ n` runs along the crease, `M` in the plane of both
//! struts and scaled so that `φ` is the azimuth about both where their weights are equal; `y` then is the
//! crease of the two unit cylinders. With unequal weights the azimuth φ_k about strut k has `tan φ_k = tan φ / λ_k`.

use crate::node::join::join;
use crate::node::star::{Star, angle, perpendicular};
use glam::DVec3;
use std::f64::consts::PI;

/// Sides shorter than this (radians) are contracted to one corner where that makes nothing worse (`join`): the sectors along them would be slivers.
/// Measured on 422 nodes of a tet lattice: 0.04, 0.08, 0.12 and 0.15 leave jumps of curvature of 93, 51, 32 and 31 / r (99 % of the nodes); with 0.2 they grow again.
pub const SNAP: f64 = 0.15;

/// The same for a second try.
pub const LESS_SNAP: f64 = 0.04;

/// The same where no skin serves with sides contracted so far: below it sectors are thinner than readers' tolerance on usual models.
pub const LEAST_SNAP: f64 = 5e-5;

/// Corners that joining moves by more than this (radians) count as moved. Below, tangent planes are off by about as much, far below 0.01°.
pub(super) const MOVED: f64 = 2e-6;

/// A cell must reach beyond its cap by this share of the cap's angle, or the diagram of the caps themselves is taken. Guessed.
const CAP_ROOM: f64 = 0.02;

/// No arc of a side is wider than this (radians): wider ones are split by extra corners. One rational patch
/// then spans at most a third of a turn. A little above it, so that tetrahedral and body-centred nodes, whose sides
/// are a third of a turn wide, are not split by round-off.
pub const WIDEST: f64 = 2.0 * PI / 3.0 + 1e-6;

/// The cells of one node: corners and the sides between them.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// Points where cells meet: direction scaled so that its distance from the axis of a neighbouring strut is 1;
    /// with equal weights from all of them (a point on the crease of unit cylinders).
    pub corners: Vec<DVec3>,
    pub sides: Vec<Side>,
    /// Per arm: its sides in counter-clockwise order about the axis, as (side, which of the side's two arms).
    pub around: Vec<Vec<(usize, usize)>>,
    /// All weights are equal: Voronoi cells.
    pub uniform: bool,
    /// Corners were joined that were apart: sides at them leave the surfaces that are as near to both their struts.
    pub moved: bool,
}

/// The common border of two cells (or a part of it where a wide border was split).
#[derive(Clone, Debug)]
pub struct Side {
    /// The two struts, `arms[0] < arms[1]`.
    pub arms: [usize; 2],
    /// Corner at the start and at the end; φ grows from the first to the second.
    pub corners: [usize; 2],
    pub frame: Frame,
    /// Parameter φ of the start and of the end, radians, `phi[0] < phi[1]`: the azimuth about both struts where weights are equal.
    pub phi: [f64; 2],
}

impl Side {
    /// φ of a direction at one end of the side, the mean by both struts: they agree unless corners were joined.
    pub(super) fn parameter(&self, end: usize, direction: DVec3) -> f64 {
        let near = |a: f64| a + 2.0 * PI * ((self.phi[end] - a) / (2.0 * PI)).round();
        0.5 * (near(self.frame.parameter(0, direction)) + near(self.frame.parameter(1, direction)))
    }
}

/// The frame of a pair of struts.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Unit axes of the two struts.
    pub c: [DVec3; 2],
    /// Unit vectors perpendicular to each axis, towards the other strut: azimuth 0.
    pub e: [DVec3; 2],
    /// Unit normal of the plane of both struts, perpendicular to each axis: azimuth 90°. Counter-clockwise about `c[0]`, clockwise
    /// about `c[1]`. One vector, but for opposite struts, which no plane holds to the last bit.
    pub n: [DVec3; 2],
    /// Angle between the struts, radians.
    pub theta: f64,
    /// cot α_k: height of the crease over its distance from strut k, in the plane of both; α_k is the angle between them.
    pub height: [f64; 2],
    /// λ_k: distance of `M` from strut k. Their product is 1.
    pub wide: [f64; 2],
}

impl Frame {
    /// The frame of two struts with weights.
    pub fn new([a, b]: [DVec3; 2], [wa, wb]: [f64; 2]) -> Frame {
        let theta = angle(a, b);
        let n = normals(a, b);
        let (height, wide) = if wa == wb {
            ([1.0 / (0.5 * theta).tan(); 2], [1.0; 2])
        } else {
            // cos α_a A_a = cos α_b A_b, α_a + α_b = θ
            let (sin, cos) = theta.sin_cos();
            let height = [sin / (wa / wb - cos), sin / (wb / wa - cos)];
            let sines = height.map(|h| 1.0 / h.hypot(1.0));
            (height, [(sines[0] / sines[1]).sqrt(), (sines[1] / sines[0]).sqrt()])
        };
        Frame { c: [a, b], e: [n[0].cross(a), b.cross(n[1])], n, theta, height, wide }
    }

    /// The crease at φ.
    pub fn crease(&self, phi: f64) -> DVec3 {
        let (sin, cos) = phi.sin_cos();
        let cos = self.wide[0] * cos;
        self.height[0] * cos * self.c[0] + cos * self.e[0] + sin * self.n[0]
    }

    /// The azimuth about arm `k` (0 or 1) of a direction.
    pub fn azimuth(&self, k: usize, y: DVec3) -> f64 {
        y.dot(self.n[k]).atan2(y.dot(self.e[k]))
    }

    /// φ of a direction on the crease, by its azimuth about arm `k`.
    fn parameter(&self, k: usize, y: DVec3) -> f64 {
        y.dot(self.n[k]).atan2(y.dot(self.e[k]) / self.wide[k])
    }
}

/// Unit normal of the plane of two unit axes, perpendicular to the last bit to a and to b.
fn normals(a: DVec3, b: DVec3) -> [DVec3; 2] {
    /// Below this sine, cross products of opposite axes lose digits that their sum still has.
    const NEARLY_OPPOSITE: f64 = 1e-3;
    /// Below this sine any plane through the struts serves: which one would be a matter of round-off.
    const OPPOSITE: f64 = 1e-9;
    let cross = a.cross(b);
    let sine = cross.length();
    if sine > NEARLY_OPPOSITE || a.dot(b) > 0.0 {
        [cross.normalize(); 2]
    } else if sine > OPPOSITE {
        [a.cross(a + b).normalize(); 2]
    } else {
        let n = a.cross(perpendicular(a)).normalize();
        [n, (n - n.dot(b) * b).normalize()]
    }
}

/// Weights of the struts' cells. Equal radii whose Voronoi cells hold the caps: all 1. Else the Laguerre diagram of caps at one
/// common distance, the least at which no two meet; where a real cap leaves its cell of that diagram, that of the real caps.
fn weights(star: &Star) -> Vec<f64> {
    let n = star.degree();
    let caps: Vec<f64> = (0..n).map(|i| star.cap(i)).collect();
    let even = if star.is_uniform() { vec![1.0; n] } else { common(star) };
    let hold = |i: usize, j: usize| {
        let frame = Frame::new([star.axes[i], star.axes[j]], [even[i], even[j]]);
        // angle from each axis to the plane between the cells
        [(i, 0), (j, 1)].iter().all(|&(k, which)| 1.0f64.atan2(frame.height[which]) > caps[k] * (1.0 + CAP_ROOM))
    };
    if (0..n).all(|i| (i + 1..n).all(|j| hold(i, j))) { even } else { caps.iter().map(|c| 1.0 / c.cos()).collect() }
}

/// Weights of caps at the least common distance at which no two of them meet: r_i / D = tan ρ_i, ρ_i + ρ_j <= θ_ij.
fn common(star: &Star) -> Vec<f64> {
    // opposite struts alone would make it 0: all caps a half sphere
    let mut distance = 1e-3f64;
    for (i, &a) in star.axes.iter().enumerate() {
        for (j, &b) in star.axes.iter().enumerate().skip(i + 1) {
            // tan(ρ_i + ρ_j) = tan θ is quadratic in D
            let (sum, product, theta) = (star.radii[i] + star.radii[j], star.radii[i] * star.radii[j], angle(a, b));
            let (sin, cos) = theta.sin_cos();
            distance = distance.max((sum * cos + (sum * sum * cos * cos + 4.0 * sin * sin * product).sqrt()) / (2.0 * sin.max(1e-12)));
        }
    }
    star.radii.iter().map(|r| (r / distance).hypot(1.0)).collect()
}

/// A part of a bisector circle: start and end azimuth, end in (start, start + 2π].
type Arc = [f64; 2];

impl Cells {
    /// Cells of a node with two struts or more.
    pub fn new(star: &Star) -> Result<Cells, String> {
        Cells::joined(star, SNAP)
    }

    /// The same with sides contracted that are shorter than `snap` (radians).
    pub fn joined(star: &Star, snap: f64) -> Result<Cells, String> {
        let axes = &star.axes;
        let weights = weights(star);
        let mut corners = Vec::new(); // directions of all arc ends, before they are joined
        let mut sides = Vec::new();
        for i in 0..axes.len() {
            for j in i + 1..axes.len() {
                let frame = Frame::new([axes[i], axes[j]], [weights[i], weights[j]]);
                let Some(arc) = side_arc(axes, &weights, i, j, &frame) else { continue };
                let cuts = split(arc);
                for w in cuts.windows(2) {
                    let at = corners.len();
                    corners.push(frame.crease(w[0]).normalize());
                    corners.push(frame.crease(w[1]).normalize());
                    sides.push(Side { arms: [i, j], corners: [at, at + 1], frame, phi: [w[0], w[1]] });
                }
            }
        }
        let (joined, place) = join(snap, &corners, &sides, axes.len());
        let moved = corners.iter().zip(&place).any(|(corner, &k)| corner.distance(joined[k]) > MOVED);
        for side in &mut sides {
            side.corners = side.corners.map(|k| place[k]);
        }
        sides.retain(|s| s.corners[0] != s.corners[1]);
        let mut cells = Cells { corners: joined, sides, around: vec![Vec::new(); axes.len()], uniform: weights.iter().all(|&w| w == weights[0]), moved };
        cells.order(axes)?;
        cells.scale_corners();
        Ok(cells)
    }

    /// Order the sides about each arm, and check that the cells close: every cell is one ring of sides, and
    /// corners - sides + cells = 2 (Euler on the sphere).
    fn order(&mut self, axes: &[DVec3]) -> Result<(), String> {
        for arm in 0..axes.len() {
            let mut ring: Vec<(usize, usize)> =
                self.sides.iter().enumerate().filter_map(|(k, s)| s.arms.iter().position(|&a| a == arm).map(|w| (k, w))).collect();
            for at in 0..ring.len() {
                let end = self.ring_end(ring[at]);
                let next = (at + 1..ring.len()).find(|&k| self.ring_start(ring[k]) == end);
                match next {
                    Some(k) => ring.swap(at + 1, k),
                    None if at + 1 == ring.len() && end == self.ring_start(ring[0]) => {}
                    None => return Err(format!("the cell of strut {arm} of the node does not close")),
                }
            }
            if ring.len() < 2 {
                return Err(format!("the cell of strut {arm} of the node has {} sides, needs 2", ring.len()));
            }
            self.around[arm] = ring;
        }
        let euler = self.corners.len() as i64 - self.sides.len() as i64 + axes.len() as i64;
        if euler != 2 {
            return Err(format!("the node's cells do not cover the sphere once (Euler number {euler}, must be 2)"));
        }
        Ok(())
    }

    /// The corner where a side starts, going counter-clockwise about the arm.
    fn ring_start(&self, (side, which): (usize, usize)) -> usize {
        self.sides[side].corners[which]
    }

    fn ring_end(&self, (side, which): (usize, usize)) -> usize {
        self.sides[side].corners[1 - which]
    }

    /// Scale corners onto the unit cylinders, and set each side's azimuths to those of its corners.
    fn scale_corners(&mut self) {
        let mut scaled = vec![false; self.corners.len()];
        for side in &mut self.sides {
            for end in 0..2 {
                let k = side.corners[end];
                let dir = self.corners[k];
                if !scaled[k] {
                    self.corners[k] = dir / dir.cross(side.frame.c[0]).length();
                    scaled[k] = true;
                }
                side.phi[end] = side.parameter(end, dir);
            }
        }
    }
}

/// The part of the circle between the cells of struts i and j where no other strut is nearer.
fn side_arc(axes: &[DVec3], weights: &[f64], i: usize, j: usize, frame: &Frame) -> Option<Arc> {
    let mid = frame.wide[0] * (frame.height[0] * axes[i] + frame.e[0]);
    let mut arc: Arc = [-PI, PI];
    let mut whole = true;
    for (k, &c) in axes.iter().enumerate() {
        if k == i || k == j {
            continue;
        }
        // strut k is no nearer than i where p cos φ + q sin φ <= 0
        let apart = weights[k] * c - weights[i] * axes[i];
        let (p, q) = (apart.dot(mid), apart.dot(frame.n[0]));
        if p.hypot(q) < 1e-12 {
            continue;
        }
        let centre = (-q).atan2(-p); // middle of the allowed half circle
        let half = [centre - 0.5 * PI, centre + 0.5 * PI];
        if whole {
            arc = half;
            whole = false;
            continue;
        }
        // arc has at most half a turn: intersect with the half circle, moved next to it
        let turn = ((0.5 * (arc[0] + arc[1]) - centre) / (2.0 * PI)).round() * 2.0 * PI;
        arc = [arc[0].max(half[0] + turn), arc[1].min(half[1] + turn)];
        if arc[1] - arc[0] < 1e-12 {
            return None;
        }
    }
    // bring the middle of the arc next to azimuth 0
    let turn = (0.5 * (arc[0] + arc[1]) / (2.0 * PI)).round() * 2.0 * PI;
    Some([arc[0] - turn, arc[1] - turn])
}

/// Where to split an arc so that each part is at most `WIDEST` wide and lies within 100° of azimuth 0 or of
/// azimuth 180° (the patch layer's rational parameter t = tan(φ/2) is measured from one of the two).
fn split(arc: Arc) -> Vec<f64> {
    let right = 0.5 * PI;
    let reach = 100f64.to_radians();
    let mut at = vec![arc[0]];
    for quarter in -4i32..=4 {
        let phi = quarter as f64 * right;
        let odd = quarter % 2 != 0;
        // odd quarters part front from back; even ones halve what is too wide
        let needed = if odd { phi - arc[0] > reach - right && arc[1] - phi > reach - right } else { arc[1] - arc[0] > WIDEST };
        if needed && phi > arc[0] + 0.1 && phi < arc[1] - 0.1 {
            at.push(phi);
        }
    }
    at.push(arc[1]);
    // whatever is still too wide is halved
    let mut fine = vec![at[0]];
    for w in at.windows(2) {
        let parts = ((w[1] - w[0]) / WIDEST).ceil().max(1.0);
        for k in 1..=parts as usize {
            fine.push(if k as f64 == parts { w[1] } else { w[0] + (w[1] - w[0]) * k as f64 / parts });
        }
    }
    fine
}
