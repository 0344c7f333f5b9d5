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
    let model = assemble(&case.0, &skins::shelved(&case.1), options).unwrap();
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
    assert_eq!(solid.face_count(), 6 + 2 * (4 + 4 + 5 + 5 + 3) + 2);
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
    let mut bits: Vec<_> = points(solid).iter().map(|p| p.to_array().map(|x| (x + 0.0).to_bits())).collect();
    let rim_middles = 2 * (4 + 4 + 5 + 5 + 3);
    assert_eq!(bits.len(), solid.point_count());
    // The patch border on a rim is no edge curve: its middle points are the patch's own.
    assert_eq!(solid.point_count() - solid.vertex_count(), rim_middles + rim_middles / 2);
    bits.sort_unstable();
    bits.dedup();
    assert_eq!(bits.len(), solid.point_count());
}

/// All points of a solid.
fn points(solid: &Solid) -> Vec<DVec3> {
    (0..solid.nodes.len()).flat_map(|n| solid.part(n).points).chain(solid.extra.iter().copied()).collect()
}

#[test]
fn points_and_edges_are_numbered_without_gaps() {
    for solid in &build(&long(), &SPHERE).solids {
        let parts: Vec<Part> = (0..solid.nodes.len()).map(|n| solid.part(n)).collect();
        let mut numbers: Vec<u32> = parts.iter().flat_map(|part| (0..part.points.len() as u32).map(|i| part.number(i))).collect();
        numbers.extend(solid.vertex_count() as u32 - solid.extra.len() as u32..solid.vertex_count() as u32);
        numbers.sort_unstable();
        assert_eq!(numbers, (0..solid.point_count() as u32).collect::<Vec<_>>());
        let of_parts = parts.iter().flat_map(|part| (part.first_edge()..).take(part.edges.len()));
        let of_struts = (0..solid.struts.len()).flat_map(|k| (solid.first_strut_edge(k)..).take(solid.strut_edges(k).len()));
        let meridians = (solid.first_strut_edge(solid.struts.len())..).take(solid.meridians().count());
        assert_eq!(of_parts.chain(of_struts).chain(meridians).collect::<Vec<_>>(), (0..solid.edge_count() as u32).collect::<Vec<_>>());
    }
}

/// Where a seam splits an arc in its middle too: an end at azimuth 0 is one at 2π as well, and readers drop what says which.
#[test]
fn no_seam_ends_where_azimuths_of_its_rim_begin() {
    let turns = [(3, 0.0), (3, -PI / 3.0), (3, 0.0), (3, PI / 3.0)];
    let model = build(&skins::row(DVec3::ZERO, DVec3::new(1.0, 0.3, -0.2), 4.0, 0.5, &turns), &AssembleOptions::default());
    let solid = &model.solids[0];
    let azimuth = |k: usize, e: usize, p: DVec3| solid.rim(k, e).azimuth(p - solid.rim(k, e).center).abs();
    // the ends of the row are closed rims, which begin at their seam
    let inner = (0..solid.struts.len()).flat_map(|k| [(k, 0), (k, 1)]).skip(1).take(2 * solid.struts.len() - 2);
    let found: Vec<f64> = inner.map(|(k, e)| azimuth(k, e, solid.seam_ends(k)[e])).collect();
    assert!(found.len() == 8 && found.iter().all(|a| *a > 0.2), "{found:?}");
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
    assert_eq!(model.solids[1].label(0), Label::Strut(StrutId(1)));
}

#[test]
fn connected_order_never_starts_a_second_island() {
    let model = build(&long(), &SPHERE);
    let borders = Borders::of(&model.solids[0]);
    let order = topology::connected_order(&borders);
    let mut held = std::collections::HashSet::new();
    for (k, &f) in order.iter().enumerate() {
        let edges: Vec<_> = borders.boundary(f as usize).iter().map(|e| e.edge).collect();
        assert!(k == 0 || edges.iter().any(|e| held.contains(e)), "face {f} at place {k}");
        held.extend(edges);
    }
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..borders.face_count() as u32).collect::<Vec<_>>());
}

#[test]
fn names_of_faces() {
    let model = build(&long(), &AssembleOptions::default());
    let names: Vec<_> = (0..12).map(|f| model.solids[0].label(f).to_string()).collect();
    assert_eq!(names[0], "strut_0");
    assert_eq!(names[6], "node_0/cap");
    assert_eq!(&names[7..9], ["node_1/strut_0/1", "node_1/strut_0/2"]);
    assert_eq!(names[11], "node_1/strut_1/1");
}

// Each invariant broken on purpose.

fn fault(case: &(Graph, Vec<Option<Skin>>)) -> BrepError {
    assemble(&case.0, &skins::shelved(&case.1), &AssembleOptions::default()).unwrap_err().remove(0)
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

fn border_fault(change: impl Fn(&mut Borders)) -> BrepError {
    let mut borders = Borders::of(&build(&long(), &AssembleOptions::default()).solids[0]);
    change(&mut borders);
    topology::check_borders(0, &borders, 0, |face| face.to_string()).unwrap_err()
}

/// Adds the borders of another solid.
fn add(to: &mut Borders, other: Borders) {
    let (v, e, u) = (to.vertex_count as u32, to.edges.len() as u32, to.uses.len() as u32);
    to.vertex_count += other.vertex_count;
    to.edges.extend(other.edges.iter().map(|ends| ends.map(|end| end + v)));
    to.uses.extend(other.uses.iter().map(|used| EdgeUse { edge: used.edge + e, ..*used }));
    to.first.extend(other.first[1..].iter().map(|first| first + u));
}

#[test]
fn broken_topology_is_found() {
    let missing = border_fault(|b| {
        b.uses.truncate(b.first[b.face_count() - 1] as usize);
        b.first.pop();
    });
    assert!(matches!(missing, BrepError::EdgeUse { .. }), "{missing}");
    let open = border_fault(|b| b.uses.swap(b.first[9] as usize, b.first[9] as usize + 1));
    assert!(matches!(open, BrepError::OpenLoop { solid: 0, ref face } if face == "9"), "{open}");
    let spare = border_fault(|b| b.vertex_count += 1);
    assert!(matches!(spare, BrepError::Euler { found: 3, wanted: 2, .. }), "{spare}");
}

#[test]
fn two_shells_in_one_are_refused_by_us_and_by_truck() {
    let single = Borders::of(&build(&single(), &AssembleOptions::default()).solids[0]);
    topology::one_shell(0, &single).unwrap();
    truck_accepts(&single).unwrap();
    let mut twins = single.clone();
    add(&mut twins, single);
    assert_eq!(topology::one_shell(0, &twins), Err(BrepError::Islands { solid: 0, islands: 2 }));
    truck_accepts(&twins).unwrap_err();
}

/// Two rows that touch in a vertex, joined elsewhere as well: one shell, yet no manifold.
#[test]
fn a_pinched_vertex_is_refused_by_us_and_by_truck() {
    let mut pinched = Borders::of(&build(&long(), &AssembleOptions::default()).solids[0]);
    truck_accepts(&pinched).unwrap();
    // two vertices of the row that share no face become one
    let [a, b] = [pinched.edges[0][0], pinched.vertex_count as u32 - 1];
    pinched.edges.iter_mut().flatten().filter(|v| **v == b).for_each(|v| *v = a);
    pinched.vertex_count -= 1;
    assert!(matches!(topology::one_shell(0, &pinched), Err(BrepError::Pinched { .. })));
    truck_accepts(&pinched).unwrap_err();
}

#[test]
fn truck_accepts_what_our_checks_accept() {
    for case in [single(), long(), tapered()] {
        for options in [AssembleOptions::default(), SPHERE] {
            truck_accepts(&Borders::of(&build(&case, &options).solids[0])).unwrap();
        }
    }
}

/// truck's `Solid` accepts the shell: not empty, connected, closed and oriented, and no vertex
/// where two cones of faces touch. Faces are built unchecked, since truck's face forbids seams and
/// closed edges.
fn truck_accepts(borders: &Borders) -> Result<(), truck_topology::errors::Error> {
    use truck_topology::{Edge, Face, Shell, Solid, Vertex, Wire};
    let vertices: Vec<Vertex<()>> = (0..borders.vertex_count).map(|_| Vertex::new(())).collect();
    let edge = |ends: &[u32; 2]| Edge::new_unchecked(&vertices[ends[0] as usize], &vertices[ends[1] as usize], ());
    let edges: Vec<Edge<(), ()>> = borders.edges.iter().map(edge).collect();
    let oriented = |e: &EdgeUse| if e.forward { edges[e.edge as usize].clone() } else { edges[e.edge as usize].inverse() };
    let wire = |face: usize| borders.boundary(face).iter().map(oriented).collect::<Wire<(), ()>>();
    let shell: Shell<(), (), ()> = (0..borders.face_count()).map(|face| Face::new_unchecked(vec![wire(face)], ())).collect();
    Solid::try_new(vec![shell]).map(|_| ())
}

#[test]
fn an_inside_out_node_is_found() {
    let mut case = long();
    let skin = case.1[1].as_mut().unwrap();
    // the border on the rim stays where it is
    for patch in &mut skin.patches {
        patch.surface.points.iter_mut().for_each(|p| *p = -4.0 * *p);
    }
    let found = measure(&assemble(&case.0, &skins::shelved(&case.1), &AssembleOptions::default()).unwrap().solids[0]).unwrap_err();
    assert!(matches!(found, BrepError::InsideOut { node: NodeId(1), .. }), "{found}");
}

#[test]
fn gaps_jumps_and_folds_are_found_where_they_are() {
    let limits = QualityLimits { rim_jump_deg: 1e-3, inner_jump_deg: 1e-3, gap_mm: 1e-9, facing: 0.0 };
    let found = |change: &dyn Fn(&mut Skin)| {
        let mut case = long();
        change(case.1[2].as_mut().unwrap());
        let q = quality(&assemble(&case.0, &skins::shelved(&case.1), &AssembleOptions::default()).unwrap(), 9, &[]);
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
