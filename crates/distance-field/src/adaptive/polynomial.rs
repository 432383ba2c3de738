//! Tensor products of Lagrange polynomials on the unit cube.

use nalgebra::{SMatrix, SVector};

/// Largest degree along an axis.
pub(super) const MOST: usize = 3;

/// The places of interpolation in `[0, 1]`: the ends, and in between those of Chebyshev and Lobatto.
pub(super) fn places(degree: usize) -> &'static [f64] {
    match degree {
        1 => &[0.0, 1.0],
        2 => &[0.0, 0.5, 1.0],
        _ => &[0.0, 0.25, 0.75, 1.0],
    }
}

/// Values, first and second derivatives of the basis polynomials at `t`.
fn basis(degree: usize, t: f64) -> [[f64; MOST + 1]; 3] {
    let places = places(degree);
    let mut out = [[0.0; MOST + 1]; 3];
    for (i, own) in places.iter().enumerate() {
        // The product Π (t − pⱼ)/(pᵢ − pⱼ) with its derivatives, factor by factor.
        let [mut value, mut first, mut second] = [1.0, 0.0, 0.0];
        for (j, other) in places.iter().enumerate() {
            if i != j {
                let (slope, factor) = (1.0 / (own - other), (t - other) / (own - other));
                second = second * factor + 2.0 * first * slope;
                first = first * factor + value * slope;
                value *= factor;
            }
        }
        (out[0][i], out[1][i], out[2][i]) = (value, first, second);
    }
    out
}

/// Number of coefficients.
pub(super) fn count<const D: usize>(degree: usize) -> usize {
    (0..D).fold(1, |product, _| product * (degree + 1))
}

/// The place of interpolation with a number, the last axis running fastest.
pub(super) fn place<const D: usize>(degree: usize, number: usize) -> SVector<f64, D> {
    let mut rest = number;
    let mut out = SVector::zeros();
    for k in (0..D).rev() {
        out[k] = places(degree)[rest % (degree + 1)];
        rest /= degree + 1;
    }
    out
}

/// Value, gradient and Hessian at a place of the unit cube.
pub(super) fn taylor<const D: usize>(
    degree: usize,
    coefficients: &[f64],
    place: &SVector<f64, D>,
) -> (f64, SVector<f64, D>, SMatrix<f64, D, D>) {
    let rows: [_; D] = std::array::from_fn(|k| basis(degree, place[k]));
    let (mut value, mut gradient, mut hessian) = (0.0, SVector::zeros(), SMatrix::zeros());
    for (number, c) in coefficients.iter().enumerate() {
        let mut at = [0; D];
        let mut rest = number;
        for k in (0..D).rev() {
            at[k] = rest % (degree + 1);
            rest /= degree + 1;
        }
        let product = |orders: [usize; D]| (0..D).fold(*c, |p, k| p * rows[k][orders[k]][at[k]]);
        value += product([0; D]);
        for d in 0..D {
            let mut orders = [0; D];
            orders[d] = 1;
            gradient[d] += product(orders);
            for e in 0..D {
                let mut orders = [0; D];
                orders[d] += 1;
                orders[e] += 1;
                hessian[(d, e)] += product(orders);
            }
        }
    }
    (value, gradient, hessian)
}

/// The value alone.
pub(super) fn value<const D: usize>(degree: usize, coefficients: &[f64], place: &SVector<f64, D>) -> f64 {
    let rows: [_; D] = std::array::from_fn(|k| basis(degree, place[k])[0]);
    let mut sum = 0.0;
    for (number, c) in coefficients.iter().enumerate() {
        let mut rest = number;
        let mut product = *c;
        for k in (0..D).rev() {
            product *= rows[k][rest % (degree + 1)];
            rest /= degree + 1;
        }
        sum += product;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn polynomials_of_the_degree_are_reproduced() {
        for degree in 1..=MOST {
            let power = i32::try_from(degree).unwrap();
            let f = |p: &Vector2<f64>| (1.0 + p.x).powi(power) * (2.0 - p.y).powi(power);
            let coefficients: Vec<f64> =
                (0..count::<2>(degree)).map(|number| f(&place(degree, number))).collect();
            let x = Vector2::new(0.3, 0.8);
            let (found, gradient, hessian) = taylor(degree, &coefficients, &x);
            assert!(
                (found - f(&x)).abs() < 1e-13 && (value(degree, &coefficients, &x) - f(&x)).abs() < 1e-13
            );
            let slope = f64::from(power) * (1.3f64).powi(power - 1) * (1.2f64).powi(power);
            assert!((gradient.x - slope).abs() < 1e-12);
            let mixed = -f64::from(power * power) * (1.3f64 * 1.2).powi(power - 1);
            assert!((hessian[(0, 1)] - mixed).abs() < 1e-11 && hessian[(0, 1)] == hessian[(1, 0)]);
        }
    }
}
