//! The algebraic sphere that fits points with normals best, weighted by their distances from a place.

use super::jet::{Jet, dot};
use crate::implicit::Taylor;
use nalgebra::Vector3;

/// Fewest points that a sphere is fitted to.
const FEWEST: usize = 4;
/// Spread of the points, as a share of the squared reach of their weights, below which they count as one point.
const SPREAD: f64 = 1e-8;

/// A point of a cloud as the fit sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Relative to some origin nearby.
    pub(super) point: Vector3<f64>,
    /// Unit length.
    pub(super) normal: Vector3<f64>,
    /// Distance at which its weight is 0.
    pub(super) reach: f64,
}

/// What a fit at a place tells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// The function whose zero set is the surface, with the derivatives of the fit as the place moves.
    pub(super) taylor: Taylor<3>,
    /// Where the mean of the points lies as seen from the place, as a share of the mean reach.
    pub(super) offset: Vector3<f64>,
}

/// `u(x) = c + l·x + q |x|²` at the place, with the coefficients that make `∇u` follow the normals and then `u` vanish at the
/// points, each in the sense of least squares with weights `(1 − |p − x|²/h²)⁴` (\[GG07, sec. 4\]).
///
/// `None` where fewer than four points have weight, or all that have lie together.
pub(super) fn fit(place: &Vector3<f64>, samples: impl Iterator<Item = Sample>) -> Option<Fit> {
    let mut total = Jet::ZERO;
    let (mut points, mut normals) = ([Jet::ZERO; 3], [Jet::ZERO; 3]);
    let (mut heights, mut squares, mut reach, mut count) = (Jet::ZERO, Jet::ZERO, 0.0, 0);
    for Sample { point, normal, reach: h } in samples {
        let away = place - point;
        let h_sq = h * h;
        let rest = 1.0 - away.norm_squared() / h_sq;
        if rest.is_nan() || rest <= 0.0 {
            continue;
        }
        count += 1;
        let mut weight = Jet::constant(rest.powi(4));
        weight.gradient = away * (-8.0 * rest.powi(3) / h_sq);
        weight.hessian = away * away.transpose() * (48.0 * rest * rest / (h_sq * h_sq));
        for k in 0..3 {
            weight.hessian[(k, k)] -= 8.0 * rest.powi(3) / h_sq;
        }
        total.add_scaled(&weight, 1.0);
        for k in 0..3 {
            points[k].add_scaled(&weight, point[k]);
            normals[k].add_scaled(&weight, normal[k]);
        }
        heights.add_scaled(&weight, point.dot(&normal));
        squares.add_scaled(&weight, point.norm_squared());
        reach += weight.value * h;
    }
    if count < FEWEST {
        return None;
    }
    let inverse = total.reciprocal();
    let mean = points.map(|sum| sum * inverse);
    let mean_normal = normals.map(|sum| sum * inverse);
    let spread = squares * inverse - dot(&mean, &mean);
    let reach = reach * inverse.value;
    let is_spread = spread.value > SPREAD * reach * reach;
    if !is_spread {
        return None;
    }
    let bend = heights * inverse - dot(&mean, &mean_normal);
    let q = (bend * spread.reciprocal()).scale(0.5);
    let linear = [0, 1, 2].map(|k| mean_normal[k] - (q * mean[k]).scale(2.0));
    let constant = Jet::ZERO - dot(&linear, &mean) - q * squares * inverse;
    let x = Jet::coordinates(place);
    let u = constant + dot(&linear, &x) + q * dot(&x, &x);
    let is_finite = u.value.is_finite() && u.gradient.iter().chain(u.hessian.iter()).all(|c| c.is_finite());
    is_finite.then(|| Fit {
        taylor: Taylor { value: u.value, gradient: u.gradient, hessian: u.hessian },
        offset: (Vector3::from_fn(|k, _| mean[k].value) - place) / reach,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere_samples() -> Vec<Sample> {
        (0..60)
            .map(|i| {
                let (z, angle) = (1.0 - f64::from(i) / 90.0, 2.4 * f64::from(i));
                let ring = (1.0 - z * z).sqrt();
                let normal = Vector3::new(ring * angle.cos(), ring * angle.sin(), z);
                Sample { point: normal * 2.0, normal, reach: 1.5 }
            })
            .collect()
    }

    #[test]
    fn a_sphere_is_reproduced() {
        let samples = sphere_samples();
        let place = Vector3::new(0.3, -0.2, 2.1);
        let found = fit(&place, samples.iter().copied()).unwrap();
        // u = (|x|² − r²)/(2 r) wherever it is looked at, so its derivatives are those of the sphere.
        let exact = (place.norm_squared() - 4.0) / 4.0;
        assert!((found.taylor.value - exact).abs() < 1e-12, "{}", found.taylor.value);
        assert!((found.taylor.gradient - place / 2.0).norm() < 1e-11);
        assert!((found.taylor.hessian - nalgebra::Matrix3::identity() / 2.0).norm() < 1e-9);
    }

    #[test]
    fn derivatives_are_those_of_the_moving_fit() {
        // Bumpy normals, so that the coefficients change with the place.
        let samples: Vec<_> = sphere_samples()
            .into_iter()
            .map(|s| {
                let tilt = Vector3::new((3.0 * s.point.x).sin(), (5.0 * s.point.y).cos(), 0.0) * 0.2;
                Sample { normal: (s.normal + tilt).normalize(), reach: 1.2 + 0.2 * s.point.x, ..s }
            })
            .collect();
        let at = |p: &Vector3<f64>| fit(p, samples.iter().copied()).unwrap().taylor;
        let (place, step) = (Vector3::new(0.3, -0.2, 2.1), 1e-5);
        let here = at(&place);
        for k in 0..3 {
            let mut ahead = place;
            ahead[k] += step;
            let mut back = place;
            back[k] -= step;
            let (ahead, back) = (at(&ahead), at(&back));
            assert!(((ahead.value - back.value) / (2.0 * step) - here.gradient[k]).abs() < 1e-8);
            let column = (ahead.gradient - back.gradient) / (2.0 * step);
            assert!((column - here.hessian.column(k)).norm() < 1e-7, "{column} {}", here.hessian);
        }
    }

    #[test]
    fn too_few_points_or_one_point_have_no_sphere() {
        let one = Sample { point: Vector3::x(), normal: Vector3::x(), reach: 1.0 };
        assert!(fit(&Vector3::x(), std::iter::repeat_n(one, 3)).is_none());
        assert!(fit(&Vector3::x(), std::iter::repeat_n(one, 30)).is_none());
        assert!(fit(&Vector3::repeat(f64::NAN), sphere_samples().into_iter()).is_none());
    }
}
