//! The Gauss-Kronrod pair of 7 and 15 points.
//!
//! The 7 nodes of the Gauss rule are among the 15 of the Kronrod rule, so the difference of the two,
//! an error estimate, costs nothing (\[PDUK83\]).

/// Nodes on `[0, 1)` of the symmetric rule on `[−1, 1]`, outermost first; odd ones belong to Gauss too.
const NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];

/// Kronrod weights of [`NODES`].
const KRONROD: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_56,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_82,
];

/// Gauss weights of the nodes 1, 3, 5, 7.
const GAUSS: [f64; 4] =
    [0.129_484_966_168_869_7, 0.279_705_391_489_276_64, 0.381_830_050_505_118_9, 0.417_959_183_673_469_4];

/// A node on `[−1, 1]` with its weights in the two rules.
#[derive(Clone, Copy)]
pub(super) struct Node {
    pub(super) x: f64,
    pub(super) kronrod: f64,
    pub(super) gauss: f64,
}

/// All 15 nodes in increasing order.
pub(super) fn nodes() -> [Node; 15] {
    std::array::from_fn(|i| {
        let (k, sign) = if i < 8 { (i, -1.0) } else { (14 - i, 1.0) };
        let gauss = if k % 2 == 1 { GAUSS[k / 2] } else { 0.0 };
        Node { x: sign * NODES[k], kronrod: KRONROD[k], gauss }
    })
}

/// Integral of `f` over `[a, b]` and an estimate of its error.
pub(super) fn integrate(f: impl Fn(f64) -> f64, a: f64, b: f64) -> (f64, f64) {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let values = nodes().map(|node| (node, f(middle + half * node.x)));
    let kronrod: f64 = values.iter().map(|(node, y)| node.kronrod * y).sum();
    let gauss: f64 = values.iter().map(|(node, y)| node.gauss * y).sum();
    let spread: f64 = values.iter().map(|(node, y)| node.kronrod * (y - 0.5 * kronrod).abs()).sum();
    (half * kronrod, half.abs() * error_estimate((kronrod - gauss).abs(), spread))
}

/// Error of the Kronrod sum from its difference to the Gauss sum, scaled by the variation of the
/// integrand (\[PDUK83\]): the difference itself is the error of the much weaker Gauss rule.
pub(super) fn error_estimate(difference: f64, spread: f64) -> f64 {
    if spread > 0.0 && difference > 0.0 {
        spread * (200.0 * difference / spread).powf(1.5).min(1.0)
    } else {
        difference
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_for_polynomials_of_degree_22() {
        for n in 0..=22 {
            let (value, _) = integrate(|x| x.powi(n), -0.5, 1.0);
            let exact = (1.0 - (-0.5_f64).powi(n + 1)) / f64::from(n + 1);
            assert!((value - exact).abs() < 2e-15, "{n}: {value} {exact}");
        }
        let gauss: f64 = nodes().iter().map(|n| n.gauss * n.x.powi(12)).sum();
        assert!((gauss - 2.0 / 13.0).abs() < 1e-15);
    }
}
