//! Registration of clouds to shapes.

use super::shapes::{apart, motion, scattered, wavy};
use super::{Checks, Failure, largest};
use crate::runtime::threads;
use industrial_geometry::distance_field::{CurveField, MeshField, SurfaceField};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::mesh::nalgebra::{DMatrix, DVector, Point3, Rotation2, Vector2, Vector3};
use industrial_geometry::nurbs::{
    BsplineCurve, Cylinder, Frame, Interval, KnotVector, ParametricCurve, ParametricSurface, Plane, Sphere,
};
use industrial_geometry::register::{
    DatumTarget, FreeMotion, Locks, Outliers, Pose, RegisterOptions, Source, align_datum, register,
};

pub(super) fn add(checks: &mut Checks) {
    checks.add("stationary pose", "x = s + r n with Jᵀr = 0: the identity is the optimum", 1e-12, stationary);
    checks.add("motion of 10°", "points of the surface, moved: the motion back", 1e-12, || recovered(10.0));
    checks.add("motion of 30°", "points of the surface, moved: the motion back", 1e-12, || recovered(30.0));
    checks.add("half of the points outliers", "the motion back", 1e-12, outliers);
    checks.add("unknown scale", "points of the surface, 3 % smaller: 1.03", 1e-12, scale);
    checks.add("locked rotations", "a pure shift: the shift back, no rotation", 1e-12, locks);
    checks.add("faces of a box (mesh)", "points of the faces, moved: the motion back", 1e-12, on_a_mesh);
    checks.add("curve in the plane", "points of the curve, moved: the motion back", 1e-12, in_the_plane);
    checks.add("datum targets 3-2-1", "six planes that a motion put out of place", 1e-12, datum);
    checks.add("plane", "two translations and a rotation are free; no motion along them", 1e-9, || {
        free_motions(0, [2, 1])
    });
    checks.add("sphere", "three rotations are free; no motion along them", 1e-9, || free_motions(1, [0, 3]));
    checks.add("cylinder", "a translation and a rotation are free; no motion along them", 1e-9, || {
        free_motions(2, [1, 1])
    });
    checks.add("covariance", "height of n points off a plane by ±s: s²/(n − 1)", 1e-12, covariance);
    checks.add("1, 2 and 3 threads", "the same bits", 0.0, same_bits);
}

/// The field of a surface, points on it, and their unit normals.
type Scanned = (SurfaceField, Vec<Vector3<f64>>, Vec<Vector3<f64>>);

/// Points of the surface away from its edges, and their unit normals.
fn on_surface(count: usize) -> Result<Scanned, Failure> {
    let surface = wavy()?;
    let jet = |i: usize| surface.jet(0.1 + 0.8 * scattered(i, 0), 0.1 + 0.8 * scattered(i, 1));
    let points = (0..count).map(|i| jet(i).point).collect();
    let normals = (0..count).map(|i| jet(i).unit_normal().unwrap_or_default()).collect();
    Ok((SurfaceField::new(&surface)?, points, normals))
}

/// The gradient of `Σ d²` in the velocity `(c̄, c)` is `2 Jᵀr` with the rows `(n, s × n)`: residuals at right angles to
/// the six columns of `J` leave the pose where it is.
fn stationary() -> Result<f64, Failure> {
    let (field, points, normals) = on_surface(600)?;
    let rows = DMatrix::from_fn(points.len(), 6, |i, k| {
        if k < 3 { normals[i][k] } else { points[i].cross(&normals[i])[k - 3] }
    });
    let wanted = DVector::from_fn(points.len(), |i, _| 0.1 * (scattered(i, 2) - 0.5));
    // Twice is enough to remove what rounding leaves of the components along the columns.
    let mut residuals = wanted;
    for _ in 0..2 {
        let normal_equations = rows.tr_mul(&rows).cholesky().ok_or("the columns depend on each other")?;
        let share = normal_equations.solve(&rows.tr_mul(&residuals));
        residuals -= &rows * share;
    }
    let moved: Vec<Vector3<f64>> = (0..points.len()).map(|i| points[i] + normals[i] * residuals[i]).collect();
    let options = RegisterOptions::default().with_outliers(Outliers::None);
    let report = register(&field, &Source::new(&moved), &Pose::identity(), &options)?;
    let rms = (residuals.norm_squared() / points.len() as f64).sqrt();
    Ok(largest([apart(&moved, &report.pose, &Pose::identity()), (report.rms - rms).abs()]))
}

fn recovered(degrees: f64) -> Result<f64, Failure> {
    let (field, points, _) = on_surface(600)?;
    let truth = motion(degrees, 0.3);
    let moved: Vec<_> = points.iter().map(|x| truth.inverse().apply(x)).collect();
    let report = register(&field, &Source::new(&moved), &Pose::identity(), &RegisterOptions::default())?;
    Ok(apart(&moved, &report.pose, &truth))
}

fn outliers() -> Result<f64, Failure> {
    let (field, points, normals) = on_surface(800)?;
    let truth = motion(15.0, 0.2);
    let off = |i: usize| if i < 400 { 0.0 } else { 0.2 + 1.5 * scattered(i, 2) };
    let moved: Vec<_> = (0..800).map(|i| truth.inverse().apply(&(points[i] + normals[i] * off(i)))).collect();
    let report = register(&field, &Source::new(&moved), &Pose::identity(), &RegisterOptions::default())?;
    Ok(apart(&moved[..400], &report.pose, &truth))
}

fn scale() -> Result<f64, Failure> {
    let (field, points, _) = on_surface(600)?;
    let truth = motion(5.0, 0.1);
    let moved: Vec<_> = points.iter().map(|x| truth.inverse().apply(x) / 1.03).collect();
    let options = RegisterOptions::default().with_scale(true).with_outliers(Outliers::None);
    let report = register(&field, &Source::new(&moved), &Pose::identity(), &options)?;
    Ok((report.pose.scale - 1.03).abs())
}

fn locks() -> Result<f64, Failure> {
    let (field, points, _) = on_surface(600)?;
    let shift = Vector3::new(0.1, -0.2, 0.15);
    let moved: Vec<_> = points.iter().map(|x| x - shift).collect();
    let options = RegisterOptions::default().with_locks(Locks::default().with_rotations([true; 3]));
    let report = register(&field, &Source::new(&moved), &Pose::identity(), &options)?;
    Ok(largest([(report.pose.translation() - shift).norm(), report.pose.rotation_vector().norm()]))
}

/// A box of 1 × 2 × 3: distances from its faces are exact.
fn on_a_mesh() -> Result<f64, Failure> {
    let sides = Vector3::new(1.0, 2.0, 3.0);
    let corner = |k: u8| {
        Point3::from(sides.component_mul(&Vector3::new(
            f64::from(k & 1),
            f64::from(k >> 1 & 1),
            f64::from(k >> 2 & 1),
        )))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let field = MeshField::new(&TriangleMesh::new((0..8).map(corner).collect(), triangles)?)?;
    let truth = motion(4.0, 0.05);
    let moved: Vec<_> = (0..600)
        .map(|i| {
            let mut x = Vector3::from_fn(|k, _| 0.15 + 0.7 * scattered(i, k));
            x[i % 3] = if i % 2 == 0 { 0.0 } else { 1.0 };
            truth.inverse().apply(&x.component_mul(&sides))
        })
        .collect();
    let report = register(&field, &Source::new(&moved), &Pose::identity(), &RegisterOptions::default())?;
    Ok(apart(&moved, &report.pose, &truth))
}

fn in_the_plane() -> Result<f64, Failure> {
    let control = [[0.0, 0.0], [1.0, 2.0], [3.0, 2.5], [4.0, -1.0], [6.0, 0.5], [7.0, 3.0]];
    let curve = BsplineCurve::<2>::new(
        KnotVector::uniform_clamped(3, 6)?,
        control.map(Vector2::from).to_vec(),
        None,
    )?;
    let truth = Pose::<2>::new(Rotation2::new(0.2).into_inner(), Vector2::new(0.2, 0.3));
    let points: Vec<_> =
        (0..200).map(|i| truth.inverse().apply(&curve.point(0.05 + 0.9 * scattered(i, 0)))).collect();
    let field = CurveField::new(&curve)?;
    let report = register(&field, &Source::new(&points), &Pose::identity(), &RegisterOptions::default())?;
    Ok(largest(points.iter().map(|x| (report.pose.apply(x) - truth.apply(x)).norm())))
}

fn datum() -> Result<f64, Failure> {
    let truth = motion(20.0, 3.0);
    let plane = |nominal: [f64; 3], axis: usize| {
        let nominal = Vector3::from(nominal);
        DatumTarget::new(truth.inverse().apply(&nominal), nominal, Vector3::ith(axis, 1.0))
    };
    let targets = [
        plane([1.0, 1.0, 0.0], 2),
        plane([9.0, 1.5, 0.0], 2),
        plane([5.0, 6.0, 0.0], 2),
        plane([1.0, 0.0, 1.0], 1),
        plane([9.0, 0.0, 2.0], 1),
        plane([0.0, 3.0, 1.0], 0),
    ];
    let report = align_datum(&targets, &Pose::identity())?;
    let points: Vec<_> = targets.iter().map(|target| target.point).collect();
    Ok(apart(&points, &report.pose, &truth))
}

/// The motions that slide a plane, a sphere or a cylinder along itself are named, and the cloud does not move along them:
/// lifted by 0.05 from where it was slid to, it comes straight down. Where names are missing the deviation is 1 and more.
fn free_motions(shape: usize, [translations, rotations]: [usize; 2]) -> Result<f64, Failure> {
    let range = Interval::new(-9.0, 9.0)?;
    let frame = Frame::WORLD;
    let surface = match shape {
        0 => Plane::new(frame, range, range).to_nurbs()?,
        1 => Sphere::new(frame, 1.0)?.to_nurbs()?,
        _ => Cylinder::new(frame, 1.0, range)?.to_nurbs()?,
    };
    let [u, v] = surface.domain();
    let at = |range: &Interval, share: f64| range.start() + range.length() * (0.35 + 0.3 * share);
    let points: Vec<_> =
        (0..500).map(|i| surface.point(at(&u, scattered(i, 0)), at(&v, scattered(i, 1)))).collect();
    let report = register(
        &SurfaceField::new(&surface)?,
        &Source::new(&points),
        &Pose::identity(),
        &RegisterOptions::default(),
    )?;
    let count = |test: fn(&FreeMotion<3>) -> bool| report.free_motions.iter().filter(|m| test(m)).count();
    let wrong = count(|m| matches!(m, FreeMotion::Translation { .. })).abs_diff(translations)
        + count(|m| matches!(m, FreeMotion::Rotation { .. })).abs_diff(rotations);
    Ok(largest([wrong as f64, apart(&points, &report.pose, &Pose::identity())]))
}

/// Only the height is free: with residuals `±s` its variance is `σ̂²/n`, `σ̂² = n s²/(n − 1)`.
fn covariance() -> Result<f64, Failure> {
    let range = Interval::new(-9.0, 9.0)?;
    let field = SurfaceField::new(&Plane::new(Frame::WORLD, range, range).to_nurbs()?)?;
    let (n, s) = (400, 0.01);
    let height = |i: usize| if i.is_multiple_of(2) { s } else { -s };
    let points: Vec<_> =
        (0..n).map(|i| Vector3::new(4.0 * scattered(i, 0), 3.0 * scattered(i, 1), height(i))).collect();
    let locks = Locks::default().with_translations([true, true, false]).with_rotations([true; 3]);
    let options = RegisterOptions::default().with_locks(locks).with_outliers(Outliers::None);
    let report = register(&field, &Source::new(&points), &Pose::identity(), &options)?;
    let variance = report.covariance.ok_or("there is no covariance")?.rows[2][2];
    Ok((variance / (s * s / (n - 1) as f64) - 1.0).abs())
}

fn same_bits() -> Result<f64, Failure> {
    let (field, points, normals) = on_surface(9000)?;
    let truth = motion(12.0, 0.2);
    let moved: Vec<_> = (0..points.len())
        .map(|i| truth.inverse().apply(&(points[i] + normals[i] * (0.02 * (scattered(i, 2) - 0.5)))))
        .collect();
    let run = |count| {
        threads::with_threads(Some(count), || {
            Ok(register(&field, &Source::new(&moved), &Pose::identity(), &RegisterOptions::default()))
        })
    };
    let first = run(1)??.pose;
    let mut different = 0;
    for count in [2, 3] {
        different += usize::from(run(count)??.pose != first);
    }
    Ok(different as f64)
}
