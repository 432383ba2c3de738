//! How much memory the projectors hold.

use crate::examples;
use footpoint::{CurveProjector, SurfaceProjector};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Error, Frame, KnotVector, Torus};

/// Bytes per Bézier piece of prepared shapes.
pub(super) fn per_piece() -> Result<Vec<(&'static str, usize)>, Error> {
    let knots = KnotVector::uniform_clamped(3, 50)?;
    let net = (0..2500).map(|k| Vector3::new(f64::from(k / 50), f64::from(k % 50), 0.0)).collect();
    let bicubic = BsplineSurface::new(knots.clone(), knots, net, None)?;
    let surface = |s: &BsplineSurface| {
        let projector = SurfaceProjector::new(s);
        projector.memory() / projector.patch_count()
    };
    let curve = CurveProjector::new(&examples::curve()?);
    Ok(vec![
        ("cubic plane curve", curve.memory() / curve.piece_count()),
        ("bicubic surface, 50 x 50", surface(&bicubic)),
        ("torus (rational biquadratic)", surface(&Torus::new(Frame::WORLD, 3.0, 1.0)?.to_nurbs()?)),
    ])
}
