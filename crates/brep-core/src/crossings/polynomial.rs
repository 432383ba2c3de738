//! Real zeros of polynomials of low degree.

/// Halvings of an interval at most.
const MAX_DEPTH: u32 = 50;
/// Steps of the bisection.
const STEPS: usize = 80;
/// Share of the largest coefficient that counts as nothing.
const NOTHING: f64 = 1e-15;

/// Zeros of `a t² + b t + c`, without cancellation; a double one once.
pub(super) fn quadratic(a: f64, b: f64, c: f64) -> Vec<f64> {
    // Coefficients that rounding leaves of a line along a generator make no zero.
    let linear = || if b == 0.0 { Vec::new() } else { vec![-c / b] };
    if a.abs() <= NOTHING * b.abs() || a == 0.0 {
        return linear();
    }
    let square = b * b - 4.0 * a * c;
    if square < 0.0 || !square.is_finite() {
        return Vec::new();
    }
    let q = -0.5 * (b + square.sqrt().copysign(b));
    if q == 0.0 {
        return vec![0.0];
    }
    vec![q / a, c / q]
}

/// Zeros in `[−1, 1]` of `f[0] + f[1] s + … + f[4] s⁴`, found by subdivision of its Bernstein form.
pub(super) fn roots(f: &[f64; 5]) -> Vec<f64> {
    // s = 2 t − 1.
    let mut power = [0.0; 5];
    for (k, value) in f.iter().enumerate() {
        for j in 0..=k {
            let sign = if (k - j) % 2 == 0 { 1.0 } else { -1.0 };
            power[j] += value * sign * binomial(k, j) * (1u32 << j) as f64;
        }
    }
    let mut bernstein = [0.0; 5];
    for (i, b) in bernstein.iter_mut().enumerate() {
        *b = (0..=i).map(|k| power[k] * binomial(i, k) / binomial(4, k)).sum();
    }
    let scale = bernstein.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
    let mut out = Vec::new();
    isolate(bernstein, [0.0, 1.0], scale * NOTHING, 0, &mut out);
    out.sort_by(f64::total_cmp);
    out.dedup_by(|a, b| (*a - *b).abs() <= 1e-14);
    out.into_iter().map(|t| 2.0 * t - 1.0).collect()
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product::<f64>().round()
}

fn isolate(b: [f64; 5], [low, high]: [f64; 2], noise: f64, depth: u32, out: &mut Vec<f64>) {
    let signs: Vec<bool> = b.iter().filter(|c| c.abs() > noise).map(|c| *c > 0.0).collect();
    let changes = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
    if signs.len() == b.len() && changes == 0 {
        return;
    }
    let middle = 0.5 * (low + high);
    if depth >= MAX_DEPTH || signs.is_empty() {
        out.push(middle);
        return;
    }
    if signs.len() == b.len() && changes == 1 {
        out.push(bisected(&b, [low, high]));
        return;
    }
    let (left, right) = halves(&b);
    isolate(left, [low, middle], noise, depth + 1, out);
    isolate(right, [middle, high], noise, depth + 1, out);
}

fn halves(b: &[f64; 5]) -> ([f64; 5], [f64; 5]) {
    let (mut left, mut right, mut row) = ([0.0; 5], [0.0; 5], *b);
    for k in 0..5 {
        (left[k], right[4 - k]) = (row[0], row[4 - k]);
        for i in 0..4 - k {
            row[i] = 0.5 * (row[i] + row[i + 1]);
        }
    }
    (left, right)
}

fn value(b: &[f64; 5], t: f64) -> f64 {
    let mut row = *b;
    for k in (1..5).rev() {
        for i in 0..k {
            row[i] = (1.0 - t) * row[i] + t * row[i + 1];
        }
    }
    row[0]
}

/// The only zero of a piece whose ends have different signs.
fn bisected(b: &[f64; 5], [low, high]: [f64; 2]) -> f64 {
    let (mut from, mut to) = (0.0, 1.0);
    for _ in 0..STEPS {
        let middle = 0.5 * (from + to);
        if middle <= from || middle >= to {
            break;
        }
        if (value(b, middle) > 0.0) == (b[0] > 0.0) {
            from = middle;
        } else {
            to = middle;
        }
    }
    low + (high - low) * 0.5 * (from + to)
}

/// A zero of a smooth function near a place, by a few steps of the secant method; the place itself where these lead away.
pub(super) fn polished(f: &impl Fn(f64) -> f64, s: f64) -> f64 {
    let (mut a, mut b) = (s, s + 1e-7);
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..6 {
        let slope = (fb - fa) / (b - a);
        let next = b - fb / slope;
        if !next.is_finite() || (next - s).abs() > 1e-4 {
            break;
        }
        (a, fa, b) = (b, fb, next);
        fb = f(b);
        if fb == 0.0 || a == b {
            break;
        }
    }
    if fb.abs() <= f(s).abs() && (b - s).abs() <= 1e-4 { b } else { s }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_of_known_polynomials() {
        assert_eq!(quadratic(1.0, -3.0, 2.0), [2.0, 1.0]);
        assert!(quadratic(1.0, 0.0, 1.0).is_empty() && quadratic(0.0, 0.0, 1.0).is_empty());
        assert_eq!(quadratic(0.0, 2.0, 1.0), [-0.5]);
        // One of the zeros cancels in the usual formula.
        assert!(quadratic(1.0, -1e8, 1.0).iter().any(|t| (t - 1e-8).abs() < 1e-22));
        // (s² − 1/4)(s − 0.9)(s + 2)
        let found = roots(&[0.45, -0.275, -2.05, 1.1, 1.0]);
        assert_eq!(found.len(), 3, "{found:?}");
        for (a, b) in found.iter().zip([-0.5, 0.5, 0.9]) {
            assert!((a - b).abs() < 1e-12, "{found:?}");
        }
        assert!(roots(&[1.0, 0.0, 0.0, 0.0, 1.0]).is_empty());
    }
}
