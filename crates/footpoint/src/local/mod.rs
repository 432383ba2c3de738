//! Local iterations: from an initial parameter to a nearby footpoint.
//!
//! Three layers, each usable alone:
//!
//! - [steps](first_order_curve): pure functions of a jet and a point that return a parameter increment;
//! - [`iterate_curve`], [`iterate_surface`]: a step repeated without bounds or safeguards, every step
//!   recorded, to study a method;
//! - [`project_curve`], [`project_surface`]: the working iteration. It stays in the domain (active set at
//!   the bounds, periodic and closed directions wrap), splits at kinks, leaves poles and maxima, and
//!   never increases the distance beyond rounding. [`invert_curve`] and [`invert_surface`] recover the
//!   parameter of a point that lies on the shape.
//!
//! All are local: they find *a* footpoint, the nearest one only from a good [`Start`].

mod axis;
mod curve;
mod escape;
mod inversion;
mod line_search;
mod location;
mod method;
mod options;
mod pole;
mod quadrilaterals;
mod start;
mod step;
mod surface;
mod surface_state;
mod trace;

pub use curve::project_curve;
pub use inversion::{invert_curve, invert_surface};
pub use method::Method;
pub use options::LocalOptions;
pub use quadrilaterals::nearest_quadrilateral;
pub use start::Start;
pub use step::{
    first_order_curve, first_order_surface, newton_curve, newton_surface, principal_circle_curve,
    principal_circle_surface, second_order_curve, second_order_surface, second_order_taylor_curve,
    second_order_taylor_surface,
};
pub use surface::project_surface;
pub use trace::{CurveStep, CurveTrace, SurfaceStep, SurfaceTrace, iterate_curve, iterate_surface};
