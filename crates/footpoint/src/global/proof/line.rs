//! Lower bounds for polynomials of one variable: pieces of curves, edges of patches.

use crate::global::arithmetic::bernstein::basis_rows;
use crate::global::arithmetic::lanes::{Lanes, Row, WIDTH, dot};

/// Halvings after which an interval is left as it is.
const MAX_DEPTH: u32 = 40;

/// Parts that are examined before the rest is left as it is.
const MAX_PARTS: u32 = 4096;

/// Bernstein coefficients on a part of `[0, 1]`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment<const K: usize> {
    pub(crate) coefficients: [[f64; WIDTH]; K],
    pub(crate) start: f64,
    pub(crate) length: f64,
    pub(crate) depth: u32,
}

impl<const K: usize> Segment<K> {
    /// The whole of `[0, 1]`.
    #[inline(always)]
    pub(crate) fn unit(row: &Row<K>) -> Self {
        Self { coefficients: row.map(|lanes| lanes.0), start: 0.0, length: 1.0, depth: 0 }
    }
}

/// What is known about the sign of a polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LineProof {
    /// Nowhere below `−noise`.
    Holds,
    /// Below `−noise` at this parameter.
    Below(f64),
    /// Not decided; nowhere below this value.
    Unresolved(f64),
}

/// Decides whether a polynomial of degree `n` is nonnegative on `[0, 1]`, up to `noise`.
///
/// Places whose values may be at most `tie_level` are reported to `tie`, with the interval in which there is no other
/// minimum. A parameter to which `skip` says yes
/// has been examined without finding anything better: it is not reported as below again.
#[inline(always)]
pub(crate) fn prove_line<const K: usize>(
    whole: Segment<K>,
    n: usize,
    noise: f64,
    tie_level: f64,
    stack: &mut Vec<Segment<K>>,
    tie: &mut impl FnMut(f64, [f64; 2]),
    skip: &mut impl FnMut(f64) -> bool,
) -> LineProof {
    stack.clear();
    stack.push(whole);
    let mut unresolved = f64::INFINITY;
    let mut parts = 0;
    while let Some(segment) = stack.pop() {
        parts += 1;
        let c = &segment.coefficients.as_flattened()[..=n];
        let parameter = |s: f64| segment.start + s * segment.length;
        let (mut argmin, mut min) = (0, f64::INFINITY);
        for (j, &value) in c.iter().enumerate() {
            if value < min {
                (argmin, min) = (j, value);
            }
        }
        let guess = argmin as f64 / n as f64;
        if min >= -noise {
            if min <= tie_level {
                tie(parameter(guess), [parameter(guess); 2]);
                for (end, s) in [(0, 0.0), (n, 1.0)] {
                    if end != argmin && c[end] <= tie_level {
                        tie(parameter(s), [parameter(s); 2]);
                    }
                }
            }
            continue;
        }
        // The end coefficients are values of the polynomial: a minimum there is exact.
        if argmin == 0 || argmin == n {
            if !skip(parameter(guess)) {
                return LineProof::Below(parameter(guess));
            }
            // Known not to be better: rounding errors only.
            if monotone(c) {
                continue;
            }
        }
        let curvature = (0..n - 1).map(|j| c[j] - 2.0 * c[j + 1] + c[j + 2]).fold(f64::INFINITY, f64::min);
        if curvature > 0.0 && n >= 2 {
            let (s, value, bound) = minimize_convex(
                &segment.coefficients.map(Lanes),
                n,
                curvature * (n * (n - 1)) as f64,
                guess,
                noise,
            );
            if value < -noise && !skip(parameter(s)) {
                return LineProof::Below(parameter(s));
            }
            if bound >= -noise || value < -noise {
                if bound <= tie_level {
                    tie(parameter(s), [parameter(0.0), parameter(1.0)]);
                }
                continue;
            }
        }
        if segment.depth >= MAX_DEPTH || parts > MAX_PARTS {
            unresolved = unresolved.min(min);
            continue;
        }
        let (low, high) = halve(&segment, n);
        stack.push(high);
        stack.push(low);
    }
    if unresolved.is_finite() { LineProof::Unresolved(unresolved) } else { LineProof::Holds }
}

fn monotone(c: &[f64]) -> bool {
    c.windows(2).all(|w| w[0] <= w[1]) || c.windows(2).all(|w| w[0] >= w[1])
}

/// Minimum of a convex polynomial with second derivative at least `strength`: place, value, lower bound.
#[inline(always)]
fn minimize_convex<const K: usize>(
    row: &Row<K>,
    n: usize,
    strength: f64,
    guess: f64,
    noise: f64,
) -> (f64, f64, f64) {
    let mut s = guess;
    let mut result = (s, f64::INFINITY, f64::NEG_INFINITY);
    for _ in 0..20 {
        let basis = basis_rows::<K>(n, s);
        let (value, slope, bend) = (dot(row, &basis[0]), dot(row, &basis[1]), dot(row, &basis[2]));
        let blocked = (s <= 0.0 && slope > 0.0) || (s >= 1.0 && slope < 0.0);
        let slope = if blocked { 0.0 } else { slope };
        let bound = value - 0.5 * slope * slope / strength;
        if value < result.1 {
            result = (s, value, bound);
        }
        if bound >= -noise || value < -noise || slope == 0.0 {
            break;
        }
        let next = (s - slope / bend.max(strength)).clamp(0.0, 1.0);
        if next == s {
            // Converged to rounding: the value is the minimum.
            result.2 = result.2.max(value - noise);
            break;
        }
        s = next;
    }
    result
}

#[inline(always)]
pub(crate) fn halve<const K: usize>(segment: &Segment<K>, n: usize) -> (Segment<K>, Segment<K>) {
    let half = 0.5 * segment.length;
    let depth = segment.depth + 1;
    let mut low = Segment { length: half, depth, ..*segment };
    let mut high = Segment { start: segment.start + half, length: half, depth, ..*segment };
    let (a, b) = (low.coefficients.as_flattened_mut(), high.coefficients.as_flattened_mut());
    for level in 0..n {
        a[level] = b[0];
        for j in 0..n - level {
            b[j] = 0.5 * (b[j] + b[j + 1]);
        }
    }
    a[n] = b[0];
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prove(c: &[f64]) -> LineProof {
        let mut row = [0.0; WIDTH];
        row[..c.len()].copy_from_slice(c);
        let whole = Segment::unit(&[Lanes(row)]);
        prove_line(whole, c.len() - 1, 1e-14, 0.0, &mut Vec::new(), &mut |_, _| (), &mut |_| false)
    }

    #[test]
    fn signs_of_quadratics() {
        // (s − 1/2)² + e in Bernstein form: [1/4, −1/4, 1/4] + e.
        assert_eq!(prove(&[0.2501, -0.2499, 0.2501]), LineProof::Holds);
        assert!(matches!(prove(&[0.2499, -0.2501, 0.2499]), LineProof::Below(s) if (s - 0.5).abs() < 0.02));
        assert!(matches!(prove(&[1.0, 2.0, -1.0]), LineProof::Below(s) if s == 1.0));
    }

    #[test]
    fn signs_of_a_wave() {
        // Two minima; the second one dips below zero.
        assert!(matches!(prove(&[1.0, -2.0, 4.0, -3.7, 1.0]), LineProof::Below(_)));
        assert_eq!(prove(&[2.0, -0.9, 4.0, -0.9, 2.0]), LineProof::Holds);
    }
}
