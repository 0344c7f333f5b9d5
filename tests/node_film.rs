//! The control mesh: on the original shape, star-shaped, rows and valences as the paper draws them.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::node::film::{Control, FIXED_ROWS, LAYERS, STEP, columns, control_mesh, narrower};
use lattice_brep::node::{Cells, Star};
use std::collections::BTreeSet;

fn film(axes: Vec<DVec3>) -> (Star, Cells, Control) {
    let star = star(axes);
    let cells = Cells::new(&star).unwrap();
    let control = control_mesh(&star, &cells);
    (star, cells, control)
}

#[test]
fn every_vertex_lies_on_the_original_shape() {
    for (name, axes) in all_nodes() {
        let (star, _, control) = film(axes);
        for p in &control.points {
            // outside or on every half cylinder, on one of them or, behind all struts there, on the node sphere
            let ahead = star.axes.iter().filter(|c| p.dot(**c) > 0.0).map(|c| p.cross(*c).length()).fold(f64::INFINITY, f64::min);
            assert!(p.length() > 1.0 - 1e-9 && ahead > 1.0 - 1e-4, "{name}: {p} is inside");
            assert!((ahead - 1.0).abs() < 1e-4 || (p.length() - 1.0).abs() < 1e-9, "{name}: {p} is off the shape, {ahead}");
        }
    }
}

/// Rims of tapered struts have the radius of their cone, also where all radii at the node are equal.
#[test]
fn tapered_struts_keep_their_rims() {
    let mut star = star(vec![DVec3::X, DVec3::Y, DVec3::NEG_Z]);
    star.tapers = vec![-0.1, 0.0, 0.05];
    let control = control_mesh(&star, &Cells::new(&star).unwrap());
    for (p, rim) in control.points.iter().zip(&control.rims) {
        let Some(rim) = rim else { continue };
        let arm = rim.arm as usize;
        assert!((p.cross(star.axes[arm]).length() - star.rim_radius(arm)).abs() < 1e-12, "strut {arm}: {p}");
    }
}

#[test]
fn every_facet_faces_away_from_the_node() {
    for (name, axes) in all_nodes() {
        let (_, _, control) = film(axes);
        for t in &control.triangles.0 {
            let [a, b, c] = t.map(|v| control.points[v as usize]);
            assert!(a.dot(b.cross(c)) > 0.0, "{name}: folded at {}", (a + b + c) / 3.0);
        }
    }
}

/// Film and rim discs together are seen from the node in every direction exactly once.
#[test]
fn film_and_discs_cover_the_sphere_once() {
    let solid_angle = |[a, b, c]: [DVec3; 3]| {
        let [a, b, c] = [a, b, c].map(|p| p.normalize());
        2.0 * a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    };
    for (name, axes) in all_nodes() {
        let (star, _, control) = film(axes);
        let corners = |t: &[u32; 3]| t.map(|v| control.points[v as usize]);
        let mut sum: f64 = control.triangles.0.iter().map(|t| solid_angle(corners(t))).sum();
        for (arm, rows) in control.rows.iter().enumerate() {
            let rim = &rows[0];
            for (k, &a) in rim.iter().enumerate() {
                let [a, b] = [a, rim[(k + 1) % rim.len()]].map(|v| control.points[v as usize]);
                // counter-clockwise about the axis, seen from outside
                sum += solid_angle([a, b, star.cuts[arm] * star.axes[arm]]);
            }
        }
        assert!((sum - 4.0 * std::f64::consts::PI).abs() < 1e-9, "{name}: {sum}");
    }
}

#[test]
fn rim_vertices_are_on_their_circles_in_the_strut_s_own_frame() {
    for (name, axes) in all_nodes() {
        let (star, _, control) = film(axes);
        for (v, rim) in control.rims.iter().enumerate() {
            let Some(rim) = rim else { continue };
            let arm = rim.arm as usize;
            let out = control.points[v] - star.cuts[arm] * star.axes[arm];
            assert!(out.dot(star.axes[arm]).abs() < 1e-12 && (out.length() - 1.0).abs() < 1e-12, "{name}: rim vertex {v}");
            assert!(control.normals[v].unwrap().distance(out) < 1e-12, "{name}");
            assert!(!control.free[v], "{name}");
        }
    }
}

#[test]
fn columns_hold_the_crest_and_are_never_wider_than_the_step() {
    for (name, axes) in all_nodes() {
        for (side, columns) in Cells::new(&star(axes)).unwrap().sides.iter().flat_map(|side| [(side, columns(side)), (side, narrower(side))]) {
            let phis = columns;
            assert_eq!([phis[0], phis[phis.len() - 1]], side.phi, "{name}");
            assert!(phis.windows(2).all(|w| w[1] > w[0] && w[1] - w[0] < STEP + 1e-12), "{name}: {phis:?}");
            let [a, b] = side.phi;
            if a < -0.2 * (b - a) && b > 0.2 * (b - a) {
                assert!(phis.contains(&0.0), "{name}: the crest is missing in {phis:?}");
            }
        }
    }
}

/// Struts 90° apart have the usual columns; 20° apart, steps of 30° times 2 tan 10°.
#[test]
fn steep_creases_have_narrower_columns() {
    assert!(Cells::new(&star(octahedron())).unwrap().sides.iter().all(|s| narrower(s) == columns(s)));
    let pair = vec![DVec3::X, DVec3::new(20f64.to_radians().cos(), 20f64.to_radians().sin(), 0.0), DVec3::NEG_X];
    let cells = Cells::new(&star(pair)).unwrap();
    let step = STEP * 2.0 * 10f64.to_radians().tan();
    for side in cells.sides.iter().filter(|s| s.arms == [0, 1]) {
        let widest = |phis: &[f64]| phis.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        assert!(widest(&columns(side)) > step && widest(&narrower(side)) < step + 1e-9, "{step}");
    }
}

/// A quarter turn has the paper's three inserted points.
#[test]
fn rows_and_valences_of_the_octahedron() {
    let (star, cells, control) = film(octahedron());
    let around = 4 * 4; // four sides of four columns
    assert!(cells.sides.iter().all(|s| columns(s).len() == 5));
    assert_eq!(control.points.len(), 8 + 12 * 3 + 6 * around * LAYERS);
    assert_eq!(control.triangles.0.len(), 6 * around * LAYERS * 2);
    assert_eq!(control.free.iter().filter(|f| !**f).count(), 6 * around * FIXED_ROWS);
    assert_eq!(control.rims.iter().flatten().count(), 6 * around);
    assert_eq!(control.normals.iter().flatten().count(), 6 * around * 2);
    let mut near = vec![BTreeSet::new(); control.points.len()];
    for t in &control.triangles.0 {
        for k in 0..3 {
            near[t[k] as usize].extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
        }
    }
    for (v, near) in near.iter().enumerate() {
        // corners of three cells first; rims have no neighbours above
        let want = if v < 8 {
            9
        } else if control.rims[v].is_some() {
            4
        } else {
            6
        };
        assert_eq!(near.len(), want, "vertex {v}");
    }
    // rows descend evenly from the rim at 1.3
    let z = star.axes[0];
    let crest: Vec<f64> = control.points.iter().filter(|p| p.dot(z) > 0.99 && p.y.abs() < 1e-9 && p.z > 0.0).map(|p| p.dot(z)).collect();
    for want in [1.3, 1.225, 1.15, 1.075, 1.0] {
        assert!(crest.iter().any(|h| (h - want).abs() < 1e-12), "no row at {want} in {crest:?}");
    }
}
