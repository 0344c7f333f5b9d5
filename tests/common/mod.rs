//! Nodes with known shapes and seeded random ones, and checks of skins, for the tests of the node and patch layers.
#![allow(dead_code)] // each test file uses its own part

use glam::{DQuat, DVec3};
use lattice_brep::node::{Star, cut, star};
use lattice_brep::patch::{Skin, SkinCurve};

pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A direction of the x-y plane at an azimuth in degrees.
pub fn flat(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    v(cos, sin, 0.0)
}

/// The star of these directions (any length), cut with the paper's λ = 0.3.
pub fn star(axes: Vec<DVec3>) -> Star {
    let axes: Vec<DVec3> = axes.into_iter().map(|a| a.normalize()).collect();
    let cuts = cut::cuts(&axes, 0.3);
    Star::uniform(axes, cuts)
}

/// The same directions with radii from 1 down to 0.3 in turn, all caps on one distance at which no two meet.
pub fn unequal(axes: Vec<DVec3>) -> Star {
    let mut star = star(axes);
    star.radii = (0..star.degree()).map(|k| [1.0, 0.3, 0.7, 0.5][k % 4]).collect();
    let far = star.cuts.iter().fold(0.0f64, |m, &c| m.max(c));
    star.cuts = vec![far; star.degree()];
    star
}

/// All sign changes of a vector, without repeats.
fn signs(p: DVec3) -> Vec<DVec3> {
    let mut out: Vec<DVec3> = Vec::new();
    for k in 0..8 {
        let s = [1, 2, 4].map(|bit| if k & bit == 0 { 1.0 } else { -1.0 });
        let q = p * v(s[0], s[1], s[2]);
        if !out.contains(&q) {
            out.push(q);
        }
    }
    out
}

/// Sign changes of a vector and of its two cyclic permutations.
fn cyclic(p: DVec3) -> Vec<DVec3> {
    [p, v(p.y, p.z, p.x), v(p.z, p.x, p.y)].into_iter().flat_map(signs).collect()
}

pub fn octahedron() -> Vec<DVec3> {
    vec![v(1.0, 0.0, 0.0), v(-1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, -1.0, 0.0), v(0.0, 0.0, 1.0), v(0.0, 0.0, -1.0)]
}

/// The eight directions of the body-centred lattice.
pub fn bcc() -> Vec<DVec3> {
    signs(v(1.0, 1.0, 1.0))
}

/// The twelve directions of the face-centred lattice (cuboctahedron).
pub fn fcc() -> Vec<DVec3> {
    cyclic(v(1.0, 1.0, 0.0))
}

pub fn tetrahedron() -> Vec<DVec3> {
    vec![v(1.0, 1.0, 1.0), v(1.0, -1.0, -1.0), v(-1.0, 1.0, -1.0), v(-1.0, -1.0, 1.0)]
}

pub fn icosahedron() -> Vec<DVec3> {
    cyclic(v(0.0, 1.0, 0.5 * (1.0 + 5f64.sqrt())))
}

pub fn dodecahedron() -> Vec<DVec3> {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    [signs(v(1.0, 1.0, 1.0)), cyclic(v(0.0, 1.0 / golden, golden))].concat()
}

/// Three directions around +z, each at `degrees` from it.
pub fn half_space(degrees: f64) -> Vec<DVec3> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [0.0, 120.0, 240.0].map(|a| sin * flat(a) + cos * DVec3::Z).to_vec()
}

/// Regular nodes, nodes of cubic lattices with parts missing, flat ones, and sharp ones (two struts 20° apart and less).
pub fn catalogue() -> Vec<(&'static str, Vec<DVec3>)> {
    let oct = octahedron();
    vec![
        ("octahedron", oct.clone()),
        ("bcc", bcc()),
        ("bcc + sc", [bcc(), oct.clone()].concat()),
        ("fcc", fcc()),
        ("tetrahedron", tetrahedron()),
        ("icosahedron", icosahedron()),
        ("dodecahedron", dodecahedron()),
        ("straight", vec![oct[4], oct[5]]),
        ("right angle", vec![oct[0], oct[4]]),
        ("160", vec![flat(0.0), flat(160.0)]),
        ("120 120 120", vec![flat(0.0), flat(120.0), flat(240.0)]),
        ("T", vec![oct[0], oct[1], oct[2]]),
        ("cross", oct[..4].to_vec()),
        ("cubic corner", vec![oct[0], oct[2], oct[4]]),
        ("cubic edge", vec![oct[0], oct[1], oct[2], oct[4]]),
        ("cubic face", oct[..5].to_vec()),
        ("fan 0 40 80", vec![flat(0.0), flat(40.0), flat(80.0)]),
        ("half space 20", half_space(20.0)),
        ("pair 20", vec![flat(0.0), flat(20.0)]),
        ("pair 10 + 4", vec![flat(0.0), flat(10.0), oct[1], oct[3], oct[4], oct[5]]),
    ]
}

/// Nodes of the catalogue where a side lies between exactly opposite struts.
pub const OPPOSITE: [&str; 3] = ["straight", "T", "cubic edge"];

/// Numbers in [0, 1), the same on every machine.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.next() - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        v(r * cos, r * sin, z)
    }

    pub fn rotation(&mut self) -> DQuat {
        DQuat::from_axis_angle(self.direction(), std::f64::consts::TAU * self.next())
    }
}

/// Directions no two of which are nearer than `least` degrees.
pub fn random(seed: u64, degree: usize, least: f64) -> Vec<DVec3> {
    let mut numbers = Random::new(seed);
    loop {
        let mut axes: Vec<DVec3> = Vec::new();
        for _ in 0..20_000 {
            let u = numbers.direction();
            if axes.len() < degree && axes.iter().all(|a| a.dot(u) < least.to_radians().cos()) {
                axes.push(u);
            }
        }
        if axes.len() == degree {
            return axes;
        }
    }
}

/// The 64 random nodes of the fairing tests: eight each of (degree, least angle).
pub fn sixty_four() -> impl Iterator<Item = (String, Vec<DVec3>)> {
    [(4, 20.0), (4, 40.0), (6, 15.0), (6, 35.0), (12, 12.0), (12, 25.0), (20, 10.0), (20, 20.0)]
        .into_iter()
        .flat_map(|(degree, least)| (1..=8).map(move |seed| (format!("degree {degree}, {least}°, seed {seed}"), random(seed, degree, least))))
}

/// The catalogue and the 64 random nodes.
pub fn all_nodes() -> impl Iterator<Item = (String, Vec<DVec3>)> {
    catalogue().into_iter().map(|(name, axes)| (name.to_owned(), axes)).chain(sixty_four())
}

/// Evenly spread unit vectors.
pub fn fibonacci(count: usize) -> impl Iterator<Item = DVec3> {
    let turn = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sin, cos) = (turn * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        v(r * cos, r * sin, z)
    })
}

/// Angle between unit vectors, degrees.
pub fn degrees(a: DVec3, b: DVec3) -> f64 {
    star::angle(a, b).to_degrees()
}

/// Parameters (u, v) of a patch on its border `side`, at `x` in [0, 1] along the boundary loop.
pub fn on_border(side: usize, x: f64) -> (f64, f64) {
    [(x, 0.0), (1.0, x), (1.0 - x, 1.0), (0.0, 1.0 - x)][side]
}

/// Outward unit normal of a patch.
pub fn normal(skin: &Skin, patch: usize, (u, v): (f64, f64)) -> DVec3 {
    let jet = skin.patches[patch].surface.jet1(u, v);
    jet.du.cross(jet.dv).normalize()
}

/// The users of each edge: (patch, border, runs forward).
pub fn users(skin: &Skin) -> Vec<Vec<(usize, usize, bool)>> {
    let mut users = vec![Vec::new(); skin.edges.len()];
    for (k, patch) in skin.patches.iter().enumerate() {
        for (side, &(edge, forward)) in patch.boundary.iter().enumerate() {
            users[edge].push((k, side, forward));
        }
    }
    users
}

/// Largest angle between the normals of both patches along the inner edges, degrees.
pub fn inner_jump(skin: &Skin) -> f64 {
    let mut most = 0.0f64;
    for (edge, users) in skin.edges.iter().zip(users(skin)) {
        if let SkinCurve::Spline(_) = edge.curve {
            for i in 0..=16 {
                let x = i as f64 / 16.0;
                let [a, b] = [0, 1].map(|k| {
                    let (patch, side, forward) = users[k];
                    normal(skin, patch, on_border(side, if forward { x } else { 1.0 - x }))
                });
                let jump = degrees(a, b);
                assert!(jump.is_finite());
                most = most.max(jump);
            }
        }
    }
    most
}

/// Largest distance of the rims from their circles (node units), and largest angle between skin and strut there (degrees).
pub fn rim_errors(skin: &Skin) -> (f64, f64) {
    let (mut off, mut tilt) = (0.0f64, 0.0f64);
    for (k, patch) in skin.patches.iter().enumerate() {
        let rim = &skin.rims[patch.arm];
        for i in 0..=16 {
            let u = i as f64 / 16.0;
            let jet = patch.surface.jet1(u, 0.0);
            let out = jet.p - rim.cut * rim.axis;
            off = off.max(out.dot(rim.axis).abs()).max((out.length() - rim.radius).abs());
            tilt = tilt.max(degrees(normal(skin, k, (u, 0.0)), out.normalize()));
            // columns leave the rim along the axis, towards the node
            tilt = tilt.max(degrees(jet.dv.normalize(), -rim.axis));
        }
    }
    (off, tilt)
}

/// Least cosine between normal and ray from the node over all patches; > 0 means no fold.
pub fn facing(skin: &Skin) -> f64 {
    let mut least = 1.0f64;
    for k in 0..skin.patches.len() {
        for i in 0..=8 {
            for j in 0..=8 {
                let at = (i as f64 / 8.0, j as f64 / 8.0);
                least = least.min(normal(skin, k, at).dot(skin.patches[k].surface.point(at.0, at.1).normalize()));
            }
        }
    }
    least
}

/// Asserts that a skin is a sphere with one hole a rim: loops close, each spline edge has two users in opposite senses, each
/// rim arc one, the rims close counter-clockwise, every shared control point is equal to the bit.
pub fn assert_topology(name: &str, skin: &Skin) {
    for patch in &skin.patches {
        for side in 0..4 {
            let end = |(edge, forward): (usize, bool)| skin.edges[edge].ends[usize::from(forward)];
            let start = |(edge, forward): (usize, bool)| skin.edges[edge].ends[usize::from(!forward)];
            assert_eq!(end(patch.boundary[side]), start(patch.boundary[(side + 1) % 4]), "{name}: a loop is open");
        }
        assert!(patch.surface.weights.iter().all(|&w| w > 0.0), "{name}: a weight is not positive");
        match skin.edges[patch.boundary[0].0].curve {
            SkinCurve::RimArc(arm) => assert_eq!(arm, patch.arm, "{name}"),
            SkinCurve::Spline(_) => panic!("{name}: a patch does not start at its rim"),
        }
    }
    let mut arcs = vec![0; skin.edges.len()];
    for (edge, (users, skin_edge)) in users(skin).iter().zip(&skin.edges).enumerate() {
        match &skin_edge.curve {
            SkinCurve::RimArc(arm) => {
                assert_eq!(users.len(), 1, "{name}: rim arc {edge}");
                // the strut runs along the rim counter-clockwise about its axis, the patch the other way
                assert!(!users[0].2, "{name}: rim arc {edge}");
                let rim = &skin.rims[*arm];
                let [a, b] = skin_edge.ends.map(|k| skin.vertices[k]);
                assert!(rim.axis.dot(a.cross(b)) > 0.0, "{name}: rim arc {edge} is clockwise or above half a turn");
                arcs[edge] = rim.arcs.iter().filter(|&&e| e == edge).count();
                assert_eq!(arcs[edge], 1, "{name}: rim arc {edge}");
            }
            SkinCurve::Spline(curve) => {
                assert_eq!(users.len(), 2, "{name}: edge {edge}");
                assert_ne!(users[0].2, users[1].2, "{name}: edge {edge} is used twice in one sense");
                assert!(curve.weights.iter().all(|&w| w > 0.0), "{name}: a weight is not positive");
                let ends = [curve.points[0], curve.points[curve.points.len() - 1]];
                assert_eq!(ends, skin_edge.ends.map(|k| skin.vertices[k]), "{name}: edge {edge}");
                for &(patch, side, forward) in users {
                    let surface = &skin.patches[patch].surface;
                    let [p, q] = surface.degree;
                    let n = q + 1;
                    let mut row: Vec<usize> = match side {
                        0 => (0..=p).map(|k| k * n).collect(),
                        1 => (0..=q).map(|k| p * n + k).collect(),
                        2 => (0..=p).map(|k| (p - k) * n + q).collect(),
                        _ => (0..=q).map(|k| q - k).collect(),
                    };
                    if !forward {
                        row.reverse();
                    }
                    let scale = surface.weights[row[0]] / curve.weights[0];
                    for (i, &k) in row.iter().enumerate() {
                        assert_eq!(surface.points[k], curve.points[i], "{name}: edge {edge}, control point {i}");
                        assert!((surface.weights[k] / (scale * curve.weights[i]) - 1.0).abs() < 1e-14, "{name}: edge {edge}, weight {i}");
                    }
                }
            }
        }
    }
    for (arm, rim) in skin.rims.iter().enumerate() {
        let mut turn = 0.0;
        for (k, &arc) in rim.arcs.iter().enumerate() {
            let next = rim.arcs[(k + 1) % rim.arcs.len()];
            assert!(matches!(skin.edges[arc].curve, SkinCurve::RimArc(a) if a == arm), "{name}: rim {arm}");
            assert_eq!(skin.edges[arc].ends[1], skin.edges[next].ends[0], "{name}: rim {arm} is open");
            let [a, b] = skin.edges[arc].ends.map(|k| skin.vertices[k] - rim.cut * rim.axis);
            turn += degrees(a.normalize(), b.normalize());
        }
        assert!((turn - 360.0).abs() < 1e-6, "{name}: rim {arm} turns {turn}°");
    }
    // a sphere with one hole a rim
    let euler = skin.vertices.len() as i64 - skin.edges.len() as i64 + skin.patches.len() as i64;
    assert_eq!(euler, 2 - skin.rims.len() as i64, "{name}");
}
