//! Seeded random lattices: nodes of all kinds with free ends, and connected graphs. The same on every machine.

use glam::{DQuat, DVec3};
use lattice_brep::graph::proximity::near_misses;
use lattice_brep::graph::{Graph, Strut};
use lattice_brep::ids::NodeId;
use lattice_brep::node::star::angle;
use std::f64::consts::{PI, TAU};

/// Smallest angle between two struts of a node, degrees. Reason: below, cuts are thirty radii and more, which nobody builds.
const LEAST_ANGLE: f64 = 3.0;
/// Largest ratio of the radii at one node, and of those at a strut's two ends.
const MOST_RATIO: f64 = 10.0;
/// Directions tried for one strut before a node gets fewer struts than asked for.
const TRIES: usize = 2000;
/// Least distance of two nodes of a graph, mm.
const APART: f64 = 10.0;

/// Numbers from a seed (xorshift64*).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        // mixed, so that seeds next to each other have nothing in common (splitmix64)
        let z = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        Random((z ^ (z >> 31)) | 1)
    }

    /// Uniform in [0, 1).
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform between two numbers.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Between two positive numbers, uniform in the logarithm.
    fn scaled(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.next())
    }

    /// Uniform in 0..n.
    fn below(&mut self, n: usize) -> usize {
        (n as f64 * self.next()) as usize
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let (sin, cos) = (TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }

    /// A direction at an angle (radians) from a given one.
    fn beside(&mut self, axis: DVec3, angle: f64) -> DVec3 {
        let (e, f) = axis.any_orthonormal_pair();
        let (sin, cos) = (TAU * self.next()).sin_cos();
        (angle.cos() * axis + angle.sin() * (cos * e + sin * f)).normalize()
    }
}

/// A node with free ends: node 0 at the origin, radii up to 1 mm.
pub fn node(seed: u64, degrees: [usize; 2]) -> Graph {
    let mut numbers = Random::new(seed);
    let degree = degrees[0] + numbers.below(degrees[1] + 1 - degrees[0]);
    let axes = directions(&mut numbers, degree);
    let radii = radii(&mut numbers, axes.len());
    // one node in eight has struts that may be too short for their preferred cuts, or for any
    let scarce = numbers.next() < 0.125;
    let lengths: Vec<f64> = (0..axes.len())
        .map(|i| {
            let [near, far] = radii[i];
            let share = |j: usize| angle(axes[i], axes[j]) * near / (near + radii[j][0]);
            let cut = (0..axes.len()).filter(|&j| j != i).map(|j| near / share(j).min(0.5 * PI - 0.1).tan()).fold(0.0, f64::max);
            let room = if scarce { numbers.between(0.5, 2.0) } else { numbers.between(2.0, 4.0) };
            room * (cut + 2.0) + far
        })
        .collect();
    let nodes = std::iter::once(DVec3::ZERO).chain(axes.iter().zip(&lengths).map(|(u, l)| *u * *l)).collect();
    let struts = radii.iter().enumerate().map(|(k, &[ra, rb])| Strut { a: NodeId(0), b: NodeId(k as u32 + 1), ra, rb }).collect();
    Graph::new(nodes, struts)
}

/// Directions of one of eight kinds, no two nearer than `LEAST_ANGLE`; fewer where so many do not fit.
fn directions(numbers: &mut Random, degree: usize) -> Vec<DVec3> {
    let spread = (100.0 / (degree as f64).sqrt()).max(LEAST_ANGLE);
    // most nodes keep farther apart than they must
    let least = if numbers.next() < 0.3 { LEAST_ANGLE } else { numbers.between(LEAST_ANGLE, spread) };
    let turn = DQuat::from_axis_angle(numbers.direction(), TAU * numbers.next());
    let kind = numbers.below(8);
    let centres: Vec<DVec3> = (0..1 + numbers.below(4)).map(|_| numbers.direction()).collect();
    let narrow = numbers.between(LEAST_ANGLE, 40.0).to_radians();
    let slack = [0.0, 1e-12, 1e-8, 1e-4, 0.02][numbers.below(5)];
    let mut axes: Vec<DVec3> = Vec::new();
    for at in 0..degree {
        for _ in 0..TRIES {
            let u = match kind {
                // anywhere
                0 | 1 => numbers.direction(),
                // around a few centres
                2 => {
                    let wide = narrow * numbers.next().sqrt();
                    numbers.beside(centres[at % centres.len()], wide)
                }
                // in a plane, exactly or nearly, with an arm out of it now and then
                3 if at % 7 == 6 => numbers.direction(),
                3 => {
                    let (sin, cos) = (TAU * numbers.next()).sin_cos();
                    turn * DVec3::new(cos, sin, numbers.between(-slack, slack)).normalize()
                }
                // in a half-space
                4 => {
                    let u = numbers.direction();
                    if u.dot(centres[0]) < 0.0 { -u } else { u }
                }
                // every other one opposite to the one before, exactly or nearly
                5 if at % 2 == 1 && axes.len() == at => numbers.beside(-axes[at - 1], slack),
                5 => numbers.direction(),
                // around a cone
                6 => numbers.beside(centres[0], narrow),
                // of a cubic lattice, exactly or nearly
                _ => {
                    let mut sign = || [-1.0, 0.0, 1.0][numbers.below(3)];
                    let u = DVec3::new(sign(), sign(), sign());
                    if u == DVec3::ZERO {
                        continue;
                    }
                    let u = turn * u.normalize();
                    numbers.beside(u, slack)
                }
            };
            if axes.iter().all(|&v| angle(u, v) >= least.to_radians()) {
                axes.push(u);
                break;
            }
        }
    }
    axes
}

/// Radii at the node and at the free end (mm), at most 1: all equal, mixed, of two sizes, or tapered.
fn radii(numbers: &mut Random, count: usize) -> Vec<[f64; 2]> {
    let least = 1.0 / numbers.between(1.0, MOST_RATIO);
    let kind = numbers.below(4);
    let far = |numbers: &mut Random, r: f64| if numbers.next() < 0.3 { r } else { numbers.scaled(least, 1.0) };
    (0..count)
        .map(|_| match kind {
            0 => [1.0; 2],
            1 => [numbers.scaled(least, 1.0); 2],
            2 => [if numbers.next() < 0.5 { 1.0 } else { least }; 2],
            _ => {
                let near = numbers.scaled(least, 1.0);
                [near, far(numbers, near)]
            }
        })
        .collect()
}

/// A connected graph of 20 to 200 struts: the shortest tree through random nodes, then struts between the nearest of the others, as
/// long as they keep apart. Radii equal, mixed, graded from node to node or tapered.
pub fn graph(seed: u64) -> Graph {
    let mut numbers = Random::new(seed);
    let wanted = 20 + numbers.below(181);
    let count = (wanted as f64 / numbers.between(1.0, 4.0)).ceil() as usize + 1;
    let side = APART * (3.0 * count as f64).cbrt();
    let mut nodes: Vec<DVec3> = Vec::new();
    while nodes.len() < count {
        let p = side * DVec3::new(numbers.next(), numbers.next(), numbers.next());
        if nodes.iter().all(|q| q.distance(p) > APART) {
            nodes.push(p);
        }
    }
    let mut pairs = shortest_tree(&nodes);
    let mut near: Vec<(usize, usize)> = (0..count).flat_map(|i| (0..i).map(move |j| (i, j))).filter(|p| !pairs.contains(p)).collect();
    near.sort_by(|p, q| nodes[p.0].distance(nodes[p.1]).total_cmp(&nodes[q.0].distance(nodes[q.1])));
    pairs.extend(near.into_iter().take(wanted.saturating_sub(pairs.len())));
    let widest = APART * numbers.scaled(0.02, 0.1);
    let least = widest / numbers.between(1.0, MOST_RATIO);
    let of_nodes: Vec<f64> = nodes.iter().map(|_| numbers.scaled(least, widest)).collect();
    let kind = numbers.below(4);
    let strut = |&(a, b): &(usize, usize)| {
        let r = numbers.scaled(least, widest);
        let [ra, rb] = match kind {
            0 => [widest; 2],
            1 => [r; 2],
            2 => [of_nodes[a], of_nodes[b]],
            _ => [r, numbers.scaled(least, widest)],
        };
        Strut { a: NodeId(a as u32), b: NodeId(b as u32), ra, rb }
    };
    let struts: Vec<Strut> = pairs.iter().map(strut).collect();
    // of two struts that come too close, the later goes; those of the tree stay, so that the graph stays connected
    let mut gone = vec![false; struts.len()];
    for miss in near_misses(&Graph::new(nodes.clone(), struts.clone())) {
        gone[miss.b.index()] = true;
    }
    let struts = struts.into_iter().enumerate().filter(|(k, _)| *k < count - 1 || !gone[*k]).map(|(_, s)| s).collect();
    Graph::new(nodes, struts)
}

/// The pairs of nodes, larger index first, of the shortest tree through all (Prim).
fn shortest_tree(nodes: &[DVec3]) -> Vec<(usize, usize)> {
    // for each node outside: the nearest one inside, and its distance
    let mut nearest: Vec<(usize, f64)> = nodes.iter().map(|p| (0, p.distance(nodes[0]))).collect();
    let mut outside: Vec<usize> = (1..nodes.len()).collect();
    let mut pairs = Vec::new();
    while let Some(at) = (0..outside.len()).min_by(|&i, &j| nearest[outside[i]].1.total_cmp(&nearest[outside[j]].1)) {
        let next = outside.swap_remove(at);
        pairs.push((next.max(nearest[next].0), next.min(nearest[next].0)));
        for &k in &outside {
            let distance = nodes[k].distance(nodes[next]);
            if distance < nearest[k].1 {
                nearest[k] = (next, distance);
            }
        }
    }
    pairs
}
