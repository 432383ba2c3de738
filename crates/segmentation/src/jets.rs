//! Local quadrics: normals with their own standard deviations, curvatures and residuals of every point.

use crate::parallel;
use nalgebra::{Matrix3, Point3, SMatrix, SVector, SymmetricEigen, Vector3};

use crate::graph::Graph;

type Vector6 = SVector<f64, 6>;
type Matrix6 = SMatrix<f64, 6, 6>;

/// A quadric `z = c₀ + c₁u + c₂v + c₃u² + c₄uv + c₅v²` over the tangent plane of a neighbourhood, `u` and `v` in units of its
/// radius.
#[derive(Clone, Debug)]
pub(crate) struct Jet {
    /// Origin: the point whose neighbourhood it is.
    origin: Point3<f64>,
    /// Columns: the directions of `u`, `v` and `z`.
    frame: Matrix3<f64>,
    radius: f64,
    coefficients: Vector6,
    /// Standard deviation of a distance from the quadric, as the residuals tell it.
    pub(crate) residual: f64,
    /// Standard deviation of the normal at the point per tangent direction and unit noise.
    spread: f64,
}

impl Jet {
    /// Least squares over some points, the first of which is the origin. `None` for fewer than 7 or for points on a line.
    pub(crate) fn fit(points: &[Point3<f64>]) -> Option<Self> {
        let n = points.len();
        let origin = *points.first()?;
        if n < 7 {
            return None;
        }
        let (frame, _) = principal(points)?;
        let local: Vec<Vector3<f64>> = points.iter().map(|p| frame.tr_mul(&(p - origin))).collect();
        let radius = local.iter().map(|q| q.x.hypot(q.y)).fold(0.0, f64::max);
        if radius.is_nan() || radius <= 0.0 {
            return None;
        }
        let mut normal = Matrix6::identity() * 1e-9;
        let mut right = Vector6::zeros();
        for q in &local {
            let row = row(q.x / radius, q.y / radius);
            normal += row * row.transpose();
            right += row * q.z;
        }
        let inverse = normal.cholesky()?.inverse();
        let coefficients = inverse * right;
        let sum: f64 =
            local.iter().map(|q| (q.z - row(q.x / radius, q.y / radius).dot(&coefficients)).powi(2)).sum();
        let spread = (0.5 * (inverse[(1, 1)] + inverse[(2, 2)])).sqrt() / radius;
        let residual = (sum / (n - 6) as f64).sqrt();
        (residual.is_finite() && spread.is_finite()).then_some(Self {
            origin,
            frame,
            radius,
            coefficients,
            residual,
            spread,
        })
    }

    /// Height of a point above the quadric, its normal there, and how far the point is from the origin in radii.
    pub(crate) fn at(&self, x: &Point3<f64>) -> (f64, Vector3<f64>, f64) {
        let q = self.frame.tr_mul(&(x - self.origin));
        let (u, v) = (q.x / self.radius, q.y / self.radius);
        let c = &self.coefficients;
        let du = (c[1] + 2.0 * c[3] * u + c[4] * v) / self.radius;
        let dv = (c[2] + c[4] * u + 2.0 * c[5] * v) / self.radius;
        let scale = 1.0 / (1.0 + du * du + dv * dv).sqrt();
        let normal = self.frame * Vector3::new(-du, -dv, 1.0) * scale;
        ((q.z - row(u, v).dot(c)) * scale, normal, u.hypot(v))
    }

    /// Standard deviation of the normal at the origin per tangent direction, in radians.
    pub(crate) fn normal_deviation(&self, sigma: f64) -> f64 {
        sigma * self.spread
    }

    /// Principal curvatures (towards the third direction of the frame positive) and their directions at the origin.
    pub(crate) fn curvatures(&self) -> [(f64, Vector3<f64>); 2] {
        let c = &self.coefficients;
        let (du, dv) = (c[1] / self.radius, c[2] / self.radius);
        let w = (1.0 + du * du + dv * dv).sqrt();
        let scale = 1.0 / (self.radius * self.radius * w);
        let second = nalgebra::Matrix2::new(2.0 * c[3], c[4], c[4], 2.0 * c[5]) * scale;
        // Orthonormal tangent directions instead of those of the parameters.
        let t1 = Vector3::new(1.0, 0.0, du).normalize();
        let n = Vector3::new(-du, -dv, 1.0) / w;
        let t2 = n.cross(&t1);
        // Parameter components of the tangent directions are their projections.
        let a = nalgebra::Matrix2::new(t1.x, t2.x, t1.y, t2.y);
        let eigen = SymmetricEigen::new(a.transpose() * second * a);
        let direction = |k: usize| {
            let e = eigen.eigenvectors.column(k);
            self.frame * (t1 * e[0] + t2 * e[1])
        };
        let [one, other] = [(eigen.eigenvalues[0], direction(0)), (eigen.eigenvalues[1], direction(1))];
        if one.0.abs() >= other.0.abs() { [one, other] } else { [other, one] }
    }

    /// How much the normal at the origin, on the side of another one, turns towards a direction per length.
    pub(crate) fn bend(&self, direction: &Vector3<f64>, side: &Vector3<f64>) -> f64 {
        let step = 1e-3 * self.radius;
        let (here, next) = (self.at(&self.origin).1, self.at(&(self.origin + direction * step)).1);
        let sign = if here.dot(side) < 0.0 { -1.0 } else { 1.0 };
        (next - here).dot(direction) / step * sign
    }

    /// The normal at the origin.
    pub(crate) fn normal(&self) -> Vector3<f64> {
        self.at(&self.origin).1
    }

    /// Radius of the neighbourhood.
    pub(crate) fn radius(&self) -> f64 {
        self.radius
    }
}

fn row(u: f64, v: f64) -> Vector6 {
    Vector6::new(1.0, u, v, u * u, u * v, v * v)
}

/// Directions of the principal axes about the mean, that of the largest extent first, right handed, and the standard deviations.
/// `None` for points on a line or in one place.
pub(crate) fn principal(points: &[Point3<f64>]) -> Option<(Matrix3<f64>, Vector3<f64>)> {
    let n = points.len() as f64;
    let mean = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / n;
    let mut matrix = Matrix3::zeros();
    for p in points {
        let q = p.coords - mean;
        matrix += q * q.transpose();
    }
    let eigen = SymmetricEigen::new(matrix / n);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]).then(a.cmp(&b)));
    let x: Vector3<f64> = eigen.eigenvectors.column(order[0]).into();
    let y: Vector3<f64> = eigen.eigenvectors.column(order[1]).into();
    let values = Vector3::from_fn(|k, _| eigen.eigenvalues[order[k]].max(0.0).sqrt());
    (values.y > 1e-9 * values.x).then(|| (Matrix3::from_columns(&[x, y, x.cross(&y)]), values))
}

/// What is known about the normal of a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointNormal {
    pub(crate) normal: Vector3<f64>,
    /// Standard deviation per tangent direction in radians; infinite where no neighbourhood agrees with a smooth surface.
    pub(crate) deviation: f64,
}

/// The local quadrics of a cloud.
#[derive(Debug)]
pub(crate) struct Jets {
    /// One of every point over its `FEW` neighbours; `None` where they lie on a line.
    pub(crate) jets: Vec<Option<Jet>>,
    pub(crate) normals: Vec<PointNormal>,
}

/// Points of a neighbourhood, the point itself included.
pub(crate) const FEW: usize = 16;

impl Jets {
    /// Fits all quadrics.
    pub(crate) fn new(points: &[Point3<f64>], graph: &Graph) -> Self {
        let jets = parallel::map(points.len(), |i| {
            let patch: Vec<Point3<f64>> = std::iter::once(points[i])
                .chain(graph.near(i).iter().take(FEW - 1).map(|&j| points[j as usize]))
                .collect();
            Jet::fit(&patch)
        });
        Self { jets, normals: Vec::new() }
    }

    /// Standard deviation of the noise: the quarter quantile of the residuals, as if they were of Gaussian noise alone.
    pub(crate) fn noise(&self) -> f64 {
        let mut all: Vec<f64> = self.jets.iter().flatten().map(|jet| jet.residual).collect();
        if all.is_empty() {
            return 0.0;
        }
        let place = all.len() / 4;
        let (_, value, _) = all.select_nth_unstable_by(place, f64::total_cmp);
        // Quarter quantile of the square root of χ²/10 with 10 degrees of freedom.
        *value / 0.821
    }

    /// Normals: of the point's own neighbourhood where its residual agrees with the noise, else of the best neighbourhood of a
    /// neighbour that holds the point, so that edges do not bend them.
    pub(crate) fn find_normals(&mut self, points: &[Point3<f64>], graph: &Graph, sigma: f64) {
        self.normals = parallel::map(points.len(), |i| {
            let own = self.jets[i].as_ref();
            if let Some(jet) = own.filter(|jet| jet.residual < CLEAN * sigma) {
                return PointNormal { normal: jet.normal(), deviation: jet.normal_deviation(sigma) };
            }
            let mut best: Option<(f64, PointNormal)> = None;
            for &j in graph.near(i).iter().take(FEW) {
                let Some(jet) = &self.jets[j as usize] else { continue };
                if jet.residual >= CLEAN * sigma || best.is_some_and(|(least, _)| jet.residual >= least) {
                    continue;
                }
                let (height, normal, away) = jet.at(&points[i]);
                if away <= 1.0 && height.abs() < 3.0 * sigma {
                    let deviation = jet.normal_deviation(sigma) * (1.0 + 2.0 * away);
                    best = Some((jet.residual, PointNormal { normal, deviation }));
                }
            }
            let unknown =
                PointNormal { normal: own.map_or(Vector3::zeros(), Jet::normal), deviation: f64::INFINITY };
            best.map_or(unknown, |(_, normal)| normal)
        });
    }
}

/// Residuals above this multiple of the noise are no noise (χ² with 10 degrees of freedom: 1 in 200).
pub(crate) const CLEAN: f64 = 1.6;
