//! Four scans of one bowl, each out of place, registered to each other all at once.
//!
//! ```sh
//! cargo run --release -p industrial-geometry --example views
//! ```

use industrial_geometry::nurbs::nalgebra::{Rotation3, Vector3};
use industrial_geometry::register::Pose;
use industrial_geometry::register::views::{View, ViewsOptions, register_views};
use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;

/// Registers and prints every pair of views that overlap.
pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Half of a bowl with three lobes, seen from four sides.
    let place = |angle: f64, height: f64| {
        let radius = (1.5 - height * height) * (1.0 + 0.15 * (3.0 * angle).cos());
        Vector3::new(radius * angle.cos(), radius * angle.sin(), height)
    };
    let seen = |side: u8| -> Vec<Vector3<f64>> {
        let from = f64::from(side) * FRAC_PI_2;
        let grid =
            (0..60u32).flat_map(|i| (0..30u32).map(move |j| (f64::from(i) / 59.0, f64::from(j) / 29.0)));
        grid.map(|(a, h)| place(from + std::f64::consts::PI * a, h)).collect()
    };
    let slip = |side: u8| {
        let size = 0.02 * f64::from(side);
        let turn = Rotation3::from_scaled_axis(Vector3::new(size, -size, 0.5 * size)).into_inner();
        Pose::new(turn, Vector3::new(size, size, -size))
    };
    let views: Vec<_> =
        (0..4).map(|s| View::new(&seen(s).iter().map(|x| slip(s).apply(x)).collect::<Vec<_>>())).collect();

    let found = register_views(&views, &[Pose::identity(); 4], &ViewsOptions::default(), &|_, _| {
        ControlFlow::Continue(())
    })?;
    println!("{found}");
    for pair in &found.pairs {
        println!("views {:?}: rms {:.2e} before, {:.2e} after", pair.views, pair.rms_before, pair.rms_after);
    }
    // The first view stays; the others come back to where they were before they slipped.
    let corner = slip(2).apply(&seen(2)[0]);
    assert!((found.views[2].pose.apply(&corner) - seen(2)[0]).norm() < 0.02);
    Ok(())
}
