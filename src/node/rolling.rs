//! The original shape with its valleys filled by a rolling ball: the closing of the union of struts and node sphere by balls of one
//! radius b. A point belongs to it if no ball of that radius that stays outside of the union reaches it, so no valley is tighter than b.
//!
//! With d the distance to the union and c the nearest centre to a point p where d(c) >= b, p is outside where |c - p| < b. The centre is found in
//! steps: each part's distance is taken as linear at the last one, and p is projected on what these half-spaces leave; with each step p moves along its
//! ray to where the ball about that centre meets it. Between two struts at an angle theta the filling begins at the height (1 + b) cot(theta/2) for
//! radius 1: cuts with lambda >= b leave it room.

use crate::node::star::Star;
use glam::DVec3;

/// Most steps to a centre; near it each squares what is off.
const STEPS: usize = 20;

/// Lengths are good to this, node radii.
const ENOUGH: f64 = 1e-10;

/// Where valleys are looked for no further, node radii.
const FARTHEST: f64 = 100.0;

/// Rolls one ball over one star; keeps its lists between rays.
pub struct Rolling<'a> {
    star: &'a Star,
    ball: f64,
    /// The struts that a ball at the ray at hand can touch.
    near: Vec<usize>,
    /// Whether it can touch the node sphere.
    sphere: bool,
    walls: Vec<Wall>,
}

/// What a part of the union leaves: x with n . x >= h.
#[derive(Clone, Copy)]
struct Wall {
    n: DVec3,
    h: f64,
}

impl<'a> Rolling<'a> {
    /// A ball of radius `ball`, node radii.
    pub fn new(star: &'a Star, ball: f64) -> Rolling<'a> {
        Rolling { star, ball, near: Vec::with_capacity(star.degree()), sphere: false, walls: Vec::with_capacity(star.degree() + 1) }
    }

    /// Distance along unit `u` from the node to the surface.
    pub fn distance(&mut self, u: DVec3) -> f64 {
        let original = self.star.original(u);
        if self.ball <= 0.0 {
            return original;
        }
        self.gather(original * u);
        if self.near.len() + usize::from(self.sphere) < 2 || self.rests(original * u) {
            return original;
        }
        self.together(u, original).unwrap_or_else(|| self.bracketed(u, original))
    }

    /// The parts that a ball can touch that reaches p or a point beyond it on its ray: those nearer than its diameter. They get no nearer beyond.
    fn gather(&mut self, p: DVec3) {
        let (star, reach) = (self.star, 2.0 * self.ball + 1e-6);
        self.near.clear();
        self.near.extend((0..star.degree()).filter(|&i| {
            let (ahead, taper) = (p.dot(star.axes[i]), star.tapers[i]);
            let far = star.radii[i] + taper * ahead + reach * (1.0 + taper * taper).sqrt();
            ahead > -reach && p.length_squared() - ahead * ahead < far * far
        }));
        self.sphere = p.length() - 1.0 < reach;
    }

    /// Signed distance from p to strut i, with its gradient, if p is ahead of it.
    fn strut(&self, i: usize, p: DVec3) -> Option<(f64, DVec3)> {
        let (c, taper) = (self.star.axes[i], self.star.tapers[i]);
        let ahead = p.dot(c);
        let out = p - ahead * c;
        let far = out.length();
        let slant = if taper == 0.0 { 1.0 } else { (1.0 + taper * taper).sqrt() };
        (ahead > 0.0 && far > 0.0).then(|| ((far - self.star.radii[i] - taper * ahead) / slant, (out / far - taper * c) / slant))
    }

    /// Signed distances from p to the near parts that it is ahead of, with their gradients.
    fn parts(&self, p: DVec3) -> impl Iterator<Item = (f64, DVec3)> {
        let sphere = self.sphere.then(|| (p.length() - 1.0, p.normalize_or_zero()));
        self.near.iter().filter_map(move |&i| self.strut(i, p)).chain(sphere)
    }

    /// Whether a ball rests on p, a point of the original shape, and on nothing else.
    fn rests(&self, p: DVec3) -> bool {
        let Some((_, n)) = self.parts(p).min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return true;
        };
        self.parts(p + self.ball * n).all(|part| part.0 > self.ball - ENOUGH)
    }

    /// One step to the centre nearest to p of a ball that stays outside: from p to where the parts, linear at the last centre, leave it.
    fn step(&mut self, p: DVec3, center: DVec3) -> DVec3 {
        let mut walls = std::mem::take(&mut self.walls);
        walls.clear();
        walls.extend(self.parts(center).map(|(d, n)| Wall { n, h: self.ball - d + n.dot(center - p) }));
        let x = shortest(&walls);
        self.walls = walls;
        x
    }

    /// Centre and point at once: each step takes the point to where its ray meets the ball. None where that does not settle.
    fn together(&mut self, u: DVec3, original: f64) -> Option<f64> {
        let (mut t, mut center) = (original, original * u);
        for _ in 0..STEPS {
            let x = self.step(t * u, center);
            let (next, off) = (t * u + x, x.length() - self.ball);
            let moved = next.distance_squared(center);
            center = next;
            let along = center.dot(u);
            let square = self.ball * self.ball - (center - along * u).length_squared();
            // where the ball about this centre misses the ray, towards the centre
            let to = if square > 0.0 { along - square.sqrt() } else { t + off * x.length() / x.dot(u) };
            // beyond the centre, or into the original shape: not the zero that is looked for
            if !(to > original - ENOUGH && to < along.max(t) + self.ball) {
                return None;
            }
            let done = moved < ENOUGH * ENOUGH && (to - t).abs() < ENOUGH;
            t = to;
            if done {
                return (square > 0.0).then_some(t.max(original));
            }
        }
        None
    }

    /// How deep the point at t is, as seen from the nearest centre: less than 0 inside.
    fn outside(&mut self, u: DVec3, t: f64) -> f64 {
        self.ball - self.center(t * u).distance(t * u)
    }

    /// The centre nearest to p of a ball that stays outside.
    fn center(&mut self, p: DVec3) -> DVec3 {
        let mut center = p;
        for _ in 0..STEPS {
            let next = p + self.step(p, center);
            let moved = next.distance(center);
            center = next;
            if moved < ENOUGH {
                break;
            }
        }
        center
    }

    /// By regula falsi, the Illinois way, each centre by itself.
    fn bracketed(&mut self, u: DVec3, original: f64) -> f64 {
        let mut low = (original, self.outside(u, original));
        if low.1 > -ENOUGH {
            return original;
        }
        let mut step = self.ball;
        let mut high = low;
        while high.1 < 0.0 && high.0 < FARTHEST {
            low = high;
            high = (high.0 + step, self.outside(u, high.0 + step));
            step *= 1.5;
        }
        let mut last = 0.0;
        while high.0 - low.0 > ENOUGH {
            let share = low.1 / (low.1 - high.1);
            let t = low.0 + (high.0 - low.0) * share.clamp(0.02, 0.98);
            let f = self.outside(u, t);
            let same = f.signum() == last;
            last = f.signum();
            if f < 0.0 {
                low = (t, f);
                high.1 *= if same { 0.5 } else { 1.0 };
            } else {
                high = (t, f);
                low.1 *= if same { 0.5 } else { 1.0 };
            }
        }
        0.5 * (low.0 + high.0)
    }
}

/// The largest ball whose fillings end before a strut's first ring of vertices behind the rim, a quarter of the way to the nearest valley; at least 0.
/// Of struts less than 90° apart, and of a thin strut on the node sphere.
pub fn most(star: &Star) -> f64 {
    let room = |i: usize, valley: f64| 0.75 * (star.cuts[i] - valley);
    let mut most = f64::INFINITY;
    for (i, &a) in star.axes.iter().enumerate() {
        let r = star.radii[i];
        if r < 1.0 {
            // the ball beside the strut on the sphere: (height of its centre)² = (1 + b)² - (r + b)²
            let reach = (1.0 - r * r).sqrt();
            most = most.min(((reach + room(i, reach)).powi(2) - reach * reach) / (2.0 * (1.0 - r)));
        }
        for (j, &b) in star.axes.iter().enumerate().filter(|&(j, b)| j != i && a.dot(*b) > 0.0) {
            let (sine, cosine) = (a.cross(b).length(), a.dot(b));
            // where both would meet in a plane; with radii larger by the ball's that moves by cot(theta/2) times as much
            most = most.min(room(i, (star.radii[j] + r * cosine) / sine) * sine / (1.0 + cosine));
        }
    }
    most.max(0.0)
}

/// The shortest x behind all walls. Those that hold it, at most three, are found one by one: the most violated joins, those
/// that the shortest x does not need leave. |x| grows each time, so this ends.
fn shortest(walls: &[Wall]) -> DVec3 {
    let (mut x, mut holding, mut count) = (DVec3::ZERO, [Wall { n: DVec3::ZERO, h: 0.0 }; 4], 0);
    for _ in 0..walls.len() + 4 {
        let (mut worst, mut most) = (None, 0.1 * ENOUGH);
        for wall in walls {
            let short = wall.h - wall.n.dot(x);
            if short > most {
                (worst, most) = (Some(*wall), short);
            }
        }
        let Some(worst) = worst else {
            break;
        };
        holding[count] = worst;
        let Some((best, mask)) = held(&holding[..=count]) else {
            break;
        };
        x = best;
        let mut kept = 0;
        for k in 0..=count {
            if mask >> k & 1 == 1 {
                holding[kept] = holding[k];
                kept += 1;
            }
        }
        count = kept;
    }
    x
}

/// The shortest x for up to four walls, the last of which holds it; and which others do, as bits.
fn held(walls: &[Wall]) -> Option<(DVec3, usize)> {
    let last = walls.len() - 1;
    let c = walls[last];
    let serves = |x: DVec3| walls.iter().all(|w| w.n.dot(x) >= w.h - ENOUGH);
    // what serves and is pushed by all its walls is the shortest: there is but one
    let alone = c.h / c.n.length_squared() * c.n;
    if c.h > 0.0 && serves(alone) {
        return Some((alone, 1 << last));
    }
    for i in 0..last {
        if let Some(x) = between(walls[i], c).filter(|&x| serves(x)) {
            return Some((x, 1 << i | 1 << last));
        }
    }
    for i in 0..last {
        for j in 0..i {
            if let Some(x) = among(walls[i], walls[j], c).filter(|&x| serves(x)) {
                return Some((x, 1 << i | 1 << j | 1 << last));
            }
        }
    }
    None
}

/// The shortest x on two walls, if both push it.
fn between(a: Wall, b: Wall) -> Option<DVec3> {
    // n_i . Σ f_j n_j = h_i
    let (aa, ab, bb) = (a.n.length_squared(), a.n.dot(b.n), b.n.length_squared());
    let det = aa * bb - ab * ab;
    let (f, g) = ((a.h * bb - b.h * ab) / det, (b.h * aa - a.h * ab) / det);
    (f > 0.0 && g > 0.0).then(|| f * a.n + g * b.n)
}

/// The x on three walls, if all push it.
fn among(a: Wall, b: Wall, c: Wall) -> Option<DVec3> {
    let [bc, ca, ab] = [b.n.cross(c.n), c.n.cross(a.n), a.n.cross(b.n)];
    let x = (a.h * bc + b.h * ca + c.h * ab) / a.n.dot(bc);
    // x = Σ f_i n_i; f_i = x . (n_j x n_k) / det
    let det = a.n.dot(bc);
    [bc, ca, ab].into_iter().all(|n| x.dot(n) / det > 0.0).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(star: &Star, u: DVec3, ball: f64) -> f64 {
        Rolling::new(star, ball).distance(u)
    }

    /// Signed distances to the parts that p is ahead of.
    fn all(star: &Star) -> Rolling<'_> {
        Rolling { near: (0..star.degree()).collect(), sphere: true, ..Rolling::new(star, 0.0) }
    }

    fn union(star: &Star, p: DVec3) -> f64 {
        all(star).parts(p).map(|part| part.0).fold(f64::INFINITY, f64::min)
    }

    /// In the plane of two struts at an angle the valley is a corner: the ball's centre lies on the bisector at (1 + b)/sin(theta/2).
    #[test]
    fn a_valley_is_filled_to_the_ball() {
        for degrees in [30.0f64, 70.0, 90.0, 120.0] {
            let half = 0.5 * degrees.to_radians();
            let star = Star::uniform(vec![DVec3::new(half.cos(), half.sin(), 0.0), DVec3::new(half.cos(), -half.sin(), 0.0)], vec![10.0; 2]);
            for ball in [0.05, 0.2, 0.5] {
                let found = distance(&star, DVec3::X, ball);
                assert!((found - ((1.0 + ball) / half.sin() - ball)).abs() < 1e-9, "{degrees}° {ball}: {found}");
            }
            assert_eq!(distance(&star, DVec3::X, 0.0), star.original(DVec3::X));
        }
    }

    /// At lambda 0.3 the filling of the nearest pair begins at the first ring for a ball of 0.225.
    #[test]
    fn cuts_leave_room_for_three_quarters_of_lambda() {
        for degrees in [20.0f64, 60.0, 85.0] {
            let half = 0.5 * degrees.to_radians();
            let axes = vec![DVec3::new(half.cos(), half.sin(), 0.0), DVec3::new(half.cos(), -half.sin(), 0.0), DVec3::NEG_X];
            let cuts = vec![1.3 / half.tan(); 3];
            assert!((most(&Star::uniform(axes, cuts)) - 0.225).abs() < 1e-12);
        }
    }

    #[test]
    fn a_straight_strut_stays_as_it_is() {
        let star = Star::uniform(vec![DVec3::X, -DVec3::X], vec![2.0; 2]);
        for u in [DVec3::Y, DVec3::new(0.5, 1.0, 0.3), DVec3::new(-0.01, 0.4, -1.0)] {
            let u = u.normalize();
            assert!((distance(&star, u, 0.3) - star.original(u)).abs() < 1e-9);
        }
    }

    /// On the surface some ball that stays outside touches, and none reaches in; valleys grow with the ball. Struts of three radii, one tapered.
    #[test]
    fn balls_touch_and_do_not_reach_in() {
        let golden = |k: usize, n: usize| {
            let z = 1.0 - (2 * k + 1) as f64 / n as f64;
            let phi = 2.399963 * k as f64;
            DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z)
        };
        for count in [3, 6, 13] {
            let axes: Vec<DVec3> = (0..count).map(|k| golden(k, count)).collect();
            let mut star = Star::uniform(axes, vec![8.0; count]);
            star.radii[1] = 0.6;
            (star.radii[2], star.tapers[2]) = (0.8, -0.02);
            let mut filled = 0;
            for k in 0..200 {
                let u = golden(k, 200);
                let mut before = star.original(u);
                for ball in [0.1, 0.25] {
                    let t = distance(&star, u, ball);
                    assert!(t >= before - 1e-9, "{count} {k} {ball}: {t} {before}");
                    before = t;
                    let p = t * u;
                    let c = Rolling { ball, ..all(&star) }.center(p);
                    if t > star.original(u) + 1e-6 {
                        filled += 1;
                        assert!(
                            union(&star, c) > ball - 1e-8 && (c.distance(p) - ball).abs() < 1e-7,
                            "{count} {k} {ball}: {} {}",
                            union(&star, c),
                            c.distance(p)
                        );
                        for i in 0..60 {
                            let other = p + 0.995 * ball * golden(i, 60);
                            assert!(union(&star, other) < ball, "{count} {k} {ball}: a ball reaches in");
                        }
                    }
                }
            }
            assert!(filled > 20, "{filled}");
        }
    }
}
