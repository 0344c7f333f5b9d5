//! Polynomials in Bernstein form on [0, 1].

/// Highest degree of [`basis`]: its values live on the stack.
pub const MOST_DEGREE: usize = 13;

/// Values and the first two derivatives of the n + 1 Bernstein polynomials of degree n at x; zeros behind them.
pub fn basis(n: usize, x: f64) -> [[f64; MOST_DEGREE + 1]; 3] {
    assert!(n <= MOST_DEGREE, "degree {n} of a Bernstein basis: at most {MOST_DEGREE}");
    let mut b = [0.0; MOST_DEGREE + 1];
    b[0] = 1.0;
    // those of degree n, n - 1 and n - 2
    let mut plain = [b; 3];
    for k in 1..=n {
        for i in (1..=k).rev() {
            b[i] = (1.0 - x) * b[i] + x * b[i - 1];
        }
        b[0] *= 1.0 - x;
        if n - k <= 2 {
            plain[n - k] = b;
        }
    }
    let lower = |b: [f64; MOST_DEGREE + 1], n: usize| {
        // derivative of degree n from the polynomials of degree n - 1
        let mut out = [0.0; MOST_DEGREE + 1];
        for i in 0..=n {
            out[i] = n as f64 * (if i > 0 { b[i - 1] } else { 0.0 } - if i < n { b[i] } else { 0.0 });
        }
        out
    };
    let none = [0.0; MOST_DEGREE + 1];
    let d1 = if n >= 1 { lower(plain[1], n) } else { none };
    let d2 = if n >= 2 { lower(lower(plain[2], n - 1), n) } else { none };
    [plain[0], d1, d2]
}

/// Turns values at the nodes of one degree into Bernstein coefficients: exact for polynomials of that degree.
#[derive(Clone, Debug)]
pub struct Interpolation {
    pub nodes: Vec<f64>,
    /// `inverse[i][k]`: weight of the value at node k in coefficient i.
    inverse: Vec<Vec<f64>>,
}

impl Interpolation {
    /// Chebyshev points with the ends.
    pub fn new(degree: usize) -> Self {
        let n = degree + 1;
        let nodes: Vec<f64> = (0..n).map(|k| 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / degree as f64).cos()).collect();
        // Gauss-Jordan with pivoting on the collocation matrix: degree <= 12, done once
        let mut a: Vec<Vec<f64>> = nodes.iter().map(|&x| basis(degree, x)[0][..n].to_vec()).collect();
        let mut inv: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(i == j)).collect()).collect();
        for col in 0..n {
            let pivot = (col..n).max_by(|&i, &j| a[i][col].abs().total_cmp(&a[j][col].abs())).expect("rows left");
            a.swap(col, pivot);
            inv.swap(col, pivot);
            let scale = 1.0 / a[col][col];
            a[col].iter_mut().chain(inv[col].iter_mut()).for_each(|x| *x *= scale);
            for row in 0..n {
                let f = a[row][col];
                if row != col && f != 0.0 {
                    for k in 0..n {
                        a[row][k] -= f * a[col][k];
                        inv[row][k] -= f * inv[col][k];
                    }
                }
            }
        }
        Interpolation { nodes, inverse: inv }
    }

    /// The same polynomials, their coefficients of a higher degree.
    pub fn raised(self, degree: usize) -> Self {
        let n = self.nodes.len() - 1;
        let row = |i: usize| {
            let weight = |k: usize| {
                (0..=n).filter(|j| (i + n).saturating_sub(degree) <= *j && *j <= i).map(|j| share(degree - n, i - j, n, j) * self.inverse[j][k]).sum::<f64>()
            };
            (0..=n).map(weight).collect()
        };
        Interpolation { inverse: (0..=degree).map(row).collect(), nodes: self.nodes.clone() }
    }

    /// Coefficients of the polynomial with these values at the nodes.
    pub fn coefficients<T>(&self, values: &[T]) -> Vec<T>
    where
        T: Copy + std::ops::Mul<f64, Output = T> + std::iter::Sum<T>,
    {
        self.inverse.iter().map(|row| row.iter().zip(values).map(|(&w, &v)| v * w).sum()).collect()
    }
}

/// Binomial coefficients, `[n][k]`.
const BINOMIAL: [[f64; MOST_DEGREE + 1]; MOST_DEGREE + 1] = {
    let mut out = [[0.0; MOST_DEGREE + 1]; MOST_DEGREE + 1];
    let mut n = 0;
    while n <= MOST_DEGREE {
        let mut k = 0;
        while k <= n {
            out[n][k] = if k == 0 || k == n { 1.0 } else { out[n - 1][k - 1] + out[n - 1][k] };
            k += 1;
        }
        n += 1;
    }
    out
};

/// What the product of coefficient i of degree m and coefficient j of degree n adds to coefficient i + j of the product of
/// both polynomials, of degree m + n.
pub fn share(m: usize, i: usize, n: usize, j: usize) -> f64 {
    BINOMIAL[m][i] * BINOMIAL[n][j] / BINOMIAL[m + n][i + j]
}
