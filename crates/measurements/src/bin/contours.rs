//! Level sets as curves, as distances and as trees: errors against closed forms.

#![allow(clippy::print_stdout, reason = "a program that prints its results")]

use distance_field::adaptive::{AdaptiveField, AdaptiveOptions};
use distance_field::grid::redistance;
use distance_field::{Grid, Saddles};
use footpoint::CurveProjector;
use level_set::{FitOptions, FittedContour, Image, Inside, contours, fit_contours, threshold};
use nalgebra::{Vector2, Vector3};
use nurbs_core::ParametricCurve;
use std::f64::consts::TAU;

type Failure = Box<dyn std::error::Error>;

/// Samples from both sides.
const SAMPLES: u32 = 20_000;

/// The star `r = 1 + 0.3 cos 5φ`.
fn star(a: f64) -> Vector2<f64> {
    Vector2::new(a.cos(), a.sin()) * (1.0 + 0.3 * (5.0 * a).cos())
}

/// Negative inside of the star; no distance.
fn level(p: &Vector2<f64>) -> f64 {
    p.norm() - 1.0 - 0.3 * (5.0 * p.y.atan2(p.x)).cos()
}

/// The distance of a point near the star from it.
fn off_star(p: &Vector2<f64>) -> f64 {
    let (mut middle, mut reach) = (p.y.atan2(p.x), 0.3);
    for _ in 0..7 {
        let at = |k: i32| middle + reach * f64::from(k) / 30.0;
        let far = |k: &i32| (star(at(*k)) - p).norm();
        let nearest = (-30..=30).min_by(|a, b| far(a).total_cmp(&far(b)));
        middle = at(nearest.unwrap_or(0));
        reach /= 15.0;
    }
    (star(middle) - p).norm()
}

/// Largest distances between a curve and the star, with a centre and a scale: of the curve, and of the star.
fn gaps(fitted: &FittedContour, centre: Vector2<f64>, scale: f64) -> [f64; 2] {
    let domain = fitted.curve.domain();
    let share = |k: u32| f64::from(k) / f64::from(SAMPLES);
    let point = |k: u32| (fitted.curve.point(domain.lerp(share(k))) - centre) / scale;
    let forth = (0..SAMPLES).map(|k| off_star(&point(k)) * scale).fold(0.0, f64::max);
    let projector = CurveProjector::new(&fitted.curve);
    let places: Vec<_> = (0..SAMPLES).map(|k| centre + star(TAU * share(k)) * scale).collect();
    let back = projector.project_all(&places).iter().map(|foot| foot.distance).fold(0.0, f64::max);
    [forth, back]
}

fn on_a_grid() -> Result<(), Failure> {
    println!("star on a signed grid of 256 x 256, distances as shares of its size");
    let grid = Grid::sample(Vector2::repeat(-1.5), Vector2::repeat(3.0 / 255.0), [256, 256], level)?;
    let field = contours(&grid, Saddles::Middle)?;
    for controls in [24, 36, 48, 72] {
        let options = FitOptions::default().with_controls(Some(controls)).with_abs_tolerance(1e-3);
        let fitted = fit_contours(&field, field.contours(), &options)?;
        let [forth, back] = gaps(&fitted[0], Vector2::zeros(), 1.0).map(|gap| gap / 2.6);
        println!("{controls:4} control points: curve {forth:.2e}, star {back:.2e}");
    }
    Ok(())
}

fn in_an_image() -> Result<(), Failure> {
    println!("star in a grey image of 256 x 256 (8 bits, areas of pixels), distances in pixels");
    let (n, scale, samples) = (256usize, 256.0 / 3.0, 24usize);
    let centre = Vector2::new(128.3, 127.6);
    let value = |pixel: usize| {
        let (column, row) = (pixel % n, n - 1 - pixel / n);
        let step = |k: usize| (k as f64 + 0.5) / samples as f64;
        let is_inside = |k: &usize| {
            let p = Vector2::new(column as f64 + step(k % samples), row as f64 + step(k / samples));
            level(&((p - centre) / scale)) < 0.0
        };
        let count = (0..samples * samples).filter(is_inside).count();
        (255.0 * count as f64 / (samples * samples) as f64).round()
    };
    let image = Image::new(n, n, (0..n * n).map(value).collect())?;
    let otsu = threshold::otsu(&image)?;
    for smoothing in [0.0, 0.7, 1.0, 1.5] {
        let field = contours(&image.level_function(otsu, Inside::Bright, smoothing)?, Saddles::Middle)?;
        for controls in [None, Some(36)] {
            let options = FitOptions::default().with_controls(controls).with_abs_tolerance(0.02);
            let fitted = fit_contours(&field, field.contours(), &options)?;
            let [forth, back] = gaps(&fitted[0], centre, scale);
            println!(
                "smoothing {smoothing:.1}, {:3} control points: curve {forth:.3}, star {back:.3}",
                fitted[0].controls
            );
        }
    }
    Ok(())
}

fn distances() -> Result<(), Failure> {
    println!(
        "distances from level functions that are none, within 0.12 of the zero set: mean and largest error"
    );
    let circle = |p: &Vector2<f64>| (p.norm_squared() - 1.0) * (2.0 + (1.3 * p.x).sin());
    let from_circle = |p: &Vector2<f64>| (p.norm() - 1.0).abs();
    type Function<'a> = &'a dyn Fn(&Vector2<f64>) -> f64;
    let shapes: [(&str, Function<'_>, Function<'_>); 2] =
        [("circle", &circle, &from_circle), ("star", &level, &off_star)];
    for (name, function, right) in shapes {
        let mut last: Option<[f64; 2]> = None;
        for nodes in [65usize, 129, 257, 513] {
            let h = 3.2 / (nodes - 1) as f64;
            let grid = Grid::sample(Vector2::repeat(-1.6), Vector2::repeat(h), [nodes, nodes], function)?;
            let found = redistance(&grid, Some(0.2))?;
            let (mut sum, mut most, mut count) = (0.0, 0.0f64, 0usize);
            for (node, value) in
                found.grid.values().iter().enumerate().filter(|(_, value)| value.abs() < 0.12)
            {
                let error = (value.abs() - right(&grid.position(node))).abs();
                (sum, most, count) = (sum + error, most.max(error), count + 1);
            }
            let errors = [sum / count.max(1) as f64, most];
            let orders = last.map(|last| [0, 1].map(|k: usize| (last[k] / errors[k]).log2()));
            let order = orders.map_or_else(String::new, |[a, b]| format!(", orders {a:.2} and {b:.2}"));
            println!("{name:6} {nodes:3}^2: {:.2e} {:.2e}{order}", errors[0], errors[1]);
            last = Some(errors);
        }
    }
    Ok(())
}

fn trees() -> Result<(), Failure> {
    println!(
        "adaptively sampled distance of a torus (radii 1 and 0.4) within 0.1 of it: leaves for an error"
    );
    let torus = |p: &Vector3<f64>| (p.xy().norm() - 1.0).hypot(p.z) - 0.4;
    for tolerance in [2e-3, 5e-4] {
        for degree in 1..=3 {
            let options = AdaptiveOptions::default()
                .with_abs_tolerance(tolerance)
                .with_band(Some(0.1))
                .with_degree(degree);
            let (_, report) =
                AdaptiveField::build(Vector3::repeat(-1.7), Vector3::repeat(1.7), &options, torus)?;
            println!(
                "{tolerance:.0e}, degree {degree}: {:6} leaves, error {:.2e}",
                report.leaves, report.largest_error
            );
        }
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    on_a_grid()?;
    in_an_image()?;
    distances()?;
    trees()
}
