//! Which of two poses the same points fit better.

/// Distances in standard deviations of the noise beyond which they count alike.
const CUT: f64 = 5.0;
/// The distance beyond which they count alike, at least and at most, as shares of the size of the model; and the distance that is none.
const NARROWEST: f64 = 1e-3;
const WIDEST: f64 = 0.012;
const NONE: f64 = 1e-5;
/// Evidence from which one pose is better: 1 of 4000 differences of chance are larger.
const CLEAR: f64 = 3.5;

/// A comparison of two poses, point by point.
///
/// Where a part nearly has a symmetry, most points lie on the model in both poses, and a few in one of them alone. Those few decide, however
/// small a share they are: of the differences of the squared distances, with a limit, the sum is compared with its standard deviation if they
/// were chance, `Σ δ / √Σ δ²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// How much the points speak for the second pose, in standard deviations; negative where they speak for the first.
    pub evidence: f64,
}

impl Comparison {
    /// Of the distances of the same points in two poses, which may have any sign; those that are not finite count as far.
    ///
    /// `size` is that of the model.
    #[must_use]
    pub fn of(first: &[f64], second: &[f64], size: f64) -> Self {
        let limit = [first, second].map(|all| CUT * spread(all)).into_iter().fold(f64::INFINITY, f64::min);
        let limit = limit.clamp(NARROWEST * size, WIDEST * size);
        let cost = |distance: f64| {
            let share = distance.abs() / limit;
            if distance.abs() <= NONE * size {
                0.0
            } else if share < 1.0 {
                share * share
            } else {
                1.0
            }
        };
        let (sum, squares) = first.iter().zip(second).fold((0.0, 0.0), |(sum, squares), (a, b)| {
            let difference = cost(*a) - cost(*b);
            (sum + difference, squares + difference * difference)
        });
        Self { evidence: if squares > 0.0 { sum / f64::sqrt(squares) } else { 0.0 } }
    }

    /// Whether the points fit clearly better in the second pose.
    #[must_use]
    pub fn is_second_better(&self) -> bool {
        self.evidence > CLEAR
    }

    /// Whether they fit clearly better in the first.
    #[must_use]
    pub fn is_first_better(&self) -> bool {
        self.evidence < -CLEAR
    }
}

/// 1.48 times the median of distances.
fn spread(distances: &[f64]) -> f64 {
    let mut all: Vec<f64> = distances.iter().map(|distance| distance.abs()).collect();
    let middle = all.len() / 2;
    if all.is_empty() { 0.0 } else { 1.4826 * *all.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
