//! Points measured against a shaft of radius 5 with a tolerance of 0.05.
//!
//! ```sh
//! cargo run -p industrial-geometry --example inspect
//! ```

use industrial_geometry::inspection::{InspectionOptions, Nominal, Tolerance};
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::nurbs::{Cylinder, Frame, Interval};

/// Prints the verdict, the distribution and the worst points.
pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let frame = Frame::new(Vector3::zeros(), Vector3::z(), Vector3::x())?;
    let shaft = Nominal::from_analytic(&[Cylinder::new(frame, 5.0, Interval::new(0.0, 20.0)?)?.into()])?;

    // Turned a little oval, with one burr.
    let mut points: Vec<Point3<f64>> = (0..500)
        .map(|i| {
            let angle = f64::from(i) * 2.399_963;
            let radius = 5.0 + 0.03 * (2.0 * angle).cos();
            Point3::new(radius * angle.cos(), radius * angle.sin(), f64::from(i) * 0.04)
        })
        .collect();
    points.push(Point3::new(5.12, 0.0, 10.0));

    let inspection = shaft.inspect(&points, &InspectionOptions::new(Tolerance::symmetric(0.05)?))?;
    let total = &inspection.total;
    println!(
        "pass: {}; {} within, {} over, {} under",
        inspection.verdict.pass, total.within, total.over, total.under
    );
    for worst in inspection.worst.iter().take(3) {
        println!("point {}: {:+.4}", worst.index, worst.distance);
    }
    assert!(!inspection.verdict.pass && total.over == 1 && inspection.worst[0].index == 500);
    Ok(())
}
