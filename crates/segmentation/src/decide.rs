//! The simplest carrier whose orthogonal distances agree with the noise.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::carrier::{Carrier, across, cylindrical};
use crate::jets::{Jet, PointNormal};
use crate::least_squares::{Fit, mean, plane, refine};
use crate::trend::is_systematic;
use crate::velocity::Fields;

/// Upper limit of the standard deviation of distances of `n` points for a noise: 4 standard deviations of the estimate, and
/// 3 % for noise that is not Gaussian.
pub(crate) fn limit(sigma: f64, n: usize) -> f64 {
    1.03 * sigma * (1.0 + 4.0 / (2.0 * n.max(1) as f64).sqrt())
}

/// Most points that take part in the search for a carrier.
const SAMPLE: usize = 1500;
/// Steps of a refinement.
const STEPS: usize = 30;

/// A carrier that is accepted, or the best of each type that was refused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Decision {
    pub(crate) accepted: Option<Fit>,
    pub(crate) refused: Vec<Fit>,
}

/// Tries plane, cylinder, sphere, cone and torus in this order.
///
/// `extent` is the largest distance from the mean; carriers with radii of more than 50 times of it are no carriers of their type.
pub(crate) fn decide(
    points: &[Point3<f64>],
    normals: &[PointNormal],
    sigma: f64,
    start: Option<&Carrier>,
    all_types: bool,
) -> Decision {
    let mut decision = Decision::default();
    let all = points.len();
    let stride = all.div_ceil(SAMPLE).max(1);
    let some: Vec<Point3<f64>> = points.iter().copied().step_by(stride).collect();
    let some_normals: Vec<PointNormal> = normals.iter().copied().step_by(stride).collect();
    let n = some.len();
    let limit = limit(sigma, n);
    let centre = mean(&some);
    let extent = some.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
    let mut offer = |fits: Vec<Fit>| -> bool {
        let best = fits.into_iter().min_by(|a, b| a.rms.total_cmp(&b.rms));
        let Some(best) = best else { return false };
        let sized = best.carrier.size() < 50.0 * extent || matches!(best.carrier, Carrier::Plane { .. });
        if !sized || best.rms >= limit || is_systematic(&best.carrier, &some, sigma) {
            decision.refused.push(best);
            return false;
        }
        let done = !all_types || matches!(best.carrier, Carrier::Plane { .. } | Carrier::Cylinder { .. });
        match &decision.accepted {
            // A simpler type holds unless the other explains much more.
            Some(simple) => {
                let more = (best.carrier.unknowns() - simple.carrier.unknowns()) as f64;
                let count = n as f64;
                let gain = (simple.rms.powi(2) - best.rms.powi(2)) * count / (sigma * sigma);
                if gain > 1.5 * more * count.ln() + 0.01 * count {
                    decision.accepted = Some(best);
                }
            }
            None => decision.accepted = Some(best),
        }
        done
    };
    if n < 4 || offer(plane(&some).into_iter().collect()) || n < 16 {
        return decision;
    }
    let go = |c: &Carrier| refine(c, &some, STEPS);
    // The carrier of a smaller support is the best start for its own type.
    let fields = Fields::new(&some, &some_normals);
    let axes = axes(&some, &some_normals, fields.as_ref());
    let mut cylinders: Vec<Fit> = match start {
        Some(c @ Carrier::Cylinder { .. }) => go(c).into_iter().collect(),
        _ => Vec::new(),
    };
    if !cylinders.iter().any(|f| f.rms < limit) {
        cylinders.extend(axes.iter().filter_map(|a| circle_about(&some, a)).filter_map(|c| go(&c)));
    }
    let cylinder = cylinders.iter().min_by(|a, b| a.rms.total_cmp(&b.rms)).cloned();
    if offer(cylinders) {
        return decision;
    }
    if offer(sphere_start(&some).and_then(|c| go(&c)).into_iter().collect()) {
        return decision;
    }
    if n < 24 {
        return decision;
    }
    let mut cones = Vec::new();
    if let Some(c @ Carrier::Cone { .. }) = start {
        cones.extend(go(c));
    }
    if !cones.iter().any(|f| f.rms < limit) {
        if let Some(Fit { carrier: Carrier::Cylinder { point, axis, radius }, .. }) = cylinder {
            cones.extend(go(&Carrier::Cone { point, axis, radius, angle: 0.0 }));
        }
        cones.extend(cone_starts(&some, &some_normals, fields.as_ref()).iter().filter_map(go));
    }
    if offer(cones) {
        return decision;
    }
    if n < 32 {
        return decision;
    }
    let mut tori = Vec::new();
    if let Some(c @ Carrier::Torus { .. }) = start {
        tori.extend(go(c));
    }
    if !tori.iter().any(|f| f.rms < limit) {
        tori.extend(torus_starts(&some, fields.as_ref()).iter().filter_map(go));
    }
    offer(tori);
    decision
}

/// Directions that may be axes: of least curvature, the one most perpendicular to the normals, of the tangential motions.
fn axes(points: &[Point3<f64>], normals: &[PointNormal], fields: Option<&Fields>) -> Vec<Vector3<f64>> {
    let mut axes = Vec::new();
    let centre = mean(points);
    let nearest =
        points.iter().min_by(|a, b| (*a - centre).norm_squared().total_cmp(&(*b - centre).norm_squared()));
    if let Some(first) = nearest {
        let patch: Vec<Point3<f64>> = std::iter::once(*first).chain(points.iter().copied()).collect();
        if let Some(jet) = Jet::fit(&patch) {
            axes.push(jet.curvatures()[1].1);
        }
    }
    if let Some(fields) = fields {
        axes.push(fields.translations[0].1);
        axes.extend((0..2).filter_map(|k| fields.motion(k)).map(|m| m.axis));
    }
    if let Some(axis) = spread_axis(normals) {
        axes.push(axis);
    }
    axes
}

/// The direction in which normals vary least.
fn spread_axis(normals: &[PointNormal]) -> Option<Vector3<f64>> {
    let known: Vec<Vector3<f64>> =
        normals.iter().filter(|n| n.deviation.is_finite()).map(|n| n.normal).collect();
    if known.len() < 6 {
        return None;
    }
    let reference = known[0];
    let turned = || known.iter().map(|n| if n.dot(&reference) < 0.0 { -n } else { *n });
    let mean = turned().fold(Vector3::zeros(), |s, n| s + n) / known.len() as f64;
    let matrix = turned().fold(Matrix3::zeros(), |m, n| m + (n - mean) * (n - mean).transpose());
    let eigen = nalgebra::SymmetricEigen::new(matrix);
    Some(eigen.eigenvectors.column(eigen.eigenvalues.imin()).into())
}

/// Circle through points in the plane in the sense of algebraic least squares: centre and radius.
pub(crate) fn circle(points: &[(f64, f64)]) -> Option<(f64, f64, f64)> {
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    let n = points.len().max(1) as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    for (x, y) in points {
        let (x, y) = (x - mx, y - my);
        let row = Vector3::new(2.0 * x, 2.0 * y, 1.0);
        matrix += row * row.transpose();
        right += row * (x * x + y * y);
    }
    let q = matrix.cholesky()?.solve(&right);
    let square = q.z + q.x * q.x + q.y * q.y;
    (square > 0.0 && square.is_finite()).then(|| (q.x + mx, q.y + my, square.sqrt()))
}

/// The cylinder of algebraic least squares with a given axis.
pub(crate) fn circle_about(points: &[Point3<f64>], axis: &Vector3<f64>) -> Option<Carrier> {
    let (e, f) = across(axis);
    let centre = mean(points);
    let flat: Vec<(f64, f64)> = points.iter().map(|p| ((p - centre).dot(&e), (p - centre).dot(&f))).collect();
    let (a, b, radius) = circle(&flat)?;
    Some(Carrier::Cylinder { point: centre + e * a + f * b, axis: *axis, radius })
}

/// The sphere of algebraic least squares.
pub(crate) fn sphere_start(points: &[Point3<f64>]) -> Option<Carrier> {
    let centre = mean(points);
    let mut matrix = nalgebra::Matrix4::zeros();
    let mut right = nalgebra::Vector4::zeros();
    for p in points {
        let q = p - centre;
        let row = nalgebra::Vector4::new(2.0 * q.x, 2.0 * q.y, 2.0 * q.z, 1.0);
        matrix += row * row.transpose();
        right += row * q.norm_squared();
    }
    let s = matrix.cholesky()?.solve(&right);
    let square = s.w + s.xyz().norm_squared();
    (square > 0.0).then(|| Carrier::Sphere { centre: centre + s.xyz(), radius: square.sqrt() })
}

/// Cones: the line of least squares of the generating curve about axes of the motions, and the apex of the normals.
fn cone_starts(points: &[Point3<f64>], normals: &[PointNormal], fields: Option<&Fields>) -> Vec<Carrier> {
    let mut lines: Vec<(Point3<f64>, Vector3<f64>)> = Vec::new();
    if let Some(fields) = fields {
        lines.extend((0..2).filter_map(|k| fields.motion(k)).map(|m| (m.point, m.axis)));
    }
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    let origin = mean(points);
    for (p, n) in points.iter().zip(normals).filter(|(_, n)| n.deviation.is_finite()) {
        matrix += n.normal * n.normal.transpose();
        right += n.normal * n.normal.dot(&(p - origin));
    }
    if let (Some(c), Some(axis)) = (matrix.cholesky(), spread_axis(normals)) {
        lines.push((origin + c.solve(&right), axis));
    }
    lines.iter().filter_map(|(point, axis)| line_about(points, point, axis)).collect()
}

/// Heights and radii of points about an axis.
fn profile<'a>(
    points: &'a [Point3<f64>],
    point: &'a Point3<f64>,
    axis: &'a Vector3<f64>,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    points.iter().map(move |p| {
        let (h, r, _) = cylindrical(p, point, axis);
        (h, r)
    })
}

/// The cone about a given axis whose generator is the line of regression.
pub(crate) fn line_about(
    points: &[Point3<f64>],
    point: &Point3<f64>,
    axis: &Vector3<f64>,
) -> Option<Carrier> {
    let flat: Vec<(f64, f64)> = profile(points, point, axis).collect();
    let n = flat.len() as f64;
    let (mh, mr) = flat.iter().fold((0.0, 0.0), |(a, b), (h, r)| (a + h / n, b + r / n));
    let (mut hh, mut hr, mut rr) = (0.0, 0.0, 0.0);
    for (h, r) in &flat {
        hh += (h - mh) * (h - mh);
        hr += (h - mh) * (r - mr);
        rr += (r - mr) * (r - mr);
    }
    // Direction of the larger principal axis of (h, r).
    let angle = 0.5 * (2.0 * hr).atan2(hh - rr);
    (angle.abs() < 1.55).then(|| Carrier::Cone {
        point: point + axis * mh,
        axis: *axis,
        radius: mr.max(0.0),
        angle,
    })
}

/// Tori: circles about the axes of the motions.
fn torus_starts(points: &[Point3<f64>], fields: Option<&Fields>) -> Vec<Carrier> {
    let Some(fields) = fields else { return Vec::new() };
    (0..3).filter_map(|k| fields.motion(k)).filter_map(|m| tube_about(points, &m.point, &m.axis)).collect()
}

/// The torus of algebraic least squares about a given axis.
pub(crate) fn tube_about(
    points: &[Point3<f64>],
    point: &Point3<f64>,
    axis: &Vector3<f64>,
) -> Option<Carrier> {
    let flat: Vec<(f64, f64)> = profile(points, point, axis).map(|(h, r)| (r, h)).collect();
    let (radius, h, minor) = circle(&flat)?;
    (radius > 0.0).then(|| Carrier::Torus { centre: point + axis * h, axis: *axis, radius, minor })
}
