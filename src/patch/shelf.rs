//! Where skins wait until they are written: in memory, and beyond a limit in a temporary file that nobody else sees and that ends with
//! its last reader. Each distinct skin is kept once; who needs it takes it from the shelf and drops it again.

use crate::math::nurbs::{NurbsCurve, NurbsSurface};
use crate::patch::{Patch, Rim, Skin, SkinCurve, SkinEdge};
use glam::DVec3;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// A shelf for the skins of one run.
#[derive(Debug)]
pub struct Shelf {
    /// Where the file goes; none: all stay in memory.
    folder: Option<PathBuf>,
    /// Bytes of skins kept in memory.
    limit: usize,
    filled: Mutex<Filled>,
}

#[derive(Debug, Default)]
struct Filled {
    in_memory: usize,
    file: Option<Arc<Mutex<File>>>,
    in_file: u64,
}

/// A skin on a shelf.
#[derive(Clone, Debug)]
pub enum Shelved {
    Memory(Arc<Skin>),
    File { file: Arc<Mutex<File>>, at: u64, bytes: u32 },
}

impl Shelf {
    pub fn new(folder: Option<PathBuf>, limit: usize) -> Shelf {
        Shelf { folder, limit, filled: Mutex::default() }
    }

    pub fn keep(&self, skin: Skin) -> io::Result<Shelved> {
        let text = encode(&skin);
        let mut filled = self.filled.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(folder) = self.folder.as_ref().filter(|_| filled.in_memory + text.len() > self.limit) else {
            filled.in_memory += text.len();
            return Ok(Shelved::Memory(Arc::new(skin)));
        };
        let file = match &filled.file {
            Some(file) => file.clone(),
            None => filled.file.insert(Arc::new(Mutex::new(tempfile::tempfile_in(folder)?))).clone(),
        };
        let at = filled.in_file;
        filled.in_file += text.len() as u64;
        drop(filled);
        let mut open = file.lock().unwrap_or_else(PoisonError::into_inner);
        open.seek(SeekFrom::Start(at))?;
        open.write_all(&text)?;
        drop(open);
        Ok(Shelved::File { file, at, bytes: text.len() as u32 })
    }
}

impl Shelved {
    /// Where it is: the same for clones alone.
    pub fn place(&self) -> (usize, u64) {
        match self {
            Shelved::Memory(skin) => (Arc::as_ptr(skin) as usize, 0),
            Shelved::File { file, at, .. } => (Arc::as_ptr(file) as usize, *at),
        }
    }

    /// The skin. Panics if the temporary file cannot be read back: nothing can be made without it.
    pub fn skin(&self) -> Arc<Skin> {
        match self {
            Shelved::Memory(skin) => skin.clone(),
            Shelved::File { file, at, bytes } => {
                let mut text = vec![0; *bytes as usize];
                let mut open = file.lock().unwrap_or_else(PoisonError::into_inner);
                open.seek(SeekFrom::Start(*at)).and_then(|_| open.read_exact(&mut text)).expect("the temporary file of skins can be read");
                drop(open);
                Arc::new(decode(&text))
            }
        }
    }
}

impl From<Skin> for Shelved {
    fn from(skin: Skin) -> Shelved {
        Shelved::Memory(Arc::new(skin))
    }
}

/// Numbers of 8 bytes, whole ones and doubles; each list behind its length.
#[derive(Default)]
struct Pen(Vec<u8>);

impl Pen {
    fn whole(&mut self, n: usize) {
        self.0.extend((n as u64).to_le_bytes());
    }

    fn number(&mut self, x: f64) {
        self.0.extend(x.to_le_bytes());
    }

    fn point(&mut self, p: DVec3) {
        p.to_array().into_iter().for_each(|x| self.number(x));
    }

    fn list<T>(&mut self, items: &[T], mut one: impl FnMut(&mut Pen, &T)) {
        self.whole(items.len());
        items.iter().for_each(|item| one(self, item));
    }
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn eight(&mut self) -> [u8; 8] {
        let (first, rest) = self.0.split_first_chunk().expect("as it was written");
        self.0 = rest;
        *first
    }

    fn whole(&mut self) -> usize {
        u64::from_le_bytes(self.eight()) as usize
    }

    fn number(&mut self) -> f64 {
        f64::from_le_bytes(self.eight())
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    fn list<T>(&mut self, mut one: impl FnMut(&mut Self) -> T) -> Vec<T> {
        (0..self.whole()).map(|_| one(self)).collect()
    }
}

/// The distinct knot vectors of a skin.
#[derive(Default)]
struct Knots(Vec<Arc<[f64]>>);

impl Knots {
    fn number(&mut self, knots: &Arc<[f64]>) -> usize {
        self.0.iter().position(|k| k == knots).unwrap_or_else(|| {
            self.0.push(knots.clone());
            self.0.len() - 1
        })
    }
}

fn encode(skin: &Skin) -> Vec<u8> {
    let (mut pen, mut knots) = (Pen::default(), Knots::default());
    pen.list(&skin.vertices, |pen, &p| pen.point(p));
    pen.list(&skin.edges, |pen, edge| {
        edge.ends.into_iter().for_each(|v| pen.whole(v));
        match &edge.curve {
            SkinCurve::RimArc(rim) => [0, *rim].into_iter().for_each(|n| pen.whole(n)),
            SkinCurve::Spline(curve) => {
                [1, curve.degree, knots.number(&curve.knots)].into_iter().for_each(|n| pen.whole(n));
                pen.list(&curve.points, |pen, &p| pen.point(p));
                pen.list(&curve.weights, |pen, &w| pen.number(w));
            }
        }
    });
    pen.list(&skin.patches, |pen, patch| {
        let surface = &patch.surface;
        surface.degree.into_iter().for_each(|d| pen.whole(d));
        surface.knots.iter().for_each(|k| pen.whole(knots.number(k)));
        pen.list(&surface.points, |pen, &p| pen.point(p));
        pen.list(&surface.weights, |pen, &w| pen.number(w));
        patch.boundary.iter().for_each(|&(edge, forward)| pen.whole(2 * edge + forward as usize));
        pen.whole(patch.arm);
    });
    pen.list(&skin.rims, |pen, rim| {
        pen.point(rim.axis);
        [rim.cut, rim.radius, rim.taper].into_iter().for_each(|x| pen.number(x));
        pen.list(&rim.arcs, |pen, &arc| pen.whole(arc));
    });
    let mut head = Pen::default();
    head.list(&knots.0, |pen, k| pen.list(k, |pen, &x| pen.number(x)));
    [head.0, pen.0].concat()
}

fn decode(text: &[u8]) -> Skin {
    let mut r = Reader(text);
    let knots: Vec<Arc<[f64]>> = r.list(|r| r.list(Reader::number).into());
    let vertices = r.list(Reader::point);
    let edges = r.list(|r| {
        let ends = [r.whole(), r.whole()];
        let curve = match r.whole() {
            0 => SkinCurve::RimArc(r.whole()),
            _ => {
                let (degree, knots) = (r.whole(), knots[r.whole()].clone());
                SkinCurve::Spline(NurbsCurve { degree, knots, points: r.list(Reader::point), weights: r.list(Reader::number).into() })
            }
        };
        SkinEdge { ends, curve }
    });
    let patches = r.list(|r| {
        let degree = [r.whole(), r.whole()];
        let knots = [0, 1].map(|_| knots[r.whole()].clone());
        let surface = NurbsSurface { degree, knots, points: r.list(Reader::point), weights: r.list(Reader::number).into() };
        let boundary = [0; 4].map(|_| r.whole()).map(|n| (n / 2, n % 2 == 1));
        Patch { surface, boundary, arm: r.whole() }
    });
    let rims = r.list(|r| {
        let (axis, cut, radius, taper) = (r.point(), r.number(), r.number(), r.number());
        Rim { axis, cut, radius, taper, arcs: r.list(Reader::whole) }
    });
    Skin { vertices, edges, patches, rims }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skin(seed: f64) -> Skin {
        let knots: [Arc<[f64]>; 2] = [[0.0, 0.0, 1.0, 1.0].into(), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0].into()];
        let point = |k: usize| DVec3::new(seed / 3.0, -0.0, k as f64 * seed);
        let spline = NurbsCurve { degree: 1, knots: knots[0].clone(), points: vec![point(0), point(1)], weights: [1.0, seed].into() };
        let surface = NurbsSurface { degree: [1, 2], knots: knots.clone(), points: (0..6).map(point).collect(), weights: [seed; 6].into() };
        Skin {
            vertices: (0..3).map(point).collect(),
            edges: vec![SkinEdge { ends: [0, 1], curve: SkinCurve::Spline(spline) }, SkinEdge { ends: [1, 2], curve: SkinCurve::RimArc(7) }],
            patches: vec![Patch { surface, boundary: [(0, true), (1, false), (2, true), (3, true)], arm: 5 }],
            rims: vec![Rim { axis: DVec3::X, cut: seed, radius: 0.5, taper: -0.1, arcs: vec![1, 2] }],
        }
    }

    #[test]
    fn skins_come_back_to_the_bit_from_memory_and_from_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let one = encode(&skin(1.0)).len();
        let shelf = Shelf::new(Some(folder.path().into()), 2 * one);
        let kept: Vec<Shelved> = (0..6).map(|k| shelf.keep(skin(k as f64 / 7.0)).unwrap()).collect();
        assert_eq!(kept.iter().filter(|k| matches!(k, Shelved::Memory(_))).count(), 2);
        for (k, kept) in kept.iter().enumerate().rev() {
            assert_eq!(format!("{:?}", kept.skin()), format!("{:?}", skin(k as f64 / 7.0)));
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "the file has no name");
    }

    #[test]
    fn without_a_folder_all_stay_in_memory() {
        let shelf = Shelf::new(None, 0);
        assert!(matches!(shelf.keep(skin(1.0)).unwrap(), Shelved::Memory(_)));
    }
}
