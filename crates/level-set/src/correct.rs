//! Parameters of the points of a contour on a curve, in their order.

use nalgebra::Vector2;
use nurbs_core::{BsplineCurve, ParametricCurve};

/// Steps of Newton's method.
const STEPS: usize = 6;
/// Longest step, as a share of the domain over the number of spans.
const LONGEST: f64 = 0.5;
/// A step, as a share of the domain, that moves nothing.
const SETTLED: f64 = 1e-12;

/// The parameters of the feet of points on a curve over `[0, 1]`, found from given ones and in their order.
///
/// Newton's method, which stays on its strand where another part of the curve is nearer. Where feet would change their order (a curve
/// that turns sharply has several) they are put together in the middle, so that a curve through the points at these parameters does not
/// run back. On a closed curve they may pass its start: the same point has a parameter in every period.
pub(crate) fn in_order(curve: &BsplineCurve<2>, parameters: &[f64], points: &[Vector2<f64>]) -> Vec<f64> {
    let is_periodic = curve.period().is_some();
    let longest = LONGEST / curve.knots().spans().count() as f64;
    let foot = |start: f64, point: &Vector2<f64>| {
        let mut t = start;
        for _ in 0..STEPS {
            let jet = curve.jet(t);
            let residual = jet.point - point;
            let slope = residual.dot(&jet.d1);
            let square = jet.d1.norm_squared();
            let curved = square + residual.dot(&jet.d2);
            // Where the distance has no minimum nearby, the step of Gauss and Newton.
            let step = -slope / if curved > 0.1 * square { curved } else { square };
            if !step.is_finite() {
                break;
            }
            let next = t + step.clamp(-longest, longest);
            let next = if is_periodic { next } else { next.clamp(0.0, 1.0) };
            let moved = (next - t).abs();
            t = next;
            if moved <= SETTLED {
                break;
            }
        }
        t
    };
    let found: Vec<f64> = parameters.iter().zip(points).map(|(&t, point)| foot(t, point)).collect();
    increasing(&found)
}

/// The numbers that do not decrease and are nearest to given ones in the sum of squares (pool adjacent violators).
fn increasing(values: &[f64]) -> Vec<f64> {
    let mut pools: Vec<(f64, usize)> = Vec::with_capacity(values.len());
    for &value in values {
        let mut pool = (value, 1);
        while let Some(&(sum, count)) = pools.last()
            && sum / count as f64 > pool.0 / pool.1 as f64
        {
            pools.pop();
            pool = (pool.0 + sum, pool.1 + count);
        }
        pools.push(pool);
    }
    pools.iter().flat_map(|&(sum, count)| std::iter::repeat_n(sum / count as f64, count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nurbs_core::KnotVector;

    #[test]
    fn numbers_that_decrease_are_put_together() {
        assert_eq!(increasing(&[1.0, 3.0, 2.0, 4.0]), [1.0, 2.5, 2.5, 4.0]);
        assert_eq!(increasing(&[3.0, 2.0, 1.0]), [2.0; 3]);
        assert_eq!(increasing(&[]), [0.0; 0]);
    }

    #[test]
    fn points_of_a_narrow_neck_stay_on_their_strand() {
        // Up one side and down the other, 0.1 apart.
        let net = [[0.0, 0.0], [0.0, 2.0], [0.1, 2.0], [0.1, 0.0]].map(Vector2::from);
        let knots = KnotVector::new(1, vec![0.0, 0.0, 0.49, 0.51, 1.0, 1.0]).unwrap();
        let curve = BsplineCurve::new(knots, net.to_vec(), None).unwrap();
        // A point of the first side that is nearer to the second.
        let points = [[0.0, 0.5], [0.08, 1.0], [0.0, 1.5]].map(Vector2::from);
        let found = in_order(&curve, &[0.1, 0.24, 0.4], &points);
        for (t, point) in found.iter().zip(&points) {
            assert!((curve.point(*t) - Vector2::new(0.0, point.y)).norm() < 1e-9, "{found:?}");
        }
    }
}
