//! Where a strut's straight seam goes. The rims at the two ends have vertices at other azimuths,
//! so that at most ends the seam needs a vertex of its own, which splits a rim arc. Readers
//! dislike tiny edges: the seam keeps its distance from vertices that it does not use.

use std::f64::consts::{PI, TAU};

/// Vertices of two rims closer than this (radians) count as one azimuth. The seam between them is
/// then off its ruling by less than this times the radius: far below any reader's tolerance.
pub const SAME: f64 = 1e-7;

/// A seam that starts at a vertex of rim a must miss the vertices of rim b by this much (radians,
/// about 3°, guessed): shorter arcs than this would be the smallest edges of the whole solid.
pub const CLEAR: f64 = 0.05;

/// The place of the seam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// Radians.
    pub azimuth: f64,
    /// The vertex of rim a and of rim b that the seam uses; `None`: the arc is split there.
    pub at: [Option<usize>; 2],
}

/// Place the seam from the azimuths of the two rims' vertices (radians, in one common frame,
/// any order). In this order: two vertices at one azimuth; the vertex of rim a that is farthest
/// from those of rim b; if that is still too close, the middle of the widest gap of both.
/// Empty rims (capped ends) have no say. Ties go to the first index.
pub fn place(a: &[f64], b: &[f64]) -> Seam {
    let nearest = |x: f64, of: &[f64]| {
        let apart = of.iter().map(|&y| separation(x, y)).enumerate();
        apart.fold((usize::MAX, f64::INFINITY), |m, n| if n.1 < m.1 { n } else { m })
    };
    match (a, b) {
        ([], []) => return Seam { azimuth: 0.0, at: [None, None] },
        (&[first, ..], []) => return Seam { azimuth: first, at: [Some(0), None] },
        ([], &[first, ..]) => return Seam { azimuth: first, at: [None, Some(0)] },
        _ => {}
    }
    let mut best = (0, 0.0);
    for (i, &x) in a.iter().enumerate() {
        let (j, apart) = nearest(x, b);
        if apart <= SAME {
            return Seam { azimuth: x, at: [Some(i), Some(j)] };
        }
        // A clear win only, so that round-off does not decide between equal places.
        if apart > best.1 + 1e-9 {
            best = (i, apart);
        }
    }
    if best.1 >= CLEAR {
        return Seam { azimuth: a[best.0], at: [Some(best.0), None] };
    }
    let mut all: Vec<f64> = a.iter().chain(b).map(|x| x.rem_euclid(TAU)).collect();
    all.sort_by(f64::total_cmp);
    let mut widest = (0.0, 0.0);
    for (k, &x) in all.iter().enumerate() {
        let next = if k + 1 < all.len() { all[k + 1] } else { all[0] + TAU };
        if next - x > widest.1 + 1e-9 {
            widest = (x, next - x);
        }
    }
    Seam { azimuth: widest.0 + 0.5 * widest.1, at: [None, None] }
}

/// Angle between two azimuths, 0 to π.
fn separation(x: f64, y: f64) -> f64 {
    let d = (x - y).rem_euclid(TAU);
    if d > PI { TAU - d } else { d }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_vertices_are_used() {
        let seam = place(&[0.3, 2.0, 4.0], &[1.0, 4.0 + TAU + 1e-9]);
        assert_eq!(seam, Seam { azimuth: 4.0, at: [Some(2), Some(1)] });
    }

    #[test]
    fn otherwise_the_farthest_vertex_of_a() {
        let seam = place(&[0.1, 2.0, 4.0], &[0.0, 2.2, 4.7]);
        assert_eq!(seam, Seam { azimuth: 4.0, at: [Some(2), None] });
    }

    #[test]
    fn almost_equal_rims_split_both_arcs() {
        let seam = place(&[0.0, 2.0, 4.0], &[0.01, 2.01, 4.01]);
        assert_eq!(seam.at, [None, None]);
        assert!((seam.azimuth - 0.5 * (4.01 + TAU)).abs() < 1e-12);
    }

    #[test]
    fn capped_ends_follow_the_other() {
        assert_eq!(place(&[], &[1.5, 3.0]), Seam { azimuth: 1.5, at: [None, Some(0)] });
        assert_eq!(place(&[1.5], &[]), Seam { azimuth: 1.5, at: [Some(0), None] });
        assert_eq!(place(&[], &[]).at, [None, None]);
    }
}
