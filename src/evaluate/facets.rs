//! A surface as triangles that share their vertices: what is measured of every film, whoever made it.

use crate::node::mesh::Mesh;
use glam::DVec3;
use std::collections::HashMap;

/// Triangles are counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Facets {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Facets {
    /// The facets of a refined film. Neighbours have their common vertices to the last bit.
    pub fn of_mesh(mesh: &Mesh) -> Facets {
        let (mut out, mut known) = (Facets::default(), HashMap::new());
        for corners in mesh.facets().map(|facet| mesh.corners(facet)) {
            out.triangles.push(corners.map(|p| {
                // + 0: of two zeros one
                *known.entry(p.to_array().map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                    out.points.push(p);
                    out.points.len() as u32 - 1
                })
            }));
        }
        out
    }

    pub fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> {
        self.triangles.iter().map(|t| t.map(|v| self.points[v as usize]))
    }

    /// For edge k of triangle f, from vertex k to the next, at `3 f + k`: the edge of the neighbour across it; none at a rim.
    pub fn twins(&self) -> Vec<Option<usize>> {
        let edges = self.triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])));
        let known: HashMap<(u32, u32), usize> = edges.clone().enumerate().map(|(edge, ends)| (ends, edge)).collect();
        edges.map(|(a, b)| known.get(&(b, a)).copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::{Fairing, Film, Method, Shape, Star, cut};

    /// Facets of all sleeves meet: six discs are missing in a sphere, so V - E + F = 2 - 6, and only rims are open.
    #[test]
    fn sleeves_share_their_vertices() {
        let axes: Vec<DVec3> = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|a| [a, -a]).collect();
        let cuts = cut::cuts(&axes, 0.3);
        let film = Film::build(Star::uniform(axes, cuts), Method::SoapFilm, Fairing::Ray, 1).unwrap();
        let Shape::Soap(mesh) = &film.shape else { unreachable!("a soap film was asked for") };
        let facets = Facets::of_mesh(mesh);
        let twins = facets.twins();
        let open = twins.iter().filter(|twin| twin.is_none()).count();
        assert_eq!(open, mesh.sleeves.iter().map(|sleeve| sleeve.columns).sum::<usize>());
        let edges = (twins.len() + open) / 2;
        assert_eq!(facets.points.len() as i64 - edges as i64 + facets.triangles.len() as i64, 2 - 6);
        assert!(twins.iter().enumerate().all(|(edge, twin)| twin.is_none_or(|twin| twins[twin] == Some(edge))));
    }
}
