//! Least squares nets over the parameters of a base surface.

use super::base_shape::{BaseShape, NetSize};
use crate::Error;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Interval, KnotVector, SurfaceFitOptions};

/// Factor of the thin plate energy of the first least squares fit, whose domain is the unit square.
const STIFFNESS: f64 = 1e-7;

/// The least squares surface with given knots at the parameters of a base, with poles where it has them.
pub(crate) fn approximate(
    points: &[Vector3<f64>],
    shape: BaseShape,
    parameters: &[[f64; 2]],
    knots: [KnotVector; 2],
) -> Result<BsplineSurface, Error> {
    let options = SurfaceFitOptions::default().with_regularization(STIFFNESS);
    let surface = BsplineSurface::approximate(knots, parameters, points, &options)?.shape;
    if shape != BaseShape::Sphere {
        return Ok(surface);
    }
    let (u, v, mut net, _) = surface.into_parts();
    let columns = v.basis_count();
    let rows = net.len() / columns;
    for column in [0, columns - 1] {
        let pole = (0..u.distinct_count()).map(|i| net[i * columns + column]).sum::<Vector3<f64>>()
            / u.distinct_count() as f64;
        (0..rows).for_each(|i| net[i * columns + column] = pole);
    }
    Ok(BsplineSurface::new(u, v, net, None)?)
}
/// The knots of a surface over a base.
pub(crate) fn knots(base: BaseShape, size: NetSize) -> Result<[KnotVector; 2], Error> {
    let closed = base != BaseShape::Plane;
    let u = if closed {
        KnotVector::uniform_periodic(size.degrees[0], size.controls[0])?
            .reparameterized(Interval::new(0.0, 1.0)?)
    } else {
        KnotVector::uniform_clamped(size.degrees[0], size.controls[0])?
    };
    let v = if base == BaseShape::Torus {
        KnotVector::uniform_periodic(size.degrees[1], size.controls[1])?
            .reparameterized(Interval::new(0.0, 1.0)?)
    } else {
        KnotVector::uniform_clamped(size.degrees[1], size.controls[1])?
    };
    Ok([u, v])
}
