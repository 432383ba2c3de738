//! The surface near a point of a cloud: a polynomial over the tangent plane.
//!
//! A scan touches the true surface at its points only. The tangent plane at the nearest of them is off by `κ h²/2` at half
//! the spacing `h`, always to the same side where the shape is convex; a cubic is off by the order `h⁴`. This is what lets two
//! scans without a common point agree to a millionth of their size.

use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

/// Coefficients of a cubic in two variables: `1, u, v, u², uv, v², u³, u²v, uv², v³`.
const TERMS: usize = 10;

/// Points for a cubic, and for a quadratic polynomial; with fewer a plane is fitted.
const CUBIC: usize = 15;
const QUADRATIC: usize = 9;

/// Relative to the radius of the neighbourhood: how far its mean may be from its centre inside a surface, how far from the
/// centre the polynomial is trusted, and the residual that no smooth surface has.
const LOPSIDED: f64 = 0.27;
const TRUSTED: f64 = 0.75;
const ROUGH: f64 = 0.25;

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
    /// Fits the surface around `centre` through its neighbours; `None` if they do not span one.
    pub(crate) fn fit(centre: &Vector3<f64>, neighbours: &[Vector3<f64>]) -> Option<Self> {
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

        let terms = if count >= CUBIC {
            TERMS
        } else if count >= QUADRATIC {
            6
        } else {
            3
        };
        let locals: Vec<Vector3<f64>> =
            neighbours.iter().map(|x| axes.tr_mul(&(x - centre)) / radius).collect();
        let (mut matrix, mut rhs) = (SMatrix::<f64, TERMS, TERMS>::zeros(), SVector::<f64, TERMS>::zeros());
        for local in &locals {
            let mut basis = powers(local.x, local.y);
            basis.fixed_rows_mut::<TERMS>(0).iter_mut().skip(terms).for_each(|value| *value = 0.0);
            matrix.ger(1.0, &basis, &basis, 1.0);
            rhs.axpy(local.z, &basis, 1.0);
        }
        for i in 0..TERMS {
            matrix[(i, i)] += if i < terms { 1e-11 * count as f64 } else { 1.0 };
        }
        let coefficients = matrix.cholesky()?.solve(&rhs);
        let residual =
            locals.iter().map(|x| (x.z - coefficients.dot(&powers(x.x, x.y))).powi(2)).sum::<f64>();
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
            let signs = [-1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0];
            self.coefficients.component_mul_assign(&SVector::from(signs));
        }
        self
    }

    fn slopes(&self, u: f64, v: f64) -> (f64, f64) {
        let c = &self.coefficients;
        (
            c[1] + 2.0 * c[3] * u + c[4] * v + 3.0 * c[6] * u * u + 2.0 * c[7] * u * v + c[8] * v * v,
            c[2] + c[4] * u + 2.0 * c[5] * v + c[7] * u * u + 2.0 * c[8] * u * v + 3.0 * c[9] * v * v,
        )
    }
}

fn powers(u: f64, v: f64) -> SVector<f64, TERMS> {
    SVector::from([1.0, u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v])
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
                let surface = LocalSurface::fit(&Vector3::z(), &points).unwrap().oriented(&Vector3::z());
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
    fn tells_the_border_and_what_is_no_surface() {
        let mut random = Random::new(6);
        let mut plane = |shift: f64| -> Vec<Vector3<f64>> {
            (0..60).map(|_| Vector3::new(random.unit() - shift, random.unit() - 0.5, 0.0)).collect()
        };
        assert!(!LocalSurface::fit(&Vector3::zeros(), &plane(0.5)).unwrap().border);
        assert!(LocalSurface::fit(&Vector3::zeros(), &plane(0.0)).unwrap().border);
        let flat = LocalSurface::fit(&Vector3::zeros(), &plane(0.5)[..5]).unwrap();
        assert!((flat.height(&Vector3::new(0.1, 0.1, 0.3)).unwrap().value.abs() - 0.3).abs() < 1e-9);
        assert!(LocalSurface::fit(&Vector3::zeros(), &[Vector3::zeros(); 30]).is_none());
        let line: Vec<_> = (0..30).map(|i| Vector3::x() * f64::from(i)).collect();
        assert!(LocalSurface::fit(&Vector3::zeros(), &line).is_none());
    }
}
