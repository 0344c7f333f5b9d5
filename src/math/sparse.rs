//! Symmetric positive definite sparse systems, solved by faer's Cholesky factorisation, single-threaded
//! (nodes run side by side, and the result must not depend on threads).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMat, SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Conj, Mat, Par, Side};
use std::ops::Range;

/// The pattern of symmetric matrices whose numbers come in blocks that meet in cliques, with an order of elimination of little fill.
/// Blocks are dense. The lower triangle is kept, column by column in the order of elimination.
pub struct Blocks {
    /// Of each block: its place among the blocks in the order of elimination, and that of its first number among the numbers.
    places: Vec<usize>,
    firsts: Vec<usize>,
    /// By place: the blocks behind it that it meets, as (place, rows of the column before that block's).
    below: Vec<Vec<(usize, usize)>>,
    /// Number at each place of the order of elimination.
    order: Vec<usize>,
    pattern: SymbolicSparseColMat<usize>,
    factor: SymbolicCholesky<usize>,
}

impl Blocks {
    /// Blocks fill the numbers from 0 on in turn. All blocks of a clique are different, and meet.
    pub fn new<const N: usize>(blocks: &[Range<usize>], cliques: impl Iterator<Item = [usize; N]>) -> Result<Blocks, String> {
        let mut meetings: Vec<(usize, usize)> = cliques.flat_map(|c| c.into_iter().flat_map(move |a| c.into_iter().map(move |b| (a, b)))).collect();
        meetings.extend((0..blocks.len()).map(|a| (a, a)));
        let (order, places) = order(blocks.len(), &mut meetings)?;
        // by place, in both directions
        meetings.iter_mut().for_each(|(a, b)| (*a, *b) = (places[*a], places[*b]));
        meetings.sort_unstable();
        let sizes: Vec<usize> = order.iter().map(|&b| blocks[b].len()).collect();
        let mut starts = vec![0];
        starts.extend(sizes.iter().scan(0, |sum, size| {
            *sum += size;
            Some(*sum)
        }));
        let n = starts[sizes.len()];
        // each pair of blocks stands in the lower triangle once, and all of them in both directions
        let most = meetings.iter().map(|m| sizes[m.0] * sizes[m.1]).sum::<usize>() / 2 + n;
        let mut below = Vec::with_capacity(sizes.len());
        let [mut lower, mut upper] = [0, 1].map(|_| Columns { ends: Vec::with_capacity(n), rows: Vec::with_capacity(most) });
        for met in meetings.chunk_by(|a, b| a.0 == b.0) {
            let place = met[0].0;
            let own = met.partition_point(|m| m.1 < place);
            let mut rows = sizes[place];
            let behind = met[own + 1..].iter().map(|&(_, other)| {
                rows += sizes[other];
                (other, rows - sizes[other])
            });
            below.push(behind.collect());
            let numbers = |m: &(usize, usize)| starts[m.1]..starts[m.1 + 1];
            for k in starts[place]..starts[place + 1] {
                lower.rows.extend(k..starts[place + 1]);
                met[own + 1..].iter().for_each(|m| lower.rows.extend(numbers(m)));
                lower.ends.push(lower.rows.len());
                met[..own].iter().for_each(|m| upper.rows.extend(numbers(m)));
                upper.rows.extend(starts[place]..=k);
                upper.ends.push(upper.rows.len());
            }
        }
        let factor = symbolic(upper.pattern(n).as_ref(), Side::Upper, SymmetricOrdering::Identity)?;
        let firsts = places.iter().map(|&place| starts[place]).collect();
        let order = order.into_iter().flat_map(|b| blocks[b].clone()).collect();
        Ok(Blocks { places, firsts, below, order, pattern: lower.pattern(n), factor })
    }

    /// A matrix of zeros with this pattern.
    pub fn zeros(&self) -> Vec<f64> {
        vec![0.0; self.pattern.compute_nnz()]
    }

    /// Add to a matrix of this pattern the lower triangle of a matrix over the blocks of a clique, in this order: row k of it is
    /// `row(k)`, at least k + 1 long.
    pub fn add<'a>(&self, values: &mut [f64], blocks: &[Range<usize>], clique: &[usize], row: impl Fn(usize) -> &'a [f64]) {
        let mut first_row = 0;
        for (k, &a) in clique.iter().enumerate() {
            let mut first_column = 0;
            for &b in &clique[..=k] {
                let (rows, columns) = (blocks[a].len(), blocks[b].len());
                for i in 0..rows {
                    let from = &row(first_row + i)[first_column..];
                    if a == b {
                        (0..=i).for_each(|j| values[self.pattern.col_ptr()[self.firsts[a] + j] + i - j] += from[j]);
                    } else if self.places[a] > self.places[b] {
                        (0..columns).for_each(|j| values[self.at(b, j, a) + i] += from[j]);
                    } else {
                        let at = self.at(a, i, b);
                        values[at..at + columns].iter_mut().zip(from).for_each(|(x, y)| *x += y);
                    }
                }
                first_column += columns;
            }
            first_row += blocks[a].len();
        }
    }

    /// Where column `j` of a block has its first number of a block behind it.
    fn at(&self, block: usize, j: usize, other: usize) -> usize {
        let below = &self.below[self.places[block]];
        let found = below.binary_search_by_key(&self.places[other], |b| b.0).expect("the blocks of a clique meet");
        self.pattern.col_ptr()[self.firsts[block] + j] + below[found].1 - j
    }

    /// Solve for one right-hand side, both in the numbers' own order.
    pub fn solve(&self, values: &[f64], rhs: &[f64]) -> Result<Vec<f64>, String> {
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), values);
        let mut x = Mat::from_fn(rhs.len(), 1, |k, _| rhs[self.order[k]]);
        solve(&self.factor, matrix, &mut x)?;
        let mut out = vec![0.0; rhs.len()];
        self.order.iter().enumerate().for_each(|(k, &number)| out[number] = x[(k, 0)]);
        Ok(out)
    }
}

/// An order of little fill for so many unknowns that meet in these pairs (which are sorted here), and the place of each in it.
fn order(n: usize, meetings: &mut Vec<(usize, usize)>) -> Result<(Vec<usize>, Vec<usize>), String> {
    meetings.sort_unstable();
    meetings.dedup();
    let mut columns = Columns::default();
    for met in meetings.chunk_by(|a, b| a.0 == b.0) {
        columns.rows.extend(met.iter().map(|m| m.1).filter(|&row| row >= met[0].0));
        columns.ends.push(columns.rows.len());
    }
    let pattern = columns.pattern(n);
    let [mut order, mut places] = [0, 1].map(|_| vec![0; n]);
    let mut room = MemBuffer::new(amd::order_scratch::<usize>(n, pattern.compute_nnz()));
    amd::order(&mut order, &mut places, pattern.as_ref(), Default::default(), MemStack::new(&mut room))
        .map_err(|e| format!("matrix analysis failed: {e:?}"))?;
    Ok((order, places))
}

/// A pattern under assembly, column by column.
#[derive(Default)]
struct Columns {
    ends: Vec<usize>,
    rows: Vec<usize>,
}

impl Columns {
    fn pattern(self, n: usize) -> SymbolicSparseColMat<usize> {
        let starts = std::iter::once(0).chain(self.ends).collect();
        SymbolicSparseColMat::new_checked(n, n, starts, None, self.rows)
    }
}

/// The pattern's factor.
fn symbolic(pattern: SymbolicSparseColMatRef<usize>, side: Side, order: SymmetricOrdering<usize>) -> Result<SymbolicCholesky<usize>, String> {
    // unknowns come in blocks that meet: dense kernels pay at any size
    let params = CholeskySymbolicParams { supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL, ..Default::default() };
    factorize_symbolic_cholesky(pattern, side, order, params).map_err(|e| format!("matrix analysis failed: {e:?}"))
}

/// Factorise, and solve in place.
fn solve(symbolic: &SymbolicCholesky<usize>, matrix: SparseColMatRef<usize, f64>, x: &mut Mat<f64>) -> Result<(), String> {
    let mut values = vec![0.0; symbolic.len_val()];
    let room = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()).or(symbolic.solve_in_place_scratch::<f64>(x.ncols(), Par::Seq));
    let mut room = MemBuffer::new(room);
    let factor = symbolic
        .factorize_numeric_llt(&mut values, matrix, Side::Lower, Default::default(), Par::Seq, MemStack::new(&mut room), Default::default())
        .map_err(|e| format!("the matrix is not positive definite: {e:?}"))?;
    factor.solve_in_place_with_conj(Conj::No, x.as_mut(), Par::Seq, MemStack::new(&mut room));
    Ok(())
}

/// A symmetric matrix under assembly: entries of the lower triangle, duplicates are added.
#[derive(Default)]
pub struct Symmetric {
    /// (row, column, value).
    entries: Vec<(u32, u32, f64)>,
}

impl Symmetric {
    /// With room for so many additions.
    pub fn with_capacity(additions: usize) -> Symmetric {
        Symmetric { entries: Vec::with_capacity(additions) }
    }

    /// Add to entry (row, column); an entry above the diagonal is skipped, its mirror image stands for it.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        if row >= column {
            self.entries.push((row as u32, column as u32, value));
        }
    }

    /// Solve for several right-hand sides at once, one a column.
    pub fn solve(&self, n: usize, mut rhs: Mat<f64>) -> Result<Mat<f64>, String> {
        let matrix = self.assemble(n);
        let symbolic = symbolic(matrix.symbolic(), Side::Lower, SymmetricOrdering::Amd)?;
        solve(&symbolic, matrix.as_ref(), &mut rhs)?;
        Ok(rhs)
    }

    /// Column by column, rows ascending, duplicates added in the order they came.
    fn assemble(&self, n: usize) -> SparseColMat<usize, f64> {
        let mut starts = vec![0usize; n + 1];
        self.entries.iter().for_each(|e| starts[e.1 as usize + 1] += 1);
        (0..n).for_each(|k| starts[k + 1] += starts[k]);
        let mut at = starts.clone();
        let mut sorted = vec![(0u32, 0.0); self.entries.len()];
        for &(row, column, value) in &self.entries {
            sorted[at[column as usize]] = (row, value);
            at[column as usize] += 1;
        }
        let mut sum = vec![0.0; n];
        let mut met = vec![usize::MAX; n];
        let (mut columns, mut rows, mut values) = (vec![0usize], Vec::new(), Vec::new());
        for column in 0..n {
            let first = rows.len();
            for &(row, value) in &sorted[starts[column]..starts[column + 1]] {
                let row = row as usize;
                if met[row] != column {
                    met[row] = column;
                    sum[row] = 0.0;
                    rows.push(row);
                }
                sum[row] += value;
            }
            rows[first..].sort_unstable();
            values.extend(rows[first..].iter().map(|&row| sum[row]));
            columns.push(rows.len());
        }
        SparseColMat::new(SymbolicSparseColMat::new_checked(n, n, columns, None, rows), values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks of three sizes that meet in three cliques, against the same entries put in one by one.
    #[test]
    fn blocks_are_the_sum_of_their_cliques() {
        let blocks = [0..2, 2..5, 5..6, 6..8, 8..11];
        let cliques = [[0, 2, 4], [3, 1, 2], [4, 3, 0]];
        let pattern = Blocks::new(&blocks, cliques.into_iter()).unwrap();
        let mut values = pattern.zeros();
        let mut single = Symmetric::default();
        for (k, clique) in cliques.iter().enumerate() {
            let numbers: Vec<usize> = clique.iter().flat_map(|&b| blocks[b].clone()).collect();
            let entry = |i: usize, j: usize| if i == j { 20.0 } else { ((3 * i + 7 * j + 5 * k) % 11) as f64 / 11.0 };
            let rows: Vec<Vec<f64>> = (0..numbers.len()).map(|i| (0..=i).map(|j| entry(i, j)).collect()).collect();
            pattern.add(&mut values, &blocks, clique, |i| &rows[i]);
            for (i, &a) in numbers.iter().enumerate() {
                for (j, &b) in numbers[..=i].iter().enumerate() {
                    single.add(a.max(b), a.min(b), rows[i][j]);
                }
            }
        }
        let rhs: Vec<f64> = (0..11).map(|k| k as f64 - 4.0).collect();
        let one = pattern.solve(&values, &rhs).unwrap();
        let other = single.solve(11, Mat::from_fn(11, 1, |k, _| rhs[k])).unwrap();
        for k in 0..11 {
            assert!((one[k] - other[(k, 0)]).abs() < 1e-15, "{k}: {} {}", one[k], other[(k, 0)]);
        }
        assert!(one.iter().any(|x| x.abs() > 0.01));
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_an_error() {
        let blocks = [0..1, 1..2];
        let pattern = Blocks::new(&blocks, [[0, 1]].into_iter()).unwrap();
        let mut values = pattern.zeros();
        pattern.add(&mut values, &blocks, &[0, 1], |k| if k == 0 { &[1.0] } else { &[2.0, 1.0] });
        assert!(pattern.solve(&values, &[1.0, 1.0]).unwrap_err().contains("positive definite"));
    }
}
