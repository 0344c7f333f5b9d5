//! Sampled geometry checks along every edge of the patches: gaps, jumps of the normal, folds.
//! Both sides of an edge are evaluated at the same parameter, about their node (mm).

use super::error::BrepError;
use super::model::{Curve, Label, Model, Part, Solid, Surface};
use crate::ids::NodeId;
use crate::math::nurbs::{Jet1, Table};
use glam::DVec3;
use rayon::prelude::*;
use std::fmt;
use std::sync::Arc;

/// The worst of many samples, and the two faces that meet there (twice the same for a value that
/// belongs to one face).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    pub value: f64,
    pub at: Option<[Label; 2]>,
}

impl Worst {
    const NONE: Worst = Worst { value: 0.0, at: None };

    fn raise(&mut self, value: f64, at: [Label; 2]) {
        if value > self.value || value.is_nan() {
            *self = Worst { value, at: Some(at) };
        }
    }

    fn merge(self, other: Worst) -> Worst {
        if other.value > self.value || other.value.is_nan() { other } else { self }
    }
}

impl fmt::Display for Worst {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.at {
            Some([a, b]) if a == b => write!(f, "{a}"),
            Some([a, b]) => write!(f, "{a} against {b}"),
            None => write!(f, "nowhere"),
        }
    }
}

/// What the samples showed. Worst places are the first in face order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Largest angle between the normals of patch and strut (cylinder or cone), degrees.
    pub rim_jump_deg: Worst,
    /// Largest angle between the normals of two patches of a node, degrees.
    pub inner_jump_deg: Worst,
    /// Largest distance of a patch border from its circle or edge curve, or of a curve's end from
    /// its vertex, mm.
    pub gap_mm: Worst,
    /// Smallest cosine between a patch's normal and the ray from the node; 1 without patches.
    pub facing: Worst,
}

/// What a model must keep to be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QualityLimits {
    pub rim_jump_deg: f64,
    pub inner_jump_deg: f64,
    pub gap_mm: f64,
    /// Below this cosine a patch counts as folded.
    pub facing: f64,
}

impl Quality {
    /// Every limit that is broken; a NaN breaks its limit.
    pub fn check(&self, limits: &QualityLimits) -> Result<(), Vec<BrepError>> {
        let mut faults = vec![];
        let above = |value: f64, limit: f64| !(value <= limit);
        if above(self.gap_mm.value, limits.gap_mm) {
            let (place, gap) = (self.gap_mm.to_string(), self.gap_mm.value);
            faults.push(BrepError::Gap { place, gap, limit: limits.gap_mm });
        }
        for (worst, limit) in [(self.rim_jump_deg, limits.rim_jump_deg), (self.inner_jump_deg, limits.inner_jump_deg)] {
            if above(worst.value, limit) {
                faults.push(BrepError::Jump { place: worst.to_string(), jump: worst.value, limit });
            }
        }
        if !(self.facing.value >= limits.facing) {
            faults.push(BrepError::Folded { face: self.facing.to_string(), facing: self.facing.value });
        }
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    fn none() -> Self {
        let facing = Worst { value: 1.0, at: None };
        Quality { rim_jump_deg: Worst::NONE, inner_jump_deg: Worst::NONE, gap_mm: Worst::NONE, facing }
    }

    fn merge(self, other: Quality) -> Quality {
        let facing = if other.facing.value < self.facing.value || other.facing.value.is_nan() { other.facing } else { self.facing };
        Quality {
            rim_jump_deg: self.rim_jump_deg.merge(other.rim_jump_deg),
            inner_jump_deg: self.inner_jump_deg.merge(other.inner_jump_deg),
            gap_mm: self.gap_mm.merge(other.gap_mm),
            facing,
        }
    }
}

/// Sample a model: `samples` points on every patch side (ends included, at least 2), their square
/// inside every patch. Creases inside the `sharp` nodes (ascending) are meant to be there: their jumps do not count.
pub fn quality(model: &Model, samples: usize, sharp: &[NodeId]) -> Quality {
    let samples = samples.max(2);
    let of_solid = |solid: &Solid| {
        let nodes: Vec<Quality> = (0..solid.nodes.len())
            .into_par_iter()
            .map(|n| {
                let mut quality = node_quality(solid, &solid.part(n), samples);
                if sharp.binary_search(&solid.nodes[n]).is_ok() {
                    quality.inner_jump_deg = Worst::NONE;
                }
                quality
            })
            .collect();
        nodes.into_iter().fold(Quality::none(), Quality::merge)
    };
    model.solids.iter().map(of_solid).fold(Quality::none(), Quality::merge)
}

/// A sampled patch of a node, about the node (mm): jets at even parameters, `[iu * samples + iv]`.
struct Sampled {
    jets: Vec<Jet1>,
    samples: usize,
    label: Label,
}

impl Sampled {
    /// Sample k of side `side`, walked in the sense of the face's loop. 0: v = 0, 1: u = 1, 2: v = 1, 3: u = 0.
    fn border(&self, side: usize, k: usize) -> &Jet1 {
        let last = self.samples - 1;
        let (u, v) = match side {
            0 => (k, 0),
            1 => (last, k),
            2 => (last - k, last),
            _ => (0, last - k),
        };
        &self.jets[u * self.samples + v]
    }
}

/// The tables of the last knot vectors met: all patches of a node share them.
#[derive(Default)]
struct Tables(Vec<Table>);

impl Tables {
    fn of(&mut self, degree: usize, knots: &Arc<[f64]>, samples: usize) -> usize {
        self.0.iter().position(|t| t.fits(degree, knots)).unwrap_or_else(|| {
            self.0.push(Table::even(degree, knots, samples));
            self.0.len() - 1
        })
    }
}

fn normal(jet: &Jet1) -> DVec3 {
    jet.du.cross(jet.dv).normalize()
}

/// Angle between two unit vectors, degrees; exact for small angles.
fn angle_deg(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

fn node_quality(solid: &Solid, part: &Part, samples: usize) -> Quality {
    let mut out = Quality::none();
    let origin = part.center;
    let mut tables = Tables::default();
    let mut patches: Vec<Sampled> = vec![];
    // (edge, patch, side, walked forward) of every spline edge.
    let mut uses = vec![];
    for face in &part.faces {
        let Surface::Spline(spline) = &face.surface else { continue };
        let label = face.label;
        let [u, v] = [0, 1].map(|k| tables.of(spline.degree[k], &spline.knots[k], samples));
        let jets = part.spline_surface(spline, origin).jets1([&tables.0[u], &tables.0[v]]);
        let patch = Sampled { jets, samples, label };
        let mut walk = face.boundary.iter();
        for (side, &count) in spline.sides.iter().enumerate() {
            for e in walk.by_ref().take(count as usize) {
                let edge = part.edge(e.edge);
                match &edge.curve {
                    Curve::Spline(_) => uses.push((e.edge, patches.len(), side, e.forward)),
                    Curve::Arc(c) => {
                        for v in edge.vertices {
                            out.gap_mm.raise(solid.circles[*c].distance(solid.vertex(part, v)), [label; 2]);
                        }
                    }
                    Curve::Line => {}
                }
            }
        }
        if let Curve::Arc(c) = part.edge(face.boundary[0].edge).curve {
            let circle = &solid.circles[c];
            let strut = label.strut().map_or(label, Label::Strut);
            for k in 0..samples {
                let jet = patch.border(0, k);
                let of_strut = solid.strut_normal(c / 2, jet.p + (origin - circle.center));
                out.rim_jump_deg.raise(angle_deg(normal(jet), of_strut), [label, strut]);
                out.gap_mm.raise(circle.distance(jet.p + origin), [label, strut]);
            }
        }
        facing(&mut out, &patch);
        patches.push(patch);
    }
    uses.sort_unstable();
    for pair in uses.chunk_by(|a, b| a.0 == b.0) {
        edge_quality(&mut out, solid, part, &patches, pair, &mut tables);
    }
    out
}

/// Normal against ray on a grid over the patch, borders included.
fn facing(out: &mut Quality, patch: &Sampled) {
    for jet in &patch.jets {
        let value = normal(jet).dot(jet.p.normalize());
        if value < out.facing.value || value.is_nan() {
            out.facing = Worst { value, at: Some([patch.label; 2]) };
        }
    }
}

/// One spline edge against the patches that use it.
fn edge_quality(out: &mut Quality, solid: &Solid, part: &Part, patches: &[Sampled], uses: &[(u32, usize, usize, bool)], tables: &mut Tables) {
    let origin = part.center;
    let edge = part.edge(uses[0].0);
    let Curve::Spline(spline) = &edge.curve else { return };
    let samples = patches[uses[0].1].samples;
    let table = tables.of(spline.degree, &spline.knots, samples);
    let points: Vec<DVec3> = part.spline_curve(spline, origin).points_at(&tables.0[table]).collect();
    let labels = [patches[uses[0].1].label, patches[uses[uses.len() - 1].1].label];
    for (p, v) in [(points[0], edge.vertices[0]), (points[samples - 1], edge.vertices[1])] {
        out.gap_mm.raise(p.distance(solid.vertex(part, v) - origin), labels);
    }
    for (k, on_curve) in points.into_iter().enumerate() {
        let mut first = None;
        for &(_, patch, side, forward) in uses {
            let jet = patches[patch].border(side, if forward { k } else { samples - 1 - k });
            out.gap_mm.raise(jet.p.distance(on_curve), [patches[patch].label; 2]);
            let n = normal(jet);
            match first {
                None => first = Some(n),
                Some(m) => out.inner_jump_deg.raise(angle_deg(m, n), labels),
            }
        }
    }
}
