//! The film's facets as grids. The film over one strut's cell is a *sleeve*: rows of vertices about the strut, the rim first, the
//! cell's sides last; columns counter-clockwise about its axis, closed. All diagonals run from (row, column) to (row + 1,
//! column + 1). Seen from the neighbour's sleeve, which is turned by half a turn, they run the same way: so facets go on
//! regularly across a side, and only where three cells and more meet a vertex has another valence than 6.

use crate::node::film::Control;
use glam::DVec3;

/// Room behind each row for whole vectors that start at any of its columns.
const SLACK: usize = 8;

/// Points and normals of one sleeve.
#[derive(Clone, Debug)]
pub struct Sleeve {
    /// Quads about the strut, and from rim to cell side.
    pub columns: usize,
    pub layers: usize,
    stride: usize,
    /// Row by row x, y, z of the points, then of the normals, `stride` each. A row starts with column -1 and ends with column
    /// `columns`, which are the last and the first once more. One row more lies beyond the cell side (`Seams::reach_over`).
    numbers: Vec<f64>,
}

impl Sleeve {
    pub fn new(columns: usize, layers: usize) -> Sleeve {
        let stride = (columns + 2 + SLACK).next_multiple_of(SLACK);
        Sleeve { columns, layers, stride, numbers: vec![0.0; 6 * stride * (layers + 2)] }
    }

    /// x, y, z of a row's points, then of its normals; column c at c + 1.
    #[inline(always)]
    pub fn row(&self, row: usize) -> [&[f64]; 6] {
        let n = self.stride;
        let (points, normals) = self.numbers[6 * n * row..6 * n * (row + 1)].split_at(3 * n);
        [&points[..n], &points[n..2 * n], &points[2 * n..], &normals[..n], &normals[n..2 * n], &normals[2 * n..]]
    }

    #[inline(always)]
    pub fn row_mut(&mut self, row: usize) -> [&mut [f64]; 6] {
        let mut parts = self.numbers[6 * self.stride * row..6 * self.stride * (row + 1)].chunks_exact_mut(self.stride);
        std::array::from_fn(|_| parts.next().expect("six a row"))
    }

    /// Of the vectors that start at number `first` of a row.
    #[inline(always)]
    fn vector(&self, row: usize, column: usize, first: usize) -> DVec3 {
        let at = &self.numbers[(6 * row + first) * self.stride + column + 1..];
        DVec3::new(at[0], at[self.stride], at[2 * self.stride])
    }

    fn set_vector(&mut self, row: usize, column: usize, first: usize, v: DVec3) {
        let at = &mut self.numbers[(6 * row + first) * self.stride + column + 1..];
        (at[0], at[self.stride], at[2 * self.stride]) = (v.x, v.y, v.z);
    }

    /// The vertex at (row, column), column 0 to `columns`, the last being the first.
    #[inline(always)]
    pub fn point(&self, row: usize, column: usize) -> DVec3 {
        self.vector(row, column, 0)
    }

    #[inline(always)]
    pub fn normal(&self, row: usize, column: usize) -> DVec3 {
        self.vector(row, column, 3)
    }

    pub fn set(&mut self, row: usize, column: usize, point: DVec3, normal: DVec3) {
        self.set_vector(row, column, 0, point);
        self.set_normal(row, column, normal);
    }

    pub fn set_normal(&mut self, row: usize, column: usize, normal: DVec3) {
        self.set_vector(row, column, 3, normal);
    }

    /// Repeat the first and the last column of a row behind and before it.
    pub fn close(&mut self, row: usize) {
        let columns = self.columns;
        for part in self.row_mut(row) {
            part[0] = part[columns];
            part[columns + 1] = part[1];
        }
    }
}

/// A vertex of the last row of a sleeve, or the edge of that row that starts there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    pub arm: usize,
    pub column: usize,
}

/// How the sleeves of a node meet, at the level of the control mesh.
#[derive(Clone, Debug, Default)]
pub struct Seams {
    /// Per arm and edge of its last row: the same edge in the neighbour's, where it runs the other way.
    pub across: Vec<Vec<Place>>,
    /// The vertices of the last rows, each with all its places.
    pub meets: Vec<Vec<Place>>,
}

impl Seams {
    pub fn new(control: &Control) -> Seams {
        let last: Vec<&Vec<u32>> = control.rows.iter().map(|rows| &rows[rows.len() - 1]).collect();
        let places = || last.iter().enumerate().flat_map(|(arm, row)| (0..row.len()).map(move |column| Place { arm, column }));
        let mut vertices: Vec<(u32, Place)> = places().map(|p| (last[p.arm][p.column], p)).collect();
        vertices.sort_unstable();
        let meets = vertices.chunk_by(|a, b| a.0 == b.0).map(|group| group.iter().map(|e| e.1).collect()).collect();
        let ends = |p: &Place| [last[p.arm][p.column], last[p.arm][(p.column + 1) % last[p.arm].len()]];
        let mut edges: Vec<([u32; 2], Place)> = places()
            .map(|p| {
                let [a, b] = ends(&p);
                ([a.min(b), a.max(b)], p)
            })
            .collect();
        edges.sort_unstable();
        let mut across: Vec<Vec<Place>> = last.iter().map(|row| vec![Place { arm: 0, column: 0 }; row.len()]).collect();
        for pair in edges.chunk_by(|a, b| a.0 == b.0) {
            let (a, b) = (pair[0].1, pair[pair.len() - 1].1);
            across[a.arm][a.column] = b;
            across[b.arm][b.column] = a;
        }
        Seams { across, meets }
    }

    /// The edge across edge `column` of an arm's last row, both after `level` levels.
    pub fn across(&self, arm: usize, column: usize, level: u32) -> Place {
        let parts = 1 << level;
        let Place { arm, column: edge } = self.across[arm][column / parts];
        Place { arm, column: edge * parts + parts - 1 - column % parts }
    }

    /// Fill the row beyond the last of each sleeve: column c + 1 is what lies across edge c.
    pub fn reach_over(&self, sleeves: &mut [Sleeve], level: u32) {
        for arm in 0..sleeves.len() {
            let (columns, layers) = (sleeves[arm].columns, sleeves[arm].layers);
            for column in 0..columns {
                let other = self.across(arm, column, level);
                let from = &sleeves[other.arm];
                let (p, n) = (from.point(from.layers - 1, other.column), from.normal(from.layers - 1, other.column));
                sleeves[arm].set(layers + 1, column + 1, p, n);
            }
            for part in sleeves[arm].row_mut(layers + 1) {
                part[1] = part[columns + 1];
            }
        }
    }
}
