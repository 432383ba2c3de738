//! The closest point among those where the face agrees with a direction.
//!
//! Feet that count are the local minima of the distance on each face by itself, its boundary included, where the normal of
//! the face is within an angle of a direction: a scan of a thin wall is then measured on the side that it shows.

use crate::boundary::Inside;
use crate::description::{EdgeCurve, Placement};
use crate::face::Face;
use crate::foot::{Foot, On};
use crate::model::Model;
use crate::part::{Item, Part};
use crate::sign::side;
use footpoint::{Facing, Mode, ProjectionOptions};
use nalgebra::{Vector2, Vector3};

/// Places of an edge at which minima are looked for.
const PLACES: u32 = 32;
/// Steps of the search for a minimum between two places.
const STEPS: usize = 60;
/// Options of the searches on B-splines.
const OPTIONS: ProjectionOptions = ProjectionOptions {
    mode: Mode::Certified,
    relative_gap: 1e-10,
    size_gap: 1e-10,
    tie_tolerance: 1e-9,
    max_boxes: 200_000,
};

/// A foot that counts.
#[derive(Clone, Copy)]
struct Found {
    distance: f64,
    face: usize,
    on: On,
    point: Vector3<f64>,
    normal: Vector3<f64>,
    /// The foot lies on an edge with a face on one side only.
    open: bool,
}

struct Query<'a> {
    part: &'a Part,
    x: &'a Vector3<f64>,
    facing: &'a Facing,
    reach: f64,
    /// No foot that counts is nearer.
    lower: f64,
    found: Option<Found>,
}

impl Model {
    /// The closest of the feet that count: local minima of the distance on single faces whose normal is within the angle of
    /// `facing`. `None` where there is none, and for points that are not finite.
    ///
    /// The bound of the foot is for feet that count; it is that of a box around the edge where minima on a free-form edge are not
    /// proven to be all.
    #[must_use]
    pub fn nearest_facing(&self, x: &Vector3<f64>, facing: &Facing) -> Option<Foot> {
        if !x.iter().all(|c| c.is_finite()) {
            return None;
        }
        match self.nearer(x) {
            Some(near) => self.nearest_facing_to(&near, facing)?.of_far(x),
            None => self.nearest_facing_to(x, facing),
        }
    }

    fn nearest_facing_to(&self, x: &Vector3<f64>, facing: &Facing) -> Option<Foot> {
        let mut best: Option<Foot> = None;
        let mut lower = f64::INFINITY;
        for (index, instance) in self.instances().iter().enumerate() {
            let placement = &instance.placement;
            let reach = best.as_ref().map_or(f64::INFINITY, |best| best.distance);
            let local = placement.inverse_point(x);
            let Some(towards) = turned_back(facing, placement) else { continue };
            let part = &self.parts()[instance.part];
            let mut query = Query {
                part,
                x: &local,
                facing: &towards,
                reach: reach / placement.scale,
                lower: f64::INFINITY,
                found: None,
            };
            part.tree.search(&local, query.reach, &mut |item| {
                if let Item::Face(face) = part.items[item] {
                    query.face(face);
                }
                query.reach
            });
            lower = lower.min(query.lower * placement.scale);
            let Some(found) = query.found else { continue };
            let point = placement.point(&found.point);
            let distance = (x - point).norm();
            if best.as_ref().is_none_or(|best| distance < best.distance) {
                let normal = placement.direction(&found.normal);
                best = Some(Foot {
                    instance: index,
                    face: Some(found.face),
                    on: found.on,
                    point,
                    distance,
                    lower_bound: distance,
                    side: side(&(x - point), &normal),
                    normal,
                    beyond_boundary: found.open,
                });
            }
        }
        best.map(|best| Foot { lower_bound: lower.min(best.distance), ..best })
    }
}

/// The direction in the coordinates of a part.
fn turned_back(facing: &Facing, placement: &Placement) -> Option<Facing> {
    let origin = placement.inverse_point(&Vector3::zeros());
    let direction = placement.inverse_point(&(facing.direction() * placement.scale)) - origin;
    Facing::new(&direction, facing.max_angle()).ok()
}

impl Query<'_> {
    fn offer(&mut self, found: Found, lower: f64) {
        self.lower = self.lower.min(lower);
        if found.distance < self.reach {
            self.reach = found.distance;
            self.found = Some(found);
        }
    }

    fn face(&mut self, index: usize) {
        let face = &self.part.faces[index];
        if face.bounds.distance(self.x) > self.reach {
            return;
        }
        // A plane agrees everywhere or nowhere.
        if face.surface.is_plane() && !self.facing.agrees(&face.normal([0.0; 2])) {
            return;
        }
        (0..face.boundary.uses.len()).for_each(|used| self.edge(index, face, used));
        if face.surface.spline().is_some() {
            self.spline(index, face);
            return;
        }
        for uv in face.surface.near_feet(self.x) {
            let point = face.surface.point(&uv);
            let distance = (self.x - point).norm();
            self.interior(index, face, &uv, point, distance);
        }
    }

    /// Takes a foot on the carrier if it lies on the face and agrees.
    fn interior(&mut self, index: usize, face: &Face, uv: &Vector2<f64>, point: Vector3<f64>, lower: f64) {
        let (distance, normal) = ((self.x - point).norm(), face.normal([uv.x, uv.y]));
        if lower > self.reach || !self.facing.agrees(&normal) {
            return;
        }
        match face.inside(&self.part.edges, uv) {
            Inside::In => {
                let on = On::Face { face: index, uv: [uv.x, uv.y] };
                self.offer(Found { distance, face: index, on, point, normal, open: false }, lower);
            }
            Inside::Out => {}
            // Inside or not, the edge was looked at; it is not nearer than this.
            Inside::Near(_) => self.lower = self.lower.min(lower),
        }
    }

    /// All minima of the distance on a B-spline face up to the best one so far.
    fn spline(&mut self, index: usize, face: &Face) {
        let Some(spline) = face.surface.spline() else { return };
        let Ok(nearest) = spline.projector.project_with(self.x, &OPTIONS) else { return };
        if !nearest.distance.is_finite() {
            self.lower = 0.0;
            return;
        }
        if nearest.lower_bound > self.reach {
            return;
        }
        // From a point of the carrier no factor leads anywhere; one beside it has the same minima.
        let tiny = 1e-11 * self.part.size;
        let uv = Vector2::from(nearest.parameter);
        let (x, shift) = if nearest.distance < tiny {
            (self.x + face.surface.normal(&uv) * tiny, tiny)
        } else {
            (*self.x, 0.0)
        };
        let box_size = spline.surface.control_box().diagonal();
        let farthest = self.reach.min(nearest.distance + 2.0 * box_size) + shift;
        let factor =
            (farthest / (x - nearest.point).norm().max(f64::MIN_POSITIVE) * (1.0 + 1e-9)).clamp(1.0, 1e13);
        let Ok(all) = spline.projector.feet_within(&x, factor, &OPTIONS) else {
            self.lower = self.lower.min(nearest.lower_bound);
            return;
        };
        for foot in &all.feet {
            let distance = (self.x - foot.point).norm();
            let slack = (1e-9 * distance).min(1e-10 * self.part.size) + shift;
            let lower = (distance - slack).max(nearest.lower_bound);
            self.interior(index, face, &Vector2::from(foot.parameter), foot.point, lower);
        }
        if !(all.complete || all.continuum) {
            self.lower = self.lower.min(nearest.lower_bound);
        }
    }

    /// The minima on an edge of a face.
    fn edge(&mut self, index: usize, face: &Face, used: usize) {
        let edge_index = face.boundary.uses[used].edge;
        let edge = &self.part.edges[edge_index];
        let box_distance = edge.bounds.distance(self.x);
        if box_distance > self.reach {
            return;
        }
        let normal_at = |t: f64, point: &Vector3<f64>| self.part.normal_at(index, used, t, point);
        let open = edge.uses.len() < 2;
        let found_at = |t: f64| {
            let point = edge.curve.point(t);
            let normal = normal_at(t, &point);
            let end = [0, 1].into_iter().find(|end| edge.range[*end] == t);
            let on = end.map_or(On::Edge { edge: edge_index, t }, |end| On::Vertex { edge: edge_index, end });
            Found { distance: (self.x - point).norm(), face: index, on, point, normal, open }
        };
        let nearest = edge.project(self.x);
        if !nearest.distance.is_finite() {
            self.lower = 0.0;
            return;
        }
        let first = found_at(nearest.end.map_or(nearest.t, |end| edge.range[end]));
        if self.facing.agrees(&first.normal) {
            self.offer(first, nearest.lower.min(first.distance));
            return;
        }
        // A line has one minimum; along an edge of a plane the normal does not change.
        if matches!(edge.curve, EdgeCurve::Line { .. }) || face.surface.is_plane() {
            return;
        }
        let minima = minima(|t| (edge.curve.point(t) - self.x).norm_squared(), edge.range);
        let others: Vec<Found> =
            minima.into_iter().map(found_at).filter(|other| self.facing.agrees(&other.normal)).collect();
        let is_exact = matches!(edge.curve, EdgeCurve::Circle { .. });
        if !is_exact {
            self.lower = self.lower.min(box_distance);
        }
        for other in others {
            self.offer(other, if is_exact { other.distance } else { box_distance });
        }
    }
}

/// Local minima of a function on an interval, its ends included, as far as they show at equal steps.
fn minima(f: impl Fn(f64) -> f64, [a, b]: [f64; 2]) -> Vec<f64> {
    let at = |k: u32| if k == PLACES { b } else { a + (b - a) * f64::from(k) / f64::from(PLACES) };
    let values: Vec<f64> = (0..=PLACES).map(|k| f(at(k))).collect();
    let mut out = Vec::new();
    for (k, place) in (0..=PLACES).zip(0_usize..) {
        let before = place.checked_sub(1).map_or(f64::INFINITY, |i| values[i]);
        let after = values.get(place + 1).copied().unwrap_or(f64::INFINITY);
        if values[place] > before || values[place] > after {
            continue;
        }
        let (mut low, mut high) = (at(k.saturating_sub(1)), at((k + 1).min(PLACES)));
        for _ in 0..STEPS {
            let third = (high - low) / 3.0;
            let (c, d) = (low + third, high - third);
            if f(c) <= f(d) { high = d } else { low = c }
        }
        // At an end the search comes as near as rounding allows.
        let middle = 0.5 * (low + high);
        out.push(if f(a) <= f(middle) && k <= 1 {
            a
        } else if f(b) <= f(middle) && k + 1 >= PLACES {
            b
        } else {
            middle
        });
    }
    out
}
