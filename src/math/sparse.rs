//! Symmetric positive definite sparse systems, solved by faer's Cholesky factorisation, single-threaded
//! (nodes run side by side, and the result must not depend on threads).

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

/// A symmetric matrix under assembly: entries of the lower triangle, duplicates are added.
#[derive(Default)]
pub struct Symmetric {
    entries: Vec<Triplet<usize, usize, f64>>,
}

impl Symmetric {
    /// Add to entry (row, column); an entry above the diagonal is skipped, its mirror image stands for it.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        if row >= column {
            self.entries.push(Triplet::new(row, column, value));
        }
    }

    /// Solve for several right-hand sides at once; `rhs` is n rows by k columns, row-major rows.
    pub fn solve(&self, n: usize, rhs: &Mat<f64>) -> Result<Mat<f64>, String> {
        let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &self.entries).map_err(|e| format!("matrix assembly failed: {e:?}"))?;
        let factor = matrix.sp_cholesky(Side::Lower).map_err(|e| format!("the matrix is not positive definite: {e:?}"))?;
        Ok(factor.solve(rhs))
    }
}
