//! Principal curvatures of meshes and clouds against closed forms.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

use crate::shapes::{bunny, octasphere, sphere, spread, torus, torus_normal};
use mesh_core::nalgebra::{Point3, Vector3};
use mesh_core::{CurvatureFrame, CurvatureOptions, Error, MeshCurvature, TriangleMesh, estimate_curvature};

/// Principal curvatures of the torus by the angle around the tube, normal outwards.
fn torus_curvatures(tube: f64, v: f64) -> [f64; 2] {
    [-v.cos() / (2.0 + tube * v.cos()), -1.0 / tube]
}

/// Largest and root mean square error of the curvatures, largest error of the directions in radians.
fn torus_errors(tube: f64, parameters: &[[f64; 2]], frames: &[Option<CurvatureFrame>]) -> [f64; 3] {
    let (mut worst, mut sum, mut turned) = (0.0f64, 0.0, 0.0f64);
    for (&[u, v], frame) in parameters.iter().zip(frames) {
        let frame = frame.unwrap();
        assert!(frame.normal.dot(&torus_normal(u, v)) > 0.9);
        let exact = torus_curvatures(tube, v);
        for (found, exact) in frame.curvatures.iter().zip(exact) {
            worst = worst.max((found - exact).abs());
            sum += (found - exact) * (found - exact);
        }
        let around_axis = Vector3::new(-u.sin(), u.cos(), 0.0);
        turned = turned.max(frame.directions[0].cross(&around_axis).norm().asin());
        let handed = frame.directions[0].cross(&frame.directions[1]).dot(&frame.normal);
        assert!((handed - 1.0).abs() < 1e-12);
    }
    [worst, (sum / (2 * frames.len()) as f64).sqrt(), turned]
}

#[test]
fn of_a_sphere_mesh_are_exact() {
    // Normals are exact on spheres, and then so are the forms.
    let mesh = octasphere(3);
    let curvature = MeshCurvature::new(&mesh);
    assert_eq!(curvature.undefined(), 0);
    for frame in curvature.frames() {
        let frame = frame.unwrap();
        assert!(frame.curvatures.iter().all(|kappa| (kappa + 1.0).abs() < 0.01), "{frame:?}");
    }
}

#[test]
fn of_a_torus_mesh_converge() {
    for (jitter, orders) in [(0.0, 1.7), (0.6, 0.7)] {
        let errors: Vec<_> = [24, 48, 96]
            .map(|m| {
                let (mesh, parameters) = torus(0.8, 2 * m, m, jitter);
                torus_errors(0.8, &parameters, MeshCurvature::new(&mesh).smoothed(1).frames())
            })
            .to_vec();
        println!("jitter {jitter}: {errors:.4?}");
        let order = (errors[0][1] / errors[2][1]).log2() / 2.0;
        assert!(order > orders, "{order}");
        assert!(errors[2][1] < 0.04 && errors[2][2] < 0.3);
    }
}

#[test]
fn smoothing_averages_noise() {
    let (mesh, parameters) = torus(0.8, 96, 48, 0.3);
    let noisy = mesh.vertices().iter().enumerate().map(|(i, p)| {
        let [u, v] = parameters[i];
        p + torus_normal(u, v) * (0.004 * (spread(i * i, 0.618_033_988_749_895) - 0.5))
    });
    let mesh = TriangleMesh::new(noisy.collect(), mesh.triangles().to_vec()).unwrap();
    let raw = MeshCurvature::new(&mesh);
    let error = |steps| torus_errors(0.8, &parameters, raw.smoothed(steps).frames())[1];
    let errors = [0, 1, 3].map(error);
    assert!(errors[1] < 0.7 * errors[0] && errors[2] < 0.7 * errors[1], "{errors:?}");
}

#[test]
fn of_a_torus_cloud_converge() {
    let errors: Vec<_> = [24, 48, 96]
        .map(|m| {
            let (mesh, parameters) = torus(0.8, 2 * m, m, 0.6);
            let normals: Vec<_> = parameters.iter().map(|&[u, v]| torus_normal(u, v)).collect();
            let estimate =
                estimate_curvature(mesh.vertices(), Some(&normals), &CurvatureOptions::default()).unwrap();
            assert_eq!(estimate.undefined, 0);
            torus_errors(0.8, &parameters, &estimate.frames)
        })
        .to_vec();
    println!("cloud: {errors:.4?}");
    assert!((errors[0][1] / errors[2][1]).log2() / 2.0 > 0.9, "{errors:?}");
    assert!(errors[2][1] < 0.02, "{errors:?}");
}

#[test]
fn of_quadrics_are_exact() {
    // z = x² / 2 − 3 y² / 2 + slope: heights over the plane of the neighbours are no longer exactly quadratic, so the
    // centre of a symmetric patch is taken, where they are.
    let cloud: Vec<_> = (0..25)
        .map(|i| (0.1 * f64::from(i % 5 - 2), 0.1 * f64::from(i / 5 - 2)))
        .map(|(x, y)| Point3::new(x + 7e5, y, 0.5 * x * x - 1.5 * y * y))
        .collect();
    let up = vec![Vector3::z(); cloud.len()];
    let options = CurvatureOptions::default().with_neighbours(25);
    let frame = estimate_curvature(&cloud, Some(&up), &options).unwrap().frames[12].unwrap();
    assert!(
        (frame.curvatures[0] - 1.0).abs() < 1e-7 && (frame.curvatures[1] + 3.0).abs() < 1e-7,
        "{frame:?}"
    );
    assert!(frame.directions[0].x.abs() > 1.0 - 1e-9);
    let down = vec![-Vector3::z(); cloud.len()];
    let flipped = estimate_curvature(&cloud, Some(&down), &options).unwrap().frames[12].unwrap();
    assert!((flipped.flipped().curvatures[0] - frame.curvatures[0]).abs() < 1e-12);
    assert!((flipped.curvatures[0] - 3.0).abs() < 1e-7);
}

#[test]
fn scale_with_the_unit() {
    let (mesh, _) = torus(0.5, 40, 20, 0.5);
    let small = MeshCurvature::new(&mesh);
    let moved = |factor: f64| {
        mesh.vertices().iter().map(|p| p * factor + Vector3::new(1.0, 2.0, 3.0) * factor).collect()
    };
    for factor in [1e-6, 1e6] {
        let scaled =
            MeshCurvature::new(&TriangleMesh::new(moved(factor), mesh.triangles().to_vec()).unwrap());
        for (one, other) in small.frames().iter().zip(scaled.frames()) {
            let (one, other) = (one.unwrap(), other.unwrap());
            assert!((one.curvatures[0] - other.curvatures[0] * factor).abs() < 1e-9);
            assert!((one.curvatures[1] - other.curvatures[1] * factor).abs() < 1e-9);
        }
    }
}

#[test]
fn interpolation_is_continuous_over_edges() {
    let mesh = octasphere(2);
    let curvature = MeshCurvature::new(&mesh);
    let [a, b, c] = mesh.triangles()[10];
    let other =
        mesh.triangles().iter().find(|t| t.contains(&a) && t.contains(&b) && !t.contains(&c)).unwrap();
    let apex = *other.iter().find(|index| ![a, b].contains(index)).unwrap();
    let one = curvature.interpolate([a, b, c], [0.3, 0.7, 0.0]).unwrap().unwrap();
    let same = curvature.interpolate([b, a, apex], [0.7, 0.3, 0.0]).unwrap().unwrap();
    assert!((one.tensor() - same.tensor()).norm() < 1e-12);
    assert!(curvature.interpolate([a, b, u32::MAX], [1.0, 0.0, 0.0]).is_err());
}

#[test]
fn of_the_bunny_are_finite() {
    let mesh = bunny();
    let curvature = MeshCurvature::new(&mesh);
    let finite = |frame: &CurvatureFrame| {
        frame.curvatures.iter().all(|k| k.is_finite())
            && frame.directions.iter().all(|d| (d.norm() - 1.0).abs() < 1e-12)
    };
    let unused = mesh.vertex_normals().undefined;
    for curvature in [curvature.smoothed(2), curvature] {
        assert!(curvature.frames().iter().flatten().all(finite));
        assert_eq!(curvature.undefined(), unused);
    }
    let estimate = estimate_curvature(mesh.vertices(), None, &CurvatureOptions::default()).unwrap();
    assert!(estimate.frames.iter().flatten().all(finite) && estimate.undefined < 20);
}

#[test]
fn degenerate_input_has_none() {
    let line: Vec<_> = (0..50u8).map(|i| Point3::new(f64::from(i), 2.0 * f64::from(i), 3.0)).collect();
    let ring: Vec<_> =
        (0..24).map(|i| f64::from(i) * 0.2618).map(|t| Point3::new(t.cos(), t.sin(), 0.0)).collect();
    let huge: Vec<_> = sphere(40).iter().map(|p| p * 1e300).collect();
    for cloud in [
        vec![],
        line.clone(),
        vec![Point3::origin(); 30],
        vec![Point3::new(f64::NAN, 0.0, 0.0); 9],
        ring,
        huge,
    ] {
        let estimate = estimate_curvature(&cloud, None, &CurvatureOptions::default()).unwrap();
        assert_eq!(estimate.undefined, cloud.len());
    }
    let few = CurvatureOptions::default().with_neighbours(5);
    assert!(matches!(estimate_curvature(&line, None, &few), Err(Error::TooFew { count: 5, least: 6, .. })));
    assert!(matches!(
        estimate_curvature(&line, Some(&[]), &CurvatureOptions::default()),
        Err(Error::AttributeLength { found: 0, .. })
    ));
    let mesh = TriangleMesh::new(
        vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(2.0, 0.0, 0.0),
            Point3::new(f64::NAN, 0.0, 0.0),
        ],
        vec![[0, 1, 2], [0, 1, 3], [1, 1, 1]],
    )
    .unwrap();
    assert_eq!(MeshCurvature::new(&mesh).smoothed(2).undefined(), 4);
}

#[test]
fn frames_in_one_walk_are_those_of_two() {
    // A bumpy sphere, with a few useless points.
    let mut points: Vec<Point3<f64>> = (0..3000)
        .map(|i| (f64::from(i) + 0.5, f64::from(i) * 2.399_963))
        .map(|(i, turn)| (1.0 - i / 1500.0, turn))
        .map(|(z, turn)| {
            Vector3::new(turn.cos() * (1.0 - z * z).sqrt(), turn.sin() * (1.0 - z * z).sqrt(), z)
        })
        .map(|n| Point3::from(n * (2.0 + 0.1 * (5.0 * n.x).sin() * (4.0 * n.y).cos())))
        .collect();
    points[17].x = f64::NAN;
    points[900] = points[901];
    let index = mesh_core::CloudIndex::new(&points).unwrap();
    let options = mesh_core::FrameOptions::default();
    let (frames, seen) = mesh_core::estimate_frames(&index, &points, None, &options, |i, near, frame| {
        (i, near.len(), frame.is_some())
    })
    .unwrap();
    let normals =
        mesh_core::estimate_normals(&points, &mesh_core::NormalOptions::default().with_neighbours(24))
            .unwrap()
            .normals;
    let curvature = estimate_curvature(&points, Some(&normals), &CurvatureOptions::default()).unwrap();
    for (i, frame) in frames.iter().enumerate() {
        assert_eq!(seen[i], (i, if i == 17 { 0 } else { 24 }, i != 17));
        match (frame, &curvature.frames[i]) {
            (Some(one), Some(two)) => {
                assert!(
                    (one.normal - two.normal).norm() < 1e-12 && one.normal.dot(&points[i].coords) > 0.0,
                    "{i}"
                );
                assert!((one.tensor() - two.tensor()).norm() < 1e-9, "{i}: {one:?} {two:?}");
            }
            (one, two) => assert!(one.is_none() && two.is_none() && i == 17, "{i}"),
        }
    }
    // Given normals tell the sides, and are the frames where no curvature is wanted.
    let inwards: Vec<_> = normals.iter().map(|n| -n).collect();
    let (frames, _) =
        mesh_core::estimate_frames(&index, &points, Some(&inwards), &options, |_, _, _| ()).unwrap();
    assert!(
        frames.iter().zip(&inwards).all(|(frame, n)| frame.is_none_or(|frame| frame.normal.dot(n) > 0.9))
    );
    let flat = mesh_core::FrameOptions { curvature: false, ..options };
    let (frames, _) =
        mesh_core::estimate_frames(&index, &points, Some(&inwards), &flat, |_, _, _| ()).unwrap();
    assert!(
        frames.iter().zip(&inwards).all(|(frame, n)| frame.is_none_or(|f| (f.normal - n).norm() < 1e-15))
    );
    let few = mesh_core::FrameOptions { neighbours: 5, ..options };
    assert!(mesh_core::estimate_frames(&index, &points, None, &few, |_, _, _| ()).is_err());
    assert!(
        mesh_core::estimate_frames(&index, &points, Some(&inwards[1..]), &options, |_, _, _| ()).is_err()
    );
}
