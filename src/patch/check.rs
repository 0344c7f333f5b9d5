//! What a skin must pass before it leaves the patch layer, and the figures that the report shows.

use crate::math::nurbs::{Jet1, Table};
use crate::node::Film;
use crate::patch::{Patch, Skin, SkinCurve};
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
    /// The patch with the largest distance: its arm, and its number among the arm's patches, from 1.
    pub farthest: (usize, u32),
    /// Least angle between the iso-lines of a patch.
    pub isoline: f64,
}

/// Samples per direction on each patch, borders included.
const SAMPLES: usize = 5;
const LAST: usize = SAMPLES - 1;

/// Place among a patch's samples of sample k along an edge that is its border `side` (index into `boundary`).
fn border(side: usize, forward: bool, k: usize) -> usize {
    let along = if forward { k } else { LAST - k };
    let (u, v) = match side {
        0 => (along, 0),
        1 => (LAST, along),
        2 => (LAST - along, LAST),
        _ => (0, LAST - along),
    };
    u * SAMPLES + v
}

fn normal(jet: &Jet1) -> DVec3 {
    jet.du.cross(jet.dv).normalize()
}

/// Points and tangents of each patch at these parameters each way, `[iu * parameters + iv]`; patches over the same knots share their tables.
pub fn jets(skin: &Skin, parameters: &[f64]) -> Vec<Vec<Jet1>> {
    let mut tables: Option<[Table; 2]> = None;
    let of = |patch: &Patch| {
        let s = &patch.surface;
        let fits = tables.as_ref().is_some_and(|t| [0, 1].iter().all(|&k| t[k].fits(s.degree[k], &s.knots[k])));
        if !fits {
            tables = Some([0, 1].map(|k| Table::new(s.degree[k], &s.knots[k], parameters.iter().copied())));
        }
        let [u, v] = tables.as_ref().expect("made above");
        s.jets1([u, v])
    };
    skin.patches.iter().map(of).collect()
}

/// Measure a skin against the film it was fitted to.
pub fn measure(skin: &Skin, film: &Film) -> Quality {
    let mut q = Quality { facing: 1.0, isoline: 90.0, ..Quality::default() };
    let jets = jets(skin, &std::array::from_fn::<_, SAMPLES, _>(|k| k as f64 / LAST as f64));
    // (patch, side, runs forward) of the users of each edge, the first two
    let mut users: Vec<[Option<(usize, usize, bool)>; 2]> = vec![[None; 2]; skin.edges.len()];
    for (k, patch) in skin.patches.iter().enumerate() {
        for (side, &(edge, forward)) in patch.boundary.iter().enumerate() {
            let slot = usize::from(users[edge][0].is_some());
            users[edge][slot] = Some((k, side, forward));
        }
    }
    for (edge, users) in skin.edges.iter().zip(&users) {
        for k in 0..SAMPLES {
            let at = |user: usize| {
                let (patch, side, forward) = users[user].expect("an edge of the skin borders a patch, a spline edge two");
                &jets[patch][border(side, forward, k)]
            };
            let first = at(0);
            match &edge.curve {
                SkinCurve::Spline(_) => raise(&mut q.jump, degrees(normal(first), normal(at(1)))),
                SkinCurve::RimArc(arm) => {
                    let rim = &skin.rims[*arm];
                    let out = (first.p - first.p.dot(rim.axis) * rim.axis).normalize();
                    raise(&mut q.rim_jump, degrees(normal(first), out - rim.taper * rim.axis));
                }
            }
        }
    }
    let mut sampler = film.sampler();
    let mut count = 0.0;
    let mut numbers = vec![0; skin.rims.len()];
    for (patch, jets) in skin.patches.iter().zip(&jets) {
        numbers[patch.arm] += 1;
        for i in 0..SAMPLES {
            for step in 0..SAMPLES {
                let jet = &jets[i * SAMPLES + if i % 2 == 0 { step } else { LAST - step }];
                let ray = jet.p.normalize();
                q.isoline = q.isoline.min(jet.du.cross(jet.dv).length().atan2(jet.du.dot(jet.dv).abs()).to_degrees());
                let facing = normal(jet).dot(ray);
                if facing.is_nan() || facing < q.facing {
                    q.facing = facing;
                }
                if let Some(hit) = sampler.hit(ray) {
                    let off = (jet.p.length() - hit.distance).abs() * hit.normal.dot(ray).max(0.0);
                    if off > q.deviation {
                        q.farthest = (patch.arm, numbers[patch.arm]);
                    }
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
