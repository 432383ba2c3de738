//! The covariance of a pose against the normal equations written down by hand: few points near straight edges and plane
//! faces, where rows, residuals and eigenvalues are known in closed form.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use distance_field::{CurveField, DistanceField, MeshField, MeshGeometry, MeshOptions};
use mesh_core::TriangleMesh;
use nalgebra::{DMatrix, DVector, Point3, Rotation2, SVector, Vector2, Vector3};
use nurbs_core::{BsplineCurve, KnotVector};
use sdm_register::{
    Covariance, Locks, Outliers, Pose, RegisterOptions, RegisterReport, Source, register, rotation,
};

const SIDES: [f64; 3] = [8.0, 6.0, 5.0];

/// A point beside a face: the axis it is normal to, whether it is the upper one, the other coordinates, the deviation.
fn beside<const D: usize>(axis: usize, upper: bool, at: [f64; 2], deviation: f64) -> SVector<f64, D> {
    let mut others = at.into_iter();
    SVector::from_fn(|i, _| match (i == axis, upper) {
        (true, true) => SIDES[i] + deviation,
        (true, false) => -deviation,
        _ => others.next().unwrap(),
    })
}

/// Outward normal and signed distance of a point near one face of the box.
fn face<const D: usize>(x: &SVector<f64, D>) -> (SVector<f64, D>, f64) {
    let all = (0..D).flat_map(|i| [(i, -1.0, -x[i]), (i, 1.0, x[i] - SIDES[i])]);
    let (axis, sign, distance) = all.min_by(|a, b| a.2.abs().total_cmp(&b.2.abs())).unwrap();
    (SVector::from_fn(|i, _| if i == axis { sign } else { 0.0 }), distance)
}

/// `⟨n, v(x)⟩` for the displacement of the origin, the rotation about it, and the growth.
fn row<const D: usize>(n: &SVector<f64, D>, x: &SVector<f64, D>) -> Vec<f64> {
    let turn = match D {
        2 => vec![x[0] * n[1] - x[1] * n[0]],
        _ => Vector3::new(x[0], x[1], x[2]).cross(&Vector3::new(n[0], n[1], n[2])).as_slice().to_vec(),
    };
    n.iter().copied().chain(turn).chain([n.dot(x)]).collect()
}

/// What must come out, from the pose found alone.
struct ByHand {
    rows: DMatrix<f64>,
    /// `BᵀJᵀWJB / σ̂²`.
    information: DMatrix<f64>,
    sigma: f64,
    degrees_of_freedom: usize,
    conditioning: f64,
}

/// The normal equations in the directions `basis` (one column each, translations first).
fn by_hand<const D: usize>(
    points: &[SVector<f64, D>],
    weights: &[f64],
    pose: &Pose<D>,
    basis: &DMatrix<f64>,
    translations: usize,
) -> ByHand {
    let taking_part: Vec<usize> = (0..points.len()).filter(|&i| weights[i] > 0.0).collect();
    let n = taking_part.len();
    let centre = taking_part.iter().map(|&i| points[i]).sum::<SVector<f64, D>>() / n as f64;
    let origin = pose.apply(&centre);
    let mean_weight = taking_part.iter().map(|&i| weights[i]).sum::<f64>() / n as f64;
    let unknowns = basis.ncols();
    let (mut matrix, mut gradient) = (DMatrix::zeros(unknowns, unknowns), DVector::zeros(unknowns));
    let mut squares = 0.0;
    for &i in &taking_part {
        let weight = weights[i] / mean_weight;
        let image = pose.apply(&points[i]);
        let (normal, distance) = face(&image);
        let mut all = row(&normal, &(image - origin));
        // Distances count in the unit of the source, which grows with it.
        *all.last_mut().unwrap() -= distance;
        let row = basis.tr_mul(&DVector::from_fn(basis.nrows(), |k, _| all[k]));
        matrix += &row * row.transpose() * weight;
        gradient += &row * (weight * distance);
        squares += weight * distance * distance;
    }
    assert!(gradient.norm() < 1e-10, "not the minimum: {gradient}");
    let degrees_of_freedom = n - unknowns;
    let variance = squares / degrees_of_freedom as f64;
    let extent = |axis: usize| {
        let coordinates = taking_part.iter().map(|&i| points[i][axis]);
        coordinates.clone().fold(f64::NEG_INFINITY, f64::max) - coordinates.fold(f64::INFINITY, f64::min)
    };
    let half_diagonal = 0.5 * pose.scale * (0..D).map(|axis| extent(axis).powi(2)).sum::<f64>().sqrt();
    let unit = |i: usize| if i < translations { half_diagonal } else { 1.0 };
    let scaled = DMatrix::from_fn(unknowns, unknowns, |i, j| unit(i) * matrix[(i, j)] * unit(j));
    let eigenvalues = scaled.symmetric_eigenvalues();
    ByHand {
        rows: basis * matrix.clone().try_inverse().unwrap() * basis.transpose() * variance,
        information: matrix / variance,
        sigma: variance.sqrt(),
        degrees_of_freedom,
        conditioning: eigenvalues.min() / eigenvalues.max(),
    }
}

fn check<const D: usize>(found: &Covariance<D>, expected: &ByHand) {
    let rows = DMatrix::from_fn(found.rows.len(), found.rows.len(), |i, j| found.rows[i][j]);
    let size = |i: usize| expected.rows[(i, i)].sqrt();
    assert_eq!(rows.shape(), expected.rows.shape());
    for i in 0..rows.nrows() {
        for j in 0..rows.ncols() {
            let difference = (rows[(i, j)] - expected.rows[(i, j)]).abs();
            assert!(
                difference <= 1e-9 * size(i) * size(j),
                "{i} {j}: {} instead of {}",
                rows[(i, j)],
                expected.rows[(i, j)]
            );
        }
    }
    assert_eq!(found.degrees_of_freedom, expected.degrees_of_freedom);
    assert!((found.sigma / expected.sigma - 1.0).abs() < 1e-9, "{} {}", found.sigma, expected.sigma);
    let ratio = found.conditioning / expected.conditioning;
    assert!((ratio - 1.0).abs() < 1e-9, "{} {}", found.conditioning, expected.conditioning);
}

fn run<const D: usize>(
    field: &dyn DistanceField<D>,
    points: &[SVector<f64, D>],
    weights: &[f64],
    options: &RegisterOptions<D>,
) -> RegisterReport<D> {
    let options = options.with_outliers(Outliers::None);
    let report =
        register(field, &Source::new(points).with_weights(weights), &Pose::identity(), &options).unwrap();
    assert!(report.is_converged(), "{report}");
    report
}

fn rectangle() -> CurveField<2> {
    let corners = [[0.0, 0.0], [8.0, 0.0], [8.0, 6.0], [0.0, 6.0], [0.0, 0.0]].map(Vector2::from);
    let knots = KnotVector::new(1, vec![0.0, 0.0, 8.0, 14.0, 22.0, 28.0, 28.0]).unwrap();
    CurveField::new(&BsplineCurve::new(knots, corners.to_vec(), None).unwrap()).unwrap()
}

fn beside_the_rectangle() -> (Vec<Vector2<f64>>, Vec<f64>) {
    let points = [
        (1, false, 1.5, 0.02),
        (1, false, 6.0, -0.01),
        (0, true, 2.0, 0.015),
        (1, true, 5.0, 0.03),
        (0, false, 3.5, -0.025),
        (0, true, 4.5, -0.01),
    ];
    let points = points.map(|(axis, upper, at, deviation)| beside(axis, upper, [at, 0.0], deviation));
    (points.to_vec(), vec![0.5, 3.0, 1.0, 2.5, 7.0, 4.0])
}

fn identity(n: usize) -> DMatrix<f64> {
    DMatrix::identity(n, n)
}

#[test]
fn a_few_weighted_points_beside_a_rectangle() {
    let (field, options) = (rectangle(), RegisterOptions::default());
    let (mut points, mut weights) = beside_the_rectangle();
    for all_alike in [true, false] {
        let weights = if all_alike { vec![1.0; points.len()] } else { weights.clone() };
        let report = run(&field, &points, &weights, &options);
        let expected = by_hand(&points, &weights, &report.pose, &identity(4).columns(0, 3).into_owned(), 2);
        // The growth is no unknown: its row and column are not shown.
        let expected = ByHand { rows: expected.rows.view((0, 0), (3, 3)).into_owned(), ..expected };
        check(&report.covariance.unwrap(), &expected);
    }
    // Weights are relative, and points without weight are none.
    points.insert(2, Vector2::new(100.0, -50.0));
    weights.insert(2, 0.0);
    let one = run(&field, &points, &weights, &options).covariance.unwrap();
    let thousandfold: Vec<f64> = weights.iter().map(|w| w * 1e3).collect();
    let other = run(&field, &points, &thousandfold, &options).covariance.unwrap();
    assert_eq!((one.degrees_of_freedom, other.degrees_of_freedom), (3, 3));
    assert!((one.sigma / other.sigma - 1.0).abs() < 1e-9, "{} {}", one.sigma, other.sigma);
    for (a, b) in one.rows.iter().flatten().zip(other.rows.iter().flatten()) {
        assert!((a - b).abs() <= 1e-9 * a.abs().max(1e-8), "{a} {b}");
    }
}

#[test]
fn an_unknown_scale_takes_a_degree_of_freedom() {
    let (points, weights) = beside_the_rectangle();
    let report = run(&rectangle(), &points, &weights, &RegisterOptions::default().with_scale(true));
    let expected = by_hand(&points, &weights, &report.pose, &identity(4), 2);
    assert_eq!(expected.degrees_of_freedom, 2);
    check(&report.covariance.unwrap(), &expected);
}

#[test]
fn directions_that_depend_on_each_other_count_with_their_correlation() {
    // The heights are all taken at one end, so that height and rotation nearly make up for each other.
    let points = [
        (1, false, 1.0, 0.01),
        (1, false, 1.1, -0.02),
        (1, false, 1.2, 0.015),
        (0, true, 3.0, 0.02),
        (0, true, 3.2, -0.01),
    ]
    .map(|(axis, upper, at, deviation)| beside::<2>(axis, upper, [at, 0.0], deviation));
    let weights = [1.0, 2.0, 0.5, 1.0, 3.0];
    let report = run(&rectangle(), &points, &weights, &RegisterOptions::default());
    let expected = by_hand(&points, &weights, &report.pose, &identity(4).columns(0, 3).into_owned(), 2);
    let rows = expected.rows.view((0, 0), (3, 3)).into_owned();
    let correlation = rows[(1, 2)] / (rows[(1, 1)] * rows[(2, 2)]).sqrt();
    assert!(1.0 - correlation.abs() < 1e-2, "{correlation}");
    let covariance = report.covariance.clone().unwrap();
    let information = expected.information.clone();
    check(&covariance, &ByHand { rows, ..expected });
    let (t, w) = (Vector2::new(1e-3, -2e-3), 3e-3);
    let motion = Pose {
        source_origin: covariance.origin,
        target_origin: covariance.origin + t,
        ..Pose::new(Rotation2::new(w).into_inner(), Vector2::zeros())
    };
    let difference = DVector::from_vec(vec![t.x, t.y, w]);
    let squared = difference.dot(&(information * &difference));
    let found = covariance.squared_distance(&report.pose, &report.pose.followed_by(&motion));
    assert!((found / squared - 1.0).abs() < 1e-8, "{found} {squared}");
}

#[test]
fn a_locked_direction_has_no_variance() {
    let (points, weights) = beside_the_rectangle();
    let axes = Rotation2::new(0.5).into_inner();
    let lock_origin = Vector2::new(3.0, -1.0);
    let locks = Locks::default().with_frame(lock_origin, axes).with_translations([true, false, false]);
    let report = run(&rectangle(), &points, &weights, &RegisterOptions::default().with_locks(locks));
    let covariance = report.covariance.clone().unwrap();
    // The system slides along the second axis, and turns about the point that was the origin of the locks.
    let along = axes.column(1).into_owned();
    let pivot = report.pose.apply(&lock_origin);
    assert!((pivot - lock_origin).dot(&axes.column(0)).abs() < 1e-12);
    let arm = covariance.origin - pivot;
    #[rustfmt::skip]
    let basis = DMatrix::from_row_slice(4, 2, &[
        along.x, -arm.y,
        along.y, arm.x,
        0.0, 1.0,
        0.0, 0.0,
    ]);
    let expected = by_hand(&points, &weights, &report.pose, &basis, 1);
    let shown = expected.rows.view((0, 0), (3, 3)).into_owned();
    let information = expected.information.clone();
    check(&covariance, &ByHand { rows: shown, ..expected });
    // A small motion that the locks allow: its squared distance is that of the two unknowns alone.
    let (slide, turn) = (1e-6, -2e-6);
    let motion = Pose {
        source_origin: pivot,
        target_origin: pivot + along * slide,
        ..Pose::new(Rotation2::new(turn).into_inner(), Vector2::zeros())
    };
    let unknowns = DVector::from_vec(vec![slide, turn]);
    let squared = unknowns.dot(&(information * &unknowns));
    let found = covariance.squared_distance(&report.pose, &report.pose.followed_by(&motion));
    assert!((found / squared - 1.0).abs() < 1e-5, "{found} {squared}");
}

fn cuboid() -> MeshField {
    let corner = |i: u8| {
        let side = |k: usize| SIDES[k] * f64::from(i >> k & 1);
        Point3::new(side(0), side(1), side(2))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap();
    MeshField::with_options(&mesh, &MeshOptions::default().with_geometry(MeshGeometry::Exact)).unwrap()
}

#[test]
fn points_beside_a_cuboid_with_and_without_scale() {
    let field = cuboid();
    let mut points = Vec::new();
    for axis in 0..3 {
        for (k, upper) in [false, true].into_iter().enumerate() {
            for j in 0..2 {
                let deviation =
                    0.01 * f64::from([3, -2, 5, 1, -4, 2, -1, 4, 2, -3, 1, -5][4 * axis + 2 * k + j]);
                points.push(beside::<3>(
                    axis,
                    upper,
                    [1.3 + 2.1 * j as f64, 3.2 - 1.7 * j as f64],
                    deviation,
                ));
            }
        }
    }
    let weights: Vec<f64> = (0..points.len()).map(|i| [1.0, 4.0, 0.25, 2.0, 3.0][i % 5]).collect();
    for scale in [false, true] {
        let report = run(&field, &points, &weights, &RegisterOptions::default().with_scale(scale));
        let unknowns = if scale { 7 } else { 6 };
        let expected =
            by_hand(&points, &weights, &report.pose, &identity(7).columns(0, unknowns).into_owned(), 3);
        let shown = expected.rows.view((0, 0), (unknowns, unknowns)).into_owned();
        let covariance = report.covariance.clone().unwrap();
        check(&covariance, &ByHand { rows: shown.clone(), ..expected });
        // The squared distance of a pose: displacement of the origin, rotation vector, growth, each by itself and all.
        let [t, w] = [Vector3::new(0.3, -0.2, 0.5), Vector3::new(-0.02, 0.05, 0.01)];
        let growth = if scale { 0.03 } else { 0.0 };
        let none = Vector3::zeros();
        for (t, w, growth) in [(t, none, 0.0), (none, w, 0.0), (none, none, growth), (t, w, growth)] {
            let motion = Pose {
                scale: f64::exp(growth),
                rotation: rotation::exponential::<3>(&w).0,
                source_origin: covariance.origin,
                target_origin: covariance.origin + t,
            };
            let difference = DVector::from_iterator(
                unknowns,
                t.iter().chain(w.iter()).copied().chain([growth]).take(unknowns),
            );
            let squared = difference.dot(&(shown.clone().try_inverse().unwrap() * &difference));
            let found = covariance.squared_distance(&report.pose, &report.pose.followed_by(&motion));
            assert!((found - squared).abs() <= 1e-8 * squared + 1e-18, "{t} {w} {growth}: {found} {squared}");
        }
    }
}
