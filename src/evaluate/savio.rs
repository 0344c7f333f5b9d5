//! The method that the paper compares itself to: Savio, Meneghello & Concheri, *Geometric modeling of lattice structures for additive
//! manufacturing*, Rapid Prototyping Journal 24 (2018) 351-360; reference 6 of Luo & Zou 2025. We have only what the latter say of it:
//! a "relatively coarser control mesh", five iterations (section 4.1), and boundaries subdivided as in their own method (footnote 2).
//!
//! So this is a reconstruction, not a copy. The control mesh is the paper's film without what section 3.3 adds for shape and smoothness: no points
//! inserted along cell sides, no layers between rim and side, no fairing; corners on the original shape, since the paper's figures for it lie
//! near that shape. It is refined by Loop's rules (equations 7-9) with circle sampling on the rims (equation 6).
//!
//! Only its mesh is measured: Loop's rules do not know the cylinder, so it leaves the struts at an angle, and patches must be tangent to them.

use super::facets::Facets;
use crate::node::film::{self, Control};
use crate::node::{Cells, Star};
use glam::DVec3;

/// Refinement levels: section 4.1.
pub const LEVELS: u32 = 5;

/// The refined film.
pub fn film(star: &Star, cells: &Cells) -> Facets {
    let Control { points, triangles, rims, .. } = film::mesh(star, cells, 1, |side| side.phi.to_vec());
    // the arm on whose rim a vertex lies
    let mut arms: Vec<Option<usize>> = rims.iter().map(|rim| rim.map(|rim| rim.arm as usize)).collect();
    let mut facets = Facets { points, triangles: triangles.0 };
    for _ in 0..LEVELS {
        refine(star, &mut facets, &mut arms);
    }
    facets
}

/// β_n of equation 8.
fn beta(n: f64) -> f64 {
    let turn = (std::f64::consts::TAU / n).cos();
    (0.625 - (0.375 + 0.25 * turn) * (0.375 + 0.25 * turn)) / n
}

/// One level, in place: each triangle becomes one at each of its vertices and one in the middle.
fn refine(star: &Star, facets: &mut Facets, arms: &mut Vec<Option<usize>>) {
    let twins = facets.twins();
    let Facets { points, triangles } = facets;
    let corner = |half: usize| triangles[half / 3][half % 3] as usize;
    let next = |half: usize| half - half % 3 + (half + 1) % 3;
    let before = points.clone();
    // equation 9 inside, equation 6 on rims
    let mut middle: Vec<u32> = Vec::with_capacity(twins.len());
    for (half, &twin) in twins.iter().enumerate() {
        let (i, j) = (corner(half), corner(next(half)));
        if let Some(twin) = twin.filter(|&twin| twin < half) {
            middle.push(middle[twin]);
            continue;
        }
        middle.push(points.len() as u32);
        if let Some(twin) = twin {
            let [p, q] = [half, twin].map(|h| corner(next(next(h))));
            points.push(0.375 * (before[i] + before[j]) + 0.125 * (before[p] + before[q]));
            arms.push(None);
        } else {
            let arm = arms[i].expect("an edge without a twin lies on a rim");
            let centre = star.cuts[arm] * star.axes[arm];
            points.push(centre + star.rim_radius(arm) * (before[i] + before[j] - 2.0 * centre).normalize());
            arms.push(Some(arm));
        }
    }
    // equation 7; rims stay
    let mut around = vec![(0.0, DVec3::ZERO); before.len()];
    for half in 0..middle.len() {
        let (count, sum) = &mut around[corner(half)];
        *count += 1.0;
        *sum += before[corner(next(half))];
    }
    for (v, (count, sum)) in around.into_iter().enumerate().filter(|&(v, _)| arms[v].is_none()) {
        let beta = beta(count);
        points[v] = (1.0 - count * beta) * before[v] + beta * sum;
    }
    let parts = |(f, &[a, b, c]): (usize, &[u32; 3])| {
        let [ab, bc, ca] = [0, 1, 2].map(|k| middle[3 * f + k]);
        [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
    };
    *triangles = triangles.iter().enumerate().flat_map(parts).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::cut;

    #[test]
    fn rims_are_circles_and_numbers_are_those_of_the_octahedron() {
        let axes: Vec<DVec3> = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|a| [a, -a]).collect();
        let cuts = cut::cuts(&axes, 0.3);
        let star = Star::uniform(axes, cuts);
        let mesh = film(&star, &Cells::new(&star).unwrap());
        // 6 cells of 4 sides, two triangles each, in 4^5 parts
        assert_eq!(mesh.triangles.len(), 6 * 4 * 2 * 1024);
        let twins = mesh.twins();
        let rim: Vec<usize> = (0..twins.len()).filter(|&h| twins[h].is_none()).map(|h| mesh.triangles[h / 3][h % 3] as usize).collect();
        assert_eq!(rim.len(), 6 * 4 * 32);
        for v in rim {
            let p = mesh.points[v];
            let arm = (0..6).max_by(|&i, &j| p.dot(star.axes[i]).total_cmp(&p.dot(star.axes[j]))).unwrap();
            let height = p.dot(star.axes[arm]);
            assert!((height - star.cuts[arm]).abs() < 1e-12 && ((p - height * star.axes[arm]).length() - 1.0).abs() < 1e-12);
        }
    }

    /// On a flat mesh of valence 6 Loop's rules keep a plane and its affine maps.
    #[test]
    fn weights_sum_to_one() {
        assert!((beta(6.0) - 1.0 / 16.0).abs() < 1e-15 && (beta(3.0) - 3.0 / 16.0).abs() < 1e-15);
    }
}
