//! The input of every node method: the directions of a node's struts, their radii, and where they are cut.

use crate::graph::Graph;
use crate::ids::NodeId;
pub use crate::math::angle;
use glam::DVec3;

/// One node in node units.
#[derive(Clone, Debug, PartialEq)]
pub struct Star {
    /// Unit vectors along the struts, in the order of `Graph::arms`.
    pub axes: Vec<DVec3>,
    /// Distance of each strut's end circle from the node, same order.
    pub cuts: Vec<f64>,
    /// Radius of each strut at the node, at most 1.
    pub radii: Vec<f64>,
    /// How much each radius grows per unit of length away from the node: 0 for a cylinder.
    pub tapers: Vec<f64>,
}

impl Star {
    /// Directions of the struts at `node`, without cuts.
    pub fn directions(graph: &Graph, node: NodeId) -> Vec<DVec3> {
        let at = graph.nodes()[node.index()];
        graph.arms(node).iter().map(|&arm| (graph.nodes()[graph.far(arm).index()] - at).normalize()).collect()
    }

    /// A star of cylinders of radius 1.
    pub fn uniform(axes: Vec<DVec3>, cuts: Vec<f64>) -> Star {
        let n = axes.len();
        Star { axes, cuts, radii: vec![1.0; n], tapers: vec![0.0; n] }
    }

    /// Whether all struts have one radius at the node.
    pub fn is_uniform(&self) -> bool {
        self.radii.iter().all(|&r| r == self.radii[0])
    }

    /// Whether all struts are cylinders of one radius.
    pub fn is_of_equal_cylinders(&self) -> bool {
        self.is_uniform() && self.tapers.iter().all(|&k| k == 0.0)
    }

    /// Radius of a strut's end circle.
    pub fn rim_radius(&self, arm: usize) -> f64 {
        self.radii[arm] + self.tapers[arm] * self.cuts[arm]
    }

    /// Angle between a strut's axis and its end circle, seen from the node. Radians.
    pub fn cap(&self, arm: usize) -> f64 {
        self.rim_radius(arm).atan2(self.cuts[arm])
    }

    /// Unit normal of a strut, `out` being the unit vector from its axis.
    pub fn normal(&self, arm: usize, out: DVec3) -> DVec3 {
        let taper = self.tapers[arm];
        if taper == 0.0 { out } else { (out - taper * self.axes[arm]).normalize() }
    }

    /// All numbers of the star, to the bit: equal for stars that build the same skin.
    pub fn bits(&self) -> Vec<u64> {
        let axes = self.axes.iter().flat_map(|a| a.to_array());
        axes.chain([&self.cuts, &self.radii, &self.tapers].into_iter().flatten().copied()).map(f64::to_bits).collect()
    }

    /// Number of struts.
    pub fn degree(&self) -> usize {
        self.axes.len()
    }

    /// Distance from the node along unit `u` to the surface of the original shape: the union of the half
    /// cylinders (or cones) and the node sphere of radius 1 (footnote 1 of the paper).
    /// `ρ(u) = max_i r_i / (s_i - k_i c_i)`, `s_i`, `c_i` the sine and cosine of the angle to strut i, k_i its taper; ahead of its plane only.
    pub fn original(&self, u: DVec3) -> f64 {
        self.axes.iter().enumerate().fold(1.0f64, |most, (i, &c)| {
            let ahead = u.dot(c);
            if ahead > 0.0 { most.max(self.radii[i] / (u.cross(c).length() - self.tapers[i] * ahead)) } else { most }
        })
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
