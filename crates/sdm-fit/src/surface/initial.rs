//! A surface to start from, from the cloud alone.

use super::base::{Base, choose};
use crate::Error;
use crate::primitive::start;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Interval, KnotVector, SurfaceFitOptions};

/// What a cloud is projected onto to get parameters to begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum BaseShape {
    /// The one over which the cloud is best described.
    #[default]
    Auto,
    /// The principal plane: an open patch.
    Plane,
    /// A cylinder about a bent axis: closed in u, open ends in v.
    Cylinder,
    /// A sphere: closed in u, poles at both ends of v.
    Sphere,
    /// A torus: closed in u and v.
    Torus,
}

impl BaseShape {
    /// The name used in files and options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Plane => "plane",
            Self::Cylinder => "cylinder",
            Self::Sphere => "sphere",
            Self::Torus => "torus",
        }
    }
}

impl std::fmt::Display for BaseShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Degrees and numbers of control points of a surface that is to be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct NetSize {
    /// Degrees in u and v; default 3, 3.
    pub degrees: [usize; 2],
    /// Control points in u and v that are not repetitions; default 12, 12.
    pub controls: [usize; 2],
}

impl Default for NetSize {
    fn default() -> Self {
        Self { degrees: [3, 3], controls: [12, 12] }
    }
}

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

/// Factor of the thin plate energy of the first least squares fit, whose domain is the unit square.
const STIFFNESS: f64 = 1e-7;

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
    let surface = approximate(&local, &found, knots(found.shape, size)?)?.translated(&middle)?;
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

/// The least squares surface with given knots at the parameters of a base, with poles where it has them.
pub(crate) fn approximate(
    points: &[Vector3<f64>],
    base: &Base,
    knots: [KnotVector; 2],
) -> Result<BsplineSurface, Error> {
    let options = SurfaceFitOptions::default().with_regularization(STIFFNESS);
    let surface = BsplineSurface::approximate(knots, &base.parameters, points, &options)?.shape;
    if base.shape != BaseShape::Sphere {
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
