//! The surface near a point of a cloud: a polynomial over the tangent plane.
//!
//! A scan touches the true surface at its points only. The tangent plane at the nearest of them is off by `κ h²/2` at half
//! the spacing `h`, always to the same side where the shape is convex; a cubic is off by the order `h⁴`. This is what lets two
//! scans without a common point agree to a millionth of their size.

use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

/// Coefficients of a polynomial of degree four in two variables:
/// `1, u, v, u², uv, v², u³, u²v, uv², v³, u⁴, u³v, u²v², uv³, v⁴`.
const TERMS: usize = 15;

/// Coefficients of a polynomial, and the points that it takes; with fewer points a plane is fitted.
const QUARTIC: [usize; 2] = [15, 22];
const CUBIC: [usize; 2] = [10, 15];
const QUADRATIC: [usize; 2] = [6, 9];

/// Share of the variance of the cubic's residuals below which degree four is no fit of the noise.
const BETTER: f64 = 0.4;

/// Relative to the radius of the neighbourhood: how far its mean may be from its centre inside a surface, how far from the
/// centre the polynomial is trusted, and the residual that no smooth surface has.
const LOPSIDED: f64 = 0.27;
const TRUSTED: f64 = 0.75;
const ROUGH: f64 = 0.25;

/// The largest degree of the polynomials of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Degree {
    Three,
    Four,
}

/// A polynomial surface `w = f(u, v)` around a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalSurface {
    origin: Vector3<f64>,
    axes: Matrix3<f64>,
    radius: f64,
    coefficients: SVector<f64, TERMS>,
    /// Whether the neighbours lie to one side, as at the border of a scan, or not on a smooth surface.
    pub(crate) border: bool,
}

/// Where a point lies with respect to a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Height {
    /// Signed distance, exact to the second order.
    pub(crate) value: f64,
    /// Its gradient, the unit normal below the point.
    pub(crate) normal: Vector3<f64>,
}

impl LocalSurface {
    /// Fits the surface around `centre` through its neighbours, of at most the given degree; `None` if they do not span one.
    pub(crate) fn fit(centre: &Vector3<f64>, neighbours: &[Vector3<f64>], degree: Degree) -> Option<Self> {
        let count = neighbours.len();
        let radius = neighbours.iter().map(|x| (x - centre).norm()).fold(0.0, f64::max);
        if count < 3 || radius.is_nan() || radius <= 0.0 {
            return None;
        }
        let mean = neighbours.iter().map(|x| x - centre).sum::<Vector3<f64>>() / count as f64;
        let mut spread = Matrix3::zeros();
        for x in neighbours {
            let offset = x - centre - mean;
            spread += offset * offset.transpose();
        }
        let eigen = spread.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        // Points on a line have no tangent plane.
        if eigen.eigenvalues[order[1]] <= 1e-9 * eigen.eigenvalues[order[0]] {
            return None;
        }
        let [first, second] = [0, 1].map(|i| eigen.eigenvectors.column(order[i]).into_owned());
        let axes = Matrix3::from_columns(&[first, second, first.cross(&second)]);

        let locals: Vec<Vector3<f64>> =
            neighbours.iter().map(|x| axes.tr_mul(&(x - centre)) / radius).collect();
        let (coefficients, residual) = fit_heights(&locals, degree)?;
        let middle = locals.iter().map(|x| x.xy()).sum::<Vector2<f64>>() / count as f64;
        let border = middle.norm() > LOPSIDED || (residual / count as f64).sqrt() > ROUGH;
        coefficients.iter().all(|c| c.is_finite()).then_some(Self {
            origin: *centre,
            axes,
            radius,
            coefficients,
            border,
        })
    }

    /// The height of a point above the surface; `None` where the polynomial is not to be trusted.
    pub(crate) fn height(&self, x: &Vector3<f64>) -> Option<Height> {
        let local = self.axes.tr_mul(&(x - self.origin)) / self.radius;
        let (u, v) = (local.x, local.y);
        if u.hypot(v) > TRUSTED {
            return None;
        }
        let (slope_u, slope_v) = self.slopes(u, v);
        let length = (1.0 + slope_u * slope_u + slope_v * slope_v).sqrt();
        let value = (local.z - self.coefficients.dot(&powers(u, v))) * self.radius / length;
        let normal = self.axes * Vector3::new(-slope_u, -slope_v, 1.0) / length;
        (length < 2.0 && value.is_finite()).then_some(Height { value, normal })
    }

    /// Whether the points asked for degree four.
    pub(crate) fn is_quartic(&self) -> bool {
        self.coefficients.rows(QUARTIC[0] - 5, 5).iter().any(|&c| c != 0.0)
    }

    /// The unit normal at the centre.
    pub(crate) fn normal(&self) -> Vector3<f64> {
        let (slope_u, slope_v) = self.slopes(0.0, 0.0);
        (self.axes * Vector3::new(-slope_u, -slope_v, 1.0)).normalize()
    }

    /// Turns the surface over, so that its normal points to the side of the given one.
    pub(crate) fn oriented(mut self, towards: &Vector3<f64>) -> Self {
        if self.normal().dot(towards) < 0.0 {
            // A half turn about the first axis: v and w change their signs.
            self.axes = Matrix3::from_columns(&[
                self.axes.column(0).into_owned(),
                -self.axes.column(1).into_owned(),
                -self.axes.column(2).into_owned(),
            ]);
            let signs = [-1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
            self.coefficients.component_mul_assign(&SVector::from(signs));
        }
        self
    }

    fn slopes(&self, u: f64, v: f64) -> (f64, f64) {
        let c = &self.coefficients;
        let (uu, uv, vv) = (u * u, u * v, v * v);
        (
            c[1] + 2.0 * c[3] * u
                + c[4] * v
                + 3.0 * c[6] * uu
                + 2.0 * c[7] * uv
                + c[8] * vv
                + u * (4.0 * c[10] * uu + 3.0 * c[11] * uv + 2.0 * c[12] * vv)
                + c[13] * vv * v,
            c[2] + c[4] * u
                + 2.0 * c[5] * v
                + c[7] * uu
                + 2.0 * c[8] * uv
                + 3.0 * c[9] * vv
                + c[11] * uu * u
                + v * (2.0 * c[12] * uu + 3.0 * c[13] * uv + 4.0 * c[14] * vv),
        )
    }
}

/// Coefficients of the polynomial that fits the heights, and the sum of the squares of its residuals.
///
/// One factorisation serves all degrees: those of the lower ones are its leading blocks, and the squares of the reduced right
/// side are what each term takes from the residuals.
fn fit_heights(locals: &[Vector3<f64>], degree: Degree) -> Option<(SVector<f64, TERMS>, f64)> {
    let count = locals.len();
    let degrees = match degree {
        Degree::Four => &[QUARTIC, CUBIC, QUADRATIC][..],
        Degree::Three => &[CUBIC, QUADRATIC],
    };
    let most = degrees.iter().find(|[_, least]| count >= *least).map_or(3, |[terms, _]| *terms);
    let (mut matrix, mut rhs) = (SMatrix::<f64, TERMS, TERMS>::zeros(), SVector::<f64, TERMS>::zeros());
    let mut squares = 0.0;
    for local in locals {
        let basis = powers(local.x, local.y);
        for j in 0..most {
            for i in j..most {
                matrix[(i, j)] += basis[i] * basis[j];
            }
            rhs[j] += basis[j] * local.z;
        }
        squares += local.z * local.z;
    }
    for i in 0..TERMS {
        matrix[(i, i)] += if i < most { 1e-11 * count as f64 } else { 1.0 };
    }
    let factor = matrix.cholesky()?.unpack();
    let mut reduced = rhs;
    if !factor.solve_lower_triangular_mut(&mut reduced) {
        return None;
    }
    let residual = |terms: usize| (squares - reduced.rows(0, terms).norm_squared()).max(0.0);
    let terms = if most == QUARTIC[0] {
        let variance = |terms: usize| residual(terms) / (count - terms) as f64;
        if variance(QUARTIC[0]) < BETTER * variance(CUBIC[0]) { QUARTIC[0] } else { CUBIC[0] }
    } else {
        most
    };
    let mut coefficients = SVector::zeros();
    for i in (0..terms).rev() {
        let known: f64 = (i + 1..terms).map(|k| factor[(k, i)] * coefficients[k]).sum();
        coefficients[i] = (reduced[i] - known) / factor[(i, i)];
    }
    Some((coefficients, residual(terms)))
}

fn powers(u: f64, v: f64) -> SVector<f64, TERMS> {
    let (uu, uv, vv) = (u * u, u * v, v * v);
    let (cubic, quartic) = ([uu * u, uu * v, u * vv, vv * v], [uu * uu, uu * uv, uu * vv, uv * vv, vv * vv]);
    let mut all = [1.0, u, v, uu, uv, vv, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    all[6..10].copy_from_slice(&cubic);
    all[10..].copy_from_slice(&quartic);
    SVector::from(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::start::random::Random;

    fn sphere(count: usize, half: f64, random: &mut Random) -> Vec<Vector3<f64>> {
        let place = |random: &mut Random| (2.0 * random.unit() - 1.0) * half;
        (0..count).map(|_| Vector3::new(place(random), place(random), 1.0).normalize()).collect()
    }

    #[test]
    fn heights_over_a_sphere_are_of_fourth_order() {
        let mut random = Random::new(5);
        let mut errors = Vec::new();
        for half in [0.2, 0.1, 0.05] {
            let mut worst: f64 = 0.0;
            for _ in 0..20 {
                let points = sphere(40, half, &mut random);
                let surface =
                    LocalSurface::fit(&Vector3::z(), &points, Degree::Three).unwrap().oriented(&Vector3::z());
                for x in sphere(20, 0.5 * half, &mut random) {
                    let height = surface.height(&x).unwrap();
                    worst = worst.max(height.value.abs());
                    assert!((height.normal - x).norm() < half.powi(3), "{}", (height.normal - x).norm());
                }
            }
            errors.push(worst);
        }
        assert!(
            errors[0] < 4e-4 && errors[1] < errors[0] / 10.0 && errors[2] < errors[1] / 10.0,
            "{errors:?}"
        );
    }

    #[test]
    fn noise_is_not_fitted_with_degree_four() {
        let mut random = Random::new(7);
        let [exact, noisy] = [0.0, 3e-3].map(|noise| {
            let mut quartic = || {
                let mut locals = sphere(28, 0.5, &mut random);
                locals.iter_mut().for_each(|x| x.z += noise * (2.0 * random.unit() - 1.0) - 1.0);
                fit_heights(&locals, Degree::Four).unwrap().0[10] != 0.0
            };
            (0..50).filter(|_| quartic()).count()
        });
        assert!(exact >= 45 && noisy <= 5, "{exact} {noisy}");
    }

    #[test]
    fn tells_the_border_and_what_is_no_surface() {
        let mut random = Random::new(6);
        let mut plane = |shift: f64| -> Vec<Vector3<f64>> {
            (0..60).map(|_| Vector3::new(random.unit() - shift, random.unit() - 0.5, 0.0)).collect()
        };
        assert!(!LocalSurface::fit(&Vector3::zeros(), &plane(0.5), Degree::Four).unwrap().border);
        assert!(LocalSurface::fit(&Vector3::zeros(), &plane(0.0), Degree::Four).unwrap().border);
        let flat = LocalSurface::fit(&Vector3::zeros(), &plane(0.5)[..5], Degree::Four).unwrap();
        assert!((flat.height(&Vector3::new(0.1, 0.1, 0.3)).unwrap().value.abs() - 0.3).abs() < 1e-9);
        assert!(LocalSurface::fit(&Vector3::zeros(), &[Vector3::zeros(); 30], Degree::Four).is_none());
        let line: Vec<_> = (0..30).map(|i| Vector3::x() * f64::from(i)).collect();
        assert!(LocalSurface::fit(&Vector3::zeros(), &line, Degree::Four).is_none());
    }
}
