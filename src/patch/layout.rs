//! Sectors and their shared edges. Two sectors per cell side, one for each of its struts.
//!
//! A **radial** runs from a corner to the rim of one strut, at the corner's azimuth; a **crease** runs along a cell side
//! from corner to corner. A sector lies between one crease, the rim, and two radials. Sides whose sectors would be
//! badly parametrised are split by extra corners (see `map`).
//!
//! Node units; azimuths in radians about the strut, local to the side's frame (counter-clockwise about its first
//! strut, clockwise about its second).

use crate::node::cells::Frame;
use crate::node::{Cells, Star};
use crate::patch::map;
use glam::DVec3;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Splitting a side again and again means that no good map exists.
const MOST_SPLITS: usize = 6;

/// Scale of the film's detail across a crease, in node radii: columns descend by about this much per unit of v there.
const DETAIL: f64 = 1.2;

/// Largest bend of a radial in units of its speed: keeps the shear of `map` mild on long columns.
const MOST_BEND: f64 = 3.0;

/// Speed, in a fine layout, at which columns that end far behind their strut's end plane cross that plane: the node's back is
/// round over about one unit of height on either side of it. Measured on pairs of struts, radii 1 to 0.1, angles from 5°: 3 leaves
/// too little room to both ends, 8 passes over the rounding.
const END_SPEED: f64 = 5.0;

/// Narrowest part of a crease that a fine layout makes, radians.
const LEAST_PART: f64 = 0.02;

#[derive(Clone, Debug)]
pub struct Layout {
    pub corners: Vec<Corner>,
    pub radials: Vec<Radial>,
    pub creases: Vec<Crease>,
    /// Sectors `2 k` and `2 k + 1` lie along crease k, on its first and second strut.
    pub sectors: Vec<Sector>,
    /// Per arm: its sectors counter-clockwise about the axis.
    pub around: Vec<Vec<usize>>,
    /// Columns of the direction map turn: cells are not uniform, or corners were joined.
    pub turned: bool,
    /// Made by `Layout::fine`.
    pub fine: bool,
}

/// A point where cells meet, or an extra corner on a side.
#[derive(Clone, Debug)]
pub struct Corner {
    /// Its direction, at distance 1 from a strut around it; from all of them where cells are uniform.
    pub k: DVec3,
    /// Orthonormal basis of the plane perpendicular to `k`.
    pub tangent: [DVec3; 2],
}

#[derive(Clone, Debug)]
pub struct Radial {
    pub arm: usize,
    pub corner: usize,
    /// Unit axis of the arm, and unit vector perpendicular to it towards the corner.
    pub c: DVec3,
    pub e: DVec3,
    /// Height over distance from the axis, of the rim and of the corner.
    pub cut: f64,
    pub h: f64,
    /// Distance of the corner's `k` from the axis: 1 where columns do not turn.
    pub scale: f64,
    /// Radius of the strut at the node, and its growth per unit of length.
    pub radius: f64,
    pub taper: f64,
    /// Speed of the map across the crease at the corner, -dη/dv, and d²η/dv² there.
    pub speed: f64,
    pub bend: f64,
}

#[derive(Clone, Debug)]
pub struct Crease {
    pub arms: [usize; 2],
    pub corners: [usize; 2],
    pub frame: Frame,
    /// Azimuth at both ends.
    pub phi: [f64; 2],
    /// +1: t = tan(φ/2). -1: t = tan((φ ∓ π)/2), measured from the back.
    pub sign: f64,
    /// The parameter at both ends.
    pub t: [f64; 2],
    /// The crease's point at both ends over the corner's `k`: 1 where columns do not turn.
    pub stretch: [f64; 2],
}

#[derive(Clone, Debug)]
pub struct Sector {
    pub crease: usize,
    /// Which of the crease's struts: 0 or 1.
    pub which: usize,
    pub arm: usize,
    /// Radials at the start and at the end of the crease.
    pub radials: [usize; 2],
    /// The parameter at both ends of the rim arc: that of the crease, but where corners were joined.
    pub t: [f64; 2],
}

/// What a layout does for the part of the node behind its struts' end planes.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Detail {
    Usual,
    /// Creases are parted there.
    Parted,
    /// And columns cross the planes slowly.
    Slow,
}

/// A side, or a part of one: (side, start azimuth, end azimuth, start corner, end corner).
struct Piece {
    side: usize,
    phi: [f64; 2],
    corners: [usize; 2],
    depth: usize,
}

impl Radial {
    /// The strut's own gauge at a height over the distance from the axis, per unit of that distance.
    pub fn own(&self, height: f64) -> f64 {
        (1.0 - self.taper * height) / self.radius
    }

    /// Height along the radial at q = 1 - v, and its first two derivatives by q: it falls from the cut (q = 1) to the
    /// corner (q = 0), where slope and second derivative are `speed` and `bend`.
    pub fn height(&self, q: f64) -> [f64; 3] {
        let rest = self.cut - self.h - self.speed - 0.5 * self.bend;
        [self.h + self.speed * q + 0.5 * self.bend * q * q + rest * q.powi(3), self.speed + self.bend * q + 3.0 * rest * q * q, self.bend + 6.0 * rest * q]
    }
}

impl Layout {
    /// Lay out the sectors; splits sides until the direction map of every sector is regular.
    pub fn new(star: &Star, cells: &Cells) -> Result<Layout, String> {
        Layout::regular(star, cells, turns(cells), Detail::Usual)
    }

    /// A layout for struts that leave the node close together, or of very different radii. Behind the struts' end planes the
    /// gauge grows with the distance from these planes: creases are parted there, and columns cross the planes slowly if such a map is regular.
    pub fn fine(star: &Star, cells: &Cells) -> Result<Layout, String> {
        Layout::regular(star, cells, turns(cells), Detail::Slow).or_else(|_| Layout::regular(star, cells, turns(cells), Detail::Parted))
    }

    /// As `new`, with columns that keep their azimuth: off by as much as corners were moved.
    pub fn straight(star: &Star, cells: &Cells) -> Result<Layout, String> {
        Layout::regular(star, cells, false, Detail::Usual)
    }

    fn regular(star: &Star, cells: &Cells, turned: bool, detail: Detail) -> Result<Layout, String> {
        let mut corners = cells.corners.clone();
        let mut pieces = Vec::with_capacity(cells.sides.len());
        for (index, side) in cells.sides.iter().enumerate() {
            let parts = if detail > Detail::Usual { parts_behind(side) } else { side.phi.to_vec() };
            let mut start = side.corners[0];
            for w in parts.windows(2) {
                let end = if w[1] == side.phi[1] {
                    side.corners[1]
                } else {
                    corners.push(side.frame.crease(w[1]));
                    corners.len() - 1
                };
                pieces.push(Piece { side: index, phi: [w[0], w[1]], corners: [start, end], depth: 0 });
                start = end;
            }
        }
        let mut straight = BTreeSet::new();
        loop {
            let layout = Layout::of_pieces(star, cells, turned, &corners, &pieces, &straight, detail);
            let bad: Vec<usize> = (0..layout.sectors.len()).filter(|&k| !map::SectorMap::new(&layout, k).is_regular()).collect();
            if bad.is_empty() {
                return Ok(layout);
            }
            // first ask for less: even descent along the radials of the sector; only then for more corners
            let mut split = BTreeSet::new();
            let asked = straight.clone(); // neighbours share a radial: one must not split for what the other asks now
            for k in bad {
                let ends = layout.sectors[k].radials.map(|r| (layout.radials[r].arm, layout.radials[r].corner));
                if ends.iter().all(|e| asked.contains(e)) {
                    split.insert(k / 2);
                }
                straight.extend(ends);
            }
            for &k in split.iter().rev() {
                let piece = &pieces[k];
                let arms = cells.sides[piece.side].arms;
                if piece.depth == MOST_SPLITS {
                    return Err(format!("no regular patch layout between struts {} and {} of the node (local numbers)", arms[0], arms[1]));
                }
                let [a, b] = piece.phi;
                let margin = 0.2 * (b - a);
                let middle = if a + margin < 0.0 && 0.0 < b - margin { 0.0 } else { 0.5 * (a + b) };
                let corner = corners.len();
                corners.push(cells.sides[piece.side].frame.crease(middle));
                let (side, depth, ends) = (piece.side, piece.depth + 1, piece.corners);
                pieces[k] = Piece { side, depth, phi: [a, middle], corners: [ends[0], corner] };
                pieces.insert(k + 1, Piece { side, depth, phi: [middle, b], corners: [corner, ends[1]] });
            }
        }
    }

    fn of_pieces(star: &Star, cells: &Cells, turned: bool, corners: &[DVec3], pieces: &[Piece], straight: &BTreeSet<(usize, usize)>, detail: Detail) -> Layout {
        let creases: Vec<Crease> = pieces
            .iter()
            .map(|p| {
                let side = &cells.sides[p.side];
                let middle = 0.5 * (p.phi[0] + p.phi[1]);
                let sign = if at_back(middle) { -1.0 } else { 1.0 };
                let stretch = [0, 1].map(|end| {
                    let k = corners[p.corners[end]];
                    if turned { side.frame.crease(p.phi[end]).dot(k) / k.length_squared() } else { 1.0 }
                });
                let t = p.phi.map(|phi| parameter(phi, middle));
                Crease { arms: side.arms, corners: p.corners, frame: side.frame, phi: p.phi, sign, t, stretch }
            })
            .collect();
        let mut layout = Layout {
            corners: corners.iter().map(|&k| Corner { k, tangent: tangents(k) }).collect(),
            radials: Vec::new(),
            creases,
            sectors: Vec::with_capacity(2 * pieces.len()),
            around: vec![Vec::new(); star.degree()],
            turned,
            fine: detail > Detail::Usual,
        };
        let mut radial_of = std::collections::BTreeMap::new();
        for (k, crease) in layout.creases.iter().enumerate() {
            for which in 0..2 {
                let arm = crease.arms[which];
                let radials = crease.corners.map(|corner| {
                    *radial_of.entry((arm, corner)).or_insert_with(|| {
                        let c = star.axes[arm];
                        let k = layout.corners[corner].k;
                        let out = k - k.dot(c) * c;
                        let scale = if turned { out.length() } else { 1.0 };
                        let h = k.dot(c) / scale;
                        let cut = star.cuts[arm] / star.rim_radius(arm);
                        let (radius, taper) = (star.radii[arm], star.tapers[arm]);
                        layout.radials.push(Radial { arm, corner, c, e: out.normalize(), cut, h, scale, radius, taper, speed: cut - h, bend: 0.0 });
                        layout.radials.len() - 1
                    })
                });
                let t = [0, 1].map(|end| {
                    let azimuth = crease.frame.azimuth(which, layout.corners[crease.corners[end]].k);
                    let turn = 2.0 * PI * ((crease.phi[end] - azimuth) / (2.0 * PI)).round();
                    parameter(azimuth + turn, crease.middle())
                });
                layout.sectors.push(Sector { crease: k, which, arm, radials, t });
            }
        }
        layout.set_speeds(straight, detail);
        layout.order(cells, pieces);
        layout
    }

    /// The speed at each corner. As fast as an even descent would be, but slower where
    /// - the film's detail next to the crease is finer than that (`DETAIL`), but for the `straight` radials (arm, corner);
    /// - the crease between two corners would be crossed too fast for the room it has (`map::MOST_SPEED`).
    ///
    /// In a fine layout the detail at a corner behind a strut's end plane is that of a sphere about the node, and columns from
    /// far behind it are slow where they cross the plane.
    fn set_speeds(&mut self, straight: &BTreeSet<(usize, usize)>, detail: Detail) {
        const STEPS: usize = 8;
        let mut slope = vec![0.0f64; self.radials.len()];
        for sector in &self.sectors {
            let crease = &self.creases[sector.crease];
            for end in 0..2 {
                let radial = sector.radials[end];
                let behind = if detail > Detail::Usual { self.radials[radial].h.min(0.0) } else { 0.0 };
                let steep = crease.frame.height[sector.which] * crease.phi[end].sin();
                slope[radial] = slope[radial].max(steep.abs()).max(steep.hypot(behind));
            }
        }
        for (radial, slope) in self.radials.iter_mut().zip(slope) {
            if !straight.contains(&(radial.arm, radial.corner)) {
                radial.speed = radial.speed.min(DETAIL * (1.0 + slope * slope).sqrt());
            }
        }
        let mut factor = vec![1.0f64; self.radials.len()];
        for (index, sector) in self.sectors.iter().enumerate() {
            let crease = &self.creases[sector.crease];
            let map = self.turned.then(|| map::SectorMap::new(self, index));
            let ends = [0, 1].map(|end| self.radials[sector.radials[end]].speed * self.crease_scale(sector, end));
            for i in 1..STEPS {
                let s = i as f64 / STEPS as f64;
                let t = (1.0 - s) * crease.t[0] + s * crease.t[1];
                let room = match &map {
                    None => self.radials[sector.radials[0]].cut - crease.sign * (1.0 - t * t) / (1.0 + t * t) * crease.frame.height[0],
                    Some(map) => map.room(s),
                };
                let speed = (1.0 - s) * ends[0] + s * ends[1];
                sector.radials.iter().for_each(|&r| factor[r] = factor[r].min(map::MOST_SPEED * room / speed));
            }
        }
        for (radial, f) in self.radials.iter_mut().zip(factor) {
            radial.speed *= f;
            radial.bend = (2.0 * (radial.cut - radial.h - radial.speed)).min(MOST_BEND * radial.speed);
            if self.fine
                && let Some((speed, bend)) = through_end_plane(radial.cut, radial.h)
            {
                (radial.speed, radial.bend) = (speed, bend);
            }
        }
    }

    /// Distance of the crease's point from the axis of a sector's strut, over w2, at the start (0) or end (1) of the crease: 1 where
    /// columns do not turn.
    pub fn crease_scale(&self, sector: &Sector, end: usize) -> f64 {
        self.radials[sector.radials[end]].scale * self.creases[sector.crease].stretch[end]
    }

    /// Sectors counter-clockwise about each arm: as the cells order the sides, and the pieces within them.
    fn order(&mut self, cells: &Cells, pieces: &[Piece]) {
        for (arm, ring) in cells.around.iter().enumerate() {
            for &(side, which) in ring {
                let mut mine: Vec<usize> = (0..pieces.len()).filter(|&k| pieces[k].side == side).collect();
                if which == 1 {
                    mine.reverse();
                }
                self.around[arm].extend(mine.iter().map(|&k| 2 * k + which));
            }
        }
    }
}

/// Whether columns have to turn: about the two struts of a side the azimuths of its corners differ.
fn turns(cells: &Cells) -> bool {
    !cells.uniform || cells.moved
}

/// Azimuths that part a side where it lies 1, 3, 7, ... below its strut's end plane (heights over the distance from the axis), ends included.
fn parts_behind(side: &crate::node::cells::Side) -> Vec<f64> {
    let tallest = side.frame.height[0].abs().max(side.frame.height[1].abs());
    let levels = (1..=MOST_SPLITS).map(|k| f64::from(1u32 << k) - 1.0).take_while(|&level| level < tallest);
    let mut parts: Vec<f64> = levels.map(|level| (-level / tallest).acos()).flat_map(|phi| [-phi, phi]).collect();
    // azimuths of a side may pass half a turn
    parts.extend(parts.clone().into_iter().flat_map(|phi| [phi - 2.0 * PI, phi + 2.0 * PI]));
    let [a, b] = side.phi;
    parts.retain(|phi| a + LEAST_PART < *phi && *phi < b - LEAST_PART);
    parts.sort_by(f64::total_cmp);
    parts.dedup_by(|b, a| *b - *a < LEAST_PART);
    parts.insert(0, a);
    parts.push(b);
    parts
}

/// Speed and bend at a corner at height `h` far behind the end plane, of the column η(q) = m (q - a) + K (q - a)³ that falls from
/// the cut to the corner and has speed m = `END_SPEED` at height 0; none where that is no slower than what it must fall.
fn through_end_plane(cut: f64, h: f64) -> Option<(f64, f64)> {
    const M: f64 = END_SPEED;
    if h > -0.5 * M {
        return None;
    }
    let k = |a: f64| (-h - M * a) / a.powi(3);
    // the height that a leaves at the rim falls with a
    let (mut low, mut high) = (0.0, (-h / M).min(1.0));
    for _ in 0..60 {
        let a = 0.5 * (low + high);
        if M * (1.0 - a) + k(a) * (1.0 - a).powi(3) > cut { low = a } else { high = a }
    }
    let a = 0.5 * (low + high);
    let k = k(a);
    (k > 0.0).then_some((M + 3.0 * k * a * a, -6.0 * k * a))
}

impl Crease {
    fn middle(&self) -> f64 {
        0.5 * (self.phi[0] + self.phi[1])
    }
}

/// Whether a crease with this middle azimuth is parametrised from the back.
fn at_back(middle: f64) -> bool {
    middle.cos() < -1e-9
}

/// t = tan(φ/2), or from the back.
fn parameter(phi: f64, middle: f64) -> f64 {
    let turn = if at_back(middle) { PI * middle.signum() } else { 0.0 };
    (0.5 * (phi - turn)).tan()
}

/// Two unit vectors that make a right-handed frame (a, b, k).
fn tangents(k: DVec3) -> [DVec3; 2] {
    let a = crate::node::star::perpendicular(k.normalize());
    [a, k.cross(a).normalize()]
}
