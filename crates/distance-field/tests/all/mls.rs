//! Moving least squares surfaces against spheres, cylinders, planes and tori that are known.

use distance_field::{DistanceField, Error, Hint, MlsField, MlsOptions, Search};
use footpoint::Status;
use nalgebra::{Point3, Vector3};

/// Numbers from -1 to 1 that repeat themselves late.
fn noise(seed: u32) -> impl FnMut() -> f64 {
    let mut state = u64::from(seed) * 2 + 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from((state >> 33) as u32) / f64::from(1u32 << 30) - 1.0
    }
}

/// Even points of a sphere with outward normals.
fn sphere(count: u32, radius: f64, centre: &Vector3<f64>) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
    (0..count)
        .map(|i| {
            let (z, angle) =
                (1.0 - f64::from(2 * i + 1) / f64::from(count), 2.399_963_229_728_653 * f64::from(i));
            let ring = (1.0 - z * z).sqrt();
            let normal = Vector3::new(ring * angle.cos(), ring * angle.sin(), z);
            (Point3::from(centre + normal * radius), normal)
        })
        .unzip()
}

#[test]
fn points_of_a_sphere_with_normals_give_the_sphere() {
    let centre = Vector3::new(1e5, -3.0, 20.0);
    let (points, normals) = sphere(3000, 2.0, &centre);
    let field = MlsField::new(&points, Some(&normals)).unwrap();
    for offset in [Vector3::new(0.3, -0.9, 1.4), Vector3::new(3.0, 4.0, -1.0), Vector3::new(0.0, 2.0, 0.1)] {
        let frame = field.frame(&(centre + offset), Search::Global, &Hint::NONE);
        assert_eq!(frame.status, Status::Converged);
        assert!((frame.distance - (offset.norm() - 2.0)).abs() < 1e-9, "{}", frame.distance);
        assert!((frame.foot - (centre + offset.normalize() * 2.0)).norm() < 1e-9);
        // Convex towards the outside: it bends away from the normal.
        assert!((frame.curvatures.xy() - Vector3::repeat(-0.5).xy()).norm() < 1e-6, "{}", frame.curvatures);
    }
    let (value, gradient) = field.value(&(centre + Vector3::new(0.0, 0.0, 2.1))).unwrap();
    assert!((value - (2.1f64.powi(2) - 4.0) / 4.0).abs() < 1e-9 && (gradient.z - 1.05).abs() < 1e-8);
    assert!(field.value(&centre).is_none());
}

#[test]
fn noise_is_averaged_and_feet_are_orthogonal() {
    // A torus, noise of a hundredth of the small radius.
    let (large, small) = (3.0, 1.0);
    let mut random = noise(1);
    let points: Vec<_> = (0..20_000)
        .map(|_| {
            let (u, v) = (3.2 * random(), 3.2 * random());
            let ring = large + (small + 0.01 * random()) * v.cos();
            Point3::new(ring * u.cos(), ring * u.sin(), (small + 0.01 * random()) * v.sin())
        })
        .collect();
    let field = MlsField::with_options(&points, None, &MlsOptions::default().with_reach(4.0)).unwrap();
    let exact = |x: &Vector3<f64>| ((x.xy().norm() - large).hypot(x.z) - small).abs();
    let mut sum = 0.0;
    for _ in 0..200 {
        let x = Vector3::new(3.0 + random(), 1.5 * random(), random());
        let frame = field.frame(&x, Search::Global, &Hint::NONE);
        if (x.xy().norm() - large).hypot(x.z) < 0.3 {
            continue;
        }
        assert!(frame.status.is_converged(), "{:?} at {x}", frame.status);
        let off = frame.distance.abs() - exact(&x);
        assert!(off.abs() < 6e-3, "{off} at {x}");
        sum += off * off;
        let residual = x - frame.foot;
        assert!((residual - frame.normal() * frame.distance).norm() < 1e-8);
    }
    assert!((sum / 200.0).sqrt() < 2e-3, "{sum}");
}

#[test]
fn a_cloud_ends_where_its_points_end() {
    let points: Vec<_> =
        (0..900u16).map(|i| Point3::new(f64::from(i % 30), f64::from(i / 30), 0.0)).collect();
    let normals = vec![Vector3::z(); points.len()];
    let field = MlsField::new(&points, Some(&normals)).unwrap();
    let inside = field.frame(&Vector3::new(12.3, 14.6, -2.0), Search::Global, &Hint::NONE);
    assert!((inside.distance + 2.0).abs() < 1e-10 && !inside.on_boundary);
    assert!(inside.curvatures.norm() < 1e-9);
    let beside = field.frame(&Vector3::new(40.0, 14.0, 0.0), Search::Global, &Hint::NONE);
    assert!(beside.on_boundary && (beside.distance - 11.0).abs() < 1e-9, "{}", beside.distance);
}

#[test]
fn spacings_may_differ() {
    // Ten times denser on one half of a plane; what is looked at lies around the change.
    let mut points = Vec::new();
    for i in 0..60u16 {
        for j in 0..60u16 {
            points.push(Point3::new(-0.1 * f64::from(i), 0.1 * f64::from(j), 0.0));
        }
    }
    for i in 0..20u16 {
        for j in 0..6u16 {
            points.push(Point3::new(1.0 + f64::from(i), f64::from(j), 0.0));
        }
    }
    let normals = vec![Vector3::z(); points.len()];
    let field = MlsField::new(&points, Some(&normals)).unwrap();
    for x in [-3.0, -0.5, 0.4, 0.9, 3.0, 8.0] {
        let frame = field.frame(&Vector3::new(x, 2.9, 0.7), Search::Global, &Hint::NONE);
        assert!((frame.distance - 0.7).abs() < 1e-9, "{} at {x}", frame.distance);
    }
}

#[test]
fn bad_input_is_refused_or_left_out() {
    let (points, normals) = sphere(200, 1.0, &Vector3::zeros());
    assert!(matches!(MlsField::new(&[], None), Err(Error::NoPoints { .. } | Error::Mesh(_))));
    let two = [Point3::origin(), Point3::new(1.0, 0.0, 0.0)];
    assert!(matches!(MlsField::new(&two, None), Err(Error::NoNormals { count: 2 })));
    assert!(matches!(MlsField::new(&points, Some(&normals[1..])), Err(Error::Mesh(_))));
    for reach in [f64::NAN, 1.0, f64::INFINITY] {
        let options = MlsOptions::default().with_reach(reach);
        assert!(matches!(MlsField::with_options(&points, None, &options), Err(Error::Option { .. })));
    }
    let (mut more, mut directions) = (points.clone(), normals.clone());
    more.extend([Point3::new(f64::NAN, 0.0, 0.0), Point3::new(1e300, 0.0, 0.0)]);
    directions.extend([Vector3::x(), Vector3::zeros()]);
    let x = Vector3::new(0.0, 0.0, 1.5);
    let one = MlsField::new(&points, Some(&normals)).unwrap().frame(&x, Search::Global, &Hint::NONE);
    let other = MlsField::new(&more, Some(&directions)).unwrap().frame(&x, Search::Global, &Hint::NONE);
    assert!((one.distance - other.distance).abs() < 1e-12);
    assert_eq!(
        MlsField::new(&points, None).unwrap().frame(&(x * f64::NAN), Search::Global, &Hint::NONE).status,
        Status::InvalidPoint
    );
    // All points in one place: no surface, and no panic.
    let one_place = MlsField::new(&vec![Point3::origin(); 50], Some(&vec![Vector3::z(); 50])).unwrap();
    assert!(!one_place.frame(&x, Search::Global, &Hint::NONE).status.is_converged());
}
