//! Geodesic curves on meshes.

use super::Distances;
use super::funnel::Strip;
use super::straighten::Route;
use crate::{Error, MetricMesh};
use nalgebra::Point3;

/// Ways that are made straight: over so many neighbours of the target.
const TRIED: usize = 12;

/// A locally shortest way over a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct GeodesicPath {
    /// Points in space, from the source to the target: where the way crosses edges or passes vertices.
    pub points: Vec<Point3<f64>>,
    /// Length in the metric of the mesh.
    pub length: f64,
    /// Whether no piece of it can be made shorter within the mesh.
    pub is_geodesic: bool,
}

impl MetricMesh {
    /// A geodesic from the sources of some distances to a vertex: ways down these distances, over each neighbour of the vertex,
    /// are made straight, and the shortest counts. `None` if no way leads there.
    ///
    /// # Errors
    /// [`Error::Vertex`] if the vertex belongs to no triangle.
    pub fn path(&self, distances: &Distances, target: usize) -> Result<Option<GeodesicPath>, Error> {
        let inner = &distances.inner;
        let places = self.places(target)?.iter().copied();
        let Some(target) = places.min_by(|a, b| inner[*a as usize].total_cmp(&inner[*b as usize])) else {
            return Ok(None);
        };
        let at_target = inner[target as usize];
        if at_target.is_infinite() {
            return Ok(None);
        }
        if distances.sources.binary_search(&target).is_ok() {
            let points = vec![self.points[target as usize]];
            return Ok(Some(GeodesicPath { points, length: 0.0, is_geodesic: true }));
        }
        let mut nearer = self.neighbours(target);
        nearer.retain(|(vertex, _)| inner[*vertex as usize] < at_target);
        nearer.sort_by(|a, b| {
            (inner[a.0 as usize] + a.1).total_cmp(&(inner[b.0 as usize] + b.1)).then(a.0.cmp(&b.0))
        });
        let mut best: Option<GeodesicPath> = None;
        for (neighbour, _) in nearer.into_iter().take(TRIED) {
            let mut vertices = vec![target, neighbour];
            if !self.descend(distances, &mut vertices) {
                continue;
            }
            vertices.reverse();
            let mut route = Route::along(vertices);
            let is_geodesic = route.straighten(self);
            let Some(path) = self.unfolded(&route, is_geodesic) else { continue };
            if best.as_ref().is_none_or(|best| path.length < best.length) {
                best = Some(path);
            }
        }
        Ok(best)
    }

    fn neighbours(&self, vertex: u32) -> Vec<(u32, f64)> {
        let mut found = Vec::new();
        for spoke in self.spokes(vertex) {
            found.push((self.connectivity.target(spoke), self.length(spoke)));
            let back = spoke.previous();
            if self.connectivity.twin(back).is_none() {
                found.push((self.connectivity.origin(back), self.length(back)));
            }
        }
        found
    }

    /// Goes on along edges to a source; whether it came there.
    fn descend(&self, distances: &Distances, vertices: &mut Vec<u32>) -> bool {
        let inner = &distances.inner;
        while let Some(&last) = vertices.last() {
            if distances.sources.binary_search(&last).is_ok() {
                return true;
            }
            let down =
                self.neighbours(last).into_iter().filter(|(v, _)| inner[*v as usize] < inner[last as usize]);
            let next =
                down.min_by(|a, b| (inner[a.0 as usize] + a.1).total_cmp(&(inner[b.0 as usize] + b.1)));
            match next {
                Some((next, _)) => vertices.push(next),
                None => return false,
            }
        }
        false
    }

    /// The points of a way, and its length.
    fn unfolded(&self, route: &Route, is_geodesic: bool) -> Option<GeodesicPath> {
        let point = |vertex: u32| self.points[vertex as usize];
        let mut points = vec![point(*route.vertices.first()?)];
        let mut length = 0.0;
        for (pair, crossed) in route.vertices.windows(2).zip(&route.crossed) {
            if crossed.is_empty() {
                let found = self.neighbours(pair[0]).into_iter().find(|(vertex, _)| *vertex == pair[1]);
                length += found?.1;
            } else {
                let strip = Strip::unfold(self, crossed)?;
                let [a, b] = [strip.start, strip.end];
                length += (b[0] - a[0]).hypot(b[1] - a[1]);
                for ([left, right], edge) in strip.portals.iter().zip(crossed) {
                    let share = crossing(a, b, *left, *right);
                    let (to, from) =
                        (point(self.connectivity.target(*edge)), point(self.connectivity.origin(*edge)));
                    points.push(to + (from - to) * share);
                }
            }
            points.push(point(pair[1]));
        }
        points.dedup();
        Some(GeodesicPath { points, length, is_geodesic })
    }
}

/// Where the line from `a` to `b` crosses the segment from `left` to `right`, as a share of it.
fn crossing(a: [f64; 2], b: [f64; 2], left: [f64; 2], right: [f64; 2]) -> f64 {
    let side = |p: [f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let (one, other) = (side(left), side(right));
    let share = one / (one - other);
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 }
}
