//! Hand-made skins with known geometry, for tests of the B-rep and STEP layers.
#![allow(dead_code)] // each test file uses its own part

use glam::{DQuat, DVec3};
use lattice_brep::graph::{Graph, Strut};
use lattice_brep::ids::NodeId;
use lattice_brep::math::nurbs::{NurbsCurve, NurbsSurface};
use lattice_brep::patch::{Patch, Rim, Shelved, Skin, SkinCurve, SkinEdge};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A graph whose struts all have one radius (mm).
pub fn graph(nodes: &[DVec3], struts: &[(u32, u32)], radius: f64) -> Graph {
    let strut = |&(a, b): &(u32, u32)| Strut { a: NodeId(a), b: NodeId(b), ra: radius, rb: radius };
    Graph::new(nodes.to_vec(), struts.iter().map(strut).collect())
}

/// The skin of a degree-1 node: one bare rim.
pub fn end(axis: DVec3) -> Skin {
    let rim = Rim { axis, cut: 0.0, radius: 1.0, taper: 0.0, arcs: vec![] };
    Skin { rims: vec![rim], ..Skin::default() }
}

/// The skin of a straight degree-2 node whose arms are `axes[0]` and `axes[1] = -axes[0]`: two
/// rings of `n` exact cylinder patches from the rims (cut 0.5) to a circle about the node, turned
/// by `turn` (radians).
pub fn tube(axes: [DVec3; 2], n: usize, turn: f64) -> Skin {
    tapered_tube(axes, n, turn, [0.0; 2])
}

/// As `tube`, with arms whose radius grows by `slopes` per length away from the node: each ring is an exact cone, and the
/// two meet about the node at radius 1, in a crease where the slopes are not opposite.
pub fn tapered_tube(axes: [DVec3; 2], n: usize, turn: f64, slopes: [f64; 2]) -> Skin {
    let q = DQuat::from_rotation_arc(DVec3::Z, axes[0]);
    let radial = |k: usize| {
        let t = turn + TAU * (k % n) as f64 / n as f64;
        DVec3::new(t.cos(), t.sin(), 0.0)
    };
    let (half, weight) = ((TAU / n as f64 / 2.0).cos(), (TAU / n as f64 / 2.0).cos());
    let middle = |k: usize| (radial(k) + radial(k + 1)) / (2.0 * half * half);
    let at = |p: DVec3, z: f64| q * (p + DVec3::Z * z);
    let ends = |d: usize| -> Arc<[f64]> { [vec![0.0; d + 1], vec![1.0; d + 1]].concat().into() };
    let heights = [0.5, 0.0, -0.5];
    let radii = [1.0 + 0.5 * slopes[0], 1.0, 1.0 + 0.5 * slopes[1]];
    let mut skin = Skin::default();
    for (z, r) in heights.into_iter().zip(radii) {
        skin.vertices.extend((0..n).map(|k| at(r * radial(k), z)));
    }
    let vertex = |ring: usize, k: usize| ring * n + k % n;
    let mut edge = |ends: [usize; 2], curve: SkinCurve| {
        skin.edges.push(SkinEdge { ends, curve });
        skin.edges.len() - 1
    };
    let line = |from: DVec3, to: DVec3| NurbsCurve { degree: 1, knots: ends(1), points: vec![from, to], weights: [1.0; 2].into() };
    let arcs0: Vec<_> = (0..n).map(|k| edge([vertex(0, k), vertex(0, k + 1)], SkinCurve::RimArc(0))).collect();
    let arcs1: Vec<_> = (0..n).map(|k| edge([vertex(2, k + 1), vertex(2, k)], SkinCurve::RimArc(1))).collect();
    let ring: Vec<_> = (0..n)
        .map(|k| {
            let points = vec![at(radial(k), 0.0), at(middle(k), 0.0), at(radial(k + 1), 0.0)];
            let curve = NurbsCurve { degree: 2, knots: ends(2), points, weights: [1.0, weight, 1.0].into() };
            edge([vertex(1, k), vertex(1, k + 1)], SkinCurve::Spline(curve))
        })
        .collect();
    let mut lines = |from: usize| -> Vec<usize> {
        let one = |k| {
            let curve = line(at(radii[from] * radial(k), heights[from]), at(radial(k), 0.0));
            edge([vertex(from, k), vertex(1, k)], SkinCurve::Spline(curve))
        };
        (0..n).map(one).collect()
    };
    let (lines0, lines1) = (lines(0), lines(2));
    for arm in 0..2 {
        for k in 0..n {
            let (z, r) = (heights[2 * arm], radii[2 * arm]);
            let columns = if arm == 0 {
                [(radial(k + 1), 1.0), (middle(k), weight), (radial(k), 1.0)]
            } else {
                [(radial(k), 1.0), (middle(k), weight), (radial(k + 1), 1.0)]
            };
            let points = columns.iter().flat_map(|&(p, _)| [at(r * p, z), at(p, 0.0)]).collect();
            let weights = columns.iter().flat_map(|&(_, w)| [w, w]).collect();
            let surface = NurbsSurface { degree: [2, 1], knots: [ends(2), ends(1)], points, weights };
            let next = (k + 1) % n;
            let boundary = if arm == 0 {
                [(arcs0[k], false), (lines0[k], true), (ring[k], true), (lines0[next], false)]
            } else {
                [(arcs1[k], false), (lines1[next], true), (ring[k], false), (lines1[k], false)]
            };
            skin.patches.push(Patch { surface, boundary, arm });
        }
    }
    let reversed: Vec<_> = (0..n).map(|j| arcs1[n - 1 - j]).collect();
    skin.rims = vec![
        Rim { axis: axes[0], cut: 0.5, radius: radii[0], taper: 0.0, arcs: arcs0 },
        Rim { axis: axes[1], cut: 0.5, radius: radii[2], taper: 0.0, arcs: reversed },
    ];
    skin
}

/// Nodes in a row along `direction` from `origin`, `length` apart, with `turns.len()` tubes
/// between two capped ends. All edges kinds: seams that use vertices, split one arc or two.
pub fn row(origin: DVec3, direction: DVec3, length: f64, radius: f64, turns: &[(usize, f64)]) -> (Graph, Vec<Option<Skin>>) {
    tapered_row(origin, direction, length, &vec![radius; turns.len() + 2], turns)
}

/// As `row`, with a radius (mm) at each node.
pub fn tapered_row(origin: DVec3, direction: DVec3, length: f64, radii: &[f64], turns: &[(usize, f64)]) -> (Graph, Vec<Option<Skin>>) {
    let n = turns.len() + 2;
    let d = direction.normalize();
    let nodes: Vec<_> = (0..n).map(|k| origin + d * (k as f64 * length)).collect();
    let strut = |k: usize| Strut { a: NodeId(k as u32), b: NodeId(k as u32 + 1), ra: radii[k], rb: radii[k + 1] };
    let graph = Graph::new(nodes.clone(), (0..n - 1).map(strut).collect());
    let axis = |a: usize, b: usize| (nodes[b] - nodes[a]).normalize();
    let mut skins = vec![Some(end(axis(0, 1)))];
    for (k, &(sides, turn)) in turns.iter().enumerate() {
        let slopes = [k, k + 2].map(|far| (radii[far] - radii[k + 1]) / length);
        skins.push(Some(tapered_tube([axis(k + 1, k), axis(k + 1, k + 2)], sides, turn, slopes)));
    }
    skins.push(Some(end(axis(n - 1, n - 2))));
    (graph, skins)
}

/// As `assemble` takes them.
pub fn shelved(skins: &[Option<Skin>]) -> Vec<Option<Shelved>> {
    skins.iter().map(|skin| skin.clone().map(Shelved::from)).collect()
}
