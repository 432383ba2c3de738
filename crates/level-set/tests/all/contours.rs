//! From images and level functions to curves, against closed forms.

use crate::coverage;
use distance_field::{Grid, LevelSetField, Saddles};
use footpoint::CurveProjector;
use level_set::{Error, FitOptions, FittedContour, Image, Inside, contours, fit_contours, threshold};
use nalgebra::Vector2;
use nurbs_core::ParametricCurve;
use std::f64::consts::{PI, TAU};

/// The star `r = 1 + 0.3 cos 5φ`.
fn star(a: f64) -> Vector2<f64> {
    Vector2::new(a.cos(), a.sin()) * (1.0 + 0.3 * (5.0 * a).cos())
}

/// Largest distance between a curve and a closed curve `true_at(angle)` whose radius is `radius(angle)` about `centre`, from both sides.
fn gap(fitted: &FittedContour, centre: Vector2<f64>, scale: f64) -> f64 {
    let projector = CurveProjector::new(&fitted.curve);
    let back = (0..8000).map(|k| centre + star(TAU * f64::from(k) / 8000.0) * scale);
    let back = back.map(|x| projector.project(&x).distance).fold(0.0, f64::max);
    let domain = fitted.curve.domain();
    let far = |x: &Vector2<f64>| {
        // The nearest of the points of the star around the angle of the point, refined twice.
        let p = (x - centre) / scale;
        let (mut middle, mut reach) = (p.y.atan2(p.x), 0.3);
        let mut best = f64::INFINITY;
        for _ in 0..4 {
            let at = |k: i32| middle + reach * f64::from(k) / 30.0;
            let nearest =
                (-30..=30).min_by(|a, b| (star(at(*a)) - p).norm().total_cmp(&(star(at(*b)) - p).norm()));
            middle = at(nearest.unwrap());
            best = (star(middle) - p).norm();
            reach /= 15.0;
        }
        best * scale
    };
    let forth = (0..8000).map(|k| far(&fitted.curve.point(domain.lerp(f64::from(k) / 8000.0))));
    forth.fold(back, f64::max)
}

#[test]
fn a_star_on_a_grid_becomes_36_control_points() {
    let f = |p: &Vector2<f64>| p.norm() - 1.0 - 0.3 * (5.0 * p.y.atan2(p.x)).cos();
    let grid = Grid::sample(Vector2::repeat(-1.5), Vector2::repeat(3.0 / 255.0), [256, 256], f).unwrap();
    let field = contours(&grid, Saddles::Middle).unwrap();
    let options = FitOptions::default().with_controls(Some(36)).with_abs_tolerance(2.6e-4);
    let fitted = fit_contours(&field, field.contours(), &options).unwrap();
    assert_eq!((fitted.len(), fitted[0].controls), (1, 36));
    assert!(fitted[0].is_within && fitted[0].is_closed && !fitted[0].is_hole);
    let error = gap(&fitted[0], Vector2::zeros(), 1.0);
    assert!(error <= 1e-4 * 2.6, "{error}");
}

#[test]
fn a_star_in_an_image_is_found_within_a_twentieth_of_a_pixel() {
    let (n, scale) = (256, 256.0 / 3.0);
    let centre = Vector2::new(128.3, 127.6);
    let inside = |x: f64, y: f64| {
        let p = (Vector2::new(x, y) - centre) / scale;
        p.norm() < 1.0 + 0.3 * (5.0 * p.y.atan2(p.x)).cos()
    };
    // Of 8 bits, as files have it.
    let values = coverage(n, n, 16, inside).iter().map(|share| (share * 255.0).round()).collect();
    let image = Image::new(n, n, values).unwrap();
    let level = threshold::otsu(&image).unwrap();
    assert_eq!(level, 127.5);
    let field =
        contours(&image.level_function(level, Inside::Automatic, 1.0).unwrap(), Saddles::Middle).unwrap();
    let options = FitOptions::default().with_abs_tolerance(0.02);
    let fitted = fit_contours(&field, field.contours(), &options).unwrap();
    assert_eq!(fitted.len(), 1);
    assert!(fitted[0].is_within && fitted[0].controls < 200, "{:?}", fitted[0].controls);
    let error = gap(&fitted[0], centre, scale);
    assert!(error <= 0.05, "{error} pixels");
    // Few control points take the mean of what the pixels do to the contour.
    let fitted = fit_contours(&field, field.contours(), &options.with_controls(Some(36))).unwrap();
    let error = gap(&fitted[0], centre, scale);
    assert!(error <= 0.05, "{error} pixels");
}

#[test]
fn components_and_holes_are_told_apart() {
    // A ring with an island, and a second disc: as one image, dark on bright.
    let inside = |x: f64, y: f64| {
        let r = (x - 40.0).hypot(y - 45.0);
        r < 10.0 || (18.0..30.0).contains(&r) || (x - 90.0).hypot(y - 30.0) < 12.0
    };
    let values = coverage(120, 90, 12, inside).iter().map(|share| 200.0 - 150.0 * share).collect();
    let image = Image::new(120, 90, values).unwrap();
    let level = threshold::otsu(&image).unwrap();
    assert_eq!(image.side(level, Inside::Automatic), Inside::Dark);
    let field =
        contours(&image.level_function(level, Inside::Automatic, 1.0).unwrap(), Saddles::Middle).unwrap();
    let fitted =
        fit_contours(&field, field.contours(), &FitOptions::default().with_abs_tolerance(0.05)).unwrap();
    let radii: Vec<f64> = fitted.iter().map(|c| (c.area / PI).sqrt()).collect();
    let holes: Vec<bool> = fitted.iter().map(|c| c.is_hole).collect();
    assert_eq!(holes, [false, true, false, false]);
    for (found, right) in radii.iter().zip([30.0, 18.0, 12.0, 10.0]) {
        assert!((found - right).abs() < 0.03, "{radii:?}");
    }
    assert!(fitted.iter().all(|c| c.is_within && c.is_closed));
    // Upwards is upwards: the second disc lies below the ring.
    let disc = fitted[2].curve.point(0.0);
    assert!((disc - Vector2::new(90.0, 30.0)).norm() < 12.5, "{disc}");
}

#[test]
fn contours_that_leave_the_image_are_open() {
    let image = Image::new(40, 30, coverage(40, 30, 12, |x, y| y < 12.0 + 4.0 * (x / 6.0).sin())).unwrap();
    let field = contours(&image.level_function(0.5, Inside::Bright, 1.0).unwrap(), Saddles::Middle).unwrap();
    let fitted =
        fit_contours(&field, field.contours(), &FitOptions::default().with_abs_tolerance(0.02)).unwrap();
    assert_eq!(fitted.len(), 1);
    assert!(fitted[0].is_within && !fitted[0].is_closed && !fitted[0].is_hole);
    let domain = fitted[0].curve.domain();
    let ends = [fitted[0].curve.point(domain.start()), fitted[0].curve.point(domain.end())];
    // The inside, below, is on the left: it runs from right to left.
    assert!((ends[0].x - 39.5).abs() < 1e-9 && (ends[1].x - 0.5).abs() < 1e-9, "{ends:?}");
}

#[test]
fn a_tolerance_that_is_not_reached_is_told() {
    let image = Image::new(64, 64, coverage(64, 64, 8, |x, y| (x - 32.0).abs().max((y - 32.0).abs()) < 20.0))
        .unwrap();
    let field = contours(&image.level_function(0.5, Inside::Bright, 1.0).unwrap(), Saddles::Middle).unwrap();
    let options = FitOptions::default().with_controls(Some(6)).with_abs_tolerance(0.1);
    let fitted = fit_contours(&field, field.contours(), &options).unwrap();
    assert!(!fitted[0].is_within && fitted[0].forth.max(fitted[0].back) > 0.1);
    for bad in [options.with_abs_tolerance(f64::NAN), options.with_controls(Some(3)), options.with_degree(1)]
    {
        assert!(matches!(fit_contours(&field, field.contours(), &bad), Err(Error::Option { .. })));
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let image =
        Image::new(48, 48, coverage(48, 48, 8, |x, y| (x - 24.0).hypot(1.7 * (y - 22.0)) < 19.0)).unwrap();
    let run = || {
        let grid = image.level_function(0.5, Inside::Bright, 1.0).unwrap();
        let field = LevelSetField::<2>::new(&grid).unwrap();
        let fitted =
            fit_contours(&field, field.contours(), &FitOptions::default().with_abs_tolerance(0.01)).unwrap();
        fitted[0].curve.control_points().to_vec()
    };
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(run);
    let many = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap().install(run);
    assert_eq!(alone, many);
}
