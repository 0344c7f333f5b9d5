//! Equations 3-5 against closed forms, and what the cuts are for: rims apart from each other and from other struts.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::node::cut::{LEAST_ROOM, cuts};
use lattice_brep::node::star::angle;

fn assert_all(axes: Vec<DVec3>, want: f64) {
    for cut in star(axes).cuts {
        assert!((cut - want).abs() < 1e-14, "{cut} instead of {want}");
    }
}

#[test]
fn cuts_of_regular_nodes_are_closed_forms() {
    assert_all(octahedron(), 1.3); // cot 45°
    assert_all(tetrahedron(), 1.3 * 0.5f64.sqrt()); // cot of half of acos(-1/3)
    assert_all(fcc(), 1.3 * 3f64.sqrt()); // cot 30°
    assert_all(bcc(), 1.3 * 2f64.sqrt()); // cot of half of acos(1/3)
    assert_all(vec![flat(0.0), flat(60.0)], 1.3 * 3f64.sqrt());
}

#[test]
fn struts_far_apart_keep_the_least_room() {
    assert_all(vec![DVec3::Z, -DVec3::Z], LEAST_ROOM);
    assert_all(vec![flat(0.0), flat(120.0), flat(240.0)], 1.0 / 3f64.sqrt() + LEAST_ROOM);
}

#[test]
fn the_nearest_neighbour_decides() {
    let star = star(vec![flat(0.0), flat(40.0), flat(130.0)]);
    let cot = |degrees: f64| 1.0 / (0.5 * degrees).to_radians().tan();
    for (cut, want) in star.cuts.iter().zip([1.3 * cot(40.0), 1.3 * cot(40.0), 1.3 * cot(90.0)]) {
        assert!((cut - want).abs() < 1e-14);
    }
}

#[test]
fn lambda_stretches_the_cut() {
    for lambda in [0.25, 0.4, 0.49] {
        assert!((cuts(&octahedron(), lambda)[0] - (1.0 + lambda)).abs() < 1e-15);
    }
    // below 0.2 the least room takes over
    assert!((cuts(&octahedron(), 0.05)[0] - (1.0 + LEAST_ROOM)).abs() < 1e-15);
}

#[test]
fn a_single_strut_is_not_cut() {
    assert_eq!(cuts(&[DVec3::X], 0.3), [0.0]);
    assert!(cuts(&[], 0.3).is_empty());
}

#[test]
fn rims_are_disjoint_caps() {
    for (name, axes) in all_nodes() {
        let star = star(axes);
        for i in 0..star.degree() {
            for j in 0..i {
                let caps = (1.0 / star.cuts[i]).atan() + (1.0 / star.cuts[j]).atan();
                assert!(caps < angle(star.axes[i], star.axes[j]), "{name}: rims {i} and {j}");
            }
        }
    }
}

#[test]
fn rims_lie_outside_of_all_other_struts() {
    for (name, axes) in all_nodes() {
        let star = star(axes);
        for (i, (&c, &cut)) in star.axes.iter().zip(&star.cuts).enumerate() {
            let (e, f) = c.any_orthonormal_pair();
            for k in 0..64 {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / 64.0).sin_cos();
                let p = cut * c + cos * e + sin * f;
                for (j, &other) in star.axes.iter().enumerate().filter(|&(j, _)| j != i) {
                    assert!(p.distance(p.dot(other).max(0.0) * other) > 1.0 + 1e-3, "{name}: rim {i} touches strut {j}");
                }
            }
        }
    }
}
