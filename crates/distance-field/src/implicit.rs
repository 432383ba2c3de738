//! One step towards the foot of a point on the zero set of a function.

use nalgebra::{SMatrix, SVector};

/// Value and derivatives of a function at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taylor<const D: usize> {
    pub(crate) value: f64,
    pub(crate) gradient: SVector<f64, D>,
    pub(crate) hessian: SMatrix<f64, D, D>,
}

/// The step from a place towards the foot of a point.
pub(crate) struct LagrangeStep<const D: usize> {
    /// Unit normal of the level set through the place.
    pub(crate) normal: SVector<f64, D>,
    /// Part of the residual along the tangents.
    pub(crate) along: SVector<f64, D>,
    /// First order distance from the zero set, along the normal.
    pub(crate) across: f64,
    /// Where to go from the place.
    pub(crate) step: SVector<f64, D>,
}

impl<const D: usize> Taylor<D> {
    /// A step of Newton's method on the equations of Lagrange for `min |x − y|²` subject to `f(y) = 0`, with the residual
    /// `x − y`; not finite where the gradient vanishes.
    pub(crate) fn lagrange_step(&self, residual: &SVector<f64, D>) -> LagrangeStep<D> {
        let slope = self.gradient.norm();
        let normal = self.gradient / slope;
        let height = residual.dot(&normal);
        let across = -self.value / slope;
        let along = residual - normal * height;
        // Of the Hessian of the Lagrangian I + μ ∇²f, μ = height / |∇f|, only the tangent part counts; the normal part
        // of the step is that to the tangent plane of the level set.
        let tangent = SMatrix::<f64, D, D>::identity() - normal * normal.transpose();
        let bend = self.hessian * (height / slope);
        let matrix = tangent * (SMatrix::identity() + bend) * tangent + normal * normal.transpose();
        let right = along - tangent * (bend * normal) * across;
        // Beyond a centre of curvature there is no minimum to go to: then as on a plane.
        let step = matrix.cholesky().map_or(along, |factor| tangent * factor.solve(&right));
        LagrangeStep { normal, along, across, step: step + normal * across }
    }

    /// Minus the Hessian as a share of the gradient: its tangent part is the second fundamental form of the level set.
    pub(crate) fn tensor(&self) -> SMatrix<f64, D, D> {
        self.hessian * (-1.0 / self.gradient.norm())
    }
}
