//! The nouns of this layer: `Model`, `Solid`, and the few kinds of curve and surface that a
//! lattice needs. The topology is truck's `CompressedSolid`: plain indexed arrays.

use super::rim_map::RimMap;
use crate::ids::{NodeId, StrutId};
use crate::math::nurbs::{NurbsCurve, NurbsSurface};
use glam::DVec3;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use truck_geometry::prelude::Point3;
use truck_topology::compress::{CompressedFace, CompressedShell, CompressedSolid};

/// All solids of a lattice, in the order of their smallest node.
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub solids: Vec<Solid>,
}

/// One closed solid: the skin over one connected component of the graph.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Nodes of the component that carry struts, ascending.
    pub nodes: Vec<NodeId>,
    /// Positions of `nodes`, mm.
    pub centers: Vec<DVec3>,
    /// Struts of the component, ascending.
    pub struts: Vec<StrutId>,
    /// Positions in `nodes` of the two ends of each of `struts`.
    pub ends: Vec<[usize; 2]>,
    /// All points in mm. Vertex `v` of the shell is `points[v]`; control points follow. Whoever
    /// shares a point shares its index, so shared points are equal bit for bit.
    pub points: Vec<DVec3>,
    /// Unit vectors from the axis of each of `struts` to its seam.
    pub seams: Vec<DVec3>,
    /// Growth of the radius of each of `struts` per length from a to b: 0 for a cylinder, else the tangent of the cone's
    /// half-angle, negative where the strut gets thinner.
    pub slopes: Vec<f64>,
    /// Rims first: the circles of `struts[k]` are `2 k` (end a) and `2 k + 1` (end b).
    /// Behind them the meridians of spherical caps.
    pub circles: Vec<Circle>,
    /// One shell. Every face's `orientation` is `true`; its one loop runs counter-clockwise seen
    /// from outside.
    pub brep: CompressedSolid<Point3, Curve, Surface>,
    /// Where each face of the shell comes from, same order.
    pub labels: Vec<Label>,
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
    /// Indices into `Solid::points`; the first and the last are the edge's vertices.
    pub points: Vec<u32>,
    pub weights: Vec<f64>,
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
    /// Indices into `Solid::points`, `points[iu * nv + iv]`.
    pub points: Vec<u32>,
    pub weights: Vec<f64>,
    /// How many edges of the loop lie on each side, in the loop's order: v = 0 (the rim), u = 1,
    /// v = 1, u = 0.
    pub sides: [u8; 4],
    /// How the first side's edges, in the loop's order, run on the surface.
    pub rim: Vec<RimMap>,
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
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Label::Strut(strut) => write!(f, "strut_{}", strut.0),
            Label::Patch { node, strut, number } => write!(f, "node_{}/strut_{}/{number}", node.0, strut.0),
            Label::Cap(node) => write!(f, "node_{}/cap", node.0),
        }
    }
}

impl Label {
    /// The node whose skin or cap the face belongs to.
    pub fn node(self) -> Option<NodeId> {
        match self {
            Label::Strut(_) => None,
            Label::Patch { node, .. } | Label::Cap(node) => Some(node),
        }
    }

    /// The strut whose own face or cell the face belongs to.
    pub fn strut(self) -> Option<StrutId> {
        match self {
            Label::Strut(strut) | Label::Patch { strut, .. } => Some(strut),
            Label::Cap(_) => None,
        }
    }
}

/// truck's point from ours.
pub(super) fn to_truck(p: DVec3) -> Point3 {
    Point3::from(p.to_array())
}

impl Solid {
    /// The only shell.
    pub fn shell(&self) -> &CompressedShell<Point3, Curve, Surface> {
        &self.brep.boundaries[0]
    }

    /// The faces of the only shell.
    pub fn faces(&self) -> &[CompressedFace<Surface>] {
        &self.shell().faces
    }

    /// The faces of each node's skin and cap, as ranges over `labels` and `faces()`, in the order of
    /// `nodes`. The faces before the first range are the struts', in the order of `struts`.
    pub fn node_faces(&self) -> Vec<Range<usize>> {
        let mut first = self.struts.len();
        let of = |n: NodeId| move |label: &&Label| label.node() == Some(n);
        let ranges = self.nodes.iter().map(|&node| {
            let count = self.labels[first..].iter().take_while(of(node)).count();
            first += count;
            first - count..first
        });
        ranges.collect()
    }

    /// No coordinate, radius, knot or weight is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        let all = |values: &[f64]| values.iter().all(|x| x.is_finite());
        let curve = |c: &Curve| match c {
            Curve::Spline(s) => all(&s.knots) && all(&s.weights),
            _ => true,
        };
        let surface = |s: &Surface| match s {
            Surface::Spline(s) => s.knots.iter().all(|k| all(k)) && all(&s.weights),
            _ => true,
        };
        self.points.iter().all(|p| p.is_finite())
            && self.circles.iter().all(Circle::is_finite)
            && self.slopes.iter().all(|s| s.is_finite())
            && self.shell().edges.iter().all(|e| curve(&e.curve))
            && self.faces().iter().all(|f| surface(&f.surface))
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
