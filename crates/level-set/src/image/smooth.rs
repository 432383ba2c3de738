//! Convolution with a Gaussian, and what it does to edges undone.

use crate::Error;
use distance_field::Grid;

/// Standard deviations on each side after which the Gaussian is cut off: the rest is below 1e-9.
const REACH: f64 = 6.0;
/// Variance of the area of a pixel along an axis: that of an even distribution on an interval of length 1.
const PIXEL: f64 = 1.0 / 12.0;

/// Values convolved with a Gaussian of a standard deviation in cells; beyond the border they stay as they are there.
pub(super) fn convolved(grid: &Grid<2>, deviation: f64) -> Result<Grid<2>, Error> {
    if deviation <= 0.0 {
        return Ok(grid.clone());
    }
    let [m, n] = grid.counts();
    let mut weights = Vec::new();
    let mut k = 0.0f64;
    while k <= (REACH * deviation).ceil() {
        weights.push((-0.5 * (k / deviation).powi(2)).exp());
        k += 1.0;
    }
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    let mut values = grid.values().to_vec();
    // Lines of `count` values that are `stride` apart.
    for (lines, count, stride) in [(m, n, 1), (n, m, n)] {
        let next = crate::parallel::map(lines * count, |place| {
            let (line, at) = (place / count, place % count);
            let first = if stride == 1 { line * n } else { line };
            let value = |index: usize| values[first + index * stride];
            let pairs = weights[1..].iter().zip(1..).map(|(weight, k): (_, usize)| {
                weight * (value(at.saturating_sub(k)) + value((at + k).min(count - 1)))
            });
            (weights[0] * value(at) + pairs.sum::<f64>()) / sum
        });
        for (place, value) in next.into_iter().enumerate() {
            let (line, at) = (place / count, place % count);
            values[if stride == 1 { line * n + at } else { line + at * stride }] = value;
        }
    }
    Ok(grid.with_values(values)?)
}

/// The same, with the shift of bent edges undone: `f − (σ² + 1/12)/2 · f_ττ`, the second derivative being that along the contour.
pub(super) fn sharpened(grid: &Grid<2>, deviation: f64) -> Result<Grid<2>, Error> {
    let smooth = convolved(grid, deviation)?;
    let [m, n] = smooth.counts();
    let f = smooth.values();
    let half = 0.5 * (deviation * deviation + PIXEL);
    let values = crate::parallel::map(m * n, |node| {
        let (i, j) = (node / n, node % n);
        let at = |di: usize, dj: usize| {
            let (i, j) = ((i + di).saturating_sub(1).min(m - 1), (j + dj).saturating_sub(1).min(n - 1));
            f[i * n + j]
        };
        let (fx, fy) = (0.5 * (at(2, 1) - at(0, 1)), 0.5 * (at(1, 2) - at(1, 0)));
        let (fxx, fyy) = (at(2, 1) - 2.0 * at(1, 1) + at(0, 1), at(1, 2) - 2.0 * at(1, 1) + at(1, 0));
        let fxy = 0.25 * (at(2, 2) - at(2, 0) - at(0, 2) + at(0, 0));
        let square = fx * fx + fy * fy;
        let along = fxx * fy * fy - 2.0 * fx * fy * fxy + fyy * fx * fx;
        // Where the image is even there is no contour, and nothing to be undone.
        let along = if square > 1e-8 { along / square } else { 0.0 };
        f[node] - half * along
    });
    Ok(smooth.with_values(values)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    fn grid(f: impl Fn(&Vector2<f64>) -> f64) -> Grid<2> {
        Grid::sample(Vector2::repeat(0.5), Vector2::repeat(1.0), [40, 30], f).unwrap()
    }

    #[test]
    fn waves_are_damped_as_the_transform_says() {
        let wave = |p: &Vector2<f64>| (0.4 * p.x).cos() * (0.3 * p.y).sin();
        let smooth = convolved(&grid(wave), 1.2).unwrap();
        let factor = (-0.5f64 * 1.44 * (0.16 + 0.09)).exp();
        let node = 20 * 30 + 15;
        assert!((smooth.values()[node] - factor * wave(&smooth.position(node))).abs() < 1e-5);
    }

    #[test]
    fn a_disc_keeps_its_radius() {
        // The exact convolution of an edge of radius 8 is not needed: only where its middle lies.
        let disc = grid(|p| if (p - Vector2::new(20.0, 15.0)).norm() < 8.0 { -0.5 } else { 0.5 });
        let radius = |grid: &Grid<2>| {
            let field = distance_field::LevelSetField::<2>::new(grid).unwrap();
            let points: Vec<f64> = field.crossings().map(|p| (p - Vector2::new(20.0, 15.0)).norm()).collect();
            points.iter().sum::<f64>() / points.len() as f64
        };
        let moved = radius(&convolved(&disc, 2.0).unwrap());
        let kept = radius(&sharpened(&disc, 2.0).unwrap());
        // The pixels inside make a disc that is a little larger.
        let inside = disc.values().iter().filter(|value| **value < 0.0).count();
        let own = (inside as f64 / std::f64::consts::PI).sqrt();
        assert!((moved - (own - 0.25)).abs() < 0.06, "{moved} {own}");
        assert!((kept - own).abs() < 0.06, "{kept} {own}");
    }
}
