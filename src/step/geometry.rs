//! Streams one solid. Every entity's number follows from counts alone, so that pieces can be
//! formatted in parallel and written in order: points, vertices, circles, edges, faces, shell.

use super::options::Decimals;
use super::text::{push_integer, push_list, push_real, push_ref, push_rounded};
use crate::brep::topology::connected_order;
use crate::brep::{Borders, Circle, Curve, Edge, Face, Part, RimMap, Solid, SplineCurve, SplineSurface, Surface};
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Write};
use std::sync::OnceLock;

/// Entities of a strut's two rims: axis, x of the seam and of both rims, both centres, placements
/// of the strut's surface and of both circles, both circles.
const PER_RIMS: u64 = 11;
/// Entities of a meridian: axis, x, centre, placement, circle.
const PER_MERIDIAN: u64 = 5;
/// Items formatted by one task (struts, or as many nodes as have about so many faces), and tasks in flight: some 10 MB of text at a time.
const CHUNK: usize = 128;
const TASKS: usize = 32;

/// Entity numbers of one solid.
pub struct Numbers {
    points: u64,
    vertices: u64,
    circles: u64,
    meridians: u64,
    /// Number of each EDGE_CURVE; its geometry is numbered just before it.
    edges: Vec<u64>,
    /// Number of each ADVANCED_FACE; its loop and surface are numbered just before it.
    faces: Vec<u64>,
    /// The faces in connected order.
    order: Vec<u32>,
    pub shell: u64,
    pub brep: u64,
    pub styled: u64,
}

impl Numbers {
    /// Numbers for a solid whose first entity is `first`; the next free number is `styled + 1`.
    pub fn new(solid: &Solid, first: u64) -> Self {
        let points = first;
        let vertices = points + solid.point_count() as u64;
        let circles = vertices + solid.vertex_count() as u64;
        let struts = solid.struts.len() as u64;
        let meridians = circles + PER_RIMS * struts;
        let mut next = meridians + PER_MERIDIAN * (solid.circles.len() as u64 - 2 * struts);
        let mut take = |count: u64| {
            next += count;
            next - 1
        };
        let mut sizes: Vec<u64> = Vec::with_capacity(solid.edge_count());
        let mut face_sizes: Vec<u64> = (0..solid.struts.len()).map(|k| face_size(solid, &solid.strut_face(k))).collect();
        let look = |n: usize, part: &Part| {
            let maps = maps(solid, n, part);
            let edges: Vec<u64> = part.edges.iter().zip(&maps).map(|(edge, map)| edge_size(&edge.curve, map.as_ref())).collect();
            let faces: Vec<u64> = part.faces.iter().map(|face| face_size(solid, face)).collect();
            (edges, faces)
        };
        let borders = Borders::with(solid, look, |(edges, faces)| {
            sizes.extend(edges);
            face_sizes.extend(faces);
        });
        let order = connected_order(&borders);
        drop(borders);
        sizes.extend((0..solid.struts.len()).flat_map(|k| solid.strut_edges(k)).chain(solid.meridians()).map(|edge| edge_size(&edge.curve, None)));
        let edges = sizes.into_iter().map(&mut take).collect();
        let faces = face_sizes.into_iter().map(&mut take).collect();
        let (shell, brep, styled) = (take(1), take(1), take(1));
        Numbers { points, vertices, circles, meridians, edges, faces, order, shell, brep, styled }
    }

    fn point(&self, index: u32) -> u64 {
        self.points + index as u64
    }

    fn vertex(&self, index: usize) -> u64 {
        self.vertices + index as u64
    }

    fn axis(&self, circle: usize) -> u64 {
        self.circles + PER_RIMS * (circle / 2) as u64
    }

    fn center(&self, circle: usize) -> u64 {
        self.axis(circle) + 4 + (circle % 2) as u64
    }

    /// The placement of a strut's surface at its rim a; not written for a strut that gets thinner.
    fn strut(&self, k: usize) -> u64 {
        self.axis(2 * k) + 6
    }

    fn placement(&self, circle: usize) -> u64 {
        self.axis(circle) + 7 + (circle % 2) as u64
    }

    fn circle(&self, circle: usize, rims: usize) -> u64 {
        match circle.checked_sub(rims) {
            None => self.axis(circle) + 9 + (circle % 2) as u64,
            Some(k) => self.meridians + PER_MERIDIAN * k as u64 + 4,
        }
    }
}

/// How an edge runs on a patch: the map, v there, and the face's number.
type Mapped<'a> = (&'a RimMap, f64, usize);

/// For each edge of a node's part the patch that maps it.
fn maps<'a>(solid: &'a Solid, n: usize, part: &Part) -> Vec<Option<Mapped<'a>>> {
    let mut out = vec![None; part.edges.len()];
    for (f, face) in part.faces.iter().enumerate() {
        let Surface::Spline(s) = &face.surface else { continue };
        for ((_, edge), map) in part.arcs(face).zip(solid.rim_maps(n, s)) {
            out[(edge - part.first_edge()) as usize] = Some((map, s.knots[1][0], part.first_face() as usize + f));
        }
    }
    out
}

/// Entities of an edge.
fn edge_size(curve: &Curve, map: Option<&Mapped>) -> u64 {
    match curve {
        Curve::Line => 4,
        Curve::Arc(_) => 1 + map.map_or(0, |(map, ..)| map.us.len() as u64 + 4),
        Curve::Spline(_) => 2,
    }
}

/// Entities of a face, with its loop and surface.
fn face_size(solid: &Solid, face: &Face) -> u64 {
    face.boundary.len() as u64 + 3 + surface_size(solid, &face.surface)
}

/// Entities of a face's surface.
fn surface_size(solid: &Solid, surface: &Surface) -> u64 {
    match surface {
        Surface::Strut(k) if solid.slopes[*k] < 0.0 => 3,
        Surface::Plane { flipped: true, .. } | Surface::Sphere { flipped: true, .. } => 3,
        _ => 1,
    }
}

/// Write all entities of a solid but its style. `name` is quoted already.
pub fn write_solid(out: &mut (impl Write + Send), solid: &Solid, name: &str, ids: &Numbers, decimals: Decimals) -> io::Result<()> {
    let (nodes, struts) = (solid.nodes.len(), solid.struts.len());
    let per_node = (CHUNK * nodes / (solid.face_count() + 1)).max(1);
    let all = |t: &mut Vec<u8>, first: u32, points: &[DVec3]| {
        for (i, &p) in (first..).zip(points) {
            point(t, ids.point(i), p, decimals.points);
        }
    };
    let of_kind = |kind: usize| {
        move |n: usize, t: &mut Vec<u8>| {
            let (first, points) = solid.points(n, kind);
            all(t, first, &points);
        }
    };
    let first_extra = (solid.vertex_count() - solid.extra.len()) as u32;
    emit(out, nodes, per_node, of_kind(0))?;
    emit(out, solid.extra.len(), CHUNK, |i, t| all(t, first_extra + i as u32, &solid.extra[i..=i]))?;
    emit(out, nodes, per_node, of_kind(1))?;
    emit(out, nodes, per_node, of_kind(2))?;
    emit(out, solid.vertex_count(), CHUNK, |i, t| {
        entity(t, ids.vertex(i), "VERTEX_POINT('',");
        push_ref(t, ids.point(i as u32));
        end(t);
    })?;
    emit(out, struts, CHUNK, |k, t| rims(t, solid, k, ids))?;
    emit(out, solid.circles.len() - 2 * struts, CHUNK, |k, t| {
        meridian(t, ids.meridians + PER_MERIDIAN * k as u64, &solid.circles[2 * struts + k]);
    })?;
    emit(out, nodes, per_node, |n, t| {
        let part = solid.bordered(n);
        let maps = maps(solid, n, &part);
        for (e, map) in (part.first_edge()..).zip(maps) {
            match &part.edge(e).curve {
                Curve::Spline(s) => {
                    spline_curve(t, &part, s, ids.edges[e as usize] - 1, ids, decimals);
                    edge_curve(t, e, part.edge(e), ids.edges[e as usize] - 1, ids);
                }
                _ => circle_edge(t, solid, e, part.edge(e), map, ids, decimals),
            }
        }
    })?;
    emit(out, struts, CHUNK, |k, t| {
        for (e, edge) in (solid.first_strut_edge(k)..).zip(solid.strut_edges(k)) {
            match edge.curve {
                Curve::Line => seam(t, e, &edge, solid.seam_ends(k), ids),
                _ => circle_edge(t, solid, e, &edge, None, ids, decimals),
            }
        }
    })?;
    let mut t = vec![];
    for (e, edge) in (solid.first_strut_edge(struts)..).zip(solid.meridians()) {
        circle_edge(&mut t, solid, e, &edge, None, ids, decimals);
    }
    out.write_all(&t)?;
    emit(out, struts, CHUNK, |k, t| face(t, solid, k, &solid.strut_face(k), None, ids))?;
    let tails = Tails::new(solid, decimals);
    emit(out, nodes, per_node, |n, t| {
        let part = solid.part(n);
        for ((f, one), tail) in (part.first_face() as usize..).zip(&part.faces).zip(tails.of(solid, n, &part).iter()) {
            face(t, solid, f, one, Some((&part, tail)), ids);
        }
    })?;
    let mut t = vec![];
    entity(&mut t, ids.shell, "CLOSED_SHELL('',");
    // Connected order: OCC 7.6 looks through all faces before the next one that touches those it
    // has, so any other order costs it the square of the number of faces.
    push_list(&mut t, ids.order.iter().enumerate(), |t, (k, &face)| {
        // A line for every few references: some readers choke on very long lines.
        if k % 16 == 15 {
            t.push(b'\n');
        }
        push_ref(t, ids.faces[face as usize]);
    });
    end(&mut t);
    entity(&mut t, ids.brep, &format!("MANIFOLD_SOLID_BREP({name},#{}", ids.shell));
    end(&mut t);
    out.write_all(&t)
}

/// Format `count` items in parallel, `chunk` of them by one task, and write them in order, while the next ones are formatted.
fn emit(out: &mut (impl Write + Send), count: usize, chunk: usize, item: impl Fn(usize, &mut Vec<u8>) + Sync) -> io::Result<()> {
    let mut ready: Vec<Vec<u8>> = vec![];
    for batch in (0..count).step_by(chunk * TASKS) {
        let stop = count.min(batch + chunk * TASKS);
        let usual = ready.iter().map(Vec::len).max().unwrap_or(0);
        let format = |from: usize| {
            let mut text = Vec::with_capacity(usual);
            for i in from..stop.min(from + chunk) {
                item(i, &mut text);
            }
            text
        };
        let (written, next) = rayon::join(|| write_all(out, &ready), || (batch..stop).into_par_iter().step_by(chunk).map(format).collect());
        written?;
        ready = next;
    }
    write_all(out, &ready)
}

fn write_all(out: &mut impl Write, texts: &[Vec<u8>]) -> io::Result<()> {
    texts.iter().try_for_each(|text| out.write_all(text))
}

/// `#id=START`
#[inline]
fn entity(t: &mut Vec<u8>, id: u64, start: &str) {
    push_ref(t, id);
    t.push(b'=');
    t.extend_from_slice(start.as_bytes());
}

/// Closes an entity.
#[inline]
fn end(t: &mut Vec<u8>) {
    t.extend_from_slice(b");\n");
}

fn text(t: &mut Vec<u8>, s: &str) {
    t.extend_from_slice(s.as_bytes());
}

/// `,#id`
#[inline]
fn also(t: &mut Vec<u8>, id: u64) {
    t.push(b',');
    push_ref(t, id);
}

fn point(t: &mut Vec<u8>, id: u64, p: DVec3, decimals: Option<u32>) {
    entity(t, id, "CARTESIAN_POINT('',");
    push_list(t, p.to_array(), |t, x| push_rounded(t, x, decimals));
    end(t);
}

fn direction(t: &mut Vec<u8>, id: u64, d: DVec3) {
    entity(t, id, "DIRECTION('',");
    push_list(t, d.to_array(), push_real);
    end(t);
}

fn placement(t: &mut Vec<u8>, id: u64, center: u64, axis: u64, x: u64) {
    entity(t, id, "AXIS2_PLACEMENT_3D(''");
    [center, axis, x].into_iter().for_each(|part| also(t, part));
    end(t);
}

/// An entity of a placement and a radius.
fn round_thing(t: &mut Vec<u8>, id: u64, kind: &str, placement: u64, radius: f64) {
    entity(t, id, kind);
    text(t, "('',");
    push_ref(t, placement);
    t.push(b',');
    push_real(t, radius);
    end(t);
}

/// The circles of a strut's two rims; both share the strut's directions.
fn rims(t: &mut Vec<u8>, solid: &Solid, k: usize, ids: &Numbers) {
    let [a, b] = [2 * k, 2 * k + 1];
    let axis = ids.axis(a);
    direction(t, axis, solid.circles[a].axis);
    direction(t, axis + 1, solid.seams[k]);
    direction(t, axis + 2, solid.circles[a].x);
    direction(t, axis + 3, solid.circles[b].x);
    for c in [a, b] {
        point(t, ids.center(c), solid.circles[c].center, None);
    }
    if solid.slopes[k] >= 0.0 {
        placement(t, ids.strut(k), ids.center(a), axis, axis + 1);
    }
    for (c, x) in [(a, axis + 2), (b, axis + 3)] {
        placement(t, ids.placement(c), ids.center(c), axis, x);
    }
    for c in [a, b] {
        round_thing(t, ids.circle(c, 2 * solid.struts.len()), "CIRCLE", ids.placement(c), solid.circles[c].radius);
    }
}

fn meridian(t: &mut Vec<u8>, first: u64, c: &Circle) {
    direction(t, first, c.axis);
    direction(t, first + 1, c.x);
    point(t, first + 2, c.center, None);
    placement(t, first + 3, first + 2, first, first + 1);
    round_thing(t, first + 4, "CIRCLE", first + 3, c.radius);
}

/// The EDGE_CURVE of edge `e` on the curve entity.
fn edge_curve(t: &mut Vec<u8>, e: u32, edge: &Edge, curve: u64, ids: &Numbers) {
    entity(t, ids.edges[e as usize], "EDGE_CURVE(''");
    let [front, back] = edge.vertices.map(|v| ids.vertex(v as usize));
    [front, back, curve].into_iter().for_each(|part| also(t, part));
    text(t, ",.T.");
    end(t);
}

/// The seam of a strut.
fn seam(t: &mut Vec<u8>, e: u32, edge: &Edge, [front, back]: [DVec3; 2], ids: &Numbers) {
    let id = ids.edges[e as usize];
    direction(t, id - 3, (back - front).normalize());
    entity(t, id - 2, "VECTOR(''");
    also(t, id - 3);
    text(t, ",1.");
    end(t);
    entity(t, id - 1, "LINE(''");
    also(t, ids.point(edge.vertices[0]));
    also(t, id - 2);
    end(t);
    edge_curve(t, e, edge, id - 1, ids);
}

/// An arc, or a whole circle.
fn circle_edge(t: &mut Vec<u8>, solid: &Solid, e: u32, edge: &Edge, map: Option<Mapped>, ids: &Numbers, decimals: Decimals) {
    let Curve::Arc(circle) = edge.curve else { unreachable!("rims and meridians are circles") };
    let circle = ids.circle(circle, 2 * solid.struts.len());
    let curve = match map {
        Some(map) => surface_curve(t, map, circle, ids.edges[e as usize] - 1, ids, decimals),
        None => circle,
    };
    edge_curve(t, e, edge, curve, ids);
}

fn spline_curve(t: &mut Vec<u8>, part: &Part, s: &SplineCurve, id: u64, ids: &Numbers, decimals: Decimals) {
    let rational = is_rational(&s.weights);
    entity(t, id, if rational { "(BOUNDED_CURVE()B_SPLINE_CURVE(" } else { "B_SPLINE_CURVE_WITH_KNOTS(''," });
    push_integer(t, s.degree as u64);
    t.push(b',');
    push_list(t, &s.points, |t, &i| push_ref(t, ids.point(part.number(i))));
    text(t, ",.UNSPECIFIED.,.F.,.F.");
    text(t, if rational { ")B_SPLINE_CURVE_WITH_KNOTS(" } else { "," });
    knots(t, &[&s.knots]);
    if rational {
        text(t, ")CURVE()GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE(");
        push_list(t, &s.weights[..], |t, &w| push_rounded(t, w, decimals.weights));
        text(t, ")REPRESENTATION_ITEM('')");
    }
    end(t);
}

/// The SURFACE_CURVE number `id` of an arc: its circle, and its p-curve on the patch.
fn surface_curve(t: &mut Vec<u8>, (map, v, face): Mapped, circle: u64, id: u64, ids: &Numbers, decimals: Decimals) -> u64 {
    let first = id - 3 - map.us.len() as u64;
    for (k, &u) in map.us.iter().enumerate() {
        entity(t, first + k as u64, "CARTESIAN_POINT('',");
        push_list(t, [u, v], |t, x| push_rounded(t, x, decimals.weights));
        end(t);
    }
    entity(t, id - 3, "B_SPLINE_CURVE_WITH_KNOTS('',");
    push_integer(t, map.degree as u64);
    t.push(b',');
    push_list(t, first..id - 3, push_ref);
    text(t, ",.UNSPECIFIED.,.F.,.F.,");
    knots(t, &[&map.knots()]);
    end(t);
    entity(t, id - 2, &format!("DEFINITIONAL_REPRESENTATION('',(#{}),#29", id - 3));
    end(t);
    entity(t, id - 1, &format!("PCURVE('',#{},#{}", ids.faces[face] - 1, id - 2));
    end(t);
    entity(t, id, &format!("SURFACE_CURVE('',#{circle},(#{}),.CURVE_3D.", id - 1));
    end(t);
    id
}

/// Weights that are all one (up to a factor) say nothing.
fn is_rational(weights: &[f64]) -> bool {
    weights.iter().any(|&w| w != weights[0])
}

/// `multiplicities,knots,.UNSPECIFIED.` of each direction, multiplicities first.
fn knots(t: &mut Vec<u8>, all: &[&[f64]]) {
    let parts = |knots: &&[f64]| -> Vec<(f64, u64)> { knots.chunk_by(|a, b| a == b).map(|run| (run[0], run.len() as u64)).collect() };
    let runs: Vec<_> = all.iter().map(parts).collect();
    for run in &runs {
        push_list(t, run, |t, r| push_integer(t, r.1));
        t.push(b',');
    }
    for run in &runs {
        push_list(t, run, |t, r| push_real(t, r.0));
        t.push(b',');
    }
    text(t, ".UNSPECIFIED.");
}

/// Face number `f`; if it is a node's, with the node's part and the face's tail.
fn face(t: &mut Vec<u8>, solid: &Solid, f: usize, face: &Face, of_node: Option<(&Part, &[u8])>, ids: &Numbers) {
    let boundary = &face.boundary;
    let id = ids.faces[f];
    let first = id + 1 - face_size(solid, face);
    for (k, e) in boundary.iter().enumerate() {
        entity(t, first + k as u64, "ORIENTED_EDGE('',*,*");
        also(t, ids.edges[e.edge as usize]);
        text(t, if e.forward { ",.T." } else { ",.F." });
        end(t);
    }
    let wire = first + boundary.len() as u64;
    entity(t, wire, "EDGE_LOOP('',");
    push_list(t, first..wire, push_ref);
    end(t);
    entity(t, wire + 1, "FACE_OUTER_BOUND(''");
    also(t, wire);
    text(t, ",.T.");
    end(t);
    match (&face.surface, of_node) {
        (Surface::Spline(s), Some((part, tail))) => spline_surface(t, part, s, wire + 2, ids, tail),
        _ => surface(t, solid, &face.surface, wire + 2, ids),
    }
    entity(t, id, &format!("ADVANCED_FACE('{}',(#{}),#{},.T.", face.label, wire + 1, id - 1));
    end(t);
}

/// The surface's entities from number `first` on; the last one is the surface.
fn surface(t: &mut Vec<u8>, solid: &Solid, surface: &Surface, first: u64, ids: &Numbers) {
    // A placement with the axis of this circle, or with the opposite axis.
    let oriented = |t: &mut Vec<u8>, circle: usize, flipped: bool| -> (u64, u64) {
        if !flipped {
            return (ids.placement(circle), first);
        }
        direction(t, first, -solid.circles[circle].axis);
        placement(t, first + 1, ids.center(circle), first, ids.axis(circle) + 1);
        (first + 1, first + 2)
    };
    match surface {
        Surface::Strut(k) => {
            let slope = solid.slopes[*k];
            // At the rim from which the radius grows: the half-angle of Part 42 is above 0.
            let (placement, id, rim) = if slope < 0.0 {
                let (placement, id) = oriented(t, 2 * k + 1, true);
                (placement, id, solid.rim(*k, 1))
            } else {
                (ids.strut(*k), first, solid.rim(*k, 0))
            };
            if slope == 0.0 {
                round_thing(t, id, "CYLINDRICAL_SURFACE", placement, rim.radius);
            } else {
                entity(t, id, "CONICAL_SURFACE(''");
                also(t, placement);
                for number in [rim.radius, slope.abs().atan()] {
                    t.push(b',');
                    push_real(t, number);
                }
                end(t);
            }
        }
        Surface::Plane { circle, flipped } => {
            let (placement, id) = oriented(t, *circle, *flipped);
            entity(t, id, "PLANE(''");
            also(t, placement);
            end(t);
        }
        Surface::Sphere { circle, flipped } => {
            let (placement, id) = oriented(t, *circle, *flipped);
            round_thing(t, id, "SPHERICAL_SURFACE", placement, solid.circles[*circle].radius);
        }
        Surface::Spline(_) => unreachable!("patches are a node's"),
    }
}

fn spline_surface(t: &mut Vec<u8>, part: &Part, s: &SplineSurface, id: u64, ids: &Numbers, tail: &[u8]) {
    let columns = s.knots[1].len() - s.degree[1] - 1;
    entity(t, id, if is_rational(&s.weights) { "(BOUNDED_SURFACE()B_SPLINE_SURFACE(" } else { "B_SPLINE_SURFACE_WITH_KNOTS(''," });
    for d in s.degree {
        push_integer(t, d as u64);
        t.push(b',');
    }
    push_list(t, s.points.chunks(columns), |t, row| push_list(t, row, |t, &i| push_ref(t, ids.point(part.number(i)))));
    t.extend_from_slice(tail);
}

/// What follows the points of a patch: knots and weights.
fn surface_tail(s: &SplineSurface, decimals: Decimals) -> Vec<u8> {
    let rational = is_rational(&s.weights);
    let columns = s.knots[1].len() - s.degree[1] - 1;
    let mut t = vec![];
    text(&mut t, ",.UNSPECIFIED.,.F.,.F.,.F.");
    text(&mut t, if rational { ")B_SPLINE_SURFACE_WITH_KNOTS(" } else { "," });
    knots(&mut t, &[&s.knots[0], &s.knots[1]]);
    if rational {
        text(&mut t, ")GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(");
        push_list(&mut t, s.weights.chunks(columns), |t, row| push_list(t, row, |t, &w| push_rounded(t, w, decimals.weights)));
        text(&mut t, ")REPRESENTATION_ITEM('')SURFACE()");
    }
    end(&mut t);
    t
}

/// The tails of a node's patches (see [`surface_tail`]), formatted once for nodes of one skin.
struct Tails {
    decimals: Decimals,
    /// By the place of a skin that several nodes have.
    shared: HashMap<(usize, u64), OnceLock<Vec<Vec<u8>>>>,
}

impl Tails {
    /// Skins whose tails are kept, some 30 MB.
    const MOST: usize = 512;

    fn new(solid: &Solid, decimals: Decimals) -> Tails {
        let mut places: Vec<_> = (0..solid.nodes.len()).map(|n| solid.skin_place(n)).collect();
        places.sort_unstable();
        let several = places.chunk_by(|a, b| a == b).filter(|same| same.len() > 1);
        Tails { decimals, shared: several.take(Self::MOST).map(|same| (same[0], OnceLock::new())).collect() }
    }

    /// The tail of each face of the n-th node's part, in order; empty where the face is no patch.
    fn of(&self, solid: &Solid, n: usize, part: &Part) -> Cow<'_, [Vec<u8>]> {
        let tail = |face: &Face| match &face.surface {
            Surface::Spline(s) => surface_tail(s, self.decimals),
            _ => vec![],
        };
        let format = || part.faces.iter().map(tail).collect::<Vec<_>>();
        match self.shared.get(&solid.skin_place(n)) {
            Some(kept) => Cow::Borrowed(kept.get_or_init(format)),
            None => Cow::Owned(format()),
        }
    }
}
