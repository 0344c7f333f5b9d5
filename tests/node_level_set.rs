//! The level-set film: cylinders at the rims, star-shaped, never inside the original shape, closed forms.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::node::level_set::LevelSet;

#[test]
fn it_is_the_cylinder_at_the_rims_and_beyond() {
    for (name, axes) in all_nodes() {
        let star = star(axes);
        let set = LevelSet::new(&star);
        for (&c, &cut) in star.axes.iter().zip(&star.cuts) {
            let (e, f) = c.any_orthonormal_pair();
            for k in 0..32 {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / 32.0).sin_cos();
                let out = cos * e + sin * f;
                for height in [cut, 1.2 * cut, 2.0 * cut] {
                    let p = height * c + out;
                    let hit = set.hit(p);
                    assert!((hit.distance / p.length() - 1.0).abs() < 1e-9, "{name}: {} instead of {}", hit.distance, p.length());
                    assert!(degrees(hit.normal, out) < 1e-6, "{name}: normal {}° off", degrees(hit.normal, out));
                }
            }
        }
    }
}

#[test]
fn it_deviates_outward_only_and_faces_away_from_the_node() {
    for (name, axes) in all_nodes() {
        let star = star(axes);
        let set = LevelSet::new(&star);
        let mut most = 0.0f64;
        for u in fibonacci(2000) {
            let (hit, original) = (set.hit(u), star.original(u));
            assert!(hit.distance >= original * (1.0 - 1e-12), "{name}: inside the original shape");
            // the reach bounds it: 1.3 radii from the nearest strut
            assert!(hit.distance <= 1.3 * original * (1.0 + 1e-12), "{name}");
            assert!(hit.normal.dot(u) > 0.0, "{name}: not star-shaped");
            most = most.max(hit.distance / original - 1.0);
        }
        assert!(most > 1e-3, "{name}: no blend");
    }
}

/// In the middle between m struts, each at distance d: m g(d) = g(1), so 1 - d²/R² = m^(-1/3) (1 - 1/R²).
#[test]
fn blends_of_symmetric_nodes_are_closed_forms() {
    let cases = [
        (octahedron(), DVec3::ONE, 3.0, 1.3),
        (octahedron(), DVec3::new(1.0, 1.0, 0.0), 2.0, 1.3),
        (bcc(), DVec3::Z, 4.0, 1.3),
        (fcc(), DVec3::Z, 4.0, 1.3),
        (vec![DVec3::X, DVec3::Z], DVec3::new(1.0, 0.0, 1.0), 2.0, 1.3),
        // a straight node's rims reach 0.2 past the other strut's end
        (vec![DVec3::Z, -DVec3::Z], DVec3::X, 2.0, (1.0f64 + 0.2 * 0.2).sqrt()),
    ];
    for (axes, direction, m, reach) in cases {
        let star = star(axes);
        let (u, r2) = (direction.normalize(), reach * reach);
        let want = reach * (1.0 - f64::powf(m, -1.0 / 3.0) * (1.0 - 1.0 / r2)).sqrt() * star.original(u);
        let hit = LevelSet::new(&star).hit(direction);
        assert!((hit.distance - want).abs() < 1e-12, "{} instead of {want}", hit.distance);
        assert!(hit.normal.distance(u) < 1e-12);
    }
}

/// The largest distance from the original shape that the octahedron had in the prototype: 0.0998.
#[test]
fn the_octahedron_deviates_as_measured() {
    let star = star(octahedron());
    let set = LevelSet::new(&star);
    let off = |u: DVec3| {
        let p = set.hit(u).distance * u;
        star.axes.iter().map(|&c| p.distance(p.dot(c).max(0.0) * c)).fold(f64::INFINITY, f64::min) - 1.0
    };
    let most = fibonacci(20_000).map(off).fold(0.0, f64::max);
    assert!((most - 0.0998).abs() < 1e-3, "{most}");
}

#[test]
fn normals_are_those_of_the_surface() {
    for (name, axes) in catalogue() {
        let set = LevelSet::new(&star(axes));
        for u in fibonacci(200) {
            let hit = set.hit(u);
            let (e, f) = u.any_orthonormal_pair();
            for side in [e, f] {
                let h = 1e-5;
                let [a, b] = [1.0, -1.0].map(|s| {
                    let w = (u + s * h * side).normalize();
                    set.hit(w).distance * w
                });
                let sine = hit.normal.dot((a - b).normalize());
                assert!(sine.abs() < 1e-3, "{name}: tangent and normal meet at {sine}");
            }
        }
    }
}
