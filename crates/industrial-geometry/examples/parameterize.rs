//! Parameters for a cloud around an axis of which nothing is known, and the surface that they lead to.
//!
//! ```sh
//! cargo run --release -p industrial-geometry --example parameterize
//! ```

use industrial_geometry::cloud_param::{
    Error, FitOptions, ParameteriseOptions, fit_parameters, parameterise,
};
use industrial_geometry::nurbs::nalgebra::Vector3;

/// Finds a base surface, parameters on it, and the least squares surface.
pub(crate) fn main() -> Result<(), Error> {
    let point = |i: u32| {
        let (angle, height) = (f64::from(i) * 2.399_963, (f64::from(i) * 0.754_877_7).fract());
        let radius = 1.0 + 0.3 * (5.0 * height).sin();
        Vector3::new(radius * angle.cos(), radius * angle.sin(), 4.0 * height)
    };
    let points: Vec<_> = (0..4000).map(point).collect();

    let found = parameterise(&points, &ParameteriseOptions::default())?;
    println!("{}", found.report);
    for (x, foot) in points.iter().zip(&found.feet).take(3) {
        let [u, v] = foot.parameter;
        println!("({:.3}, {:.3}, {:.3}) at (u, v) = ({:.4}, {:.4})", x.x, x.y, x.z, u, v);
    }
    let options = FitOptions { control_points: [14, 12], ..FitOptions::default() };
    let fit = fit_parameters(&points, &found.base, &found.feet, &found.counts, &options)?;
    println!("14 x 12 control points: rms {:.2e}, max {:.2e}", fit.rms, fit.max);
    assert!(fit.rms < 5e-3 && fit.surface.knots_u().is_periodic());
    Ok(())
}
