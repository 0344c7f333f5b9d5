//! Every rung of the ladder, and what brings a node to it.

mod common;

use common::*;
use glam::DVec3;
use lattice_brep::ladder::{self, Built, Degrees, Rung};
use lattice_brep::node::{Fairing, Film, Method};
use lattice_brep::options::Options;
use lattice_brep::patch::Degree;
use lattice_brep::patch::{self, Skin};

fn build(axes: Vec<DVec3>, options: &Options) -> Built {
    ladder::build(star(axes), options, &Degrees::new()).unwrap_or_else(|e| panic!("{}", e.join("; ")))
}

fn paper() -> Options {
    Options { fairing: Fairing::Paper, ..Options::default() }
}

fn assert_smooth(skin: &Skin) {
    assert_topology("", skin);
    assert!(inner_jump(skin) < 1e-6 && facing(skin) > 0.0);
}

#[test]
fn a_single_strut_is_an_end() {
    let built = build(vec![DVec3::new(1.0, 2.0, 2.0)], &Options::default());
    assert_eq!(built.rung, Rung::End);
    assert!(built.reasons.is_empty() && built.skin.patches.is_empty() && built.skin.edges.is_empty());
    let [rim] = &built.skin.rims[..] else { panic!("an end has one rim") };
    assert!(rim.arcs.is_empty() && rim.cut == 0.0 && rim.radius == 1.0);
    assert!(rim.axis.distance(DVec3::new(1.0, 2.0, 2.0) / 3.0) < 1e-15);
}

#[test]
fn a_usual_node_stays_on_the_first_rung() {
    let built = build(octahedron(), &Options::default());
    assert_eq!(built.rung, Rung::SoapFilm);
    assert!(built.reasons.is_empty());
}

/// A tolerance that the usual degree misses is met by more control points, still on the first rung.
#[test]
fn a_tight_tolerance_brings_more_control_points() {
    let built = |tolerance| build(octahedron(), &Options { tolerance, ..Options::default() });
    let (usual, tight) = (built(0.05), built(1e-3));
    assert_eq!((usual.rung, tight.rung), (Rung::SoapFilm, Rung::SoapFilm));
    let degree = |b: &Built| b.skin.patches[0].surface.degree;
    assert_eq!((degree(&usual), degree(&tight)), ([6, 6], [8, 8]));
    assert!(tight.quality.deviation < usual.quality.deviation);
    assert_smooth(&tight.skin);
}

/// A ball of 0.2 r fills all between two struts 5° apart, and no skin follows; without it the node is as usual.
#[test]
fn where_the_ball_leads_to_no_skin_the_node_is_faired() {
    let axes = vec![flat(0.0), flat(5.0), flat(140.0)];
    let built = build(axes.clone(), &Options { fairing: Fairing::Ball(0.2), ..Options::default() });
    assert_eq!(built.rung, Rung::NoBall);
    assert!(built.reasons.len() == 1 && built.reasons[0].starts_with("soap film: "), "{:?}", built.reasons);
    assert_smooth(&built.skin);
    let usual = build(axes, &Options { fairing: Fairing::Ray, ..Options::default() });
    assert_eq!((usual.rung, format!("{:?}", usual.skin)), (Rung::SoapFilm, format!("{:?}", built.skin)));
}

/// The paper's own fairing folds the film of three struts in a narrow cone.
#[test]
fn a_folded_film_takes_the_level_set() {
    let built = build(half_space(20.0), &paper());
    assert_eq!(built.rung, Rung::LevelSet);
    assert_eq!(built.reasons.len(), 1);
    assert!(built.reasons[0].starts_with("soap film: "), "{:?}", built.reasons);
    assert_smooth(&built.skin);
    assert_eq!(build(half_space(20.0), &Options::default()).rung, Rung::SoapFilm);
}

#[test]
fn a_level_set_that_the_usual_degree_misses_gets_more_control_points() {
    // with its valleys filled the node needs none of this
    let built = build(vec![flat(0.0), flat(9.0)], &Options { fairing: Fairing::Ray, ..Options::default() });
    assert_eq!(built.rung, Rung::MoreControl);
    assert_eq!(built.reasons.len(), 2);
    assert!(built.reasons[1].starts_with("level-set film, degree 6: "), "{:?}", built.reasons);
    assert_eq!(built.skin.patches[0].surface.degree, [8, 8]);
    assert_smooth(&built.skin);
}

/// Two struts close together: the usual layout follows neither the crotch nor the back, a fine one both.
#[test]
fn close_pairs_are_smooth() {
    for angle in [10.0, 12.0, 14.0] {
        let built = build(vec![flat(0.0), flat(angle)], &Options::default());
        assert_eq!(built.rung, Rung::SoapFilm, "{angle}°: {:?}", built.reasons);
        assert_smooth(&built.skin);
    }
}

/// Two struts almost along each other: no smooth skin keeps near its film.
#[test]
fn the_last_rung_is_sharp() {
    for angle in [5.0, 1.0] {
        let built = build(vec![flat(0.0), flat(angle)], &Options::default());
        assert_eq!(built.rung, Rung::Sharp, "{angle}°");
        assert_eq!(built.reasons.len(), 4, "{angle}°: {:?}", built.reasons);
        assert_topology("sharp", &built.skin);
    }
}

/// Sharp skins are the struts' cylinders up to the cell sides: closed, tangent at the rims, not folded.
#[test]
fn a_sharp_skin_is_made_of_exact_cylinders() {
    let tables = Degree::new(6);
    for (name, axes) in catalogue() {
        let film = Film::build(star(axes), Method::LevelSet, Fairing::Ray, 0).unwrap();
        let skin = patch::sharp(&film, &tables).unwrap_or_else(|e| panic!("{name}: {e}")).skin;
        assert_topology(name, &skin);
        let (off, tilt) = rim_errors(&skin);
        assert!(off < 1e-12 && tilt < 1e-6, "{name}: {off}, {tilt}°");
        assert!(facing(&skin) > 0.0, "{name}");
        for patch in &skin.patches {
            let axis = skin.rims[patch.arm].axis;
            for i in 0..=6 {
                for k in 0..=6 {
                    let p = patch.surface.point(i as f64 / 6.0, k as f64 / 6.0);
                    assert!((p.cross(axis).length() - 1.0).abs() < 1e-9, "{name}: {p}");
                    let nearest = film.star.axes.iter().map(|c| p.dot(*c)).fold(f64::NEG_INFINITY, f64::max);
                    assert!(p.dot(axis) > nearest - 1e-9 * p.length().max(1.0), "{name}: {p} lies beyond its cell");
                }
            }
        }
    }
}

/// Two struts in one direction have no node.
#[test]
fn coinciding_struts_are_refused_with_a_reason_a_rung() {
    let refused = ladder::build(star(vec![DVec3::X, DVec3::X]), &Options::default(), &Degrees::new());
    let reasons = refused.err().expect("no skin");
    assert!(!reasons.is_empty() && reasons.iter().all(|r| !r.is_empty()), "{reasons:?}");
}

/// Many nodes of all kinds; prints the distribution. `cargo test --release --test ladder -- --ignored --nocapture`;
/// the environment variable `RANDOM_NODES` sets their number.
#[test]
#[ignore = "minutes"]
fn random_nodes() {
    use rayon::prelude::*;
    let count = std::env::var("RANDOM_NODES").ok().and_then(|n| n.parse().ok()).unwrap_or(2000u64);
    let degrees = Degrees::new();
    let results: Vec<(String, Result<Built, Vec<String>>)> = (1..=count)
        .into_par_iter()
        .map(|seed| {
            let mut numbers = Random::new(seed + 1_000_000);
            let degree = 1 + (41.0 * numbers.next()) as usize;
            // from 12° up to what still fits
            let least = 12.0 + numbers.next() * (100.0 / (degree as f64).sqrt() - 12.0).max(0.0);
            let name = format!("seed {seed}, degree {degree}, least angle {least:.1}°");
            (name, ladder::build(star(random(seed, degree, least)), &Options::default(), &degrees))
        })
        .collect();
    let mut refused = 0;
    let mut rungs = std::collections::BTreeMap::new();
    let mut figures: [Vec<(f64, &str)>; 4] = Default::default();
    for (name, result) in &results {
        match result {
            Err(reasons) => {
                refused += 1;
                println!("REFUSED {name}: {}", reasons.join("; "));
            }
            Ok(built) => {
                *rungs.entry(built.rung).or_insert(0) += 1;
                if built.rung > Rung::SoapFilm {
                    println!("{:?} {name}: {}", built.rung, built.reasons.join("; "));
                }
                if built.rung != Rung::End && built.rung != Rung::Sharp {
                    let q = &built.quality;
                    [q.jump, q.rim_jump, q.deviation, q.facing].into_iter().zip(&mut figures).for_each(|(x, list)| list.push((x, name)));
                }
            }
        }
    }
    println!("{count} nodes: {rungs:?}, {refused} refused");
    for (name, list) in ["jump (degrees)", "rim jump (degrees)", "deviation (radii)", "facing"].iter().zip(&mut figures) {
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = |f: f64| list[((list.len() - 1) as f64 * f).round() as usize];
        let ((least, first), (most, last)) = (at(0.0), at(1.0));
        println!("{name}: least {least:.2e} ({first}), median {:.2e}, p99 {:.2e}, most {most:.2e} ({last})", at(0.5).0, at(0.99).0);
    }
    assert_eq!(refused, 0);
}
