//! The original shape with its valleys filled by a rolling ball: the closing of the union of struts and node sphere by balls of one
//! radius b. A point belongs to it if no ball of that radius that stays outside of the union reaches it, so no valley is tighter than b.
//!
//! With d the distance to the union and c the nearest centre to a point p where d(c) >= b, p is outside where |c - p| < b. The centre is found in
//! steps: each part's distance is taken as linear at the last one, and p is projected on what these half-spaces leave. Between two struts at an angle
//! theta the filling begins at the height (1 + b) cot(theta/2) for radius 1: cuts with lambda >= b leave it room.

use crate::node::star::Star;
use glam::{DMat3, DVec3};

/// Most steps to a centre; near it each squares what is off.
const STEPS: usize = 20;

/// Lengths are good to this, node radii.
const ENOUGH: f64 = 1e-10;

/// Where valleys are looked for no further, node radii.
const FARTHEST: f64 = 100.0;

/// Distance along unit `u` from the node to the surface, for a ball of radius `ball` (node radii).
pub fn distance(star: &Star, u: DVec3, ball: f64) -> f64 {
    let original = star.original(u);
    // how deep a point on the ray is, as seen from the nearest centre: less than 0 inside
    let outside = |t: f64| ball - center(star, t * u, ball).distance(t * u);
    let mut low = (original, outside(original));
    if ball <= 0.0 || low.1 > -ENOUGH {
        return original;
    }
    let mut step = ball;
    let mut high = low;
    while high.1 < 0.0 && high.0 < FARTHEST {
        low = high;
        high = (high.0 + step, outside(high.0 + step));
        step *= 1.5;
    }
    // regula falsi, the Illinois way
    let mut last = 0.0;
    while high.0 - low.0 > ENOUGH {
        let share = low.1 / (low.1 - high.1);
        let t = low.0 + (high.0 - low.0) * share.clamp(0.02, 0.98);
        let f = outside(t);
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

/// Signed distances to the parts that p is ahead of, with their gradients: struts, and the node sphere.
fn parts(star: &Star, p: DVec3) -> impl Iterator<Item = (f64, DVec3)> {
    let strut = move |i: usize| {
        let (c, taper) = (star.axes[i], star.tapers[i]);
        let ahead = p.dot(c);
        let out = p - ahead * c;
        let (far, slant) = (out.length(), (1.0 + taper * taper).sqrt());
        (ahead > 0.0 && far > 0.0).then(|| ((far - star.radii[i] - taper * ahead) / slant, (out / far - taper * c) / slant))
    };
    (0..star.degree()).filter_map(strut).chain(std::iter::once((p.length() - 1.0, p.normalize_or_zero())))
}

/// The centre nearest to p of a ball that stays outside.
fn center(star: &Star, p: DVec3, ball: f64) -> DVec3 {
    let mut center = p;
    let mut walls: Vec<(DVec3, f64)> = Vec::with_capacity(star.degree() + 1);
    for _ in 0..STEPS {
        walls.clear();
        walls.extend(parts(star, center).map(|(d, n)| (n, ball - d + n.dot(center - p))));
        let next = p + shortest(&walls);
        let moved = next.distance(center);
        center = next;
        if moved < ENOUGH {
            break;
        }
    }
    center
}

/// The shortest x with n . x >= h for all walls (n, h). The walls that hold it, at most three, are found one by one: the most violated joins, those
/// that the shortest x does not need leave. |x| grows each time, so this ends.
fn shortest(walls: &[(DVec3, f64)]) -> DVec3 {
    let (mut x, mut holding) = (DVec3::ZERO, Vec::with_capacity(4));
    for _ in 0..walls.len() + 4 {
        let short = |w: &(DVec3, f64)| w.1 - w.0.dot(x);
        let Some(worst) = walls.iter().max_by(|a, b| short(a).total_cmp(&short(b))).filter(|w| short(w) > 0.1 * ENOUGH) else {
            break;
        };
        holding.push(*worst);
        let Some((best, mask)) = held(&holding) else {
            break;
        };
        x = best;
        let mut k = 0;
        holding.retain(|_| {
            k += 1;
            mask >> (k - 1) & 1 == 1
        });
    }
    x
}

/// The shortest x for up to four walls, the last of which holds it; and which others do, as bits.
fn held(walls: &[(DVec3, f64)]) -> Option<(DVec3, usize)> {
    let last = 1usize << (walls.len() - 1);
    let of = |mask: usize| -> Option<DVec3> {
        let chosen: Vec<(DVec3, f64)> = walls.iter().enumerate().filter(|w| mask >> w.0 & 1 == 1).map(|w| *w.1).collect();
        // n_i . Σ f_j n_j = h_i
        let entry = |i: usize, j: usize| if i < chosen.len() && j < chosen.len() { chosen[i].0.dot(chosen[j].0) } else { f64::from(i == j) };
        let gram = DMat3::from_cols_array_2d(&[0, 1, 2].map(|j| [0, 1, 2].map(|i| entry(i, j))));
        let pulls = gram.inverse() * DVec3::from_array([0, 1, 2].map(|i| chosen.get(i).map_or(0.0, |w| w.1)));
        let x: DVec3 = chosen.iter().enumerate().map(|(k, w)| pulls[k] * w.0).sum();
        let pushes = (0..chosen.len()).all(|k| pulls[k] > 0.0);
        (pushes && walls.iter().all(|w| w.0.dot(x) >= w.1 - ENOUGH)).then_some(x)
    };
    (0..last)
        .map(|mask| mask | last)
        .filter(|mask| mask.count_ones() <= 3)
        .filter_map(|mask| Some((of(mask)?, mask)))
        .min_by(|a, b| a.0.length_squared().total_cmp(&b.0.length_squared()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn union(star: &Star, p: DVec3) -> f64 {
        parts(star, p).map(|part| part.0).fold(f64::INFINITY, f64::min)
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
                    let c = center(&star, p, ball);
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
