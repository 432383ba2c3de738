//! Ways over a mesh, made shorter until they are straight.

use super::funnel::Strip;
use crate::MetricMesh;
use mesh_core::HalfEdge;
use std::f64::consts::PI;

/// Angle by which a way may bend and still count as straight, radians.
const STRAIGHT: f64 = 1e-10;
/// Most corrections per vertex of the first way, and at least.
const CORRECTIONS: [usize; 2] = [50, 1000];

/// A way over a mesh: vertices, and the edges that are crossed between each and the next, by their half-edges in the triangles that
/// are left. Without any, the way runs along the edge between the two.
#[derive(Clone, Debug)]
pub(super) struct Route {
    pub(super) vertices: Vec<u32>,
    pub(super) crossed: Vec<Vec<HalfEdge>>,
}

/// A direction at a vertex: between one of its spokes and the next.
#[derive(Clone, Copy, Debug)]
struct Direction {
    spoke: usize,
    /// Angle from the first spoke.
    angle: f64,
    on_edge: bool,
}

/// The triangles around a vertex.
struct Fan {
    spokes: Vec<HalfEdge>,
    /// Angles of the spokes from the first one, and that of all triangles together.
    angles: Vec<f64>,
    is_closed: bool,
}

impl Route {
    /// Along edges.
    pub(super) fn along(vertices: Vec<u32>) -> Self {
        let crossed = vec![Vec::new(); vertices.len().saturating_sub(1)];
        Self { vertices, crossed }
    }

    /// Makes the way a locally shortest one; whether it is one.
    pub(super) fn straighten(&mut self, mesh: &MetricMesh) -> bool {
        let mut left = (CORRECTIONS[0] * self.vertices.len()).max(CORRECTIONS[1]);
        let mut i = 1;
        let mut since = 0;
        while self.vertices.len() > 2 && since < self.vertices.len() {
            if i + 1 >= self.vertices.len() {
                i = 1;
            }
            if self.correct(mesh, i) {
                left -= 1;
                if left == 0 {
                    return false;
                }
                since = 0;
                i = i.saturating_sub(1).max(1);
            } else {
                since += 1;
                i += 1;
            }
        }
        true
    }

    /// Takes the way around a vertex where it bends; whether it did.
    fn correct(&mut self, mesh: &MetricMesh, i: usize) -> bool {
        let Some(around) = self.around(mesh, i) else { return false };
        let (from, to) = (self.vertices[i - 1], self.vertices[i + 1]);
        let merged: Vec<HalfEdge> =
            self.crossed[i - 1].iter().chain(&around).chain(&self.crossed[i]).copied().collect();
        let (mut vertices, mut crossed) = (vec![from], Vec::new());
        if merged.is_empty() {
            crossed.push(Vec::new());
        } else {
            let Some(strip) = Strip::unfold(mesh, &merged) else { return false };
            let bends = strip.bends(mesh, &merged);
            if matches!(bends.as_slice(), [bend] if bend.vertex == self.vertices[i]) {
                return false;
            }
            let mut places = vec![(0, from)];
            places.extend(bends.iter().map(|bend| (bend.portal, bend.vertex)));
            places.push((merged.len() - 1, to));
            for pair in places.windows(2) {
                let [(first, a), (last, b)] = [pair[0], pair[1]];
                let apart = |edge: &&HalfEdge| {
                    let ends = [mesh.connectivity.origin(**edge), mesh.connectivity.target(**edge)];
                    !ends.contains(&a) && !ends.contains(&b)
                };
                crossed.push(merged[first..=last.max(first)].iter().filter(apart).copied().collect());
            }
            vertices.extend(bends.iter().map(|bend| bend.vertex));
        }
        self.vertices.splice(i - 1..=i, vertices);
        self.crossed.splice(i - 1..=i, crossed);
        true
    }

    /// The spokes of a vertex that a way around it crosses, on the side on which it bends; `None` where it does not.
    fn around(&self, mesh: &MetricMesh, i: usize) -> Option<Vec<HalfEdge>> {
        let fan = Fan::of(mesh, self.vertices[i]);
        let to = self.leaving(mesh, i, &fan)?;
        let from = self.arriving(mesh, i, &fan)?;
        let whole = *fan.angles.last()?;
        let turn = |one: &Direction, other: &Direction| {
            let angle = other.angle - one.angle;
            match (angle >= 0.0, fan.is_closed) {
                (true, _) => angle,
                (false, true) => angle + whole,
                (false, false) => f64::INFINITY,
            }
        };
        // Counter-clockwise from the way out to the way in, or from the way in to the way out.
        let (right, left) = (turn(&to, &from), turn(&from, &to));
        if right.min(left) >= PI - STRAIGHT {
            return None;
        }
        if right <= left {
            // From the way in, clockwise.
            return Some(fan.between(&to, &from).into_iter().rev().collect());
        }
        fan.between(&from, &to).into_iter().map(|spoke| mesh.connectivity.twin(spoke)).collect()
    }

    fn leaving(&self, mesh: &MetricMesh, i: usize, fan: &Fan) -> Option<Direction> {
        let crossed = &self.crossed[i];
        let Some(first) = crossed.first() else { return fan.towards(mesh, self.vertices[i + 1]) };
        let strip = Strip::unfold(mesh, crossed)?;
        let [_, origin] = strip.portals[0];
        fan.inside(first.previous(), between(strip.start, origin, strip.end))
    }

    fn arriving(&self, mesh: &MetricMesh, i: usize, fan: &Fan) -> Option<Direction> {
        let crossed = &self.crossed[i - 1];
        let Some(last) = crossed.last() else { return fan.towards(mesh, self.vertices[i - 1]) };
        let entered = mesh.connectivity.twin(*last)?;
        let strip = Strip::unfold(mesh, crossed)?;
        let [origin, _] = *strip.portals.last()?;
        fan.inside(entered.previous(), between(strip.end, origin, strip.start))
    }
}

impl Fan {
    fn of(mesh: &MetricMesh, vertex: u32) -> Self {
        let spokes: Vec<HalfEdge> = mesh.connectivity.spokes(vertex).collect();
        let mut angles = vec![0.0];
        let mut sum = 0.0;
        for &spoke in &spokes {
            sum += mesh.angle(spoke);
            angles.push(sum);
        }
        Self { spokes, angles, is_closed: !mesh.connectivity.is_boundary(vertex) }
    }

    /// Along the edge to a neighbour.
    fn towards(&self, mesh: &MetricMesh, neighbour: u32) -> Option<Direction> {
        let found = self.spokes.iter().position(|&spoke| mesh.connectivity.target(spoke) == neighbour);
        // The last edge of an open fan is no spoke.
        let last = || {
            let last = *self.spokes.last()?;
            let is_last = mesh.connectivity.origin(last.previous()) == neighbour;
            is_last.then_some(self.spokes.len())
        };
        let spoke = found.or_else(last)?;
        Some(Direction { spoke, angle: self.angles[spoke], on_edge: true })
    }

    /// Inside the triangle of a spoke, at an angle from it.
    fn inside(&self, spoke: HalfEdge, angle: f64) -> Option<Direction> {
        let spoke = self.spokes.iter().position(|&other| other == spoke)?;
        Some(Direction { spoke, angle: self.angles[spoke] + angle, on_edge: false })
    }

    /// The spokes between two directions, counter-clockwise.
    fn between(&self, one: &Direction, other: &Direction) -> Vec<HalfEdge> {
        let count = self.spokes.len();
        let first = one.spoke + 1;
        let wrap = if other.angle < one.angle { count } else { 0 };
        let end = other.spoke + usize::from(!other.on_edge) + wrap;
        (first..end.max(first)).map(|k| self.spokes[k % count]).collect()
    }
}

/// The angle at a point between two others, not negative.
fn between(at: [f64; 2], one: [f64; 2], other: [f64; 2]) -> f64 {
    let [a, b] = [one, other].map(|p| [p[0] - at[0], p[1] - at[1]]);
    (a[0] * b[1] - a[1] * b[0]).abs().atan2(a[0] * b[0] + a[1] * b[1])
}
