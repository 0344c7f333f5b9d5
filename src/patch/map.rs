//! The direction map of a sector: where each parameter (t, v) looks from the node. The project's own construction;
//! `docs/method/patches.md` derives it.
//!
//! A star-shaped surface is a gauge g, homogeneous of degree 1, as {g = 1}; the point that looks along Y is Y / g(Y).
//! With Y(t, v) polynomial and w = g(Y(t, v)) polynomial, Y / w is one rational Bézier patch, and the surface is
//! G1 exactly where g is C1 as a function of direction. Y is fixed before any fit. In cylinder coordinates about the strut
//!
//! ```text
//! Y(t, v) = w2 η(t, v) c + E(t),   E = ±((1 - t²) e + 2 t n),   w2 = 1 + t² = |E|,   t = tan(φ/2)
//! ```
//!
//! so all columns keep their azimuth, the rim is an exact rational circle, and w = w2 is the strut's cylinder. The height
//! η falls from the cut at v = 0 to the crease h(φ) at v = 1. It is chosen so that the C1 conditions on w across the
//! sector's edges have polynomial coefficients of low degree:
//!
//! - across a crease: ∂η/∂v = -l(t), l linear. Then  w_v = l(t) (-½ sin θ (w - t w_t) ± δ)  on both sides, with one
//!   function δ for both;
//! - across a radial: ∂η/∂φ = c(v) ∂η/∂v with c quadratic. Then  ∂(w/w2)/∂φ = χ + c(v) ∂(w/w2)/∂v  on both
//!   sides, with one function χ for both.
//!
//! The map never folds: Y, Y_t, Y_v are independent exactly where ∂η/∂v < 0, which is checked.

use crate::patch::layout::{Crease, Layout, Radial};
use glam::DVec3;

/// Largest speed l in units of the height left between the crease and the rim: below 2 the base profile is monotone.
/// At 1.35 sectors up to about 110° wide keep a regular map and wider ones are split (BCC nodes: 48 patches); at 1.5 120° sectors
/// stay whole (24 patches), but OCC 7.6 then found 10 of the rim arcs of BCC 3x3x3 off their patches by more than its tolerance.
pub const MOST_SPEED: f64 = 1.35;

/// The map must keep at least this part of its mean descent everywhere.
const LEAST_DESCENT: f64 = 0.1;

/// The direction map of one sector.
pub struct SectorMap<'a> {
    crease: &'a Crease,
    ends: [End<'a>; 2],
    /// cot(θ/2): the crease's height at azimuth 0.
    top: f64,
    cut: f64,
    /// Parameter of the rim arc at both ends.
    rim: [f64; 2],
    /// Axis, azimuth 0, and azimuth 90° of the strut, the latter two with the crease's sign.
    frame: [DVec3; 3],
    /// How far the natural crease misses the corners: round-off, unless corners were joined.
    misses: [DVec3; 2],
}

/// What the map must do along one of its radials.
struct End<'a> {
    radial: &'a Radial,
    /// dh/dφ and dl/dφ of the crease.
    slopes: [f64; 2],
    /// d bend / dφ.
    bend: f64,
    /// c(v) = a v + b v (1 - v): c(0) = 0 at the rim; at the corner its value and slope are those of the crease.
    shear: [f64; 2],
}

impl<'a> SectorMap<'a> {
    pub fn new(layout: &'a Layout, sector: usize) -> Self {
        let s = &layout.sectors[sector];
        let crease = &layout.creases[s.crease];
        let radials = s.radials.map(|r| &layout.radials[r]);
        let top = crease.frame.height();
        let per_t = |get: fn(&Radial) -> f64| (get(radials[1]) - get(radials[0])) / (s.t[1] - s.t[0]);
        let ends = [0, 1].map(|end| {
            let radial = radials[end];
            let dt = 0.5 * (1.0 + s.t[end].powi(2)); // dt/dφ
            let slopes = [-top * crease.phi[end].sin(), dt * per_t(|r| r.speed)];
            let [h, l] = slopes;
            let a = -h / radial.speed;
            let shear = [a, a - (l - h * radial.bend / radial.speed) / radial.speed];
            End { radial, slopes, bend: dt * per_t(|r| r.bend), shear }
        });
        let misses = [0, 1].map(|end| {
            let t = crease.t[end];
            (1.0 + t * t) * layout.corners[crease.corners[end]].k - raw_crease(crease, top, t)[0]
        });
        let f = &crease.frame;
        let frame = [f.c[s.which], crease.sign * f.e[s.which], crease.sign * f.n];
        SectorMap { crease, ends, top, cut: radials[0].cut, rim: s.t, frame, misses }
    }

    /// t at s in [0, 1], which runs along the crease.
    pub fn t(&self, s: f64) -> f64 {
        let [a, b] = self.rim;
        (1.0 - s) * a + s * b
    }

    /// w2 at both ends, on the crease's side: what both its sectors share.
    pub fn w2_of_ends(&self) -> [f64; 2] {
        self.crease.t.map(|t| 1.0 + t * t)
    }

    /// The crease's own parameter.
    fn crease_t(&self, s: f64) -> f64 {
        let [a, b] = self.crease.t;
        (1.0 - s) * a + s * b
    }

    /// dt/ds.
    pub fn dt(&self) -> f64 {
        self.crease.t[1] - self.crease.t[0]
    }

    /// The speed l(t) across the crease, linear between the corners.
    pub fn speed(&self, s: f64) -> f64 {
        (1.0 - s) * self.ends[0].radial.speed + s * self.ends[1].radial.speed
    }

    /// Height of the crease, times w2.
    fn height(&self, t: f64) -> f64 {
        self.crease.sign * (1.0 - t * t) * self.top
    }

    /// c(v) at one end (0 or 1): ∂η/∂φ = c(v) ∂η/∂v along the radial.
    pub fn shear(&self, end: usize, v: f64) -> f64 {
        let [a, b] = self.ends[end].shear;
        a * v + b * v * (1.0 - v)
    }

    /// w2 η, and its derivative by q = 1 - v.
    fn profile(&self, s: f64, v: f64) -> (f64, f64) {
        let (t, q) = (self.t(s), 1.0 - v);
        let w2 = 1.0 + t * t;
        let (h, l) = (self.height(t), w2 * self.speed(s));
        let bend = w2 * ((1.0 - s) * self.ends[0].radial.bend + s * self.ends[1].radial.bend);
        let rest = w2 * self.cut - h - l - 0.5 * bend;
        let mut value = h + l * q + 0.5 * bend * q * q + rest * q.powi(3);
        let mut by_q = l + bend * q + 3.0 * rest * q * q;
        // what this base profile misses of the prescribed ∂η/∂φ at both ends
        let hermite = [s * (1.0 - s).powi(2), -(1.0 - s) * s * s];
        for (end, hermite) in self.ends.iter().zip(hermite) {
            let ([h, l], bend, [a, b]) = (end.slopes, end.bend, end.shear);
            let rest = -h - l - 0.5 * bend;
            let (shear, shear_by_q) = (a * v + b * v * q, -a + b * (v - q));
            let [_, fall, fall_by_q] = end.radial.height(q).map(|x| -x);
            let miss = shear * fall - (h + l * q + 0.5 * bend * q * q + rest * q.powi(3));
            let miss_by_q = shear_by_q * fall + shear * fall_by_q - (l + bend * q + 3.0 * rest * q * q);
            value += 2.0 * self.dt() * hermite * miss;
            by_q += 2.0 * self.dt() * hermite * miss_by_q;
        }
        (value, by_q)
    }

    /// The crease ŷ(t) = Y(t, 1), and its first two derivatives by t. Ends are moved onto the corners where corners were joined.
    pub fn crease(&self, s: f64) -> [DVec3; 3] {
        let raw = raw_crease(self.crease, self.top, self.crease_t(s));
        let [a, b] = self.misses;
        let [t0, t1] = self.crease.t;
        [raw[0] + (1.0 - s) * a + s * b, raw[1] + (b - a) / (t1 - t0), raw[2]]
    }

    /// The direction at (s, v): a polynomial of degree 3 in s and 4 in v.
    pub fn y(&self, s: f64, v: f64) -> DVec3 {
        let t = self.t(s);
        let [c, e, n] = self.frame;
        let blend = v * v * (3.0 - 2.0 * v);
        let natural = |v: f64| self.profile(s, v).0 * c + (1.0 - t * t) * e + 2.0 * t * n;
        natural(v) + blend * (self.crease(s)[0] - natural(1.0))
    }

    /// Solid angle per unit of ds dv at (s, v).
    pub fn solid_angle(&self, s: f64, v: f64) -> f64 {
        let w2 = 1.0 + self.t(s).powi(2);
        2.0 * self.dt() * self.profile(s, v).1 * w2 / self.y(s, v).length().powi(3)
    }

    /// Width (radians), mean height from crease to rim, and mean w2.
    pub fn extent(&self) -> (f64, f64, f64) {
        let [a, b] = self.crease.phi;
        let height = self.cut - 0.5 * (self.ends[0].radial.h + self.ends[1].radial.h);
        let [t0, t1] = self.crease.t;
        (b - a, height, 1.0 + (t0 * t0 + t0 * t1 + t1 * t1) / 3.0)
    }

    /// Whether the map descends from the rim to the crease everywhere: then it does not fold.
    pub fn is_regular(&self) -> bool {
        const STEPS: usize = 12;
        (0..=STEPS).all(|i| {
            let s = i as f64 / STEPS as f64;
            let (top, bottom) = (self.profile(s, 0.0).0, self.profile(s, 1.0).0);
            (0..=STEPS).all(|k| self.profile(s, k as f64 / STEPS as f64).1 > LEAST_DESCENT * (top - bottom))
        })
    }
}

/// The natural crease and its first two derivatives by t.
fn raw_crease(crease: &Crease, top: f64, t: f64) -> [DVec3; 3] {
    let f = &crease.frame;
    let m = crease.sign * (top * f.c[0] + f.e[0]);
    let n = crease.sign * 2.0 * f.n;
    [(1.0 - t * t) * m + t * n, -2.0 * t * m + n, -2.0 * m]
}

/// The direction along a radial (height η0 and unit distance from the axis, but for joined corners), at v.
pub fn radial(radial: &Radial, corner: DVec3, v: f64) -> DVec3 {
    let q = 1.0 - v;
    let [height, ..] = radial.height(q);
    let blend = v * v * (3.0 - 2.0 * v);
    height * radial.c + radial.e + blend * (corner - radial.h * radial.c - radial.e)
}
