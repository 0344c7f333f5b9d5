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
use glam::{DVec2, DVec3};

/// Largest speed l in units of the height left between the crease and the rim: below 2 the base profile is monotone.
/// At 1.35 sectors up to about 110° wide keep a regular map and wider ones are split (BCC nodes: 48 patches). From 1.37 on 120° sectors stay whole (24 patches, files a third
/// smaller), but the descent left at the rim is a quarter of the mean: of gmsh's quadratic elements more then turn inside out (BCC node, r/16: 37 of 17,444, at 1.35 2 of 18,011), the peak stress there
/// does not converge, and the patches of a dodecahedral node ripple.
pub const MOST_SPEED: f64 = 1.35;

/// The map must keep at least this part of its mean descent everywhere.
const LEAST_DESCENT: f64 = 0.1;

/// Misses of the corners below this are round-off, node units.
const ROUND_OFF: f64 = 1e-12;

/// Degree of Y in s, and in v: where columns keep their azimuth, and where they turn.
pub const DEGREE: usize = 3;
pub const COLUMN_DEGREE: usize = 4;
pub const TURNED_DEGREE: usize = 4;
pub const TURNED_COLUMN_DEGREE: usize = 6;

/// The direction map of one sector.
pub struct SectorMap<'a> {
    crease: &'a Crease,
    which: usize,
    ends: [End<'a>; 2],
    cut: f64,
    /// Parameter of the rim arc at both ends, where columns keep their azimuth.
    rim: [f64; 2],
    /// Axis, azimuth 0, and azimuth 90° of the strut, the latter two with the crease's sign.
    frame: [DVec3; 3],
    /// How far the natural crease misses the corners: round-off, unless corners were joined.
    misses: [DVec3; 2],
    /// Slopes by t of what moves the crease onto them, where cells are not uniform: with them m - t m' is 0 at both ends.
    leans: [DVec3; 2],
    /// Speed across the crease at both ends, times the crease's scale there.
    speeds: [f64; 2],
    /// Columns turn: `turned` is set once the crease is known.
    turns: bool,
    turned: Option<Turned>,
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

/// Columns that leave the rim at one azimuth and meet the crease at another: E(s, v) = E_rim + B(v) (E_crease - E_rim),
/// B = v² (3 - 2 v), both quadratic in s and equal at both ends.
struct Turned {
    /// Bernstein coefficients of E_rim, in (e, n) of the sector's frame: a rational circle, |E_rim| a polynomial.
    rim: [DVec2; 3],
    /// Bernstein coefficients of |E_rim|.
    length: [f64; 3],
    ends: [TurnedEnd; 2],
}

/// What a turned map does along one of its radials. Slopes by s.
struct TurnedEnd {
    /// Slopes of the base profile's coefficients of 1, q, q², q³.
    base: [f64; 4],
    /// Radial part of E_s at the rim and at the crease, but for `aside`.
    out: [f64; 2],
    /// Azimuthal part of E_s: Bernstein coefficients.
    around: [f64; 4],
    /// As `End::shear`, times |E| dφ/ds.
    shear: [f64; 2],
    /// Slope of `SectorMap::aside`: its radial part.
    aside: f64,
}

impl TurnedEnd {
    /// Radial part of E_s at v, and its slope by v.
    fn out(&self, v: f64) -> [f64; 2] {
        let [rim, crease] = self.out;
        let q = 1.0 - v;
        [rim + smooth(v) * (crease - rim) + v * v * q * self.aside, 6.0 * v * q * (crease - rim) + v * (2.0 * q - v) * self.aside]
    }
}

/// The smooth step from 0 to 1.
fn smooth(v: f64) -> f64 {
    v * v * (3.0 - 2.0 * v)
}

impl<'a> SectorMap<'a> {
    pub fn new(layout: &'a Layout, sector: usize) -> Self {
        let s = &layout.sectors[sector];
        let crease = &layout.creases[s.crease];
        let radials = s.radials.map(|r| &layout.radials[r]);
        let top = crease.frame.height[s.which];
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
            (1.0 + t * t) * crease.stretch[end] * layout.corners[crease.corners[end]].k - raw_crease(crease, t)[0]
        });
        let f = &crease.frame;
        let frame = [f.c[s.which], crease.sign * f.e[s.which], crease.sign * f.n[s.which]];
        let speeds = [0, 1].map(|end| radials[end].speed * layout.crease_scale(s, end));
        // m_e / t_e; a miss of round-off has no direction
        let leans = [0, 1].map(|end| if misses[end].length() < ROUND_OFF { DVec3::ZERO } else { misses[end] / crease.t[end] });
        let mut map =
            SectorMap { crease, which: s.which, ends, cut: radials[0].cut, rim: s.t, frame, misses, leans, speeds, turns: layout.turned, turned: None };
        if layout.turned {
            map.turned = Some(map.turn([0, 1].map(|end| layout.crease_scale(s, end))));
        }
        map
    }

    /// Set up columns that change their azimuth; `scales` is the distance of the crease from the axis over w2, at both ends.
    fn turn(&self, scales: [f64; 2]) -> Turned {
        let [start, end] = [0.0, 1.0].map(|s| self.around_crease(s));
        let [a, b] = [start[0].length(), end[0].length()];
        let units = [start[0] / a, end[0] / b];
        let middle = units[0] + units[1];
        let half = 0.5 * middle.length(); // cosine of half the rim arc
        let rim = [start[0], (a * b).sqrt() * middle.normalize(), end[0]];
        let length = [a, (a * b).sqrt() * half, b];
        let dt = self.dt();
        let between = |get: fn(&Radial) -> f64| [0, 1].map(|k| get(self.ends[k].radial) * scales[k]);
        let (speeds, bends) = (self.speeds, between(|r| r.bend));
        let ends = [0, 1].map(|k| {
            let radial = self.ends[k].radial;
            let (t, crease) = (self.crease_t(k as f64), [&start, &end][k]);
            let (w2, w2_by_s) = (1.0 + t * t, 2.0 * t * dt);
            let turn = |slope: DVec2| [units[k].dot(slope), self.sense() * units[k].perp_dot(slope)];
            let rim_slope = if k == 0 { 2.0 * (rim[1] - rim[0]) } else { 2.0 * (rim[2] - rim[1]) };
            let length_slope = if k == 0 { 2.0 * (length[1] - length[0]) } else { 2.0 * (length[2] - length[1]) };
            let ([out_rim, around_rim], [out, around]) = (turn(rim_slope), turn(crease[1]));
            let h = self.crease(k as f64)[1].dot(self.frame[0]) * dt;
            let by_s = |x: [f64; 2]| w2_by_s * x[k] + w2 * (x[1] - x[0]);
            let (l, bend) = (by_s(speeds), by_s(bends));
            let aside = self.aside_slope(k);
            let up = aside.dot(self.frame[0]);
            let [aside_out, aside_around] = turn(DVec2::new(aside.dot(self.frame[1]), aside.dot(self.frame[2])));
            let base = [h, l + up, 0.5 * bend - 2.0 * up, length_slope * self.cut - h - l - 0.5 * bend + up];
            let c = (out * radial.h - h) / radial.speed;
            let c_by_v = (l + up - aside_out * radial.h - out * radial.speed + c * radial.bend) / radial.speed;
            // v² (1 - v) is a third of the third Bernstein polynomial of degree 3
            let around = [around_rim, around_rim, around + aside_around / 3.0, around];
            TurnedEnd { base, out: [out_rim, out], around, shear: [c, c - c_by_v], aside: aside_out }
        });
        Turned { rim, length, ends }
    }

    /// +1 where azimuths grow counter-clockwise about the strut.
    fn sense(&self) -> f64 {
        if self.which == 0 { 1.0 } else { -1.0 }
    }

    /// t at s in [0, 1], which runs along the crease.
    pub fn t(&self, s: f64) -> f64 {
        let [a, b] = self.rim;
        (1.0 - s) * a + s * b
    }

    /// The radial at its start; all of a sector have its strut's radius and taper.
    pub fn start(&self) -> &Radial {
        self.ends[0].radial
    }

    /// Height component of Y.
    pub fn height_at(&self, s: f64, v: f64) -> f64 {
        self.profile(s, v).0
    }

    /// |E| at both ends, along the whole radial there: what multiplies the radial's own gauge.
    pub fn scale_of_ends(&self) -> [f64; 2] {
        match &self.turned {
            None => self.crease.t.map(|t| 1.0 + t * t),
            Some(turned) => [turned.length[0], turned.length[2]],
        }
    }

    /// |E| along the rim.
    pub fn rim_length(&self, s: f64) -> f64 {
        match &self.turned {
            None => 1.0 + self.t(s).powi(2),
            Some(turned) => quadratic(turned.length, s)[0],
        }
    }

    /// What `rim_length` must be multiplied by at both ends to give `scale_of_ends`: 1 unless corners were joined.
    pub fn rim_ratio(&self) -> [f64; 2] {
        match &self.turned {
            None => [0, 1].map(|end| self.scale_of_ends()[end] / (1.0 + self.t(end as f64).powi(2))),
            Some(_) => [1.0; 2],
        }
    }

    /// The crease's own parameter.
    pub fn crease_t(&self, s: f64) -> f64 {
        let [a, b] = self.crease.t;
        (1.0 - s) * a + s * b
    }

    /// dt/ds.
    pub fn dt(&self) -> f64 {
        self.crease.t[1] - self.crease.t[0]
    }

    /// The speed l(t) across the crease, linear between the corners: Y_v = -w2 l c there.
    pub fn speed(&self, s: f64) -> f64 {
        (1.0 - s) * self.speeds[0] + s * self.speeds[1]
    }

    /// Height of the crease, times w2.
    fn height(&self, t: f64) -> f64 {
        self.crease.sign * (1.0 - t * t) * self.crease.frame.height[self.which]
    }

    /// Room between crease and rim at s, over w2.
    pub fn room(&self, s: f64) -> f64 {
        (self.rim_length(s) * self.cut - self.crease(s)[0].dot(self.frame[0])) / (1.0 + self.crease_t(s).powi(2))
    }

    /// ∂w/∂s along a radial (end 0 or 1) as b W + c W_v + d χ: the gauge along the radial, its slope, and its slope by azimuth at
    /// constant height, counter-clockwise, all per unit of distance from the axis. Bernstein coefficients of b, c and d: of degrees
    /// 1, 2 and 0; where columns turn 3, 4 and 3.
    pub fn across_radial(&self, end: usize) -> [Vec<f64>; 3] {
        // a v + b v (1 - v)
        let shear = |[a, b]: [f64; 2]| [0.0, 0.5 * (a + b), a];
        match &self.turned {
            None => {
                let f = 2.0 * self.dt();
                let b = f * self.t(end as f64);
                [vec![b; 2], shear(self.ends[end].shear).map(|c| f * c).to_vec(), vec![f * self.sense()]]
            }
            Some(turned) => {
                let e = &turned.ends[end];
                let [rim, crease] = e.out;
                let [c0, c1, c2] = shear(e.shear);
                let out = vec![rim, rim, crease + e.aside / 3.0, crease];
                [out, vec![c0, 0.5 * (c0 + c1), (c0 + 4.0 * c1 + c2) / 6.0, 0.5 * (c1 + c2), c2], e.around.to_vec()]
            }
        }
    }

    /// Height component of Y, and its derivative by q = 1 - v.
    fn profile(&self, s: f64, v: f64) -> (f64, f64) {
        if let Some(turned) = &self.turned {
            return self.column(turned, s).height(&self.misses_of_heights(turned, v), v);
        }
        self.straight_column(s).height(2.0 * self.dt(), &self.misses_of_slopes(v), v)
    }

    /// What a map whose columns keep their azimuth is made of at s.
    fn straight_column(&self, s: f64) -> StraightColumn {
        let t = self.t(s);
        let w2 = 1.0 + t * t;
        let (h, l) = (self.height(t), w2 * self.speed(s));
        let bend = w2 * ((1.0 - s) * self.ends[0].radial.bend + s * self.ends[1].radial.bend);
        StraightColumn { base: [h, l, bend, w2 * self.cut - h - l - 0.5 * bend], hermite: hermite(s) }
    }

    /// What the base profile misses of the prescribed ∂η/∂φ, and of its slope by q, at both ends.
    fn misses_of_slopes(&self, v: f64) -> [[f64; 2]; 2] {
        let q = 1.0 - v;
        [0, 1].map(|end| {
            let &End { radial, slopes: [h, l], bend, shear: [a, b] } = &self.ends[end];
            let rest = -h - l - 0.5 * bend;
            let (shear, shear_by_q) = (a * v + b * v * q, -a + b * (v - q));
            let [_, fall, fall_by_q] = radial.height(q).map(|x| -x);
            let miss = shear * fall - (h + l * q + 0.5 * bend * q * q + rest * q.powi(3));
            let miss_by_q = shear_by_q * fall + shear * fall_by_q - (l + bend * q + 3.0 * rest * q * q);
            [miss, miss_by_q]
        })
    }

    /// What a turned map is made of at s.
    fn column(&self, turned: &Turned, s: f64) -> Column {
        let [c, out, around] = self.frame;
        let flat = |x: DVec3| DVec2::new(x.dot(out), x.dot(around));
        let t = self.crease_t(s);
        let w2 = 1.0 + t * t;
        let (crease, aside) = (self.crease(s)[0], self.aside(s));
        let (h, l) = (crease.dot(c), w2 * self.speed(s));
        let bends = [0, 1].map(|k| self.ends[k].radial.bend / self.ends[k].radial.speed * self.speeds[k]);
        let half_bend = 0.5 * w2 * ((1.0 - s) * bends[0] + s * bends[1]);
        let rest = quadratic(turned.length, s)[0] * self.cut - h - l - half_bend;
        let rim = quadratic(turned.rim, s)[0];
        Column { base: [h, l, half_bend, rest], up: aside.dot(c), hermite: hermite(s), rim, way: flat(crease) - rim, aside: flat(aside) }
    }

    /// What the base profile misses, by s, of the height that the radials want, and its slope by q, at both ends.
    fn misses_of_heights(&self, turned: &Turned, v: f64) -> [[f64; 2]; 2] {
        let q = 1.0 - v;
        [0, 1].map(|end| {
            let [height, fall, fall_by_q] = self.ends[end].radial.height(q);
            let turned = &turned.ends[end];
            let ([out, out_by_v], [a, b], base) = (turned.out(v), turned.shear, turned.base);
            let (shear, shear_by_q) = (a * v + b * v * q, -a + b * (v - q));
            let wanted = out * height - shear * fall;
            let wanted_by_q = -out_by_v * height + out * fall - shear_by_q * fall - shear * fall_by_q;
            let [value, by_q] = cubic(base, q);
            [wanted - value, wanted_by_q - by_q]
        })
    }

    /// The crease ŷ(t) = Y(t, 1), and its first two derivatives by t. Ends are moved onto the corners where corners were joined.
    pub fn crease(&self, s: f64) -> [DVec3; 3] {
        let raw = raw_crease(self.crease, self.crease_t(s));
        let moved = self.moved(s);
        [0, 1, 2].map(|k| raw[k] + moved[k])
    }

    /// What moves the crease, m(t), and its first two derivatives by t: linear where cells are uniform, else cubic.
    fn moved(&self, s: f64) -> [DVec3; 3] {
        let [a, b] = self.misses;
        let dt = self.dt();
        if !self.turns {
            return [(1.0 - s) * a + s * b, (b - a) / dt, DVec3::ZERO];
        }
        let [c, d] = self.leans.map(|lean| lean * dt);
        let (square, cube) = (3.0 * (b - a) - 2.0 * c - d, 2.0 * (a - b) + c + d);
        [a + s * (c + s * (square + s * cube)), (c + s * (2.0 * square + 3.0 * s * cube)) / dt, (2.0 * square + 6.0 * s * cube) / (dt * dt)]
    }

    /// What is added to -Y_v at the crease besides w2 l c where the crease was moved, l z with z = ½ λ σ sin θ (m - t m'): then
    /// Y_v of both sides together lies in the plane of ŷ and ŷ_t again, as if the crease lay on the bisector plane.
    fn aside(&self, s: f64) -> DVec3 {
        let [m, m_by_t, _] = self.moved(s);
        self.aside_scale() * self.speed(s) * (m - self.crease_t(s) * m_by_t)
    }

    /// Its slope by s at an end, where it is 0.
    fn aside_slope(&self, end: usize) -> DVec3 {
        let [.., m_by_tt] = self.moved(end as f64);
        -self.aside_scale() * self.speeds[end] * self.dt() * self.crease.t[end] * m_by_tt
    }

    fn aside_scale(&self) -> f64 {
        let f = &self.crease.frame;
        0.5 * f.wide[self.which] * self.crease.sign * f.theta.sin()
    }

    /// E of the crease in (e, n), and its slope by s.
    fn around_crease(&self, s: f64) -> [DVec2; 2] {
        let [y, y_by_t, _] = self.crease(s);
        let [_, e, n] = self.frame;
        [y, y_by_t * self.dt()].map(|y| DVec2::new(y.dot(e), y.dot(n)))
    }

    /// The direction at (s, v): a polynomial of degree 3 in s and 4 in v; where columns turn 4 in s and 6 in v.
    pub fn y(&self, s: f64, v: f64) -> DVec3 {
        self.ys(&[s], &[v])[0]
    }

    /// The same at all pairs, `[is * vs.len() + iv]`.
    pub fn ys(&self, ss: &[f64], vs: &[f64]) -> Vec<DVec3> {
        let [c, e, n] = self.frame;
        let mut out = Vec::with_capacity(ss.len() * vs.len());
        if let Some(turned) = &self.turned {
            let misses: Vec<_> = vs.iter().map(|&v| self.misses_of_heights(turned, v)).collect();
            for &s in ss {
                let column = self.column(turned, s);
                out.extend(vs.iter().zip(&misses).map(|(&v, misses)| {
                    let around = column.around(v);
                    column.height(misses, v).0 * c + around.x * e + around.y * n
                }));
            }
            return out;
        }
        let (misses, last): (Vec<_>, _) = (vs.iter().map(|&v| self.misses_of_slopes(v)).collect(), self.misses_of_slopes(1.0));
        for &s in ss {
            let (t, column, crease) = (self.t(s), self.straight_column(s), self.crease(s)[0]);
            let natural = |v: f64, misses: &[[f64; 2]; 2]| column.height(2.0 * self.dt(), misses, v).0 * c + (1.0 - t * t) * e + 2.0 * t * n;
            let end = natural(1.0, &last);
            out.extend(vs.iter().zip(&misses).map(|(&v, misses)| natural(v, misses) + smooth(v) * (crease - end)));
        }
        out
    }

    /// Width (radians), mean height from crease to rim, and mean w2.
    pub fn extent(&self) -> (f64, f64, f64) {
        let height = self.cut - 0.5 * (self.ends[0].radial.h + self.ends[1].radial.h);
        if let Some(turned) = &self.turned {
            let [a, b, c] = turned.length;
            return (turned.rim[0].angle_to(turned.rim[2]).abs(), height, (a + b + c) / 3.0);
        }
        let [a, b] = self.crease.phi;
        let [t0, t1] = self.crease.t;
        (b - a, height, 1.0 + (t0 * t0 + t0 * t1 + t1 * t1) / 3.0)
    }

    /// Whether the map descends from the rim to the crease everywhere: then it does not fold.
    pub fn is_regular(&self) -> bool {
        const STEPS: usize = 12;
        let part = |k: usize| k as f64 / STEPS as f64;
        match &self.turned {
            None => {
                let misses: Vec<_> = (0..=STEPS).map(|k| self.misses_of_slopes(part(k))).collect();
                (0..=STEPS).map(part).all(|s| {
                    let column = self.straight_column(s);
                    let height = |k: usize| column.height(2.0 * self.dt(), &misses[k], part(k));
                    let (top, bottom) = (height(0).0, height(STEPS).0);
                    (0..=STEPS).all(|k| height(k).1 > LEAST_DESCENT * (top - bottom))
                })
            }
            Some(turned) => {
                let misses: Vec<_> = (0..=STEPS).map(|k| self.misses_of_heights(turned, part(k))).collect();
                (0..=STEPS).map(part).all(|s| {
                    let columns = [s - Column::STEP, s, s + Column::STEP].map(|s| self.column(turned, s));
                    let (top, bottom) = (columns[1].height(&misses[0], 0.0).0, columns[1].height(&misses[STEPS], 1.0).0);
                    (0..=STEPS).all(|k| {
                        let [area, plain] = Column::area(&columns, &misses[k], part(k));
                        plain > 0.0 && area > LEAST_DESCENT * (top - bottom).max(0.0) * plain
                    })
                })
            }
        }
    }
}

/// A map whose columns keep their azimuth at one s: the base profile in q = 1 - v (its coefficients, but twice that of q²), and what corrects it at both ends.
struct StraightColumn {
    base: [f64; 4],
    hermite: [f64; 2],
}

impl StraightColumn {
    /// Height component of Y, and its derivative by q; `scale` is dφ/ds times w2.
    fn height(&self, scale: f64, misses: &[[f64; 2]; 2], v: f64) -> (f64, f64) {
        let q = 1.0 - v;
        let [h, l, bend, rest] = self.base;
        let mut value = h + l * q + 0.5 * bend * q * q + rest * q.powi(3);
        let mut by_q = l + bend * q + 3.0 * rest * q * q;
        for (hermite, [miss, miss_by_q]) in self.hermite.into_iter().zip(misses) {
            value += scale * hermite * miss;
            by_q += scale * hermite * miss_by_q;
        }
        (value, by_q)
    }
}

/// A turned map at one s: E = rim + B way + v² (1 - v) aside, and what its height is made of.
struct Column {
    /// Coefficients of the base profile in q = 1 - v, and what is added to it as v² q.
    base: [f64; 4],
    up: f64,
    hermite: [f64; 2],
    rim: DVec2,
    way: DVec2,
    aside: DVec2,
}

impl Column {
    /// For slopes by s from differences: only an inequality depends on them.
    const STEP: f64 = 1e-5;

    /// Height component of Y, and its derivative by q.
    fn height(&self, misses: &[[f64; 2]; 2], v: f64) -> (f64, f64) {
        let q = 1.0 - v;
        let [value, by_q] = cubic(self.base, q);
        let add = |k: usize| self.hermite[0] * misses[0][k] + self.hermite[1] * misses[1][k];
        (value + self.up * v * v * q + add(0), by_q + self.up * v * (v - 2.0 * q) + add(1))
    }

    /// E.
    fn around(&self, v: f64) -> DVec2 {
        self.rim + smooth(v) * self.way + v * v * (1.0 - v) * self.aside
    }

    /// det(Y, Y_v, Y_s), and det(E, E_s), what it is per unit of descent where columns keep their azimuth; of the middle of three columns.
    fn area(columns: &[Column; 3], misses: &[[f64; 2]; 2], v: f64) -> [f64; 2] {
        let [before, here, after] = columns;
        let e = here.around(v);
        let e_by_v = 6.0 * v * (1.0 - v) * here.way + v * (2.0 - 3.0 * v) * here.aside;
        let e_by_s = (after.around(v) - before.around(v)) / (2.0 * Column::STEP);
        let (h, h_by_q) = here.height(misses, v);
        let h_by_s = (after.height(misses, v).0 - before.height(misses, v).0) / (2.0 * Column::STEP);
        let plain = e.perp_dot(e_by_s);
        [h * e_by_v.perp_dot(e_by_s) + h_by_q * plain + h_by_s * e.perp_dot(e_by_v), plain]
    }
}

/// The Hermite polynomials of slope 1 at one end.
fn hermite(s: f64) -> [f64; 2] {
    [s * (1.0 - s).powi(2), -(1.0 - s) * s * s]
}

/// Value and slope of a cubic by its coefficients.
fn cubic([a, b, c, d]: [f64; 4], x: f64) -> [f64; 2] {
    [a + x * (b + x * (c + x * d)), b + x * (2.0 * c + x * 3.0 * d)]
}

/// Value and slope of a quadratic in Bernstein form.
fn quadratic<T>([a, b, c]: [T; 3], s: f64) -> [T; 2]
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T> + std::ops::Sub<Output = T>,
{
    let q = 1.0 - s;
    [a * (q * q) + b * (2.0 * q * s) + c * (s * s), (b - a) * (2.0 * q) + (c - b) * (2.0 * s)]
}

/// The natural crease and its first two derivatives by t.
fn raw_crease(crease: &Crease, t: f64) -> [DVec3; 3] {
    let f = &crease.frame;
    let m = crease.sign * f.wide[0] * (f.height[0] * f.c[0] + f.e[0]);
    let n = crease.sign * 2.0 * f.n[0];
    [(1.0 - t * t) * m + t * n, -2.0 * t * m + n, -2.0 * m]
}

/// The direction along a radial (height η0 and unit distance from the axis, but for joined corners), at v.
pub fn radial(radial: &Radial, corner: DVec3, v: f64) -> DVec3 {
    let q = 1.0 - v;
    let [height, ..] = radial.height(q);
    let blend = smooth(v);
    height * radial.c + radial.e + blend * (corner / radial.scale - radial.h * radial.c - radial.e)
}
