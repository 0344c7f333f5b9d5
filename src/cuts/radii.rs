//! Radii made smaller: a factor for each strut end, and the least change of them that makes a strut thin enough at one place.
//!
//! Seen from end a, the radius at part t of the length is f_a p_a + f_b p_b with p_a = (1 - t) r_a, p_b = t r_b. The factors nearest to
//! those of before (least sum of squares) with a given value of this go down in proportion to p: an end gives the more the nearer it is. So
//! a strut tapers back to its radius at the end that is far from the place, and shrinks evenly where the place is in its middle.

use crate::graph::{Graph, Strut};
use crate::ids::StrutId;

/// Least ratio of the factors at a strut's two ends. Reason: at a steeper taper nodes fail, and the whole strut has to be thin in the end.
const STEEPEST: f64 = 0.5;

/// Factors that differ by less than this share are made one. Reason: a cylinder of 1 % less volume is worth more than a cone that nobody sees.
const EVEN: f64 = 0.01;

/// The radius of a strut at part `t` of its length from end a is wanted `to` times as large as it is.
#[derive(Clone, Copy, Debug)]
pub struct Thinner {
    pub strut: StrutId,
    pub t: f64,
    pub to: f64,
}

/// A strut whose radii were made smaller.
#[derive(Clone, Copy, Debug)]
pub struct Shrunk {
    pub strut: StrutId,
    /// Radii at ends a and b, mm.
    pub before: [f64; 2],
    pub after: [f64; 2],
    /// Volume lost of the strut from node to node, mm³.
    pub volume: f64,
}

/// A graph and factors on its radii.
pub struct Radii<'a> {
    given: &'a Graph,
    /// At ends a and b, by strut; at most 1.
    pub factors: Vec<[f64; 2]>,
}

impl<'a> Radii<'a> {
    pub fn new(given: &'a Graph) -> Radii<'a> {
        Radii { given, factors: vec![[1.0; 2]; given.struts().len()] }
    }

    /// Radii of a strut with these factors, mm.
    pub fn of(&self, strut: usize, factors: [f64; 2]) -> [f64; 2] {
        let s = &self.given.struts()[strut];
        [s.ra * factors[0], s.rb * factors[1]]
    }

    fn strut(&self, strut: usize, factors: [f64; 2]) -> Strut {
        let [ra, rb] = self.of(strut, factors);
        Strut { ra, rb, ..self.given.struts()[strut] }
    }

    /// The graph with its radii as they are now.
    pub fn graph(&self) -> Graph {
        Graph::new(self.given.nodes().to_vec(), (0..self.factors.len()).map(|k| self.strut(k, self.factors[k])).collect())
    }

    /// Make struts thinner: all wishes are measured from the radii as they are, and each end takes the least.
    pub fn thin(&mut self, wishes: impl IntoIterator<Item = Thinner>) {
        let before = self.factors.clone();
        for wish in wishes {
            let k = wish.strut.index();
            let factors = self.thinned(k, before[k], wish.t, wish.to);
            self.factors[k] = [0, 1].map(|e| self.factors[k][e].min(factors[e]));
        }
    }

    /// The factors nearest to `factors` with which the radius at part `t` of the strut is `to` (below 1) times as large.
    pub fn thinned(&self, strut: usize, factors: [f64; 2], t: f64, to: f64) -> [f64; 2] {
        let [ra, rb] = self.of(strut, [1.0; 2]);
        let p = [(1.0 - t) * ra, t * rb];
        let radius = factors[0] * p[0] + factors[1] * p[1];
        let give = (1.0 - to) * radius / (p[0] * p[0] + p[1] * p[1]);
        let free = [0, 1].map(|e| factors[e] - give * p[e]);
        let (near, far) = if free[0] < free[1] { (0, 1) } else { (1, 0) };
        let mut out = free;
        if free[near] < STEEPEST * free[far] {
            out[far] = to * radius / (p[far] + STEEPEST * p[near]);
            out[near] = STEEPEST * out[far];
        }
        if out[near] > (1.0 - EVEN) * out[far] { [out[near]; 2] } else { out }
    }

    /// The smallest factor.
    pub fn least(&self, strut: StrutId) -> f64 {
        let [a, b] = self.factors[strut.index()];
        a.min(b)
    }

    /// What was made smaller.
    pub fn shrunk(&self) -> Vec<Shrunk> {
        let one = |k: usize| {
            let (old, new) = (self.strut(k, [1.0; 2]), self.strut(k, self.factors[k]));
            let strut = StrutId(k as u32);
            let length = self.given.length(strut);
            Shrunk { strut, before: [old.ra, old.rb], after: [new.ra, new.rb], volume: old.volume(length) - new.volume(length) }
        };
        (0..self.factors.len()).filter(|&k| self.factors[k] != [1.0; 2]).map(one).collect()
    }
}
