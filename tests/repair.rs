//! Repairs: what each changes and leaves, that each is at rest on its own result, and that its record takes it back bit for bit.

use glam::{DVec3, dvec3};
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::check::{Overlaps, admit};
use lattice_brep::graph::repair::chains::{STRAIGHT, collapse};
use lattice_brep::graph::repair::loose::{LOOSE, drop_loose};
use lattice_brep::graph::repair::merge::{Fit, Stuck};
use lattice_brep::graph::repair::record::{Step, Why};
use lattice_brep::graph::repair::weld::weld;
use lattice_brep::graph::repair::{Merged, Repair, Wanted, merge, repair, undo};
use lattice_brep::graph::{Graph, Input, Strut};
use lattice_brep::ids::{NodeId, StrutId};
use lattice_brep::inspect::{cut_conflicts, fit};
use proptest::prelude::*;
use std::collections::BTreeMap;

fn strut(a: u32, b: u32, ra: f64, rb: f64) -> Strut {
    Strut { a: NodeId(a), b: NodeId(b), ra, rb }
}

fn lattice(nodes: Vec<DVec3>, ends: &[(u32, u32)], r: f64) -> Input {
    Input { name: Some("a name".into()), nodes, struts: ends.iter().map(|&(a, b)| strut(a, b, r, r)).collect() }
}

fn input(graph: &Graph) -> Input {
    Input { name: None, nodes: graph.nodes().to_vec(), struts: graph.struts().to_vec() }
}

fn cell(cell: Cell, repeat: u32) -> Input {
    input(&generate(cell, 10.0, [repeat; 3], 0.5).unwrap())
}

/// The record survives its JSON form and takes the repair back; made again, the repair does nothing.
fn sound(before: &Input, step: impl Fn(&Input) -> (Input, Repair)) -> (Input, Repair) {
    let (after, record) = step(before);
    let read: Repair = serde_json::from_str(&serde_json::to_string(&record).unwrap()).unwrap();
    assert_eq!(read, record);
    assert_eq!(&undo(&after, &[read]).unwrap(), before);
    assert_eq!((record.before.nodes, record.after.nodes), (before.nodes.len(), after.nodes.len()));
    assert_eq!((record.before.struts, record.after.struts), (before.struts.len(), after.struts.len()));
    let (again, nothing) = step(&after);
    assert_eq!(again, after);
    assert!(nothing.nodes.is_empty() && nothing.struts.is_empty(), "{nothing:?}");
    (after, record)
}

const LAMBDA: f64 = 0.3;

fn merged(input: &Input, angle: f64, fit: &dyn Fn(&Graph) -> Fit) -> (Input, Repair) {
    let Merged { input, repair, .. } = merge(input, angle, fit);
    (input, repair)
}

/// No struts in conflict, and nodes that reach as far as their radii.
fn all_fits(graph: &Graph) -> Fit {
    Fit { conflicts: vec![], reach: graph.node_ids().map(|n| graph.largest_radius(n)).collect() }
}

/// Each strut with its ends and radii swapped where that puts the lower place first: equal for equal lattices however numbered.
fn shape(input: &Input) -> Vec<[f64; 8]> {
    let end = |n: NodeId, r: f64| [input.nodes[n.index()].x, input.nodes[n.index()].y, input.nodes[n.index()].z, r];
    let mut list: Vec<[f64; 8]> = input
        .struts
        .iter()
        .map(|s| {
            let (p, q) = (end(s.a, s.ra), end(s.b, s.rb));
            let (p, q) = if p <= q { (p, q) } else { (q, p) };
            [p[0], p[1], p[2], p[3], q[0], q[1], q[2], q[3]]
        })
        .collect();
    list.sort_by(|x, y| x.partial_cmp(y).unwrap());
    list
}

/// The cell with every strut given nodes of its own, each a little off.
fn torn(whole: &Input, by: f64) -> Input {
    let mut out = Input { name: None, ..Input::default() };
    for (k, s) in whole.struts.iter().enumerate() {
        for (end, n) in [s.a, s.b].into_iter().enumerate() {
            let angle = (2 * k + end) as f64;
            out.nodes.push(whole.nodes[n.index()] + 0.4 * by * dvec3(angle.sin(), angle.cos(), 0.0));
        }
        out.struts.push(strut(2 * k as u32, 2 * k as u32 + 1, s.ra, s.rb));
    }
    out
}

/// Every strut in `parts` pieces.
fn segmented(whole: &Input, parts: u32) -> Input {
    let mut out = Input { name: None, nodes: whole.nodes.clone(), struts: vec![] };
    for s in &whole.struts {
        let (p, q) = (whole.nodes[s.a.index()], whole.nodes[s.b.index()]);
        let at = |k: u32| f64::from(k) / f64::from(parts);
        let radius = |k: u32| s.ra + at(k) * (s.rb - s.ra);
        let mut last = s.a;
        for k in 1..=parts {
            let next = if k == parts { s.b } else { NodeId(out.nodes.len() as u32) };
            if k < parts {
                out.nodes.push(p.lerp(q, at(k)));
            }
            out.struts.push(Strut { a: last, b: next, ra: radius(k - 1), rb: radius(k) });
            last = next;
        }
    }
    out
}

#[test]
fn weld_joins_what_was_torn() {
    let whole = cell(Cell::Octet, 2);
    let (after, record) = sound(&torn(&whole, 1e-3), |i| weld(i, 1e-3));
    assert_eq!((after.nodes.len(), after.struts.len()), (whole.nodes.len(), whole.struts.len()));
    assert!(record.nodes.iter().all(|n| n.moved.unwrap() <= 1e-3 && !n.stays));
    assert!(admit(after, vec![], Overlaps::Refuse).is_ok());
    let (same, record) = weld(&whole, 1e-3);
    assert_eq!((same, record.nodes, record.struts), (whole, vec![], vec![]));
}

#[test]
fn weld_drops_loops_and_twins_and_lists_them() {
    let nodes = vec![DVec3::ZERO, DVec3::X * 5.0, dvec3(5.0, 0.005, 0.0), DVec3::Y * 5.0];
    let mut before = lattice(nodes, &[(0, 1), (2, 0), (1, 2), (1, 3), (2, 3)], 0.5);
    before.struts[1].ra = 0.75;
    let (after, record) = sound(&before, |i| weld(i, 0.01));
    assert_eq!(after.struts, [strut(0, 1, 0.5, 0.75), strut(1, 2, 0.5, 0.5)], "the twin's larger radius stays");
    let [n] = &record.nodes[..] else { panic!("{record:?}") };
    assert_eq!((n.node, n.at, n.into, n.stays), (NodeId(2), [5.0, 0.005, 0.0], Some(NodeId(1)), false));
    assert!((n.moved.unwrap() - 0.005).abs() < 1e-15);
    let why: Vec<_> = record.struts.iter().map(|s| (s.strut.0, s.why, s.into)).collect();
    assert_eq!(why, [(0, Why::Changed, Some(StrutId(0))), (1, Why::Twin, Some(StrutId(0))), (2, Why::Loop, None), (4, Why::Twin, Some(StrutId(1)))]);
}

#[test]
fn weld_is_greedy_and_moves_no_node_further_than_the_tolerance() {
    // A row of nodes 0.6 apart: transitive welding would make one of them all.
    let before = lattice((0..7).map(|k| DVec3::X * 0.6 * f64::from(k)).collect(), &[(0, 6)], 0.1);
    let (after, record) = sound(&before, |i| weld(i, 1.0));
    assert_eq!(after.nodes.iter().map(|p| (p.x * 10.0).round()).collect::<Vec<_>>(), [0.0, 12.0, 24.0, 36.0]);
    assert!(record.nodes.iter().all(|n| n.moved.unwrap() <= 1.0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn weld_agrees_with_comparing_all_pairs(nodes in prop::collection::vec(prop::array::uniform3(-2.0..2.0f64), 80), ends in prop::collection::vec((0..80u32, 0..80u32), 60), tolerance in 0.05..1.0f64) {
        let nodes: Vec<DVec3> = nodes.into_iter().map(DVec3::from_array).collect();
        let before = lattice(nodes.clone(), &ends, 0.1);
        let mut heads: Vec<DVec3> = vec![];
        for &p in &nodes {
            if heads.iter().all(|h| h.distance(p) > tolerance) {
                heads.push(p);
            }
        }
        let (after, record) = sound(&before, |i| weld(i, tolerance));
        prop_assert_eq!(&after.nodes, &heads);
        for n in &record.nodes {
            let least = heads.iter().map(|h| h.distance(DVec3::from_array(n.at))).fold(f64::INFINITY, f64::min);
            prop_assert!(n.moved == Some(least) && after.nodes[n.into.unwrap().index()].distance(DVec3::from_array(n.at)) == least);
        }
        prop_assert!(after.struts.iter().all(|s| s.a != s.b));
    }

    #[test]
    fn every_repair_is_taken_back_whatever_the_lattice(
        nodes in prop::collection::vec(prop::array::uniform3(0.0..6.0f64), 30),
        ends in prop::collection::vec((0..31u32, 0..30u32, 0.05..0.4f64, 0.05..0.4f64), 1..60),
    ) {
        // some ends are out of range, some struts are loops or twins
        let struts = ends.into_iter().map(|(a, b, ra, rb)| strut(a, b, ra, rb)).collect();
        let before = Input { name: None, nodes: nodes.into_iter().map(DVec3::from_array).collect(), struts };
        let wanted = Wanted { weld: Some(0.8), drop_loose: Some(0.2), collapse_chains: Some(3.0) };
        let mut repaired = repair(before.clone(), &wanted);
        repaired.then(|i| merged(i, 10.0, &fit(LAMBDA)));
        prop_assert_eq!(repaired.repairs.iter().map(|r| r.step).collect::<Vec<_>>(), [Step::Weld, Step::DropLoose, Step::CollapseChains, Step::Merge]);
        prop_assert_eq!(undo(&repaired.input, &repaired.repairs).unwrap(), before);
    }
}

#[test]
fn chains_of_a_segmented_lattice_become_its_struts() {
    for (name, parts) in [(Cell::Cubic, 2), (Cell::Octet, 5), (Cell::Kelvin, 3)] {
        let whole = cell(name, 2);
        let (after, record) = sound(&segmented(&whole, parts), |i| collapse(i, STRAIGHT));
        assert_eq!(shape(&after), shape(&whole), "{name:?}");
        assert_eq!(record.nodes.len(), whole.struts.len() * (parts as usize - 1));
        assert!(record.struts.iter().all(|s| s.into.is_some()));
    }
}

#[test]
fn chains_taper_only_where_the_radius_is_linear() {
    let line = |k: usize| DVec3::X * k as f64;
    let mut before = lattice((0..6).map(line).collect(), &[(1, 0), (1, 2), (2, 3), (4, 3), (4, 5)], 1.0);
    let radii = [(1.1, 1.0), (1.1, 1.2), (1.2, 1.3), (2.0, 1.9), (2.0, 2.1)];
    for (s, (ra, rb)) in before.struts.iter_mut().zip(radii) {
        (s.ra, s.rb) = (ra, rb);
    }
    // linear from 1 to 1.3, a step at node 3, linear from 1.9 to 2.1
    let (after, record) = sound(&before, |i| collapse(i, STRAIGHT));
    assert_eq!(after.nodes, [line(0), line(3), line(5)]);
    assert_eq!(after.struts, [strut(1, 0, 1.3, 1.0), strut(2, 1, 2.1, 1.9)], "direction of the first strut of each");
    assert_eq!(record.nodes.iter().map(|n| n.node.0).collect::<Vec<_>>(), [1, 2, 4]);
}

#[test]
fn corners_rings_and_struts_that_are_there_already_stay() {
    // A square ring, each side in two: the corners stay, also when the ring starts within a side.
    let square = [(1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0), (0.0, 2.0), (0.0, 1.0), (0.0, 0.0)];
    let ring = lattice(square.map(|(x, y)| dvec3(x, y, 0.0)).to_vec(), &[(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 7), (7, 0)], 0.1);
    let (after, _) = sound(&ring, |i| collapse(i, STRAIGHT));
    assert_eq!(after.nodes, [dvec3(2.0, 0.0, 0.0), dvec3(2.0, 2.0, 0.0), dvec3(0.0, 2.0, 0.0), DVec3::ZERO]);
    assert_eq!(after.struts.len(), 4);
    // A bend of 0.02 radii at the middle stays at δ = 0.01, and goes at 0.03.
    let bent = lattice(vec![DVec3::ZERO, dvec3(1.0, 0.002, 0.0), DVec3::X * 2.0], &[(0, 1), (1, 2)], 0.1);
    assert_eq!(collapse(&bent, 0.01).0, bent);
    assert_eq!(collapse(&bent, 0.03).0.struts, [strut(0, 1, 0.1, 0.1)]);
    // A fold back is no straight chain.
    let folded = lattice(vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::X, DVec3::X * 3.0], &[(0, 1), (1, 2), (2, 3)], 0.1);
    assert_eq!(collapse(&folded, STRAIGHT).0, folded);
    // A chain beside a strut between the same nodes, of degree 3 both.
    let beside = lattice(vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0, -DVec3::Y, dvec3(2.0, 1.0, 0.0)], &[(0, 1), (1, 2), (0, 2), (0, 3), (2, 4)], 0.1);
    assert_eq!(collapse(&beside, STRAIGHT).0, beside);
}

#[test]
fn collapse_stays_within_its_tolerance() {
    // A quarter circle of 60 segments, radius 10: pieces as long as δ lets them be.
    let nodes: Vec<DVec3> = (0..=60).map(|k| DVec3::from_angle_xy(f64::from(k) * 1.5f64.to_radians()) * 10.0).collect();
    let ends: Vec<(u32, u32)> = (0..60).map(|k| (k, k + 1)).collect();
    let before = lattice(nodes.clone(), &ends, 0.5);
    for delta in [0.01, 0.1, 0.5] {
        let (after, _) = sound(&before, |i| collapse(i, delta));
        assert!(after.struts.len() < 60);
        for &p in &nodes {
            let off = |s: &Strut| {
                let (a, b) = (after.nodes[s.a.index()], after.nodes[s.b.index()]);
                let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                p.distance(a.lerp(b, t))
            };
            let off = after.struts.iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(off <= delta * 0.5 + 1e-12, "{off} at {delta}");
        }
    }
}

trait FromAngle {
    fn from_angle_xy(angle: f64) -> DVec3;
}

impl FromAngle for DVec3 {
    fn from_angle_xy(angle: f64) -> DVec3 {
        dvec3(angle.cos(), angle.sin(), 0.0)
    }
}

#[test]
fn loose_parts_go_by_their_volume() {
    let mut before = cell(Cell::Cubic, 2);
    let (nodes, struts) = (before.nodes.len(), before.struts.len());
    // a lone strut, a part of a tenth of the volume, a node without struts
    before.nodes.extend([100.0, 105.0, 200.0, 254.0, 300.0].map(|x| DVec3::X * x));
    let n = nodes as u32;
    before.struts.extend([strut(n, n + 1, 0.5, 0.5), strut(n + 2, n + 3, 0.5, 0.5)]);
    let (after, record) = sound(&before, |i| drop_loose(i, LOOSE));
    assert_eq!((after.nodes.len(), after.struts.len()), (nodes + 2, struts + 1));
    assert_eq!(record.nodes.iter().map(|c| (c.node.0, c.into, c.moved)).collect::<Vec<_>>(), [(n, None, None), (n + 1, None, None), (n + 4, None, None)]);
    assert_eq!(record.struts.iter().map(|c| (c.strut.index(), c.why)).collect::<Vec<_>>(), [(struts, Why::Loose)]);
    let (alone, _) = sound(&before, |i| drop_loose(i, 1.0));
    assert_eq!((alone.nodes.len(), alone.struts.len()), (nodes, struts));
    // of equal parts none is loose
    let twins = lattice(vec![DVec3::ZERO, DVec3::X, DVec3::Y * 9.0, dvec3(1.0, 9.0, 0.0)], &[(0, 1), (2, 3)], 0.1);
    assert_eq!(drop_loose(&twins, 1.0).0, twins);
}

#[test]
fn pieces_out_of_range_or_not_finite_are_left_for_the_checks() {
    let mut before = lattice(vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0, DVec3::Y, dvec3(9.0, 9.0, 9.0)], &[(0, 1), (1, 2), (0, 3), (1, 77)], 0.1);
    before.nodes[3].z = f64::INFINITY;
    let wanted = Wanted { weld: Some(0.1), drop_loose: Some(1.0), collapse_chains: Some(STRAIGHT) };
    let repaired = repair(before.clone(), &wanted);
    assert_eq!(repaired.input.nodes, before.nodes[..4], "only the bare node goes");
    assert_eq!(repaired.input.struts, before.struts, "node 1 has a strut to nowhere: no inner node");
    assert_eq!(undo(&repaired.input, &repaired.repairs).unwrap(), before);
}

#[test]
fn forged_records_are_refused() {
    let before = segmented(&cell(Cell::Cubic, 1), 2);
    let (after, record) = collapse(&before, STRAIGHT);
    let forged = |change: fn(&mut Repair)| {
        let mut record = record.clone();
        change(&mut record);
        undo(&after, &[record])
    };
    assert!(forged(|_| ()).is_ok());
    assert!(forged(|r| r.before.nodes = usize::MAX / 2).is_err());
    assert!(forged(|r| r.before.struts -= 1).is_err());
    assert!(forged(|r| r.nodes[0].node = NodeId(u32::MAX)).is_err());
    assert!(forged(|r| r.struts.truncate(3)).is_err());
    assert!(undo(&before, &[record]).is_err(), "another lattice");
}

fn graph(input: &Input) -> Graph {
    Graph::new(input.nodes.clone(), input.struts.clone())
}

/// The nodes, in the ids before, that went into one with others.
fn groups(repair: &Repair) -> Vec<Vec<usize>> {
    let mut groups: BTreeMap<NodeId, Vec<usize>> = BTreeMap::new();
    for n in &repair.nodes {
        groups.entry(n.into.expect("no node is dropped")).or_default().push(n.node.index());
    }
    groups.into_values().collect()
}

#[test]
fn merge_joins_only_nodes_that_reach_each_other_and_names_what_is_stuck() {
    // thick struts: each of them, or nearly, is too short for its cuts
    for (name, radius) in [(Cell::Octet, 2.1), (Cell::Bcc, 3.3), (Cell::BccEdges, 2.6)] {
        let before = input(&generate(name, 10.0, [2; 3], radius).unwrap());
        assert!(!cut_conflicts(&graph(&before), LAMBDA).is_empty(), "{name:?}");
        let reach = fit(LAMBDA)(&graph(&before)).reach;
        let Merged { input: after, repair, stuck } = merge(&before, 5.0, &fit(LAMBDA));
        assert_eq!(undo(&after, &[repair.clone()]).unwrap(), before);
        for group in groups(&repair) {
            for (&p, &q) in group.iter().flat_map(|p| group.iter().map(move |q| (p, q))).filter(|(p, q)| p != q) {
                assert!(before.nodes[p].distance(before.nodes[q]) <= reach[p] + reach[q], "{name:?}: {group:?}");
            }
        }
        let left = cut_conflicts(&graph(&after), LAMBDA);
        let original = repair.origins().1;
        assert_eq!(stuck.iter().map(|s| s.strut).collect::<Vec<_>>(), left.iter().map(|c| original[c.strut.index()]).collect::<Vec<_>>());
        for Stuck { nodes: [p, q], distance, reach: together, .. } in stuck {
            assert_eq!((distance, together), (before.nodes[p.index()].distance(before.nodes[q.index()]), reach[p.index()] + reach[q.index()]));
            assert!(distance > together);
        }
        assert!(after.nodes.len() > 8, "{name:?}: {} nodes of {}", after.nodes.len(), before.nodes.len());
    }
    let fits = cell(Cell::Octet, 2);
    assert_eq!(merged(&fits, 5.0, &fit(LAMBDA)).0, fits);
}

#[test]
fn a_row_of_short_struts_does_not_become_a_point() {
    // 12 nodes 0.3 apart, radius 1: a strut needs 0.4, and nodes up to 2 apart reach each other
    let before = lattice((0..12).map(|k| 0.3 * f64::from(k) * DVec3::X).collect(), &(0..11).map(|k| (k, k + 1)).collect::<Vec<_>>(), 1.0);
    let (after, record) = sound(&before, |i| merged(i, 5.0, &fit(LAMBDA)));
    assert!(cut_conflicts(&graph(&after), LAMBDA).is_empty());
    assert!(groups(&record).iter().all(|g| g.len() <= 7) && (2..12).contains(&after.nodes.len()), "{:?}", after.nodes);
}

#[test]
fn a_short_strut_is_merged_away_and_the_record_has_before_and_after() {
    let arm = |x: f64, degrees: f64| x * DVec3::X + 20.0 * DVec3::from_angle_xy(degrees.to_radians());
    let nodes = vec![DVec3::ZERO, 0.3 * DVec3::X, arm(0.0, 120.0), arm(0.0, -120.0), arm(0.3, 60.0), arm(0.3, -60.0)];
    let before = lattice(nodes, &[(0, 1), (0, 2), (3, 0), (1, 4), (1, 5)], 1.0);
    let (after, record) = sound(&before, |i| merged(i, 5.0, &fit(LAMBDA)));
    assert_eq!(after.nodes[0], 0.15 * DVec3::X);
    assert_eq!((after.nodes.len(), after.struts.len()), (5, 4));
    let [gone, moved_4, moved_5] = &record.struts[..] else { panic!("{:?}", record.struts) };
    assert_eq!((gone.strut.0, gone.why, gone.into, gone.now), (0, Why::Loop, None, None));
    for (change, end) in [(moved_4, 3), (moved_5, 4)] {
        let now = change.now.unwrap();
        assert_eq!((change.why, now.a, now.b, now.ra, now.rb), (Why::Changed, NodeId(0), NodeId(end), 1.0, 1.0));
    }
    // the strut that went, and four that are longer by as much as the node moved
    let longer = (after.nodes[0] - after.nodes[1]).length() - 20.0;
    assert!((record.changed_mm3 - std::f64::consts::PI * (0.3 + 4.0 * longer)).abs() < 1e-9, "{}", record.changed_mm3);
}

#[test]
fn merge_runs_close_struts_together_as_far_as_the_nearer_node() {
    let at = |degrees: f64, length: f64| length * DVec3::from_angle_xy(degrees.to_radians());
    // 2° apart from node 0: to node 1 at 10 mm, to node 2 at 30 mm, thicker
    let mut before = lattice(vec![DVec3::ZERO, at(0.0, 10.0), at(2.0, 30.0), at(90.0, 20.0)], &[(2, 0), (0, 1), (0, 3)], 0.5);
    (before.struts[0].ra, before.struts[0].rb) = (0.6, 0.9);
    let (after, record) = sound(&before, |i| merged(i, 5.0, &all_fits));
    let t = 2f64.to_radians().cos() / 3.0;
    assert_eq!(after.nodes, before.nodes);
    let [to_c, to_b, side] = after.struts[..] else { panic!() };
    assert_eq!((to_c.a, to_c.b, to_c.ra), (NodeId(2), NodeId(1), 0.6));
    assert!((to_c.rb - (0.9 - t * 0.3)).abs() < 1e-12 && (to_b.rb - to_c.rb).abs() < 1e-15);
    assert_eq!((to_b.a, to_b.b, to_b.ra, side), (NodeId(0), NodeId(1), 0.9, before.struts[2]));
    assert_eq!(record.struts.iter().map(|s| (s.strut.0, s.why)).collect::<Vec<_>>(), [(0, Why::Changed), (1, Why::Changed)]);
    assert_eq!(merged(&before, 1.0, &all_fits).0, before, "not below the limit");
}

#[test]
fn merge_joins_nodes_whose_balls_touch() {
    let nodes = vec![DVec3::ZERO, DVec3::X * 10.0, dvec3(10.0, 0.6, 0.0), dvec3(20.0, 0.6, 0.0)];
    let before = lattice(nodes, &[(0, 1), (2, 3)], 0.5);
    let (after, record) = sound(&before, |i| merged(i, 5.0, &all_fits));
    assert_eq!(after.nodes, [DVec3::ZERO, dvec3(10.0, 0.3, 0.0), dvec3(20.0, 0.6, 0.0)]);
    assert_eq!(after.struts, [strut(0, 1, 0.5, 0.5), strut(1, 2, 0.5, 0.5)]);
    let nodes: Vec<_> = record.nodes.iter().map(|n| (n.node.0, n.into, n.stays)).collect();
    assert_eq!(nodes, [(1, Some(NodeId(1)), true), (2, Some(NodeId(1)), false)]);
}
