//! What a node or a strut of a solid is made of, put together when it is asked for: `Skin` ▶ `Part`.
//!
//! Each point is computed in one place, as `node + radius · p`, and shared by index within its node, so the border rows of patches and the
//! edges between them are equal bit for bit. Nothing but the vertices on rims is shared between a node and its struts.

use super::model::{Curve, Edge, EdgeUse, Face, First, Label, Part, Solid, SplineCurve, SplineSurface, Surface};
use super::rim_map::RimMap;
use crate::graph::End;
use crate::math::nurbs::NurbsSurface;
use crate::patch::{Patch, Rim, Skin, SkinCurve};
use glam::DVec3;

/// The edges that a skin edge became: two where the seam splits a rim arc.
#[derive(Clone, Copy, Default)]
struct Pieces {
    first: u32,
    two: bool,
    /// The edges run against the skin edge.
    reversed: bool,
}

impl Pieces {
    /// The edges along the skin edge, or against it.
    fn walk(self, along: bool) -> impl Iterator<Item = EdgeUse> {
        let (a, b) = (self.first, self.first + self.two as u32);
        // Stored order follows the skin edge; `reversed` only turns each piece.
        let order = if along { [a, b] } else { [b, a] };
        let forward = along != self.reversed;
        order.into_iter().take(1 + self.two as usize).map(move |edge| EdgeUse { edge, forward })
    }
}

impl Solid {
    pub fn vertex_count(&self) -> usize {
        self.end().vertex as usize + self.extra.len()
    }

    pub fn edge_count(&self) -> usize {
        self.strut_edges[self.struts.len() + 1] as usize
    }

    pub fn face_count(&self) -> usize {
        self.end().face as usize
    }

    /// All points: vertices and control points.
    pub fn point_count(&self) -> usize {
        self.end().face_point as usize
    }

    /// Faces that close ends.
    pub fn cap_count(&self) -> usize {
        self.strut_ends.iter().flatten().filter(|end| end.closed).count()
    }

    fn end(&self) -> First {
        self.first[self.nodes.len()]
    }

    /// The place of a vertex of one of the part's edges, mm.
    pub fn vertex(&self, part: &Part, vertex: u32) -> DVec3 {
        match vertex.checked_sub(self.end().vertex) {
            Some(extra) => self.extra[extra as usize],
            None => part.points[(vertex - part.first.vertex) as usize],
        }
    }

    /// Where the skin of the n-th of `nodes` is kept: the same place for nodes of one skin, and for no others.
    pub fn skin_place(&self, n: usize) -> (usize, u64) {
        self.skins[n].1.place()
    }

    /// What the n-th of `nodes` is made of.
    pub fn part(&self, n: usize) -> Part {
        self.put_together(n, &self.skins[n].1.skin(), self.centers[n], true).0
    }

    /// The same part without the control points of its patches: its edges, and the loops of its faces.
    pub fn bordered(&self, n: usize) -> Part {
        self.put_together(n, &self.skins[n].1.skin(), self.centers[n], false).0
    }

    /// The same part as if the node were at the origin: equal to the bit for nodes that differ in nothing but their places and numbers.
    pub(super) fn part_at_origin(&self, n: usize, skin: &Skin) -> Part {
        self.put_together(n, skin, DVec3::ZERO, true).0
    }

    /// The part of a node, and the closed rim of each arm: see `Found::loops`.
    pub(super) fn part_with_rims(&self, n: usize) -> (Part, Box<[Box<[EdgeUse]>]>) {
        let skin = self.skins[n].1.skin();
        let (part, pieces) = self.put_together(n, &skin, self.centers[n], true);
        let rim_loop = |(rim, &(k, end)): (&Rim, &(u32, End))| -> Box<[EdgeUse]> {
            let vertex = self.strut_ends[k as usize][end as usize].vertex;
            let mut around: Vec<EdgeUse> = rim.arcs.iter().flat_map(|&arc| pieces[arc].walk(true)).collect();
            let starts = |e: &EdgeUse| vertex == part.edge(e.edge).vertices[!e.forward as usize];
            let turn = around.iter().position(starts).unwrap_or(0);
            around.rotate_left(turn);
            around.into()
        };
        let loops = skin.rims.iter().zip(self.arms_of(n)).map(rim_loop).collect();
        (part, loops)
    }

    /// The points of a node, mm, and the number of the first: its vertices (0), the inner control points of its edges (1) or of its patches (2).
    pub fn points(&self, n: usize, kind: usize) -> (u32, Vec<DVec3>) {
        let (skin, first) = (self.skins[n].1.skin(), self.first[n]);
        let (first, part) = match kind {
            0 => (first.vertex, self.bare(n, &skin, self.centers[n])),
            1 => (first.edge_point, self.with_edges(n, &skin, self.centers[n]).0),
            _ => (first.face_point, self.put_together(n, &skin, self.centers[n], true).0),
        };
        (first, part.points_by_kind()[kind].to_vec())
    }

    /// A part without edges and faces.
    fn bare(&self, n: usize, skin: &Skin, center: DVec3) -> Part {
        let unit = self.skins[n].0;
        let points: Vec<DVec3> = skin.vertices.iter().map(|&p| center + unit * p).collect();
        let vertex_count = points.len();
        Part { center, points, edges: vec![], faces: vec![], first: self.first[n], vertex_count, edge_point_count: 0 }
    }

    /// A part without faces, and the edges that each edge of its skin became.
    fn with_edges(&self, n: usize, skin: &Skin, center: DVec3) -> (Part, Vec<Pieces>) {
        let mut part = self.bare(n, skin, center);
        let pieces = self.skin_edges(n, skin, self.skins[n].0, &mut part);
        part.edge_point_count = part.points.len() - part.vertex_count;
        (part, pieces)
    }

    /// The part of a node at this place, with or without the control points of its patches, and the edges that each edge of its skin became.
    fn put_together(&self, n: usize, skin: &Skin, center: DVec3, with_points: bool) -> (Part, Vec<Pieces>) {
        let (mut part, pieces) = self.with_edges(n, skin, center);
        let mut numbers = vec![0; skin.rims.len()];
        let mut first_map = 0;
        if with_points {
            part.points.reserve(skin.patches.iter().map(|patch| patch.surface.points.len()).sum());
        }
        part.faces.reserve(skin.patches.len());
        for patch in &skin.patches {
            numbers[patch.arm] += 1;
            let (k, _) = self.arms_of(n)[patch.arm];
            let label = Label::Patch { node: self.nodes[n], strut: self.struts[k as usize], number: numbers[patch.arm] };
            part.patch_face(patch, with_points.then_some(self.skins[n].0), &pieces, first_map, label);
            first_map += part.arcs(&part.faces[part.faces.len() - 1]).count() as u32;
        }
        part.faces.extend(self.cap(n));
        (part, pieces)
    }

    /// Adds the edges of a node's skin, rim arcs split where a seam ends. Indexed by skin edge.
    fn skin_edges(&self, n: usize, skin: &Skin, unit: f64, part: &mut Part) -> Vec<Pieces> {
        let arms = self.arms_of(n);
        let split = |(rim, &(k, end)): (usize, &(u32, End))| {
            let split = self.strut_ends[k as usize][end as usize].split?;
            Some(skin.rims[rim].arcs[split as usize])
        };
        let splits: Vec<usize> = arms.iter().enumerate().filter_map(split).collect();
        let mut pieces = Vec::with_capacity(skin.edges.len());
        part.edges.reserve(skin.edges.len() + splits.len());
        for (index, edge) in skin.edges.iter().enumerate() {
            let [from, to] = edge.ends.map(|v| part.first.vertex + v as u32);
            let first = part.first.edge + part.edges.len() as u32;
            match &edge.curve {
                SkinCurve::RimArc(rim) => {
                    let (k, end) = arms[*rim];
                    let two = splits.contains(&index);
                    let steps = [from, self.strut_ends[k as usize][end as usize].vertex, to];
                    let steps = if two { &steps[..] } else { &[from, to] };
                    // Arcs run about the outward axis; the circle's axis points from a to b.
                    let reversed = end == End::B;
                    for step in steps.windows(2) {
                        let vertices = if reversed { [step[1], step[0]] } else { [step[0], step[1]] };
                        part.edges.push(Edge { vertices, curve: Curve::Arc(2 * k as usize + end as usize) });
                    }
                    pieces.push(Pieces { first, two, reversed });
                }
                SkinCurve::Spline(curve) => {
                    let last = curve.points.len() - 1;
                    let points = curve.points.iter().enumerate().map(|(i, &p)| {
                        let vertex = if i == 0 { Some(edge.ends[0]) } else { (i == last).then_some(edge.ends[1]) };
                        part.share(unit, p, vertex.map(|v| v as u32))
                    });
                    let points = points.collect();
                    let (degree, knots, weights) = (curve.degree, curve.knots.clone(), curve.weights.clone());
                    let spline = SplineCurve { degree, knots, points, weights };
                    part.edges.push(Edge { vertices: [from, to], curve: Curve::Spline(spline) });
                    pieces.push(Pieces { first, two: false, reversed: false });
                }
            }
        }
        pieces
    }

    /// The struts (positions in `struts`) and ends at the n-th of `nodes`.
    pub(super) fn arms_of(&self, n: usize) -> &[(u32, End)] {
        &self.arms[self.first_arm[n] as usize..self.first_arm[n + 1] as usize]
    }

    /// Closes a strut at the n-th of `nodes`, if that is an end: flat, or round if the node has a pole.
    pub(super) fn cap(&self, n: usize) -> Option<Face> {
        let (k, end) = *self.arms_of(n).first().filter(|&&(k, end)| self.strut_ends[k as usize][end as usize].closed)?;
        let label = if n < self.own { Label::Cap(self.nodes[n]) } else { Label::Disc(self.struts[k as usize]) };
        let circle = 2 * k as usize + end as usize;
        // Counter-clockwise about the cap's own outward axis, which points away from the strut.
        let mut boundary = vec![EdgeUse { edge: self.closed_edge(k as usize, end), forward: end == End::B }];
        let flipped = end == End::A;
        let Ok(pole) = self.poles.binary_search(&(n as u32)) else {
            return Some(Face { boundary, surface: Surface::Plane { circle, flipped }, label });
        };
        let edge = self.strut_edges[self.struts.len()] + pole as u32;
        boundary.extend([true, false].map(|forward| EdgeUse { edge, forward }));
        Some(Face { boundary, surface: Surface::Sphere { circle, flipped }, label })
    }

    /// The closed edge on a rim without arcs.
    fn closed_edge(&self, k: usize, end: End) -> u32 {
        self.strut_edges[k] + (end == End::B && self.strut_ends[k][0].closed) as u32
    }

    /// The closed rims and the seam of the k-th of `struts`, in order of their numbers.
    pub fn strut_edges(&self, k: usize) -> Vec<Edge> {
        let ends = self.strut_ends[k];
        let closed = |e: usize| Edge { vertices: [ends[e].vertex; 2], curve: Curve::Arc(2 * k + e) };
        let seam = Edge { vertices: ends.map(|end| end.vertex), curve: Curve::Line };
        (0..2).filter(|&e| ends[e].closed).map(closed).chain([seam]).collect()
    }

    /// The ends of a strut's seam, mm.
    pub fn seam_ends(&self, k: usize) -> [DVec3; 2] {
        self.strut_ends[k].map(|end| end.point)
    }

    /// The first of `strut_edges(k)`; for `k` the number of struts, the first of `meridians`.
    pub fn first_strut_edge(&self, k: usize) -> u32 {
        self.strut_edges[k]
    }

    /// The edges from round caps' rims to their poles.
    pub fn meridians(&self) -> impl Iterator<Item = Edge> {
        let first_pole = (self.vertex_count() - self.poles.len()) as u32;
        self.poles.iter().enumerate().map(move |(j, &n)| {
            let (k, end) = self.arms_of(n as usize)[0];
            let vertices = [self.strut_ends[k as usize][end as usize].vertex, first_pole + j as u32];
            Edge { vertices, curve: Curve::Arc(2 * self.struts.len() + j) }
        })
    }

    /// The circles of the rims with round caps.
    pub(super) fn round_ends(&self) -> impl Iterator<Item = usize> {
        let circle = |&n: &u32| self.arms_of(n as usize).iter().map(|&(k, end)| 2 * k as usize + end as usize);
        self.poles.iter().flat_map(circle)
    }

    /// The face of the k-th of `struts`.
    pub fn strut_face(&self, k: usize) -> Face {
        let rim = |end: End| {
            let n = self.ends[k][end as usize] as usize;
            let arm = self.arms_of(n).iter().position(|&a| a == (k as u32, end)).expect("an arm is listed at its node");
            let closed = EdgeUse { edge: self.closed_edge(k, end), forward: end == End::A };
            let arcs = &self.found[n].loops[arm];
            if arcs.is_empty() { vec![closed] } else { arcs.to_vec() }
        };
        let edge = self.strut_edges[k + 1] - 1;
        let seam = |forward: bool| [EdgeUse { edge, forward }];
        let boundary = [&rim(End::A)[..], &seam(true), &rim(End::B), &seam(false)].concat();
        Face { boundary, surface: Surface::Strut(k), label: Label::Strut(self.struts[k]) }
    }

    /// How the rim arcs of one of the n-th node's patches run on it, in the order of `Part::arcs`; others follow.
    pub fn rim_maps(&self, n: usize, patch: &SplineSurface) -> &[RimMap] {
        &self.found[n].rims[patch.first_map as usize..]
    }

    /// The name of a face, by its number.
    pub fn label(&self, face: usize) -> Label {
        match self.struts.get(face) {
            Some(&strut) => Label::Strut(strut),
            None => {
                let n = self.first[..self.nodes.len()].partition_point(|first| first.face as usize <= face) - 1;
                self.bordered(n).faces[face - self.first[n].face as usize].label
            }
        }
    }
}

impl Part {
    /// The number of the first edge, and of the first face.
    pub fn first_edge(&self) -> u32 {
        self.first.edge
    }

    pub fn first_face(&self) -> u32 {
        self.first.face
    }

    /// One of the skin's vertices, by its number.
    pub(super) fn vertex(&self, vertex: u32) -> Option<DVec3> {
        let own = vertex.checked_sub(self.first.vertex).filter(|&v| (v as usize) < self.vertex_count);
        own.map(|v| self.points[v as usize])
    }

    /// The solid's number of one of `points`.
    pub fn number(&self, point: u32) -> u32 {
        let (vertices, edge_points) = (self.vertex_count as u32, self.edge_point_count as u32);
        if point < vertices {
            self.first.vertex + point
        } else if point < vertices + edge_points {
            self.first.edge_point + point - vertices
        } else {
            self.first.face_point + point - vertices - edge_points
        }
    }

    /// The vertices; the control points of edges; those of patches.
    fn points_by_kind(&self) -> [&[DVec3]; 3] {
        let (vertices, rest) = self.points.split_at(self.vertex_count);
        let (of_edges, of_faces) = rest.split_at(self.edge_point_count);
        [vertices, of_edges, of_faces]
    }

    /// Control points of edges and of patches.
    pub(super) fn point_counts(&self) -> [usize; 2] {
        let [_, of_edges, of_faces] = self.points_by_kind();
        [of_edges.len(), of_faces.len()]
    }

    /// An edge of the skin, by its number.
    pub fn edge(&self, edge: u32) -> &Edge {
        &self.edges[(edge - self.first.edge) as usize]
    }

    /// The rim arcs on the first side of a patch: the circle's number, and the edge's.
    pub fn arcs<'a>(&'a self, face: &'a Face) -> impl Iterator<Item = (usize, u32)> + 'a {
        let count = if let Surface::Spline(s) = &face.surface { s.sides[0] } else { 0 };
        let arc = |e: &EdgeUse| if let Curve::Arc(circle) = self.edge(e.edge).curve { Some((circle, e.edge)) } else { None };
        face.boundary.iter().take(count as usize).filter_map(arc)
    }

    /// The index of `node + unit · p`: `like`, if that is the same point bit for bit, else a new one.
    fn share(&mut self, unit: f64, p: DVec3, like: Option<u32>) -> u32 {
        let p = self.center + unit * p;
        if let Some(index) = like.filter(|&i| self.points[i as usize] == p) {
            return index;
        }
        self.points.push(p);
        (self.points.len() - 1) as u32
    }

    /// Adds the face of a patch, and its control points if their unit is given.
    fn patch_face(&mut self, patch: &Patch, unit: Option<f64>, pieces: &[Pieces], first_map: u32, label: Label) {
        let s = &patch.surface;
        let mut boundary = Vec::with_capacity(6);
        let mut sides = [0; 4];
        for (side, &(edge, forward)) in patch.boundary.iter().enumerate() {
            let before = boundary.len();
            boundary.extend(pieces[edge].walk(forward));
            sides[side] = (boundary.len() - before) as u8;
        }
        let points = unit.map_or(vec![], |unit| self.patch_points(s, unit, &boundary, sides));
        let surface = SplineSurface { degree: s.degree, knots: s.knots.clone(), points, weights: s.weights.clone(), sides, first_map };
        self.faces.push(Face { boundary, surface: Surface::Spline(surface), label });
    }

    /// The indices of a patch's control points: of those that an edge on its loop holds, or of new ones.
    fn patch_points(&mut self, s: &NurbsSurface, unit: f64, boundary: &[EdgeUse], sides: [u8; 4]) -> Vec<u32> {
        const NEW: u32 = u32::MAX;
        let [nu, nv] = s.size();
        let mut points = vec![NEW; nu * nv];
        let mut left = boundary;
        for (side, count) in sides.into_iter().enumerate() {
            let (row, step, len) = match side {
                0 => (0, nv as isize, nu),
                1 => ((nu - 1) * nv, 1, nv),
                2 => (nu * nv - 1, -(nv as isize), nu),
                _ => (nv - 1, -1, nv),
            };
            let on_side = |i: usize| row.wrapping_add_signed(step * i as isize);
            let first = left[0];
            left = &left[count as usize..];
            let walked = self.edge(first.edge);
            points[on_side(0)] = walked.vertices[!first.forward as usize] - self.first.vertex;
            if let Curve::Spline(curve) = &walked.curve
                && curve.points.len() == len
            {
                for i in 1..len - 1 {
                    points[on_side(i)] = curve.points[if first.forward { i } else { len - 1 - i }];
                }
            }
        }
        for (&p, index) in s.points.iter().zip(&mut points) {
            *index = self.share(unit, p, Some(*index).filter(|&held| held != NEW));
        }
        points
    }
}
