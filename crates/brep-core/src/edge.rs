//! Edges and their closest points.

use crate::Error;
use crate::description::EdgeCurve;
use footpoint::{CurveProjector, Mode, ProjectionOptions};
use nalgebra::Vector3;
use nurbs_core::{Aabb, Ellipse, Interval, ParametricCurve};
use std::f64::consts::TAU;

/// A piece of a curve, shared by the faces that it bounds.
#[derive(Clone, Debug)]
pub struct Edge {
    pub(crate) curve: EdgeCurve,
    pub(crate) range: [f64; 2],
    pub(crate) source: u64,
    /// Index of the vertices at start and end.
    pub(crate) vertices: [usize; 2],
    /// Uses by faces: face and use of its boundary.
    pub(crate) uses: Vec<[usize; 2]>,
    /// Largest distance from the carriers of its faces.
    pub(crate) tolerance: f64,
    pub(crate) bounds: Aabb<3>,
    search: Search,
}

/// Options of the search: the gap is to be a small share of the size, however far away the point is.
const OPTIONS: ProjectionOptions = ProjectionOptions {
    mode: Mode::Certified,
    relative_gap: 1e-10,
    size_gap: 1e-10,
    tie_tolerance: 1e-9,
    max_boxes: 20_000,
};

/// How the closest point is found.
#[derive(Clone, Debug)]
enum Search {
    /// In closed form, on lines and circles.
    Closed,
    /// By the certified search on a B-spline.
    Spline(Box<CurveProjector<3>>),
}

/// The closest point of an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeFoot {
    pub(crate) t: f64,
    pub(crate) point: Vector3<f64>,
    pub(crate) distance: f64,
    /// No point of the edge is nearer.
    pub(crate) lower: f64,
    /// The foot is the start (0) or the end (1).
    pub(crate) end: Option<usize>,
}

impl Edge {
    pub(crate) fn new(
        curve: EdgeCurve,
        range: [f64; 2],
        source: u64,
        vertices: [usize; 2],
    ) -> Result<Self, Error> {
        let fail = |why: String| Error::of(format!("edge #{source}"), why);
        let [a, b] = range;
        if !(a.is_finite() && b.is_finite() && a < b) {
            return Err(fail(format!("its parameters {a} and {b} do not increase")));
        }
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
        let nurbs = |e: nurbs_core::Error| fail(e.to_string());
        let (search, bounds) = match &curve {
            EdgeCurve::Line { origin, direction } => {
                if !(finite(origin.as_slice()) && finite(direction.as_slice()) && direction.norm() > 0.0) {
                    return Err(fail("its line has no finite position and direction".to_owned()));
                }
                let bounds = Aabb::of_point(curve.point(a)).with_point(&curve.point(b));
                (Search::Closed, bounds)
            }
            EdgeCurve::Circle { frame, radius } => {
                if !(*radius > 0.0 && radius.is_finite()) || b - a > TAU * (1.0 + 1e-12) {
                    return Err(fail(format!("radius {radius} and angles {a} to {b} make no arc")));
                }
                (Search::Closed, arc_bounds(&curve, range, [frame.x() * *radius, frame.y() * *radius]))
            }
            EdgeCurve::Ellipse { frame, semi_axes } => {
                if !semi_axes.iter().all(|r| *r > 0.0 && r.is_finite()) || b - a > TAU * (1.0 + 1e-12) {
                    return Err(fail(format!("semi-axes {semi_axes:?} and angles {a} to {b} make no arc")));
                }
                // Another point of the ellipse may be a second local minimum: the exact rational form is searched.
                let whole = Ellipse::in_frame(frame, *semi_axes).and_then(|e| e.to_nurbs()).map_err(nurbs)?;
                let axes = [frame.x() * semi_axes[0], frame.y() * semi_axes[1]];
                let bounds = arc_bounds(&curve, range, axes);
                let piece = if b - a >= TAU * (1.0 - 1e-12) {
                    whole
                } else {
                    ellipse_piece(&whole, &curve, range).map_err(nurbs)?
                };
                (Search::Spline(Box::new(CurveProjector::new(&piece))), bounds)
            }
            EdgeCurve::Nurbs(spline) => {
                let domain = spline.domain();
                let piece = if a <= domain.start() && b >= domain.end() {
                    (**spline).clone()
                } else {
                    Interval::new(a, b).and_then(|i| spline.trimmed(i)).map_err(nurbs)?
                };
                let bounds = piece.bounding_box(1e-3);
                (Search::Spline(Box::new(CurveProjector::new(&piece))), bounds)
            }
        };
        if !(finite(bounds.min.as_slice()) && finite(bounds.max.as_slice())) {
            return Err(fail("it is not finite".to_owned()));
        }
        Ok(Self { curve, range, source, vertices, uses: Vec::new(), tolerance: 0.0, bounds, search })
    }

    /// The curve.
    #[must_use]
    pub fn curve(&self) -> &EdgeCurve {
        &self.curve
    }

    /// Parameters of start and end.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Number of the entity in the file.
    #[must_use]
    pub fn source(&self) -> u64 {
        self.source
    }

    /// Largest distance of the edge from the surfaces of its faces.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Indices of the faces on its sides, each as often as it uses the edge.
    pub fn faces(&self) -> impl Iterator<Item = usize> + '_ {
        self.uses.iter().map(|[face, _]| *face)
    }

    pub(crate) fn project(&self, x: &Vector3<f64>) -> EdgeFoot {
        let [a, b] = self.range;
        let at = |t: f64, end: Option<usize>| {
            let point = self.curve.point(t);
            let distance = (x - point).norm();
            EdgeFoot { t, point, distance, lower: distance, end }
        };
        let ends = || {
            let [start, end] = [at(a, Some(0)), at(b, Some(1))];
            if end.distance < start.distance { end } else { start }
        };
        match &self.search {
            Search::Closed => {
                let t = self.curve.parameter_of(x);
                if matches!(self.curve, EdgeCurve::Line { .. }) {
                    return if t <= a {
                        at(a, Some(0))
                    } else if t >= b {
                        at(b, Some(1))
                    } else {
                        at(t, None)
                    };
                }
                // The distance from an arc grows with the angle from the nearest point of its circle.
                let t = a + (t - a).rem_euclid(TAU);
                if t > a && t < b { at(t, None) } else { ends() }
            }
            Search::Spline(projector) => {
                let foot = projector.project_with(x, &OPTIONS).unwrap_or_else(|_| projector.project(x));
                let t = match &self.curve {
                    EdgeCurve::Nurbs(_) => foot.parameter,
                    curve => a + (curve.parameter_of(&foot.point) - a).rem_euclid(TAU),
                };
                let t = t.clamp(a, b);
                let slack = 1e-12 * (b - a);
                let end = if t - a <= slack {
                    Some(0)
                } else if b - t <= slack {
                    Some(1)
                } else {
                    None
                };
                EdgeFoot { t, point: foot.point, distance: foot.distance, lower: foot.lower_bound, end }
            }
        }
    }
}

/// Box of an arc `m + cos t a + sin t b`.
fn arc_bounds(curve: &EdgeCurve, range: [f64; 2], axes: [Vector3<f64>; 2]) -> Aabb<3> {
    let mut bounds = Aabb::of_point(curve.point(range[0])).with_point(&curve.point(range[1]));
    for i in 0..3 {
        let extreme = axes[1][i].atan2(axes[0][i]);
        for t in [extreme, extreme + 0.5 * TAU] {
            let t = range[0] + (t - range[0]).rem_euclid(TAU);
            if t <= range[1] {
                bounds = bounds.with_point(&curve.point(t));
            }
        }
    }
    bounds
}

/// The part of an ellipse between two angles, from its whole rational form, which has knots at multiples of a right
/// angle and starts at 0.
fn ellipse_piece(
    whole: &nurbs_core::BsplineCurve<3>,
    curve: &EdgeCurve,
    range: [f64; 2],
) -> Result<nurbs_core::BsplineCurve<3>, nurbs_core::Error> {
    let projector = CurveProjector::new(whole);
    let domain = whole.domain();
    let parameter = |t: f64| projector.project(&curve.point(t)).parameter;
    let (a, b) = (parameter(range[0]), parameter(range[1]));
    let slack = 1e-9 * domain.length();
    let (start, end) = (domain.start(), domain.end());
    let a = if end - a <= slack { start } else { a };
    let b = if b - start <= slack { end } else { b };
    if a < b {
        return whole.trimmed(Interval::new(a, b)?);
    }
    let size = whole.control_box().diagonal();
    let (first, second) = (whole.trimmed(Interval::new(a, end)?)?, whole.trimmed(Interval::new(start, b)?)?);
    first.join(&second, 1e-9 * size)
}
