//! The public functions, one for each shape.

use super::PrimitiveOptions;
use super::elements::PrimitiveFit;
use super::fit::{Found, fit};
use super::flat::{LineModel, PlaneModel};
use super::round::{BallModel, CircleModel};
use super::torus::TorusModel;
use super::turned::ConeModel;
use crate::Error;
use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{Circle, Cone, Cylinder, Frame, Interval, Line, Plane, Sphere, Torus};

/// The line with the least sum of squared distances from points in the plane (`D = 2`) or in space (`D = 3`).
///
/// Points that are not finite are left out and counted.
///
/// # Errors
/// [`Error::TooFewPoints`], [`Error::Degenerate`] for points in one place, [`Error::Option`].
pub fn fit_line<const D: usize>(
    points: &[SVector<f64, D>],
    options: &PrimitiveOptions,
) -> Result<PrimitiveFit<Line<D>, D>, Error> {
    if !(2..=3).contains(&D) {
        return Err(Error::Option { name: "dimension", value: D as f64, allowed: "2 or 3" });
    }
    let found = fit::<D, LineModel<D>>(points, options, "a line", 1)?;
    let (point, direction) = (found.model.point, found.model.direction);
    let [low, high] = found.extent(|x| (x - point).dot(&direction));
    let [low, high] = [low, high].map(|h| found.place(&(point + direction * h)));
    let line = Line::new(low, high)?;
    Ok(found.fit.with_shape(line))
}

/// The plane with the least sum of squared distances.
///
/// # Errors
/// As [`fit_line`]; [`Error::Degenerate`] for points on a line.
pub fn fit_plane(
    points: &[Vector3<f64>],
    options: &PrimitiveOptions,
) -> Result<PrimitiveFit<Plane, 3>, Error> {
    let found = fit::<_, PlaneModel>(points, options, "a plane", 2)?;
    let frame = Frame::new(found.fit.elements.location, found.model.normal, found.model.e)?;
    let scale = found.cloud.scale;
    let middle = (frame.origin() - found.cloud.centre) / scale;
    let side = |axis: Vector3<f64>| {
        let [low, high] = found.extent(|x| (x - middle).dot(&axis));
        Interval::new(low * scale, high * scale)
    };
    let plane = Plane::new(frame, side(frame.x())?, side(frame.y())?);
    Ok(found.fit.with_shape(plane))
}

/// The circle with the least sum of squared distances from points in the plane.
///
/// # Errors
/// As [`fit_line`]; [`Error::Degenerate`] for points on a line.
pub fn fit_circle(
    points: &[Vector2<f64>],
    options: &PrimitiveOptions,
) -> Result<PrimitiveFit<Circle<2>, 2>, Error> {
    let found = fit::<_, BallModel<2>>(points, options, "a circle", 2)?;
    let radius = found.cloud.scale / found.model.curvature;
    let circle = Circle::new(found.fit.elements.location, radius)?;
    Ok(found.fit.with_shape(circle))
}

/// The circle in space with the least sum of squared distances.
///
/// # Errors
/// As [`fit_line`]; [`Error::Degenerate`] for points on a line.
pub fn fit_circle_in_space(
    points: &[Vector3<f64>],
    options: &PrimitiveOptions,
) -> Result<PrimitiveFit<Circle<3>, 3>, Error> {
    let found = fit::<_, CircleModel>(points, options, "a circle", 2)?;
    let frame = Frame::new(found.fit.elements.location, found.model.pose.z, found.model.pose.e)?;
    let circle = Circle::in_frame(&frame, found.cloud.scale / found.model.curvature)?;
    Ok(found.fit.with_shape(circle))
}

/// The sphere with the least sum of squared distances.
///
/// # Errors
/// As [`fit_line`]; [`Error::Degenerate`] for points on a plane.
pub fn fit_sphere(
    points: &[Vector3<f64>],
    options: &PrimitiveOptions,
) -> Result<PrimitiveFit<Sphere, 3>, Error> {
    let found = fit::<_, BallModel<3>>(points, options, "a sphere", 3)?;
    let frame = Frame::from_axis(found.fit.elements.location, Vector3::z())?;
    let sphere = Sphere::new(frame, found.cloud.scale / found.model.curvature)?;
    Ok(found.fit.with_shape(sphere))
}

/// The cylinder with the least sum of squared distances, as high as the points reach.
///
/// # Errors
/// As [`fit_line`]; [`Error::Degenerate`] for points on a plane.
pub fn fit_cylinder(
    points: &[Vector3<f64>],
    options: &PrimitiveOptions,
) -> Result<PrimitiveFit<Cylinder, 3>, Error> {
    let found = fit::<_, ConeModel<false>>(points, options, "a cylinder", 3)?;
    let (frame, heights) = along_axis(&found, found.model.pose.z, found.model.pose.e)?;
    let heights = Interval::new(heights[0], heights[1])?;
    let cylinder = Cylinder::new(frame, found.cloud.scale / found.model.curvature, heights)?;
    Ok(found.fit.with_shape(cylinder))
}

/// The cone with the least sum of squared distances, as high as the points reach but not beyond its apex.
///
/// Distances are those from the cone's generators, which go on beyond the apex: points there should be few.
///
/// # Errors
/// As [`fit_line`]; [`Error::Degenerate`] for points on a plane.
pub fn fit_cone(points: &[Vector3<f64>], options: &PrimitiveOptions) -> Result<PrimitiveFit<Cone, 3>, Error> {
    let found = fit::<_, ConeModel<true>>(points, options, "a cone", 3)?;
    let elements = found.fit.elements;
    let (Some(direction), Some(radius), Some(angle)) =
        (elements.direction, elements.radius, elements.half_angle)
    else {
        return Err(Error::Degenerate { shape: "a cone", what: "on a plane" });
    };
    let (frame, [low, high]) = along_axis(&found, direction, found.model.pose.e)?;
    let slope = angle.tan();
    let low = if slope > 0.0 { low.max(-radius / slope) } else { low };
    let base = Frame::new(frame.origin() + frame.z() * low, frame.z(), frame.x())?;
    let radii = [low, high].map(|h| (radius + h * slope).max(0.0));
    let cone = Cone::new(base, radii[0], radii[1], high - low)?;
    Ok(found.fit.with_shape(cone))
}

/// The torus with the least sum of squared distances, among those whose tube does not meet the axis.
///
/// # Errors
/// As [`fit_line`]; [`Error::Degenerate`] for points on a plane, or where no such torus could be found.
pub fn fit_torus(
    points: &[Vector3<f64>],
    options: &PrimitiveOptions,
) -> Result<PrimitiveFit<Torus, 3>, Error> {
    let found = fit::<_, TorusModel>(points, options, "a torus", 3)?;
    let elements = found.fit.elements;
    let (Some(z), Some(major), Some(minor)) = (elements.direction, elements.radius, elements.minor_radius)
    else {
        return Err(Error::Degenerate { shape: "a torus", what: "on a plane" });
    };
    let torus = Torus::new(Frame::from_axis(elements.location, z)?, major, minor)?;
    Ok(found.fit.with_shape(torus))
}

/// The frame of an axis at the location of the shape, and the heights between which the points lie.
fn along_axis<M>(found: &Found<M, 3>, z: Vector3<f64>, x: Vector3<f64>) -> Result<(Frame, [f64; 2]), Error> {
    let frame = Frame::new(found.fit.elements.location, z, x)?;
    let scale = found.cloud.scale;
    let middle = (frame.origin() - found.cloud.centre) / scale;
    let heights = found.extent(|x| (x - middle).dot(&z)).map(|h| h * scale);
    if heights[0] < heights[1] {
        Ok((frame, heights))
    } else {
        Err(Error::Degenerate { shape: "a surface of revolution", what: "on one circle" })
    }
}
