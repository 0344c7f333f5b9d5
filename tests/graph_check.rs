//! Every check of a graph's content: one sound graph that holds, and for each check one that breaks it, with its path.

use glam::{DVec3, dvec3};
use lattice_brep::error::{Error, Fault};
use lattice_brep::graph::check::{Overlaps, check};
use lattice_brep::graph::{self, Input, Strut};
use lattice_brep::ids::NodeId;

fn strut(a: u32, b: u32, ra: f64, rb: f64) -> Strut {
    Strut { a: NodeId(a), b: NodeId(b), ra, rb }
}

/// A tetrahedron with one strut hanging from it: nodes 0 to 4, struts 0 to 6.
fn sound() -> Input {
    let nodes = vec![DVec3::ZERO, DVec3::X * 10.0, DVec3::Y * 10.0, DVec3::Z * 10.0, dvec3(10.0, 0.0, -10.0)];
    let ends = [(0, 1), (0, 2), (0, 3), (1, 2), (2, 3), (3, 1), (1, 4)];
    Input { name: None, nodes, struts: ends.into_iter().map(|(a, b)| strut(a, b, 0.5, 0.5)).collect() }
}

fn broken(change: impl FnOnce(&mut Input)) -> Vec<Fault> {
    let mut input = sound();
    change(&mut input);
    check(&input)
}

fn paths(faults: &[Fault]) -> Vec<&str> {
    faults.iter().map(|f| f.path.as_str()).collect()
}

#[test]
fn sound_graph_has_no_fault() {
    assert_eq!(check(&sound()), vec![]);
}

#[test]
fn empty_graph() {
    assert_eq!(paths(&check(&Input::default())), ["nodes", "struts"]);
    assert_eq!(paths(&broken(|g| g.struts.clear())), ["struts"]);
}

#[test]
fn coordinate_not_a_number() {
    let faults = broken(|g| g.nodes[2].y = f64::NAN);
    assert_eq!(faults, [Fault::new("nodes[2][1]", "NaN", "a finite number")]);
}

#[test]
fn coordinate_infinite() {
    let faults = broken(|g| g.nodes[3].z = f64::NEG_INFINITY);
    assert_eq!(faults, [Fault::new("nodes[3][2]", "-inf", "a finite number")]);
}

#[test]
fn coordinate_too_large_to_square() {
    assert_eq!(paths(&broken(|g| g.nodes[4].x = 1e200)), ["nodes[4][0]"]);
}

#[test]
fn two_nodes_in_one_place() {
    // Node 4 on node 3: strut 6 then lies on strut 5, but only the node is at fault.
    let faults = broken(|g| g.nodes[4] = g.nodes[3]);
    assert_eq!(paths(&faults), ["nodes[4]"]);
    assert!(faults[0].found.starts_with("the place of nodes[3]"), "{}", faults[0]);
    assert_eq!(paths(&broken(|g| g.nodes[4] = g.nodes[3] + 1e-9)), ["nodes[4]"]);
}

#[test]
fn nodes_a_little_apart_are_two_places() {
    let faults = broken(|g| g.nodes[4] = g.nodes[3] + dvec3(0.0, 0.0, 1e-6));
    assert!(!paths(&faults).contains(&"nodes[4]"), "{faults:?}");
}

#[test]
fn places_agree_with_comparing_all_pairs() {
    // 4,000 nodes on 1,000 grid places, most of them several times and a little off.
    let mut seed = 7;
    let mut random = |n: u64| {
        seed = u64::wrapping_mul(seed, 6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) % n
    };
    let nodes: Vec<DVec3> = (0..4000).map(|_| dvec3(random(10) as f64, random(10) as f64, random(10) as f64) + 1e-12 * random(9) as f64).collect();
    let earlier = |n: usize| (0..n).any(|m| nodes[m].distance(nodes[n]) < 1e-9);
    let expected: Vec<String> = (0..nodes.len()).filter(|&n| earlier(n)).map(|n| format!("nodes[{n}]")).collect();
    assert!(expected.len() > 2900);
    let faults = check(&Input { name: None, nodes, struts: vec![strut(0, 1, 1e-4, 1e-4)] });
    let mut found = paths(&faults);
    found.retain(|path| path.starts_with("nodes["));
    assert_eq!(found, expected);
}

#[test]
fn index_out_of_range() {
    let faults = broken(|g| g.struts[2].b = NodeId(5));
    assert_eq!(faults, [Fault::new("struts[2].b", "5", "a node index below 5")]);
    assert_eq!(paths(&broken(|g| g.struts[2] = strut(9, u32::MAX, 0.5, 0.5))), ["struts[2].a", "struts[2].b"]);
}

#[test]
fn self_loop() {
    let faults = broken(|g| g.struts.push(strut(3, 3, 0.5, 0.5)));
    assert_eq!(faults, [Fault::new("struts[7]", "both ends at nodes[3]", "two different nodes")]);
}

#[test]
fn zero_length_strut() {
    let faults = broken(|g| g.nodes[4] = g.nodes[1]);
    assert_eq!(paths(&faults), ["nodes[4]", "struts[6]"]);
    assert_eq!(faults[1].found, "length 0e0 mm between nodes[1] and nodes[4]");
}

#[test]
fn duplicate_strut_in_either_direction() {
    for twin in [strut(1, 2, 0.5, 0.5), strut(2, 1, 0.5, 0.5)] {
        let faults = broken(|g| g.struts.push(twin));
        assert_eq!(faults, [Fault::new("struts[7]", "the same nodes 1 and 2 as struts[3]", "at most one strut between two nodes")]);
    }
}

#[test]
fn radius_zero_negative_or_not_finite() {
    for (r, found) in [(0.0, "0"), (-0.5, "-0.5"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
        assert_eq!(broken(|g| g.struts[4].ra = r), [Fault::new("struts[4].ra", found, "a radius > 0")]);
        assert_eq!(broken(|g| g.struts[4].rb = r), [Fault::new("struts[4].rb", found, "a radius > 0")]);
    }
    assert!(paths(&broken(|g| g.struts[4].ra = 1e-310)).contains(&"struts[4].ra"));
}

#[test]
fn tapers_and_unequal_radii_at_a_node_are_sound() {
    assert_eq!(broken(|g| g.struts[6].rb = 0.25), vec![]);
    assert_eq!(broken(|g| g.struts[6] = strut(1, 4, 0.25, 0.25)), vec![]);
}

#[test]
fn parts_may_differ_in_radius() {
    let faults = broken(|g| {
        g.nodes.extend([dvec3(50.0, 0.0, 0.0), dvec3(60.0, 0.0, 0.0)]);
        g.struts.push(strut(5, 6, 2.0, 2.0));
    });
    assert_eq!(faults, vec![]);
}

#[test]
fn lattice_too_far_from_the_origin() {
    assert_eq!(broken(|g| g.nodes.iter_mut().for_each(|p| *p += 1e6)), vec![]);
    assert_eq!(paths(&broken(|g| g.nodes.iter_mut().for_each(|p| *p += 1e10))), ["nodes"]);
}

#[test]
fn struts_that_cross_without_a_node() {
    // A strut of its own, past the axis of strut 0 at 0.7 mm where 1 mm is wanted; at 1.1 mm it holds.
    let crossing = |at: f64| {
        broken(|g| {
            g.nodes.extend([dvec3(5.0, -at, -20.0), dvec3(5.0, -at, 2.0)]);
            g.struts.push(strut(5, 6, 0.5, 0.5));
        })
    };
    let faults = crossing(0.7);
    assert_eq!(paths(&faults), ["struts[7]"]);
    assert_eq!(faults[0].found, "its axis 0.700000 mm from that of struts[0] at [5.000000, -0.350000, 0.000000]");
    assert_eq!(faults[0].wanted, "more than 1 mm, the sum of the radii, or a common node");
    assert_eq!(crossing(1.1), vec![]);
}

#[test]
fn all_faults_are_told_at_once() {
    let faults = broken(|g| {
        g.nodes[0].x = f64::NAN;
        g.struts[1].ra = -1.0;
        g.struts[3] = strut(2, 2, 0.5, 0.5);
        g.struts[5].b = NodeId(77);
        g.struts.push(strut(4, 1, 0.5, 0.5));
    });
    assert_eq!(paths(&faults), ["nodes[0][0]", "struts[3]", "struts[5].b", "struts[7]", "struts[1].ra"]);
}

#[test]
fn faults_of_form_and_of_content_are_told_together_and_none_twice() {
    let text = r#"{"nodes":[[0,0,0],[NaN,0,0],[0,5,0]],
        "struts":[{"a":0,"b":1,"ra":1,"rb":1},{"a":0,"b":-2,"ra":1,"rb":1},{"a":0,"b":2,"ra":"x","rb":-3},{"a":2,"b":2,"ra":1,"rb":1}]}"#;
    let Err(Error::BadInput(faults)) = graph::read(text.as_bytes()) else { panic!("refused") };
    assert_eq!(paths(&faults), ["nodes[1][0]", "struts[1].b", "struts[2].ra", "struts[3]", "struts[2].rb"]);
}

#[test]
fn form_that_cannot_be_read_has_one_fault_and_no_echoes() {
    let Err(Error::BadInput(faults)) = graph::read(b"nonsense") else { panic!("refused") };
    assert_eq!(paths(&faults), ["document"]);
    let Err(error) = graph::read(br#"{"struts":[{"a":0,"b":1,"ra":1,"rb":1}]}"#) else { panic!("refused") };
    assert_eq!(error.to_string(), "1 fault in the input:\n  nodes: found nothing, wanted an array of nodes [x, y, z]");
    assert_eq!(error.exit_code(), 2);
}

#[test]
fn node_without_struts_is_noted_and_keeps_the_ids_of_the_others() {
    let text = r#"{"name":"n","nodes":[[0,0,0],[9,9,9],[0,5,0]],"struts":[{"a":0,"b":2,"ra":1,"rb":1}]}"#;
    let lattice = graph::read(text.as_bytes()).unwrap();
    assert_eq!(lattice.notes.iter().map(ToString::to_string).collect::<Vec<_>>(), ["nodes[1]: has no strut: left out"]);
    assert_eq!(lattice.graph.used_nodes().collect::<Vec<_>>(), [NodeId(0), NodeId(2)]);
    assert_eq!(lattice.name.as_deref(), Some("n"));
}

#[test]
fn radii_that_differ_by_round_off_become_equal_and_are_noted() {
    let text = r#"{"nodes":[[0,0,0],[9,0,0],[0,9,0]],"struts":[{"a":0,"b":1,"ra":0.3,"rb":0.3},{"a":0,"b":2,"ra":0.30000000000000004,"rb":0.3}]}"#;
    let lattice = graph::read(text.as_bytes()).unwrap();
    assert!(lattice.graph.struts().iter().all(|s| s.ra == 0.3 && s.rb == 0.3));
    assert_eq!(lattice.notes.len(), 1);
    assert_eq!(lattice.notes[0].path, "struts[1].ra");
}

#[test]
fn overlaps_are_refused_or_kept_as_notes() {
    let text = br#"{"nodes":[[0,0,0],[10,0,0],[5,-5,1],[5,5,1]],"struts":[{"a":0,"b":1,"ra":0.6,"rb":0.6},{"a":2,"b":3,"ra":0.6,"rb":0.6}]}"#;
    let Err(Error::BadInput(faults)) = graph::read(text) else { panic!("refused") };
    assert_eq!(paths(&faults), ["struts[1]"]);
    let lattice = graph::read_with(text, Overlaps::Keep).unwrap();
    assert_eq!(lattice.notes.iter().map(|n| n.path.as_str()).collect::<Vec<_>>(), ["struts[1]"]);
}
