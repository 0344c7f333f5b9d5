//! Skins against struts that do not end at their node, and against each other.

mod common;

use common::{Random, flat, random, v};
use glam::DVec3;
use lattice_brep::brep::{Caps, Crossing, Face, Model, Other, Solid, Surface, crossings};
use lattice_brep::error::Error;
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::check::Overlaps;
use lattice_brep::graph::proximity::near_misses;
use lattice_brep::graph::{Graph, Lattice, Strut};
use lattice_brep::ids::{NodeId, StrutId};
use lattice_brep::options::{OnConflict, Options};
use lattice_brep::pipeline::{Silent, solve};

/// A lattice as a user of the library can make it, without the checks of the input.
#[derive(Clone, Default)]
struct Draft {
    nodes: Vec<DVec3>,
    struts: Vec<Strut>,
}

impl Draft {
    /// A node with struts of this length and radius in these directions.
    fn fan(mut self, at: DVec3, axes: &[DVec3], length: f64, radius: f64) -> Draft {
        let a = NodeId(self.nodes.len() as u32);
        self.nodes.push(at);
        for axis in axes {
            self.struts.push(Strut { a, b: NodeId(self.nodes.len() as u32), ra: radius, rb: radius });
            self.nodes.push(at + length * axis.normalize());
        }
        self
    }

    /// A strut by itself.
    fn strut(self, from: DVec3, to: DVec3, radius: f64) -> Draft {
        self.fan(from, &[to - from], from.distance(to), radius)
    }

    fn scaled(mut self, scale: f64, by: f64) -> Draft {
        self.nodes.iter_mut().for_each(|p| *p = *p * scale + DVec3::splat(by));
        self.struts.iter_mut().for_each(|s| (s.ra, s.rb) = (s.ra * scale, s.rb * scale));
        self
    }

    fn lattice(self) -> Lattice {
        Lattice { name: None, graph: Graph::new(self.nodes, self.struts), notes: vec![] }
    }

    fn model(self, caps: Caps) -> Model {
        let options = Options { overlaps: Overlaps::Keep, caps, ..Options::default() };
        solve(&self.lattice(), &options, &Silent).unwrap_or_else(|e| panic!("{e}")).model
    }

    fn crossings(self) -> Vec<Crossing> {
        crossings(&self.model(Caps::Flat))
    }
}

/// Two struts of radius 1 at 60°. Their cylinders part 2 mm from the node, the skin between them reaches farther.
fn crotch() -> Draft {
    Draft::default().fan(DVec3::ZERO, &[flat(-30.0), flat(30.0)], 10.0, 1.0)
}

/// The crotch with a thin strut across it, at this distance from the node.
fn pierced(distance: f64) -> Draft {
    crotch().strut(v(distance, 0.0, -5.0), v(distance, 0.0, 5.0), 0.02)
}

/// How far the skin of the crotch reaches along the bisector (mm).
fn reach_of_crotch() -> f64 {
    let [solid] = &crotch().model(Caps::Flat).solids[..] else { panic!("one solid") };
    points(solid, 0, 65).filter(|p| p.y.abs() < 0.01 && p.z.abs() < 0.05).map(|p| p.x).fold(0.0, f64::max)
}

/// Points of the skin of the solid's `n`-th node: a square of them on each patch.
fn points(solid: &Solid, n: usize, count: usize) -> impl Iterator<Item = DVec3> {
    let at = move |k: usize| k as f64 / (count - 1) as f64;
    let part = solid.part(n);
    let surface = |face: &Face| if let Surface::Spline(s) = &face.surface { Some(part.spline_surface(s, DVec3::ZERO)) } else { None };
    let patches: Vec<_> = part.faces.iter().filter_map(surface).collect();
    patches.into_iter().flat_map(move |s| (0..count * count).map(move |k| s.point(at(k / count), at(k % count))))
}

#[test]
fn blocks_of_cells_pass() {
    for cell in [Cell::Bcc, Cell::Octet, Cell::Kelvin] {
        let lattice = Lattice { name: None, graph: generate(cell, 10.0, [2; 3], 0.5).unwrap(), notes: vec![] };
        let solved = solve(&lattice, &Options::default(), &Silent).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(crossings(&solved.model), []);
        assert!(solved.report.changes.is_empty());
    }
}

#[test]
fn a_strut_through_the_fillet_of_another_node_is_found() {
    let reach = reach_of_crotch();
    assert!(reach > 2.1, "the fillet reaches {reach} mm");
    for (distance, crosses) in [(reach - 0.05, true), (reach + 0.01, true), (reach + 0.04, false), (reach + 0.2, false)] {
        let draft = pierced(distance);
        assert!(near_misses(&draft.clone().lattice().graph).is_empty(), "clear of both cylinders");
        let refused = solve(&draft.clone().lattice(), &Options::default(), &Silent);
        let found = draft.crossings();
        if !crosses {
            assert_eq!(found, [], "{distance} mm");
            assert!(refused.is_ok());
            continue;
        }
        let [Crossing { node: NodeId(0), other: Other::Strut(StrutId(2)), at, clearance }] = found[..] else { panic!("{distance} mm: {found:?}") };
        assert!(at.distance(v(distance, 0.0, 0.0)) < 0.3, "at {at}");
        assert!((clearance - (distance - reach - 0.02).max(-0.02)).abs() < 0.004, "{clearance} at {distance} mm, the fillet reaches {reach}");
        let Err(Error::CannotBuild { reasons }) = refused else { panic!("not refused") };
        assert!(reasons[0].starts_with("node 0: its skin crosses strut 2, which does not end there, "), "{}", reasons[0]);
    }
}

/// Where crossings are kept they are notes of the report.
#[test]
fn kept_where_overlaps_are_kept() {
    let options = Options { overlaps: Overlaps::Keep, ..Options::default() };
    let report = solve(&pierced(2.07).lattice(), &options, &Silent).unwrap_or_else(|e| panic!("{e}")).report;
    let [note] = &report.changes[..] else { panic!("{:?}", report.changes) };
    assert_eq!(note.path, "nodes[0]");
    assert!(note.what.starts_with("its skin crosses strut 2,") && note.what.ends_with(": kept"), "{}", note.what);
}

#[test]
fn skins_of_near_nodes_are_found() {
    let cross = [0.0, 90.0, 180.0, 270.0].map(flat);
    let two = |apart: f64| {
        let found = Draft::default().fan(DVec3::ZERO, &cross, 10.0, 1.0).fan(v(0.0, 0.0, apart), &cross, 10.0, 1.0).crossings();
        found.into_iter().find(|c| c.other == Other::Node(NodeId(5)))
    };
    let found = two(1.5).expect("the skins cross");
    assert_eq!(found.node, NodeId(0));
    assert!((-0.6..-0.2).contains(&found.clearance), "{}", found.clearance);
    assert_eq!(two(2.3), None);
}

/// A round cap reaches into the fillet where a flat one does not.
#[test]
fn shrinking_parts_skins_from_what_they_meet() {
    let options = Options { on_conflict: OnConflict::Shrink { part: true }, ..Options::default() };
    // the struts at the node give near it, not the thin one; their far ends stay
    let solved = solve(&pierced(2.07).lattice(), &options, &Silent).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(crossings(&solved.model), []);
    let shrunk = &solved.report.cuts.shrunk;
    assert!(!shrunk.is_empty() && shrunk.iter().all(|s| s.strut.0 < 2 && s.after_mm[0] < s.after_mm[1]), "{shrunk:?}");
}

#[test]
fn round_caps_count() {
    let from = v(reach_of_crotch() + 0.01, 0.0, 0.0);
    let draft = crotch().strut(from, from + 5.0 * DVec3::X, 0.02);
    assert_eq!(crossings(&draft.clone().model(Caps::Flat)), []);
    let found = crossings(&draft.model(Caps::Sphere));
    assert_eq!(found.iter().map(|c| (c.node, c.other)).collect::<Vec<_>>(), [(NodeId(0), Other::Strut(StrutId(2)))]);
    assert!((found[0].clearance + 0.01).abs() < 0.004, "{}", found[0].clearance);
}

/// A solid wholly within the fillet meets no patch, and is found all the same.
#[test]
fn a_solid_within_a_fillet_is_found() {
    let middle = v(1.0 + 0.5 * reach_of_crotch(), 0.0, 0.0);
    let draft = crotch().strut(middle - 0.02 * DVec3::Z, middle + 0.02 * DVec3::Z, 0.01);
    assert!(near_misses(&draft.clone().lattice().graph).is_empty(), "outside of both cylinders");
    let found = draft.crossings();
    assert_eq!(found.iter().map(|c| (c.node, c.other)).collect::<Vec<_>>(), [(NodeId(0), Other::Strut(StrutId(2)))]);
    assert!(found[0].clearance < 0.0);
}

/// Sampled points of the skins against the struts' cylinders.
#[test]
fn samples_agree() {
    let (mut crossing, mut clear) = (0, 0);
    for seed in 1..=12 {
        let mut numbers = Random::new(900 + seed);
        let mut draft = Draft::default().fan(DVec3::ZERO, &random(seed, 3 + seed as usize % 4, 40.0), 12.0, 1.0);
        for _ in 0..15 {
            let middle = (1.0 + 2.5 * numbers.next()) * numbers.direction();
            let along = (0.2 + 4.0 * numbers.next()) * numbers.direction();
            draft = draft.strut(middle - along, middle + along, 0.02 + 0.3 * numbers.next());
        }
        let model = draft.model(Caps::Flat);
        let found = crossings(&model);
        let skin: Vec<DVec3> = points(&model.solids[0], 0, 41).collect();
        for solid in &model.solids[1..] {
            let [a, b] = [solid.rim(0, 0), solid.rim(0, 1)];
            // depth below the nearest of the strut's faces; below zero outside of it
            let depth = |p: &DVec3| {
                let (height, aside) = ((p - a.center).dot(a.axis), (p - a.center).reject_from_normalized(a.axis).length());
                (a.radius - aside).min(height).min(a.center.distance(b.center) - height)
            };
            let deepest = skin.iter().map(depth).fold(f64::NEG_INFINITY, f64::max);
            let hit = found.iter().find(|c| c.node == NodeId(0) && c.other == Other::Strut(solid.struts[0]));
            match hit {
                Some(_) if deepest > 0.0 => crossing += 1,
                // between the samples, or wholly inside
                Some(hit) => assert!(deepest > -0.04 || hit.at == a.center, "seed {seed}: {hit:?}, samples {} mm away", -deepest),
                None => {
                    assert!(deepest <= 0.0, "seed {seed}: strut {} missed, {deepest} mm deep", solid.struts[0].0);
                    clear += 1;
                }
            }
        }
    }
    assert!(crossing > 30 && clear > 30, "{crossing} cross, {clear} do not");
}

#[test]
fn scale_and_place_do_not_matter() {
    let [plain] = pierced(2.07).crossings()[..] else { panic!("one crossing") };
    for (scale, by) in [(1e-3, 0.0), (1e3, 0.0), (1.0, 1e5), (1e-3, 1e3)] {
        let found = pierced(2.07).scaled(scale, by).crossings();
        let [other] = found[..] else { panic!("{found:?}, scaled by {scale}, moved by {by}") };
        assert_eq!((other.node, other.other), (plain.node, plain.other));
        assert!((other.clearance / scale - plain.clearance).abs() < 1e-5, "{other:?}, scaled by {scale}, moved by {by}");
        assert_eq!(pierced(2.2).scaled(scale, by).crossings(), []);
    }
}
