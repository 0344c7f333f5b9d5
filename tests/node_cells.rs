//! Spherical Voronoi cells: counts of known nodes, what makes a corner a corner, the convex hull as an oracle, and
//! nodes next to degenerate ones.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::node::Cells;
use lattice_brep::node::cells::{Frame, LEAST_SNAP, SNAP, Side, WIDEST};
use parry3d_f64::transformation::try_convex_hull;
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

fn cells(name: &str, axes: Vec<DVec3>) -> Cells {
    Cells::new(&star(axes)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The struts around each corner.
fn struts(cells: &Cells) -> Vec<BTreeSet<usize>> {
    let mut around = vec![BTreeSet::new(); cells.corners.len()];
    for side in &cells.sides {
        side.corners.iter().for_each(|&k| around[k].extend(side.arms));
    }
    around
}

/// Corners where three cells or more meet, all corners, sides.
fn counts(axes: Vec<DVec3>) -> [usize; 3] {
    let cells = cells("", axes);
    [struts(&cells).iter().filter(|s| s.len() > 2).count(), cells.corners.len(), cells.sides.len()]
}

#[test]
fn counts_of_regular_nodes() {
    assert_eq!(counts(octahedron()), [8, 8, 12]);
    assert_eq!(counts(bcc()), [6, 6, 12]);
    assert_eq!(counts(fcc()), [14, 14, 24]);
    assert_eq!(counts([bcc(), octahedron()].concat()), [24, 24, 36]);
    assert_eq!(counts(tetrahedron()), [4, 4, 6]);
    assert_eq!(counts(icosahedron()), [20, 20, 30]);
    assert_eq!(counts(dodecahedron()), [12, 12, 30]);
}

#[test]
fn counts_of_nodes_with_wide_sides() {
    let oct = octahedron();
    // one circle, quartered
    assert_eq!(counts(vec![oct[4], oct[5]]), [0, 4, 4]);
    assert_eq!(counts(vec![oct[0], oct[4]]), [0, 4, 4]);
    assert_eq!(counts(vec![flat(0.0), flat(160.0)]), [0, 4, 4]);
    // half circles between two corners, halved
    assert_eq!(counts(vec![flat(0.0), flat(120.0), flat(240.0)]), [2, 5, 6]);
    assert_eq!(counts(vec![oct[0], oct[1], oct[2]]), [2, 5, 6]);
    assert_eq!(counts(vec![flat(0.0), flat(40.0), flat(80.0)]), [2, 5, 6]);
    assert_eq!(counts(oct[..4].to_vec()), [2, 6, 8]);
    // half circles from -135° to 45°: cut at -90° and at 0°
    assert_eq!(counts(vec![oct[0], oct[2], oct[4]]), [2, 8, 9]);
    // from -90° to 45°: cut at 0°
    assert_eq!(counts(vec![oct[0], oct[1], oct[2], oct[4]]), [4, 8, 10]);
    assert_eq!(counts(oct[..5].to_vec()), [5, 9, 12]);
}

/// Not so where exactly opposite struts share a side: its azimuth 0 is then arbitrary.
#[test]
fn counts_do_not_depend_on_the_frame() {
    let mut numbers = Random::new(7);
    for (name, axes) in catalogue().into_iter().filter(|(name, _)| !OPPOSITE.contains(name)) {
        let want = counts(axes.clone());
        for _ in 0..20 {
            let q = numbers.rotation();
            assert_eq!(counts(axes.iter().map(|&a| q * a).collect()), want, "{name} turned by {q}");
        }
    }
}

#[test]
fn corners_are_as_far_from_all_struts_around_and_no_strut_is_nearer() {
    for (name, axes) in all_nodes() {
        let star = star(axes);
        let cells = Cells::joined(&star, LEAST_SNAP).unwrap();
        for (k, arms) in cells.corners.iter().zip(struts(&cells)) {
            for (arm, c) in star.axes.iter().enumerate() {
                let (near, height) = (k.cross(*c).length(), k.dot(*c));
                let own = k.dot(star.axes[*arms.first().unwrap()]);
                if arms.contains(&arm) {
                    assert!((near - 1.0).abs() < 1e-4, "{name}: corner {k} is {near} from strut {arm}");
                    assert!((height - own).abs() < 1e-4 * k.length(), "{name}");
                } else {
                    assert!(height < own + 1e-4, "{name}: strut {arm} is nearer to corner {k}");
                }
            }
        }
    }
}

/// The middle of each side is nearest to its own two struts; and sides tile each strut's full turn of azimuth.
#[test]
fn sides_lie_between_their_struts_and_close_around_each() {
    for (name, axes) in all_nodes() {
        let star = star(axes);
        let cells = Cells::joined(&star, LEAST_SNAP).unwrap();
        for side in &cells.sides {
            let [a, b] = side.phi;
            assert!(a < b && b - a < WIDEST + 1e-3, "{name}: {}°..{}°", a.to_degrees(), b.to_degrees());
            let y = side.frame.crease(0.5 * (a + b));
            let [own, other] = side.arms.map(|k| y.dot(star.axes[k]));
            assert!((own - other).abs() < 1e-9 * y.length(), "{name}");
            assert!(star.axes.iter().all(|c| y.dot(*c) < own + 1e-9 * y.length()), "{name}");
        }
        for (arm, ring) in cells.around.iter().enumerate() {
            let turn: f64 = ring.iter().map(|&(s, _)| cells.sides[s].phi[1] - cells.sides[s].phi[0]).sum();
            assert!((turn - TAU).abs() < 1e-3, "{name}: strut {arm} has {turn} rad around it");
            for (k, &(s, which)) in ring.iter().enumerate() {
                let (t, with) = ring[(k + 1) % ring.len()];
                assert_eq!(cells.sides[s].arms[which], arm);
                assert_eq!(cells.sides[s].corners[1 - which], cells.sides[t].corners[with], "{name}: ring of strut {arm}");
            }
        }
    }
}

/// Facets of the hull of the directions are the corners; their outward normals are the corners' directions, also where
/// the hull misses the node.
#[test]
fn corners_are_the_facets_of_the_convex_hull() {
    let (mut checked, mut half_space) = (0, 0);
    for seed in 1..=300 {
        let degree = 4 + (seed % 27) as usize;
        let axes = random(seed, degree, 5.0);
        let (points, facets) = try_convex_hull(&axes).unwrap();
        // the hull has its own order of points
        let arm = |p: DVec3| axes.iter().position(|a| a.distance(p) < 1e-12).unwrap();
        let mut want: Vec<(BTreeSet<usize>, DVec3)> = Vec::new();
        let mut holds = true;
        for f in &facets {
            let [a, b, c] = f.map(|k| points[k as usize]);
            let n = (b - a).cross(c - a).normalize();
            holds &= n.dot(a) > 0.0;
            want.push(([a, b, c].map(arm).into(), n));
        }
        let apart = (0..want.len()).all(|i| (0..i).all(|j| want[i].1.distance(want[j].1) > 20.0 * LEAST_SNAP));
        if !apart {
            continue; // not in general position
        }
        let cells = Cells::joined(&star(axes), LEAST_SNAP).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        let around = struts(&cells);
        let corners: Vec<usize> = (0..around.len()).filter(|&k| around[k].len() > 2).collect();
        assert_eq!(corners.len(), want.len(), "seed {seed}, degree {degree}");
        for (arms, n) in want {
            let near = corners.iter().find(|&&k| around[k] == arms).unwrap_or_else(|| panic!("seed {seed}: no corner between {arms:?}"));
            assert!(cells.corners[*near].normalize().distance(n) < 1e-9, "seed {seed}: corner between {arms:?}");
        }
        checked += 1;
        half_space += usize::from(!holds);
    }
    assert!(checked > 250 && half_space > 10, "{checked} nodes checked, {half_space} in a half space");
}

/// Noise splits the corners of regular nodes where four or five cells meet; the noise crosses `LEAST_SNAP`.
#[test]
fn cells_close_next_to_degenerate_nodes() {
    let regular = [octahedron(), bcc(), fcc(), dodecahedron(), octahedron()[..4].to_vec(), octahedron()[..5].to_vec(), vec![flat(0.0), flat(40.0), flat(80.0)]];
    for (which, axes) in regular.iter().enumerate() {
        for noise in [1e-15, 1e-12, 1e-9, 1e-6, 1e-5, 3e-5, 5e-5, 1e-4, 1e-3] {
            for seed in 1..=20 {
                let mut numbers = Random::new(seed);
                let shaken = axes.iter().map(|a| a.normalize() + noise * numbers.direction()).collect();
                let cells = cells(&format!("node {which}, noise {noise}, seed {seed}"), shaken);
                for ring in &cells.around {
                    let turn: f64 = ring.iter().map(|&(s, _)| cells.sides[s].phi[1] - cells.sides[s].phi[0]).sum();
                    assert!((turn - TAU).abs() < 0.01, "node {which}, noise {noise}, seed {seed}: {turn}");
                }
            }
        }
    }
}

#[test]
fn noise_below_the_snap_does_not_change_the_cells() {
    for (axes, want) in [(octahedron(), [8, 8, 12]), (fcc(), [14, 14, 24]), (icosahedron(), [20, 20, 30])] {
        for noise in [1e-12, 1e-9, 1e-6, 1e-3, 0.02] {
            for seed in 1..=10 {
                let mut numbers = Random::new(seed);
                assert_eq!(counts(axes.iter().map(|a| a.normalize() + noise * numbers.direction()).collect()), want, "noise {noise}, seed {seed}");
            }
        }
    }
}

/// Short sides go where each cell keeps three sides, or what it had.
#[test]
fn contraction_leaves_few_short_sides_and_no_slit_cells() {
    let short = |cells: &Cells| {
        let length = |side: &Side| side.corners.map(|k| cells.corners[k].normalize()).into_iter().reduce(|a, b| a - b).unwrap().length();
        cells.sides.iter().filter(|side| length(side) < SNAP).count()
    };
    let (mut before, mut after) = (0, 0);
    for (name, axes) in all_nodes() {
        let star = star(axes);
        let [all, contracted] = [LEAST_SNAP, SNAP].map(|snap| Cells::joined(&star, snap).unwrap_or_else(|e| panic!("{name}: {e}")));
        for (ring, full) in contracted.around.iter().zip(&all.around) {
            assert!(ring.len() >= full.len().min(3), "{name}: a cell of {} sides has {}", full.len(), ring.len());
        }
        before += short(&all);
        after += short(&contracted);
    }
    assert!(before >= 150 && 10 * after < before, "{before} short sides, {after} after contraction"); // measured: 159, 11
}

/// Azimuths about both struts of a side agree, and the crease lies on both unit cylinders.
#[test]
fn creases_lie_on_both_cylinders_at_one_azimuth() {
    for (name, axes) in all_nodes() {
        for side in cells(&name, axes).sides {
            for k in 0..=4 {
                let phi = side.phi[0] + 0.25 * k as f64 * (side.phi[1] - side.phi[0]);
                let y = side.frame.crease(phi);
                for which in 0..2 {
                    let off = (side.frame.azimuth(which, y) - phi + PI).rem_euclid(TAU) - PI;
                    assert!(off.abs() < 1e-9, "{name}");
                    assert!((y.cross(side.frame.c[which]).length() - 1.0).abs() < 1e-9 * y.length(), "{name}");
                }
            }
        }
    }
}

/// Struts that are opposite but for what a file's decimals leave: a cross product has lost most digits there, and rims would not be circles.
#[test]
fn frames_of_nearly_opposite_struts_are_orthonormal() {
    let a = DVec3::new(-0.21373687, -0.29961281, 0.92981112).normalize();
    let aside = a.any_orthonormal_vector();
    for tilt in [1e-2, 1e-4, 1e-6, 1e-8, 2.9e-9, 1.1e-9, 9e-10, 1e-12, 0.0] {
        let b = (tilt * aside - a).normalize();
        let frame = Frame::new([a, b], [1.0; 2]);
        for (k, axis) in [a, b].into_iter().enumerate() {
            let off = [axis.dot(frame.n[k]), axis.dot(frame.e[k]), frame.n[k].dot(frame.e[k])].map(f64::abs).into_iter().fold(0.0, f64::max);
            assert!(off < 4e-16, "tilt {tilt}, strut {k}: {off}");
        }
        assert!(frame.n[0].distance(frame.n[1]) < 1e-8, "tilt {tilt}");
    }
}
