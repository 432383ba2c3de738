//! Orders and basins.

use super::random::Random;
use super::subject::Subject;
use footpoint::local::{LocalOptions, Method};

/// Test points for an order.
const ORDER_POINTS: usize = 400;

/// Pairs of a test point and a start for a basin.
const BASIN_STARTS: usize = 4000;

/// Distance of test points and starts from the ends of the domain.
const MARGIN: f64 = 0.05;

/// Steps of which the last before rounding tell the order.
const ORDER_STEPS: u32 = 15;

const SEED: u64 = 2005;

/// Test points of an order.
pub(crate) struct Order {
    /// Largest distance from the shape, as a share of its size.
    pub(crate) distance: f64,
    /// Distance of the starts from the foot, in parameters.
    pub(crate) near: f64,
    /// Errors below this are rounding.
    pub(crate) rounding: f64,
}

/// The median order of convergence; `None` when fewer than half of the points show three errors above
/// rounding.
pub(crate) fn order<S: Subject>(subject: &S, method: Method, points: &Order) -> Option<f64> {
    let mut random = Random::new(SEED);
    let options = LocalOptions::default()
        .with_method(method)
        .with_max_iterations(ORDER_STEPS)
        .with_parameter_tolerance(0.0);
    let mut orders = Vec::new();
    let mut tried = 0;
    while tried < ORDER_POINTS {
        let exact = subject.parameter(&mut random, MARGIN);
        let distance = random.between(-points.distance, points.distance);
        let Some(x) = subject.above(exact, distance) else { continue };
        let start = subject.beside(exact, points.near, &mut random);
        tried += 1;
        let errors = subject.errors(x, start, exact, &options);
        let last = errors.windows(3).rfind(|e| e[2] > points.rounding && e[1] < e[0] && e[2] < e[1]);
        orders.extend(last.map(|e| (e[2] / e[1]).ln() / (e[1] / e[0]).ln()));
    }
    orders.sort_by(f64::total_cmp);
    (2 * orders.len() >= tried).then(|| orders[orders.len() / 2])
}

/// From how many starts a method reaches a footpoint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Basin {
    /// Share of all starts.
    pub(crate) reached: f64,
    /// Steps of those that do, on average.
    pub(crate) mean: f64,
    /// Most steps of those that do.
    pub(crate) most: u32,
}

/// Measures a basin: test points up to `distance` (a share of the size) above inner points, or anywhere if
/// that is infinite.
pub(crate) fn basin<S: Subject>(
    subject: &S,
    method: Method,
    distance: f64,
    iterate: fn(&S, S::Point, S::Parameter, &LocalOptions) -> Option<u32>,
) -> Basin {
    let mut random = Random::new(SEED);
    let options = LocalOptions::default().with_method(method);
    let (mut reached, mut total, mut most) = (0_u32, 0_u64, 0);
    let mut tried = 0;
    while tried < BASIN_STARTS {
        let x = if distance.is_finite() {
            let foot = subject.parameter(&mut random, MARGIN);
            subject.above(foot, random.between(-distance, distance))
        } else {
            Some(subject.anywhere(&mut random))
        };
        let Some(x) = x else { continue };
        let start = subject.parameter(&mut random, 0.0);
        tried += 1;
        if let Some(steps) = iterate(subject, x, start, &options) {
            reached += 1;
            total += u64::from(steps);
            most = most.max(steps);
        }
    }
    Basin { reached: f64::from(reached) / tried as f64, mean: total as f64 / f64::from(reached.max(1)), most }
}
