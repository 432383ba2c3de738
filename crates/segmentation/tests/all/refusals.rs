//! Input that is no surface, or of another magnitude.

use segmentation::nalgebra::{Point3, Vector3};
use segmentation::{Error, SegmentationOptions, segment};

fn run(points: &[Point3<f64>]) -> Result<segmentation::Segmentation, Error> {
    segment(points, None, &SegmentationOptions::default())
}

fn grid(n: usize, step: f64) -> Vec<Point3<f64>> {
    (0..n * n).map(|i| Point3::new((i % n) as f64 * step, (i / n) as f64 * step, 0.0)).collect()
}

#[test]
fn points_that_span_no_surface_are_refused() {
    assert!(matches!(run(&[]), Err(Error::TooFewPoints { count: 0, .. })));
    assert!(matches!(run(&grid(1, 1.0)), Err(Error::TooFewPoints { count: 1, .. })));
    assert!(matches!(
        run(&[Point3::new(1.0, 2.0, 3.0); 50]),
        Err(Error::Degenerate { what: "in one place" })
    ));
    let line: Vec<_> = (0..100).map(|i| Point3::new(f64::from(i), 2.0 * f64::from(i), 0.0)).collect();
    assert!(matches!(run(&line), Err(Error::Degenerate { what: "on a line" })));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut points = grid(10, 1.0);
        points[37].y = bad;
        assert!(matches!(run(&points), Err(Error::NotFinite { what: "point", index: 37 })));
    }
    for scale in [1e300, 1e-300] {
        assert!(matches!(run(&grid(10, scale)), Err(Error::Magnitude { .. })));
    }
}

#[test]
fn options_and_normals_are_checked() {
    let points = grid(10, 1.0);
    let sigma = |s| SegmentationOptions::default().with_sigma(Some(s));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(segment(&points, None, &sigma(bad)), Err(Error::Option { name: "sigma", .. })));
    }
    let few = SegmentationOptions::default().with_min_points(7);
    assert!(matches!(segment(&points, None, &few), Err(Error::Option { name: "min_points", .. })));
    let normals = vec![Vector3::z(); 99];
    let default = SegmentationOptions::default();
    assert!(matches!(
        segment(&points, Some(&normals), &default),
        Err(Error::Normals { normals: 99, points: 100 })
    ));
    let mut normals = vec![Vector3::z(); 100];
    normals[5].x = f64::NAN;
    assert!(matches!(
        segment(&points, Some(&normals), &default),
        Err(Error::NotFinite { what: "normal", index: 5 })
    ));
}

#[test]
fn few_and_repeated_points_are_no_trouble() {
    for n in [2usize, 3, 4] {
        let found = run(&grid(n, 1.0)).unwrap();
        assert_eq!(found.labels.len(), n * n);
    }
    // Every point ten times: neighbours share their place.
    let points: Vec<_> = grid(12, 0.5).into_iter().flat_map(|p| [p; 10]).collect();
    let found = run(&points).unwrap();
    assert_eq!(found.labels.len(), points.len());
}

#[test]
fn magnitude_and_place_do_not_matter() {
    let near = run(&grid(20, 1.0)).unwrap();
    assert_eq!((near.regions.len(), near.unlabelled()), (1, 0));
    for scale in [1e-80, 1e80] {
        let found = run(&grid(20, scale)).unwrap();
        assert_eq!(found.labels, near.labels);
    }
}
