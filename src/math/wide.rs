//! Several numbers, or vectors, in one go: the widest vector instructions of this machine. Products and sums stay apart, and each
//! lane is computed by itself, so all machines give the same bits.

use pulp::Simd;
use std::ops::{Add, Div, Mul, Sub};

/// Lanes of the widest vectors that are made use of.
const MOST_LANES: usize = 8;

/// `Simd::F64_LANES` numbers.
#[derive(Clone, Copy)]
pub struct Wide<S: Simd>(S, S::f64s);

impl<S: Simd> Wide<S> {
    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, x: f64) -> Self {
        Wide(simd, simd.splat_f64s(x))
    }

    /// The numbers from `at` on.
    #[inline(always)]
    pub fn load(simd: S, from: &[f64], at: usize) -> Self {
        Wide(simd, S::as_simd_f64s(&from[at..at + S::F64_LANES]).0[0])
    }

    #[inline(always)]
    pub fn store(self, to: &mut [f64], at: usize) {
        S::as_mut_simd_f64s(&mut to[at..at + S::F64_LANES]).0[0] = self.1;
    }

    /// Whether the first `count` lanes, or all, are above 0.
    #[inline(always)]
    pub fn all_positive(self, count: usize) -> bool {
        let mut lanes = [0.0; MOST_LANES];
        self.store(&mut lanes, 0);
        let mut all = true;
        for lane in &lanes[..count.min(S::F64_LANES)] {
            all &= *lane > 0.0;
        }
        all
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Wide(self.0, self.0.sqrt_f64s(self.1))
    }

    /// The lesser of both, lane by lane.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Wide(self.0, self.0.min_f64s(self.1, other.1))
    }

    /// `self` where `x` is at least `least`, else 0.
    #[inline(always)]
    pub fn where_at_least(self, x: Self, least: f64) -> Self {
        let mask = self.0.greater_than_or_equal_f64s(x.1, self.0.splat_f64s(least));
        Wide(self.0, self.0.select_f64s(mask, self.1, self.0.splat_f64s(0.0)))
    }
}

/// One operator, lane by lane.
macro_rules! operator {
    ($trait:ident, $method:ident, $lanes:ident) => {
        impl<S: Simd> $trait for Wide<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Wide(self.0, self.0.$lanes(self.1, other.1))
            }
        }

        impl<S: Simd> $trait<f64> for Wide<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Wide(self.0, self.0.$lanes(self.1, self.0.splat_f64s(other)))
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

/// As many vectors in space.
#[derive(Clone, Copy)]
pub struct Wide3<S: Simd>(pub [Wide<S>; 3]);

impl<S: Simd> Wide3<S> {
    /// The vectors from `at` on, from lists of their x, y and z.
    #[inline(always)]
    pub fn load(simd: S, [x, y, z]: [&[f64]; 3], at: usize) -> Self {
        Wide3([Wide::load(simd, x, at), Wide::load(simd, y, at), Wide::load(simd, z, at)])
    }

    #[inline(always)]
    pub fn store_in(self, to: &mut [&mut [f64]; 3], at: usize) {
        let [x, y, z] = self.0;
        x.store(to[0], at);
        y.store(to[1], at);
        z.store(to[2], at);
    }

    /// Into a list of all x, then all y, then all z.
    #[inline(always)]
    pub fn store(self, to: &mut [f64], at: usize) {
        let n = to.len() / 3;
        let ([x, y, z], (first, rest)) = (self.0, to.split_at_mut(n));
        x.store(first, at);
        y.store(&mut rest[..n], at);
        z.store(&mut rest[n..], at);
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> Wide<S> {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        a * d + b * e + c * f
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        Wide3([b * f - c * e, c * d - a * f, a * e - b * d])
    }

    /// Unit vectors; 0 stays 0.
    #[inline(always)]
    pub fn normalize_or_zero(self) -> Self {
        let square = self.dot(self);
        let scale = (Wide::splat(square.0, 1.0) / square.sqrt()).where_at_least(square, f64::MIN_POSITIVE);
        self * scale
    }
}

impl<S: Simd> Add for Wide3<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        Wide3([a + d, b + e, c + f])
    }
}

impl<S: Simd> Sub for Wide3<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        Wide3([a - d, b - e, c - f])
    }
}

impl<S: Simd> Mul<Wide<S>> for Wide3<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: Wide<S>) -> Self {
        let [a, b, c] = self.0;
        Wide3([a * by, b * by, c * by])
    }
}

impl<S: Simd> Mul<f64> for Wide3<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: f64) -> Self {
        let [a, b, c] = self.0;
        Wide3([a * by, b * by, c * by])
    }
}
