//! A circle around points.

use crate::Error;
use nalgebra::Vector2;

/// A circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// Its centre.
    pub centre: Vector2<f64>,
    /// Its radius.
    pub radius: f64,
}

/// A circle around finite points, a few percent larger than the smallest one (\[Rit90\]): from two points far apart, it
/// grows as far as each point makes it.
///
/// # Errors
/// [`Error::TooFewPoints`] for no points.
pub fn bounding_circle(points: &[Vector2<f64>]) -> Result<Circle, Error> {
    let Some(first) = points.first() else {
        return Err(Error::TooFewPoints { total: 0, usable: 0, needed: 1 });
    };
    let farthest = |from: &Vector2<f64>| {
        points
            .iter()
            .fold((0.0, *from), |best, p| {
                let d = (p - from).norm_squared();
                if d > best.0 { (d, *p) } else { best }
            })
            .1
    };
    let a = farthest(first);
    let b = farthest(&a);
    let mut circle = Circle { centre: (a + b) / 2.0, radius: (b - a).norm() / 2.0 };
    for p in points {
        let away = p - circle.centre;
        let distance = away.norm();
        if distance > circle.radius {
            let radius = 0.5 * (circle.radius + distance);
            circle.centre += away * ((distance - radius) / distance);
            circle.radius = radius;
        }
    }
    // Earlier points may lie outside by rounding.
    circle.radius = points.iter().map(|p| (p - circle.centre).norm()).fold(circle.radius, f64::max);
    Ok(circle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_all_points_and_is_hardly_too_large() {
        let points: Vec<_> = (0..500)
            .map(f64::from)
            .map(|i| {
                Vector2::new((0.9 * i).cos(), (0.9 * i).sin()) * (i * 0.618).fract()
                    + Vector2::new(50.0, -20.0)
            })
            .collect();
        let circle = bounding_circle(&points).unwrap();
        assert!(points.iter().all(|p| (p - circle.centre).norm() <= circle.radius));
        assert!(circle.radius < 1.1 && (circle.centre - Vector2::new(50.0, -20.0)).norm() < 0.1);
        assert!(bounding_circle(&[]).is_err());
    }
}
