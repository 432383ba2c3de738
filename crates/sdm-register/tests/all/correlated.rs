//! The covariance of a pose when the errors of neighbouring points are alike.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small counts")]

use crate::common::{Random, model};
use distance_field::SurfaceField;
use nalgebra::Vector3;
use nurbs_core::ParametricSurface;
use sdm_register::{Outliers, Pose, RegisterOptions, Source, register};

/// An error that changes smoothly over the parameters: independent numbers on a grid of `cells × cells`, and in between bilinear
/// with a smooth step, scaled to the variance 1 on average.
struct Smooth {
    cells: usize,
    values: Vec<f64>,
    shift: [f64; 2],
}

impl Smooth {
    fn new(cells: usize, random: &mut Random) -> Self {
        let values = (0..(cells + 2) * (cells + 2)).map(|_| random.normal()).collect();
        Self { cells, values, shift: [random.uniform(), random.uniform()] }
    }

    fn at(&self, u: f64, v: f64) -> f64 {
        let [x, y] = [u * self.cells as f64 + self.shift[0], v * self.cells as f64 + self.shift[1]];
        let (i, j) = (x.floor() as usize, y.floor() as usize);
        let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
        let (s, t) = (smooth(x.fract()), smooth(y.fract()));
        let value = |i: usize, j: usize| self.values[i * (self.cells + 2) + j];
        let along = |j: usize| (1.0 - s) * value(i, j) + s * value(i + 1, j);
        ((1.0 - t) * along(j) + t * along(j + 1)) * 1.35
    }
}

/// Mean of the squared distances of the true pose, in units of the covariance, over many scans; 6 is right.
fn mean_squared_distance(cells: Option<usize>, white: f64, count: usize, runs: u64) -> (f64, f64) {
    let surface = model();
    let field = SurfaceField::new(&surface).unwrap();
    let options = RegisterOptions::default().with_outliers(Outliers::None);
    let (mut sum, mut alike) = (0.0, 0.0);
    for run in 1..=runs {
        let mut random = Random::new(100 * run);
        // The first numbers of seeds next to each other are alike.
        for _ in 0..100 {
            let _ = random.uniform();
        }
        let error = cells.map(|cells| Smooth::new(cells, &mut random));
        let points: Vec<Vector3<f64>> = (0..count)
            .map(|_| {
                let (u, v) = (0.02 + 0.96 * random.uniform(), 0.02 + 0.96 * random.uniform());
                let jet = surface.jet(u, v);
                let height = error.as_ref().map_or(0.0, |error| error.at(u, v)) + white * random.normal();
                jet.point + jet.unit_normal().unwrap() * (1e-3 * height)
            })
            .collect();
        let report = register(&field, &Source::new(&points), &Pose::identity(), &options).unwrap();
        assert!(report.is_converged(), "{report}");
        let covariance = report.covariance.as_ref().unwrap();
        sum += covariance.squared_distance(&report.pose, &Pose::identity());
        alike += covariance.points_per_independent;
    }
    (sum / runs as f64, alike / runs as f64)
}

#[test]
fn independent_errors_give_the_plain_covariance() {
    let (mean, alike) = mean_squared_distance(None, 1.0, 800, 60);
    assert!(mean > 4.8 && mean < 7.2 && alike < 1.05, "{mean} {alike}");
}

#[test]
fn errors_that_neighbours_share_widen_it() {
    for (cells, white, count) in [(24, 0.0, 6000), (16, 0.5, 4000), (40, 0.0, 8000)] {
        let (mean, alike) = mean_squared_distance(Some(cells), white, count, 50);
        assert!(alike > 1.5, "{cells} {white} {count}: {alike}");
        // Fifty runs tell the mean to half a unit.
        assert!(mean > 4.5 && mean < 8.0, "{cells} {white} {count}: {mean}, {alike} points count as one");
    }
}
