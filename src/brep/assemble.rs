//! `Graph` + `Skin`s ▶ `Model`: takes over the skins' topology, adds one cylinder or cone per strut
//! with an explicit seam, and caps.
//!
//! Each point is computed once, as `node + radius · p`, and shared by index from then on, so the
//! border rows of patches and the edges between them stay equal bit for bit.

use super::error::BrepError;
use super::model::{Circle, Curve, Label, Model, Solid, SplineCurve, SplineSurface, Surface, to_truck};
use super::rim_map::map_rims;
use super::seam::{self, Seam};
use crate::graph::components::{Members, components};
use crate::graph::{Arm, End, Graph};
use crate::ids::{NodeId, StrutId};
use crate::patch::{Patch, Skin, SkinCurve};
use glam::DVec3;
use std::f64::consts::TAU;
use truck_topology::compress::{CompressedEdge, CompressedEdgeIndex, CompressedFace, CompressedShell, CompressedSolid};

/// How a strut ends at a degree-1 node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Caps {
    /// A flat disc through the node.
    #[default]
    Flat,
    /// A hemisphere about the node with the strut's end radius: inside the ball that the overlap check knows. Tangent to a
    /// cylinder; a cone meets it at its half-angle.
    Sphere,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct AssembleOptions {
    pub caps: Caps,
}

/// A rim's axis may leave its strut by this much (radians); round-off stays below 1e-14.
const AXIS_TOLERANCE: f64 = 1e-9;
/// A rim's radius may differ from its strut's by this part of the strut's larger radius; round-off stays below 1e-15.
const RADIUS_TOLERANCE: f64 = 1e-12;

/// Build one solid per connected component.
///
/// `skins` is indexed by `NodeId`; nodes without struts have none. Returns the first fault of each
/// component that has one, in order.
pub fn assemble(graph: &Graph, skins: &[Option<&Skin>], options: &AssembleOptions) -> Result<Model, Vec<BrepError>> {
    let mut solids = vec![];
    let mut faults = vec![];
    for component in components(graph).members() {
        match Builder::new(graph, skins, options.caps).solid(component) {
            Ok(solid) => solids.push(solid),
            Err(fault) => faults.push(fault),
        }
    }
    if faults.is_empty() { Ok(Model { solids }) } else { Err(faults) }
}

/// The solid's edges that a skin edge became: two where the seam splits a rim arc.
#[derive(Clone, Copy, Default)]
struct Pieces {
    first: usize,
    two: bool,
    /// The edges run against the skin edge.
    reversed: bool,
}

impl Pieces {
    /// The edges along the skin edge, or against it.
    fn walk(self, forward: bool) -> impl Iterator<Item = CompressedEdgeIndex> {
        let (a, b) = (self.first, self.first + self.two as usize);
        // Stored order follows the skin edge; `reversed` only turns each piece.
        let order = if forward { [a, b] } else { [b, a] };
        let orientation = forward != self.reversed;
        order.into_iter().take(1 + self.two as usize).map(move |index| CompressedEdgeIndex { index, orientation })
    }
}

/// One strut end while the solid is built.
#[derive(Clone, Copy, Default)]
struct StrutEnd {
    /// The vertex where the seam ends.
    seam_vertex: usize,
    /// The arc (position in `Rim::arcs`) that the seam splits.
    split: Option<usize>,
}

struct Builder<'a> {
    graph: &'a Graph,
    skins: &'a [Option<&'a Skin>],
    caps: Caps,
    points: Vec<DVec3>,
    vertex_count: usize,
    seams: Vec<DVec3>,
    slopes: Vec<f64>,
    circles: Vec<Circle>,
    /// The closed edge on a rim without vertices, indexed by circle.
    closed: Vec<Option<usize>>,
    edges: Vec<CompressedEdge<Curve>>,
    faces: Vec<CompressedFace<Surface>>,
    labels: Vec<Label>,
}

impl<'a> Builder<'a> {
    fn new(graph: &'a Graph, skins: &'a [Option<&'a Skin>], caps: Caps) -> Self {
        Builder {
            graph,
            skins,
            caps,
            points: vec![],
            vertex_count: 0,
            seams: vec![],
            slopes: vec![],
            circles: vec![],
            closed: vec![],
            edges: vec![],
            faces: vec![],
            labels: vec![],
        }
    }

    fn solid(mut self, component: Members) -> Result<Solid, BrepError> {
        let Members { nodes, struts } = component;
        // Vertices: those of the skins, node by node, then those of the seams and caps.
        let mut first_vertex = vec![];
        for &node in &nodes {
            let skin = self.skin(node)?;
            let found = skin.rims.len();
            let wanted = self.graph.degree(node);
            if found != wanted {
                return Err(BrepError::RimCount { node, found, wanted });
            }
            first_vertex.push(self.points.len());
            let (at, r) = self.frame(node);
            self.points.extend(skin.vertices.iter().map(|&p| at + r * p));
        }
        let of_node = |node: NodeId| nodes.binary_search(&node).expect("the node belongs to the component");
        let mut ends = vec![];
        for &strut in &struts {
            ends.push(self.strut_ends(strut, |node| first_vertex[of_node(node)])?);
        }
        let mut poles = vec![];
        if self.caps == Caps::Sphere {
            for &node in nodes.iter().filter(|&&n| self.graph.degree(n) == 1) {
                poles.push((node, self.points.len()));
                let (at, r) = self.frame(node);
                let arm = self.graph.arms(node)[0];
                self.points.push(at - r * self.outward(arm));
            }
        }
        self.vertex_count = self.points.len();

        self.closed = vec![None; self.circles.len()];

        // Edges: those of the skins, node by node, then each strut's seam and closed rims.
        let mut pieces = vec![];
        for (&node, &first) in nodes.iter().zip(&first_vertex) {
            pieces.push(self.skin_edges(node, first, |strut| {
                let k = struts.binary_search(&strut).expect("the strut belongs to the component");
                (k, ends[k])
            })?);
        }
        for (k, &strut) in struts.iter().enumerate() {
            let rims = [End::A, End::B].map(|end| {
                let arm = Arm { strut, end };
                let node = self.graph.near(arm);
                self.rim_loop(arm, 2 * k + end as usize, ends[k][end as usize].seam_vertex, &pieces[of_node(node)])
            });
            self.strut_face(strut, k, ends[k], rims);
        }

        // Faces of the nodes, with the control points that are not on an edge.
        for (n, &node) in nodes.iter().enumerate() {
            let skin = self.skin(node)?;
            let mut numbers = vec![0; skin.rims.len()];
            for patch in &skin.patches {
                numbers[patch.arm] += 1;
                let strut = self.graph.arms(node)[patch.arm].strut;
                let label = Label::Patch { node, strut, number: numbers[patch.arm] };
                self.patch_face(node, patch, &pieces[n], label);
            }
            if self.graph.degree(node) == 1 {
                let arm = self.graph.arms(node)[0];
                let k = struts.binary_search(&arm.strut).expect("the strut belongs to the component");
                if skin.rims[0].arcs.is_empty() {
                    let pole = poles.binary_search_by_key(&node, |p| p.0).ok().map(|i| poles[i].1);
                    self.cap_face(node, 2 * k + arm.end as usize, arm.end, ends[k][arm.end as usize].seam_vertex, pole);
                }
            }
        }
        let shell = CompressedShell { vertices: self.points[..self.vertex_count].iter().map(|&p| to_truck(p)).collect(), edges: self.edges, faces: self.faces };
        let brep = CompressedSolid { boundaries: vec![shell] };
        let centers = nodes.iter().map(|n| self.graph.nodes()[n.index()]).collect();
        let ends = struts.iter().map(|s| self.graph.struts()[s.index()]).map(|s| [of_node(s.a), of_node(s.b)]).collect();
        let (points, seams, slopes, circles, labels) = (self.points, self.seams, self.slopes, self.circles, self.labels);
        let mut solid = Solid { nodes, centers, struts, ends, points, seams, slopes, circles, brep, labels };
        map_rims(&mut solid);
        Ok(solid)
    }

    fn skin(&self, node: NodeId) -> Result<&'a Skin, BrepError> {
        let skin = self.skins.get(node.index()).copied().flatten();
        skin.ok_or(BrepError::NoSkin { node })
    }

    /// Position (mm) and unit of length (mm) of a node's skin: its largest radius.
    fn frame(&self, node: NodeId) -> (DVec3, f64) {
        (self.graph.nodes()[node.index()], self.graph.largest_radius(node))
    }

    /// Unit vector from the arm's node along the strut.
    fn outward(&self, arm: Arm) -> DVec3 {
        let at = |node: NodeId| self.graph.nodes()[node.index()];
        (at(self.graph.far(arm)) - at(self.graph.near(arm))).normalize()
    }

    /// Rim circles and seam of one strut; pushes the vertices that the seam needs.
    fn strut_ends(&mut self, strut: StrutId, first_vertex: impl Fn(NodeId) -> usize) -> Result<[StrutEnd; 2], BrepError> {
        let axis = self.outward(Arm { strut, end: End::A });
        let side = axis.any_orthonormal_vector();
        let mut centers = [DVec3::ZERO; 2];
        let mut radii = [0.0; 2];
        let mut azimuths: [Vec<f64>; 2] = [vec![], vec![]];
        let mut vertices: [Vec<usize>; 2] = [vec![], vec![]];
        for end in [End::A, End::B] {
            let arm = Arm { strut, end };
            let node = self.graph.near(arm);
            let skin = self.skin(node)?;
            let rim = &skin.rims[self.arm_index(arm)];
            let outward = self.outward(arm);
            let angle = rim.axis.cross(outward).length().atan2(rim.axis.dot(outward));
            if angle > AXIS_TOLERANCE {
                return Err(BrepError::RimAxis { node, strut, angle });
            }
            let (at, r) = self.frame(node);
            let radius = self.graph.radius_at(arm, r * rim.cut);
            if !((r * rim.radius - radius).abs() <= RADIUS_TOLERANCE * self.graph.widest(strut)) {
                return Err(BrepError::RimRadius { node, strut, found: r * rim.radius, wanted: radius });
            }
            radii[end as usize] = radius;
            let center = at + r * rim.cut * outward;
            centers[end as usize] = center;
            for (k, &arc) in rim.arcs.iter().enumerate() {
                let next = rim.arcs[(k + 1) % rim.arcs.len()];
                if skin.edges[arc].ends[1] != skin.edges[next].ends[0] {
                    return Err(BrepError::RimNotClosed { node, strut });
                }
                let vertex = first_vertex(node) + skin.edges[arc].ends[0];
                let p = self.points[vertex] - center;
                vertices[end as usize].push(vertex);
                azimuths[end as usize].push(p.dot(axis.cross(side)).atan2(p.dot(side)));
            }
        }
        let room = (centers[1] - centers[0]).dot(axis);
        if room <= 0.0 {
            return Err(BrepError::NoRoom { strut, room });
        }
        let seam = seam::place(&azimuths[0], &azimuths[1]);
        // The seam runs through an existing vertex if there is one; its azimuth is exact there.
        let x = match seam.at {
            [Some(k), _] => self.points[vertices[0][k]] - centers[0],
            [None, Some(k)] => self.points[vertices[1][k]] - centers[1],
            [None, None] => side * seam.azimuth.cos() + axis.cross(side) * seam.azimuth.sin(),
        };
        let x = x.reject_from_normalized(axis).normalize();
        let mut out = [StrutEnd::default(); 2];
        for end in [End::A, End::B] {
            let e = end as usize;
            out[e].seam_vertex = match seam.at[e] {
                Some(k) => vertices[e][k],
                None => self.points.len(),
            };
            if seam.at[e].is_none() {
                out[e].split = arc_at(&azimuths[e], seam, end);
                self.points.push(centers[e] + radii[e] * x);
            }
            // The frame's own x keeps away from vertices: the middle of the first arc.
            let middle = match vertices[e][..] {
                [] => x,
                [first, ..] => {
                    let second = vertices[e][1 % vertices[e].len()];
                    arc_middle(centers[e], outward_sign(end) * axis, [first, second].map(|v| self.points[v]))
                }
            };
            self.circles.push(Circle { center: centers[e], axis, x: middle, radius: radii[e] });
        }
        self.seams.push(x);
        let s = &self.graph.struts()[strut.index()];
        self.slopes.push((s.rb - s.ra) / self.graph.length(strut));
        Ok(out)
    }

    /// Position of the arm among its node's arms.
    fn arm_index(&self, arm: Arm) -> usize {
        let arms = self.graph.arms(self.graph.near(arm));
        arms.iter().position(|&a| a == arm).expect("an arm is listed at its node")
    }

    /// Adds the edges of a node's skin, rim arcs split where a seam ends. Indexed by skin edge.
    fn skin_edges(&mut self, node: NodeId, first_vertex: usize, strut_end: impl Fn(StrutId) -> (usize, [StrutEnd; 2])) -> Result<Vec<Pieces>, BrepError> {
        let skin = self.skin(node)?;
        let (at, r) = self.frame(node);
        let arms = self.graph.arms(node);
        let mut pieces = vec![];
        for (index, edge) in skin.edges.iter().enumerate() {
            let [from, to] = edge.ends.map(|v| first_vertex + v);
            let first = self.edges.len();
            match &edge.curve {
                SkinCurve::RimArc(rim) => {
                    let arm = arms[*rim];
                    let (k, ends) = strut_end(arm.strut);
                    let end = ends[arm.end as usize];
                    let position = skin.rims[*rim].arcs.iter().position(|&a| a == index);
                    let position = position.ok_or(BrepError::RimNotClosed { node, strut: arm.strut })?;
                    let two = end.split == Some(position);
                    let steps = if two { vec![from, end.seam_vertex, to] } else { vec![from, to] };
                    // Arcs run about the outward axis; the circle's axis points from a to b.
                    let reversed = arm.end == End::B;
                    for step in steps.windows(2) {
                        let vertices = if reversed { (step[1], step[0]) } else { (step[0], step[1]) };
                        self.edges.push(CompressedEdge { vertices, curve: Curve::Arc(2 * k + arm.end as usize) });
                    }
                    pieces.push(Pieces { first, two, reversed });
                }
                SkinCurve::Spline(curve) => {
                    let last = curve.points.len() - 1;
                    let points = curve.points.iter().enumerate().map(|(i, &p)| {
                        let vertex = if i == 0 { Some(from) } else { (i == last).then_some(to) };
                        self.share(at + r * p, vertex.map(|v| v as u32))
                    });
                    let points = points.collect();
                    let (degree, knots, weights) = (curve.degree, curve.knots.clone(), curve.weights.clone());
                    let spline = SplineCurve { degree, knots, points, weights };
                    self.edges.push(CompressedEdge { vertices: (from, to), curve: Curve::Spline(spline) });
                    pieces.push(Pieces { first, two: false, reversed: false });
                }
            }
        }
        Ok(pieces)
    }

    /// The point's index: `like`, if that is the same point bit for bit, else a new one.
    fn share(&mut self, p: DVec3, like: Option<u32>) -> u32 {
        if let Some(index) = like.filter(|&i| self.points[i as usize] == p) {
            return index;
        }
        self.points.push(p);
        (self.points.len() - 1) as u32
    }

    /// The closed rim of a strut end, counter-clockwise about the outward axis, from the seam's
    /// vertex on. Adds the closed edge where the strut ends in a cap.
    fn rim_loop(&mut self, arm: Arm, circle: usize, vertex: usize, pieces: &[Pieces]) -> Vec<CompressedEdgeIndex> {
        let node = self.graph.near(arm);
        let skin = self.skins[node.index()].expect("checked with the vertices");
        let rim = &skin.rims[self.arm_index(arm)];
        if rim.arcs.is_empty() {
            let index = self.edges.len();
            self.edges.push(CompressedEdge { vertices: (vertex, vertex), curve: Curve::Arc(circle) });
            self.closed[circle] = Some(index);
            return vec![CompressedEdgeIndex { index, orientation: arm.end == End::A }];
        }
        let mut around: Vec<_> = rim.arcs.iter().flat_map(|&arc| pieces[arc].walk(true)).collect();
        let starts = |e: &CompressedEdgeIndex| {
            let (front, back) = self.edges[e.index].vertices;
            vertex == if e.orientation { front } else { back }
        };
        let turn = around.iter().position(starts).unwrap_or(0);
        around.rotate_left(turn);
        around
    }

    /// The seam and the face of a strut.
    fn strut_face(&mut self, strut: StrutId, k: usize, ends: [StrutEnd; 2], rims: [Vec<CompressedEdgeIndex>; 2]) {
        let index = self.edges.len();
        let vertices = (ends[0].seam_vertex, ends[1].seam_vertex);
        self.edges.push(CompressedEdge { vertices, curve: Curve::Line });
        let [mut boundary, rim_b] = rims;
        boundary.push(CompressedEdgeIndex { index, orientation: true });
        boundary.extend(rim_b);
        boundary.push(CompressedEdgeIndex { index, orientation: false });
        self.face(vec![boundary], Surface::Strut(k), Label::Strut(strut));
    }

    fn patch_face(&mut self, node: NodeId, patch: &Patch, pieces: &[Pieces], label: Label) {
        let (at, r) = self.frame(node);
        let s = &patch.surface;
        let [nu, nv] = s.size();
        // The border points that an edge already holds, by the side's walk around the patch.
        let mut known = vec![None; nu * nv];
        let mut boundary = vec![];
        let mut sides = [0; 4];
        for (side, &(edge, forward)) in patch.boundary.iter().enumerate() {
            let walk: Vec<_> = pieces[edge].walk(forward).collect();
            sides[side] = walk.len() as u8;
            let (row, len) = match side {
                0 => ([0, nv as isize], nu),
                1 => ([((nu - 1) * nv) as isize, 1], nv),
                2 => ([(nu * nv - 1) as isize, -(nv as isize)], nu),
                _ => ([(nv - 1) as isize, -1], nv),
            };
            let mut hold = |i: usize, id: u32| known[(row[0] + row[1] * i as isize) as usize] = Some(id);
            let first = &self.edges[walk[0].index];
            hold(0, if walk[0].orientation { first.vertices.0 } else { first.vertices.1 } as u32);
            if let Curve::Spline(curve) = &first.curve
                && curve.points.len() == len
            {
                for i in 1..len - 1 {
                    hold(i, curve.points[if forward { i } else { len - 1 - i }]);
                }
            }
            boundary.extend(walk);
        }
        let points = s.points.iter().zip(known).map(|(&p, known)| self.share(at + r * p, known)).collect();
        let surface = SplineSurface { degree: s.degree, knots: s.knots.clone(), points, weights: s.weights.clone(), sides, rim: vec![] };
        self.face(vec![boundary], Surface::Spline(surface), label);
    }

    /// Closes a strut at a degree-1 node, flat, or round if there is a `pole` (a vertex).
    fn cap_face(&mut self, node: NodeId, circle: usize, end: End, vertex: usize, pole: Option<usize>) {
        let rim = self.closed[circle].expect("a rim without arcs has a closed edge");
        // Counter-clockwise about the cap's own outward axis, which points away from the strut.
        let mut boundary = vec![CompressedEdgeIndex { index: rim, orientation: end == End::B }];
        let flipped = end == End::A;
        let Some(pole) = pole else {
            return self.face(vec![boundary], Surface::Plane { circle, flipped }, Label::Cap(node));
        };
        let frame = self.circles[circle];
        let up = if flipped { -frame.axis } else { frame.axis };
        // This rim has no arcs: its x points to its vertex.
        let meridian = Circle { axis: frame.x.cross(up), ..frame };
        let index = self.edges.len();
        self.edges.push(CompressedEdge { vertices: (vertex, pole), curve: Curve::Arc(self.circles.len()) });
        self.circles.push(meridian);
        boundary.extend([true, false].map(|orientation| CompressedEdgeIndex { index, orientation }));
        self.face(vec![boundary], Surface::Sphere { circle, flipped }, Label::Cap(node));
    }

    fn face(&mut self, boundaries: Vec<Vec<CompressedEdgeIndex>>, surface: Surface, label: Label) {
        self.faces.push(CompressedFace { boundaries, orientation: true, surface });
        self.labels.push(label);
    }
}

/// The sign that turns a strut's direction (a to b) outward at this end's node.
fn outward_sign(end: End) -> f64 {
    if end == End::A { 1.0 } else { -1.0 }
}

/// Unit vector to the middle of the arc between two points of a circle, counter-clockwise about
/// `axis`; opposite to the point if both are one.
fn arc_middle(center: DVec3, axis: DVec3, [from, to]: [DVec3; 2]) -> DVec3 {
    let start = (from - center).reject_from_normalized(axis).normalize();
    let side = axis.cross(start);
    let q = to - center;
    let angle = q.dot(side).atan2(q.dot(start)).rem_euclid(TAU);
    let half = if angle == 0.0 { 0.5 * TAU } else { 0.5 * angle };
    let x = start * half.cos() + side * half.sin();
    x.reject_from_normalized(axis).normalize()
}

/// The arc whose inside holds the seam: the one whose start lies least far behind it, in the
/// arcs' own sense (about the outward axis). `None` for a capped end.
fn arc_at(azimuths: &[f64], seam: Seam, end: End) -> Option<usize> {
    let sense = outward_sign(end);
    let behind = |&x: &f64| (sense * (seam.azimuth - x)).rem_euclid(TAU);
    let order = |m: &(usize, f64), n: &(usize, f64)| m.1.total_cmp(&n.1);
    azimuths.iter().map(behind).enumerate().min_by(order).map(|m| m.0)
}
