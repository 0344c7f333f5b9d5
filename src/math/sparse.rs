//! Symmetric positive definite sparse systems, solved by faer's Cholesky factorisation, single-threaded
//! (nodes run side by side, and the result must not depend on threads).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Conj, Mat, Par, Side};

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

    /// Solve for several right-hand sides at once; `rhs` is n rows by k columns, row-major rows.
    pub fn solve(&self, n: usize, rhs: &Mat<f64>) -> Result<Mat<f64>, String> {
        let matrix = self.assemble(n);
        // corners and edges come with blocks of numbers each: dense kernels pay at any size
        let params = CholeskySymbolicParams { supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL, ..Default::default() };
        let symbolic = factorize_symbolic_cholesky(matrix.symbolic(), Side::Lower, SymmetricOrdering::Amd, params)
            .map_err(|e| format!("matrix analysis failed: {e:?}"))?;
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
