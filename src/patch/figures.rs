//! What the report tells of a skin's shape, from a few samples a patch: its tightest valley, and its volume against the original shape's.
//! Node units.

use crate::node::Star;
use crate::patch::Skin;
use crate::patch::check::jets;
use crate::patch::fairness;

/// Parts each way on each patch. Measured on the 154 nodes of `evaluate nodes`, against 32 parts: docs/method/evaluation.md.
const PARTS: usize = 4;

/// Figures of one skin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Largest concave curvature at the samples, in 1/r: 1 over the radius of the tightest valley. 0 where nothing is concave.
    pub concave: f64,
    /// Volume outside the original shape, and volume of it that the skin leaves out, in r³.
    pub added: f64,
    pub removed: f64,
}

/// Measure a skin with so many samples as a run can afford.
pub fn measure(skin: &Skin, star: &Star) -> Figures {
    let places = || (0..=PARTS).map(|k| k as f64 / PARTS as f64);
    let of = |surface| places().flat_map(move |u| places().map(move |v| fairness::concave(surface, u, v)));
    let concave = skin.patches.iter().flat_map(|patch| of(&patch.surface)).fold(0.0, f64::max);
    let [added, removed] = volumes(skin, star, PARTS);
    Figures { concave, added, removed }
}

/// Volume added to the original shape and removed from it, r³: both are star-shaped, so along the ray of each point p of the skin the
/// difference is (|p|³ - ρ³)/3 per unit of solid angle. Simpson's rule with an even number of parts each way.
pub fn volumes(skin: &Skin, star: &Star, parts: usize) -> [f64; 2] {
    debug_assert!(parts.is_multiple_of(2));
    let mut sums = [0.0; 2];
    for jets in jets(skin, parts + 1) {
        for (k, jet) in jets.iter().enumerate() {
            let weight = share(k / (parts + 1), parts) * share(k % (parts + 1), parts);
            let far = jet.p.length();
            let gain = weight * jet.p.dot(jet.du.cross(jet.dv)) / 3.0 * (1.0 - (star.original(jet.p / far) / far).powi(3));
            sums[usize::from(gain < 0.0)] += gain.abs();
        }
    }
    sums
}

/// Weight of sample k in Simpson's rule over [0, 1].
fn share(k: usize, parts: usize) -> f64 {
    let factor = match k {
        0 => 1.0,
        k if k == parts => 1.0,
        k if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    factor / (3.0 * parts as f64)
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
        let inside: f64 = jets(&skin, 33)
            .iter()
            .flat_map(|jets| jets.iter().enumerate().map(|(k, jet)| share(k / 33, 32) * share(k % 33, 32) * jet.p.dot(jet.du.cross(jet.dv)) / 3.0))
            .sum();
        let [added, removed] = volumes(&skin, &star, 32);
        assert!((added - removed - (inside + cones - original)).abs() < 1e-4, "{added} {removed} {}", inside + cones - original);
        assert!(added > 0.1 && removed < added);
        let few = measure(&skin, &star);
        assert!((few.added / added - 1.0).abs() < 0.06, "{} {added}", few.added);
        // the tightest valley of the octahedral node, as `fairness::measure` finds it at many more places
        assert!((few.concave / fairness::measure(&skin).most_concave - 1.0).abs() < 0.05);
    }
}
