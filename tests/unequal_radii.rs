//! Nodes whose struts have unequal radii or taper: exact rims, smooth skins, closed solids.

mod common;

use common::{Random, random};
use glam::DVec3;
use lattice_brep::graph::{Arm, End, Graph, Lattice, Strut};
use lattice_brep::ids::NodeId;
use lattice_brep::options::Options;
use lattice_brep::pipeline::{self, Silent, Solved};

/// Struts from one node in these directions, each with its radius at the node and at its far end (mm), long enough for any cuts.
fn fan(axes: &[DVec3], radii: &[[f64; 2]]) -> Lattice {
    let nodes = std::iter::once(DVec3::ZERO).chain(axes.iter().map(|a| 40.0 * a.normalize())).collect();
    let struts = radii.iter().enumerate().map(|(k, &[ra, rb])| Strut { a: NodeId(0), b: NodeId(k as u32 + 1), ra, rb }).collect();
    Lattice { name: None, graph: Graph::new(nodes, struts), notes: vec![] }
}

fn solved(name: &str, lattice: &Lattice) -> Solved {
    pipeline::solve(lattice, &Options::default(), &Silent).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Rims have the graph's radius where they are; the skin is smooth and on a soap film.
fn assert_sound(name: &str, lattice: &Lattice) {
    let solved = solved(name, lattice);
    let report = &solved.report;
    assert_eq!(report.rungs.soap_film + report.rungs.no_ball.len(), 1, "{name}: {:?}", report.rungs);
    assert!(report.quality.inner_jump_deg.value < 1e-5, "{name}: {} inside", report.quality.inner_jump_deg.value);
    assert!(report.quality.rim_jump_deg.value < 1e-6, "{name}: {} at rims", report.quality.rim_jump_deg.value);
    assert!(report.quality.facing.value > 0.0);
    let [solid] = &solved.model.solids[..] else { panic!("{name}: one solid") };
    for &strut in &solid.struts {
        let circle = solid.rim(strut.index(), 0);
        let wanted = lattice.graph.radius_at(Arm { strut, end: End::A }, circle.center.length());
        assert!((circle.radius - wanted).abs() <= 1e-12 * wanted, "{name}: strut {}: {} instead of {wanted}", strut.0, circle.radius);
        assert!(!solid.strut_face(strut.index()).boundary.is_empty());
    }
}

#[test]
fn random_radii() {
    for (degree, least) in [(2, 50.0), (3, 40.0), (4, 40.0), (6, 35.0), (9, 28.0), (14, 22.0)] {
        for seed in 1..=4 {
            let mut numbers = Random::new(100 * degree as u64 + seed);
            let radii: Vec<[f64; 2]> = (0..degree).map(|_| [0.2 + 0.8 * numbers.next(); 2]).collect();
            assert_sound(&format!("degree {degree}, seed {seed}"), &fan(&random(seed, degree, least), &radii));
        }
    }
}

#[test]
fn random_tapers() {
    for (degree, least) in [(2, 60.0), (3, 50.0), (5, 40.0), (8, 30.0)] {
        for seed in 1..=3 {
            let mut numbers = Random::new(200 * degree as u64 + seed);
            let mut radius = || 0.3 + 0.7 * numbers.next();
            let radii: Vec<[f64; 2]> = (0..degree).map(|_| [radius(), radius()]).collect();
            assert_sound(&format!("degree {degree}, seed {seed}"), &fan(&random(seed, degree, least), &radii));
        }
    }
}

/// A straight strut that changes its radius, a right angle, and a thin strut on a thick one.
#[test]
fn hand_made_nodes() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    assert_sound("straight", &fan(&[x, -x], &[[1.0; 2], [0.5; 2]]));
    assert_sound("straight taper", &fan(&[x, -x], &[[1.0, 0.4], [1.0, 1.3]]));
    assert_sound("right angle", &fan(&[x, y], &[[1.0; 2], [0.25; 2]]));
    assert_sound("thin on thick", &fan(&[x, -x, z], &[[1.0; 2], [1.0; 2], [0.1; 2]]));
    assert_sound("cross", &fan(&[x, -x, y, -y], &[[1.0; 2], [1.0; 2], [0.3; 2], [0.3; 2]]));
}

/// Two struts alone: once refused in bands of angle, and at small ones.
#[test]
fn pairs() {
    for (ratio, degrees) in [(0.3, 48.0), (0.25, 60.0), (0.2, 70.0), (0.1, 52.0), (0.1, 100.0), (0.5, 15.0), (0.3, 18.0), (0.9, 14.0)] {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        assert_sound(&format!("{ratio} at {degrees}°"), &fan(&[DVec3::X, DVec3::new(cos, sin, 0.0)], &[[ratio; 2], [1.0; 2]]));
    }
}

/// One radius at the node, and struts that shrink or grow away from it.
#[test]
fn equal_radii_with_tapers() {
    let (x, y) = (DVec3::X, DVec3::Y);
    assert_sound("one shrinks", &fan(&[x, y], &[[1.0, 0.3], [1.0; 2]]));
    assert_sound("one grows", &fan(&[x, y], &[[1.0, 1.8], [1.0; 2]]));
    assert_sound("one shrinks, one grows", &fan(&[x, y], &[[1.0, 0.3], [1.0, 1.8]]));
}

/// The order of the struts and the unit of length change nothing but round-off.
#[test]
fn invariant() {
    let axes = random(7, 6, 35.0);
    let radii = [[1.0, 1.0], [0.4, 0.6], [0.7, 0.7], [0.9, 0.3], [0.5, 0.5], [0.6, 0.8]];
    let volume = |lattice: &Lattice| solved("invariant", lattice).report.volume_mm3;
    let plain = volume(&fan(&axes, &radii));
    let mut turned: Vec<_> = axes.iter().copied().zip(radii).collect();
    turned.rotate_left(2);
    let (axes_turned, radii_turned): (Vec<_>, Vec<_>) = turned.into_iter().unzip();
    assert!((volume(&fan(&axes_turned, &radii_turned)) / plain - 1.0).abs() < 1e-9);
    let fan = fan(&axes, &radii);
    let scaled: Vec<DVec3> = fan.graph.nodes().iter().map(|p| 1e-3 * *p).collect();
    let struts = fan.graph.struts().iter().map(|s| Strut { ra: 1e-3 * s.ra, rb: 1e-3 * s.rb, ..*s }).collect();
    let small = Lattice { name: None, graph: Graph::new(scaled, struts), notes: vec![] };
    assert!((volume(&small) / plain * 1e9 - 1.0).abs() < 1e-9);
}
