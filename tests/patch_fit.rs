//! Fitted skins: exact rims, exact G1, closed topology; and that the default options build smooth nodes at once.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::ladder::{self, Built, Degrees, Rung};
use lattice_brep::math::nurbs::NurbsSurface;
use lattice_brep::node::{Fairing, Film, Method};
use lattice_brep::options::Options;
use lattice_brep::patch::Degree;
use lattice_brep::patch::layout::Layout;
use lattice_brep::patch::{self, check};

fn build(name: &str, axes: Vec<DVec3>, degrees: &Degrees) -> Built {
    let built = ladder::build(star(axes), &Options::default(), degrees).unwrap_or_else(|e| panic!("{name}: {}", e.join("; ")));
    assert_eq!(built.rung, Rung::SoapFilm, "{name}: {}", built.reasons.join("; "));
    built
}

fn assert_smooth(name: &str, built: &Built) {
    let skin = &built.skin;
    assert_topology(name, skin);
    let (off, tilt) = rim_errors(skin);
    assert!(off < 1e-12, "{name}: a rim is {off} from its circle");
    assert!(tilt < 1e-6, "{name}: a rim is {tilt}° from its strut");
    let jump = inner_jump(skin);
    assert!(jump < 1e-6, "{name}: jump of {jump}°");
    assert!(facing(skin) > 0.0, "{name}: facing {}", facing(skin));
}

#[test]
fn the_catalogue_is_smooth() {
    let degrees = Degrees::new();
    for (name, axes) in catalogue() {
        assert_smooth(name, &build(name, axes, &degrees));
    }
}

#[test]
fn sixty_random_nodes_are_smooth() {
    let degrees = Degrees::new();
    for seed in 1..=60 {
        let degree = 3 + (seed % 18) as usize;
        let name = format!("degree {degree}, seed {seed}");
        assert_smooth(&name, &build(&name, random(seed, degree, 25.0), &degrees));
    }
}

#[test]
fn a_straight_node_is_its_cylinder() {
    let built = build("straight", vec![DVec3::Z, -DVec3::Z], &Degrees::new());
    for patch in &built.skin.patches {
        for k in 0..=20 {
            for i in 0..=20 {
                let p = patch.surface.point(0.05 * i as f64, 0.05 * k as f64);
                assert!((p.x.hypot(p.y) - 1.0).abs() < 1e-5, "{p}");
            }
        }
    }
}

/// More control points come nearer to the film.
#[test]
fn the_fit_converges_with_the_degree() {
    for (name, axes) in [("octahedron", octahedron()), ("cross", octahedron()[..4].to_vec()), ("random", random(2, 4, 40.0))] {
        let film = Film::build(star(axes), Method::SoapFilm, Fairing::Ray, 3).unwrap();
        let mean = |p: usize| patch::fit(&film, &Degree::new(p)).unwrap_or_else(|e| panic!("{name}: {e}")).quality.mean_deviation;
        let [coarse, middle, fine] = [6, 7, 8].map(mean);
        assert!(middle < 0.8 * coarse && fine < 0.9 * middle, "{name}: {coarse}, {middle}, {fine}");
        assert!(coarse < 2e-3, "{name}: {coarse}");
    }
}

/// What is left of the film without its neighbours tells what the fit will miss.
#[test]
fn the_forecast_is_near_what_is_missed() {
    let degree = Degree::new(6);
    let misses = |axes: Vec<DVec3>| {
        let film = Film::build(star(axes), Method::SoapFilm, Fairing::Ray, 3).unwrap();
        let layout = Layout::new(&film.star, &film.cells).unwrap();
        let missed = patch::fit_on(&layout, &film, &degree).unwrap().quality.deviation;
        let is_rough = |most: f64| patch::sample_unless_rough(&layout, &film, &degree, most).unwrap().is_none();
        let (mut forecast, mut above) = (1e-5, 1.0);
        assert!(is_rough(forecast) && !is_rough(above));
        for _ in 0..10 {
            let middle = f64::sqrt(forecast * above);
            if is_rough(middle) { forecast = middle } else { above = middle }
        }
        (forecast, missed)
    };
    let nodes: Vec<(f64, f64)> =
        [(2, 4, 40.0), (5, 9, 25.0), (7, 6, 20.0), (8, 12, 15.0)].into_iter().map(|(seed, n, angle)| misses(random(seed, n, angle))).collect();
    for (forecast, missed) in &nodes {
        assert!((0.3..3.0).contains(&(forecast / missed)), "{nodes:?}");
    }
    let worst = |f: fn(&(f64, f64)) -> f64| nodes.iter().map(f).fold(0.0, f64::max) / nodes.iter().map(f).fold(1.0, f64::min);
    assert!(worst(|n| n.1) > 3.0 && worst(|n| n.0) > 3.0, "nodes that differ: {nodes:?}");
}

/// The figures of the report are those that the tests measure.
#[test]
fn reported_quality_is_what_is_measured() {
    for (name, axes) in [("octahedron", octahedron()), ("fan", vec![flat(0.0), flat(40.0), flat(80.0)]), ("random", random(5, 9, 25.0))] {
        let film = Film::build(star(axes), Method::SoapFilm, Fairing::Ray, 3).unwrap();
        let fitted = patch::fit(&film, &Degree::new(6)).unwrap();
        let q = fitted.quality;
        assert!((q.facing - facing(&fitted.skin)).abs() < 0.05, "{name}: {} and {}", q.facing, facing(&fitted.skin));
        assert!(q.jump < 1e-6 && q.rim_jump < 1e-6 && q.mean_deviation < q.deviation, "{name}: {q:?}");
        check::accept(&q).unwrap();
        let at = |k: usize| k as f64 / 20.0;
        let angle = |s: &NurbsSurface, u: f64, v: f64| {
            let jet = s.jet1(u, v);
            let angle = jet.du.angle_between(jet.dv).to_degrees();
            angle.min(180.0 - angle)
        };
        let all = fitted.skin.patches.iter().flat_map(|p| (0..=400).map(|k| angle(&p.surface, at(k / 21 % 21), at(k % 21))));
        let least = all.fold(90.0, f64::min);
        assert!(q.isoline > least - 1e-9 && q.isoline < 1.2 * least + 1.0, "{name}: {} and {least}", q.isoline);
        // a patch that is moved outward is the farthest
        let mut moved = fitted.skin.clone();
        let last = moved.patches.len() - 1;
        moved.patches[last].surface.points.iter_mut().for_each(|p| *p *= 1.4);
        let arm = moved.patches[last].arm;
        let number = moved.patches.iter().filter(|p| p.arm == arm).count() as u32;
        assert_eq!(check::measure(&moved, &film).farthest, (arm, number), "{name}");
        // a patch turned by 1° is seen at its edges
        let mut broken = fitted.skin.clone();
        let turn = glam::DQuat::from_axis_angle(broken.vertices[0].normalize(), 1f64.to_radians());
        broken.patches[0].surface.points.iter_mut().for_each(|p| *p = turn * *p);
        let q = check::measure(&broken, &film);
        assert!(q.jump > 0.1 && q.jump < 1.5, "{name}: {q:?}");
        check::accept(&q).unwrap_err();
    }
}

#[test]
fn checks_refuse_folds_jumps_strangers_and_nan() {
    let good = check::Quality { facing: 0.5, deviation: 0.01, mean_deviation: 0.001, ..check::Quality::default() };
    check::accept(&good).unwrap();
    for (bad, word) in [
        (check::Quality { jump: 0.06, ..good }, "jump"),
        (check::Quality { jump: f64::NAN, ..good }, "jump"),
        (check::Quality { deviation: 0.6, ..good }, "film"),
        (check::Quality { facing: 0.0, ..good }, "folds"),
        (check::Quality { facing: f64::NAN, ..good }, "folds"),
        (check::Quality { rim_jump: 0.06, ..good }, "strut"),
    ] {
        assert!(check::accept(&bad).unwrap_err().contains(word), "{bad:?}");
    }
}

/// A turned node has the turned skin.
#[test]
fn a_turned_node_has_the_turned_skin() {
    let degrees = Degrees::new();
    let mut numbers = Random::new(3);
    for (name, axes) in [("tripod", half_space(50.0)), ("random 5", random(4, 5, 40.0)), ("random 8", random(4, 8, 35.0))] {
        let q = numbers.rotation();
        let here = build(name, axes.clone(), &degrees).skin;
        let there = build(name, axes.iter().map(|&a| q * a.normalize()).collect(), &degrees).skin;
        assert_eq!((here.vertices.len(), here.patches.len()), (there.vertices.len(), there.patches.len()), "{name}");
        for (a, b) in here.vertices.iter().zip(&there.vertices) {
            assert!((q * *a).distance(*b) < 1e-6, "{name}: {} and {b}", q * *a);
        }
        for (a, b) in here.patches.iter().zip(&there.patches) {
            for x in [0.1, 0.5, 0.8] {
                let (p, r) = (q * a.surface.point(x, 1.0 - x), b.surface.point(x, 1.0 - x));
                assert!(p.distance(r) < 1e-6, "{name}: {p} and {r}");
            }
        }
    }
}

/// The order in which struts are named does not change the shape: the same vertices, in another order.
#[test]
fn the_order_of_struts_does_not_change_the_shape() {
    let degrees = Degrees::new();
    let axes = random(6, 7, 35.0);
    let here = build("here", axes.clone(), &degrees).skin;
    let there = build("there", axes.into_iter().rev().collect(), &degrees).skin;
    assert_eq!(here.patches.len(), there.patches.len());
    for a in &here.vertices {
        let near = there.vertices.iter().map(|b| a.distance(*b)).fold(f64::INFINITY, f64::min);
        assert!(near < 1e-2, "{a} moved by {near}");
    }
}

#[test]
fn the_same_node_gives_the_same_bits() {
    let degrees = Degrees::new();
    let [a, b] = [0, 1].map(|_| build("random", random(9, 11, 25.0), &degrees).skin);
    assert!(a.patches.iter().zip(&b.patches).all(|(a, b)| a.surface.points == b.surface.points && a.surface.weights == b.surface.weights));
}
