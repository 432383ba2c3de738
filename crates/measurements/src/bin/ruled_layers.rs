//! A freeform scan approximated by layers of ruled surfaces, and its offset for a cutter of radius r.
//!
//! `cargo run --release -p measurements --bin ruled_layers -- CLOUD.xyz [RADIUS]`
//!
//! The cloud is a tube like the trunk of a body, open at both ends. A closed B-spline surface is fitted to it and taken as the
//! model; sections lie in parallel planes across its axis. Prints distances of the sensor points of each approximation.

use distance_field::{OffsetField, SurfaceField};
use measurements::cases;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Interval, KnotVector, ParametricSurface};
use sdm_fit::ruled::{RuledOptions, fit_ruled};
use sdm_fit::{BaseShape, NetSize, SurfaceOptions, Target, fit_cloud};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let points = cases::points::<3>(arguments.first().ok_or("name a file of points")?)?;
    let size = NetSize { controls: [20, 14], ..NetSize::default() };
    let options = SurfaceOptions::default().with_base(BaseShape::Cylinder).with_size(size);
    let fitted = fit_cloud(&points, &options)?;
    println!("model: {}", fitted.report);
    let model = fitted.surface;
    let diagonal = model.bounding_box(1e-3).diagonal();
    let radius = arguments.get(1).map_or(Ok(0.02 * diagonal), |a| a.parse())?;
    let [u, v] = model.domain();
    let middle =
        |v: f64| (0..40).map(|k| model.point(u.lerp(f64::from(k) / 40.0), v)).sum::<Vector3<f64>>() / 40.0;
    let axis = middle(v.end()) - middle(v.start());
    let field = SurfaceField::new(&model)?;
    let outside = outside(&model, &middle);
    let offset = OffsetField::new(&field, outside * radius)?;
    let options = RuledOptions::default().with_section_normal(Some(axis.into()));
    println!(
        "layers, control points on a section: to the model, to its offset at {radius:.3} (rms, max), turn of normals"
    );
    for (layers, controls) in [(1, 16), (2, 16), (4, 16), (6, 16), (6, 32), (12, 32)] {
        let start = around(&model, layers, controls)?;
        let of = |target| fit_ruled(target, start.clone(), &options);
        let found = of(Target::Model { field: &field, sensors: 4, boundary: true })?.report;
        let milled = of(Target::Model { field: &offset, sensors: 4, boundary: true })?.report;
        println!(
            "{layers:3} {controls:3}: {:.4} {:.4}, {:.4} {:.4}, {:.2}°",
            found.fit.rms,
            found.fit.max,
            milled.fit.rms,
            milled.fit.max,
            found.developability.rms_angle.to_degrees()
        );
    }
    Ok(())
}

/// 1 if the normal of a tube points outwards, otherwise −1.
fn outside(model: &BsplineSurface, middle: &dyn Fn(f64) -> Vector3<f64>) -> f64 {
    let [u, v] = model.domain();
    let half = v.lerp(0.5);
    let outwards = |k: i32| {
        let jet = model.jet(u.lerp(f64::from(k) / 40.0), half);
        jet.du.cross(&jet.dv).dot(&(jet.point - middle(half))).signum()
    };
    (0..40).map(outwards).sum::<f64>().signum()
}

/// Sections of the model, blown up a little so that the start lies around it.
fn around(
    model: &BsplineSurface,
    layers: usize,
    controls: usize,
) -> Result<BsplineSurface, nurbs_core::Error> {
    let knots_u = KnotVector::uniform_periodic(3, controls)?.reparameterized(Interval::UNIT);
    let knots_v = KnotVector::uniform_clamped(1, layers + 1)?;
    let [u, v] = model.domain();
    let mut net = Vec::new();
    for i in 0..knots_u.basis_count() {
        for j in 0..=layers {
            // Away from the very ends, beyond which there is no foot inside.
            let height = v.lerp(0.02 + 0.96 * j as f64 / layers as f64);
            let around = |k: usize| model.point(u.lerp((k % controls) as f64 / controls as f64), height);
            let middle = (0..controls).map(around).sum::<Vector3<f64>>() / controls as f64;
            net.push(middle + (around(i) - middle) * 1.1);
        }
    }
    BsplineSurface::new(knots_u, knots_v, net, None)
}
