//! A lattice as an assembly: each node with its half struts is a solid of its own, closed by a disc in the middle of every strut's
//! visible part. Nodes whose solids are equal up to a translation, to the bit, share one: a unit.
//!
//! Neighbours touch in coincident discs. Nothing is joined.

use super::assemble::{AssembleOptions, Caps, assemble_parts, disc};
use super::error::BrepError;
use super::model::{Circle, Model, Solid};
use crate::graph::{Arm, End, Graph, Strut};
use crate::ids::{NodeId, StrutId};
use crate::patch::{Rim, Shelved};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// A unit at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Position in the model's solids. Its first node is at the origin there.
    pub unit: u32,
    pub node: NodeId,
    /// mm
    pub at: DVec3,
}

/// What a node and its half struts are, up to a translation: the skin, its unit of length, and for each strut the middle of its
/// visible part (from the node) and the radii there and at the node. All to the bit.
type Key = ((usize, u64), Vec<u64>);

/// A half strut: the other end of the unit's solid, from the node (mm), and the radii at node and end.
struct Half {
    middle: DVec3,
    radii: [f64; 2],
}

/// The different units, each about the origin, and where they stand, in the order of the nodes. Labels are those of a unit's first node.
pub fn units(graph: &Graph, skins: &[Option<Shelved>], options: &AssembleOptions) -> Result<(Model, Vec<Instance>), Vec<BrepError>> {
    let nodes: Vec<NodeId> = graph.used_nodes().collect();
    let cuts = cuts(graph, skins).map_err(|e| vec![e])?;
    let halves_of = |node: NodeId| -> Vec<Half> { graph.arms(node).iter().map(|&arm| half(graph, arm, &cuts)).collect() };
    let key = |&node: &NodeId| -> Key {
        let numbers = |half: Half| [half.middle.to_array().to_vec(), half.radii.to_vec()].concat();
        let skin = skins[node.index()].as_ref().expect("looked at with the cuts").place();
        (skin, halves_of(node).into_iter().flat_map(numbers).map(f64::to_bits).collect())
    };
    let keys: Vec<Key> = nodes.par_iter().map(key).collect();
    let mut known: HashMap<Key, u32> = HashMap::new();
    let (mut firsts, mut instances) = (vec![], vec![]);
    for (&node, key) in nodes.iter().zip(keys) {
        let unit = *known.entry(key).or_insert_with(|| {
            firsts.push(node);
            firsts.len() as u32 - 1
        });
        instances.push(Instance { unit, node, at: graph.nodes()[node.index()] });
    }

    // all units in one graph, each a component about the origin
    let (mut points, mut struts, mut of_points) = (vec![], vec![], vec![]);
    for &node in &firsts {
        let center = NodeId(points.len() as u32);
        points.push(DVec3::ZERO);
        of_points.push(skins[node.index()].clone());
        for half in halves_of(node) {
            struts.push(Strut { a: center, b: NodeId(points.len() as u32), ra: half.radii[0], rb: half.radii[1] });
            let length = half.middle.length();
            let taper = (half.radii[0] - half.radii[1]) / length;
            let rim = Rim { axis: -half.middle / length, cut: 0.0, radius: 1.0, taper, arcs: vec![] };
            of_points.push(Some(disc(rim)));
            points.push(half.middle);
        }
    }
    let parts = Graph::new(points, struts);
    let is_center = |node: NodeId| parts.arms(node).iter().all(|arm| arm.end == End::A);
    let mut model = assemble_parts(&parts, &of_points, &|node| options.caps == Caps::Sphere && is_center(node))?;
    for (solid, &node) in model.solids.iter_mut().zip(&firsts) {
        let arms = graph.arms(node);
        solid.nodes = std::iter::once(node).chain(arms.iter().map(|&arm| graph.far(arm))).collect();
        solid.struts = arms.iter().map(|arm| arm.strut).collect();
        solid.own = 1;
    }
    Ok((model, instances))
}

/// Distances of the rims from their nodes at both ends of each strut, mm.
fn cuts(graph: &Graph, skins: &[Option<Shelved>]) -> Result<Vec<[f64; 2]>, BrepError> {
    let of_node = |node: NodeId| {
        let skin = skins.get(node.index()).and_then(Option::as_ref).ok_or(BrepError::NoSkin { node })?.skin();
        let (found, wanted) = (skin.rims.len(), graph.degree(node));
        if found != wanted {
            return Err(BrepError::RimCount { node, found, wanted });
        }
        Ok(skin.rims.iter().map(|rim| graph.largest_radius(node) * rim.cut).collect::<Vec<f64>>())
    };
    let nodes: Vec<NodeId> = graph.used_nodes().collect();
    let of_nodes: Vec<Vec<f64>> = nodes.par_iter().map(|&node| of_node(node)).collect::<Result<_, _>>()?;
    let mut cuts = vec![[0.0; 2]; graph.struts().len()];
    for (&node, of_node) in nodes.iter().zip(of_nodes) {
        for (arm, cut) in graph.arms(node).iter().zip(of_node) {
            cuts[arm.strut.index()][arm.end as usize] = cut;
        }
    }
    Ok(cuts)
}

fn half(graph: &Graph, arm: Arm, cuts: &[[f64; 2]]) -> Half {
    let at = |node: NodeId| graph.nodes()[node.index()];
    let length = graph.length(arm.strut);
    let [a, b] = cuts[arm.strut.index()];
    let (near, far) = if arm.end == End::A { (a, b) } else { (b, a) };
    let share = (length + near - far) / (2.0 * length);
    let middle = share * (at(graph.far(arm)) - at(graph.near(arm)));
    Half { middle, radii: [graph.radius(arm), graph.radius_at(arm, share * length)] }
}

/// A strut of the lattice between its rims, put together from two units, and the solid of its end a.
pub(super) fn whole_strut<'a>(graph: &Graph, strut: StrutId, place_of: &impl Fn(NodeId) -> (&'a Solid, DVec3)) -> (&'a Solid, [Circle; 2], [bool; 2]) {
    let ends = [End::A, End::B].map(|end| {
        let arm = Arm { strut, end };
        let node = graph.near(arm);
        let (solid, at) = place_of(node);
        let k = graph.arms(node).iter().position(|&a| a == arm).expect("an arm is listed at its node");
        let circle = *solid.rim(k, 0);
        (solid, Circle { center: circle.center + at, ..circle }, solid.round_ends().any(|c| c == 2 * k))
    });
    let [a, b] = ends;
    // both point from a to b
    (a.0, [a.1, Circle { axis: -b.1.axis, ..b.1 }], [a.2, b.2])
}
