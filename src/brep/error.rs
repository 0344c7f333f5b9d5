//! Everything that can be wrong with a solid, one variant per invariant.

use super::clearance::Crossing;
use crate::ids::{NodeId, StrutId};

/// A fault found while a solid is put together or checked before writing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BrepError {
    #[error("node {0}: no skin, but struts end there", .node.0)]
    NoSkin { node: NodeId },
    #[error("node {0}: the skin has {found} rims for {wanted} struts", .node.0)]
    RimCount { node: NodeId, found: usize, wanted: usize },
    #[error("node {0}, strut {1}: the rim's arcs do not close into one circle", .node.0, .strut.0)]
    RimNotClosed { node: NodeId, strut: StrutId },
    #[error("node {0}, strut {1}: the rim's axis leaves the strut by {angle:.3e} rad", .node.0, .strut.0)]
    RimAxis { node: NodeId, strut: StrutId, angle: f64 },
    #[error("node {0}, strut {1}: rim radius {found} mm, strut radius there {wanted} mm", .node.0, .strut.0)]
    RimRadius { node: NodeId, strut: StrutId, found: f64, wanted: f64 },
    #[error("strut {0}: its rims leave {room} mm of strut; more than 0 is needed", .strut.0)]
    NoRoom { strut: StrutId, room: f64 },
    #[error("solid {solid}, edge {edge}: used {forward} times forward and {backward} times backward; once each is needed")]
    EdgeUse { solid: usize, edge: usize, forward: usize, backward: usize },
    #[error("solid {solid}, {face}: its boundary loop is open or empty")]
    OpenLoop { solid: usize, face: String },
    #[error("solid {solid}: its faces are {islands} shells; one is needed")]
    Islands { solid: usize, islands: usize },
    #[error("solid {solid}: {rings} rings of faces around {vertices} vertices; one a vertex is needed")]
    Pinched { solid: usize, rings: usize, vertices: usize },
    #[error("solid {solid}: V - E + F = {found}, but the graph asks for {wanted}")]
    Euler { solid: usize, found: i64, wanted: i64 },
    #[error("node {0}: its skin encloses {volume} mm³; it must be positive (inside out?)", .node.0)]
    InsideOut { node: NodeId, volume: f64 },
    #[error("{face}: folded, its normal meets the ray from the node at cosine {facing:.3}")]
    Folded { face: String, facing: f64 },
    #[error("{place}: gap of {gap:.3e} mm; at most {limit:.3e} mm is allowed")]
    Gap { place: String, gap: f64, limit: f64 },
    #[error("{place}: normals jump by {jump:.3e} degrees; at most {limit:.3e} is allowed")]
    Jump { place: String, jump: f64, limit: f64 },
    #[error("node {node}: {0}", node = .0.node.0)]
    Crossing(Crossing),
}
