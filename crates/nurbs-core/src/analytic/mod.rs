//! Shapes given by closed formulas: line, circle, ellipse, helix, plane, sphere, cylinder, cone, torus.
//!
//! Each is a finite piece in a position of its own. It evaluates exactly, and (but for the helix) knows the
//! closest point in closed form (`footpoint`), and turns into the exact rational B-spline (`to_nurbs`), which has the
//! same image and the same parameter interval; parameters agree where knots are, in between the rational
//! form runs at another pace. Angles are in radians, lengths in the units of the coordinates.

mod arc;
mod circle;
mod cone;
mod cylinder;
mod ellipse;
mod foot;
#[cfg(feature = "serde")]
mod form;
mod frame;
mod helix;
mod line;
mod plane;
mod revolved;
mod sphere;
mod surface;
mod torus;

pub(crate) use arc::arc_net;
pub(crate) use frame::finite;
pub(crate) use revolved::{check_angles, is_full_turn};

pub use circle::Circle;
pub use cone::Cone;
pub use cylinder::Cylinder;
pub use ellipse::Ellipse;
pub use foot::{CurveFoot, SurfaceFoot};
pub use frame::Frame;
pub use helix::Helix;
pub use line::Line;
pub use plane::Plane;
pub use sphere::Sphere;
pub use surface::AnalyticSurface;
pub use torus::Torus;
