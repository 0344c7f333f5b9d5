//! From skins to closed solids: counts, checks that hold, and each check broken on purpose.

mod skins;

use glam::DVec3;
use lattice_brep::brep::*;
use lattice_brep::graph::Graph;
use lattice_brep::ids::{NodeId, StrutId};
use lattice_brep::patch::Skin;
use std::f64::consts::PI;

const SPHERE: AssembleOptions = AssembleOptions { caps: Caps::Sphere };

fn build(case: &(Graph, Vec<Option<Skin>>), options: &AssembleOptions) -> Model {
    let model = assemble(&case.0, &skins::borrowed(&case.1), options).unwrap();
    check_topology(&model).unwrap();
    model
}

fn single() -> (Graph, Vec<Option<Skin>>) {
    skins::row(DVec3::ZERO, DVec3::new(1.0, 2.0, 2.0), 6.0, 0.5, &[])
}

/// Seams: capped to tube, same azimuths, other azimuths, almost the same azimuths, tube to capped.
fn long() -> (Graph, Vec<Option<Skin>>) {
    let turns = [(4, 0.1), (4, 0.1), (5, 0.3), (5, 0.301), (3, 0.0)];
    skins::row(DVec3::new(5.0, -3.0, 1.0), DVec3::new(1.0, 0.3, -0.2), 4.0, 0.5, &turns)
}

#[test]
fn a_single_strut_has_two_vertices_three_edges_three_faces() {
    let model = build(&single(), &AssembleOptions::default());
    assert_eq!(Counts::of(&model.solids[0]), Counts { vertices: 2, edges: 3, faces: 3 });
    let round = build(&single(), &SPHERE);
    assert_eq!(Counts::of(&round.solids[0]), Counts { vertices: 4, edges: 5, faces: 3 });
}

#[test]
fn measures_of_a_single_strut_are_closed_forms() {
    let (r, l) = (0.5, 6.0);
    let middle = DVec3::new(1.0, 2.0, 2.0);
    let flat = measure(&build(&single(), &AssembleOptions::default()).solids[0]).unwrap();
    assert!((flat.volume - PI * r * r * l).abs() < 1e-14);
    assert!((flat.area - 2.0 * PI * r * (l + r)).abs() < 1e-14);
    assert!(flat.centroid.distance(middle) < 1e-14);
    let round = measure(&build(&single(), &SPHERE).solids[0]).unwrap();
    assert!((round.volume - PI * r * r * (l + 4.0 / 3.0 * r)).abs() < 1e-14);
    assert!((round.area - 2.0 * PI * r * (l + 2.0 * r)).abs() < 1e-14);
    assert!(round.centroid.distance(middle) < 1e-14);
}

#[test]
fn a_row_of_tubes_is_one_cylinder() {
    let model = build(&long(), &AssembleOptions::default());
    let solid = &model.solids[0];
    let (r, l) = (0.5, 24.0);
    let m = measure(solid).unwrap();
    assert!((m.volume / (PI * r * r * l) - 1.0).abs() < 1e-12, "{m:?}");
    assert!((m.area / (2.0 * PI * r * (l + r)) - 1.0).abs() < 1e-9, "{m:?}");
    let middle = DVec3::new(5.0, -3.0, 1.0) + DVec3::new(1.0, 0.3, -0.2).normalize() * 12.0;
    assert!(m.centroid.distance(middle) < 1e-12);
    assert_eq!(solid.labels.len(), 6 + 2 * (4 + 4 + 5 + 5 + 3) + 2);
    assert_eq!(solid.circles.len(), 12);
    let q = quality(&model, 9, &[]);
    assert!(q.gap_mm.value < 1e-14 && q.rim_jump_deg.value < 1e-12 && q.inner_jump_deg.value < 1e-12, "{q:?}");
    assert!(q.facing.value > 0.8, "{q:?}");
    let limits = QualityLimits { rim_jump_deg: 1e-9, inner_jump_deg: 1e-9, gap_mm: 1e-12, facing: 0.0 };
    q.check(&limits).unwrap();
}

/// Volume, area of the side and height of the centroid of a frustum of length `l`.
fn frustum(a: f64, b: f64, l: f64) -> (f64, f64, f64) {
    let squares = a * a + a * b + b * b;
    (PI * l / 3.0 * squares, PI * (a + b) * (l * l + (b - a) * (b - a)).sqrt(), l / 4.0 * (a * a + 2.0 * a * b + 3.0 * b * b) / squares)
}

/// Radii of a row of six struts: cones that grow and shrink, steep and flat, and a cylinder.
const RADII: [f64; 7] = [0.3, 0.5, 0.5, 1.4, 0.9, 0.8, 0.801];

fn tapered() -> (Graph, Vec<Option<Skin>>) {
    let turns = [(4, 0.1), (4, 0.1), (5, 0.3), (5, 0.301), (3, 0.0)];
    skins::tapered_row(DVec3::new(5.0, -3.0, 1.0), DVec3::new(1.0, 0.3, -0.2), 4.0, &RADII, &turns)
}

#[test]
fn measures_of_a_single_tapered_strut_are_closed_forms() {
    let d = DVec3::new(1.0, 2.0, 2.0) / 3.0;
    for (a, b) in [(0.5, 0.8), (0.8, 0.5), (0.2, 2.0), (0.5, 0.5 + 1e-9)] {
        let case = skins::tapered_row(DVec3::ZERO, d, 6.0, &[a, b], &[]);
        let (volume, side, height) = frustum(a, b, 6.0);
        let model = build(&case, &AssembleOptions::default());
        assert_eq!(Counts::of(&model.solids[0]), Counts { vertices: 2, edges: 3, faces: 3 });
        assert_eq!([0, 1].map(|end| model.solids[0].rim(0, end).radius), [a, b]);
        assert!((model.solids[0].slopes[0] - (b - a) / 6.0).abs() < 1e-15);
        let flat = measure(&model.solids[0]).unwrap();
        assert!((flat.volume / volume - 1.0).abs() < 1e-14);
        assert!((flat.area / (side + PI * (a * a + b * b)) - 1.0).abs() < 1e-14);
        assert!(flat.centroid.distance(d * height) < 1e-14);
        let round = measure(&build(&case, &SPHERE).solids[0]).unwrap();
        let balls = [a, b].map(|r: f64| 2.0 / 3.0 * PI * r.powi(3));
        assert!((round.volume / (volume + balls[0] + balls[1]) - 1.0).abs() < 1e-14);
        assert!((round.area / (side + 2.0 * PI * (a * a + b * b)) - 1.0).abs() < 1e-14);
        let moment = volume * height - balls[0] * 0.375 * a + balls[1] * (6.0 + 0.375 * b);
        assert!(round.centroid.distance(d * (moment / round.volume)) < 1e-14);
    }
}

/// Ends of equal radius are a cylinder, and a cone that is almost one has its measures.
#[test]
fn a_cone_without_taper_is_a_cylinder() {
    let of = |b: f64| measure(&build(&skins::tapered_row(DVec3::ZERO, DVec3::X, 6.0, &[0.5, b], &[]), &SPHERE).solids[0]).unwrap();
    let (exact, near) = (of(0.5), of(0.5 + 1e-12));
    assert!((near.volume / exact.volume - 1.0).abs() < 1e-11 && (near.area / exact.area - 1.0).abs() < 1e-11);
    assert!(near.centroid.distance(exact.centroid) < 1e-11);
}

#[test]
fn a_row_of_cones_and_cylinders_is_its_frusta() {
    let model = build(&tapered(), &AssembleOptions::default());
    let solid = &model.solids[0];
    let (mut volume, mut area, mut moment) = (0.0, PI * (RADII[0] * RADII[0] + RADII[6] * RADII[6]), 0.0);
    for (k, r) in RADII.windows(2).enumerate() {
        let (v, s, h) = frustum(r[0], r[1], 4.0);
        volume += v;
        area += s;
        moment += v * (4.0 * k as f64 + h);
    }
    let m = measure(solid).unwrap();
    assert!((m.volume / volume - 1.0).abs() < 1e-12, "{m:?} {volume}");
    assert!((m.area / area - 1.0).abs() < 1e-9, "{m:?} {area}");
    let middle = DVec3::new(5.0, -3.0, 1.0) + DVec3::new(1.0, 0.3, -0.2).normalize() * (moment / volume);
    assert!(m.centroid.distance(middle) < 1e-11, "{m:?} {middle}");
    assert_eq!(solid.slopes.iter().filter(|&&s| s == 0.0).count(), 1);
    // Tangent to the cones at every rim; the sharpest crease is at the thick node, between both cones.
    let q = quality(&model, 9, &[]);
    assert!(q.gap_mm.value < 1e-14 && q.rim_jump_deg.value < 1e-12, "{q:?}");
    let crease = [0.9f64, 0.5].map(|fall| (fall / 4.0).atan().to_degrees()).iter().sum::<f64>();
    assert!((q.inner_jump_deg.value - crease).abs() < 1e-9, "{q:?} {crease}");
}

#[test]
fn a_rim_is_judged_against_the_normal_of_its_cone() {
    let mut case = tapered();
    // A patch at the thick node as a cylinder on its rim: radial where the strut's normal is not.
    let patch = &mut case.1[3].as_mut().unwrap().patches[0];
    let axis = DVec3::new(1.0, 0.3, -0.2).normalize();
    for column in patch.surface.points.chunks_mut(2) {
        column[1] = column[1].project_onto_normalized(axis) + column[0].reject_from_normalized(axis);
    }
    let q = quality(&build(&case, &AssembleOptions::default()), 9, &[]);
    assert!((q.rim_jump_deg.value - (0.9f64 / 4.0).atan().to_degrees()).abs() < 1e-9, "{q:?}");
    assert_eq!(q.rim_jump_deg.at.unwrap()[1], Label::Strut(StrutId(2)));
}

#[test]
fn far_from_the_origin_no_digits_of_the_measures_are_lost() {
    let at = DVec3::new(4e6, -1e6, 3e6);
    let case = skins::row(at, DVec3::X, 4.0, 0.5, &[(4, 0.1), (4, 1.0)]);
    let m = measure(&build(&case, &AssembleOptions::default()).solids[0]).unwrap();
    assert!((m.volume / (PI * 0.25 * 12.0) - 1.0).abs() < 1e-8, "{m:?}");
    assert!(m.centroid.distance(at + DVec3::X * 6.0) < 1e-8);
}

#[test]
fn every_shared_point_is_stored_once() {
    let model = build(&long(), &AssembleOptions::default());
    let solid = &model.solids[0];
    let mut bits: Vec<_> = solid.points.iter().map(|p| p.to_array().map(|x| (x + 0.0).to_bits())).collect();
    let rim_middles = 2 * (4 + 4 + 5 + 5 + 3);
    // The patch border on a rim is no edge curve: its middle points are the patch's own.
    assert_eq!(solid.points.len() - solid.shell().vertices.len(), rim_middles + rim_middles / 2);
    bits.sort_unstable();
    bits.dedup();
    assert_eq!(bits.len(), solid.points.len());
}

#[test]
fn components_become_solids() {
    let (a, b) = (single(), long());
    let shift = |g: &Graph| g.nodes().iter().map(|&p| p + DVec3::Z * 50.0).collect::<Vec<_>>();
    let nodes = [a.0.nodes().to_vec(), vec![DVec3::ONE], shift(&b.0)].concat();
    let struts = a.0.struts().iter().map(|s| (s.a.0, s.b.0)).chain(b.0.struts().iter().map(|s| (s.a.0 + 3, s.b.0 + 3)));
    let graph = skins::graph(&nodes, &struts.collect::<Vec<_>>(), 0.5);
    let all = [a.1, vec![None], b.1].concat();
    let model = build(&(graph, all), &AssembleOptions::default());
    assert_eq!(model.solids.len(), 2);
    assert_eq!(model.solids[1].nodes[0], NodeId(3));
    assert_eq!(model.solids[1].labels[0], Label::Strut(StrutId(1)));
}

#[test]
fn connected_order_never_starts_a_second_island() {
    let model = build(&long(), &SPHERE);
    let solid = &model.solids[0];
    let order = topology::connected_order(solid);
    let mut held = std::collections::HashSet::new();
    for (k, &f) in order.iter().enumerate() {
        let edges: Vec<_> = solid.faces()[f].boundaries[0].iter().map(|e| e.index).collect();
        assert!(k == 0 || edges.iter().any(|e| held.contains(e)), "face {f} at place {k}");
        held.extend(edges);
    }
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..solid.faces().len()).collect::<Vec<_>>());
}

#[test]
fn names_of_faces() {
    let model = build(&long(), &AssembleOptions::default());
    let names: Vec<_> = model.solids[0].labels.iter().map(|l| l.to_string()).collect();
    assert_eq!(names[0], "strut_0");
    assert_eq!(names[6], "node_0/cap");
    assert_eq!(&names[7..9], ["node_1/strut_0/1", "node_1/strut_0/2"]);
    assert_eq!(names[11], "node_1/strut_1/1");
}

// Each invariant broken on purpose.

fn fault(case: &(Graph, Vec<Option<Skin>>)) -> BrepError {
    assemble(&case.0, &skins::borrowed(&case.1), &AssembleOptions::default()).unwrap_err().remove(0)
}

#[test]
fn broken_skins_are_refused() {
    let mut case = long();
    case.1[2] = None;
    assert_eq!(fault(&case), BrepError::NoSkin { node: NodeId(2) });

    let mut case = long();
    case.1[1].as_mut().unwrap().rims.pop();
    assert_eq!(fault(&case), BrepError::RimCount { node: NodeId(1), found: 1, wanted: 2 });

    let mut case = long();
    case.1[1].as_mut().unwrap().rims[1].arcs.swap(0, 1);
    assert_eq!(fault(&case), BrepError::RimNotClosed { node: NodeId(1), strut: StrutId(1) });

    let mut case = long();
    case.1[3].as_mut().unwrap().rims[0].axis.x += 1e-6;
    assert!(matches!(fault(&case), BrepError::RimAxis { node: NodeId(3), strut: StrutId(2), .. }));

    let mut case = long();
    case.1[3].as_mut().unwrap().rims[0].radius = 0.9;
    assert!(matches!(fault(&case), BrepError::RimRadius { .. }));

    // The rim of a tapered strut has the radius at its cut, not that at its node.
    let mut case = tapered();
    case.1[3].as_mut().unwrap().rims[0].radius = 1.0;
    assert!(matches!(fault(&case), BrepError::RimRadius { node: NodeId(3), strut: StrutId(2), found, wanted } if found == 1.4 && wanted < 1.3));

    let mut case = single();
    case.1[0].as_mut().unwrap().rims[0].cut = 13.0;
    assert!(matches!(fault(&case), BrepError::NoRoom { room, .. } if (room + 0.5).abs() < 1e-12));
}

fn topology_fault(change: impl Fn(&mut Solid)) -> BrepError {
    let mut model = build(&long(), &AssembleOptions::default());
    change(&mut model.solids[0]);
    check_topology(&model).unwrap_err().remove(0)
}

#[test]
fn broken_topology_is_found() {
    let missing = topology_fault(|s| {
        s.brep.boundaries[0].faces.pop();
    });
    assert!(matches!(missing, BrepError::EdgeUse { .. }), "{missing}");
    let open = topology_fault(|s| {
        s.brep.boundaries[0].faces[9].boundaries[0].swap(0, 1);
    });
    assert!(matches!(open, BrepError::OpenLoop { .. }), "{open}");
    let handle = topology_fault(|s| {
        s.nodes.pop();
    });
    assert!(matches!(handle, BrepError::Euler { found: 2, wanted: 0, .. }), "{handle}");
}

#[test]
fn truck_refuses_two_shells_in_one() {
    let mut model = build(&single(), &AssembleOptions::default());
    let mut twin = model.solids[0].brep.boundaries[0].clone();
    let shell = &mut model.solids[0].brep.boundaries[0];
    let (v, e) = (shell.vertices.len(), shell.edges.len());
    for edge in &mut twin.edges {
        edge.vertices = (edge.vertices.0 + v, edge.vertices.1 + v);
    }
    for used in twin.faces.iter_mut().flat_map(|f| &mut f.boundaries).flatten() {
        used.index += e;
    }
    shell.vertices.extend(twin.vertices);
    shell.edges.extend(twin.edges);
    shell.faces.extend(twin.faces);
    topology::accepted_by_truck(0, &model.solids[0]).unwrap_err();
}

#[test]
fn an_inside_out_node_is_found() {
    let mut model = build(&long(), &AssembleOptions::default());
    let solid = &mut model.solids[0];
    for p in &mut solid.points {
        *p = -*p;
    }
    for c in solid.circles.iter_mut() {
        c.center = -c.center;
    }
    for c in solid.centers.iter_mut() {
        *c = -*c;
    }
    let found = measure(solid).unwrap_err();
    assert!(matches!(found, BrepError::InsideOut { node: NodeId(1), .. }), "{found}");
}

#[test]
fn gaps_jumps_and_folds_are_found_where_they_are() {
    let limits = QualityLimits { rim_jump_deg: 1e-3, inner_jump_deg: 1e-3, gap_mm: 1e-9, facing: 0.0 };
    let found = |change: &dyn Fn(&mut Skin)| {
        let mut case = long();
        change(case.1[2].as_mut().unwrap());
        let q = quality(&assemble(&case.0, &skins::borrowed(&case.1), &AssembleOptions::default()).unwrap(), 9, &[]);
        (q, q.check(&limits).unwrap_err())
    };
    // A middle control point of the inner circle, in one patch alone: gap and jump.
    let (q, faults) = found(&|skin| skin.patches[0].surface.points[3].z += 1e-3);
    assert!(q.gap_mm.value > 1e-5 && q.gap_mm.value < 1e-3, "{q:?}");
    assert_eq!(q.gap_mm.at.unwrap()[0], Label::Patch { node: NodeId(2), strut: StrutId(1), number: 1 });
    assert!(faults.iter().any(|f| matches!(f, BrepError::Gap { .. })));
    // The rim's middle control point: gap to the circle and a jump at the rim.
    let (q, faults) = found(&|skin| skin.patches[0].surface.points[2] *= 1.001);
    assert_eq!(q.rim_jump_deg.at.unwrap()[1], Label::Strut(StrutId(1)));
    assert!(faults.iter().any(|f| matches!(f, BrepError::Jump { place, .. } if place == "node_2/strut_1/1 against strut_1")));
    // A patch turned inside out folds.
    let (_, faults) = found(&|skin| skin.patches[0].surface.points.reverse());
    assert!(faults.iter().any(|f| matches!(f, BrepError::Gap { .. })));
    let (_, faults) = found(&|skin| {
        let p = &mut skin.patches[0].surface.points;
        p.swap(0, 1);
        p.swap(2, 3);
        p.swap(4, 5);
    });
    assert!(faults.iter().any(|f| matches!(f, BrepError::Folded { .. })));
}
