//! The input of every node method: the directions of a node's struts and where they are cut.

use crate::graph::Graph;
use crate::ids::NodeId;
pub use crate::math::angle;
use glam::DVec3;

/// One node in node units.
#[derive(Clone, Debug)]
pub struct Star {
    /// Unit vectors along the struts, in the order of `Graph::arms`.
    pub axes: Vec<DVec3>,
    /// Distance of each strut's end circle from the node, same order, > the cell's highest point.
    pub cuts: Vec<f64>,
}

impl Star {
    /// Directions of the struts at `node`, without cuts.
    pub fn directions(graph: &Graph, node: NodeId) -> Vec<DVec3> {
        let at = graph.nodes()[node.index()];
        graph.arms(node).iter().map(|&arm| (graph.nodes()[graph.far(arm).index()] - at).normalize()).collect()
    }

    /// Number of struts.
    pub fn degree(&self) -> usize {
        self.axes.len()
    }

    /// Distance from the node along unit `u` to the surface of the original shape: the union of the half
    /// cylinders and the node sphere (footnote 1 of the paper). `ρ(u) = max_i 1 / s_i(u)`, `s_i` the sine of
    /// the angle to strut i ahead of its plane, 1 behind it.
    pub fn original(&self, u: DVec3) -> f64 {
        let least = self.axes.iter().fold(1.0f64, |least, &c| if u.dot(c) > 0.0 { least.min(u.cross(c).length()) } else { least });
        1.0 / least
    }
}

/// Any unit vector perpendicular to unit `a`, chosen by its smallest component.
pub fn perpendicular(a: DVec3) -> DVec3 {
    let m = a.abs();
    let pick = if m.x <= m.y && m.x <= m.z {
        DVec3::X
    } else if m.y <= m.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    a.cross(pick).normalize()
}
