//! What a skin must pass before it leaves the patch layer, and the figures that the report shows.

use crate::node::Film;
use crate::patch::{Skin, SkinCurve};
use glam::DVec3;

/// Measured on one skin. Lengths in node units, angles in degrees.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quality {
    /// Largest angle between the normals of two patches along their common edge.
    pub jump: f64,
    /// Largest angle between a patch's normal and the strut's along a rim.
    pub rim_jump: f64,
    /// Least cosine between a patch's normal and the ray from the node; > 0 means no fold.
    pub facing: f64,
    /// Largest and mean distance between skin and film, along the film's normal.
    pub deviation: f64,
    pub mean_deviation: f64,
}

/// Samples along each edge, and per direction inside each patch.
const ALONG: usize = 5;
const INSIDE: usize = 5;

/// The normal of patch `patch` at the point of its border `side` (index into `boundary`) where the edge has parameter `x`.
fn border_normal(skin: &Skin, patch: usize, side: usize, x: f64) -> DVec3 {
    let p = &skin.patches[patch];
    let (_, forward) = p.boundary[side];
    let along = if forward { x } else { 1.0 - x };
    let (u, v) = match side {
        0 => (along, 0.0),
        1 => (1.0, along),
        2 => (1.0 - along, 1.0),
        _ => (0.0, 1.0 - along),
    };
    let jet = p.surface.jet1(u, v);
    jet.du.cross(jet.dv).normalize()
}

/// Measure a skin against the film it was fitted to.
pub fn measure(skin: &Skin, film: &Film) -> Quality {
    let mut q = Quality { facing: 1.0, ..Quality::default() };
    let mut users: Vec<Vec<(usize, usize)>> = vec![Vec::new(); skin.edges.len()];
    for (k, patch) in skin.patches.iter().enumerate() {
        for (side, &(edge, _)) in patch.boundary.iter().enumerate() {
            users[edge].push((k, side));
        }
    }
    for (edge, users) in users.iter().enumerate() {
        for i in 0..ALONG {
            let x = i as f64 / (ALONG - 1) as f64;
            let n = border_normal(skin, users[0].0, users[0].1, x);
            match &skin.edges[edge].curve {
                SkinCurve::Spline(_) => raise(&mut q.jump, degrees(n, border_normal(skin, users[1].0, users[1].1, x))),
                SkinCurve::RimArc(arm) => {
                    // a rim arc has no parameter of its own: ask the patch for the point
                    let p = &skin.patches[users[0].0];
                    let at = p.surface.point(1.0 - x, 0.0);
                    let rim = &skin.rims[*arm];
                    let out = (at - at.dot(rim.axis) * rim.axis).normalize();
                    raise(&mut q.rim_jump, degrees(n, out - rim.taper * rim.axis));
                }
            }
        }
    }
    let mut sampler = film.sampler();
    let mut count = 0.0;
    for patch in &skin.patches {
        for i in 0..INSIDE {
            for step in 0..INSIDE {
                let k = if i % 2 == 0 { step } else { INSIDE - 1 - step };
                let (u, v) = (i as f64 / (INSIDE - 1) as f64, k as f64 / (INSIDE - 1) as f64);
                let jet = patch.surface.jet1(u, v);
                let normal = jet.du.cross(jet.dv).normalize();
                let ray = jet.p.normalize();
                let facing = normal.dot(ray);
                if facing.is_nan() || facing < q.facing {
                    q.facing = facing;
                }
                if let Some(hit) = sampler.hit(ray) {
                    let off = (jet.p.length() - hit.distance).abs() * hit.normal.dot(ray).max(0.0);
                    raise(&mut q.deviation, off);
                    q.mean_deviation += off;
                    count += 1.0;
                }
            }
        }
    }
    q.mean_deviation /= count;
    q
}

/// The larger of both, or NaN where one is: a degenerate point must not pass unseen.
fn raise(worst: &mut f64, value: f64) {
    if value.is_nan() || value > *worst {
        *worst = value;
    }
}

fn degrees(a: DVec3, b: DVec3) -> f64 {
    crate::node::star::angle(a, b).to_degrees()
}

/// Largest normal jump inside a node or at a rim, degrees. The construction keeps 1e-6° unless corners were joined.
pub const MOST_JUMP: f64 = 0.05;

/// Largest distance between skin and film, in node radii: beyond it the skin is another shape.
pub const MOST_DEVIATION: f64 = 0.5;

/// Whether a smooth skin may leave the patch layer.
pub fn accept(q: &Quality) -> Result<(), String> {
    // limits are written so that a NaN fails
    if !(q.jump <= MOST_JUMP) {
        return Err(format!("the skin has a normal jump of {:.3}° (largest allowed {MOST_JUMP}°)", q.jump));
    }
    if !(q.deviation <= MOST_DEVIATION) {
        return Err(format!("the skin is {:.3} radii from its film (largest allowed {MOST_DEVIATION})", q.deviation));
    }
    accept_sharp(q)
}

/// Whether a sharp skin may leave the patch layer: smooth at the rims, and not folded.
pub fn accept_sharp(q: &Quality) -> Result<(), String> {
    if !(q.facing > 0.0) {
        return Err(format!("the skin folds (least cosine between normal and ray {:.3}, must be positive)", q.facing));
    }
    if !(q.rim_jump <= MOST_JUMP) {
        return Err(format!("the skin leaves its strut at {:.3}° (largest allowed {MOST_JUMP}°)", q.rim_jump));
    }
    Ok(())
}
