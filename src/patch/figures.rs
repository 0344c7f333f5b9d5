//! What the report tells of a skin's shape, from a few samples a patch: its tightest valley, how far curvature jumps at its edges, and its volume against
//! the original shape's. Node units.

use crate::math::gauss;
use crate::node::Star;
use crate::patch::check::jets;
use crate::patch::fairness;
use crate::patch::{Patch, Skin, SkinCurve};

/// Where curvature is asked for: valleys follow the cell sides (v = 1), rims, only for what jumps there, are at v = 0. All of a patch would cost 6 % of a run.
const U: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const V: [f64; 3] = [0.0, 0.75, 1.0];

/// Gauss points each way for volumes. Measured on `evaluate nodes`: docs/evaluation.md.
const POINTS: usize = 5;

/// Figures of one skin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Largest concave curvature at the samples, in 1/r: 1 over the radius of the tightest valley. 0 where nothing is concave.
    pub concave: f64,
    /// Largest difference of the mean curvatures on both sides of an edge, another patch's or the strut's, in 1/r: tangent planes agree there, curvatures need not.
    pub jump: f64,
    /// Volume outside the original shape, and volume of it that the skin leaves out, in r³.
    pub added: f64,
    pub removed: f64,
}

/// Measure a skin with so many samples as a run can afford.
pub fn measure(skin: &Skin, star: &Star) -> Figures {
    let mut concave = 0.0f64;
    let means = |patch: &Patch| {
        V.map(|v| {
            let mut means = [0.0; U.len()];
            for (mean, (at, hollow)) in means.iter_mut().zip(fairness::curvatures(&patch.surface, U.into_iter(), v)) {
                *mean = at;
                concave = if v > 0.0 { concave.max(hollow) } else { concave };
            }
            means
        })
    };
    let means: Vec<[[f64; U.len()]; V.len()]> = skin.patches.iter().map(means).collect();
    let [added, removed] = volumes(skin, star, POINTS);
    Figures { concave, jump: jump(skin, &means), added, removed }
}

/// The largest difference of mean curvatures (of each patch at the `V` and `U`) on both sides of an edge.
fn jump(skin: &Skin, means: &[[[f64; U.len()]; V.len()]]) -> f64 {
    let last = U.len() - 1;
    let mut most = fairness::most_jump(skin, |patch, side| {
        let [rim, between, crease] = means[patch];
        match side {
            0 => rim,
            1 => [between[last]; U.len()],
            2 => std::array::from_fn(|k| crease[last - k]),
            _ => [between[0]; U.len()],
        }
    });
    for (patch, [at_rim, ..]) in skin.patches.iter().zip(means) {
        if let SkinCurve::RimArc(arm) = skin.edges[patch.boundary[0].0].curve {
            let rim = &skin.rims[arm];
            // mean curvature of the strut: half of one over the radius square to its surface
            let own = 0.5 / (rim.radius * (1.0 + rim.taper * rim.taper).sqrt());
            most = at_rim.iter().fold(most, |most, mean| most.max((mean - own).abs()));
        }
    }
    most
}

/// Volume added to the original shape and removed from it, r³: both are star-shaped, so along the ray of each point p of the skin the
/// difference is (|p|³ - ρ³)/3 per unit of solid angle. So many Gauss points each way.
pub fn volumes(skin: &Skin, star: &Star, points: usize) -> [f64; 2] {
    let (parameters, weights): (Vec<f64>, Vec<f64>) = gauss::rule(points).into_iter().unzip();
    let mut sums = [0.0; 2];
    for jets in jets(skin, &parameters) {
        for (k, jet) in jets.iter().enumerate() {
            let far = jet.p.length();
            let cone = weights[k / points] * weights[k % points] * jet.p.dot(jet.du.cross(jet.dv)) / 3.0;
            let gain = cone * (1.0 - (star.original(jet.p / far) / far).powi(3));
            sums[usize::from(gain < 0.0)] += gain.abs();
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::{Fairing, Film, Method, cut};
    use crate::patch::{Degree, fit};
    use glam::DVec3;

    fn octahedron() -> (Skin, Star) {
        let axes: Vec<DVec3> = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|a| [a, -a]).collect();
        let cuts = cut::cuts(&axes, 0.3);
        let film = Film::build(Star::uniform(axes, cuts), Method::SoapFilm, Fairing::Ray, 3).unwrap();
        (fit(&film, &Degree::new(6)).unwrap().skin, film.star)
    }

    /// The skin's own volume less that of the original in closed form: three crossed cylinders of length 2.6 have
    /// 3 (2.6 π) - 3 (16/3) + 8 (2 - √2).
    #[test]
    fn added_less_removed_is_the_difference_of_volumes() {
        let (skin, star) = octahedron();
        let cuts = star.cuts[0];
        let original = 6.0 * std::f64::consts::PI * cuts - 16.0 + 8.0 * (2.0 - 2f64.sqrt());
        // cones from the node to the rims
        let cones = 6.0 * std::f64::consts::PI * cuts / 3.0;
        let (parameters, weights): (Vec<f64>, Vec<f64>) = gauss::rule(32).into_iter().unzip();
        let inside: f64 = jets(&skin, &parameters)
            .iter()
            .flat_map(|jets| jets.iter().enumerate().map(|(k, jet)| weights[k / 32] * weights[k % 32] * jet.p.dot(jet.du.cross(jet.dv)) / 3.0))
            .sum();
        let [added, removed] = volumes(&skin, &star, 32);
        assert!((added - removed - (inside + cones - original)).abs() < 1e-4, "{added} {removed} {}", inside + cones - original);
        assert!(added > 0.1 && removed < added);
        let few = measure(&skin, &star);
        assert!((few.added / added - 1.0).abs() < 0.01, "{} {added}", few.added);
        // the tightest valley of the octahedral node, as `fairness::measure` finds it at many more places
        let fair = fairness::measure(&skin);
        assert!((few.concave / fair.most_concave - 1.0).abs() < 0.05);
        // and the largest jump between patches, or a larger one at a rim
        assert!(few.jump > 0.9 * fair.most_jump && few.jump < 2.0 * fair.most_jump, "{} {}", few.jump, fair.most_jump);
    }
}
