//! Struts that come too close: the tree against comparing all pairs, and the segment distance against closed forms.

use glam::{DVec3, dvec3};
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::proximity::{closest_points, near_misses};
use lattice_brep::graph::{Graph, Strut};
use lattice_brep::ids::{NodeId, StrutId};
use proptest::prelude::*;

fn point() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-10.0..10.0f64).prop_map(DVec3::from_array)
}

/// The smallest distance over a fine grid of both segments: an upper bound, at most a step off.
fn sampled(a: [DVec3; 2], b: [DVec3; 2]) -> f64 {
    let on = |s: [DVec3; 2], k: u32| s[0].lerp(s[1], f64::from(k) / 200.0);
    (0..=200).flat_map(|i| (0..=200).map(move |j| (i, j))).map(|(i, j)| on(a, i).distance(on(b, j))).fold(f64::INFINITY, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn segment_distance_agrees_with_sampling(a in [point(), point()], b in [point(), point()]) {
        let (p, q) = closest_points(a, b);
        let step = (a[0].distance(a[1]) + b[0].distance(b[1])) / 400.0;
        let (exact, upper) = (p.distance(q), sampled(a, b));
        prop_assert!(exact <= upper + 1e-12 && upper <= exact + step, "{exact} against {upper}");
    }

    #[test]
    fn tree_agrees_with_comparing_all_pairs(nodes in prop::collection::vec(point(), 60), ends in prop::collection::vec((0..60u32, 0..60u32), 150), r in 0.01..0.5f64) {
        let ends = ends.into_iter().filter(|(a, b)| a != b);
        let graph = Graph::new(nodes, ends.map(|(a, b)| Strut { a: NodeId(a), b: NodeId(b), ra: r, rb: r }).collect());
        let segment = |s: &Strut| [graph.nodes()[s.a.index()], graph.nodes()[s.b.index()]];
        let mut expected = Vec::new();
        for (k, t) in graph.struts().iter().enumerate() {
            for (j, s) in graph.struts()[..k].iter().enumerate() {
                let share = s.a == t.a || s.a == t.b || s.b == t.a || s.b == t.b;
                let (p, q) = closest_points(segment(s), segment(t));
                if !share && p.distance(q) <= 2.0 * r {
                    expected.push((StrutId(j as u32), StrutId(k as u32), p.distance(q)));
                }
            }
        }
        let found: Vec<_> = near_misses(&graph).into_iter().map(|m| (m.a, m.b, m.distance)).collect();
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn segment_distance_in_every_position() {
    let x = [DVec3::ZERO, DVec3::X * 4.0];
    let distance = |b: [DVec3; 2]| {
        let (p, q) = closest_points(x, b);
        let (q2, p2) = closest_points(b, x);
        assert!((p.distance(q) - p2.distance(q2)).abs() < 1e-15);
        p.distance(q)
    };
    assert_eq!(distance([dvec3(1.0, -1.0, 2.0), dvec3(1.0, 1.0, 2.0)]), 2.0, "crossing inside both");
    assert_eq!(distance([dvec3(2.0, 3.0, 0.0), dvec3(2.0, 9.0, 0.0)]), 3.0, "end against inside");
    assert_eq!(distance([dvec3(7.0, 4.0, 0.0), dvec3(9.0, 9.0, 0.0)]), 5.0, "end against end");
    assert_eq!(distance([dvec3(3.0, 1.5, 0.0), dvec3(9.0, 1.5, 0.0)]), 1.5, "parallel, side by side");
    assert_eq!(distance([dvec3(6.0, 0.0, 0.0), dvec3(9.0, 0.0, 0.0)]), 2.0, "in one line, apart");
    assert_eq!(distance([dvec3(2.0, 0.0, 0.0), dvec3(9.0, 0.0, 0.0)]), 0.0, "in one line, overlapping");
    assert_eq!(distance([dvec3(1.0, 0.0, 0.0), dvec3(3.0, 0.0, 0.0)]), 0.0, "one within the other");
    assert!((distance([dvec3(0.0, 1.0, 0.0), dvec3(4.0, 1.0 + 1e-9, 0.0)]) - 1.0).abs() < 1e-15, "almost parallel");
}

#[test]
fn touching_struts_are_too_close() {
    let pair = |height: f64| {
        let nodes = vec![dvec3(-5.0, 0.0, 0.0), dvec3(5.0, 0.0, 0.0), dvec3(0.0, -5.0, height), dvec3(0.0, 5.0, height)];
        let strut = |a, b| Strut { a: NodeId(a), b: NodeId(b), ra: 0.5, rb: 0.5 };
        near_misses(&Graph::new(nodes, vec![strut(0, 1), strut(2, 3)]))
    };
    let [miss] = pair(1.0)[..] else { panic!("one pair") };
    assert_eq!((miss.a, miss.b, miss.distance, miss.wanted, miss.at), (StrutId(0), StrutId(1), 1.0, 1.0, dvec3(0.0, 0.0, 0.5)));
    assert_eq!(pair(1.001), vec![]);
}

#[test]
fn radius_at_which_cubic_struts_touch() {
    // Parallel struts of the cube are one cell apart.
    let count = |radius: f64| near_misses(&generate(Cell::Cubic, 10.0, [1, 1, 1], radius).unwrap()).len();
    assert_eq!(count(4.99), 0);
    // Twelve pairs of parallel struts a cell apart, and each strut 10 mm from four of the eight it neither meets nor runs along.
    assert_eq!(count(5.0), 12 + 12 * 4 / 2);
}
