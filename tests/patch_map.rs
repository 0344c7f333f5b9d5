//! The direction map: regular, polynomial, shared along edges, and the two identities that make G1 linear. Then the
//! conditions that `forms` solves, held against surfaces that meet them by nature: planes.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::math::bernstein::{Interpolation, basis};
use lattice_brep::node::Cells;
use lattice_brep::patch::forms::{CreaseForms, Form, JET, RadialForms, Tables};
use lattice_brep::patch::layout::Layout;
use lattice_brep::patch::map::{SectorMap, radial};

fn layout(name: &str, axes: Vec<DVec3>) -> Layout {
    let star = star(axes);
    Layout::new(&star, &Cells::new(&star).unwrap()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Derivative of a function that is polynomial of low degree: central difference of fourth order.
fn slope<T: std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>>(f: impl Fn(f64) -> T, x: f64) -> T {
    let h = 1e-3;
    (f(x + h) - f(x - h)) * (8.0 / (12.0 * h)) - (f(x + 2.0 * h) - f(x - 2.0 * h)) * (1.0 / (12.0 * h))
}

/// All sectors of the catalogue and the 64 random nodes: (name, layout, sector).
fn each_sector(mut f: impl FnMut(&str, &Layout, usize)) {
    for (name, axes) in all_nodes() {
        let layout = layout(&name, axes);
        (0..layout.sectors.len()).for_each(|k| f(&name, &layout, k));
    }
}

/// Those whose columns keep their azimuth.
fn each_straight_sector(mut f: impl FnMut(&str, &Layout, usize)) {
    let mut count = 0;
    each_sector(|name, layout, k| {
        if !layout.turned {
            f(name, layout, k);
            count += 1;
        }
    });
    assert!(count > 1000, "{count} sectors");
}

/// Height above the node over distance from the axis: η.
fn eta(layout: &Layout, sector: usize, s: f64, v: f64) -> f64 {
    let map = SectorMap::new(layout, sector);
    let c = layout.radials[layout.sectors[sector].radials[0]].c;
    map.y(s, v).dot(c) / (1.0 + map.t(s).powi(2))
}

#[test]
fn the_map_never_folds() {
    each_sector(|name, layout, k| {
        let map = SectorMap::new(layout, k);
        assert!(map.is_regular(), "{name}: sector {k}");
        // s runs counter-clockwise about the first strut and clockwise about the second
        let sense = if layout.sectors[k].which == 0 { -1.0 } else { 1.0 };
        for i in 0..=10 {
            for j in 0..=10 {
                let (s, v) = (0.1 * i as f64, 0.1 * j as f64);
                let (y, ys, yv) = (map.y(s, v), slope(|s| map.y(s, v), s), slope(|v| map.y(s, v), v));
                assert!(sense * y.dot(ys.cross(yv)) > 0.0, "{name}: sector {k} at ({s}, {v})");
            }
        }
    });
}

#[test]
fn the_map_is_cubic_along_the_crease_and_quartic_across() {
    each_straight_sector(|name, layout, k| {
        let map = SectorMap::new(layout, k);
        let fourth = |f: &dyn Fn(f64) -> DVec3| f(0.0) - 4.0 * f(0.25) + 6.0 * f(0.5) - 4.0 * f(0.75) + f(1.0);
        let fifth = |f: &dyn Fn(f64) -> DVec3| f(0.0) - 5.0 * f(0.2) + 10.0 * f(0.4) - 10.0 * f(0.6) + 5.0 * f(0.8) - f(1.0);
        for x in [0.0, 0.3, 0.8] {
            let size = map.y(x, x).length();
            assert!(fourth(&|s| map.y(s, x)).length() < 1e-10 * size, "{name}: along sector {k}");
            assert!(fifth(&|v| map.y(x, v)).length() < 1e-10 * size, "{name}: across sector {k}");
        }
    });
}

#[test]
fn rims_are_circles_and_columns_keep_their_azimuth() {
    each_straight_sector(|name, layout, k| {
        let map = SectorMap::new(layout, k);
        let r = &layout.radials[layout.sectors[k].radials[0]];
        for i in 0..=8 {
            let s = i as f64 / 8.0;
            let p = map.y(s, 0.0) / (1.0 + map.t(s).powi(2));
            assert!((p.dot(r.c) - r.cut).abs() < 1e-12 * r.cut.max(1.0) && (p.cross(r.c).length() - 1.0).abs() < 1e-12, "{name}: {p} is off rim {}", r.arm);
            let out = |v: f64| (map.y(s, v) - map.y(s, v).dot(r.c) * r.c).normalize();
            for v in [0.3, 0.7, 1.0] {
                assert!(degrees(out(0.0), out(v)) < 0.02, "{name}: sector {k} turns by {}°", degrees(out(0.0), out(v)));
            }
        }
    });
}

/// Both sectors of a crease, and all sectors of a radial, look in the same directions there.
#[test]
fn neighbours_share_their_edges() {
    each_sector(|name, layout, k| {
        let map = SectorMap::new(layout, k);
        let sector = &layout.sectors[k];
        let other = SectorMap::new(layout, k ^ 1);
        for i in 0..=8 {
            let x = i as f64 / 8.0;
            assert!(map.y(x, 1.0).distance(other.y(x, 1.0)) < 1e-9 * map.y(x, 1.0).length(), "{name}: crease {}", sector.crease);
            for end in 0..2 {
                let r = &layout.radials[sector.radials[end]];
                let w2 = map.scale_of_ends()[end];
                let y = map.y(end as f64, x) / w2;
                assert!(y.distance(radial(r, layout.corners[r.corner].k, x)) < 1e-9 * y.length(), "{name}: radial {}", sector.radials[end]);
            }
        }
    });
}

/// ∂η/∂v = -l(t) on the crease, l linear.
#[test]
fn columns_cross_the_crease_at_the_speed_of_their_corners() {
    each_straight_sector(|name, layout, k| {
        let map = SectorMap::new(layout, k);
        let ends = layout.sectors[k].radials.map(|r| layout.radials[r].speed);
        for i in 0..=8 {
            let s = i as f64 / 8.0;
            let l = -slope(|v| eta(layout, k, s, v), 1.0);
            assert!((l - map.speed(s)).abs() < 1e-7 * (1.0 + l.abs()), "{name}: sector {k}, s = {s}: {l} instead of {}", map.speed(s));
            assert!((map.speed(s) - (1.0 - s) * ends[0] - s * ends[1]).abs() < 1e-12 * l.abs().max(1.0), "{name}: speed is not linear");
        }
    });
}

/// ∂η/∂φ = c(v) ∂η/∂v on the radials, c quadratic with c(0) = 0.
#[test]
fn the_map_is_sheared_along_radials_as_promised() {
    each_straight_sector(|name, layout, k| {
        let map = SectorMap::new(layout, k);
        for end in 0..2 {
            let s = end as f64;
            let [_, shear, _] = map.across_radial(end);
            let c = |v: f64| basis(2, v)[0].iter().zip(&shear).map(|(b, c)| b * c).sum::<f64>() / (2.0 * map.dt());
            assert_eq!(c(0.0), 0.0);
            let third = c(1.0) - 3.0 * c(2.0 / 3.0) + 3.0 * c(1.0 / 3.0);
            assert!(third.abs() < 1e-12 * (1.0 + c(0.5).abs() + c(1.0).abs()), "{name}: the shear is not quadratic");
            for i in 0..=8 {
                let v = i as f64 / 8.0;
                // t = tan(φ/2): dφ = 2 dt / (1 + t²)
                let per_s = 2.0 * map.dt() / (1.0 + map.t(s).powi(2));
                let by_phi = slope(|s| eta(layout, k, s, v), s) / per_s;
                let by_v = slope(|v| eta(layout, k, s, v), v);
                let off = by_phi - c(v) * by_v;
                assert!(off.abs() < 1e-6 * (1.0 + by_phi.abs()), "{name}: sector {k}, end {end}, v = {v}: {by_phi} instead of {}", c(v) * by_v);
            }
        }
    });
}

fn value(form: &Form, numbers: &[f64]) -> f64 {
    form.iter().zip(numbers).map(|(f, x)| f * x).sum()
}

/// Numbers of the jet of the gauge a·Y at a corner: value at k, slopes along the tangents, no second slopes.
fn jet(layout: &Layout, corner: usize, a: DVec3) -> [f64; JET] {
    let c = &layout.corners[corner];
    [a.dot(c.k), a.dot(c.tangent[0]), a.dot(c.tangent[1]), 0.0, 0.0, 0.0]
}

const PLANES: [DVec3; 3] = [DVec3::new(0.3, -0.5, 0.8), DVec3::X, DVec3::new(-0.2, 0.1, 0.05)];

/// Nodes where finite differences are sharp enough; of some corners were joined.
fn exact_nodes() -> Vec<(&'static str, Layout)> {
    let mut nodes: Vec<_> = catalogue().into_iter().filter(|(name, _)| !name.starts_with("pair")).collect();
    nodes.extend([("random 6", random(2, 6, 35.0)), ("random 12", random(2, 12, 25.0))]);
    let mut layouts: Vec<_> = nodes.into_iter().map(|(name, axes)| (name, layout(name, axes))).collect();
    for (name, axes) in [("octahedron", octahedron()), ("random 5", random(3, 5, 40.0)), ("random 9", random(4, 9, 30.0))] {
        let star = unequal(axes);
        layouts.push((name, Layout::new(&star, &Cells::new(&star).unwrap()).unwrap()));
        assert!(layouts.last().unwrap().1.turned);
    }
    let mut numbers = Random::new(1);
    let shaken: Vec<DVec3> = fcc().into_iter().map(|a| (a.normalize() + 5e-3 * numbers.direction()).normalize()).collect();
    for (name, star) in [("shaken fcc", star(shaken.clone())), ("shaken fcc, unequal", unequal(shaken))] {
        let cells = Cells::new(&star).unwrap();
        assert!(cells.moved, "{name}");
        layouts.push((name, Layout::new(&star, &cells).unwrap()));
    }
    layouts
}

/// The map is the polynomial through as many nodes as its degrees say.
#[test]
fn the_map_has_the_degrees_it_is_taken_for() {
    for (name, layout) in exact_nodes() {
        let tables = if layout.turned { Tables::turned(6) } else { Tables::new(6) };
        let [along, across] = &tables.map;
        let at = |c: Vec<DVec3>, x: f64| c.iter().zip(basis(c.len() - 1, x)[0]).map(|(&c, b)| b * c).sum::<DVec3>();
        for k in 0..layout.sectors.len() {
            let map = SectorMap::new(&layout, k);
            for (s, v) in [(0.1, 0.9), (0.37, 0.53), (0.8, 0.2)] {
                let column = |s: f64| at(across.coefficients(&across.nodes.iter().map(|&v| map.y(s, v)).collect::<Vec<_>>()), v);
                let y = at(along.coefficients(&along.nodes.iter().map(|&s| column(s)).collect::<Vec<_>>()), s);
                assert!(y.distance(map.y(s, v)) < 1e-11 * y.length(), "{name}: sector {k} at ({s}, {v})");
            }
        }
    }
}

/// A plane's gauge is linear, C1 everywhere: with its jets at the corners and its own coefficients in between, the crease
/// forms must give back its derivative across the crease on both sides.
#[test]
fn crease_forms_reproduce_planes() {
    for p in [6, 8] {
        let below = Interpolation::new(p - 1);
        for (name, layout) in exact_nodes() {
            let tables = if layout.turned { Tables::turned(p) } else { Tables::new(p) };
            for k in 0..layout.creases.len() {
                let crease = &layout.creases[k];
                let forms = CreaseForms::new(&tables, &layout, k);
                let maps = [0, 1].map(|which| SectorMap::new(&layout, 2 * k + which));
                for a in PLANES {
                    let along = |s: f64| a.dot(maps[0].crease(s)[0]);
                    let ([l0, l1], [c0, c1]) = (crease.frame.wide, crease.frame.c);
                    let delta = |s: f64| -0.5 * (1.0 + maps[0].crease_t(s).powi(2)) * a.dot(l1 * c0 - l0 * c1);
                    let w = below.coefficients(&below.nodes.iter().map(|&s| along(s)).collect::<Vec<_>>());
                    let d = below.coefficients(&below.nodes.iter().map(|&s| delta(s)).collect::<Vec<_>>());
                    let mut numbers = vec![1.0];
                    crease.corners.iter().for_each(|&c| numbers.extend(jet(&layout, c, a)));
                    numbers.extend(&w[3..p - 3]);
                    numbers.extend(&d[2..p - 2]);
                    for i in 0..=10 {
                        let s = 0.1 * i as f64;
                        let b = &basis(p, s)[0];
                        let at = |forms: &[Form]| b.iter().zip(forms).map(|(b, f)| b * value(f, &numbers)).sum::<f64>();
                        let size = maps[0].y(s, 1.0).length();
                        assert!((at(&forms.w) - along(s)).abs() < 1e-9 * size, "{name}: crease {k}, s = {s}");
                        for which in 0..2 {
                            let want = slope(|v| a.dot(maps[which].y(s, v)), 1.0);
                            let got = at(&forms.across[which]);
                            assert!((got - want).abs() < 1e-7 * (size + want.abs()), "{name}: crease {k}, side {which}, s = {s}: {got} instead of {want}");
                        }
                    }
                }
            }
        }
    }
}

/// The same at the corner ends of radials: value, slope and second slope along, and value and slope of the derivative across.
#[test]
fn radial_forms_reproduce_planes_at_corners() {
    for (name, layout) in exact_nodes() {
        let tables = if layout.turned { Tables::turned(6) } else { Tables::new(6) };
        for (k, sector) in layout.sectors.iter().enumerate() {
            let map = SectorMap::new(&layout, k);
            for end in 0..2 {
                let r = &layout.radials[sector.radials[end]];
                let forms = RadialForms::new(&tables, &layout, sector.radials[end]);
                let across = forms.across(&map, end);
                for a in PLANES {
                    let mut numbers = vec![1.0];
                    numbers.extend(jet(&layout, r.corner, a));
                    numbers.resize(forms.w[0].len(), 0.0); // the free ones do not reach the corner
                    let at = |forms: &[Form], x: f64| -> [f64; 3] {
                        basis(forms.len() - 1, x).map(|b| b.iter().zip(forms).map(|(b, f)| b * value(f, &numbers)).sum())
                    };
                    let size = map.y(end as f64, 1.0).length();
                    let along = |v: f64| a.dot(radial(r, layout.corners[r.corner].k, v));
                    let got = at(&forms.w, 1.0);
                    let want = [along(1.0), slope(along, 1.0), slope(|v| slope(along, v), 1.0)];
                    for (got, want) in got.iter().zip(want) {
                        assert!((got - want).abs() < 1e-5 * (size + want.abs()), "{name}: radial of sector {k}: {got} instead of {want}");
                    }
                    let by_s = |v: f64| slope(|s| a.dot(map.y(s, v)), end as f64);
                    let got = at(&across, 1.0);
                    let want = [by_s(1.0), slope(by_s, 1.0)];
                    for (got, want) in got.iter().zip(want) {
                        assert!((got - want).abs() < 1e-5 * (size + want.abs()), "{name}: sector {k}, end {end}: {got} instead of {want}");
                    }
                }
            }
        }
    }
}

/// Long columns next to short ones: both neighbours of a new radial ask for even descent along it before either is split.
#[test]
fn narrow_pairs_have_a_layout() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    for angle in [14.0, 12.5, 11.0, 10.0, 8.0, 6.0, 4.0, 2.0] {
        for rest in [vec![], vec![z], vec![-x], vec![-y], vec![z, -z], vec![-x, z], vec![-y, z, -z], vec![-x, -y, z, -z]] {
            let name = format!("pair of {angle}° with {rest:?}");
            let layout = layout(&name, [vec![flat(0.0), flat(angle)], rest].concat());
            assert!((0..layout.sectors.len()).all(|k| SectorMap::new(&layout, k).is_regular()), "{name}");
        }
    }
}

/// Two patches a crease; the number must not hang on round-off.
#[test]
fn the_layout_does_not_depend_on_the_frame() {
    let mut numbers = Random::new(11);
    for (name, axes) in catalogue().into_iter().filter(|(name, _)| !OPPOSITE.contains(name)) {
        let count = |axes: Vec<DVec3>| layout(name, axes).sectors.len();
        let want = count(axes.clone());
        for _ in 0..10 {
            let q = numbers.rotation();
            assert_eq!(count(axes.iter().map(|&a| q * a).collect()), want, "{name} turned by {q}");
        }
    }
}

#[test]
fn sectors_of_known_nodes() {
    for (axes, want) in [(octahedron(), 24), (fcc(), 48), ([bcc(), octahedron()].concat(), 72), (icosahedron(), 60), (octahedron()[..4].to_vec(), 16)] {
        assert_eq!(layout("", axes).sectors.len(), want);
    }
    // sides a third of a turn wide are halved
    for (axes, want) in [(bcc(), 48), (tetrahedron(), 24), (dodecahedron(), 120)] {
        assert_eq!(layout("", axes).sectors.len(), want);
    }
}
