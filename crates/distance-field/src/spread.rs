//! The spread of residuals when some of them are outliers.

/// Median absolute deviation of a normal distribution of unit variance.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_082;

/// The median of some numbers, the lower one of two; 0 of none. Reorders them.
fn median_in_place(values: &mut [f64]) -> f64 {
    quantile_in_place(values, 0.5)
}

/// The value below which a share of the numbers lies; 0 of none. Reorders them.
pub fn quantile_in_place(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the length")]
    let k = ((values.len() - 1) as f64 * share.clamp(0.0, 1.0)) as usize;
    *values.select_nth_unstable_by(k, f64::total_cmp).1
}

/// The spread of distances whose inliers are normally distributed about 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Standard deviation of the inliers.
    pub sigma: f64,
}

impl Spread {
    /// The standard deviation of the inliers among `distances` (not negative), of which nothing is known but that they
    /// are more crowded at 0 than the outliers.
    ///
    /// From above the interval is narrowed to `width` standard deviations until it stays; the outliers in the interval
    /// then are those few that lie there by chance. Reorders the numbers.
    #[must_use]
    pub fn of(distances: &mut [f64], width: f64) -> Self {
        let mut kept = distances.len();
        let mut sigma = f64::INFINITY;
        for _ in 0..50 {
            let next = median_in_place(&mut distances[..kept]) / NORMAL_MEDIAN;
            if next.is_nan() || next >= sigma {
                break;
            }
            sigma = next;
            // Partition: the kept ones to the front.
            let mut front = 0;
            for i in 0..kept {
                if distances[i] <= width * sigma {
                    distances.swap(i, front);
                    front += 1;
                }
            }
            if front == kept {
                break;
            }
            kept = front;
        }
        Self { sigma: if sigma.is_finite() { sigma } else { 0.0 } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of a normal distribution by bisection of its integral (Simpson): no random numbers needed.
    fn normal(n: usize) -> Vec<f64> {
        let (mut out, mut x, mut p) = (Vec::new(), 0.0f64, 0.0);
        let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
        for i in 0..n {
            let goal = (i as f64 + 0.5) / (2.0 * n as f64);
            while p < goal {
                p += density(x + 5e-6) * 1e-5;
                x += 1e-5;
            }
            out.push(x);
        }
        out
    }

    #[test]
    fn outliers_do_not_widen_the_spread() {
        let inliers = normal(2000);
        let mut clean: Vec<f64> = inliers.iter().map(|x| x * 0.01).collect();
        assert!((Spread::of(&mut clean, 4.685).sigma - 0.01).abs() < 1e-4);
        // As many outliers, uniform up to 100 standard deviations.
        let mut mixed: Vec<f64> = inliers.iter().map(|x| x * 0.01).collect();
        mixed.extend((0..2000).map(|i| f64::from(i) / 2000.0));
        let sigma = Spread::of(&mut mixed, 4.685).sigma;
        assert!(sigma > 0.01 && sigma < 0.0112, "{sigma}");
        assert_eq!(Spread::of(&mut [], 3.0).sigma, 0.0);
        assert_eq!(Spread::of(&mut [0.0; 5], 3.0).sigma, 0.0);
    }
}
