//! Does the skin of a node meet what it should not: struts that do not end there, or the skin of another node?
//!
//! By construction a skin does not meet itself (it is star-shaped about its node) nor its own struts (each stays in the directions
//! of its cap), and `graph/proximity.rs` keeps struts apart from each other. What is left, because fillets reach beyond the union
//! of the struts, is looked at here, between all solids of a model:
//!
//! 1. Bounding-volume trees over the boxes of all skins' control points and of all struts give the pairs that may meet; the ball of
//!    the control points about the node takes most of them away.
//! 2. A patch lies in the convex hull of its control points (weights are positive); a strut between its rims is the convex hull of
//!    two discs, a round cap half a ball. GJK looks for a plane with `TOUCHING` of room between the two, and the plane is tried on
//!    both before it is believed.
//! 3. Patches without such a plane are halved (de Casteljau), as often as it takes, down to `SMALLEST`. What has no plane there
//!    crosses, or is nearer than the hulls of such small parts can tell.
//! 4. A strut of another solid that meets no patch may lie wholly within the skin: then it meets the cone over a patch.
//!
//! Lengths in mm, in steps 2 to 4 about the node and divided by its reach.

use super::model::{Circle, Model, Part, Solid, SplineSurface, Surface};
use super::units::{Instance, whole_strut};
use crate::graph::Graph;
use crate::ids::{NodeId, StrutId};
use crate::math::nurbs::{Jet1, NurbsSurface, Table};
use glam::{DVec2, DVec3, DVec4};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::SupportMap;
use rayon::prelude::*;
use std::fmt;

/// Least room between two hulls, in reaches of the node. Reason: round-off; the same as between struts (`proximity::TOUCHING`).
const TOUCHING: f64 = 1e-9;
/// Parts of patches smaller than this are not halved, in reaches of the node. A hull this small is off its surface by the square
/// of this at the most, so skins and struts 1e-8 reaches apart are still told apart.
const SMALLEST: f64 = 1e-4;
/// Points along each side of a patch that meets something, to find out how deep: for the message, not for the verdict.
const SAMPLES: usize = 17;
/// Last step of the walk to the deepest place, as a part of a patch's side: for the message alone.
const FINEST_STEP: f64 = 1e-6;

/// What the skin of a node meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Other {
    /// A strut that does not end at the node.
    Strut(StrutId),
    /// The skin of another node.
    Node(NodeId),
}

/// A skin that crosses or touches what it should not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    pub node: NodeId,
    pub other: Other,
    /// The deepest place found, mm.
    pub at: DVec3,
    /// Distance of the skin's point there from the other's surface, mm; below zero inside of it. From samples: the verdict does not depend on it.
    pub clearance: f64,
}

impl fmt::Display for Crossing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Crossing { other, at, clearance, .. } = self;
        let other = match other {
            Other::Strut(strut) => format!("strut {}, which does not end there", strut.0),
            Other::Node(node) => format!("the skin of node {}", node.0),
        };
        let how = if *clearance < 0.0 { format!("crosses {other}, {:.3e} mm deep,", -clearance) } else { format!("touches {other},") };
        write!(f, "its skin {how} at [{:.6}, {:.6}, {:.6}]", at.x, at.y, at.z)
    }
}

/// All crossings, by node and what its skin meets: struts first; two skins once, at the smaller node. Halves of one strut count as the whole.
pub fn crossings(model: &Model) -> Vec<Crossing> {
    let mut struts: Vec<Strut> = model.solids.iter().flat_map(Strut::all).collect();
    struts.sort_by_key(|s| s.strut);
    struts.dedup_by(|other, half| {
        let same = other.strut == half.strut;
        if same {
            half.join(other);
        }
        same
    });
    between(model.solids.iter().flat_map(Skin::all).collect(), struts)
}

/// The same for units at their places; struts are those of the graph, from node to node.
pub fn unit_crossings(graph: &Graph, model: &Model, instances: &[Instance]) -> Vec<Crossing> {
    let of_unit: Vec<Option<Skin>> = model.solids.iter().map(|solid| Skin::of(solid, 0)).collect();
    let place = |instance: &Instance| {
        let skin = of_unit[instance.unit as usize].as_ref()?;
        let at = instance.at;
        Some(Skin { node: instance.node, offset: at, center: at, bounds: skin.bounds.map(|p| p + at), ..*skin })
    };
    let mut of_node = vec![u32::MAX; graph.nodes().len()];
    for (k, instance) in instances.iter().enumerate() {
        of_node[instance.node.index()] = k as u32;
    }
    let place_of = |node: NodeId| {
        let instance = &instances[of_node[node.index()] as usize];
        (&model.solids[instance.unit as usize], instance.at)
    };
    let strut = |k: usize| {
        let strut = StrutId(k as u32);
        let (solid, rims, round) = whole_strut(graph, strut, &place_of);
        let ends = graph.struts()[k];
        Strut { strut, solid, ends: [ends.a, ends.b], rims, round, halved: None }
    };
    between(instances.iter().filter_map(place).collect(), (0..graph.struts().len()).into_par_iter().map(strut).collect())
}

fn between(mut skins: Vec<Skin>, mut struts: Vec<Strut>) -> Vec<Crossing> {
    skins.sort_unstable_by_key(|s| s.node);
    struts.sort_unstable_by_key(|s| s.strut);
    let boxes: Vec<Aabb> = struts.iter().map(Strut::bounds).collect();
    let skin_boxes: Vec<Aabb> = skins.iter().map(|s| aabb(s.bounds)).collect();
    let [tree, skin_tree] = [&boxes, &skin_boxes].map(|leaves| Bvh::from_leaves(BvhBuildStrategy::Binned, leaves));
    let of_skin = |n: usize| {
        let skin = &skins[n];
        let sorted = |tree: &Bvh| {
            let mut found: Vec<usize> = tree.intersect_aabb(&skin_boxes[n]).map(|k| k as usize).collect();
            found.sort_unstable();
            found
        };
        let near_struts = sorted(&tree).into_iter().map(|k| &struts[k]).filter(|s| skin.may_meet(s)).collect::<Vec<_>>();
        let near_skins = sorted(&skin_tree).into_iter().filter(|&m| m > n).map(|m| &skins[m]).filter(|s| skin.may_meet_skin(s)).collect::<Vec<_>>();
        if near_struts.is_empty() && near_skins.is_empty() {
            return vec![];
        }
        let frame = Frame { origin: skin.center, unit: skin.reach };
        let nets = skin.nets(&frame);
        let with_struts = near_struts.into_iter().filter_map(|strut| meets_strut(skin, &nets, &frame, strut));
        with_struts.chain(near_skins.into_iter().filter_map(|other| meets_skin(skin, &nets, &frame, other))).collect()
    };
    (0..skins.len()).into_par_iter().flat_map_iter(of_skin).collect()
}

/// Where the patches of one node are.
struct Skin<'a> {
    node: NodeId,
    solid: &'a Solid,
    /// Position in the solid's nodes.
    n: usize,
    /// What is added to the solid's points, mm.
    offset: DVec3,
    center: DVec3,
    /// The box of the control points, mm.
    bounds: [DVec3; 2],
    /// Largest distance of a control point from the node, mm.
    reach: f64,
}

impl<'a> Skin<'a> {
    /// The skins of all nodes that have patches.
    fn all(solid: &'a Solid) -> Vec<Skin<'a>> {
        (0..solid.nodes.len()).into_par_iter().filter_map(|n| Skin::of(solid, n)).collect()
    }

    fn of(solid: &'a Solid, n: usize) -> Option<Skin<'a>> {
        let (part, center) = (solid.part(n), solid.centers[n]);
        let points = || patches(&part).flat_map(|p| &p.points).map(|&i| part.points[i as usize]);
        let bounds = points().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)]);
        let reach = points().map(|p| p.distance_squared(center)).fold(0.0, f64::max).sqrt();
        points().next().map(|_| Skin { node: solid.nodes[n], solid, n, offset: DVec3::ZERO, center, bounds, reach })
    }

    /// Whether a strut does not end here and comes into the ball of the control points.
    fn may_meet(&self, strut: &Strut) -> bool {
        let [a, b] = &strut.rims;
        let along = b.center - a.center;
        let nearest = a.center + ((self.center - a.center).dot(along) / along.length_squared()).clamp(0.0, 1.0) * along;
        let room = self.reach + a.radius.max(b.radius);
        !strut.ends.contains(&self.node) && nearest.distance(self.center) <= room * (1.0 + TOUCHING)
    }

    /// Whether the balls of the control points meet.
    fn may_meet_skin(&self, other: &Skin) -> bool {
        self.center.distance(other.center) <= (self.reach + other.reach) * (1.0 + TOUCHING)
    }

    /// Its patches, about the node (mm).
    fn patches(&self) -> Vec<NurbsSurface> {
        let part = self.solid.part(self.n);
        patches(&part).map(|p| part.spline_surface(p, self.center - self.offset)).collect()
    }

    /// The hulls of its patches.
    fn nets(&self, frame: &Frame) -> Vec<Net> {
        let part = self.solid.part(self.n);
        patches(&part).map(|p| Net::of(&part, p, self.offset, frame)).collect()
    }
}

fn patches(part: &Part) -> impl Iterator<Item = &SplineSurface> {
    part.faces.iter().filter_map(|face| if let Surface::Spline(spline) = &face.surface { Some(spline) } else { None })
}

/// Points and tangents of a patch.
fn samples(surface: &NurbsSurface) -> Vec<Jet1> {
    let [u, v] = [0, 1].map(|k| Table::even(surface.degree[k], &surface.knots[k], SAMPLES));
    surface.jets1([&u, &v])
}

/// The point of a patch, given about `center`, with the least value, mm: the best of the samples, walked down from there in ever smaller steps.
fn lowest(surface: &NurbsSurface, center: DVec3, value: impl Fn(DVec3) -> f64) -> DVec3 {
    let point = |t: DVec2| {
        let [u, v] = [0, 1].map(|k| surface.domain()[k]);
        center + surface.point(u[0] + t.x * (u[1] - u[0]), v[0] + t.y * (v[1] - v[0]))
    };
    let value_at = |t: DVec2| value(point(t));
    let mut step = 1.0 / (SAMPLES - 1) as f64;
    let grid = (0..SAMPLES * SAMPLES).map(|k| step * DVec2::new((k / SAMPLES) as f64, (k % SAMPLES) as f64));
    let least = |a: (f64, DVec2), b: (f64, DVec2)| if b.0 < a.0 { b } else { a };
    let mut best = grid.map(|t| (value_at(t), t)).reduce(least).expect("samples");
    while step > FINEST_STEP {
        let around = (0..9).map(|k| (best.1 + step * DVec2::new((k / 3) as f64 - 1.0, (k % 3) as f64 - 1.0)).clamp(DVec2::ZERO, DVec2::ONE));
        let next = around.map(|t| (value_at(t), t)).fold(best, least);
        step *= if next.0 < best.0 { 1.0 } else { 0.5 };
        best = next;
    }
    point(best.1)
}

/// A strut between its rims, with its round caps.
struct Strut<'a> {
    strut: StrutId,
    solid: &'a Solid,
    ends: [NodeId; 2],
    rims: [Circle; 2],
    /// Which end has a round cap.
    round: [bool; 2],
    /// The end where a disc halves it.
    halved: Option<usize>,
}

impl<'a> Strut<'a> {
    fn all(solid: &'a Solid) -> impl Iterator<Item = Strut<'a>> {
        let mut round = vec![false; 2 * solid.struts.len()];
        solid.round_ends().for_each(|circle| round[circle] = true);
        solid.struts.iter().enumerate().map(move |(k, &strut)| Strut {
            strut,
            solid,
            ends: solid.ends[k].map(|n| solid.nodes[n as usize]),
            rims: [*solid.rim(k, 0), *solid.rim(k, 1)],
            round: [round[2 * k], round[2 * k + 1]],
            halved: (0..2).find(|&e| solid.ends[k][e] as usize >= solid.own),
        })
    }

    /// Takes over the end of the other half.
    fn join(&mut self, other: &Strut) {
        if let Some(end) = self.halved.take() {
            (self.rims[end], self.round[end]) = (other.rims[end], other.round[end]);
        }
    }

    /// A box around the balls on both rims.
    fn bounds(&self) -> Aabb {
        let [[a, ra], [b, rb]] = [0, 1].map(|e| [self.rims[e].center, DVec3::splat(self.rims[e].radius)]);
        aabb([(a - ra).min(b - rb), (a + ra).max(b + rb)])
    }

    /// The convex parts.
    fn parts(&self, frame: &Frame) -> Vec<Body> {
        let (centers, radii) = (self.rims.map(|c| frame.of(c.center)), self.rims.map(|c| c.radius / frame.unit));
        let axis = self.rims[0].axis;
        let caps = [(0, -axis), (1, axis)].into_iter().filter(|&(end, _)| self.round[end]);
        let half_ball = |(end, out)| Body::HalfBall { center: centers[end], out, radius: radii[end] };
        std::iter::once(Body::Frustum { centers, axis, radii }).chain(caps.map(half_ball)).collect()
    }

    /// Distance of a point from the surface, below zero inside (mm). Inside, the flat ends do not count: the solid goes on there.
    fn clearance(&self, p: DVec3) -> f64 {
        let [a, b] = &self.rims;
        let length = (b.center - a.center).dot(a.axis);
        let height = (p - a.center).dot(a.axis);
        let aside = (p - a.center - height * a.axis).length();
        if (0.0..=length).contains(&height) {
            let slope = (b.radius - a.radius) / length;
            return (aside - a.radius - slope * height) / slope.hypot(1.0);
        }
        let (end, beyond) = if height < 0.0 { (0, -height) } else { (1, height - length) };
        let radius = self.rims[end].radius;
        if self.round[end] { beyond.hypot(aside) - radius } else { beyond.hypot((aside - radius).max(0.0)) }
    }
}

/// The least clearance so far, and where.
struct Deepest(Option<(f64, DVec3)>);

impl Deepest {
    fn consider(&mut self, clearance: f64, at: DVec3) {
        if self.0.is_none_or(|(least, _)| clearance < least) {
            self.0 = Some((clearance, at));
        }
    }

    fn crossing(self, node: NodeId, other: Other) -> Option<Crossing> {
        self.0.map(|(clearance, at)| Crossing { node, other, at, clearance })
    }
}

fn meets_strut(skin: &Skin, nets: &[Net], frame: &Frame, strut: &Strut) -> Option<Crossing> {
    let parts = strut.parts(frame);
    let mut deepest = Deepest(None);
    let mut patches = None;
    for (patch, net) in nets.iter().enumerate() {
        if let Some(at) = parts.iter().filter(|part| boxes_meet(net, *part)).find_map(|part| contact(net, part)) {
            let at = frame.back(at);
            deepest.consider(strut.clearance(at), at);
            let patches = patches.get_or_insert_with(|| skin.patches());
            let lowest = lowest(&patches[patch], skin.center, |p| strut.clearance(p));
            deepest.consider(strut.clearance(lowest), lowest);
        }
    }
    if deepest.0.is_none() && !std::ptr::eq(skin.solid, strut.solid) {
        let at = strut.rims[0].center;
        let point = Body::Point(frame.of(at));
        if nets.iter().map(Net::with_node).any(|cone| boxes_meet(&cone, &point) && contact(&cone, &point).is_some()) {
            let distance = |jet: Jet1| jet.p.distance(at - skin.center);
            let depth = skin.patches().iter().flat_map(samples).map(distance).fold(f64::INFINITY, f64::min);
            deepest.consider(-depth, at);
        }
    }
    deepest.crossing(skin.node, Other::Strut(strut.strut))
}

fn meets_skin(skin: &Skin, nets: &[Net], frame: &Frame, other: &Skin) -> Option<Crossing> {
    let others = other.nets(frame);
    let mut contacts = vec![];
    for (patch, net) in nets.iter().enumerate() {
        for (other_patch, other_net) in others.iter().enumerate().filter(|(_, o)| boxes_meet(net, *o)) {
            if let Some(at) = contact(net, other_net) {
                contacts.push((patch, other_patch, frame.back(at)));
            }
        }
    }
    let (_, _, first) = *contacts.first()?;
    let mut deepest = Deepest(None);
    deepest.consider(0.0, first);
    // how far the samples of this skin are behind the tangent planes of the other's nearest samples
    let distinct = |mut patches: Vec<usize>| {
        patches.sort_unstable();
        patches.dedup();
        patches
    };
    let sampled = |skin: &Skin, of: Vec<usize>| -> Vec<Jet1> {
        let patches = skin.patches();
        distinct(of).into_iter().flat_map(|p| samples(&patches[p])).collect()
    };
    let of_other = sampled(other, contacts.iter().map(|c| c.1).collect());
    for p in sampled(skin, contacts.iter().map(|c| c.0).collect()).into_iter().map(|jet| skin.center + jet.p) {
        let off = |jet: &Jet1| p - other.center - jet.p;
        let nearest = of_other.iter().min_by(|a, b| off(a).length_squared().total_cmp(&off(b).length_squared()));
        if let Some(jet) = nearest {
            deepest.consider(off(jet).dot(jet.du.cross(jet.dv).normalize()), p);
        }
    }
    deepest.crossing(skin.node, Other::Node(other.node))
}

/// Coordinates about a node, divided by its reach.
struct Frame {
    origin: DVec3,
    unit: f64,
}

impl Frame {
    fn of(&self, p: DVec3) -> DVec3 {
        (p - self.origin) / self.unit
    }

    fn back(&self, p: DVec3) -> DVec3 {
        self.origin + self.unit * p
    }
}

/// A convex body, and how it is halved.
trait Convex: Sized {
    /// A point of the body that is farthest in a direction.
    fn support(&self, dir: DVec3) -> DVec3;
    /// Some point near the middle.
    fn middle(&self) -> DVec3;
    /// How large what can be halved is.
    fn size(&self) -> f64;
    fn halves(&self) -> [Self; 2];

    fn bounds(&self) -> [DVec3; 2] {
        let farthest = |sign: f64| DVec3::AXES.map(|e| sign * self.support(sign * e).dot(sign * e));
        [-1.0, 1.0].map(|sign| DVec3::from(farthest(sign)))
    }
}

/// A Bézier patch or a part of one: its control points, and the hull of what it stands for.
struct Net {
    /// Of the patch; `None` if it is not one Bézier patch: then it is never halved, and what meets its hull counts as met.
    degree: Option<[usize; 2]>,
    /// (weight · point, weight), `[iu * (degree of v + 1) + iv]`.
    weighted: Vec<DVec4>,
    /// The control points, and behind them the node for the cone over the patch.
    hull: Vec<DVec3>,
}

impl Net {
    fn of(part: &Part, spline: &SplineSurface, offset: DVec3, frame: &Frame) -> Net {
        let is_bezier = (0..2).all(|k| spline.knots[k].len() == 2 * (spline.degree[k] + 1));
        let points = spline.points.iter().map(|&i| frame.of(part.points[i as usize] + offset));
        let weighted = points.zip(&spline.weights[..]).map(|(p, &w)| (w * p).extend(w)).collect();
        Net::new(is_bezier.then_some(spline.degree), weighted)
    }

    fn new(degree: Option<[usize; 2]>, weighted: Vec<DVec4>) -> Net {
        let hull = weighted.iter().map(|h| h.truncate() / h.w).collect();
        Net { degree, weighted, hull }
    }

    /// The cone over the patch from its node, the origin.
    fn with_node(&self) -> Net {
        let hull = self.points().iter().copied().chain([DVec3::ZERO]).collect();
        Net { degree: self.degree, weighted: self.weighted.clone(), hull }
    }

    fn points(&self) -> &[DVec3] {
        &self.hull[..self.weighted.len()]
    }
}

impl Convex for Net {
    fn support(&self, dir: DVec3) -> DVec3 {
        let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
        for &p in &self.hull {
            let reach = p.dot(dir);
            if reach > best.0 {
                best = (reach, p);
            }
        }
        best.1
    }

    fn middle(&self) -> DVec3 {
        self.points()[0].midpoint(self.points()[self.weighted.len() - 1])
    }

    fn size(&self) -> f64 {
        let [low, high] = self.points().iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], &p| [low.min(p), high.max(p)]);
        if self.degree.is_some() { low.distance(high) } else { 0.0 }
    }

    /// By de Casteljau, across the direction in which the net is longer.
    fn halves(&self) -> [Net; 2] {
        let [p, q] = self.degree.expect("a size above zero");
        let [nu, nv] = [p + 1, q + 1];
        // (points of a line, steps to the next of them, lines, steps to the next line)
        let layouts = [(nu, nv, nv, 1), (nv, 1, nu, nv)];
        let length = |(count, step, lines, across): (usize, usize, usize, usize)| {
            let line = |l: usize| (1..count).map(move |k| self.hull[l * across + k * step].distance(self.hull[l * across + (k - 1) * step]));
            (0..lines).flat_map(line).sum::<f64>() / lines as f64
        };
        let (count, step, lines, across) = if length(layouts[0]) >= length(layouts[1]) { layouts[0] } else { layouts[1] };
        let (mut first, mut second) = (self.weighted.clone(), self.weighted.clone());
        for line in 0..lines {
            let at = |k: usize| line * across + k * step;
            for k in 1..count {
                for i in 0..count - k {
                    second[at(i)] = 0.5 * (second[at(i)] + second[at(i + 1)]);
                }
                first[at(k)] = second[at(0)];
            }
        }
        let has_node = self.hull.len() > self.weighted.len();
        [first, second].map(|weighted| {
            let half = Net::new(self.degree, weighted);
            if has_node { half.with_node() } else { half }
        })
    }
}

/// What a patch is held against, besides other patches.
enum Body {
    /// The hull of two discs square to `axis`.
    Frustum {
        centers: [DVec3; 2],
        axis: DVec3,
        radii: [f64; 2],
    },
    /// The half on the side of `out`.
    HalfBall {
        center: DVec3,
        out: DVec3,
        radius: f64,
    },
    Point(DVec3),
}

impl Convex for Body {
    fn support(&self, dir: DVec3) -> DVec3 {
        let rim = |center: DVec3, axis: DVec3, radius: f64| center + radius * dir.reject_from_normalized(axis).normalize_or_zero();
        match *self {
            Body::Frustum { centers: [a, b], axis, radii: [ra, rb] } => {
                let (a, b) = (rim(a, axis, ra), rim(b, axis, rb));
                if a.dot(dir) >= b.dot(dir) { a } else { b }
            }
            Body::HalfBall { center, out, radius } if dir.dot(out) > 0.0 => center + radius * dir.normalize_or_zero(),
            Body::HalfBall { center, out, radius } => rim(center, out, radius),
            Body::Point(p) => p,
        }
    }

    fn middle(&self) -> DVec3 {
        match *self {
            Body::Frustum { centers: [a, b], .. } => a.midpoint(b),
            Body::HalfBall { center, .. } => center,
            Body::Point(p) => p,
        }
    }

    fn size(&self) -> f64 {
        0.0
    }

    fn halves(&self) -> [Body; 2] {
        unreachable!("a body of no size is not halved")
    }
}

/// A place where two bodies meet, as far as parts of `SMALLEST` can tell.
fn contact<A: Convex, B: Convex>(a: &A, b: &B) -> Option<DVec3> {
    if apart(a, b) {
        return None;
    }
    let (size_a, size_b) = (a.size(), b.size());
    if size_a.max(size_b) <= SMALLEST {
        return Some(a.middle());
    }
    if size_a >= size_b { a.halves().iter().find_map(|half| contact(half, b)) } else { b.halves().iter().find_map(|half| contact(a, half)) }
}

/// Whether a plane with `TOUCHING` of room to both is found between two bodies.
fn apart<A: Convex, B: Convex>(a: &A, b: &B) -> bool {
    let parts = |n: DVec3| b.support(-n).dot(n) - a.support(n).dot(n) > TOUCHING;
    let toward = (b.middle() - a.middle()).normalize_or(DVec3::X);
    if parts(toward) {
        return true;
    }
    let (map_a, map_b) = (Supports(a), Supports(b));
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(&Pose::IDENTITY, &map_a, &map_b, vector(toward)));
    match closest_points(&Pose::IDENTITY, &map_a, &map_b, TOUCHING, false, &mut simplex) {
        GJKResult::NoIntersection(n) | GJKResult::Proximity(n) | GJKResult::ClosestPoints(_, _, n) => parts(DVec3::from(n.to_array())),
        GJKResult::Intersection => false,
    }
}

/// A body as parry wants it.
struct Supports<'a, C>(&'a C);

impl<C: Convex> SupportMap for Supports<'_, C> {
    fn local_support_point(&self, dir: Vector) -> Vector {
        vector(self.0.support(DVec3::from(dir.to_array())))
    }
}

fn boxes_meet(a: &impl Convex, b: &impl Convex) -> bool {
    let ([low, high], [low_b, high_b]) = (a.bounds(), b.bounds());
    low.cmple(high_b + TOUCHING).all() && low_b.cmple(high + TOUCHING).all()
}

fn vector(p: DVec3) -> Vector {
    Vector::from_array(p.to_array())
}

fn aabb([low, high]: [DVec3; 2]) -> Aabb {
    Aabb::new(vector(low), vector(high))
}
