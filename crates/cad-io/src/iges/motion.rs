//! Transformation matrices (type 124).

use super::directory::Entry;
use super::fault::Fault;
use super::file::File;
use brep_core::description::{Carrier, EdgeCurve};
use nalgebra::{Matrix3, Vector3};
use nurbs_core::{Error, Frame};
use std::sync::Arc;

/// Largest entry of `MᵀM − 1` with which a matrix counts as a rotation or mirror image; files have 9 digits or more.
const RIGID: f64 = 1e-6;

/// The map `x ↦ M x + b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    matrix: Matrix3<f64>,
    offset: Vector3<f64>,
}

impl Motion {
    /// What moves an entity into the coordinates of the model: its own matrix, then that of the entity that it belongs to.
    /// `None` moves nothing, so that no number of the file changes.
    pub(crate) fn of(
        file: &File<'_>,
        entry: &Entry,
        parent: Option<&Self>,
        depth: usize,
    ) -> Result<Option<Self>, Fault> {
        let own = Self::named_by(file, entry, depth)?;
        Ok(match (parent, own) {
            (Some(parent), Some(own)) => Some(parent.after(&own)),
            (parent, own) => own.or(parent.copied()),
        })
    }

    fn named_by(file: &File<'_>, entry: &Entry, depth: usize) -> Result<Option<Self>, Fault> {
        if entry.transform == 0 {
            return Ok(None);
        }
        let Some(matrix) = file.entry(entry.transform).filter(|matrix| matrix.kind == 124) else {
            let what = format!("its transformation matrix is entity {}, which is none", entry.transform);
            return Err(Fault::of(entry, what));
        };
        file.mark_used(matrix);
        let mut values = file.record(matrix, depth)?;
        let mut rows = [[0.0; 4]; 3];
        for row in &mut rows {
            *row = values.reals("element of the matrix")?;
        }
        let own =
            Self { matrix: Matrix3::from_fn(|i, j| rows[i][j]), offset: Vector3::from_fn(|i, _| rows[i][3]) };
        let is_regular = own.matrix.determinant().abs() > 0.0;
        if !is_regular {
            return Err(Fault::of(matrix, "the transformation matrix is singular"));
        }
        let own = Some(own).filter(|own| own.matrix != Matrix3::identity() || own.offset != Vector3::zeros());
        // A matrix may have a matrix of its own, which comes after it.
        Ok(match (Self::named_by(file, matrix, values.depth())?, own) {
            (Some(next), Some(own)) => Some(next.after(&own)),
            (next, own) => own.or(next),
        })
    }

    fn after(&self, first: &Self) -> Self {
        Self { matrix: self.matrix * first.matrix, offset: self.matrix * first.offset + self.offset }
    }

    /// The image of a point.
    pub(crate) fn point(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.matrix * x + self.offset
    }

    /// The image of a difference of points.
    pub(crate) fn vector(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.matrix * x
    }

    /// Whether circles stay circles.
    fn is_rigid(&self) -> bool {
        (self.matrix.tr_mul(&self.matrix) - Matrix3::identity()).amax() <= RIGID
    }

    /// The frame whose `x` and `y` axes are the images of those of `frame`.
    fn frame(&self, frame: &Frame) -> Result<Frame, Error> {
        let (x, y) = (self.vector(&frame.x()), self.vector(&frame.y()));
        Frame::new(self.point(&frame.origin()), x.cross(&y), x)
    }

    /// The image of a curve with the same parameters.
    pub(crate) fn curve(&self, curve: &EdgeCurve, range: [f64; 2]) -> Result<(EdgeCurve, [f64; 2]), Error> {
        let moved = match curve {
            EdgeCurve::Line { origin, direction } => {
                EdgeCurve::Line { origin: self.point(origin), direction: self.vector(direction) }
            }
            EdgeCurve::Nurbs(curve) => {
                EdgeCurve::Nurbs(Arc::new(curve.transformed(&self.matrix, &self.offset)?))
            }
            EdgeCurve::Circle { frame, radius } if self.is_rigid() => {
                EdgeCurve::Circle { frame: self.frame(frame)?, radius: *radius }
            }
            EdgeCurve::Ellipse { frame, semi_axes } if self.is_rigid() => {
                EdgeCurve::Ellipse { frame: self.frame(frame)?, semi_axes: *semi_axes }
            }
            EdgeCurve::Circle { .. } | EdgeCurve::Ellipse { .. } => {
                let exact = crate::edges::nurbs(curve, range)?.transformed(&self.matrix, &self.offset)?;
                EdgeCurve::Nurbs(Arc::new(exact))
            }
        };
        Ok((moved, range))
    }

    /// The image of a surface, and whether its normal is the image of the normal that the parameters `u × v` give.
    ///
    /// Mirror images turn the normals of analytic carriers, which are geometric, against those of their parameters.
    pub(crate) fn carrier(&self, carrier: &Carrier) -> Result<(Carrier, bool), Error> {
        if let Carrier::Nurbs(surface) = carrier {
            let moved = surface.transformed(&self.matrix, &self.offset)?;
            return Ok((Carrier::Nurbs(Arc::new(moved)), true));
        }
        if !self.is_rigid() {
            return Err(Error::Argument {
                what: "its transformation matrix is neither a rotation nor a mirror image".to_owned(),
            });
        }
        let moved = |frame: &Frame| {
            Frame::new(self.point(&frame.origin()), self.vector(&frame.z()), self.vector(&frame.x()))
        };
        let image = match carrier {
            Carrier::Plane { frame } => Carrier::Plane { frame: moved(frame)? },
            Carrier::Cylinder { frame, radius } => {
                Carrier::Cylinder { frame: moved(frame)?, radius: *radius }
            }
            Carrier::Cone { frame, radius, half_angle } => {
                Carrier::Cone { frame: moved(frame)?, radius: *radius, half_angle: *half_angle }
            }
            Carrier::Sphere { frame, radius } => Carrier::Sphere { frame: moved(frame)?, radius: *radius },
            Carrier::Torus { frame, major_radius, minor_radius } => Carrier::Torus {
                frame: moved(frame)?,
                major_radius: *major_radius,
                minor_radius: *minor_radius,
            },
            Carrier::Nurbs(surface) => Carrier::Nurbs(Arc::clone(surface)),
        };
        Ok((image, self.matrix.determinant() > 0.0))
    }
}
