//! Cuts over a whole graph: hand-made cases with closed forms, the bounds they must keep, what must not matter, and proofs.

mod common;

use common::{Random, degrees, flat, random};
use glam::{DVec3, dvec3};
use lattice_brep::cuts::preferred::{self, LEAST_ROOM};
use lattice_brep::cuts::{self, Binding, Cone, Cuts, FREE, MARGIN, Means, Radii, Shrunk, Thinner, negotiate};
use lattice_brep::graph::{Arm, End, Graph, Strut, catalogue, json, proximity};
use lattice_brep::ids::{NodeId, StrutId};
use lattice_brep::math::angle;
use lattice_brep::node::{Star, cut};
use std::time::Instant;

const LAMBDA: f64 = 0.3;

fn graph(nodes: &[DVec3], struts: &[(u32, u32, f64, f64)]) -> Graph {
    Graph::new(nodes.to_vec(), struts.iter().map(|&(a, b, ra, rb)| Strut { a: NodeId(a), b: NodeId(b), ra, rb }).collect())
}

/// The graph shrunk until cuts fit, these cuts, and what was shrunk.
fn shrink(graph: &Graph, lambda: f64) -> (Graph, Cuts, Vec<Shrunk>) {
    let mut radii = Radii::new(graph);
    let cuts = cuts::shrink(&mut radii, lambda);
    (radii.graph(), cuts, radii.shrunk())
}

/// Radius and its growth seen from an arm.
fn cone(graph: &Graph, arm: Arm) -> Cone {
    let s = graph.struts()[arm.strut.index()];
    let (near, far) = if arm.end == End::A { (s.ra, s.rb) } else { (s.rb, s.ra) };
    Cone { r: near, k: (far - near) / graph.length(arm.strut) }
}

/// The cap of a rim, from its circle alone: angular radius seen from the node.
fn cap(cone: Cone, cut: f64) -> f64 {
    if cut.is_finite() { (cone.r + cone.k * cut).atan2(cut) } else { cone.k.atan() }
}

/// Caps apart, cuts within the struts, free ends not cut.
fn assert_sound(name: &str, graph: &Graph, cuts: &Cuts) {
    for node in graph.node_ids() {
        let axes = Star::directions(graph, node);
        let arms = graph.arms(node);
        for (i, &arm) in arms.iter().enumerate() {
            let me = cone(graph, arm);
            let at = cuts.at[arm.strut.index()][arm.end as usize];
            if arms.len() == 1 {
                assert_eq!(at, 0.0, "{name}: a free end");
                continue;
            }
            assert!(at >= LEAST_ROOM * me.r * (1.0 - 1e-7), "{name}: a cut of {at}");
            for (j, &other) in arms[..i].iter().enumerate() {
                let caps = cap(me, at) + cap(cone(graph, other), cuts.at[other.strut.index()][other.end as usize]);
                let most = (1.0 - MARGIN) * angle(axes[i], axes[j]);
                assert!(caps <= most + 1e-6, "{name}: caps of {} and {} take {caps} of {most}", arm.strut.0, other.strut.0);
            }
        }
    }
    for (k, [a, b]) in cuts.at.iter().enumerate() {
        let length = graph.length(StrutId(k as u32));
        assert!(a + b <= length * (1.0 - FREE) * (1.0 + 1e-6), "{name}: strut {k}: {a} + {b} on {length}");
        assert_eq!(cuts.means[k] == Means::Preferred, cuts.at[k] == cuts.preferred[k], "{name}: strut {k}");
    }
}

/// A graph of random nodes, each joined to its nearest neighbours, with radii of `thick` times the distance of nodes and ratios up
/// to `ratio`.
fn random_graph(seed: u64, count: usize, thick: f64, ratio: f64) -> Graph {
    let mut numbers = Random::new(seed);
    let side = (count as f64).cbrt();
    let nodes: Vec<DVec3> = (0..count).map(|_| side * dvec3(numbers.next(), numbers.next(), numbers.next())).collect();
    let mut struts: Vec<(u32, u32, f64, f64)> = Vec::new();
    let degree = 2 + (seed % 5) as usize;
    for a in 0..count {
        let mut others: Vec<usize> = (0..count).filter(|&b| b != a).collect();
        others.sort_by(|&b, &c| nodes[a].distance(nodes[b]).total_cmp(&nodes[a].distance(nodes[c])));
        for &b in others.iter().take(degree) {
            let ends = (a.min(b) as u32, a.max(b) as u32);
            if !struts.iter().any(|&(a, b, ..)| (a, b) == ends) {
                let mut radius = || thick * ratio.powf(numbers.next() - 1.0);
                struts.push((ends.0, ends.1, radius(), radius()));
            }
        }
    }
    graph(&nodes, &struts)
}

#[test]
fn graphs_with_room_have_the_cuts_of_the_paper_to_the_bit() {
    for cell in catalogue::Cell::ALL {
        let graph = catalogue::generate(cell, 10.0, [2, 2, 2], 0.25).unwrap();
        let cuts = negotiate(&graph, LAMBDA).unwrap();
        assert!(cuts.means.iter().all(|&m| m == Means::Preferred), "{}", cell.name());
        for node in graph.used_nodes() {
            let want = cut::cuts(&Star::directions(&graph, node), LAMBDA);
            for (&arm, want) in graph.arms(node).iter().zip(want) {
                assert_eq!(cuts.at[arm.strut.index()][arm.end as usize].to_bits(), (want * graph.radius(arm)).to_bits(), "{}", cell.name());
            }
        }
    }
    // and so have random nodes with struts long enough
    for seed in 1..=50 {
        let axes = random(seed, 3 + (seed % 12) as usize, 8.0);
        let struts: Vec<_> = (1..=axes.len() as u32).map(|k| (0, k, 0.7, 0.7)).collect();
        let nodes: Vec<DVec3> = std::iter::once(DVec3::ZERO).chain(axes.iter().map(|u| 100.0 * u)).collect();
        let graph = graph(&nodes, &struts);
        let want = cut::cuts(&Star::directions(&graph, NodeId(0)), LAMBDA);
        for (at, want) in negotiate(&graph, LAMBDA).unwrap().at.iter().zip(want) {
            assert_eq!(at[0].to_bits(), (0.7 * want).to_bits());
        }
    }
}

#[test]
fn preferred_cuts_of_unequal_radii_part_caps_and_keep_rims_out_of_other_struts() {
    for seed in 1..=1000 {
        let mut numbers = Random::new(seed);
        let axes = random(seed, 2 + (seed % 7) as usize, 5.0 + 10.0 * numbers.next());
        let cones: Vec<Cone> =
            axes.iter().map(|_| Cone { r: 10f64.powf(numbers.next()), k: if seed % 2 == 0 { 0.0 } else { 0.06 * numbers.next() - 0.03 } }).collect();
        let cut = |i: usize| preferred::cut(&cones, i, |j| angle(axes[i], axes[j]), 0.0);
        for i in 0..axes.len() {
            let rim = cones[i].r + cones[i].k * cut(i);
            if !(cut(i).is_finite() && rim > 0.0) {
                continue; // no strut can have that
            }
            let (e, f) = axes[i].any_orthonormal_pair();
            for j in (0..axes.len()).filter(|&j| j != i) {
                assert!(cap(cones[i], cut(i)) + cap(cones[j], cut(j)) < angle(axes[i], axes[j]), "seed {seed}: caps {i}, {j}");
                for k in 0..64 {
                    let (sin, cos) = (std::f64::consts::TAU * k as f64 / 64.0).sin_cos();
                    let p = cut(i) * axes[i] + rim * (cos * e + sin * f);
                    let along = p.dot(axes[j]);
                    let inside = along > 0.0 && p.distance(along * axes[j]) < cones[j].r + cones[j].k * along;
                    assert!(!inside, "seed {seed}: rim {i} (radius {rim}) in strut {j} at {:.1}°", degrees(axes[i], axes[j]));
                }
            }
        }
    }
}

#[test]
fn preferred_cuts_of_unequal_radii_are_closed_forms() {
    let cut = |r: [f64; 2], theta: f64| [0, 1].map(|i| preferred::cut(&r.map(|r| Cone { r, k: 0.0 }), i, |_| theta.to_radians(), 0.3));
    // a right angle: each rim stops where the other cylinder begins; the thick one keeps the shared angle, a little longer
    let share = |r: f64, s: f64, theta: f64| r / (theta * r / (r + s)).to_radians().tan();
    let [thin, thick] = cut([1.0, 2.0], 90.0);
    assert!((thin - 1.3 * 2.0).abs() < 1e-12 && (thick - (share(2.0, 1.0, 90.0) + 2.0 * LEAST_ROOM)).abs() < 1e-12);
    // opposite struts share 180° as their radii do; the thick one keeps the least room
    let [thin, thick] = cut([1.0, 10.0], 180.0);
    assert!((thin - 1.3 * share(1.0, 10.0, 180.0)).abs() < 1e-12 && (thick - LEAST_ROOM * 10.0).abs() < 1e-12);
    // no jump anywhere on the way
    for ratio in [1.0 + 1e-9, 1.5, 3.0, 10.0] {
        for step in 1..3600 {
            let [a, b] = [0.0, 0.05].map(|more| cut([1.0, ratio], 5.0 + 175.0 * step as f64 / 3600.0 - more));
            assert!((0..2).all(|k| (a[k] - b[k]).abs() < 0.2 * ratio + 0.05 * a[k]), "{ratio}, {step}");
        }
    }
    let [even, odd] = [cut([1.0, 1.0], 70.0), cut([1.0, 1.0 + 1e-12], 70.0)];
    assert!((even[0] - odd[0]).abs() < 1e-10);
}

#[test]
fn smaller_lambda_comes_first() {
    let (n, r) = ([DVec3::ZERO, 10.0 * flat(0.0), 10.0 * flat(60.0)], 2.5);
    let cuts = negotiate(&graph(&n, &[(0, 1, r, r), (1, 2, r, r), (2, 0, r, r)]), LAMBDA).unwrap();
    assert_eq!(cuts.means, [Means::SmallerLambda; 3]);
    for at in cuts.at.as_flattened() {
        assert!((at - 5.0 * (1.0 - FREE)).abs() < 1e-12);
    }
}

/// A strut between two nodes, with a neighbour at 40° at each end.
fn zigzag(length: f64, neighbours: [f64; 2]) -> Graph {
    let b = dvec3(length, 0.0, 0.0);
    let nodes = [DVec3::ZERO, b, neighbours[0] * flat(40.0), b + neighbours[1] * flat(220.0)];
    graph(&nodes, &[(0, 1, 1.0, 1.0), (0, 2, 1.0, 1.0), (1, 3, 1.0, 1.0)])
}

/// The cut of a unit strut that shares 40° with one cut at `beside`.
fn beside(beside: f64) -> f64 {
    1.0 / ((1.0 - MARGIN) * 40f64.to_radians() - (1.0 / beside).atan()).tan()
}

#[test]
fn a_short_strut_between_long_ones_is_cut_short_and_they_are_cut_long() {
    let graph = zigzag(3.0, [50.0, 50.0]);
    let cuts = negotiate(&graph, LAMBDA).unwrap();
    assert_eq!(cuts.means, [Means::UnequalCuts; 3]);
    let short = 1.5 * (1.0 - FREE);
    assert!((cuts.at[0][0] - short).abs() < 1e-12 && (cuts.at[0][1] - short).abs() < 1e-12);
    assert!((cuts.at[1][0] - beside(short)).abs() < 1e-9 && (cuts.at[2][0] - beside(short)).abs() < 1e-9);
    assert_eq!(cuts.at[1][1], 0.0);
    assert_sound("unequal cuts", &graph, &cuts);
}

#[test]
fn a_short_strut_beside_a_short_neighbour_shares_its_length_unequally() {
    let graph = zigzag(4.0, [4.0, 50.0]);
    let cuts = negotiate(&graph, LAMBDA).unwrap();
    assert_eq!(cuts.means[0], Means::UnequalSharing);
    assert!(cuts.at[0][0] >= beside(4.0 * (1.0 - FREE)) - 1e-6 && cuts.at[0][1] < 1.8, "{:?}", cuts.at);
    assert_sound("unequal sharing", &graph, &cuts);
}

#[test]
fn a_strut_that_cannot_fit_has_a_proof_that_can_be_checked_by_hand() {
    let graph = zigzag(4.0, [4.0, 4.0]);
    let conflicts = negotiate(&graph, LAMBDA).unwrap_err();
    let strut = conflicts.iter().find(|c| c.strut == StrutId(0)).expect("the strut in the middle");
    let room = 4.0 * (1.0 - FREE);
    for (end, neighbour) in [(0, 1), (1, 2)] {
        let [link] = strut.because[end][..] else { panic!("one link") };
        assert_eq!((link.strut.0, link.beside.0, link.node.index()), (0, neighbour, end));
        assert!((link.most - room).abs() < 1e-9 && (link.least - beside(room)).abs() < 1e-6);
    }
    assert!((strut.factor - room / (2.0 * beside(room))).abs() < 1e-6);
    let text = strut.fault().to_string();
    assert!(text.starts_with("struts[0]: found cuts of at least 2.2") && text.contains("with 1, which is cut at 3.996"), "{text}");
}

#[test]
fn every_proof_adds_up() {
    let mut longest = 0;
    for seed in 1..=40 {
        let graph = random_graph(seed, 60, 0.12, 4.0);
        let Err(conflicts) = negotiate(&graph, LAMBDA) else { continue };
        for c in &conflicts {
            let room = |strut: StrutId| graph.length(strut) * (1.0 - FREE);
            assert!(c.least[0] + c.least[1] > room(c.strut), "seed {seed}");
            for (end, chain) in [End::A, End::B].into_iter().zip(&c.because) {
                longest = longest.max(chain.len());
                let mut arm = Arm { strut: c.strut, end };
                for (k, link) in chain.iter().enumerate() {
                    assert_eq!(arm, Arm { strut: link.strut, end: link.end });
                    let near = graph.near(arm);
                    let other = *graph.arms(near).iter().find(|a| a.strut == link.beside).expect("a neighbour at the node");
                    let [u, v] = [arm, other].map(|a| (graph.nodes()[graph.far(a).index()] - graph.nodes()[near.index()]).normalize());
                    assert!((link.angle - (1.0 - MARGIN) * angle(u, v)).abs() < 1e-9, "seed {seed}");
                    let least = if link.least.is_finite() { cap(cone(&graph, arm), link.least) } else { cone(&graph, arm).k.atan().max(0.0) };
                    let rest = link.angle - cap(cone(&graph, other), link.most);
                    assert!(rest <= least + 1e-6, "seed {seed}: {link:?}");
                    // the neighbour's longest cut: its room less what its far end needs
                    arm = Arm { strut: other.strut, end: if other.end == End::A { End::B } else { End::A } };
                    let free = if graph.degree(graph.near(arm)) == 1 { 0.0 } else { LEAST_ROOM * graph.radius(arm) };
                    let far = chain.get(k + 1).map_or(free, |next: &Binding| next.least);
                    assert!((link.most + far - room(other.strut)).abs() < 1e-5 * room(other.strut), "seed {seed}: {link:?} {far}");
                }
            }
        }
    }
    assert!(longest > 2);
}

#[test]
fn cuts_of_random_graphs_are_sound_and_shrinking_makes_the_rest_so() {
    let mut seen = [0; 5];
    for seed in 1..=120 {
        let graph = random_graph(seed, 20 + (seed % 60) as usize, [0.02, 0.05, 0.1, 0.2][seed as usize % 4], [1.0, 3.0, 10.0][seed as usize % 3]);
        let name = format!("seed {seed}");
        let result = negotiate(&graph, LAMBDA);
        let (small, cuts, shrunk) = shrink(&graph, LAMBDA);
        assert_sound(&name, &small, &cuts);
        assert_eq!(shrunk.is_empty(), result.is_ok(), "{name}");
        seen[4] += usize::from(result.is_err());
        for m in cuts.means {
            seen[m as usize] += 1;
        }
        let mut changed = shrunk.iter();
        for (k, (old, new)) in graph.struts().iter().zip(small.struts()).enumerate() {
            assert!(new.ra > 0.0 && new.ra <= old.ra && new.rb <= old.rb, "{name}");
            if old != new {
                let told = changed.next().unwrap();
                assert_eq!((told.strut.index(), told.before, told.after), (k, [old.ra, old.rb], [new.ra, new.rb]));
                assert!(told.volume > 0.0);
            }
        }
        assert!(changed.next().is_none());
    }
    assert!(seen.iter().all(|&n| n > 20), "every means in use: {seen:?}");
}

#[test]
fn a_strut_is_thin_where_its_cuts_meet_and_tapers_back() {
    // 40° to a short neighbour at one end, 140° to a long one at the other: the cuts of strut 0 meet near its far end
    let (b, r) = (dvec3(3.0, 0.0, 0.0), 1.0);
    let nodes = [DVec3::ZERO, b, 2.9 * flat(40.0), b + 50.0 * flat(40.0)];
    let graph = graph(&nodes, &[(0, 1, r, r), (0, 2, r, r), (1, 3, r, r)]);
    assert!(negotiate(&graph, LAMBDA).is_err());
    let (small, cuts, shrunk) = shrink(&graph, LAMBDA);
    assert_sound("tapered back", &small, &cuts);
    let [one] = shrunk[..] else { panic!("one strut: {shrunk:?}") };
    // touching caps are 0.48 of the angles; the ends give in proportion to their nearness to where these cuts meet
    let [cot_a, cot_b] = [40.0, 140.0].map(|angle: f64| 1.0 / (0.48 * angle).to_radians().tan());
    let gives = [0, 1].map(|e| one.before[e] - one.after[e]);
    assert!((gives[0] / gives[1] - cot_b / cot_a).abs() < 1e-9 && gives[1] > 0.0, "{gives:?}");
    // no more than needed, to a 32nd of the way: the radius there that touching cuts need
    let at = |r: [f64; 2]| (r[0] * cot_b + r[1] * cot_a) / (cot_a + cot_b);
    let least = 3.0 * (1.0 - FREE) / (cot_a + cot_b);
    assert!(at(one.after) >= least && at(one.after) < r, "{} {least}", at(one.after));
    // the whole strut made so thin there would lose more
    let even = std::f64::consts::PI * 3.0 * (1.0 - at(one.after).powi(2));
    assert!(one.volume < 0.8 * even, "{} {even}", one.volume);
}

#[test]
fn a_strut_gives_at_the_nearer_end_but_is_never_steep() {
    let graph = graph(&[DVec3::ZERO, 10.0 * DVec3::X], &[(0, 1, 1.0, 2.0)]);
    let radii = Radii::new(&graph);
    assert_eq!(radii.thinned(0, [1.0, 1.0], 1.0, 0.75), [1.0, 0.75]);
    // weights 0.5 and 1: the ends give a fifth of 0.5 : 1
    let [a, b] = radii.thinned(0, [1.0, 1.0], 0.5, 0.9);
    assert!((a - 0.94).abs() < 1e-12 && (b - 0.88).abs() < 1e-12 && (0.5 * a + b - 0.9 * 1.5).abs() < 1e-12);
    // one end alone would have to be a quarter of the other: at most half, and then the other gives too
    let [a, b] = radii.thinned(0, [1.0, 1.0], 1.0, 0.25);
    assert_eq!([a, b], [0.5, 0.25]);
    // in the middle of a cylinder both give the same, to the bit
    let graph = self::graph(&[DVec3::ZERO, DVec3::X], &[(0, 1, 0.3, 0.3)]);
    let mut radii = Radii::new(&graph);
    radii.thin([Thinner { strut: StrutId(0), t: 0.5 + 1e-12, to: 0.9 }]);
    let s = radii.graph().struts()[0];
    assert!(s.ra == s.rb && (s.ra - 0.27).abs() < 1e-9);
}

#[test]
fn struts_that_overlap_are_thin_there_and_taper_back() {
    // strut 1 passes above strut 0, close to its end b, and is passed in its middle itself
    let nodes = [DVec3::ZERO, 20.0 * DVec3::X, dvec3(18.0, -10.0, 1.6), dvec3(18.0, 10.0, 1.6)];
    let graph = graph(&nodes, &[(0, 1, 1.0, 1.0), (2, 3, 1.0, 1.0)]);
    let mut radii = Radii::new(&graph);
    cuts::part(&mut radii).unwrap();
    let small = radii.graph();
    assert!(proximity::near_misses(&small).is_empty());
    let [tapered, even] = radii.shrunk()[..] else { panic!("both") };
    let [a, b] = tapered.after;
    assert!(a > 0.97 && b < 0.78 && 0.1 * a + 0.9 * b > 0.76, "{a} {b}");
    assert!(even.after[0] == even.after[1] && even.after[0] > 0.76);
    assert!((tapered.volume - 20.0 * std::f64::consts::PI * (1.0 - (a * a + a * b + b * b) / 3.0)).abs() < 1e-12);
}

#[test]
fn place_scale_and_numbering_do_not_matter() {
    for seed in 1..=40 {
        let base = random_graph(seed, 40, 0.06, 3.0);
        let (small, cuts, _) = shrink(&base, LAMBDA);
        for (scale, shift) in [(1e-3, 0.0), (1e3, 0.0), (0.125, 1e5)] {
            let nodes: Vec<DVec3> = base.nodes().iter().map(|&p| scale * p + shift).collect();
            let struts = base.struts().iter().map(|s| Strut { ra: scale * s.ra, rb: scale * s.rb, ..*s }).collect();
            let (moved_small, moved, _) = shrink(&Graph::new(nodes, struts), LAMBDA);
            for k in 0..cuts.at.len() {
                assert!((moved_small.struts()[k].ra / scale - small.struts()[k].ra).abs() < 1e-6, "seed {seed}");
                assert!((0..2).all(|e| (moved.at[k][e] / scale - cuts.at[k][e]).abs() < 1e-5), "seed {seed}, strut {k}: {:?} {:?}", moved.at[k], cuts.at[k]);
            }
        }
        // nodes and struts in reverse order, struts turned round
        let (n, m) = (base.nodes().len() as u32, base.struts().len());
        let nodes: Vec<DVec3> = base.nodes().iter().rev().copied().collect();
        let struts = base.struts().iter().rev().map(|s| Strut { a: NodeId(n - 1 - s.b.0), b: NodeId(n - 1 - s.a.0), ra: s.rb, rb: s.ra }).collect();
        let (_, turned, _) = shrink(&Graph::new(nodes, struts), LAMBDA);
        for k in 0..m {
            let [b, a] = turned.at[m - 1 - k];
            assert!((a - cuts.at[k][0]).abs() < 1e-5 && (b - cuts.at[k][1]).abs() < 1e-5, "seed {seed}, strut {k}: {a} {b} {:?}", cuts.at[k]);
        }
    }
}

/// Figures of lattices given as a list of files: `LATTICES="a.json b.json" cargo test --release --test cuts -- --ignored --nocapture`.
#[test]
#[ignore = "needs files"]
fn figures_of_given_lattices() {
    let files = std::env::var("LATTICES").expect("LATTICES: a list of files");
    for file in files.split_whitespace() {
        let (input, faults) = json::read(&std::fs::read(file).unwrap());
        assert!(faults.is_empty());
        let graph = Graph::new(input.nodes, input.struts);
        println!("{file}: {} struts", graph.struts().len());
        // where all radii of a node are equal: the paper's cuts, strut by strut
        let mut paper = vec![[f64::NAN; 2]; graph.struts().len()];
        for node in graph.used_nodes().filter(|&n| graph.arms(n).windows(2).all(|w| graph.radius(w[0]) == graph.radius(w[1]))) {
            for (&arm, cut) in graph.arms(node).iter().zip(cut::cuts(&Star::directions(&graph, node), LAMBDA)) {
                paper[arm.strut.index()][arm.end as usize] = cut * graph.radius(arm);
            }
        }
        let short = (0..paper.len()).filter(|&k| paper[k][0] + paper[k][1] >= graph.length(StrutId(k as u32))).count();
        println!("  {short} too short for the paper's cuts");
        let start = Instant::now();
        let result = negotiate(&graph, 0.3);
        println!("  negotiate {:.3} s", start.elapsed().as_secs_f64());
        match result {
            Ok(cuts) => {
                let same = paper.iter().zip(&cuts.at).filter(|(p, c)| (0..2).all(|k| p[k].to_bits() == c[k].to_bits())).count();
                println!(
                    "  {same} with the paper's cuts to the bit, {} with nodes of unequal radii",
                    paper.iter().filter(|p| p.iter().any(|x| x.is_nan())).count()
                );
                print_means(&cuts.means);
            }
            Err(conflicts) => {
                println!("  {} conflicts", conflicts.len());
                for c in conflicts.iter().take(3) {
                    println!("    {}", c.fault());
                }
                let longest = conflicts.iter().flat_map(|c| c.because.iter().map(Vec::len)).max().unwrap();
                println!("  longest proof {longest} links");
                let start = Instant::now();
                let (_, cuts, shrunk) = shrink(&graph, 0.3);
                println!("  shrink {:.3} s", start.elapsed().as_secs_f64());
                print_means(&cuts.means);
                let volume: f64 = graph.struts().iter().enumerate().map(|(k, s)| s.volume(graph.length(StrutId(k as u32)))).sum();
                let lost: f64 = shrunk.iter().map(|s| s.volume).sum();
                let factors: Vec<f64> = shrunk.iter().flat_map(|s| [s.after[0] / s.before[0], s.after[1] / s.before[1]]).collect();
                let ends = factors.iter().filter(|&&f| f < 1.0).count();
                let (least, tapered) = (factors.iter().copied().fold(1.0, f64::min), factors.chunks(2).filter(|f| f[0] != f[1]).count());
                println!("  {} shrunk at {ends} ends, {tapered} unevenly, least factor {least:.4}", shrunk.len());
                println!("  {lost:.3} mm³ lost, {:.3} % of the volume", 100.0 * lost / volume);
            }
        }
    }
}

fn print_means(means: &[Means]) {
    for m in [Means::Preferred, Means::SmallerLambda, Means::UnequalCuts, Means::UnequalSharing] {
        println!("    {m:?}: {}", means.iter().filter(|&&x| x == m).count());
    }
}
