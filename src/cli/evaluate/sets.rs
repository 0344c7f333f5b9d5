//! The nodes of Case study 1: regular ones, and seeded random ones.

use crate::cli::bench::random::Random;
use glam::DVec3;
use lattice_brep::node::star::angle;

/// Directions tried before a random node is begun again.
const TRIES: usize = 20_000;

/// One row of Table 1.
pub struct Set {
    pub name: &'static str,
    /// Max, Avg and Std of the paper's own method, mm.
    pub paper: [f64; 3],
    /// The same of Savio's method, as the paper gives it.
    pub savio: [f64; 3],
    pub kind: Kind,
}

pub enum Kind {
    Regular(fn() -> Vec<DVec3>),
    /// `degree` directions, uniform on the sphere, no two nearer than `least_angle` degrees.
    Irregular {
        degree: usize,
        least_angle: f64,
    },
}

/// The paper does not say what its twelve directions are (icosahedron or cuboctahedron), nor which its random ones are.
pub const SETS: [Set; 7] = [
    Set { name: "regular-6", paper: [0.2846, 0.0647, 0.0715], savio: [0.2832, 0.1732, 0.0737], kind: Kind::Regular(octahedron) },
    Set { name: "regular-12", paper: [0.3021, 0.0645, 0.0751], savio: [0.3021, 0.1808, 0.0793], kind: Kind::Regular(icosahedron) },
    Set { name: "cuboctahedron", paper: [0.3021, 0.0645, 0.0751], savio: [0.3021, 0.1808, 0.0793], kind: Kind::Regular(cuboctahedron) },
    Set { name: "regular-20", paper: [0.6653, 0.1009, 0.1394], savio: [0.6958, 0.3279, 0.1666], kind: Kind::Regular(dodecahedron) },
    Set { name: "irregular-6", paper: [1.1082, 0.1643, 0.2205], savio: [0.8457, 0.2254, 0.1659], kind: Kind::Irregular { degree: 6, least_angle: 35.0 } },
    Set { name: "irregular-12", paper: [0.9762, 0.1442, 0.1690], savio: [0.8029, 0.1972, 0.1481], kind: Kind::Irregular { degree: 12, least_angle: 25.0 } },
    Set { name: "irregular-20", paper: [1.3798, 0.1681, 0.2480], savio: [0.9722, 0.2059, 0.1601], kind: Kind::Irregular { degree: 20, least_angle: 20.0 } },
];

impl Kind {
    /// The directions of this set's nodes: one regular node, or `count` random ones of the seeds from `seed` on.
    pub fn nodes(&self, count: u64, seed: u64, least_angle: Option<f64>) -> Vec<Vec<DVec3>> {
        match *self {
            Kind::Regular(axes) => vec![axes().into_iter().map(DVec3::normalize).collect()],
            Kind::Irregular { degree, least_angle: usual } => {
                let least = least_angle.unwrap_or(usual).to_radians();
                (seed..seed + count).map(|seed| random(seed, degree, least)).collect()
            }
        }
    }
}

fn random(seed: u64, degree: usize, least: f64) -> Vec<DVec3> {
    let mut numbers = Random::new(seed);
    loop {
        let mut axes: Vec<DVec3> = Vec::new();
        for _ in 0..TRIES {
            let u = numbers.direction();
            if axes.iter().all(|&a| angle(a, u) >= least) {
                axes.push(u);
            }
            if axes.len() == degree {
                return axes;
            }
        }
    }
}

/// All sign changes of a vector, without repeats.
fn signs(p: DVec3) -> Vec<DVec3> {
    let mut out: Vec<DVec3> = Vec::new();
    for k in 0..8 {
        let sign = |bit: i32| if k & bit == 0 { 1.0 } else { -1.0 };
        let q = p * DVec3::new(sign(1), sign(2), sign(4));
        if !out.contains(&q) {
            out.push(q);
        }
    }
    out
}

/// Sign changes of a vector and of its two cyclic permutations.
fn cyclic(p: DVec3) -> Vec<DVec3> {
    [p, DVec3::new(p.y, p.z, p.x), DVec3::new(p.z, p.x, p.y)].into_iter().flat_map(signs).collect()
}

/// The golden ratio.
fn golden() -> f64 {
    0.5 * (1.0 + 5f64.sqrt())
}

fn octahedron() -> Vec<DVec3> {
    cyclic(DVec3::X)
}

fn icosahedron() -> Vec<DVec3> {
    cyclic(DVec3::new(0.0, 1.0, golden()))
}

fn cuboctahedron() -> Vec<DVec3> {
    cyclic(DVec3::new(1.0, 1.0, 0.0))
}

fn dodecahedron() -> Vec<DVec3> {
    [signs(DVec3::ONE), cyclic(DVec3::new(0.0, 1.0 / golden(), golden()))].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_set_has_its_degree_and_keeps_its_angle() {
        let least = |axes: &[DVec3]| {
            let pairs = (0..axes.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
            pairs.map(|(i, j)| angle(axes[i], axes[j]).to_degrees()).fold(f64::INFINITY, f64::min)
        };
        for (set, (degree, wanted)) in SETS.iter().zip([(6, 90.0), (12, 63.4349), (12, 60.0), (20, 41.8103), (6, 35.0), (12, 25.0), (20, 20.0)]) {
            for axes in set.kind.nodes(3, 1, None) {
                let found = least(&axes);
                assert_eq!(axes.len(), degree, "{}", set.name);
                match set.kind {
                    Kind::Regular(_) => assert!((found - wanted).abs() < 1e-4, "{}: {found}", set.name),
                    Kind::Irregular { .. } => assert!(found >= wanted, "{}: {found}", set.name),
                }
            }
        }
    }
}
