//! An order of points in which neighbours in space are near in memory too.

use nalgebra::Point;

/// Fewest points for which sorting pays.
const LEAST: usize = 2048;
/// Bits per axis: cells of a thousandth of the size.
const BITS: u32 = 10;

/// The indices of points in the plane or in space along a curve that fills it (Morton's): points after each other are near each
/// other, so that what is kept and asked for in this order is found in the caches of the processor.
///
/// `None` where it would not pay, for fewer than 2048 points, or for points that are in this order already, or beyond 32-bit
/// indices. Points that are not finite are somewhere.
#[must_use]
pub fn spatial_order<const D: usize>(points: &[Point<f64, D>]) -> Option<Vec<u32>> {
    if points.len() < LEAST || u32::try_from(points.len()).is_err() || D > 3 {
        return None;
    }
    let (mut min, mut max) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for point in points.iter().filter(|point| point.iter().all(|value| value.is_finite())) {
        for axis in 0..D {
            min[axis] = min[axis].min(point[axis]);
            max[axis] = max[axis].max(point[axis]);
        }
    }
    let size = (0..D).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
    let scale = f64::from(1u32 << BITS) / size;
    let code = |point: &Point<f64, D>| {
        let mut code = 0u32;
        for (axis, &value) in (0u32..).zip(point.iter()) {
            let low = min[axis as usize];
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "any cell will do for NaN"
            )]
            let cell = (((value - low) * scale) as u32).min((1 << BITS) - 1);
            for bit in 0..BITS {
                code |= ((cell >> bit) & 1) << (bit * 3 + axis);
            }
        }
        code
    };
    let mut order: Vec<(u32, u32)> =
        points.iter().zip(0u32..).map(|(point, index)| (code(point), index)).collect();
    if order.is_sorted() {
        return None;
    }
    order.sort_unstable();
    Some(order.into_iter().map(|(_, index)| index).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_a_permutation_whatever_the_points() {
        let mut points: Vec<_> =
            (0..3000u32).map(|i| Point::from([f64::from(i * 7919 % 3000), 0.5])).collect();
        points[7] = Point::from([f64::NAN, f64::INFINITY]);
        let mut order = spatial_order(&points).unwrap();
        order.sort_unstable();
        assert!(order.into_iter().eq(0..3000));
        // What is in order needs none.
        for points in [vec![Point::from([1.0, 1.0]); 3000], vec![Point::from([f64::NAN; 2]); 3000]] {
            assert_eq!(spatial_order(&points), None);
        }
        assert_eq!(spatial_order(&[Point::from([0.0; 3])]), None);
    }
}
