//! A surface to start from, from the cloud alone.

use super::approximate::{approximate, knots};
use super::base::choose;
use super::base_shape::{BaseShape, NetSize};
use crate::Error;
use crate::primitive::start;
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;

/// A start, and over what it was found.
#[derive(Clone, Debug)]
pub struct InitialSurface {
    /// The surface.
    pub surface: BsplineSurface,
    /// What the parameters were taken from; never [`BaseShape::Auto`].
    pub base: BaseShape,
    /// Parameters of the points on that base (and so about those of the surface).
    pub parameters: Vec<[f64; 2]>,
}

/// A surface near a cloud: the cloud is projected onto a base shape, and a surface of the given size fitted to the parameters
/// that this gives.
///
/// # Errors
/// [`Error::TooFewPoints`], [`Error::NotFinite`], [`Error::Degenerate`] for clouds that span no surface, [`Error::Shape`] for
/// sizes that do not fit the degrees.
pub fn initial_surface(
    points: &[Vector3<f64>],
    base: BaseShape,
    size: NetSize,
) -> Result<InitialSurface, Error> {
    let (local, middle) = centred(points)?;
    let found = choose(&local, base)?;
    let surface = approximate(&local, found.shape, &found.parameters, knots(found.shape, size)?)?
        .translated(&middle)?;
    Ok(InitialSurface { surface, base: found.shape, parameters: found.parameters })
}

/// Points about their middle, and that, if they span a surface.
pub(crate) fn centred(points: &[Vector3<f64>]) -> Result<(Vec<Vector3<f64>>, Vector3<f64>), Error> {
    if let Some(index) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        let count = points.iter().filter(|p| !p.iter().all(|c| c.is_finite())).count();
        return Err(Error::NotFinite { index, count });
    }
    if points.len() < 4 {
        return Err(Error::TooFewPoints { total: points.len(), finite: points.len(), needed: 4 });
    }
    let middle = start::mean(points);
    let scale = points.iter().map(|p| (p - middle).amax()).fold(0.0, f64::max);
    let rounding = 4.0 * f64::EPSILON * (scale + middle.amax());
    let local: Vec<_> = points.iter().map(|p| p - middle).collect();
    let dimensions = start::rank(&local, rounding);
    if dimensions < 2 {
        let what = ["in one place", "on a line"][dimensions];
        return Err(Error::Degenerate { shape: "a surface", what });
    }
    Ok((local, middle))
}
