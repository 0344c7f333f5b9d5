//! The common form of VTK files: points, cells, and a radius for each point or each cell.
//!
//! Lines and polylines become struts, of tetrahedra each edge. An array named `radius` (or `radii`, `rad`, `r`; upper or lower case)
//! gives radii; that of the cells counts for lines, that of the points where there is none.

use super::draft::{Draft, Place};
use super::mesh::Edges;

#[derive(Default)]
pub struct Grid {
    /// x, y, z of one point after the other.
    pub points: Vec<f64>,
    /// Point numbers of all cells, one cell after the other.
    pub connectivity: Vec<f64>,
    /// Where in `connectivity` each cell ends.
    pub ends: Vec<f64>,
    /// VTK's number of each cell's type.
    pub types: Vec<f64>,
    pub point_radius: Option<Vec<f64>>,
    pub cell_radius: Option<Vec<f64>>,
}

/// The array gives radii.
pub fn is_radius(name: &str) -> bool {
    ["radius", "radii", "rad", "r"].contains(&name.to_ascii_lowercase().as_str())
}

fn check_radius(r: f64, place: Place, draft: &mut Draft) -> bool {
    let sound = r.is_finite() && r > 0.0;
    if !sound {
        draft.fault(place, format_args!("{r} as radius"), "a radius > 0");
    }
    sound
}

impl Grid {
    /// Put nodes and struts into the draft; `before` stands before the places of this grid.
    pub fn pour(self, before: &str, edges: &mut Edges, draft: &mut Draft) {
        let (point_kind, cell_kind) = (draft.kind(format!("{before}points["), "]"), draft.kind(format!("{before}cells["), "]"));
        let first = draft.node_count();
        let count = self.points.len() / 3;
        self.check(count, before, draft);
        for (k, p) in self.points.chunks_exact(3).enumerate() {
            let place = Place { kind: point_kind, at: k as u32 };
            let is_sound = p.iter().all(|x| x.is_finite());
            if !is_sound {
                draft.fault(place, format_args!("{} {} {}", p[0], p[1], p[2]), "three finite numbers");
            }
            draft.node(place, is_sound.then(|| [p[0], p[1], p[2]]));
            if draft.is_full() {
                return;
            }
        }
        let cell_radius = |k: usize| self.cell_radius.as_ref().and_then(|r| r.get(k)).copied();
        let point_radius = |n: u32| self.point_radius.as_ref().and_then(|r| r.get((n - first) as usize)).copied();
        let mut start = 0;
        for (k, (&end, &kind)) in self.ends.iter().zip(&self.types).enumerate() {
            let place = Place { kind: cell_kind, at: k as u32 };
            let cell = if end >= start as f64 { self.connectivity.get(start..end as usize) } else { None };
            let Some(cell) = cell else {
                draft.fault(place, format_args!("an end at {end}"), format!("between {start} and {}", self.connectivity.len()));
                edges.broken();
                break;
            };
            start = end as usize;
            // the corners of curved cells come first
            let (corners, name) = match kind as i64 {
                3 | 21 | 35 => (2, ""),
                4 => (cell.len(), ""),
                10 | 24 => (4, ""),
                1 | 2 => (0, "points"),
                5 | 6 | 22 => (0, "triangles"),
                7..=9 | 23 | 28 => (0, "polygons"),
                11 | 12 | 25 | 29 => (0, "hexahedra"),
                13 | 26 => (0, "prisms"),
                14 | 27 => (0, "pyramids"),
                _ => (0, "cells of other types"),
            };
            if !name.is_empty() {
                edges.other(name);
                continue;
            }
            let nodes: Option<Vec<u32>> =
                cell.iter().take(corners).map(|&n| (n >= 0.0 && n < count as f64 && n.fract() == 0.0).then(|| first + n as u32)).collect();
            let nodes = match nodes {
                Some(nodes) if nodes.len() == corners && corners >= 2 => nodes,
                _ => {
                    let shown: Vec<String> = cell.iter().take(4).map(f64::to_string).collect();
                    draft.fault(place, format_args!("the points {}", shown.join(" ")), format!("{} point numbers below {count}", corners.max(2)));
                    edges.broken();
                    continue;
                }
            };
            if kind == 10.0 || kind == 24.0 {
                if nodes.iter().all(|&n| point_radius(n).is_none_or(|r| check_radius(r, place, draft))) {
                    edges.tet(draft, place, [nodes[0], nodes[1], nodes[2], nodes[3]], point_radius);
                }
                continue;
            }
            for pair in nodes.windows(2) {
                let of_points = || point_radius(pair[0]).zip(point_radius(pair[1])).map(<[f64; 2]>::from);
                let radii = cell_radius(k).map(|r| [r; 2]).or_else(of_points);
                if radii.is_none_or(|r| r.into_iter().all(|r| check_radius(r, place, draft))) {
                    edges.line(draft, place, [pair[0], pair[1]], radii);
                }
            }
        }
        if self.cell_radius.is_some() && self.types.iter().any(|&t| t == 10.0 || t == 24.0) {
            draft.note("document", "radii of cells do not count for edges of tetrahedra, which belong to several cells");
        }
    }

    /// Arrays that belong together have the same length.
    fn check(&self, points: usize, before: &str, draft: &mut Draft) {
        let mut same = |name: &str, found: usize, wanted: usize| {
            if found != wanted {
                draft.fault_at(format!("{before}{name}"), format!("{found} values"), format!("{wanted}"));
            }
        };
        same("points", self.points.len(), 3 * points);
        same("types", self.types.len(), self.ends.len());
        same("point radii", self.point_radius.as_ref().map_or(points, Vec::len), points);
        same("cell radii", self.cell_radius.as_ref().map_or(self.types.len(), Vec::len), self.types.len());
    }
}
