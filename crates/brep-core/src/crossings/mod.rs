//! Where straight lines meet the faces of a model.
//!
//! Lines meet planes, cylinders, cones and spheres where a polynomial of degree one or two vanishes, tori where one of degree four
//! does. On B-splines all common zeros of two polynomials are isolated by subdivision. A crossing counts if it lies on the face, or
//! within the tolerance of its boundary.

mod patches;
mod polynomial;

use crate::boundary::Inside;
use crate::carrier::Surface;
use crate::description::Carrier;
use crate::face::Face;
use crate::model::Model;
use crate::part::Part;
use footpoint::Facing;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{Aabb, Frame};

/// Share of the size of a part that counts as nothing.
const NOTHING: f64 = 1e-12;
/// Share of the size of a part by which a point of a carrier may miss it.
const ON_CARRIER: f64 = 1e-8;

/// A point that a line and a face have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Signed length from the origin of the line to the point, along the direction.
    pub offset: f64,
    /// Index of the instance.
    pub instance: usize,
    /// Index of the face in its part.
    pub face: usize,
    /// Parameters on the carrier.
    pub uv: [f64; 2],
    /// The point.
    pub point: Vector3<f64>,
    /// Unit normal of the face there; zero where it has none.
    pub normal: Vector3<f64>,
    /// The point is as near to an edge as that is known.
    pub is_at_edge: bool,
}

/// What a line through a point shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSearch {
    /// The crossing with the smallest absolute offset that counts.
    pub nearest: Option<Crossing>,
    /// No crossing that counts has a smaller absolute offset; that of `nearest` but where a line touches a surface so closely that
    /// not all crossings could be told apart.
    pub free: f64,
    /// The smallest absolute offset of a crossing whose normal does not agree; infinite without any.
    pub refused: f64,
}

/// A line in the coordinates of a part.
struct Line {
    origin: Vector3<f64>,
    /// Of length 1.
    direction: Vector3<f64>,
}

/// Offsets at which a line meets a carrier, and the one from which on more of them may be missing.
#[derive(Debug)]
struct Zeros {
    /// Offsets with the parameters on the carrier, where they are known.
    at: Vec<(f64, Option<Vector2<f64>>)>,
    open: f64,
}

impl Model {
    /// The point nearest to `x` in which the line through it along `direction` (of any length but 0, in either sense) meets a face,
    /// up to `reach`; only those crossings count at which the normal of the face agrees with `facing`, if there is one.
    ///
    /// `None` for points and directions that are not finite. Faces that contain the direction are not met.
    #[must_use]
    pub fn nearest_on_line(
        &self,
        x: &Vector3<f64>,
        direction: &Vector3<f64>,
        reach: f64,
        facing: Option<&Facing>,
    ) -> Option<LineSearch> {
        let largest = direction.amax();
        let unit = (direction / largest).try_normalize(0.0)?;
        if !x.iter().chain(unit.iter()).all(|c| c.is_finite()) {
            return None;
        }
        let mut found = LineSearch { nearest: None, free: f64::INFINITY, refused: f64::INFINITY };
        for (index, instance) in self.instances().iter().enumerate() {
            let placement = &instance.placement;
            let line =
                Line { origin: placement.inverse_point(x), direction: placement.rotation.tr_mul(&unit) };
            let part = &self.parts()[instance.part];
            let limit =
                |found: &LineSearch| found.nearest.map_or(reach, |n| n.offset.abs()) / placement.scale;
            let mut faces: Vec<(f64, usize, [f64; 2])> = Vec::new();
            for (face, f) in part.faces.iter().enumerate() {
                if let Some([start, end]) = line.within(&f.bounds, limit(&found)) {
                    let nearest = if start > 0.0 { start } else { (-end).max(0.0) };
                    faces.push((nearest, face, [start, end]));
                }
            }
            faces.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for (nearest, face, range) in faces {
                if nearest > limit(&found) {
                    break;
                }
                let zeros = line.zeros(part, &part.faces[face], range);
                found.free = found.free.min(zeros.open * placement.scale);
                for (offset, uv) in zeros.at {
                    let Some((uv, is_at_edge)) = part.place_on(face, &line.at(offset), uv) else { continue };
                    let offset = offset * placement.scale;
                    if offset.abs() > reach {
                        continue;
                    }
                    let normal = placement.direction(&part.faces[face].normal([uv.x, uv.y]));
                    if facing.is_some_and(|facing| !facing.agrees(&normal)) {
                        found.refused = found.refused.min(offset.abs());
                        continue;
                    }
                    // Of crossings as near, one inside of a face.
                    let is_nearer = found.nearest.is_none_or(|other| {
                        let (a, b) = (offset.abs(), other.offset.abs());
                        a < b || a == b && other.is_at_edge && !is_at_edge
                    });
                    if is_nearer {
                        let point = placement.point(&part.faces[face].surface.point(&uv));
                        let uv = [uv.x, uv.y];
                        found.nearest =
                            Some(Crossing { offset, instance: index, face, uv, point, normal, is_at_edge });
                    }
                }
            }
        }
        let nearest = found.nearest.map_or(f64::INFINITY, |n| n.offset.abs());
        Some(LineSearch { free: found.free.min(nearest), ..found })
    }
}

impl Part {
    /// Parameters of a point of the carrier that lies on the face, and whether its boundary is as near as it is known.
    fn place_on(
        &self,
        face: usize,
        point: &Vector3<f64>,
        uv: Option<Vector2<f64>>,
    ) -> Option<(Vector2<f64>, bool)> {
        let f = &self.faces[face];
        let uv = uv.unwrap_or_else(|| f.surface.invert(point, None).at);
        if (f.surface.point(&uv) - point).norm() > ON_CARRIER * self.size {
            return None;
        }
        match f.inside(&self.edges, &uv) {
            Inside::In => Some((uv, false)),
            Inside::Near(_) => Some((uv, true)),
            Inside::Out => None,
        }
    }
}

impl Line {
    fn at(&self, offset: f64) -> Vector3<f64> {
        self.origin + self.direction * offset
    }

    /// Between which offsets the line is in a box, up to a limit to both sides.
    fn within(&self, bounds: &Aabb<3>, limit: f64) -> Option<[f64; 2]> {
        let margin = 1e-9 * bounds.diagonal() + f64::MIN_POSITIVE;
        let (mut start, mut end) = (-limit, limit);
        for axis in 0..3 {
            let low = bounds.min[axis] - margin - self.origin[axis];
            let high = bounds.max[axis] + margin - self.origin[axis];
            let d = self.direction[axis];
            if d == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / d, high / d);
            (start, end) = (start.max(a.min(b)), end.min(a.max(b)));
        }
        (start <= end && start.is_finite() && end.is_finite()).then_some([start, end])
    }

    /// Offsets in a range at which the line meets the carrier of a face.
    fn zeros(&self, part: &Part, face: &Face, [start, end]: [f64; 2]) -> Zeros {
        // From a point in the box on: coordinates of a point that is far away would cancel.
        let middle = 0.5 * (start + end);
        let base = Self { origin: self.at(middle), direction: self.direction };
        let half = 0.5 * (end - start) + NOTHING * part.size;
        let analytic = |roots: Vec<f64>| {
            let roots = roots.into_iter().filter(|t| t.abs() <= half).map(|t| (middle + t, None));
            Zeros { at: roots.collect(), open: f64::INFINITY }
        };
        match face.carrier() {
            Carrier::Plane { frame } => analytic(base.on_plane(frame)),
            Carrier::Cylinder { frame, radius } => analytic(base.on_cone(frame, *radius, 0.0)),
            Carrier::Cone { frame, radius, half_angle } => {
                analytic(base.on_cone(frame, *radius, half_angle.tan()))
            }
            Carrier::Sphere { frame, radius } => {
                let p = base.origin - frame.origin();
                analytic(polynomial::quadratic(
                    1.0,
                    2.0 * p.dot(&base.direction),
                    p.norm_squared() - radius * radius,
                ))
            }
            Carrier::Torus { frame, major_radius, minor_radius } => {
                analytic(base.on_torus(frame, *major_radius, *minor_radius, half))
            }
            Carrier::Nurbs(_) => {
                let mut zeros =
                    face.surface.spline().map_or(Zeros { at: Vec::new(), open: f64::INFINITY }, |spline| {
                        patches::zeros(&base, spline, [-half, half], NOTHING * part.size)
                    });
                zeros.at.iter_mut().for_each(|(t, _)| *t += middle);
                if zeros.open.is_finite() {
                    // An offset from the middle says how near to the origin a missing one may be.
                    zeros.open = nearest_offset(middle, half);
                }
                zeros
            }
        }
    }

    fn on_plane(&self, frame: &Frame) -> Vec<f64> {
        let (slope, height) =
            (self.direction.dot(&frame.z()), (self.origin - frame.origin()).dot(&frame.z()));
        if slope == 0.0 { Vec::new() } else { vec![-height / slope] }
    }

    /// On a cylinder (slope 0) or a cone: `x² + y² = (r + z tan α)²`.
    fn on_cone(&self, frame: &Frame, radius: f64, slope: f64) -> Vec<f64> {
        let p = frame.local(&self.origin);
        let d = frame.local(&(frame.origin() + self.direction));
        let (r, s) = (radius + p.z * slope, d.z * slope);
        polynomial::quadratic(
            d.x * d.x + d.y * d.y - s * s,
            2.0 * (p.x * d.x + p.y * d.y - r * s),
            p.x * p.x + p.y * p.y - r * r,
        )
    }

    /// On a torus: `(|p|² + R² − r²)² = 4 R² (x² + y²)`, within `half` to both sides.
    fn on_torus(&self, frame: &Frame, major: f64, minor: f64, half: f64) -> Vec<f64> {
        // In units of the largest length, so that no power overflows.
        let unit = major.abs().max(minor).max(half);
        let p = frame.local(&self.origin) / unit;
        let d = frame.local(&(frame.origin() + self.direction)) * (half / unit);
        let (big, small) = (major / unit, minor / unit);
        // In s, from −1 to 1 along the range.
        let g = [p.norm_squared() + big * big - small * small, 2.0 * p.dot(&d), d.norm_squared()];
        let h = [p.x * p.x + p.y * p.y, 2.0 * (p.x * d.x + p.y * d.y), d.x * d.x + d.y * d.y];
        let q = 4.0 * big * big;
        let f = [
            g[0] * g[0] - q * h[0],
            2.0 * g[0] * g[1] - q * h[1],
            2.0 * g[0] * g[2] + g[1] * g[1] - q * h[2],
            2.0 * g[1] * g[2],
            g[2] * g[2],
        ];
        let off = |s: f64| {
            let x = p + d * s;
            (x.x.hypot(x.y) - big.abs()).hypot(x.z) - small
        };
        let roots = polynomial::roots(&f).into_iter().map(|s| polynomial::polished(&off, s) * half);
        roots.collect()
    }
}

/// The smallest absolute value of an offset within `half` of `middle`.
fn nearest_offset(middle: f64, half: f64) -> f64 {
    (middle.abs() - half).max(0.0)
}

impl Surface {
    /// Two directions across a line.
    fn across(direction: &Vector3<f64>) -> Option<[Vector3<f64>; 2]> {
        let mut axis = Vector3::zeros();
        axis[direction.iamin()] = 1.0;
        let first = direction.cross(&axis).try_normalize(0.0)?;
        Some([first, direction.cross(&first)])
    }
}
