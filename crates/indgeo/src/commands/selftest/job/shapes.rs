//! Shapes, points and motions of the cases.

use super::Failure;
use industrial_geometry::mesh::nalgebra::{Rotation3, Vector3};
use industrial_geometry::nurbs::{BsplineSurface, Frame, KnotVector};
use industrial_geometry::register::Pose;

/// Numbers in [0, 1) without order, always the same: multiples of an irrational number.
pub(super) fn scattered(index: usize, direction: usize) -> f64 {
    // Powers of the real root of x⁴ = x + 1: the sequence fills the cube evenly.
    const STEPS: [f64; 3] = [0.819_172_513_396_164, 0.671_043_606_703_789_2, 0.549_700_477_901_970_1];
    (0.5 + (index + 1) as f64 * STEPS[direction % 3]).fract()
}

/// A point of the cube [−1, 1]³.
pub(super) fn in_cube(index: usize) -> Vector3<f64> {
    Vector3::from_fn(|i, _| 2.0 * scattered(index, i) - 1.0)
}

/// A place and directions that are no whole numbers.
pub(super) fn tilted() -> Result<Frame, Failure> {
    Ok(Frame::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(1.0, 1.0, 2.0), Vector3::new(1.0, -1.0, 0.0))?)
}

/// A wavy bicubic surface over [0, 5]², its curvatures below 1.
pub(super) fn wavy() -> Result<BsplineSurface, Failure> {
    let knots = KnotVector::uniform_clamped(3, 6)?;
    let height = |i: usize, j: usize| [0.0, 0.45, -0.3, 0.2, 0.55][(2 * i + 3 * j) % 5];
    let net = (0..36).map(|k| Vector3::new((k / 6) as f64, (k % 6) as f64, height(k / 6, k % 6))).collect();
    Ok(BsplineSurface::new(knots.clone(), knots, net, None)?)
}

/// A turn by `degrees` about an axis that is none of the coordinates', and a shift.
pub(super) fn motion(degrees: f64, shift: f64) -> Pose<3> {
    let axis = Vector3::new(0.6, -0.64, 0.48);
    let turn = Rotation3::from_scaled_axis(axis * degrees.to_radians());
    Pose::new(turn.into_inner(), Vector3::new(0.36, 0.48, -0.8) * shift)
}

/// Largest distance between where two poses take some points.
pub(super) fn apart(points: &[Vector3<f64>], a: &Pose<3>, b: &Pose<3>) -> f64 {
    super::largest(points.iter().map(|x| (a.apply(x) - b.apply(x)).norm()))
}
