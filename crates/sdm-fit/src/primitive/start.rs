//! Initial values from the points alone.

use super::flat::{LineModel, PlaneModel};
pub(crate) use super::model::normal_to;
use super::random::Random;
use super::round::{BallModel, CircleModel};
use super::torus::TorusModel;
use super::turned::ConeModel;
use mesh_core::{NormalOptions, Orientation, estimate_normals};
use nalgebra::{DMatrix, DVector, Matrix3, Point3, SVector, Vector2, Vector3};

/// Number of directions that are tried as axes; neighbours are 7° apart.
const DIRECTIONS: usize = 400;

/// Number of points that judge a direction.
const JUDGES: usize = 250;

/// Random axes that few points choose from.
const TRIES: usize = 24;

/// Curvature, in units of the size of the cloud, below which points lie on a line or a plane.
const FLAT: f64 = 1e-11;

/// Every k-th point, so that about `count` are left.
pub(crate) fn thinned<T: Copy>(points: &[T], count: usize) -> Vec<T> {
    points.iter().copied().step_by(points.len().div_ceil(count.max(1)).max(1)).collect()
}

/// Mean of some points.
pub(crate) fn mean<const D: usize>(points: &[SVector<f64, D>]) -> SVector<f64, D> {
    points.iter().sum::<SVector<f64, D>>() / points.len().max(1) as f64
}

/// Mean and principal axes, longest first.
pub(crate) fn principal<const D: usize>(
    points: &[SVector<f64, D>],
) -> (SVector<f64, D>, Vec<SVector<f64, D>>) {
    let centre = mean(points);
    let mut scatter: DMatrix<f64> = DMatrix::zeros(D, D);
    for x in points {
        let d = x - centre;
        for i in 0..D {
            for j in 0..D {
                scatter[(i, j)] += d[i] * d[j];
            }
        }
    }
    let eigen = scatter.symmetric_eigen();
    let mut order: Vec<usize> = (0..D).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axes = order.iter().map(|&k| SVector::from_fn(|i, _| eigen.eigenvectors[(i, k)])).collect();
    (centre, axes)
}

/// Dimension of the space that the points span, up to a tolerance: 0 for points in one place, and so on.
pub(crate) fn rank<const D: usize>(points: &[SVector<f64, D>], tolerance: f64) -> usize {
    let (centre, axes) = principal(points);
    // The spread along the axes is lost in rounding where it is below a hundred millionth of the largest one: measured.
    (0..D)
        .rev()
        .find(|&k| points.iter().any(|x| (x - centre).dot(&axes[k]).abs() > tolerance))
        .map_or(0, |k| k + 1)
}

pub(super) fn line<const D: usize>(points: &[SVector<f64, D>]) -> Vec<LineModel<D>> {
    let (centre, axes) = principal(points);
    vec![LineModel::new(centre, axes[0])]
}

pub(super) fn plane(points: &[Vector3<f64>]) -> Vec<PlaneModel> {
    let (centre, axes) = principal(points);
    vec![PlaneModel::new(centre, axes[2])]
}

/// The algebraic circle or sphere of [Ta91]: the right singular vector of the rows `((|x|² − m)/(2√m), x)` about the mean, `m` the
/// mean of `|x|²`. Hardly biased on short arcs. `None` if the points lie on a line or a plane.
pub(crate) fn taubin<const D: usize>(points: &[SVector<f64, D>]) -> Option<(SVector<f64, D>, f64)> {
    let centre = mean(points);
    let square = points.iter().map(|x| (x - centre).norm_squared()).sum::<f64>() / points.len().max(1) as f64;
    if square.is_nan() || square <= 0.0 || points.len() <= D {
        return None;
    }
    let scale = 2.0 * square.sqrt();
    let rows = DMatrix::from_fn(points.len(), D + 1, |i, j| {
        let d = points[i] - centre;
        if j == 0 { (d.norm_squared() - square) / scale } else { d[j - 1] }
    });
    let svd = rows.qr().unpack_r().svd(false, true);
    let smallest = svd.singular_values.imin();
    let vector = svd.v_t.as_ref()?.row(smallest).transpose();
    let lead = vector[0] / scale;
    if lead.abs() < FLAT {
        return None;
    }
    let offset: SVector<f64, D> = SVector::from_fn(|i, _| -vector[i + 1] / (2.0 * lead));
    let radius = (offset.norm_squared() + square).sqrt();
    radius.is_finite().then_some((centre + offset, radius))
}

pub(super) fn ball<const D: usize>(points: &[SVector<f64, D>]) -> Vec<BallModel<D>> {
    taubin(&thinned(points, 2000))
        .map(|(centre, radius)| BallModel::new(centre, radius))
        .into_iter()
        .collect()
}

/// Coordinates in the plane normal to a direction, and heights along it.
fn along(points: &[Vector3<f64>], z: &Vector3<f64>) -> (Vec<Vector2<f64>>, [Vector3<f64>; 2]) {
    let x = normal_to(z);
    let y = z.cross(&x);
    (points.iter().map(|p| Vector2::new(p.dot(&x), p.dot(&y))).collect(), [x, y])
}

pub(super) fn circle(points: &[Vector3<f64>]) -> Vec<CircleModel> {
    let sample = thinned(points, 2000);
    let (centre, axes) = principal(&sample);
    let (flat, [x, y]) = along(&sample, &axes[2]);
    let Some((found, radius)) = taubin(&flat) else { return Vec::new() };
    let middle = x * found.x + y * found.y + axes[2] * centre.dot(&axes[2]);
    vec![CircleModel::new(middle, axes[2], radius)]
}

/// Directions spread evenly over a hemisphere.
fn hemisphere() -> impl Iterator<Item = Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..DIRECTIONS).map(move |i| {
        let z = (i as f64 + 0.5) / DIRECTIONS as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * cos, r * sin, z)
    })
}

/// Directions in which an axis may point: principal axes, those that estimated normals suggest, and all others.
fn directions(points: &[Vector3<f64>], lines: &[(Vector3<f64>, Vector3<f64>)]) -> Vec<Vector3<f64>> {
    let (_, axes) = principal(points);
    let mut list = axes;
    list.extend(lines.iter().map(|(_, direction)| *direction));
    list.extend(hemisphere());
    list
}

/// Axes suggested by normals: the line that meets all normals best (its linear complex has pitch 0, [PW01]), and the directions
/// that make the steadiest angle with them (cones, cylinders).
pub(crate) fn axes_of_normals(points: &[Vector3<f64>]) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    if points.len() < 30 {
        return Vec::new();
    }
    let cloud: Vec<Point3<f64>> = thinned(points, 20_000).into_iter().map(Point3::from).collect();
    let options = NormalOptions::default().with_orientation(Orientation::Any);
    let Ok(estimate) = estimate_normals(&cloud, &options) else { return Vec::new() };
    let mut complex: DMatrix<f64> = DMatrix::zeros(6, 6);
    let mut second = Matrix3::zeros();
    for (x, n) in cloud.iter().zip(&estimate.normals) {
        let moment = x.coords.cross(n);
        let row = DVector::from_iterator(6, n.iter().chain(moment.iter()).copied());
        complex += &row * row.transpose();
        second += n * n.transpose();
    }
    let mut lines = Vec::new();
    let eigen = complex.symmetric_eigen();
    let mut order: Vec<usize> = (0..6).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    for &k in &order[..2] {
        let v = eigen.eigenvectors.column(k);
        let velocity = Vector3::new(v[0], v[1], v[2]);
        let rotation = Vector3::new(v[3], v[4], v[5]);
        if rotation.norm() > 1e-3 {
            let point = rotation.cross(&velocity) / rotation.norm_squared();
            lines.push((point, rotation.normalize()));
        }
    }
    let eigen = second.symmetric_eigen();
    let least = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    lines.push((mean(points), least));
    lines
}

/// The cheapest models, at most `count`, no two of nearly the same axis.
fn best<M>(mut models: Vec<(f64, Vector3<f64>, M)>, count: usize) -> Vec<M> {
    models.retain(|(cost, ..)| cost.is_finite());
    models.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<(Vector3<f64>, M)> = Vec::new();
    for (_, axis, model) in models {
        if kept.len() == count {
            break;
        }
        if kept.iter().filter(|(other, _)| axis.cross(other).norm() < 0.1).count() < 2 {
            kept.push((axis, model));
        }
    }
    kept.into_iter().map(|(_, model)| model).collect()
}

/// Sum of squared distances.
fn cost_of<M: super::model::Model<3>>(model: &M, points: &[Vector3<f64>]) -> f64 {
    points.iter().map(|x| model.distance_sq(x)).sum()
}

/// The cylinder with a given axis direction, or the cones by linear least squares of `|x⊥|² = 2 c·x⊥ + α + β h + γ h²`.
fn cones_along<const CONE: bool>(points: &[Vector3<f64>], z: &Vector3<f64>) -> Vec<ConeModel<CONE>> {
    let (flat, [x, y]) = along(points, z);
    if !CONE {
        let found = taubin(&flat);
        let model = found.and_then(|(c, radius)| ConeModel::new(x * c.x + y * c.y, *z, radius, 0.0));
        return model.into_iter().collect();
    }
    let rows = DMatrix::from_fn(points.len().max(5), 5, |i, j| {
        let Some(p) = points.get(i) else { return 0.0 };
        let h = p.dot(z);
        [2.0 * flat[i].x, 2.0 * flat[i].y, 1.0, h, h * h][j]
    });
    let right = DVector::from_fn(points.len().max(5), |i, _| flat.get(i).map_or(0.0, |p| p.norm_squared()));
    let qr = rows.qr();
    let Some(s) = qr.r().solve_upper_triangular(&qr.q().tr_mul(&right)) else { return Vec::new() };
    let centre = x * s[0] + y * s[1];
    let radius = (s[2] + s[0] * s[0] + s[1] * s[1]).max(0.0).sqrt();
    let slopes = [s[3] / (2.0 * radius), s[4].max(0.0).sqrt().copysign(s[3])];
    slopes.iter().filter_map(|&slope| ConeModel::new(centre, *z, radius, slope)).collect()
}

pub(super) fn cones<const CONE: bool>(points: &[Vector3<f64>]) -> Vec<ConeModel<CONE>> {
    let judges = thinned(points, JUDGES);
    let mut models = Vec::new();
    let list = directions(points, &axes_of_normals(points));
    for z in &list {
        models.extend(cones_along(&judges, z).into_iter().map(|m| (cost_of(&m, &judges), *z, m)));
    }
    let mut found = best(models, 10);
    if CONE {
        // A slender cone is found from a cylinder.
        let straight =
            |z| cones_along::<false>(&judges, z).into_iter().map(|m| (cost_of(&m, &judges), *z, m));
        let cylinders = best(list.iter().flat_map(straight).collect(), 10).into_iter().take(3);
        found.extend(
            cylinders.filter_map(|c| ConeModel::new(c.pose.point, c.pose.z, 1.0 / c.curvature, 0.01)),
        );
    }
    found
}

/// The best of random axes through few points.
pub(super) fn cone_from_few<const CONE: bool>(
    points: &[Vector3<f64>],
    random: &mut Random,
    count: usize,
) -> Vec<ConeModel<CONE>> {
    let mut models = Vec::new();
    for _ in 0..TRIES {
        let z = random.direction();
        models.extend(cones_along(points, &z).into_iter().map(|m| (cost_of(&m, points), z, m)));
    }
    best(models, count)
}

/// The best of random axes near few points.
pub(super) fn torus_from_few(points: &[Vector3<f64>], random: &mut Random, count: usize) -> Vec<TorusModel> {
    let mut models = Vec::new();
    for _ in 0..TRIES {
        let z = random.direction();
        let axis = mean(points) + random.direction() * (2.0 * random.centred());
        models.extend(torus_around(points, axis, &z).map(|m| (cost_of(&m, points), z, m)));
    }
    best(models, count)
}

/// The torus around an axis: a circle through the points turned into one half plane.
fn torus_around(points: &[Vector3<f64>], axis: Vector3<f64>, z: &Vector3<f64>) -> Option<TorusModel> {
    let profile: Vec<Vector2<f64>> = points
        .iter()
        .map(|p| {
            let d = p - axis;
            let height = d.dot(z);
            Vector2::new((d - z * height).norm(), height)
        })
        .collect();
    let (centre, radius) = taubin(&profile)?;
    TorusModel::new(axis + z * centre.y, *z, centre.x, radius)
}

pub(super) fn torus(points: &[Vector3<f64>]) -> Vec<TorusModel> {
    let judges = thinned(points, JUDGES);
    let centre = mean(points);
    let lines = axes_of_normals(points);
    let mut models = Vec::new();
    for (point, z) in &lines {
        if let Some(model) = torus_around(&judges, *point, z) {
            models.push((cost_of(&model, &judges), *z, model));
        }
    }
    for z in directions(points, &lines) {
        let (flat, [x, y]) = along(&judges, &z);
        let ring = taubin(&flat).map(|(c, _)| x * c.x + y * c.y);
        for axis in std::iter::once(centre).chain(ring) {
            if let Some(model) = torus_around(&judges, axis, &z) {
                models.push((cost_of(&model, &judges), z, model));
            }
        }
    }
    best(models, 16)
}
