//! The certified closest point of a part.
//!
//! The nearest point of a trimmed surface is a local minimum of the distance from its carrier that lies inside the
//! boundary, or it lies on an edge. Planes, cylinders, cones, spheres and tori have one such minimum (cones one on each
//! nappe, and the apex), so that no search is needed. On a B-spline carrier the certified search finds the nearest point;
//! where that is outside, all local minima up to the best distance found elsewhere.

use crate::boundary::Inside;
use crate::face::Face;
use crate::foot::{Foot, On, Side};
use crate::part::{Item, Part};
use crate::sign::{Sides, side};
use footpoint::{Mode, ProjectionOptions};
use nalgebra::{Vector2, Vector3};

/// Factor by which the range of a search for minima may exceed the distance of the carrier.
const MAX_FACTOR: f64 = 1e13;

/// Share of the size of the part within which feet count as equally near.
const TIE: f64 = 1e-11;

/// Share of the size of the part within which feet that are equally near lie at one place.
const SAME_PLACE: f64 = 1e-5;

/// What distances are rounded by, as a share of them.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The best foot so far, those that are as near, and what is proven.
struct Best {
    distance: f64,
    lower: f64,
    found: Option<(On, Vector3<f64>)>,
    /// Feet that were as near as the best one when they were found.
    ties: Vec<(f64, On, Vector3<f64>)>,
    /// Distance within which feet count as equally near.
    tie: f64,
}

impl Best {
    fn offer(&mut self, distance: f64, lower: f64, on: On, point: Vector3<f64>) {
        if distance <= self.reach() {
            self.ties.push((distance, on, point));
        }
        if distance < self.distance {
            self.distance = distance;
            self.found = Some((on, point));
        }
        self.lower = self.lower.min(lower);
    }

    /// Distance beyond which nothing matters.
    fn reach(&self) -> f64 {
        self.distance * (1.0 + ROUNDING) + self.tie
    }
}

/// Options of the searches on B-splines: the gap is to be a small share of the size, however far away the point is.
const OPTIONS: ProjectionOptions = ProjectionOptions {
    mode: Mode::Certified,
    relative_gap: 1e-10,
    size_gap: 1e-10,
    tie_tolerance: 1e-9,
    max_boxes: 200_000,
};

/// State of a query: edges are looked at once.
struct Query<'a> {
    part: &'a Part,
    x: &'a Vector3<f64>,
    best: Best,
    edges_done: Vec<usize>,
}

impl Part {
    /// The closest point if it is nearer than `reach`, and a bound below which no point of the part lies, as far as it
    /// is less than `reach`.
    pub(crate) fn nearest_within(&self, x: &Vector3<f64>, reach: f64) -> (Option<Foot>, f64) {
        let tie = TIE * self.size;
        let best = Best { distance: reach, lower: f64::INFINITY, found: None, ties: Vec::new(), tie };
        let mut query = Query { part: self, x, best, edges_done: Vec::new() };
        self.tree.search(x, reach, &mut |item| {
            match self.items[item] {
                Item::Face(face) => query.face(face),
                Item::Edge(edge) => query.edge(edge),
                Item::Point(face, index) => {
                    let point = self.faces[face].points[index];
                    let distance = (x - point).norm();
                    query.best.offer(distance, distance, On::Apex { face }, point);
                }
            }
            query.best.reach()
        });
        let reach = query.best.reach();
        let Best { distance, lower, found, ties, .. } = query.best;
        let Some((on, point)) = found else { return (None, lower) };
        let mut chosen = (on, point, self.sides(on, x, &point));
        let nearest = point;
        // Where solids touch, faces at one place have opposite normals: inside of one of them is inside.
        for (_, on, point) in ties.into_iter().filter(|t| t.0 <= reach) {
            let sides = self.sides(on, x, &point);
            let is_there = (point - nearest).norm() <= SAME_PLACE * self.size;
            if is_there
                && chosen.2.side == Side::Positive
                && sides.side == Side::Negative
                && self.is_closed_at(&sides)
            {
                chosen = (on, point, sides);
            }
        }
        let (on, point, Sides { side, normal, open, face }) = chosen;
        let distance = distance.max((x - point).norm());
        let lower_bound = lower.min(distance);
        let foot =
            Foot { instance: 0, face, on, point, distance, lower_bound, side, normal, beyond_boundary: open };
        (Some(foot), lower_bound)
    }

    fn sides(&self, on: On, x: &Vector3<f64>, point: &Vector3<f64>) -> Sides {
        let offset = x - point;
        match on {
            On::Face { face, uv } => {
                let normal = self.faces[face].normal(uv);
                Sides { side: side(&offset, &normal), normal, open: false, face: Some(face) }
            }
            On::Edge { edge, t } => self.edge_sides(edge, t, &offset),
            On::Vertex { edge, end } => self.vertex_sides(self.edges[edge].vertices[end], edge, &offset),
            On::Apex { face } => self.apex_side(face, x, point),
        }
    }

    /// Whether the face of a foot belongs to a closed shell.
    fn is_closed_at(&self, sides: &Sides) -> bool {
        sides.face.is_some_and(|face| self.shells[self.faces[face].shell].closed)
    }

    /// The closest point of the part; `None` for a part that is empty and for points that are not finite.
    #[must_use]
    pub fn nearest(&self, x: &Vector3<f64>) -> Option<Foot> {
        if !x.iter().all(|c| c.is_finite()) {
            return None;
        }
        self.nearest_within(x, f64::INFINITY).0
    }
}

impl Query<'_> {
    fn edge(&mut self, edge: usize) {
        if self.edges_done.contains(&edge) {
            return;
        }
        self.edges_done.push(edge);
        let e = &self.part.edges[edge];
        if e.bounds.distance(self.x) > self.best.reach() {
            return;
        }
        let foot = e.project(self.x);
        let on = match foot.end {
            Some(end) => On::Vertex { edge, end },
            None => On::Edge { edge, t: foot.t },
        };
        if foot.distance.is_finite() {
            self.best.offer(foot.distance, foot.lower, on, foot.point);
        }
    }

    fn face(&mut self, index: usize) {
        let face = &self.part.faces[index];
        if face.bounds.distance(self.x) > self.best.reach() {
            return;
        }
        if face.surface.spline().is_some() {
            // What is known about the edges limits the search on the surface.
            face.edges.iter().for_each(|&edge| self.edge(edge));
            self.spline_face(index, face);
            return;
        }
        for uv in face.surface.near_feet(self.x) {
            let point = face.surface.point(&uv);
            let distance = (self.x - point).norm();
            self.candidate(index, face, &uv, point, distance, distance);
        }
        if let Some(apex) = face.surface.apex().filter(|_| face.apex_inside()) {
            let point = face.surface.point(&Vector2::new(0.0, apex));
            let distance = (self.x - point).norm();
            self.best.offer(distance, distance, On::Apex { face: index }, point);
        }
    }

    /// Takes a foot on the carrier if it lies on the face.
    fn candidate(
        &mut self,
        index: usize,
        face: &Face,
        uv: &Vector2<f64>,
        point: Vector3<f64>,
        distance: f64,
        lower: f64,
    ) -> bool {
        if distance > self.best.reach() {
            return false;
        }
        match face.inside(&self.part.edges, uv) {
            Inside::In => {
                self.best.offer(distance, lower, On::Face { face: index, uv: [uv.x, uv.y] }, point);
                true
            }
            Inside::Out => false,
            Inside::Near(owner) => {
                // Inside or not, it is not nearer than this; the edge is a point of the face for certain.
                self.best.lower = self.best.lower.min(lower);
                let edge = face.boundary.uses[owner].edge;
                self.edge(edge);
                false
            }
        }
    }

    fn spline_face(&mut self, index: usize, face: &Face) {
        let Some(spline) = face.surface.spline() else { return };
        let Ok(nearest) = spline.projector.project_with(self.x, &OPTIONS) else { return };
        if !nearest.distance.is_finite() {
            self.best.lower = 0.0;
            return;
        }
        if nearest.lower_bound > self.best.reach() {
            return;
        }
        let uv = Vector2::from(nearest.parameter);
        if face.boundary.chords.is_empty() {
            self.candidate(index, face, &uv, nearest.point, nearest.distance, nearest.lower_bound);
            return;
        }
        if nearest.distance < self.best.distance && face.inside(&self.part.edges, &uv) == Inside::In {
            self.candidate(index, face, &uv, nearest.point, nearest.distance, nearest.lower_bound);
            return;
        }
        // The nearest point of the carrier is cut away: other minima of the distance may be inside.
        let tiny = 1e-11 * self.part.size;
        let (x, shift) = if nearest.distance < tiny {
            // From a point of the carrier no factor leads anywhere; one beside it has the same minima.
            (self.x + face.surface.normal(&uv) * tiny, tiny)
        } else {
            (*self.x, 0.0)
        };
        let own = (x - nearest.point).norm().max(f64::MIN_POSITIVE);
        let factor = ((self.best.distance + shift) / own * (1.0 + 1e-9)).clamp(1.0, MAX_FACTOR);
        let Ok(all) = spline.projector.feet_within(&x, factor, &OPTIONS) else {
            self.best.lower = self.best.lower.min(nearest.lower_bound);
            return;
        };
        for foot in &all.feet {
            let point = foot.point;
            let distance = (self.x - point).norm();
            let slack = (1e-9 * distance).min(1e-10 * self.part.size) + shift;
            let uv = Vector2::from(foot.parameter);
            self.candidate(index, face, &uv, point, distance, (distance - slack).max(nearest.lower_bound));
        }
        if !(all.complete || all.continuum) {
            // Minima may have been missed: nothing more is known than about the whole carrier.
            self.best.lower = self.best.lower.min(nearest.lower_bound);
        }
    }
}
