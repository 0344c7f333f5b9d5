//! Surfaces with figures at their points as PLY text: readable by numpy and by viewers.

use glam::DVec3;
use lattice_brep::evaluate::fields::Fields;
use std::io::{self, Write};

/// A comment for each strut direction; vertices with `distance` (mm, positive outside the original node) and `mean_curvature` (1/mm, positive where the solid bulges), to the last bit.
pub fn write(axes: &[DVec3], fields: &Fields, out: &mut dyn Write) -> io::Result<()> {
    let vertex = "property double x\nproperty double y\nproperty double z\nproperty double distance\nproperty double mean_curvature";
    writeln!(out, "ply\nformat ascii 1.0")?;
    axes.iter().try_for_each(|c| writeln!(out, "comment strut {} {} {}", c.x, c.y, c.z))?;
    writeln!(out, "element vertex {}\n{vertex}", fields.points.len())?;
    writeln!(out, "element face {}\nproperty list uchar int vertex_indices\nend_header", fields.triangles.len())?;
    for ((p, distance), mean) in fields.points.iter().zip(&fields.distances).zip(&fields.means) {
        writeln!(out, "{} {} {} {distance} {mean}", p.x, p.y, p.z)?;
    }
    fields.triangles.iter().try_for_each(|[a, b, c]| writeln!(out, "3 {a} {b} {c}"))
}
