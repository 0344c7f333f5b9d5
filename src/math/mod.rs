//! Floor: plain geometry and numbers that every layer may use. Knows nothing of lattices.

pub mod bernstein;
pub mod gauss;
pub mod halves;
pub mod nurbs;
pub mod sparse;
pub mod wide;

use glam::DVec3;

/// Loops over many numbers.
pub trait Loops {
    type Output;

    /// To be marked `inline(always)`, with all that it calls: else it stays as it is.
    fn run(self) -> Self::Output;
}

/// Run loops with the widest vector instructions of this machine. Products and sums stay apart, so all machines give the same bits.
pub fn vectorised<L: Loops>(loops: L) -> L::Output {
    struct Run<L>(L);
    impl<L: Loops> pulp::WithSimd for Run<L> {
        type Output = L::Output;

        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) -> L::Output {
            self.0.run()
        }
    }
    pulp::Arch::new().dispatch(Run(loops))
}

/// Vectors whose length is a multiple of this are added without a remainder.
const LANES: usize = 8;

/// The next length without a remainder.
pub fn padded(n: usize) -> usize {
    n.next_multiple_of(LANES)
}

/// y += f x
#[inline(always)]
pub fn axpy(y: &mut [f64], f: f64, x: &[f64]) {
    let n = y.len().min(x.len());
    let (y, y_rest) = y[..n].as_chunks_mut::<LANES>();
    let (x, x_rest) = x[..n].as_chunks::<LANES>();
    for (y, x) in y.iter_mut().zip(x) {
        // all are read before one is written: no need to know that x and y lie apart
        let (mut sum, x) = (*y, *x);
        for k in 0..LANES {
            sum[k] += f * x[k];
        }
        *y = sum;
    }
    y_rest.iter_mut().zip(x_rest).for_each(|(y, x)| *y += f * x);
}

/// y += f x for two x in turn, which are at least as long as y.
#[inline(always)]
pub fn axpy2(y: &mut [f64], [f, g]: [f64; 2], [x, z]: [&[f64]; 2]) {
    let n = y.len();
    let (y, y_rest) = y.as_chunks_mut::<LANES>();
    let ((x, x_rest), (z, z_rest)) = (x[..n].as_chunks::<LANES>(), z[..n].as_chunks::<LANES>());
    for (y, (x, z)) in y.iter_mut().zip(x.iter().zip(z)) {
        let (mut sum, x, z) = (*y, *x, *z);
        for k in 0..LANES {
            sum[k] = (sum[k] + f * x[k]) + g * z[k];
        }
        *y = sum;
    }
    y_rest.iter_mut().zip(x_rest.iter().zip(z_rest)).for_each(|(y, (x, z))| *y = (*y + f * x) + g * z);
}

/// The first n numbers of a buffer that is used again, whatever they are; it grows where it is shorter.
pub fn room(x: &mut Vec<f64>, n: usize) -> &mut [f64] {
    x.resize(x.len().max(n), 0.0);
    &mut x[..n]
}

/// Sum of rows, each times a factor: `entries` are (row, factor), rows `line` long. All lengths are padded.
#[inline(always)]
pub fn combine(out: &mut [f64], entries: &[(usize, f64)], rows: &[f64], line: usize) {
    let mut at = 0;
    let (wide, rest) = out.as_chunks_mut::<32>();
    for out in wide {
        *out = combined(entries, rows, line, at);
        at += 32;
    }
    let (middle, rest) = rest.as_chunks_mut::<16>();
    for out in middle {
        *out = combined(entries, rows, line, at);
        at += 16;
    }
    for out in rest.as_chunks_mut::<8>().0 {
        *out = combined(entries, rows, line, at);
        at += 8;
    }
}

/// The same of all rows, with a factor for each; lengths are multiples of 4.
#[inline(always)]
pub fn combine_all(out: &mut [f64], factors: &[f64], rows: &[f64], line: usize) {
    let mut at = 0;
    let (wide, rest) = out.as_chunks_mut::<32>();
    for out in wide {
        *out = combined_all(factors, rows, line, at);
        at += 32;
    }
    let (middle, rest) = rest.as_chunks_mut::<16>();
    for out in middle {
        *out = combined_all(factors, rows, line, at);
        at += 16;
    }
    for out in rest.as_chunks_mut::<4>().0 {
        *out = combined_all(factors, rows, line, at);
        at += 4;
    }
}

#[inline(always)]
fn combined_all<const N: usize>(factors: &[f64], rows: &[f64], line: usize, at: usize) -> [f64; N] {
    let mut sum = [0.0; N];
    for (row, &f) in rows.chunks_exact(line).zip(factors) {
        let row = row[at..].first_chunk::<N>().expect("rows are as long as said");
        for k in 0..N {
            sum[k] += f * row[k];
        }
    }
    sum
}

/// So many columns of `combine`, from `at` on: few enough to be kept in vector registers.
#[inline(always)]
fn combined<const N: usize>(entries: &[(usize, f64)], rows: &[f64], line: usize, at: usize) -> [f64; N] {
    let mut sum = [0.0; N];
    for &(row, f) in entries {
        let row = rows[row * line + at..].first_chunk::<N>().expect("rows are padded");
        for k in 0..N {
            sum[k] += f * row[k];
        }
    }
    sum
}

/// The angle between two unit vectors, exact also near 0 and π. Radians.
pub fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
