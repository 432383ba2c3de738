//! A surface through the points of a tube that widens: that it is a tube is found from the points.
//!
//! ```sh
//! cargo run --release -p industrial-geometry --example fit_surface
//! ```

use industrial_geometry::fit::{BaseShape, Error, SurfaceOptions, fit_cloud};
use industrial_geometry::nurbs::nalgebra::Vector3;

/// Fits without any choice.
pub(crate) fn main() -> Result<(), Error> {
    let point = |i: u32| {
        let (angle, height) = (f64::from(i) * 2.399_963, f64::from(i) / 1500.0);
        let radius = 1.0 + height * height;
        Vector3::new(radius * angle.cos(), radius * angle.sin(), 3.0 * height)
    };
    let points: Vec<_> = (0..1500).map(point).collect();

    let fit = fit_cloud(&points, &SurfaceOptions::default())?;
    println!("{}", fit.report);
    let (around, along) = (fit.surface.n_u(), fit.surface.n_v());
    println!("{around} x {along} control points, closed around: {}", fit.surface.knots_u().is_periodic());
    assert_eq!(fit.report.base, Some(BaseShape::Cylinder));
    assert!(fit.report.fit.rms < 1e-3);
    Ok(())
}
