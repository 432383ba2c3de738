//! What a fit returns.

use super::observations::Observations;

/// A fitted shape and how far it stays from the data at their parameters.
///
/// These distances bound the true (orthogonal) ones from above.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted<S> {
    /// The curve or surface.
    pub shape: S,
    /// Root of the (weighted) mean of the squared distances.
    pub rms: f64,
    /// Largest distance, weights left aside.
    pub max: f64,
    /// Index of the data point where it occurs.
    pub max_index: usize,
}

impl<S> Fitted<S> {
    pub(crate) fn new(shape: S, data: &Observations, coefficients: &[f64]) -> Self {
        let (mut sum, mut max, mut max_index) = (0.0, 0.0, 0);
        data.for_residuals(coefficients, |_, slot, residual| {
            let square: f64 = residual.iter().map(|r| r * r).sum();
            sum += data.weights[slot] * square;
            if square > max {
                (max, max_index) = (square, data.order[slot]);
            }
        });
        Self { shape, rms: sum.sqrt(), max: max.sqrt(), max_index }
    }
}

impl<S> std::fmt::Display for Fitted<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "rms {:.6e}, max {:.6e} at data point {}", self.rms, self.max, self.max_index)
    }
}
