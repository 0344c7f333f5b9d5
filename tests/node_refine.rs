//! PN-Loop with circle sampling: Loop's weights, exact circles and cylinders, counts.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::node::fair::{HOLD, fair};
use lattice_brep::node::film::{Control, control_mesh};
use lattice_brep::node::mesh::{Mesh, NONE, Rim, Triangles};
use lattice_brep::node::refine::refine;
use lattice_brep::node::{Cells, Fairing, Star};
use std::f64::consts::TAU;

fn unfaired(axes: Vec<DVec3>) -> (Star, Control) {
    let star = star(axes);
    let control = control_mesh(&star, &Cells::new(&star).unwrap());
    (star, control)
}

fn control(axes: Vec<DVec3>) -> (Star, Control) {
    let (star, mut control) = unfaired(axes);
    fair(&mut control, Fairing::Ray, HOLD).unwrap();
    (star, control)
}

/// A flat fan of `n` triangles in z = 0 around vertex 0, with flat normals: no lift. The outer ring counts as a rim.
fn fan(n: usize, centre: DVec3) -> Control {
    let ring = (0..n).map(|k| flat(360.0 * k as f64 / n as f64));
    Control {
        points: std::iter::once(centre).chain(ring).collect(),
        free: vec![true; n + 1],
        normals: vec![Some(DVec3::Z); n + 1],
        triangles: Triangles((0..n).map(|k| [0, 1 + k as u32, 1 + ((k + 1) % n) as u32]).collect()),
        rims: std::iter::once(None).chain((0..n).map(|_| Some(Rim { arm: 0 }))).collect(),
    }
}

/// β of equation 8 from the place of the fan's centre: (1 - n β) of where it was.
fn beta(n: usize) -> f64 {
    let star = Star::uniform(vec![DVec3::Z], vec![1.0]);
    let start = DVec3::new(0.25, 0.125, 0.0);
    let end = refine(fan(n, start), &star, 1).points[0];
    assert!(end.z.abs() < 1e-15 && end.cross(start).length() < 1e-15);
    (1.0 - end.dot(start) / start.length_squared()) / n as f64
}

#[test]
fn vertex_weights_are_loop_s() {
    for (n, want) in [(3, 3.0 / 16.0), (4, 31.0 / 256.0), (6, 1.0 / 16.0), (9, 0.0337850)] {
        assert!((beta(n) - want).abs() < 1e-7, "valence {n}: {}", beta(n));
    }
    // the neighbours' share tends to 5/8 - (5/8)²
    assert!((2000.0 * beta(2000) - 15.0 / 64.0).abs() < 1e-5);
}

#[test]
fn edge_points_are_loop_s() {
    let n = 6;
    let star = Star::uniform(vec![DVec3::Z], vec![1.0]);
    let mesh = refine(fan(n, DVec3::new(0.25, 0.125, 0.0)), &star, 1);
    let old = fan(n, DVec3::new(0.25, 0.125, 0.0)).points;
    for k in 0..n {
        let ring = |k: usize| old[1 + k % n];
        let want = 0.375 * (old[0] + ring(k)) + 0.125 * (ring(k + 1) + ring(k + n - 1));
        assert!(mesh.points[n + 1..].iter().any(|p| p.distance(want) < 1e-15), "no edge point at {want}");
    }
}

/// Points and normals of a cylinder stay on it, for any spacing of columns and rows.
#[test]
fn a_cylinder_stays_a_cylinder() {
    for phase in [0.0, 0.37] {
        let (star, mut control) = unfaired(vec![DVec3::Z, -DVec3::Z]);
        for (v, p) in control.points.iter_mut().enumerate() {
            if control.rims[v].is_none() {
                // shear the mesh along the cylinder
                let turn = phase * (star.cuts[0] - p.z.abs());
                *p = DVec3::new(p.x * turn.cos() - p.y * turn.sin(), p.x * turn.sin() + p.y * turn.cos(), p.z + 0.1 * phase * p.x * (0.2 - p.z.abs()));
            }
            control.normals[v] = Some(DVec3::new(p.x, p.y, 0.0).normalize());
        }
        let mesh = refine(control, &star, 3);
        for p in &mesh.points {
            assert!((p.x.hypot(p.y) - 1.0).abs() < 1e-12, "{p}");
        }
    }
}

/// The same without help: a straight node's own control mesh. Fairing bends it by a hundred-thousandth.
#[test]
fn a_straight_node_is_its_cylinder() {
    for ((star, control), most) in [(unfaired(vec![DVec3::Z, -DVec3::Z]), 1e-12), (control(vec![DVec3::Z, -DVec3::Z]), 2e-5)] {
        for p in &refine(control, &star, 3).points {
            assert!((p.x.hypot(p.y) - 1.0).abs() < most, "{p}");
        }
    }
}

#[test]
fn a_sphere_stays_a_sphere() {
    let mut triangles = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let mut points = octahedron();
    // twice by hand: the lift takes only neighbours within 60°
    for _ in 0..2 {
        let mut middle = |a: u32, b: u32| {
            let p = (points[a as usize] + points[b as usize]).normalize();
            points.iter().position(|q| q.distance(p) < 1e-9).unwrap_or_else(|| {
                points.push(p);
                points.len() - 1
            }) as u32
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [d, e, f] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
            })
            .collect();
    }
    let n = points.len();
    let normals = points.iter().copied().map(Some).collect();
    let control = Control { points, free: vec![true; n], normals, triangles: Triangles(triangles), rims: vec![None; n] };
    let mesh = refine(control, &Star::uniform(vec![], vec![]), 3);
    assert_eq!(mesh.triangles.0.len(), 8 * 16 * 64);
    assert!(mesh.points.iter().all(|p| (p.length() - 1.0).abs() < 1e-13));
    assert!(mesh.twins.iter().all(|&t| t != NONE));
}

/// Start vertices of the half-edges on rims, by arm.
fn rim_vertices(mesh: &Mesh, star: &Star) -> Vec<Vec<usize>> {
    let mut out = vec![Vec::new(); star.degree()];
    for h in (0..mesh.twins.len()).filter(|&h| mesh.twins[h] == NONE) {
        let v = mesh.triangles.0[h / 3][h % 3] as usize;
        let at = |arm: usize| (mesh.points[v] - star.cuts[arm] * star.axes[arm]).length();
        let arm = (0..star.degree()).min_by(|&a, &b| (at(a) - 1.0).abs().total_cmp(&(at(b) - 1.0).abs())).unwrap();
        out[arm].push(v);
    }
    out
}

#[test]
fn rims_stay_exact_circles() {
    for (name, axes) in catalogue() {
        let (star, control) = control(axes);
        let coarse = control.rims.iter().flatten().count();
        let mesh = refine(control, &star, 3);
        let rims = rim_vertices(&mesh, &star);
        assert_eq!(rims.iter().flatten().count(), 8 * coarse, "{name}");
        for (arm, vertices) in rims.iter().enumerate() {
            for &v in vertices {
                let out = mesh.points[v] - star.cuts[arm] * star.axes[arm];
                assert!(out.dot(star.axes[arm]).abs() < 1e-12 && (out.length() - 1.0).abs() < 1e-12, "{name}: {out}");
                assert!(mesh.normals[v].distance(out) < 1e-12, "{name}: normal on a rim");
            }
        }
    }
}

#[test]
fn circle_sampling_halves_every_arc() {
    let (star, control) = control(random(3, 5, 40.0));
    let azimuths = |mesh: &Mesh| -> Vec<f64> {
        let c = star.axes[0];
        let (e, f) = c.any_orthonormal_pair();
        let mut out: Vec<f64> = rim_vertices(mesh, &star)[0].iter().map(|&v| mesh.points[v].dot(f).atan2(mesh.points[v].dot(e))).collect();
        out.sort_by(f64::total_cmp);
        out
    };
    let (coarse, fine) = (azimuths(&refine(control.clone(), &star, 0)), azimuths(&refine(control, &star, 1)));
    assert_eq!(fine.len(), 2 * coarse.len());
    for (k, &a) in coarse.iter().enumerate() {
        let b = if k + 1 < coarse.len() { coarse[k + 1] } else { coarse[0] + TAU };
        let middle = 0.5 * (a + b);
        for want in [a, middle] {
            assert!(fine.iter().any(|f| ((f - want + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU).abs() < 1e-12), "no rim vertex at {want}");
        }
    }
}

#[test]
fn each_level_has_four_times_the_facets_and_twins_match() {
    let (star, control) = control(octahedron());
    let facets = control.triangles.0.len();
    for levels in 0..=3 {
        let mesh = refine(control.clone(), &star, levels);
        assert_eq!(mesh.triangles.0.len(), facets * 4usize.pow(levels));
        assert_eq!(mesh.twins, mesh.triangles.twins(), "level {levels}");
    }
}

/// All regular and lattice nodes stay star-shaped; of the random nodes most (measured: 48 of 64).
#[test]
fn refined_films_are_star_shaped() {
    let folded = |axes: Vec<DVec3>| {
        let (star, control) = control(axes);
        refine(control, &star, 3).facing().1
    };
    for (name, axes) in catalogue() {
        if !name.starts_with("pair") {
            assert_eq!(folded(axes), 0, "{name}");
        }
    }
    let stars = sixty_four().filter(|(_, axes)| folded(axes.clone()) == 0).count();
    assert!(stars >= 46, "{stars} of 64 random films are star-shaped");
}
