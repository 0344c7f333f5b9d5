//! Symmetric positive definite sparse systems, solved by faer's Cholesky factorisation, single-threaded
//! (nodes run side by side, and the result must not depend on threads).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::Perm;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Conj, Mat, Par, Side};
use std::ops::Range;

/// An order of elimination.
pub struct Order(Perm<usize>);

impl Order {
    /// One of little fill for unknowns in blocks that fill the numbers from 0 on in turn. All blocks of a clique meet.
    pub fn of_blocks<const N: usize>(blocks: &[Range<usize>], cliques: impl Iterator<Item = [usize; N]>) -> Result<Order, String> {
        let mut graph = Symmetric::default();
        for clique in cliques {
            for a in clique {
                clique.into_iter().for_each(|b| graph.add(a, b, 1.0));
            }
        }
        let graph = graph.assemble(blocks.len());
        let [mut order, mut place] = [0, 1].map(|_| vec![0; blocks.len()]);
        let mut room = MemBuffer::new(amd::order_scratch::<usize>(blocks.len(), graph.compute_nnz()));
        amd::order(&mut order, &mut place, graph.symbolic(), Default::default(), MemStack::new(&mut room))
            .map_err(|e| format!("matrix analysis failed: {e:?}"))?;
        let order: Vec<usize> = order.into_iter().flat_map(|block| blocks[block].clone()).collect();
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(k, &number)| place[number] = k);
        let n = order.len();
        Ok(Order(Perm::new_checked(order.into(), place.into(), n)))
    }
}

/// A symmetric matrix under assembly: entries of the lower triangle, duplicates are added.
#[derive(Default)]
pub struct Symmetric {
    /// (row, column, value).
    entries: Vec<(u32, u32, f64)>,
}

impl Symmetric {
    /// Add to entry (row, column); an entry above the diagonal is skipped, its mirror image stands for it.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        if row >= column {
            self.entries.push((row as u32, column as u32, value));
        }
    }

    /// Solve for several right-hand sides at once; `rhs` is n rows by k columns, row-major rows. `order` is an order of
    /// elimination; without one, one of little fill is looked for.
    pub fn solve(&self, n: usize, rhs: &Mat<f64>, order: Option<&Order>) -> Result<Mat<f64>, String> {
        let matrix = self.assemble(n);
        // corners and edges come with blocks of numbers each: dense kernels pay at any size
        let params = CholeskySymbolicParams { supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL, ..Default::default() };
        let order = order.map_or(SymmetricOrdering::Amd, |order| SymmetricOrdering::Custom(order.0.as_ref()));
        let symbolic = factorize_symbolic_cholesky(matrix.symbolic(), Side::Lower, order, params).map_err(|e| format!("matrix analysis failed: {e:?}"))?;
        let mut values = vec![0.0; symbolic.len_val()];
        let room =
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()).or(symbolic.solve_in_place_scratch::<f64>(rhs.ncols(), Par::Seq));
        let mut room = MemBuffer::new(room);
        let factor = symbolic
            .factorize_numeric_llt(&mut values, matrix.as_ref(), Side::Lower, Default::default(), Par::Seq, MemStack::new(&mut room), Default::default())
            .map_err(|e| format!("the matrix is not positive definite: {e:?}"))?;
        let mut x = rhs.clone();
        factor.solve_in_place_with_conj(Conj::No, x.as_mut(), Par::Seq, MemStack::new(&mut room));
        Ok(x)
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
