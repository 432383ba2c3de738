//! A scan that is moved back to its model, free, and with the height and the tilt held as by a table.
//!
//! ```sh
//! cargo run -p industrial-geometry --example register_with_lock
//! ```

use industrial_geometry::distance_field::SurfaceField;
use industrial_geometry::nurbs::nalgebra::{Rotation3, Vector3};
use industrial_geometry::nurbs::{BsplineSurface, KnotVector, ParametricSurface};
use industrial_geometry::register::{Locks, Pose, RegisterOptions, Source, register};

/// Registers twice and prints both motions.
pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let knots = KnotVector::uniform_clamped(3, 6)?;
    let height = |i: u8, j: u8| [0.0, 0.9, -0.6, 0.4, 1.1][usize::from(2 * i + 3 * j) % 5];
    let net =
        (0..36).map(|k| (k / 6, k % 6)).map(|(i, j)| Vector3::new(f64::from(i), f64::from(j), height(i, j)));
    let model = BsplineSurface::new(knots.clone(), knots, net.collect(), None)?;

    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.1);
    let place = |k: u16| model.point(f64::from(k / 20) / 19.0, f64::from(k % 20) / 19.0);
    let scan: Vec<_> = (0..400).map(|k| turn * place(k) + Vector3::new(0.2, -0.1, 0.0)).collect();

    let field = SurfaceField::new(&model)?;
    let table = Locks::default().with_translations([false, false, true]).with_rotations([true, true, false]);
    for (name, options) in
        [("free", RegisterOptions::default()), ("on a table", RegisterOptions::default().with_locks(table))]
    {
        let found = register(&field, &Source::new(&scan), &Pose::identity(), &options)?;
        println!("{name}: {found}");
        assert!(found.is_converged() && found.rms < 1e-10);
        // The motion back takes every point of the scan to the model.
        assert!((found.pose.apply(&scan[210]) - place(210)).norm() < 1e-9);
    }
    Ok(())
}
