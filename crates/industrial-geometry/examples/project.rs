//! The closest points of a torus to three points, with the proof that no other point is nearer.
//!
//! ```sh
//! cargo run -p industrial-geometry --example project
//! ```

use industrial_geometry::footpoint::SurfaceProjector;
use industrial_geometry::nurbs::nalgebra::Vector3;
use industrial_geometry::nurbs::{Error, Frame, Torus};

/// Prints a foot for each point.
pub(crate) fn main() -> Result<(), Error> {
    let frame = Frame::new(Vector3::zeros(), Vector3::z(), Vector3::x())?;
    let torus = Torus::new(frame, 3.0, 1.0)?.to_nurbs()?;
    let projector = SurfaceProjector::new(&torus);

    let points = [Vector3::new(5.0, 1.0, 0.5), Vector3::new(0.5, 0.2, 2.0), Vector3::zeros()];
    for (point, foot) in points.iter().zip(projector.project_all(&points)) {
        println!(
            "{point:?}: {:.6} from the torus at (u, v) = ({:.4}, {:.4}); nothing is nearer than {:.6}; {:?}",
            foot.distance, foot.parameter[0], foot.parameter[1], foot.lower_bound, foot.multiplicity
        );
        assert!(foot.lower_bound <= foot.distance);
    }
    Ok(())
}
