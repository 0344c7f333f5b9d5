//! A surface as triangles with its distance from the original node and its mean curvature at every point: what figures 14 and 15 show.
//! Mean curvature of patches from exact derivatives; of meshes by cotangents (Meyer, Desbrun, Schröder & Barr, *Discrete
//! differential-geometry operators for triangulated 2-manifolds*, 2003, equation 8), with a third of the triangles around as area. Positive
//! where the solid bulges, in 1/mm.

use super::facets::Facets;
use crate::math::nurbs::Table;
use crate::node::deviation::Original;
use crate::patch::{Skin, fairness};
use glam::DVec3;

/// Parts each way that a patch is drawn in.
const PARTS: usize = 24;

/// A surface with figures at its points, all lists of points equally long.
#[derive(Clone, Debug, Default)]
pub struct Fields {
    pub points: Vec<DVec3>,
    /// Signed distance from the original node, mm.
    pub distances: Vec<f64>,
    /// 1/mm.
    pub means: Vec<f64>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Fields {
    pub fn of_facets(facets: Facets, original: &Original) -> Fields {
        let distances = facets.points.iter().map(|&p| original.distance(p)).collect();
        let means = mean_curvatures(&facets).into_iter().map(|(mean, _)| mean).collect();
        Fields { points: facets.points, distances, means, triangles: facets.triangles }
    }

    /// Points on borders are there once for each patch.
    pub fn of_skin(skin: &Skin, original: &Original) -> Fields {
        let mut out = Fields::default();
        for patch in &skin.patches {
            let (surface, first) = (&patch.surface, out.points.len());
            let [u, v] = [0, 1].map(|k| Table::even(surface.degree[k], &surface.knots[k], PARTS + 1));
            let at = |i: usize, j: usize| (first + i * (PARTS + 1) + j) as u32;
            for (k, jet) in surface.jets1([&u, &v]).into_iter().enumerate() {
                let [u, v] = [k / (PARTS + 1), k % (PARTS + 1)].map(|x| x as f64 / PARTS as f64);
                out.points.push(jet.p);
                out.distances.push(original.distance(jet.p));
                out.means.push(fairness::mean(surface, u, v));
            }
            for (i, j) in (0..PARTS * PARTS).map(|k| (k / PARTS, k % PARTS)) {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                out.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        out
    }
}

/// Mean curvature at each vertex, and the area it stands for. A rim vertex takes the mean of its neighbours inside: its own ring is open.
pub fn mean_curvatures(facets: &Facets) -> Vec<(f64, f64)> {
    let (points, twins) = (&facets.points, facets.twins());
    let mut laplacian = vec![DVec3::ZERO; points.len()];
    let mut normals = vec![DVec3::ZERO; points.len()];
    let mut areas = vec![0.0; points.len()];
    let mut open = vec![false; points.len()];
    for (f, t) in facets.triangles.iter().enumerate() {
        let t = t.map(|v| v as usize);
        let cross = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
        let twice = cross.length().max(f64::MIN_POSITIVE);
        for k in 0..3 {
            let [i, j, o] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
            let cot = (points[i] - points[o]).dot(points[j] - points[o]) / twice;
            let step = 0.5 * cot * (points[j] - points[i]);
            laplacian[i] += step;
            laplacian[j] -= step;
            areas[i] += twice / 6.0;
            normals[i] += cross;
            if twins[3 * f + k].is_none() {
                (open[i], open[j]) = (true, true);
            }
        }
    }
    // the Laplacian of the position is -2 H times the normal
    let mut means: Vec<f64> = (0..points.len()).map(|v| -0.5 * laplacian[v].dot(normals[v].normalize_or_zero()) / areas[v]).collect();
    let mut inner = vec![(0.0, 0.0); points.len()];
    for t in facets.triangles.iter().map(|t| t.map(|v| v as usize)) {
        for (i, j) in t.into_iter().flat_map(|i| t.map(|j| (i, j))).filter(|&(i, j)| open[i] && !open[j]) {
            inner[i] = (inner[i].0 + means[j], inner[i].1 + 1.0);
        }
    }
    (0..points.len()).filter(|&v| open[v]).for_each(|v| means[v] = inner[v].0 / f64::max(inner[v].1, 1.0));
    means.into_iter().zip(areas).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::{Evaluation, Reading};

    fn octahedron() -> Vec<DVec3> {
        [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|a| [a, -a]).collect()
    }

    /// Both give the tightest valley of the octahedral node.
    #[test]
    fn mesh_and_patches_agree() {
        let surfaces = Evaluation::new(100).surfaces(&octahedron(), &Reading::OURS).unwrap().map(|surface| surface.unwrap().1);
        let [mesh, patches] = surfaces.map(|fields| fields.means.iter().copied().fold(f64::INFINITY, f64::min));
        assert!((mesh / patches - 1.0).abs() < 0.15, "{mesh} {patches}");
    }

    /// A straight node is a cylinder, in facets that are not even.
    #[test]
    fn a_cylinder_is_half_curved() {
        let evaluation = Evaluation::new(100);
        let (film, _) = evaluation.build(&evaluation.star(&[DVec3::X, -DVec3::X]), &Reading::OURS).unwrap();
        let worst = mean_curvatures(&film).into_iter().map(|(mean, _)| (mean - 0.5).abs()).fold(0.0, f64::max);
        assert!(worst < 0.01, "{worst}");
    }
}
