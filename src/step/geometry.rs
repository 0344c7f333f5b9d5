//! Streams one solid. Every entity's number follows from counts alone, so that pieces can be
//! formatted in parallel and written in order: points, vertices, circles, edges, faces, shell.

use super::text::{push_integer, push_list, push_real, push_ref, round};
use crate::brep::topology::connected_order;
use crate::brep::{Circle, Curve, RimMap, Solid, SplineSurface, Surface};
use glam::DVec3;
use rayon::prelude::*;
use std::io::{self, Write};

/// Entities of a strut's two rims: axis, x of the seam and of both rims, both centres, placements
/// of the strut's surface and of both circles, both circles.
const PER_RIMS: u64 = 11;
/// Entities of a meridian: axis, x, centre, placement, circle.
const PER_MERIDIAN: u64 = 5;
/// Items formatted by one task, and tasks in flight: some 10 MB of text at a time.
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
    /// The face and the place in its `rim` that map each edge, for rim arcs on patches.
    maps: Vec<Option<(u32, u8)>>,
    /// Number of each ADVANCED_FACE; its loop and surface are numbered just before it.
    faces: Vec<u64>,
    pub shell: u64,
    pub brep: u64,
    pub styled: u64,
}

impl Numbers {
    /// Numbers for a solid whose first entity is `first`; the next free number is `styled + 1`.
    pub fn new(solid: &Solid, first: u64) -> Self {
        let shell = solid.shell();
        let points = first;
        let vertices = points + solid.points.len() as u64;
        let circles = vertices + shell.vertices.len() as u64;
        let struts = solid.struts.len() as u64;
        let meridians = circles + PER_RIMS * struts;
        let mut next = meridians + PER_MERIDIAN * (solid.circles.len() as u64 - 2 * struts);
        let mut take = |count: u64| {
            next += count;
            next - 1
        };
        let maps = rim_maps(solid);
        let edge_size = |(e, curve): (usize, &Curve)| match curve {
            Curve::Line => 4,
            Curve::Arc(_) => 1 + maps[e].map_or(0, |m| rim_map(solid, m).us.len() as u64 + 4),
            Curve::Spline(_) => 2,
        };
        let edges = shell.edges.iter().map(|e| &e.curve).enumerate().map(|e| take(edge_size(e))).collect();
        let faces = shell.faces.iter().map(|f| take(f.boundaries[0].len() as u64 + 3 + surface_size(solid, &f.surface))).collect();
        let (shell, brep, styled) = (take(1), take(1), take(1));
        Numbers { points, vertices, circles, meridians, edges, maps, faces, shell, brep, styled }
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

/// For each edge the patch that maps it, and the place in that patch's `rim`.
fn rim_maps(solid: &Solid) -> Vec<Option<(u32, u8)>> {
    let mut out = vec![None; solid.shell().edges.len()];
    for (f, face) in solid.faces().iter().enumerate() {
        let Surface::Spline(s) = &face.surface else { continue };
        for (k, e) in face.boundaries[0].iter().take(s.rim.len()).enumerate() {
            out[e.index] = Some((f as u32, k as u8));
        }
    }
    out
}

fn rim_map(solid: &Solid, (face, k): (u32, u8)) -> &RimMap {
    let Surface::Spline(s) = &solid.faces()[face as usize].surface else { unreachable!("only patches map rims") };
    &s.rim[k as usize]
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
pub fn write_solid(out: &mut impl Write, solid: &Solid, name: &str, ids: &Numbers, decimals: Option<u32>) -> io::Result<()> {
    let shell = solid.shell();
    emit(out, solid.points.len(), |i, t| point(t, ids.point(i as u32), solid.points[i], decimals))?;
    emit(out, shell.vertices.len(), |i, t| {
        entity(t, ids.vertex(i), "VERTEX_POINT('',");
        push_ref(t, ids.point(i as u32));
        end(t);
    })?;
    emit(out, solid.struts.len(), |k, t| rims(t, solid, k, ids))?;
    let first = 2 * solid.struts.len();
    emit(out, solid.circles.len() - first, |k, t| {
        meridian(t, ids.meridians + PER_MERIDIAN * k as u64, &solid.circles[first + k]);
    })?;
    emit(out, shell.edges.len(), |e, t| edge(t, solid, e, ids))?;
    emit(out, shell.faces.len(), |f, t| face(t, solid, f, ids))?;
    let mut t = vec![];
    entity(&mut t, ids.shell, "CLOSED_SHELL('',");
    // Connected order: OCC 7.6 looks through all faces before the next one that touches those it
    // has, so any other order costs it the square of the number of faces.
    push_list(&mut t, connected_order(solid).into_iter().enumerate(), |t, (k, face)| {
        // A line for every few references: some readers choke on very long lines.
        if k % 16 == 15 {
            t.push(b'\n');
        }
        push_ref(t, ids.faces[face]);
    });
    end(&mut t);
    entity(&mut t, ids.brep, &format!("MANIFOLD_SOLID_BREP({name},#{}", ids.shell));
    end(&mut t);
    out.write_all(&t)
}

/// Format `count` items in parallel, write them in order.
fn emit(out: &mut impl Write, count: usize, item: impl Fn(usize, &mut Vec<u8>) + Sync) -> io::Result<()> {
    for batch in (0..count).step_by(CHUNK * TASKS) {
        let stop = count.min(batch + CHUNK * TASKS);
        let chunks: Vec<Vec<u8>> = (batch..stop)
            .into_par_iter()
            .step_by(CHUNK)
            .map(|from| {
                let mut text = vec![];
                for i in from..stop.min(from + CHUNK) {
                    item(i, &mut text);
                }
                text
            })
            .collect();
        for chunk in chunks {
            out.write_all(&chunk)?;
        }
    }
    Ok(())
}

/// `#id=START`
fn entity(t: &mut Vec<u8>, id: u64, start: &str) {
    push_ref(t, id);
    t.push(b'=');
    t.extend_from_slice(start.as_bytes());
}

/// Closes an entity.
fn end(t: &mut Vec<u8>) {
    t.extend_from_slice(b");\n");
}

fn text(t: &mut Vec<u8>, s: &str) {
    t.extend_from_slice(s.as_bytes());
}

/// `,#id`
fn also(t: &mut Vec<u8>, id: u64) {
    t.push(b',');
    push_ref(t, id);
}

fn point(t: &mut Vec<u8>, id: u64, p: DVec3, decimals: Option<u32>) {
    entity(t, id, "CARTESIAN_POINT('',");
    push_list(t, p.to_array(), |t, x| push_real(t, round(x, decimals)));
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

fn edge(t: &mut Vec<u8>, solid: &Solid, e: usize, ids: &Numbers) {
    let edge = &solid.shell().edges[e];
    let id = ids.edges[e];
    let (front, back) = edge.vertices;
    let curve = match &edge.curve {
        Curve::Line => {
            let d = (solid.points[back] - solid.points[front]).normalize();
            direction(t, id - 3, d);
            entity(t, id - 2, "VECTOR(''");
            also(t, id - 3);
            text(t, ",1.");
            end(t);
            entity(t, id - 1, "LINE(''");
            also(t, ids.point(front as u32));
            also(t, id - 2);
            end(t);
            id - 1
        }
        Curve::Arc(circle) => {
            let circle = ids.circle(*circle, 2 * solid.struts.len());
            match ids.maps[e] {
                Some(map) => surface_curve(t, solid, map, circle, id - 1, ids),
                None => circle,
            }
        }
        Curve::Spline(s) => {
            let rational = is_rational(&s.weights);
            entity(t, id - 1, if rational { "(BOUNDED_CURVE()B_SPLINE_CURVE(" } else { "B_SPLINE_CURVE_WITH_KNOTS(''," });
            push_integer(t, s.degree as u64);
            t.push(b',');
            push_list(t, &s.points, |t, &i| push_ref(t, ids.point(i)));
            text(t, ",.UNSPECIFIED.,.F.,.F.");
            text(t, if rational { ")B_SPLINE_CURVE_WITH_KNOTS(" } else { "," });
            knots(t, &[&s.knots]);
            if rational {
                text(t, ")CURVE()GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE(");
                push_list(t, &s.weights, |t, &w| push_real(t, w));
                text(t, ")REPRESENTATION_ITEM('')");
            }
            end(t);
            id - 1
        }
    };
    entity(t, id, "EDGE_CURVE(''");
    [ids.vertex(front), ids.vertex(back), curve].into_iter().for_each(|part| also(t, part));
    text(t, ",.T.");
    end(t);
}

/// The SURFACE_CURVE number `id` of an arc: its circle, and its p-curve on the patch.
fn surface_curve(t: &mut Vec<u8>, solid: &Solid, at: (u32, u8), circle: u64, id: u64, ids: &Numbers) -> u64 {
    let map = rim_map(solid, at);
    let first = id - 3 - map.us.len() as u64;
    for (k, &u) in map.us.iter().enumerate() {
        entity(t, first + k as u64, "CARTESIAN_POINT('',");
        push_list(t, [u, map.v], push_real);
        end(t);
    }
    entity(t, id - 3, "B_SPLINE_CURVE_WITH_KNOTS('',");
    push_integer(t, map.degree as u64);
    t.push(b',');
    push_list(t, first..id - 3, push_ref);
    text(t, ",.UNSPECIFIED.,.F.,.F.,");
    knots(t, &[&map.knots]);
    end(t);
    entity(t, id - 2, &format!("DEFINITIONAL_REPRESENTATION('',(#{}),#29", id - 3));
    end(t);
    entity(t, id - 1, &format!("PCURVE('',#{},#{}", ids.faces[at.0 as usize] - 1, id - 2));
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

fn face(t: &mut Vec<u8>, solid: &Solid, f: usize, ids: &Numbers) {
    let face = &solid.shell().faces[f];
    let boundary = &face.boundaries[0];
    let id = ids.faces[f];
    let first = id + 1 - (boundary.len() as u64 + 3 + surface_size(solid, &face.surface));
    for (k, e) in boundary.iter().enumerate() {
        entity(t, first + k as u64, "ORIENTED_EDGE('',*,*");
        also(t, ids.edges[e.index]);
        text(t, if e.orientation { ",.T." } else { ",.F." });
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
    surface(t, solid, &face.surface, wire + 2, ids);
    entity(t, id, &format!("ADVANCED_FACE('{}',(#{}),#{},.T.", solid.labels[f], wire + 1, id - 1));
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
        Surface::Spline(s) => spline_surface(t, s, first, ids),
    }
}

fn spline_surface(t: &mut Vec<u8>, s: &SplineSurface, id: u64, ids: &Numbers) {
    let rational = is_rational(&s.weights);
    let columns = s.knots[1].len() - s.degree[1] - 1;
    entity(t, id, if rational { "(BOUNDED_SURFACE()B_SPLINE_SURFACE(" } else { "B_SPLINE_SURFACE_WITH_KNOTS(''," });
    for d in s.degree {
        push_integer(t, d as u64);
        t.push(b',');
    }
    push_list(t, s.points.chunks(columns), |t, row| push_list(t, row, |t, &i| push_ref(t, ids.point(i))));
    text(t, ",.UNSPECIFIED.,.F.,.F.,.F.");
    text(t, if rational { ")B_SPLINE_SURFACE_WITH_KNOTS(" } else { "," });
    knots(t, &[&s.knots[0], &s.knots[1]]);
    if rational {
        text(t, ")GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(");
        push_list(t, s.weights.chunks(columns), |t, row| push_list(t, row, |t, &w| push_real(t, w)));
        text(t, ")REPRESENTATION_ITEM('')SURFACE()");
    }
    end(t);
}
