//! Parts that nearly have a symmetry: which turn they are in, and what tells it.

use crate::common::Random;
use crate::symmetry::{prism, regular};
use distance_field::{DistanceField, MeshField, MeshGeometry, MeshOptions, Search};
use mesh_core::TriangleMesh;
use nalgebra::Vector3;
use sdm_register::start::OrientedPoints;
use sdm_register::{Comparison, FreeMotion, Pose, is_symmetry, rival_poses, rotation, surface_left_out};

fn exact(mesh: &TriangleMesh) -> MeshField {
    MeshField::with_options(mesh, &MeshOptions::default().with_geometry(MeshGeometry::Exact)).unwrap()
}

/// A turn about z by an angle in degrees.
fn turn(degrees: f64) -> Pose<3> {
    let angle = degrees.to_radians();
    Pose::new(rotation::exponential::<3>(&Vector3::new(0.0, 0.0, angle)).0, Vector3::zeros())
}

fn distances(field: &MeshField, points: &[Vector3<f64>], pose: &Pose<3>) -> Vec<f64> {
    let moved: Vec<Vector3<f64>> = points.iter().map(|x| pose.apply(x)).collect();
    field.frames(&moved, Search::Global, &[]).iter().map(|frame| frame.distance).collect()
}

#[test]
fn a_prism_with_one_corner_cut_is_turned_to_where_it_belongs() {
    // Of 15 corners one is missing: 24 degrees from one position to the next, which is no step of 30.
    let mut corners = regular(15, 1.0);
    corners.remove(4);
    let mesh = prism(&corners, 0.4, &Pose::identity());
    let (field, samples) = (exact(&mesh), OrientedPoints::from_mesh(&mesh, 12_000));
    let mut random = Random::new(8);
    let points: Vec<Vector3<f64>> =
        samples.points().iter().step_by(4).map(|x| x + random.vector() * 2e-4).collect();
    for steps in [1.0, 4.0, 7.0] {
        let wrong = turn(24.0 * steps);
        let found = rival_poses(&field, &samples, &points, &wrong);
        let off = |pose: &Pose<3>| points.iter().map(|x| (pose.apply(x) - x).norm()).fold(0.0, f64::max);
        let offsets: Vec<f64> = found.iter().map(off).collect();
        assert!(offsets.iter().any(|off| *off < 0.05), "{steps}: {offsets:?}");
        // The poses are roughly known; that to which a registration leads from there is the identity.
        let [own, other] = [&wrong, &Pose::identity()].map(|pose| distances(&field, &points, pose));
        assert!(Comparison::of(&own, &other, 2.0).is_second_better(), "{steps}");
        assert!(!is_symmetry(&field, &samples, &wrong.inverse(), 0.0), "{steps}");
    }
    // Of the whole prism each of these is a symmetry.
    let whole = prism(&regular(15, 1.0), 0.4, &Pose::identity());
    let (field, samples) = (exact(&whole), OrientedPoints::from_mesh(&whole, 12_000));
    assert!(is_symmetry(&field, &samples, &turn(96.3), 0.0));
    assert!(!is_symmetry(&field, &samples, &turn(108.0), 0.0));
}

#[test]
fn a_block_has_no_rivals_but_those_of_half_turns() {
    let corners = vec![[0.0, 0.0], [5.0, 0.0], [5.0, 1.0], [2.0, 3.0], [0.0, 3.0]];
    let mesh = prism(&corners, 1.0, &Pose::identity());
    let samples = OrientedPoints::from_mesh(&mesh, 12_000);
    assert!(rival_poses(&exact(&mesh), &samples, samples.points(), &Pose::identity()).len() <= 4);
    assert!(rival_poses(&exact(&mesh), &OrientedPoints::default(), &[], &Pose::identity()).is_empty());
}

/// Distances of 3000 points in two poses: 15 % outliers, and some points that lie on the model in the first alone.
fn pair(noise: f64, misfits: usize) -> [Vec<f64>; 2] {
    let mut random = Random::new(9);
    let (mut first, mut second) = (Vec::new(), Vec::new());
    for k in 0..3000 {
        if k < 450 {
            first.push(0.2 * random.uniform());
            second.push(0.2 * random.uniform());
        } else {
            let own = noise * random.normal();
            first.push(own);
            second.push(if k < 450 + misfits { 0.02 } else { own * 1.01 });
        }
    }
    [first, second]
}

#[test]
fn few_points_decide_where_the_others_fit_both() {
    for noise in [0.0, 1e-4, 1e-3] {
        let [first, second] = pair(noise, 40);
        let compared = Comparison::of(&first, &second, 1.0);
        assert!(compared.is_first_better() && !compared.is_second_better(), "{noise}: {compared:?}");
        assert!(Comparison::of(&second, &first, 1.0).is_second_better(), "{noise}");
        let [first, second] = pair(noise, 0);
        let compared = Comparison::of(&first, &second, 1.0);
        assert!(!compared.is_first_better() && !compared.is_second_better(), "{noise}: {compared:?}");
    }
    assert_eq!(Comparison::of(&[], &[], 1.0).evidence, 0.0);
    assert!(Comparison::of(&[f64::NAN; 20], &[0.0; 20], 1.0).is_second_better());
}

#[test]
fn scattered_points_are_told_from_a_patch() {
    let mut random = Random::new(4);
    let mut unit = || random.uniform();
    let mut points: Vec<Vector3<f64>> = (0..3000).map(|_| Vector3::new(unit(), unit(), 0.0)).collect();
    for _ in 0..40 {
        points.push(Vector3::new(0.1 * unit(), 0.1 * unit(), 0.3));
    }
    for _ in 0..300 {
        points.push(Vector3::from_fn(|_, _| unit()));
    }
    points.push(Vector3::repeat(f64::NAN));
    let is_out: Vec<bool> = (0..points.len()).map(|i| i >= 3000).collect();
    let found = surface_left_out(&points, &is_out);
    let count = |range: std::ops::Range<usize>| found[range].iter().filter(|found| **found).count();
    assert_eq!(count(0..3000), 0);
    assert!(count(3000..3040) >= 32, "{}", count(3000..3040));
    assert!(count(3040..3340) <= 15, "{}", count(3040..3340));
    assert!(!found[3340]);
    assert_eq!(surface_left_out(&points[..3], &[true, false, true]), [false; 3]);
}

#[test]
fn a_notch_fixes_the_turn_that_a_round_part_leaves_free() {
    let about = FreeMotion::Rotation { axis: Vector3::z(), point: Vector3::zeros() };
    let along = FreeMotion::Translation { direction: Vector3::z() };
    let round = regular(240, 1.0);
    let mut notched = round.clone();
    notched.drain(10..22);
    for (corners, fixes) in [(round, false), (notched, true)] {
        let mesh = prism(&corners, 0.7, &Pose::identity());
        let samples = OrientedPoints::from_mesh(&mesh, 12_000);
        assert_eq!(about.is_fixed_by(&exact(&mesh), &samples), fixes);
        // The ends of a solid fix its place along the axis.
        assert!(along.is_fixed_by(&exact(&mesh), &samples));
    }
}
