//! `Graph` + `Skin`s ▶ `Model`: one cylinder or cone per strut with an explicit seam, caps, and the numbers of all vertices, edges,
//! faces and points. What a node is made of stays in its skin: see `part.rs`.

use super::error::BrepError;
use super::model::{Circle, First, Found, Model, Solid, StrutEnd};
use super::rim_map::map_rims;
use super::seam::{self, Seam};
use crate::graph::components::{Members, components};
use crate::graph::{Arm, End, Graph};
use crate::ids::{NodeId, StrutId};
use crate::patch::{Rim, Shelved, Skin};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

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
pub fn assemble(graph: &Graph, skins: &[Option<Shelved>], options: &AssembleOptions) -> Result<Model, Vec<BrepError>> {
    assemble_parts(graph, skins, &|_| options.caps == Caps::Sphere)
}

/// The same, told which ends of degree 1 are round.
pub(super) fn assemble_parts(graph: &Graph, skins: &[Option<Shelved>], is_round: &dyn Fn(NodeId) -> bool) -> Result<Model, Vec<BrepError>> {
    solids(graph, skins, components(graph).members(), is_round)
}

/// One solid for each part of a graph. Where a strut leads to a node of another part, a disc ends it in the middle between its rims.
pub(super) fn solids(graph: &Graph, skins: &[Option<Shelved>], parts: Vec<Members>, is_round: &dyn Fn(NodeId) -> bool) -> Result<Model, Vec<BrepError>> {
    let mut solids = vec![];
    let mut faults = vec![];
    for part in parts {
        match (Builder { graph, skins }).solid(part, is_round) {
            Ok(solid) => solids.push(solid),
            Err(fault) => faults.push(fault),
        }
    }
    if faults.is_empty() { Ok(Model { solids }) } else { Err(faults) }
}

/// What stands for the skin where a disc ends a strut: a rim without arcs.
pub(super) fn disc(rim: Rim) -> Shelved {
    Shelved::from(Skin { rims: vec![rim], ..Skin::default() })
}

struct Builder<'a> {
    graph: &'a Graph,
    skins: &'a [Option<Shelved>],
}

/// What a look at a node's skin shows.
struct Outline {
    vertices: u32,
    edges: u32,
    patches: u32,
    /// The rim of each arm, or what is wrong with it.
    rims: Vec<Result<Outlined, BrepError>>,
}

/// A rim: its centre and radius (mm), and its vertices, counter-clockwise about the outward axis.
struct Outlined {
    center: DVec3,
    radius: f64,
    vertices: Vec<RimVertex>,
}

/// A vertex on a rim. From the rim's centre it is the same to the bit wherever the node stands.
#[derive(Clone, Copy)]
struct RimVertex {
    /// Position in the skin.
    number: u32,
    /// mm
    place: DVec3,
    from_center: DVec3,
}

/// Rims and seam of one strut, before vertices are numbered.
struct Placed {
    seam: DVec3,
    slope: f64,
    rims: [Circle; 2],
    ends: [PlacedEnd; 2],
}

struct PlacedEnd {
    /// The vertex of the node's skin where the seam ends; none where the seam has a vertex of its own.
    vertex: Option<u32>,
    point: DVec3,
    split: Option<u32>,
    closed: bool,
}

impl Placed {
    /// A disc in the middle between the rims takes the place of the rim at this end. Both halves of a strut get the same, to the bit.
    fn halved(mut self, end: End) -> Placed {
        let [a, b] = self.rims;
        let middle = Circle { center: a.center.midpoint(b.center), axis: a.axis, x: self.seam, radius: a.radius.midpoint(b.radius) };
        self.rims[end as usize] = middle;
        self.ends[end as usize] = PlacedEnd { vertex: None, point: middle.center + middle.radius * middle.x, split: None, closed: true };
        self
    }
}

impl Builder<'_> {
    fn solid(&self, part: Members, is_round: &dyn Fn(NodeId) -> bool) -> Result<Solid, BrepError> {
        let Members { nodes: own, struts } = part;
        // the nodes that halved struts lead to, in the order of the struts
        let ends_of = |strut: StrutId| [End::A, End::B].map(|end| self.graph.near(Arm { strut, end }));
        let beyond: Vec<NodeId> = struts.iter().flat_map(|&strut| ends_of(strut)).filter(|n| own.binary_search(n).is_err()).collect();
        let mut seen = [&own[..], &beyond].concat();
        seen.sort_unstable();
        seen.dedup();
        let outlines: Vec<Outline> = seen.par_iter().map(|&node| self.outline(node)).collect::<Result<_, _>>()?;
        let outline_of = |node: NodeId| &outlines[seen.binary_search(&node).expect("a node at one of the struts")];
        let rim = |arm: Arm| {
            let node = self.graph.near(arm);
            let position = self.graph.arms(node).iter().position(|&a| a == arm).expect("an arm is listed at its node");
            outline_of(node).rims[position].as_ref().map_err(Clone::clone)
        };
        let place = |&strut: &StrutId| {
            let placed = self.place(strut, [rim(Arm { strut, end: End::A })?, rim(Arm { strut, end: End::B })?])?;
            let cut = [End::A, End::B].into_iter().find(|&end| own.binary_search(&self.graph.near(Arm { strut, end })).is_err());
            Ok(if let Some(end) = cut { placed.halved(end) } else { placed })
        };
        let placed: Vec<Placed> = struts.par_iter().map(place).collect::<Result<_, _>>()?;
        let mut discs = own.len() as u32..;
        let mut position = |node: NodeId| own.binary_search(&node).map_or_else(|_| discs.next().expect("no end"), |n| n as u32);
        let ends: Vec<[u32; 2]> = struts.iter().map(|&strut| ends_of(strut).map(&mut position)).collect();

        // the own nodes, then the discs of halved struts, which have no skins
        let nodes = [&own[..], &beyond].concat();
        let (mut next, mut first) = (First::default(), vec![]);
        for &node in &own {
            first.push(next);
            next.vertex += outline_of(node).vertices;
        }
        first.resize(nodes.len() + 1, next);

        // vertices that no skin has
        let mut extra = vec![];
        let mut add = |p: DVec3| {
            extra.push(p);
            next.vertex + extra.len() as u32 - 1
        };
        let strut_ends: Vec<[StrutEnd; 2]> = placed
            .iter()
            .zip(&ends)
            .map(|(placed, ends)| {
                [0, 1].map(|e| {
                    let PlacedEnd { vertex, point, split, closed } = placed.ends[e];
                    let vertex = vertex.map_or_else(|| add(point), |v| first[ends[e] as usize].vertex + v);
                    StrutEnd { vertex, point, split, closed }
                })
            })
            .collect();
        let mut circles: Vec<Circle> = placed.iter().flat_map(|p| p.rims).collect();

        let of_strut = |strut: StrutId| struts.binary_search(&strut).expect("the strut belongs to the part") as u32;
        let mut arms: Vec<(u32, End)> = own.iter().flat_map(|&n| self.graph.arms(n)).map(|arm| (of_strut(arm.strut), arm.end)).collect();
        let mut first_arm = vec![0];
        for (n, &node) in own.iter().enumerate() {
            first_arm.push(first_arm[n] + self.graph.degree(node) as u32);
        }
        let at_disc = |(k, ends): (usize, &[u32; 2])| [End::A, End::B].into_iter().find(|&e| ends[e as usize] >= own.len() as u32).map(|e| (k as u32, e));
        arms.extend(ends.iter().enumerate().filter_map(at_disc));
        first_arm.extend(first_arm[own.len()] + 1..=arms.len() as u32);

        // edges and faces
        let mut poles = vec![];
        next.face = struts.len() as u32;
        for (n, &node) in nodes.iter().enumerate() {
            let arms = &arms[first_arm[n] as usize..first_arm[n + 1] as usize];
            let ends = || arms.iter().map(|&(k, end)| &strut_ends[k as usize][end as usize]);
            let is_capped = ends().len() == 1 && ends().all(|end| end.closed);
            (first[n].edge, first[n].face) = (next.edge, next.face);
            let outline = (n < own.len()).then(|| outline_of(node));
            if let Some(outline) = outline {
                next.edge += outline.edges + ends().filter(|end| end.split.is_some()).count() as u32;
                next.face += outline.patches;
            }
            next.face += is_capped as u32;
            if is_capped && outline.is_some() && is_round(node) {
                poles.push(n as u32);
                let (k, end) = arms[0];
                let (at, r) = self.frame(node);
                let arm = Arm { strut: struts[k as usize], end };
                add(at - r * self.outward(arm));
                // this rim has no arcs: its x points to its vertex
                let rim = circles[2 * k as usize + end as usize];
                let up = outward_sign(end) * -rim.axis;
                circles.push(Circle { axis: rim.x.cross(up), ..rim });
            }
        }
        let mut strut_edges = vec![next.edge];
        for ends in &strut_ends {
            next.edge += 1 + ends.iter().filter(|end| end.closed).count() as u32;
            strut_edges.push(next.edge);
        }
        strut_edges.push(next.edge + poles.len() as u32);
        next.edge = strut_edges[0];
        first[nodes.len()] = next;

        let rims_at_discs = || arms[first_arm[own.len()] as usize..].iter().map(|&(k, end)| circles[2 * k as usize + end as usize]);
        let centers = own.iter().map(|n| self.graph.nodes()[n.index()]).chain(rims_at_discs().map(|c| c.center)).collect();
        let mut skins = own.iter().map(|&node| Ok((self.graph.largest_radius(node), self.skin(node)?.clone()))).collect::<Result<Vec<_>, _>>()?;
        if !beyond.is_empty() {
            let bare = disc(Rim { axis: DVec3::Z, cut: 0.0, radius: 1.0, taper: 0.0, arcs: vec![] });
            skins.extend(rims_at_discs().map(|c| (c.radius, bare.clone())));
        }
        let own = own.len();
        let (seams, slopes) = placed.into_iter().map(|p| (p.seam, p.slope)).unzip();
        let found = vec![];
        drop(outlines);
        let mut solid =
            Solid { nodes, own, centers, struts, ends, seams, slopes, circles, extra, first, skins, strut_ends, strut_edges, arms, first_arm, poles, found };
        solid.find();
        Ok(solid)
    }

    fn skin(&self, node: NodeId) -> Result<&Shelved, BrepError> {
        let skin = self.skins.get(node.index()).and_then(Option::as_ref);
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

    fn outline(&self, node: NodeId) -> Result<Outline, BrepError> {
        let skin = self.skin(node)?.skin();
        let (found, wanted) = (skin.rims.len(), self.graph.degree(node));
        if found != wanted {
            return Err(BrepError::RimCount { node, found, wanted });
        }
        let rims = self.graph.arms(node).iter().zip(&skin.rims).map(|(&arm, rim)| self.outline_rim(arm, &skin, rim)).collect();
        Ok(Outline { vertices: skin.vertices.len() as u32, edges: skin.edges.len() as u32, patches: skin.patches.len() as u32, rims })
    }

    fn outline_rim(&self, arm: Arm, skin: &Skin, rim: &Rim) -> Result<Outlined, BrepError> {
        let (node, strut) = (self.graph.near(arm), arm.strut);
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
        let to_center = r * rim.cut * outward;
        let mut vertices = Vec::with_capacity(rim.arcs.len());
        for (k, &arc) in rim.arcs.iter().enumerate() {
            let next = rim.arcs[(k + 1) % rim.arcs.len()];
            if skin.edges[arc].ends[1] != skin.edges[next].ends[0] {
                return Err(BrepError::RimNotClosed { node, strut });
            }
            let vertex = skin.edges[arc].ends[0];
            let offset = r * skin.vertices[vertex];
            vertices.push(RimVertex { number: vertex as u32, place: at + offset, from_center: offset - to_center });
        }
        Ok(Outlined { center: at + to_center, radius, vertices })
    }

    /// Rim circles and seam of one strut.
    fn place(&self, strut: StrutId, rims: [&Outlined; 2]) -> Result<Placed, BrepError> {
        let axis = self.outward(Arm { strut, end: End::A });
        let side = axis.any_orthonormal_vector();
        let (centers, radii, vertices) = (rims.map(|r| r.center), rims.map(|r| r.radius), rims.map(|r| &r.vertices));
        let azimuths = rims.map(|rim| {
            let azimuth = |p: DVec3| p.dot(axis.cross(side)).atan2(p.dot(side));
            rim.vertices.iter().map(|v| azimuth(v.from_center)).collect::<Vec<f64>>()
        });
        let room = (centers[1] - centers[0]).dot(axis);
        if room <= 0.0 {
            return Err(BrepError::NoRoom { strut, room });
        }
        let seam = seam::place(&azimuths[0], &azimuths[1]);
        // The seam runs through an existing vertex if there is one; its azimuth is exact there.
        let x = match seam.at {
            [Some(k), _] => vertices[0][k].from_center,
            [None, Some(k)] => vertices[1][k].from_center,
            [None, None] => side * seam.azimuth.cos() + axis.cross(side) * seam.azimuth.sin(),
        };
        let x = x.reject_from_normalized(axis).normalize();
        let ends = [End::A, End::B].map(|end| {
            let e = end as usize;
            let closed = vertices[e].is_empty();
            match seam.at[e] {
                Some(k) => PlacedEnd { vertex: Some(vertices[e][k].number), point: vertices[e][k].place, split: None, closed },
                None => PlacedEnd { vertex: None, point: centers[e] + radii[e] * x, split: arc_at(&azimuths[e], seam, end), closed },
            }
        });
        let rims = [End::A, End::B].map(|end| {
            let e = end as usize;
            // The frame's own x keeps away from vertices: the middle of the first arc, or of the second if the seam splits the first.
            let arc = |k: usize| [k, k + 1].map(|k| vertices[e][k % vertices[e].len()].from_center);
            let first = (ends[e].split == Some(0)) as usize;
            let x = if ends[e].closed { x } else { arc_middle(outward_sign(end) * axis, arc(first)) };
            Circle { center: centers[e], axis, x, radius: radii[e] }
        });
        let s = &self.graph.struts()[strut.index()];
        Ok(Placed { seam: x, slope: (s.rb - s.ra) / self.graph.length(strut), rims, ends })
    }
}

impl Solid {
    /// Fills in what takes a look at each node's part: points counted, rims closed, rim arcs mapped on their patches.
    fn find(&mut self) {
        let maps = map_rims(self);
        let of_node = |(n, rims)| {
            let (part, loops) = self.part_with_rims(n);
            (part.point_counts(), Found { loops, rims, is_finite: part.is_finite() })
        };
        let (counts, found): (Vec<_>, Vec<_>) = maps.into_par_iter().enumerate().map(of_node).unzip();
        let mut next = self.vertex_count() as u32;
        for (k, first) in self.first.iter_mut().enumerate() {
            first.edge_point = next;
            next += counts.get(k).map_or(0, |c| c[0]) as u32;
        }
        for (k, first) in self.first.iter_mut().enumerate() {
            first.face_point = next;
            next += counts.get(k).map_or(0, |c| c[1]) as u32;
        }
        self.found = found;
    }
}

/// The sign that turns a strut's direction (a to b) outward at this end's node.
pub(super) fn outward_sign(end: End) -> f64 {
    if end == End::A { 1.0 } else { -1.0 }
}

/// Unit vector to the middle of the arc between two points of a circle, given from its centre, counter-clockwise about
/// `axis`; opposite to the point if both are one.
fn arc_middle(axis: DVec3, [from, to]: [DVec3; 2]) -> DVec3 {
    let start = from.reject_from_normalized(axis).normalize();
    let side = axis.cross(start);
    let angle = to.dot(side).atan2(to.dot(start)).rem_euclid(TAU);
    let half = if angle == 0.0 { 0.5 * TAU } else { 0.5 * angle };
    let x = start * half.cos() + side * half.sin();
    x.reject_from_normalized(axis).normalize()
}

/// The arc whose inside holds the seam: the one whose start lies least far behind it, in the
/// arcs' own sense (about the outward axis). `None` for a capped end.
fn arc_at(azimuths: &[f64], seam: Seam, end: End) -> Option<u32> {
    let sense = outward_sign(end);
    let behind = |&x: &f64| (sense * (seam.azimuth - x)).rem_euclid(TAU);
    let order = |m: &(usize, f64), n: &(usize, f64)| m.1.total_cmp(&n.1);
    azimuths.iter().map(behind).enumerate().min_by(order).map(|m| m.0 as u32)
}
