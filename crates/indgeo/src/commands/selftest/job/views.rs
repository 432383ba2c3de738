//! Registration of many views.

use super::shapes::{motion, scattered};
use super::{Checks, Failure, largest};
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::register::Pose;
use industrial_geometry::register::views::{View, ViewsOptions, register_views};
use std::ops::ControlFlow;

pub(super) fn add(checks: &mut Checks) {
    checks.add("three views of a sphere", "all centres fall together (up to the sampling)", 1e-3, sphere);
    checks.add("three views of a free-form body", "the motions back (up to the sampling)", 1e-4, body);
}

/// Directions from which the views see: 50 degrees apart.
fn towards(view: usize) -> Vector3<f64> {
    let angle = 50f64.to_radians() * view as f64;
    Vector3::new(angle.cos(), angle.sin(), 0.0)
}

/// Each view has points of its own.
fn seen(view: usize, count: usize, radius: impl Fn(&Vector3<f64>) -> f64) -> Vec<Vector3<f64>> {
    let direction = |i: usize| {
        let (z, angle) = (2.0 * scattered(i, 0) - 1.0, std::f64::consts::TAU * scattered(i, 1));
        Vector3::new((1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z)
    };
    let all = (0..3 * count).map(|i| direction(i + 7919 * (view + 1)));
    all.filter(|d| d.dot(&towards(view)) > 0.0).map(|d| d * radius(&d)).collect()
}

fn poses(clouds: &[Vec<Vector3<f64>>], start: &[Pose<3>]) -> Result<Vec<Pose<3>>, Failure> {
    let views: Vec<View> = clouds.iter().map(|points| View::new(points)).collect();
    let go = |_: usize, _: usize| ControlFlow::Continue(());
    let report = register_views(&views, start, &ViewsOptions::default(), &go)?;
    Ok(report.views.iter().map(|view| view.pose).collect())
}

fn sphere() -> Result<f64, Failure> {
    let clouds: Vec<_> = (0..3).map(|view| seen(view, 1500, |_| 1.0)).collect();
    let start: Vec<_> = (0..3).map(|view| motion(3.0 * f64::from(view), 0.02 * f64::from(view))).collect();
    let found = poses(&clouds, &start)?;
    Ok(largest(found.iter().map(|pose| pose.apply(&Vector3::zeros()).norm())))
}

fn body() -> Result<f64, Failure> {
    let radius = |d: &Vector3<f64>| {
        1.0 + 0.16 * (2.1 * d.x + 1.3 * d.y + 0.4).sin() + 0.11 * (3.2 * d.z - 2.0 * d.x + 1.1).sin()
    };
    let truth: Vec<_> = (0..3).map(|view| motion(4.0 * f64::from(view), 0.03 * f64::from(view))).collect();
    let clouds: Vec<Vec<_>> = (0..3)
        .map(|view| seen(view, 2000, radius).iter().map(|x| truth[view].inverse().apply(x)).collect())
        .collect();
    let found = poses(&clouds, &[Pose::identity(); 3])?;
    let apart = |view: usize| super::shapes::apart(&clouds[view], &found[view], &truth[view]);
    Ok(largest((0..3).map(apart)))
}
