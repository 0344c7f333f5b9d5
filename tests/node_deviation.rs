//! Signed distance to the original node, against closed forms and against brute force over the surface itself.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::node::Star;
use lattice_brep::node::deviation::Original;

/// Samples over the sphere, and around the bisector plane of each pair of struts, where all creases lie.
const SPREAD: usize = 20_000;
const ROUND: usize = 720;

/// Points of the surface, by `Star::original`: it knows nothing of feet, creases and what covers what.
fn surface(star: &Star) -> Vec<DVec3> {
    let axes = &star.axes;
    let pairs = (0..axes.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let circles = pairs.flat_map(|(i, j)| {
        let (e, f) = (axes[i] - axes[j]).normalize().any_orthonormal_pair();
        (0..ROUND).map(move |k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / ROUND as f64).sin_cos();
            cos * e + sin * f
        })
    });
    fibonacci(SPREAD).chain(circles).map(|u| star.original(u) * u).collect()
}

/// Distance to the nearest half axis, less 1: 0 on the surface and nowhere inside.
fn to_axes(star: &Star, p: DVec3) -> f64 {
    star.axes.iter().map(|c| (p - p.dot(*c).max(0.0) * *c).length() - 1.0).fold(f64::INFINITY, f64::min)
}

/// The point of the surface that a distance is measured to: p - d grad d, as d falls at rate 1 towards it.
fn foot(original: &Original, p: DVec3) -> DVec3 {
    let step = 1e-6;
    let slope = |axis: DVec3| (original.distance(p + step * axis) - original.distance(p - step * axis)) / (2.0 * step);
    p - original.distance(p) * v(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
}

/// Points in and around the node: shares 0.1 to 1.3 of the way to the surface, and near the creases.
fn points<'a>(star: &'a Star, numbers: &'a mut Random, count: usize) -> impl Iterator<Item = DVec3> + 'a {
    (0..count).map(move |k| {
        let mut u = numbers.direction();
        if k % 3 == 0 && star.degree() > 1 {
            // towards a crease
            let n = star.degree();
            let i = (numbers.next() * n as f64) as usize;
            let v = star.axes[i] + star.axes[(i + 1) % n] + 0.3 * u;
            u = v.normalize();
        }
        (0.1 + 1.2 * numbers.next()) * star.original(u).min(4.0) * u
    })
}

/// No sampled point of the surface is nearer, and there is one as near.
#[test]
fn it_is_the_distance_to_the_surface() {
    let (mut inside, mut on_creases) = (0, 0);
    for (name, axes) in all_nodes() {
        let star = star(axes);
        let (original, samples) = (Original::new(&star).unwrap(), surface(&star));
        let mut numbers = Random::new(1001);
        for p in points(&star, &mut numbers, 60) {
            let found = original.distance(p);
            assert_eq!(found > 0.0, p.length() > star.original(p.normalize()), "{name}: {p}");
            let nearest = samples.iter().map(|q| q.distance_squared(p)).fold(f64::INFINITY, f64::min).sqrt();
            assert!(found.abs() < nearest + 1e-12, "{name}: {p}: {found}, but a point of the surface is {nearest} away");
            let q = foot(&original, p);
            assert!(to_axes(&star, q).abs() < 1e-7, "{name}: {p}: {found} leads to {q}, which is {} off the surface", to_axes(&star, q));
            inside += usize::from(found < 0.0);
            on_creases += usize::from(star.axes.iter().filter(|c| (q.cross(**c).length() - 1.0).abs() < 1e-7 && q.dot(**c) > 0.0).count() > 1);
        }
    }
    assert!(inside > 2000 && on_creases > 500, "{inside} points inside, {on_creases} nearest to a crease");
}

/// Six struts along the axes: creases x = y at a distance 1 from both axes, meeting where all coordinates are equal.
#[test]
fn octahedron_by_hand() {
    let original = Original::new(&star(octahedron())).unwrap();
    let half = 0.5f64.sqrt();
    for (p, wanted) in [
        (v(3.0, 0.2, 0.0), -0.8),                        // foot on a cylinder
        (v(3.0, 0.0, 1.5), 0.5),                         // outside
        (v(0.5, 0.5, 0.0), -half),                       // crease, at (1, 1, 0)
        (v(half, half, 0.0), 1.0 - 2f64.sqrt()),         // crease; the nearest cylinder is only 1 - sqrt(1/2) away
        (v(0.6, 0.6, 0.6), -(half - 0.6) * 3f64.sqrt()), // triple point
        (v(1.0, 1.0, 1.0), 2f64.sqrt() - 1.0),           // outside, over a triple point
        (v(half, half, half), 0.0),                      // triple point
    ] {
        assert!((original.distance(p) - wanted).abs() < 1e-14, "{p}: {} instead of {wanted}", original.distance(p));
    }
}

#[test]
fn a_single_strut_is_a_capsule() {
    let original = Original::new(&star(vec![DVec3::Z])).unwrap();
    for (p, wanted) in [(v(0.3, 0.0, 5.0), -0.7), (v(0.0, 2.0, 1.0), 1.0), (v(0.3, 0.0, -0.4), -0.5), (v(0.0, 3.0, -4.0), 4.0)] {
        assert!((original.distance(p) - wanted).abs() < 1e-14, "{p}: {}", original.distance(p));
    }
}

#[test]
fn the_film_before_fairing_starts_on_it() {
    for (name, axes) in all_nodes() {
        let star = star(axes);
        let original = Original::new(&star).unwrap();
        for u in fibonacci(500) {
            let p = star.original(u).min(50.0) * u;
            if star.original(u) < 50.0 {
                assert!(original.distance(p).abs() < 1e-9, "{name}: {p} is {}", original.distance(p));
            }
        }
    }
}

#[test]
fn unequal_radii_are_refused() {
    assert!(Original::new(&unequal(octahedron())).is_err());
    let mut tapered = star(octahedron());
    tapered.tapers[2] = 0.01;
    assert!(Original::new(&tapered).is_err());
}
