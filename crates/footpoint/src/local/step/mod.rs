//! Single steps of the local methods: pure functions of a jet and a point.
//!
//! A step returns the increment of the parameter and nothing else; who calls it decides about bounds,
//! acceptance and stopping.
//!
//! At singular points (`c' = 0`; `s_u × s_v = 0`) there is no tangent line or plane. Curve steps return
//! `None` there. Surface steps move along the one regular direction, if there is one (at a pole the
//! derivative along the collapsed edge vanishes, the other does not), and return `None` otherwise.

mod circle;
mod first_order;
mod newton;
mod principal_circle;
mod second_order_curve;
mod second_order_surface;
mod tangent;

pub use first_order::{first_order_curve, first_order_surface};
pub use newton::{newton_curve, newton_surface};
pub use principal_circle::{principal_circle_curve, principal_circle_surface};
pub use second_order_curve::{second_order_curve, second_order_taylor_curve};
pub use second_order_surface::{second_order_surface, second_order_taylor_surface};

pub(crate) use tangent::{
    CurveResidual, PrincipalTangents, Tangent, TangentPlane, parameter_line, surface_tangent,
};

#[cfg(test)]
mod tests;
