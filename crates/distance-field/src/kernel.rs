//! Robust kernels: what a residual is worth as a function of its size.

/// A loss `ρ(s)` of the squared residual `s = (d/c)²`, `c` the scale: near 0 all are the square, `ρ ≈ s`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Kernel {
    /// Least squares, `ρ = s`.
    #[default]
    Square,
    /// The square inside, the absolute value outside: `ρ = 2√s − 1` for `s > 1`. Convex.
    Huber,
    /// `ρ = ln(1 + s)`. Distant points keep a little weight.
    Cauchy,
    /// `ρ = 1 − exp(−s)`. Distant points lose their weight smoothly.
    Welsch,
    /// `ρ = (1 − (1 − s)³)/3` for `s < 1`. Points beyond the scale have no weight at all (biweight).
    Tukey,
}

impl Kernel {
    /// Every kernel.
    pub const ALL: [Self; 5] = [Self::Square, Self::Huber, Self::Cauchy, Self::Welsch, Self::Tukey];

    /// The scale for which an estimate has 95 % of the efficiency of least squares, in standard deviations of a normal
    /// distribution.
    #[must_use]
    pub fn tuning(self) -> f64 {
        match self {
            Self::Square => f64::INFINITY,
            Self::Huber => 1.345,
            Self::Cauchy => 2.385,
            Self::Welsch => 2.985,
            Self::Tukey => 4.685,
        }
    }

    /// `ρ(s)`, `s = (d/c)²`.
    #[must_use]
    pub fn loss(self, s: f64) -> f64 {
        match self {
            Self::Square => s,
            Self::Huber if s <= 1.0 => s,
            Self::Huber => 2.0 * s.sqrt() - 1.0,
            Self::Cauchy => s.ln_1p(),
            Self::Welsch => -(-s).exp_m1(),
            Self::Tukey if s >= 1.0 => 1.0 / 3.0,
            Self::Tukey => (1.0 - (1.0 - s).powi(3)) / 3.0,
        }
    }

    /// The weight `ρ'(s)`, between 0 and 1.
    #[must_use]
    pub fn weight(self, s: f64) -> f64 {
        match self {
            Self::Square => 1.0,
            Self::Huber if s <= 1.0 => 1.0,
            Self::Huber => 1.0 / s.sqrt(),
            Self::Cauchy => 1.0 / (1.0 + s),
            Self::Welsch => (-s).exp(),
            Self::Tukey if s >= 1.0 => 0.0,
            Self::Tukey => (1.0 - s).powi(2),
        }
    }

    /// `ρ''(s)`, never positive: how the weight changes with the residual, which Newton's method has to know.
    #[must_use]
    pub fn weight_slope(self, s: f64) -> f64 {
        match self {
            Self::Square => 0.0,
            Self::Huber if s <= 1.0 => 0.0,
            Self::Huber => -0.5 / (s * s.sqrt()),
            Self::Cauchy => -1.0 / (1.0 + s).powi(2),
            Self::Welsch => -(-s).exp(),
            Self::Tukey if s >= 1.0 => 0.0,
            Self::Tukey => -2.0 * (1.0 - s),
        }
    }

    /// The name used in files and options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Square => "square",
            Self::Huber => "huber",
            Self::Cauchy => "cauchy",
            Self::Welsch => "welsch",
            Self::Tukey => "tukey",
        }
    }
}

impl std::fmt::Display for Kernel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_agree_with_differences() {
        for kernel in Kernel::ALL {
            for s in [0.01, 0.3, 0.9, 1.1, 2.5, 40.0] {
                let h = 1e-5;
                let first = (kernel.loss(s + h) - kernel.loss(s - h)) / (2.0 * h);
                let second = (kernel.weight(s + h) - kernel.weight(s - h)) / (2.0 * h);
                assert!((first - kernel.weight(s)).abs() < 1e-8, "{kernel} {s}");
                assert!((second - kernel.weight_slope(s)).abs() < 1e-8, "{kernel} {s}");
            }
            assert_eq!((kernel.loss(0.0), kernel.weight(0.0)), (0.0, 1.0), "{kernel}");
        }
    }
}
