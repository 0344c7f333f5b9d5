//! Connected parts: numbering, sizes, genus.

use glam::DVec3;
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::components::{ComponentId, ComponentSize, apart, components};
use lattice_brep::graph::{Graph, Strut};
use lattice_brep::ids::{NodeId, StrutId};

fn graph(nodes: u32, ends: &[(u32, u32)]) -> Graph {
    let strut = |&(a, b): &(u32, u32)| Strut { a: NodeId(a), b: NodeId(b), ra: 1.0, rb: 1.0 };
    Graph::new((0..nodes).map(|k| DVec3::X * f64::from(k)).collect(), ends.iter().map(strut).collect())
}

#[test]
fn parts_are_numbered_by_their_smallest_strut() {
    // Strut 0 joins the last nodes; node 3 has no strut; struts 1 and 2 become one part only through strut 4.
    let parts = components(&graph(8, &[(7, 6), (0, 1), (5, 4), (1, 2), (2, 4), (6, 7)]));
    assert_eq!(parts.of_strut.iter().map(|id| id.0).collect::<Vec<_>>(), [0, 1, 1, 1, 1, 0]);
    let (first, second) = (Some(ComponentId(0)), Some(ComponentId(1)));
    assert_eq!(parts.of_node, [second, second, second, None, second, second, first, first]);
    assert_eq!(parts.sizes, [ComponentSize { nodes: 2, struts: 2 }, ComponentSize { nodes: 5, struts: 4 }]);
}

#[test]
fn genus_counts_independent_loops() {
    let genus = |graph: &Graph| components(graph).sizes.iter().map(|s| s.genus()).collect::<Vec<_>>();
    assert_eq!(genus(&graph(4, &[(0, 1), (1, 2), (1, 3)])), [0]);
    assert_eq!(genus(&graph(6, &[(0, 1), (1, 2), (2, 0), (3, 4), (4, 5)])), [1, 0]);
    assert_eq!(genus(&generate(Cell::Cubic, 1.0, [1, 1, 1], 0.1).unwrap()), [5]);
}

#[test]
fn members_are_listed_by_part_in_ascending_order() {
    let strut = |a, b| Strut { a: NodeId(a), b: NodeId(b), ra: 1.0, rb: 1.0 };
    let graph = Graph::new(vec![DVec3::ZERO; 6], vec![strut(5, 1), strut(0, 4), strut(1, 2)]);
    let found = components(&graph).members();
    assert_eq!(found.len(), 2);
    assert_eq!((&found[0].nodes[..], &found[0].struts[..]), (&[NodeId(1), NodeId(2), NodeId(5)][..], &[StrutId(0), StrutId(2)][..]));
    assert_eq!((&found[1].nodes[..], &found[1].struts[..]), (&[NodeId(0), NodeId(4)][..], &[StrutId(1)][..]));
}

#[test]
fn struts_between_groups_do_not_connect_and_are_in_both_parts() {
    // a ring of four in two groups, and a node without struts
    let found = apart(&graph(5, &[(0, 1), (1, 2), (2, 3), (3, 0)]), &[1, 1, 0, 0, 0]);
    let listed: Vec<(Vec<u32>, Vec<u32>)> = found.iter().map(|m| (m.nodes.iter().map(|n| n.0).collect(), m.struts.iter().map(|s| s.0).collect())).collect();
    assert_eq!(listed, [(vec![2, 3], vec![1, 2, 3]), (vec![0, 1], vec![0, 1, 3])]);
    // a chain whose ends are in one group is three parts
    assert_eq!(apart(&graph(3, &[(0, 1), (1, 2)]), &[0, 1, 0]).len(), 3);
}
