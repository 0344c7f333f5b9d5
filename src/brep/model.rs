//! The nouns of this layer: `Model`, `Solid`, and the few kinds of curve and surface that a lattice needs.
//!
//! A `Solid` holds tables: where the vertices, edges, faces and points of each node begin, the struts' circles, and the skins, each
//! distinct one once. What a node is made of, its `Part`, is put together whenever it is asked for and dropped again.

use super::rim_map::RimMap;
use crate::graph::End;
use crate::ids::{NodeId, StrutId};
use crate::math::nurbs::{NurbsCurve, NurbsSurface};
use crate::patch::Shelved;
use glam::DVec3;
use std::fmt;
use std::sync::Arc;

/// All solids of a lattice, in the order of their smallest node; of blocks, block by block.
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub solids: Vec<Solid>,
}

/// One closed solid: the skin over one connected component of the graph. Its numbers:
///
/// - vertices: those of the skins, node by node, then those of the seams (`extra`), strut by strut, then the poles of round caps;
/// - edges: those of the skins, node by node, then each strut's closed rims and seam, then the meridians of round caps;
/// - faces: the struts', then those of the skins and the caps, node by node;
/// - points: the vertices, then the inner control points of the edges, node by node, then those of the patches, node by node.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Its own nodes, all with struts, ascending; behind them the nodes that halved struts would lead to. There a disc ends the strut.
    pub nodes: Vec<NodeId>,
    /// How many of `nodes` are its own.
    pub own: usize,
    /// Positions of `nodes`, mm; of discs the middle.
    pub centers: Vec<DVec3>,
    /// Struts of the component, ascending.
    pub struts: Vec<StrutId>,
    /// Positions in `nodes` of the two ends of each of `struts`.
    pub ends: Vec<[u32; 2]>,
    /// Unit vectors from the axis of each of `struts` to its seam.
    pub seams: Vec<DVec3>,
    /// Growth of the radius of each of `struts` per length from a to b: 0 for a cylinder, else the tangent of the cone's
    /// half-angle, negative where the strut gets thinner.
    pub slopes: Vec<f64>,
    /// Rims first: the circles of `struts[k]` are `2 k` (end a) and `2 k + 1` (end b).
    /// Behind them the meridians of spherical caps.
    pub circles: Vec<Circle>,
    /// Vertices that no skin has, mm.
    pub extra: Vec<DVec3>,
    /// Where the parts of each of `nodes` begin, and where those of the last one end.
    pub(super) first: Vec<First>,
    /// The unit of length of each of `nodes`, mm, and its skin.
    pub(super) skins: Vec<(f64, Shelved)>,
    /// How each of `struts` meets its rims.
    pub(super) strut_ends: Vec<[StrutEnd; 2]>,
    /// The first edge of each of `struts`, and of the meridians of round caps; then the number of edges.
    pub(super) strut_edges: Vec<u32>,
    /// The struts (positions in `struts`) and ends at each of `nodes`, one after the other.
    pub(super) arms: Vec<(u32, End)>,
    /// Where those of each node begin, and the end.
    pub(super) first_arm: Vec<u32>,
    /// Nodes (positions in `nodes`) with a round cap.
    pub(super) poles: Vec<u32>,
    /// What was found out about each of `nodes` when the solid was put together.
    pub(super) found: Vec<Found>,
}

/// The first vertex, edge, ... of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct First {
    pub vertex: u32,
    pub edge: u32,
    pub face: u32,
    pub edge_point: u32,
    pub face_point: u32,
}

/// How a strut meets a rim.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StrutEnd {
    /// The vertex where the seam ends, and its place (mm).
    pub vertex: u32,
    pub point: DVec3,
    /// The arc (position in `Rim::arcs`) that the seam splits.
    pub split: Option<u32>,
    /// The rim has no arcs: one closed edge goes around it.
    pub closed: bool,
}

/// Of one node.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// The rim of each arm, counter-clockwise about the outward axis, from the seam's vertex on; empty if it is one closed edge.
    pub loops: Box<[Box<[EdgeUse]>]>,
    /// How each rim arc runs on its patch, in the order of faces and their loops. Shared by nodes that differ in nothing but their places.
    pub rims: Arc<[RimMap]>,
    /// Whether all its numbers are.
    pub is_finite: bool,
}

/// What one node is made of: its skin in mm, or its cap. Vertices, edges and faces bear the numbers of the solid.
#[derive(Clone, Debug)]
pub struct Part {
    /// Position of the node, mm.
    pub center: DVec3,
    /// mm. The vertices first, then the inner control points of the edges, then those of the patches.
    pub points: Vec<DVec3>,
    /// The edges of the skin, in order of their numbers.
    pub edges: Vec<Edge>,
    /// The faces, in order of their numbers.
    pub faces: Vec<Face>,
    pub(super) first: First,
    /// How many of `points` are vertices, and how many control points of edges.
    pub(super) vertex_count: usize,
    pub(super) edge_point_count: usize,
}

/// An edge from its first vertex to its second.
#[derive(Clone, Debug)]
pub struct Edge {
    pub vertices: [u32; 2],
    pub curve: Curve,
}

/// A face. Its one loop runs counter-clockwise seen from outside.
#[derive(Clone, Debug)]
pub struct Face {
    pub boundary: Vec<EdgeUse>,
    pub surface: Surface,
    pub label: Label,
}

/// An edge on a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeUse {
    /// The edge's number.
    pub edge: u32,
    /// From its first vertex to its second.
    pub forward: bool,
}

/// A circle with its frame. `x` and `axis` are unit vectors at right angles.
/// For a rim, `axis` is the strut's direction from a to b at both ends, and `x` lies in the middle
/// of an arc, where no vertex is: readers then agree on the azimuth of every vertex. Rims without
/// arcs have their only vertex at `x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    pub center: DVec3,
    pub axis: DVec3,
    pub x: DVec3,
    /// mm
    pub radius: f64,
}

/// Geometry of an edge.
#[derive(Clone, Debug)]
pub enum Curve {
    /// The straight line between the edge's vertices (a strut's seam).
    Line,
    /// Along `circles[.0]`, counter-clockwise about its axis from the first to the second vertex.
    Arc(usize),
    Spline(SplineCurve),
}

/// A clamped B-spline over shared points; see [`NurbsCurve`].
#[derive(Clone, Debug)]
pub struct SplineCurve {
    pub degree: usize,
    pub knots: Arc<[f64]>,
    /// Indices into `Part::points`; the first and the last are the edge's vertices.
    pub points: Vec<u32>,
    pub weights: Arc<[f64]>,
}

/// Geometry of a face.
#[derive(Clone, Debug)]
pub enum Surface {
    /// The cylinder or cone (see `Solid::slopes`) of `struts[.0]`: through its rims, x to its seam; normal outward.
    Strut(usize),
    /// Through `circles[circle]`; the normal is its axis, or the opposite if `flipped`.
    Plane {
        circle: usize,
        flipped: bool,
    },
    /// Half a sphere on `circles[circle]`; pole along its axis, or the opposite if `flipped`.
    Sphere {
        circle: usize,
        flipped: bool,
    },
    Spline(SplineSurface),
}

/// A clamped B-spline surface over shared points; see [`NurbsSurface`]. `du × dv` is outward.
#[derive(Clone, Debug)]
pub struct SplineSurface {
    pub degree: [usize; 2],
    pub knots: [Arc<[f64]>; 2],
    /// Indices into `Part::points`, `points[iu * nv + iv]`.
    pub points: Vec<u32>,
    pub weights: Arc<[f64]>,
    /// How many edges of the loop lie on each side, in the loop's order: v = 0 (the rim), u = 1,
    /// v = 1, u = 0.
    pub sides: [u8; 4],
    /// The first of the node's `rim_maps` for this patch: those of the arcs on its first side, in the loop's order.
    pub first_map: u32,
}

/// Where a face comes from. Its text is the face's name in the STEP file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Label {
    /// The cylinder or cone of a strut.
    Strut(StrutId),
    /// Patch number `number` (from 1) of this strut's cell at this node.
    Patch { node: NodeId, strut: StrutId, number: u32 },
    /// The end cap of a strut at a degree-1 node.
    Cap(NodeId),
    /// The disc that ends a halved strut.
    Disc(StrutId),
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Label::Strut(strut) => write!(f, "strut_{}", strut.0),
            Label::Patch { node, strut, number } => write!(f, "node_{}/strut_{}/{number}", node.0, strut.0),
            Label::Cap(node) => write!(f, "node_{}/cap", node.0),
            Label::Disc(strut) => write!(f, "strut_{}/disc", strut.0),
        }
    }
}

impl Label {
    /// The node whose skin or cap the face belongs to.
    pub fn node(self) -> Option<NodeId> {
        match self {
            Label::Strut(_) | Label::Disc(_) => None,
            Label::Patch { node, .. } | Label::Cap(node) => Some(node),
        }
    }

    /// The strut whose own face or cell the face belongs to.
    pub fn strut(self) -> Option<StrutId> {
        match self {
            Label::Strut(strut) | Label::Patch { strut, .. } => Some(strut),
            Label::Cap(_) | Label::Disc(_) => None,
        }
    }
}

impl Solid {
    /// No coordinate, radius, knot or weight is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        self.extra.iter().all(|p| p.is_finite())
            && self.circles.iter().all(Circle::is_finite)
            && self.slopes.iter().all(|s| s.is_finite())
            && self.found.iter().all(|found| found.is_finite)
    }

    /// How many of its struts end in a disc halfway.
    pub fn halved(&self) -> usize {
        self.nodes.len() - self.own
    }

    /// Independent rings of struts.
    pub fn genus(&self) -> i64 {
        self.struts.len() as i64 - self.nodes.len() as i64 + 1
    }

    /// The rim circle of `struts[k]` at end a (0) or b (1).
    pub fn rim(&self, k: usize, end: usize) -> &Circle {
        &self.circles[2 * k + end]
    }

    /// Outward normal of the face of `struts[k]` at a place given from a point of the strut's axis (mm).
    pub fn strut_normal(&self, k: usize, place: DVec3) -> DVec3 {
        let axis = self.rim(k, 0).axis;
        let out = place.reject_from_normalized(axis);
        (out - self.slopes[k] * out.length() * axis).normalize()
    }
}

impl Part {
    pub(super) fn is_finite(&self) -> bool {
        let all = |values: &[f64]| values.iter().all(|x| x.is_finite());
        let curve = |c: &Curve| match c {
            Curve::Spline(s) => all(&s.knots) && all(&s.weights),
            _ => true,
        };
        let surface = |s: &Surface| match s {
            Surface::Spline(s) => s.knots.iter().all(|k| all(k)) && all(&s.weights),
            _ => true,
        };
        self.points.iter().all(|p| p.is_finite()) && self.edges.iter().all(|e| curve(&e.curve)) && self.faces.iter().all(|f| surface(&f.surface))
    }

    /// The spline with its control points, relative to `origin` (mm).
    pub fn spline_surface(&self, s: &SplineSurface, origin: DVec3) -> NurbsSurface {
        NurbsSurface {
            degree: s.degree,
            knots: s.knots.clone(),
            points: s.points.iter().map(|&i| self.points[i as usize] - origin).collect(),
            weights: s.weights.clone(),
        }
    }

    /// The spline with its control points, relative to `origin` (mm).
    pub fn spline_curve(&self, c: &SplineCurve, origin: DVec3) -> NurbsCurve {
        NurbsCurve {
            degree: c.degree,
            knots: c.knots.clone(),
            points: c.points.iter().map(|&i| self.points[i as usize] - origin).collect(),
            weights: c.weights.clone(),
        }
    }
}

impl Circle {
    fn is_finite(&self) -> bool {
        self.center.is_finite() && self.axis.is_finite() && self.x.is_finite() && self.radius.is_finite()
    }

    /// Direction from the centre at this azimuth (radians, counter-clockwise about `axis` from `x`).
    pub fn radial(&self, azimuth: f64) -> DVec3 {
        self.x * azimuth.cos() + self.axis.cross(self.x) * azimuth.sin()
    }

    /// Azimuth of a point given relative to the centre, in (-π, π].
    pub fn azimuth(&self, q: DVec3) -> f64 {
        q.dot(self.axis.cross(self.x)).atan2(q.dot(self.x))
    }

    /// Distance of a point from the circle (mm).
    pub fn distance(&self, p: DVec3) -> f64 {
        let q = p - self.center;
        let height = q.dot(self.axis);
        let out = (q - height * self.axis).length() - self.radius;
        height.hypot(out)
    }
}
