//! Which corners of a node's cells become one. Not in the paper: where four cells and more nearly meet, short sides are left between them, and the sectors along
//! a short side would be slivers on which curvature grows without bound. A short side is contracted: its ends become one corner, at their mean direction.
//!
//! A joined corner is no longer on all planes between its cells; patches are exactly tangent there all the same, while sides stay long
//! for what their ends were moved, and lean little (`docs/method/patches.md`, section 9).

use crate::node::cells::{LEAST_SNAP, MOVED, Side};
use glam::DVec3;

/// A side is at least so many times as long as its ends were moved. With 2 and 3 one of 422 nodes of a tet lattice cannot be built so, and the others are alike.
const LEAST_SIDE: f64 = 4.0;

/// Largest lean (`Joining::lean`). Measured on 250 random nodes and 422 of a tet lattice: one leans by 33 and has a curvature jump of 1,023 / r in place of 20; of all
/// others none gets worse by leaning up to 3, and many keep a sliver where only 0.3 is allowed.
const MOST_LEAN: f64 = 1.0;

/// Fewest sides of a cell that contraction leaves.
const FEWEST_SIDES: usize = 3;

/// Join the ends of sides: unit directions `points`, two a side in the order of the sides' `corners`. First those nearer than `LEAST_SNAP`, then those of sides shorter than
/// `snap` (radians), the shortest first, where cells and the other sides allow it. Returns the joined directions and where each point went.
pub(super) fn join(snap: f64, points: &[DVec3], sides: &[Side], struts: usize) -> (Vec<DVec3>, Vec<usize>) {
    let mut joining = Joining::new(points, sides);
    for a in 0..points.len() {
        for b in 0..a {
            if points[a].distance_squared(points[b]) < LEAST_SNAP * LEAST_SNAP {
                joining.merge(a, b);
            }
        }
    }
    joining.lengthen();
    let before = joining.shape(struts);
    let mut kept = vec![false; sides.len()];
    loop {
        let open = (0..sides.len()).filter(|&k| !kept[k]).map(|k| (k, joining.length(&sides[k]))).filter(|(_, length)| *length > 0.0);
        let Some((shortest, _)) = open.filter(|(_, length)| *length < snap).min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        let mut tried = joining.clone();
        let [a, b] = sides[shortest].corners;
        tried.merge(a, b);
        tried.lengthen();
        if tried.shape(struts).may_follow(&before) && sides.iter().all(|s| tried.lean(s) <= MOST_LEAN) {
            joining = tried;
        } else {
            kept[shortest] = true;
        }
    }
    joining.done()
}

/// Points on their way to joined corners. A corner goes by the first of its points.
#[derive(Clone)]
struct Joining<'a> {
    points: &'a [DVec3],
    sides: &'a [Side],
    /// The corner of each point.
    place: Vec<usize>,
    /// Of each corner: its unit direction, and how far from it the farthest of its points is.
    means: Vec<DVec3>,
    moved: Vec<f64>,
}

/// What contraction must not spoil.
struct Shape {
    /// Corners less sides.
    balance: i64,
    /// Sides of each cell.
    sides: Vec<usize>,
}

impl Shape {
    /// Cells still cover the sphere once, and none has lost what it needs.
    fn may_follow(&self, before: &Shape) -> bool {
        self.balance == before.balance && self.sides.iter().zip(&before.sides).all(|(now, before)| *now >= FEWEST_SIDES.min(*before))
    }
}

impl<'a> Joining<'a> {
    fn new(points: &'a [DVec3], sides: &'a [Side]) -> Self {
        Joining { points, sides, place: (0..points.len()).collect(), means: points.to_vec(), moved: vec![0.0; points.len()] }
    }

    /// The corners at the ends of a side.
    fn ends(&self, side: &Side) -> [usize; 2] {
        side.corners.map(|k| self.place[k])
    }

    /// 0 where both ends are one corner.
    fn length(&self, side: &Side) -> f64 {
        let [a, b] = self.ends(side);
        self.means[a].distance(self.means[b])
    }

    /// Make the corners of two points one.
    fn merge(&mut self, a: usize, b: usize) {
        let (a, b) = (self.place[a], self.place[b]);
        if a == b {
            return;
        }
        let (to, from) = (a.min(b), a.max(b));
        self.place.iter_mut().filter(|place| **place == from).for_each(|place| *place = to);
        let mine = || self.points.iter().zip(&self.place).filter(|(_, place)| **place == to).map(|(point, _)| *point);
        let mean = mine().sum::<DVec3>().normalize_or_zero();
        let moved = mine().map(|point| point.distance(mean)).fold(0.0, f64::max);
        (self.means[to], self.moved[to]) = (mean, moved);
    }

    /// Contract all sides that are too short for what their ends were moved.
    fn lengthen(&mut self) {
        let short = |joining: &Self| {
            joining
                .sides
                .iter()
                .map(|side| joining.ends(side))
                .find(|&[a, b]| a != b && joining.means[a].distance(joining.means[b]) < LEAST_SIDE * (joining.moved[a] + joining.moved[b]))
        };
        while let Some([a, b]) = short(self) {
            self.merge(a, b);
        }
    }

    /// How far the natural crease of a side misses its corners, over the sine of its azimuth there: the slope of what moves the crease onto them grows like it.
    fn lean(&self, side: &Side) -> f64 {
        let ends = self.ends(side);
        if ends[0] == ends[1] {
            return 0.0;
        }
        let lean = |end: usize| {
            let corner = self.means[ends[end]];
            if self.moved[ends[end]] < MOVED {
                return 0.0;
            }
            let phi = side.parameter(end, corner);
            side.frame.crease(phi).reject_from_normalized(corner).length() / phi.sin().abs()
        };
        lean(0).max(lean(1))
    }

    fn shape(&self, struts: usize) -> Shape {
        let corners = self.place.iter().enumerate().filter(|(k, place)| *k == **place).count();
        let mut shape = Shape { balance: corners as i64, sides: vec![0; struts] };
        for side in self.sides {
            let [a, b] = self.ends(side);
            if a != b {
                shape.balance -= 1;
                side.arms.iter().for_each(|&arm| shape.sides[arm] += 1);
            }
        }
        shape
    }

    fn done(self) -> (Vec<DVec3>, Vec<usize>) {
        let slots: Vec<usize> = (0..self.points.len()).filter(|&k| self.place[k] == k).collect();
        let slot = |k: &usize| slots.binary_search(k).expect("a corner is its own place");
        (slots.iter().map(|&k| self.means[k]).collect(), self.place.iter().map(slot).collect())
    }
}
