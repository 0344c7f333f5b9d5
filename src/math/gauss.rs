//! Gauss-Legendre quadrature on [0, 1].
//! Source: Golub & Welsch's rule, here with the nodes as roots of the Legendre polynomial by
//! Newton's method from the Chebyshev guess (Abramowitz & Stegun 25.4.29).

/// Nodes in (0, 1), ascending, with their weights (sum 1). Exact for polynomials of degree
/// `2 order - 1`. Good to round-off for orders up to about 100.
pub fn rule(order: usize) -> Vec<(f64, f64)> {
    let n = order as f64;
    (0..order)
        .map(|k| {
            let mut x = -(std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..20 {
                let (value, d) = legendre(order, x);
                slope = d;
                let step = value / d;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Value and derivative of the Legendre polynomial of degree `n` at `x` in (-1, 1).
pub fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut p0, mut p1) = (1.0, x);
    if n == 0 {
        return (1.0, 0.0);
    }
    for k in 2..=n {
        let k = k as f64;
        (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
    }
    (p1, n as f64 * (p0 - x * p1) / (1.0 - x * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_twice_the_order_are_exact() {
        for order in 1..=24 {
            let rule = rule(order);
            for degree in 0..2 * order {
                let sum: f64 = rule.iter().map(|&(x, w)| w * x.powi(degree as i32)).sum();
                let exact = 1.0 / (degree as f64 + 1.0);
                assert!((sum - exact).abs() < 4e-15, "order {order} degree {degree}: {sum} against {exact}");
            }
        }
    }

    #[test]
    fn one_degree_more_is_not_exact() {
        let sum: f64 = rule(3).iter().map(|&(x, w)| w * x.powi(6)).sum();
        assert!((sum - 1.0 / 7.0).abs() > 1e-5);
    }
}
