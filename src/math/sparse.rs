//! Symmetric positive definite sparse systems, solved by faer's Cholesky factorisation, single-threaded
//! (nodes run side by side, and the result must not depend on threads).

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};

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
        let factor = self.assemble(n).sp_cholesky(Side::Lower).map_err(|e| format!("the matrix is not positive definite: {e:?}"))?;
        Ok(factor.solve(rhs))
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
