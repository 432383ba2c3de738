//! Poles: edges of the parameter domain that are collapsed into a point.
//!
//! The derivatives of the parameterisation say nothing about the surface there, but the parameter lines that end at the
//! pole leave it in many tangent directions, and the normal curvature of each is known. Euler's theorem makes of them
//! the principal curvatures.

use crate::local_geometry::{LocalGeometry, of_point, of_principal, principal_axes, tangents};
use nalgebra::{Matrix3, Vector3};
use nurbs_core::{ParametricSurface, SurfaceJet};

/// Parameter lines looked at.
const LINES: usize = 24;
/// Sine of the angle between a parameter line and the tangent plane above which the pole is an apex.
const APEX: f64 = 1e-6;
/// Largest angle in radians between neighbouring parameter lines that surround a pole.
const GAP: f64 = 1.5;

/// What a surface looks like at a pole.
#[derive(Clone, Debug)]
pub(crate) struct Pole {
    normal: Vector3<f64>,
    directions: [Vector3<f64>; 2],
    curvatures: [f64; 2],
    /// Whether there is a tangent plane.
    smooth: bool,
    /// Whether the surface lies all around: otherwise the pole is a corner of its boundary.
    pub(crate) inner: bool,
}

impl Pole {
    /// The pole at the lower (`end` 0) or upper end of parameter `k`.
    pub(crate) fn new<S: ParametricSurface>(surface: &S, k: usize, end: usize) -> Self {
        let domain = surface.domain();
        let at = if end == 0 { domain[k].start() } else { domain[k].end() };
        let inwards = if end == 0 { 1.0 } else { -1.0 };
        let lines: Vec<(Vector3<f64>, Vector3<f64>, Vector3<f64>)> = (0..=LINES)
            .filter_map(|i| {
                let along = domain[1 - k].lerp(i as f64 / LINES as f64);
                let jet = if k == 0 { surface.jet(at, along) } else { surface.jet(along, at) };
                let (d1, d2) = if k == 0 { (jet.du, jet.duu) } else { (jet.dv, jet.dvv) };
                let speed = d1.norm();
                let direction = d1 * (inwards / speed);
                let normal = if k == 0 { d1.cross(&jet.duv) } else { jet.duv.cross(&d1) } * inwards;
                let normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
                let bend = (d2 - direction * direction.dot(&d2)) / (speed * speed);
                let usable = [direction, normal, bend].iter().all(|v| v.iter().all(|c| c.is_finite()));
                usable.then_some((direction, normal, bend))
            })
            .collect();
        let sum: Vector3<f64> = lines.iter().map(|(_, normal, _)| normal).sum();
        let normal = sum.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector3::z);
        let flat = lines.iter().all(|(direction, _, _)| direction.dot(&normal).abs() <= APEX);
        let [e1, e2] = tangents(&normal);
        let mut pole =
            Self { normal, directions: [e1, e2], curvatures: [0.0; 2], smooth: false, inner: false };
        let angles: Vec<f64> =
            lines.iter().map(|(direction, _, _)| direction.dot(&e2).atan2(direction.dot(&e1))).collect();
        let closes = lines.first().zip(lines.last()).is_some_and(|(a, b)| (a.0 - b.0).norm() <= 1e-6);
        pole.inner = closes && largest_gap(angles) <= GAP;
        pole.smooth = flat && pole.fit(&lines);
        pole
    }

    /// Least squares for the second fundamental form from its values in the directions of the lines.
    fn fit(&mut self, lines: &[(Vector3<f64>, Vector3<f64>, Vector3<f64>)]) -> bool {
        let [e1, e2] = self.directions;
        let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (direction, _, bend) in lines {
            let (x, y) = (direction.dot(&e1), direction.dot(&e2));
            let row = Vector3::new(x * x, 2.0 * x * y, y * y);
            matrix += row * row.transpose();
            right += row * bend.dot(&self.normal);
        }
        let Some(form) = matrix.cholesky().map(|c| c.solve(&right)) else { return false };
        (self.directions, self.curvatures) = principal_axes([form.x, form.y, form.z], [e1, e2]);
        self.curvatures.iter().all(|c| c.is_finite())
    }

    /// The geometry at the pole as a query sees it.
    pub(crate) fn geometry(&self, residual: &Vector3<f64>) -> LocalGeometry<3> {
        if self.smooth && self.inner {
            of_principal(&self.directions, &self.normal, self.curvatures, residual.dot(&self.normal))
        } else {
            of_point(residual, Some(&self.normal))
        }
    }

    /// The geometry beside the pole, where second derivatives drown in rounding errors: the normal there, and the
    /// curvatures of the pole.
    pub(crate) fn geometry_beside(
        &self,
        jet: &SurfaceJet,
        residual: &Vector3<f64>,
    ) -> Option<LocalGeometry<3>> {
        let normal = jet.unit_normal().filter(|_| self.smooth)?;
        let first = (self.directions[0] - normal * normal.dot(&self.directions[0])).try_normalize(0.5)?;
        Some(of_principal(&[first, normal.cross(&first)], &normal, self.curvatures, residual.dot(&normal)))
    }
}

/// The largest angle between neighbours on the circle.
fn largest_gap(mut angles: Vec<f64>) -> f64 {
    angles.sort_by(f64::total_cmp);
    let Some((first, last)) = angles.first().zip(angles.last()) else { return f64::INFINITY };
    let around = first + std::f64::consts::TAU - last;
    angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max)
}
