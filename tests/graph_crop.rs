//! Crop: what stays whole, what is cut, what is dropped.

use glam::{DVec3, dvec3};
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::crop::{Cropped, crop};
use lattice_brep::graph::{Graph, Strut};
use lattice_brep::ids::{NodeId, StrutId};

const R: f64 = 0.5;

fn path(places: &[DVec3]) -> Graph {
    let strut = |k: u32| Strut { a: NodeId(k), b: NodeId(k + 1), ra: R, rb: R };
    Graph::new(places.to_vec(), (0..places.len() as u32 - 1).map(strut).collect())
}

/// Two struts in a line, from x = 0 through 10 to 30, cropped at x.
fn cropped_at(x: f64) -> Cropped {
    crop(&path(&[DVec3::ZERO, DVec3::X * 10.0, DVec3::X * 30.0]), DVec3::splat(-5.0), dvec3(x, 5.0, 5.0))
}

fn places(c: &Cropped) -> Vec<f64> {
    c.graph.nodes().iter().map(|p| p.x).collect()
}

#[test]
fn whole_graph_inside_is_unchanged() {
    let graph = generate(Cell::Octet, 10.0, [2, 2, 2], R).unwrap();
    let c = crop(&graph, DVec3::ZERO, DVec3::splat(20.0));
    assert_eq!(c.graph.nodes(), graph.nodes());
    assert_eq!(c.graph.struts(), graph.struts());
    assert_eq!(c.nodes, graph.node_ids().map(Some).collect::<Vec<_>>());
    assert_eq!(c.struts, (0..graph.struts().len() as u32).map(StrutId).collect::<Vec<_>>());
}

#[test]
fn crossing_strut_is_cut_at_the_face() {
    let c = cropped_at(20.0);
    assert_eq!(places(&c), [0.0, 10.0, 20.0]);
    assert_eq!(c.nodes, [Some(NodeId(0)), Some(NodeId(1)), None]);
    assert_eq!(c.struts, [StrutId(0), StrutId(1)]);
    assert_eq!(c.graph.struts()[1], Strut { a: NodeId(1), b: NodeId(2), ra: R, rb: R });
    assert_eq!(c.graph.degree(NodeId(2)), 1);
}

#[test]
fn strut_cut_at_its_first_end_keeps_its_direction() {
    let c = crop(&path(&[DVec3::ZERO, DVec3::X * 10.0]), dvec3(6.0, -1.0, -1.0), dvec3(20.0, 1.0, 1.0));
    assert_eq!(places(&c), [10.0, 6.0]);
    assert_eq!(c.graph.struts(), [Strut { a: NodeId(1), b: NodeId(0), ra: R, rb: R }]);
}

#[test]
fn tapered_strut_keeps_its_taper() {
    let strut = |a: u32, b: u32, ra: f64, rb: f64| Strut { a: NodeId(a), b: NodeId(b), ra, rb };
    let nodes = vec![DVec3::ZERO, DVec3::X * 10.0, DVec3::X * 30.0];
    for radii in [[0.1, 0.7, 0.3], [0.7, 0.1, 0.3]] {
        let graph = Graph::new(nodes.clone(), vec![strut(0, 1, radii[0], radii[1]), strut(1, 2, radii[1], radii[2])]);
        let c = crop(&graph, DVec3::splat(-5.0), dvec3(15.0, 5.0, 5.0));
        assert_eq!(places(&c), [0.0, 10.0, 15.0]);
        assert_eq!(c.graph.struts()[0], graph.struts()[0]); // bit for bit
        let cut = c.graph.struts()[1];
        assert_eq!(cut.ra, radii[1]);
        assert!((cut.rb - (0.75 * radii[1] + 0.25 * radii[2])).abs() < 1e-15, "{cut:?}");
        let at_cut = graph.radius_at(graph.arms(NodeId(2))[0], 15.0);
        assert!((at_cut - cut.rb).abs() < 1e-15);
    }
}

#[test]
fn long_strut_is_cut_at_its_middle_at_the_latest() {
    let c = cropped_at(28.0);
    assert_eq!(places(&c), [0.0, 10.0, 20.0]);
    assert_eq!(c.nodes, [Some(NodeId(0)), Some(NodeId(1)), None]);
}

#[test]
fn short_stub_is_cut_with_room_outside_the_box() {
    // 1.2 mm would be left: less than three radii, more than one.
    let c = cropped_at(11.2);
    assert_eq!(places(&c), [0.0, 10.0, 11.5]);
    assert_eq!(c.nodes, [Some(NodeId(0)), Some(NodeId(1)), None]);
}

#[test]
fn stub_shorter_than_its_radius_is_dropped() {
    for x in [10.0, 10.4] {
        let c = cropped_at(x);
        assert_eq!(places(&c), [0.0, 10.0]);
        assert_eq!(c.struts, [StrutId(0)]);
    }
}

#[test]
fn sharp_angle_needs_more_room() {
    // Two struts 0.2 rad apart: the paper's cut is about 6.5 mm from the node, so a face 6 mm away cuts further out.
    let graph = Graph::new(
        vec![DVec3::ZERO, dvec3(30.0, 3.0, 0.0), dvec3(30.0, -3.0, 0.0)],
        vec![Strut { a: NodeId(0), b: NodeId(1), ra: R, rb: R }, Strut { a: NodeId(0), b: NodeId(2), ra: R, rb: R }],
    );
    let reach = |x: f64| crop(&graph, DVec3::splat(-9.0), dvec3(x, 9.0, 9.0)).graph.nodes().iter().map(|p| p.x).fold(0.0, f64::max);
    assert!((8.0..9.0).contains(&reach(6.0)), "{}", reach(6.0));
    assert!((reach(12.0) - 12.0).abs() < 1e-12, "{}", reach(12.0));
}

#[test]
fn strut_without_a_node_inside_is_dropped() {
    let graph = path(&[DVec3::X * -20.0, DVec3::X * 20.0]);
    let c = crop(&graph, DVec3::splat(-5.0), DVec3::splat(5.0));
    assert_eq!((c.graph.nodes().len(), c.graph.struts().len()), (0, 0));
}

#[test]
fn box_along_planes_of_nodes_shows_no_stubs() {
    // One cell out of 3x3x3 is one cell.
    for cell in [Cell::Cubic, Cell::Bcc, Cell::BccEdges, Cell::Fcc, Cell::Octet, Cell::Diamond] {
        let c = crop(&generate(cell, 10.0, [3, 3, 3], R).unwrap(), DVec3::splat(10.0), DVec3::splat(20.0));
        let one = generate(cell, 10.0, [1, 1, 1], R).unwrap();
        assert_eq!(c.graph.nodes().iter().map(|&p| p - 10.0).collect::<Vec<_>>(), one.nodes(), "{}", cell.name());
        assert_eq!(c.graph.struts(), one.struts(), "{}", cell.name());
        assert!(c.nodes.iter().all(Option::is_some), "{}", cell.name());
    }
}

#[test]
fn cut_ends_lie_on_a_face_or_mid_strut_and_have_one_strut() {
    let graph = generate(Cell::Kelvin, 10.0, [3, 3, 3], 0.2).unwrap();
    let on = |x: f64, face: f64| (x - face).abs() < 1e-12;
    let (min, max) = (DVec3::splat(4.0), dvec3(21.0, 22.0, 23.0));
    let c = crop(&graph, min, max);
    let ends: Vec<NodeId> = c.graph.node_ids().filter(|n| c.nodes[n.index()].is_none()).collect();
    assert!(ends.len() > 20, "{}", ends.len());
    for n in ends {
        let p = c.graph.nodes()[n.index()];
        assert_eq!(c.graph.degree(n), 1);
        let arm = c.graph.arms(n)[0];
        let whole = graph.length(c.struts[arm.strut.index()]);
        let kept = c.graph.length(arm.strut) / whole;
        let on_face = (0..3).any(|k| on(p[k], min[k]) || on(p[k], max[k]));
        assert!(on_face && kept < 0.5 + 1e-12 || on(kept, 0.5), "{p} {kept}");
    }
    for (new, old) in c.graph.struts().iter().zip(&c.struts) {
        let line = |s: &Strut, g: &Graph| (g.nodes()[s.b.index()] - g.nodes()[s.a.index()]).normalize();
        assert!(line(new, &c.graph).distance(line(&graph.struts()[old.index()], &graph)) < 1e-12);
    }
}

#[test]
fn tapered_strut_has_at_the_cut_the_radius_it_has_there() {
    let cone = |a: u32, b: u32, ra: f64, rb: f64| {
        let graph = Graph::new(vec![DVec3::ZERO, DVec3::X * 20.0], vec![Strut { a: NodeId(a), b: NodeId(b), ra, rb }]);
        crop(&graph, DVec3::splat(-5.0), dvec3(8.0, 5.0, 5.0)).graph
    };
    // from 1 to 0.5 over 20 mm: 0.8 at 8 mm
    let cut = cone(0, 1, 1.0, 0.5);
    assert_eq!((cut.nodes()[1], cut.struts()), (DVec3::X * 8.0, &[Strut { a: NodeId(0), b: NodeId(1), ra: 1.0, rb: 0.8 }][..]));
    let turned = cone(1, 0, 0.5, 1.0);
    assert!((turned.nodes()[1] - DVec3::X * 8.0).length() < 1e-14 && (turned.struts()[0].ra - 0.8).abs() < 1e-15);
    assert_eq!((turned.struts()[0].a, turned.struts()[0].b, turned.struts()[0].rb), (NodeId(1), NodeId(0), 1.0));
}
