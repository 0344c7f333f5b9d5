//! Struts that come too close: the tree against comparing all pairs, and the segment distance against closed forms.

use glam::{DVec3, dvec3};
use lattice_brep::graph::catalogue::{Cell, generate};
use lattice_brep::graph::proximity::{Body, bodies, closest_points, gap, near_misses, within};
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

/// A strut from `p` to `q` for `gap`.
fn body(p: DVec3, q: DVec3, radii: [f64; 2]) -> Body {
    Body { strut: StrutId(0), ends: [0, 1], p, q, radii }
}

/// Distance (mm) from `x` to the truncated cone and its two node balls, below zero inside one of them: plane geometry in the
/// half plane of (along the axis, away from it), nothing of the balls that `gap` works with.
fn distance_to(b: &Body, x: DVec3) -> f64 {
    let (axis, length) = ((b.q - b.p).normalize(), b.p.distance(b.q));
    let (z, h) = (axis.dot(x - b.p), (x - b.p).reject_from(axis).length());
    let [ra, rb] = b.radii;
    let corners = [[0.0, 0.0], [0.0, ra], [length, rb], [length, 0.0]];
    let side = |[[z0, h0], [z1, h1]]: [[f64; 2]; 2]| {
        let t = (((z - z0) * (z1 - z0) + (h - h0) * (h1 - h0)) / ((z1 - z0).powi(2) + (h1 - h0).powi(2))).clamp(0.0, 1.0);
        (z - z0 - t * (z1 - z0)).hypot(h - h0 - t * (h1 - h0))
    };
    let nearest = corners.windows(2).map(|w| side([w[0], w[1]])).fold(f64::INFINITY, f64::min);
    let inside = z >= 0.0 && z <= length && h <= ra + (rb - ra) * z / length;
    let cone = if inside { -nearest } else { nearest };
    cone.min(x.distance(b.p) - ra).min(x.distance(b.q) - rb)
}

/// Points on the surface of the truncated cone and its node balls, and the largest distance between neighbours (mm).
fn surface(b: &Body) -> (Vec<DVec3>, f64) {
    const STEPS: u32 = 48;
    let axis = (b.q - b.p).normalize();
    let (e, f) = axis.any_orthonormal_pair();
    let turn = |k: u32| f64::from(k) / f64::from(STEPS) * std::f64::consts::TAU;
    let mut points = vec![];
    for (i, j) in (0..=STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
        let (s, (sin, cos)) = (f64::from(i) / f64::from(STEPS), turn(j).sin_cos());
        let out = cos * e + sin * f;
        points.push(b.p.lerp(b.q, s) + (b.radii[0] + s * (b.radii[1] - b.radii[0])) * out);
        let (up, flat) = (0.5 * turn(i)).sin_cos();
        points.extend([b.p, b.q].iter().zip(b.radii).map(|(&c, r)| c + r * (flat * axis + up * out)));
    }
    let largest = b.radii[0].max(b.radii[1]);
    (points, (b.p.distance(b.q) + 4.0 * std::f64::consts::PI * largest) / f64::from(STEPS))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn cone_distance_agrees_with_sampled_surfaces(ends in prop::array::uniform4(point()), r in prop::array::uniform4(0.05..3.0f64)) {
        let (a, b) = (body(ends[0], ends[1], [r[0], r[1]]), body(ends[2], ends[3], [r[2], r[3]]));
        let exact = gap(&a, &b).clearance();
        prop_assert!((exact - gap(&b, &a).clearance()).abs() < 1e-12);
        for (one, other) in [(&a, &b), (&b, &a)] {
            let (points, step) = surface(other);
            let sampled = points.iter().map(|&x| distance_to(one, x)).fold(f64::INFINITY, f64::min);
            if exact > 0.0 {
                prop_assert!(exact <= sampled + 1e-9 && sampled <= exact + step, "{exact} against {sampled}");
            } else {
                prop_assert!(sampled <= step, "crossing by {exact}, yet {sampled} apart");
            }
        }
    }

    #[test]
    fn tree_agrees_with_comparing_all_pairs_of_cones(nodes in prop::collection::vec(point(), 60), ends in prop::collection::vec((0..60u32, 0..60u32, 0.01..0.6f64, 0.01..0.6f64), 150), margin in 0.0..0.5f64) {
        let ends = ends.into_iter().filter(|(a, b, ..)| a != b);
        let graph = Graph::new(nodes, ends.map(|(a, b, ra, rb)| Strut { a: NodeId(a), b: NodeId(b), ra, rb }).collect());
        let all = bodies(&graph);
        let mut expected = Vec::new();
        for (k, t) in all.iter().enumerate() {
            for s in &all[..k] {
                let g = gap(s, t);
                let distance = g.points[0].distance(g.points[1]);
                if !s.ends.iter().any(|e| t.ends.contains(e)) && distance <= g.radii * (1.0 + margin) {
                    expected.push((s.strut, t.strut, distance, g.radii));
                }
            }
        }
        let found: Vec<_> = within(&all, margin).into_iter().map(|m| (m.a, m.b, m.distance, m.wanted)).collect();
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn cone_distance_in_closed_form() {
    // A cone from radius 1 to 3 over 10 along x, and a parallel strut of radius 1: nearest beside the wide end.
    let cone = body(DVec3::ZERO, DVec3::X * 10.0, [1.0, 3.0]);
    let clearance = |b: Body| gap(&cone, &b).clearance();
    assert!((clearance(body(dvec3(0.0, 6.0, 0.0), dvec3(10.0, 6.0, 0.0), [1.0, 1.0])) - 2.0).abs() < 1e-12, "node ball of the wide end");
    // A thin strut square to the cone's axis, past its middle: 6 mm to the axis less the cone there, square to its side.
    let across = body(dvec3(5.0, 6.0, -9.0), dvec3(5.0, 6.0, 9.0), [0.5, 0.5]);
    assert!((clearance(across) - (4.0 / 1.04f64.sqrt() - 0.5)).abs() < 1e-12, "square to the slope 1/5");
    assert!((clearance(body(dvec3(-4.0, 0.0, 0.0), dvec3(-9.0, 0.0, 0.0), [1.0, 1.0])) - 2.0).abs() < 1e-12, "in one line, by the narrow end");
    assert!(clearance(body(dvec3(5.0, -4.0, 0.0), dvec3(5.0, 4.0, 0.0), [0.1, 0.2])) < -2.0, "through the axis");
    // The larger radius along the whole length would refuse this one: the narrow end leaves it room.
    let beside_narrow = body(dvec3(0.0, 3.0, -5.0), dvec3(0.0, 3.0, 5.0), [1.0, 1.0]);
    assert!(clearance(beside_narrow) > 0.7, "{}", clearance(beside_narrow));
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
