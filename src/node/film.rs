//! Film geometry: the control mesh of one node. Luo & Zou 2025, section 3.3.1 (figures 6 and 7) and the
//! upsampling of section 3.3.2 (figure 8a).
//!
//! Columns run along a strut at constant azimuth, from the rim to the cell side; rows run about it. The columns
//! of a side's two cells meet, since azimuths about both struts agree on it. Corners and inserted points sit on the
//! original shape: `ρ(u) u`, the line-cylinder intersection, or the node sphere where the line leaves the cylinder
//! behind the node (without that, half-space nodes spike).
//!
//! Differs from the paper: where the crease is not monotonic (azimuth 0 inside the side) its top is always a column;
//! the other points are inserted by even azimuth steps of at most `STEP` (less on the steep creases of close struts: `narrower`), which for a quarter turn
//! are the paper's three points. The diagonals, which the paper leaves open, all run one way, so inner vertices have valence 6.

use crate::node::Fairing;
use crate::node::cells::{Cells, Side};
use crate::node::mesh::{Rim, Triangles};
use crate::node::star::Star;
use glam::DVec3;

/// Widest azimuth step between columns, radians. The paper's three points on a 90° side give 22.5°.
pub const STEP: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// For `Fairing::Filled`, creases that rise more steeply, as cot(theta/2) of the angle theta between their struts (53°), have narrower steps in proportion, at
/// least a quarter of `STEP`: points then lie as near to each other along the crease. Without it the refined film ripples along the creases of close struts.
const STEEP: f64 = 2.0;

/// Widths of a whole number of steps, as in cubic lattices, are not to be told apart by round-off.
const TIE: f64 = 1e-6;

/// Rows of quads between rim and cell side: the paper inserts three layers of vertices.
pub const LAYERS: usize = 4;

/// Rows that stay on the cylinder: the rim and its 2-ring (section 3.3.2).
pub const FIXED_ROWS: usize = 3;

/// The control mesh, with what fairing and refinement must know of each vertex.
#[derive(Clone, Debug)]
pub struct Control {
    pub points: Vec<DVec3>,
    /// Free to move in fairing.
    pub free: Vec<bool>,
    /// Outward normal of the strut at rim vertices and their 1-ring (figure 11b), none elsewhere.
    pub normals: Vec<Option<DVec3>>,
    pub triangles: Triangles,
    /// Per arm: its vertices row by row, from the rim to the cell's sides, counter-clockwise about the axis.
    pub rows: Vec<Vec<Vec<u32>>>,
    /// Place on its rim circle, for rim vertices.
    pub rims: Vec<Option<Rim>>,
}

/// Azimuths of a side's columns, ends included.
pub fn columns(side: &Side) -> Vec<f64> {
    spread(side, STEP)
}

/// The same, narrower on steep creases (`STEEP`).
pub fn narrower(side: &Side) -> Vec<f64> {
    spread(side, STEP * (STEEP * (0.5 * side.frame.theta).tan()).clamp(0.25, 1.0))
}

fn spread(side: &Side, step: f64) -> Vec<f64> {
    let [a, b] = side.phi;
    let margin = 0.15 * (b - a);
    let stops = if a + margin < 0.0 && 0.0 < b - margin { vec![a, 0.0, b] } else { vec![a, b] };
    let mut phis = vec![a];
    for w in stops.windows(2) {
        let width = w[1] - w[0];
        let parts = if width < 0.25 * step { 1 } else { (width / step - TIE).ceil().max(2.0) as usize };
        for k in 1..=parts {
            phis.push(if k == parts { w[1] } else { w[0] + width * k as f64 / parts as f64 });
        }
    }
    phis
}

/// Build the control mesh of a node.
pub fn control_mesh(star: &Star, cells: &Cells) -> Control {
    mesh(star, cells, LAYERS, columns)
}

/// The control mesh that is faired so.
pub fn mesh_for(star: &Star, cells: &Cells, fairing: Fairing) -> Control {
    mesh(star, cells, LAYERS, if fairing == Fairing::Filled { narrower } else { columns })
}

/// A control mesh of so many rows of quads between rim and cell side, with the columns at these azimuths of a side, its ends included.
pub fn mesh(star: &Star, cells: &Cells, layers: usize, columns: impl Fn(&Side) -> Vec<f64>) -> Control {
    let mut mesh = Control { points: vec![], free: vec![], normals: vec![], triangles: Triangles::default(), rows: vec![], rims: vec![] };
    let on_shape = |y: DVec3| {
        let u = y.normalize();
        star.original(u) * u
    };
    // corners, then the inner columns of each side
    let mut crease: Vec<Vec<u32>> = Vec::with_capacity(cells.sides.len());
    let corners: Vec<u32> = cells.corners.iter().map(|&k| mesh.push(on_shape(k), true, None, None)).collect();
    for side in &cells.sides {
        let phis = columns(side);
        let mut row = vec![corners[side.corners[0]]];
        for &phi in &phis[1..phis.len() - 1] {
            row.push(mesh.push(on_shape(side.frame.crease(phi)), true, None, None));
        }
        row.push(corners[side.corners[1]]);
        crease.push(row);
    }
    for (arm, ring) in cells.around.iter().enumerate() {
        let (c, cut, rim_radius) = (star.axes[arm], star.cuts[arm], star.rim_radius(arm));
        // the cell's outline counter-clockwise: crease vertices, without repeating the corner between sides
        let mut outline: Vec<u32> = Vec::new();
        for &(side, which) in ring {
            let row = &crease[side];
            match which {
                0 => outline.extend(&row[..row.len() - 1]),
                _ => outline.extend(row[1..].iter().rev()),
            }
        }
        let mut rows: Vec<Vec<u32>> = Vec::with_capacity(layers + 1);
        for layer in 0..layers {
            let f = layer as f64 / layers as f64;
            rows.push(
                outline
                    .iter()
                    .map(|&v| {
                        let top = mesh.points[v as usize];
                        let out = (top - top.dot(c) * c).normalize();
                        // linear from the rim to the crease point, then onto the cylinder (the sphere behind the node);
                        // on a cone, and where a thinner strut may lie inside its neighbour, onto the original shape
                        let p = (cut * c + rim_radius * out).lerp(top, f);
                        let height = p.dot(c);
                        let p = if !cells.uniform || star.tapers[arm] != 0.0 {
                            if layer == 0 { p } else { on_shape(p) }
                        } else if height >= 0.0 {
                            height * c + out
                        } else {
                            p.normalize()
                        };
                        let normal = (layer <= 1).then_some(star.normal(arm, out));
                        let rim = (layer == 0).then_some(Rim { arm: arm as u32 });
                        mesh.push(p, layer >= FIXED_ROWS, normal, rim)
                    })
                    .collect(),
            );
        }
        rows.push(outline);
        let n = rows[0].len();
        for layer in 0..layers {
            for k in 0..n {
                let next = (k + 1) % n;
                let (a, b) = (rows[layer][k], rows[layer][next]);
                let (d, e) = (rows[layer + 1][k], rows[layer + 1][next]);
                // counter-clockwise about the axis and towards the node: d below a; outward is (a, d, e), (a, e, b)
                mesh.triangles.0.extend([[a, d, e], [a, e, b]]);
            }
        }
        mesh.rows.push(rows);
    }
    mesh
}

impl Control {
    fn push(&mut self, p: DVec3, free: bool, normal: Option<DVec3>, rim: Option<Rim>) -> u32 {
        self.points.push(p);
        self.free.push(free);
        self.normals.push(normal);
        self.rims.push(rim);
        self.points.len() as u32 - 1
    }
}
