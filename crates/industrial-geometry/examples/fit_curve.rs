//! A closed curve through points of an ellipse in no order, with noise.
//!
//! ```sh
//! cargo run -p industrial-geometry --example fit_curve
//! ```

use industrial_geometry::fit::Error;
use industrial_geometry::fit::curve::{CurveOptions, fit_curve};
use industrial_geometry::nurbs::nalgebra::Vector2;

/// Fits with a tolerance, which decides on the number of control points.
pub(crate) fn main() -> Result<(), Error> {
    let noise = |i: f64| 0.01 * (i * 7.31).sin();
    let point = |i: u32| {
        let i = f64::from(i);
        // Multiples of the golden angle: neighbours in the list are far from each other.
        let (sin, cos) = (i * 2.399_963).sin_cos();
        Vector2::new(3.0 * cos + noise(i), sin + noise(i + 0.5))
    };
    let points: Vec<_> = (0..400).map(point).collect();

    let fit = fit_curve(&points, None, &CurveOptions::default().with_abs_tolerance(Some(0.03)))?;
    let report = &fit.report;
    println!("{report}");
    println!(
        "{} control points; the points are at most {:.4} from the curve, the curve {:.4} from the points",
        report.controls, report.max, report.coverage.max
    );
    assert!(report.closed && report.max <= 0.03 && report.coverage.is_complete());
    Ok(())
}
