//! Faces: trimmed surfaces and what is known about them.

use crate::Error;
use crate::boundary::{Boundary, Inside};
use crate::carrier::Surface;
use crate::description::{Carrier, FaceDescription, LoopDescription};
use crate::edge::Edge;
use nalgebra::{Vector2, Vector3};
use nurbs_core::Aabb;
use std::f64::consts::{PI, TAU};

/// A piece of a surface bounded by loops of edges.
#[derive(Clone, Debug)]
pub struct Face {
    pub(crate) name: String,
    pub(crate) source: u64,
    pub(crate) carrier: Carrier,
    pub(crate) surface: Surface,
    pub(crate) same_sense: bool,
    pub(crate) boundary: Boundary,
    /// Points of vertex loops.
    pub(crate) points: Vec<Vector3<f64>>,
    pub(crate) bounds: Aabb<3>,
    /// Edges of the boundary, each once.
    pub(crate) edges: Vec<usize>,
    /// Index of the shell.
    pub(crate) shell: usize,
}

impl Face {
    /// Builds a face. `vertices` are the points of the part, `size` is the size of the model.
    pub(crate) fn new(
        description: &FaceDescription,
        edges: &[Edge],
        vertices: &[Vector3<f64>],
        size: f64,
        shell: usize,
    ) -> Result<Self, Error> {
        let what = || match description.name.as_str() {
            "" => format!("face #{}", description.source),
            name => format!("face #{} \"{name}\"", description.source),
        };
        let surface = Surface::new(&description.carrier, size).map_err(|e| Error::of(what(), e))?;
        let mut loops = Vec::new();
        let mut points = Vec::new();
        for entry in &description.loops {
            match entry {
                LoopDescription::Vertex(index) => {
                    let point = vertices.get(*index);
                    points
                        .push(*point.ok_or_else(|| Error::of(what(), "a vertex of a loop does not exist"))?);
                }
                LoopDescription::Edges(uses) => {
                    if uses.iter().any(|u| u.edge >= edges.len()) {
                        return Err(Error::of(what(), "an edge of a loop does not exist"));
                    }
                    loops.push(uses.iter().map(|u| (u.edge, u.forward)).collect::<Vec<_>>());
                }
            }
        }
        let whole =
            matches!(description.carrier, Carrier::Sphere { .. } | Carrier::Torus { .. } | Carrier::Nurbs(_));
        // A vertex alone bounds nothing: the face is the whole carrier, which has to be finite.
        if loops.iter().all(Vec::is_empty) && !whole {
            return Err(Error::of(what(), "it has no boundary, and its surface has no end"));
        }
        let boundary = Boundary::trace(&surface, edges, &loops, size, description.same_sense);
        if boundary.chords.iter().any(|c| !c.uv.iter().all(|p| p.iter().all(|x| x.is_finite()))) {
            return Err(Error::of(what(), "its boundary is not finite on its surface"));
        }
        let turns: i64 = boundary.windings.iter().map(|w| w[0]).sum();
        if surface.unbounded() && surface.apex().is_none() && turns.rem_euclid(2) == 1 {
            return Err(Error::of(what(), "its boundary goes around its surface on one side only"));
        }
        let mut used: Vec<usize> = boundary.uses.iter().map(|u| u.edge).collect();
        used.sort_unstable();
        used.dedup();
        let mut face = Self {
            name: description.name.clone(),
            source: description.source,
            carrier: description.carrier.clone(),
            surface,
            same_sense: description.same_sense,
            boundary,
            points,
            bounds: Aabb::of_point(Vector3::zeros()),
            edges: used,
            shell,
        };
        face.bounds = face.find_bounds(edges);
        if !(face.bounds.diagonal().is_finite()) {
            return Err(Error::of(what(), "it is not finite"));
        }
        Ok(face)
    }

    /// Name in the file; may be empty.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of the entity in the file.
    #[must_use]
    pub fn source(&self) -> u64 {
        self.source
    }

    /// The surface that the face is part of.
    #[must_use]
    pub fn carrier(&self) -> &Carrier {
        &self.carrier
    }

    /// Index of the shell that it belongs to.
    #[must_use]
    pub fn shell(&self) -> usize {
        self.shell
    }

    /// A box that contains the face.
    #[must_use]
    pub fn bounds(&self) -> &Aabb<3> {
        &self.bounds
    }

    /// Indices of the edges of its boundary, each once.
    #[must_use]
    pub fn edges(&self) -> &[usize] {
        &self.edges
    }

    /// Unit normal of the face at parameters of its carrier; zero where there is none.
    #[must_use]
    pub fn normal(&self, uv: [f64; 2]) -> Vector3<f64> {
        let n = self.surface.normal(&Vector2::from(uv));
        if self.same_sense { n } else { -n }
    }

    /// Where a place of the parameter plane lies.
    pub(crate) fn inside(&self, edges: &[Edge], uv: &Vector2<f64>) -> Inside {
        let found = self.boundary.inside(&self.surface, edges, uv);
        // Paths on a cone lead away from its apex: those from beyond it end on the other side of all loops.
        match self.surface.apex() {
            Some(apex) if uv.y < apex && self.apex_inside() => match found {
                Inside::In => Inside::Out,
                Inside::Out => Inside::In,
                near => near,
            },
            _ => found,
        }
    }

    /// Whether the apex of the cone belongs to the face: an odd number of loops goes around the axis.
    pub(crate) fn apex_inside(&self) -> bool {
        let turns: i64 = self.boundary.windings.iter().map(|w| w[0]).sum();
        self.surface.apex().is_some() && turns.rem_euclid(2) == 1
    }

    /// The box of the parameter plane that holds the face; infinite only on planes.
    pub(crate) fn parameter_box(&self) -> [Vector2<f64>; 2] {
        let [bottom, top] = self.surface.v_range();
        let Some(([mut low, mut high], round)) = self.boundary.extent() else {
            return match self.surface.spline() {
                Some(spline) => {
                    let [u, v] = nurbs_core::ParametricSurface::domain(&spline.surface);
                    [Vector2::new(u.start(), v.start()), Vector2::new(u.end(), v.end())]
                }
                None => [Vector2::new(0.0, bottom), Vector2::new(TAU, top)],
            };
        };
        for i in 0..2 {
            if let Some(period) = self.surface.period[i].filter(|p| round[i] || high[i] - low[i] > *p) {
                high[i] = low[i] + period;
            }
        }
        let ends = self.boundary.ends_inside();
        if let Some(apex) = self.surface.apex() {
            if self.apex_inside() {
                (low.y, high.y) = (low.y.min(apex), high.y.max(apex));
            }
        } else if self.surface.spline().is_some() {
            let i = usize::from(!self.boundary.swap);
            let domain = self.surface.spline().map(|s| nurbs_core::ParametricSurface::domain(&s.surface)[i]);
            if let (Some(domain), None) = (domain, self.surface.period[i]) {
                if ends[0] {
                    low[i] = domain.start();
                }
                if ends[1] {
                    high[i] = domain.end();
                }
            }
        } else if !self.surface.unbounded() && self.surface.period[1].is_none() {
            if ends[0] {
                low.y = bottom;
            }
            if ends[1] {
                high.y = top;
            }
            (low.y, high.y) = (low.y.max(bottom), high.y.min(top));
        }
        [low, high]
    }

    fn find_bounds(&self, edges: &[Edge]) -> Aabb<3> {
        let of_edges = self.edges.iter().map(|e| edges[*e].bounds).reduce(|a, b| a.merged(&b));
        let slack = self.boundary.uses.iter().map(|u| u.tolerance).fold(0.0, f64::max);
        let [low, high] = self.parameter_box();
        let own = match &self.carrier {
            // A plane region lies in the hull of its boundary.
            Carrier::Plane { .. } => None,
            Carrier::Nurbs(_) => {
                self.surface.spline().map(|s| spline_bounds(&s.surface, [low, high], self.surface.period))
            }
            Carrier::Cylinder { frame, radius } => {
                Some(revolved_bounds(frame, [low.x, high.x], [*radius; 2], [low.y, high.y]))
            }
            Carrier::Cone { frame, radius, half_angle } => {
                let at = |v: f64| radius + v * half_angle.tan();
                let f = [at(low.y).min(at(high.y)), at(low.y).max(at(high.y))];
                Some(revolved_bounds(frame, [low.x, high.x], f, [low.y, high.y]))
            }
            Carrier::Sphere { frame, radius } => {
                let (f, g) = (cosine_range(low.y, high.y), cosine_range(low.y - 0.5 * PI, high.y - 0.5 * PI));
                let [f, g] = [f, g].map(|r| r.map(|x| x * radius));
                Some(revolved_bounds(frame, [low.x, high.x], f, g))
            }
            Carrier::Torus { frame, major_radius, minor_radius: r } => {
                let f = cosine_range(low.y, high.y).map(|c| major_radius + r * c);
                let g = cosine_range(low.y - 0.5 * PI, high.y - 0.5 * PI).map(|s| r * s);
                Some(revolved_bounds(frame, [low.x, high.x], f, g))
            }
        };
        let all = match (own, of_edges) {
            (Some(own), Some(edges)) => own.merged(&edges),
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => Aabb::of_point(Vector3::repeat(f64::NAN)),
        };
        let all = self.points.iter().fold(all, |found, p| found.with_point(p));
        all.inflated(slack + 1e-12 * all.diagonal())
    }
}

fn spline_bounds(
    surface: &nurbs_core::BsplineSurface,
    [low, high]: [Vector2<f64>; 2],
    period: [Option<f64>; 2],
) -> Aabb<3> {
    use nurbs_core::{Direction, Interval, ParametricSurface};
    let mut piece = surface.clone();
    for (i, direction) in [(0, Direction::U), (1, Direction::V)] {
        let domain = piece.domain()[i];
        let crosses = period[i].is_some() && (low[i] < domain.start() || high[i] > domain.end());
        let part = Interval::new(low[i].max(domain.start()), high[i].min(domain.end()));
        if let (false, Ok(part)) = (crosses, part) {
            piece = piece.trimmed(direction, part).unwrap_or(piece);
        }
    }
    piece.bounding_box(1e-2)
}

/// Least and largest cosine between two angles.
fn cosine_range(a: f64, b: f64) -> [f64; 2] {
    if b - a >= TAU {
        return [-1.0, 1.0];
    }
    let (ca, cb) = (a.cos(), b.cos());
    let holds = |angle: f64| a + (angle - a).rem_euclid(TAU) <= b;
    [if holds(PI) { -1.0 } else { ca.min(cb) }, if holds(0.0) { 1.0 } else { ca.max(cb) }]
}

/// Box of `m + f e(u) + g z` for `u`, `f` and `g` in intervals.
fn revolved_bounds(frame: &nurbs_core::Frame, u: [f64; 2], f: [f64; 2], g: [f64; 2]) -> Aabb<3> {
    let mut low = Vector3::zeros();
    let mut high = Vector3::zeros();
    for i in 0..3 {
        let (x, y, z) = (frame.x()[i], frame.y()[i], frame.z()[i]);
        let (amplitude, phase) = (x.hypot(y), y.atan2(x));
        let c = cosine_range(u[0] - phase, u[1] - phase).map(|c| c * amplitude);
        let products = [c[0] * f[0], c[0] * f[1], c[1] * f[0], c[1] * f[1]];
        let heights = [z * g[0], z * g[1]];
        let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        low[i] = frame.origin()[i] + least(&products) + least(&heights);
        high[i] = frame.origin()[i] + most(&products) + most(&heights);
    }
    Aabb::of_point(low).with_point(&high)
}
