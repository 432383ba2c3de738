//! Exact distances: windows, roughly in the order of their distances (Chen and Han's method with Xin and Wang's filter, in the buckets
//! of Xu et al. 2015).

use super::queue::Queue;
use super::sides::{Sides, number_of};
use super::window::{Window, length_of};
use crate::MetricMesh;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Angle around a vertex, less a whole turn, above which shortest ways bend at it, radians. At flat vertices they need not.
const SADDLE: f64 = 1e-9;
/// Share of an edge by which a line may miss a window and still count: lines through a vertex are the ends of windows.
const MISS: f64 = 1e-9;
/// Share by which distances may differ and still count as equal.
const EQUAL: f64 = 1e-12;
/// Distances that windows of one bucket span, in mean lengths of edges.
const BUCKET: f64 = 0.5;

/// For each half-edge: of the windows on it that see the opposite vertex, the distance of the best and where its line crosses.
#[derive(Clone, Copy, Debug)]
struct Occupant {
    distance: f64,
    crossing: f64,
}

/// Windows that wait, in buckets by their shortest distance. The order decides how many windows go on in vain, not what is found.
#[derive(Debug)]
struct Buckets {
    width: f64,
    waiting: BTreeMap<u64, Vec<Window>>,
}

impl Buckets {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "distances are not negative, and a cast of a large number saturates"
    )]
    fn of(&self, distance: f64) -> u64 {
        (distance / self.width) as u64
    }

    fn push(&mut self, window: Window) {
        let bucket = self.of(window.least());
        self.waiting.entry(bucket).or_default().push(window);
    }
}

struct Propagation<'a> {
    mesh: &'a MetricMesh,
    sides: Sides,
    distances: Vec<f64>,
    occupants: Vec<Occupant>,
    /// Whether shortest ways may bend at a vertex.
    bends: Vec<bool>,
    /// Vertices whose distance became shorter.
    vertices: Queue<u32>,
    windows: Buckets,
}

/// Distances of all vertices from the nearest source.
pub(super) fn distances(mesh: &MetricMesh, sources: &[u32]) -> Vec<f64> {
    let connectivity = &mesh.connectivity;
    let count = connectivity.vertex_count();
    let mut angles = vec![0.0; count];
    let (mut sum, mut edges) = (0.0, 0.0);
    for half_edge in connectivity.half_edges() {
        angles[connectivity.origin(half_edge) as usize] += mesh.angle(half_edge);
        sum += mesh.length(half_edge);
        edges += 1.0;
    }
    let vertices = u32::try_from(count).unwrap_or(u32::MAX);
    let bends = (0..vertices)
        .map(|vertex| angles[vertex as usize] - TAU > SADDLE || mesh.is_border(vertex))
        .collect();
    let none = Occupant { distance: f64::INFINITY, crossing: 0.0 };
    let sides = Sides::new(mesh);
    let mut propagation = Propagation {
        mesh,
        distances: vec![f64::INFINITY; count],
        occupants: vec![none; sides.len()],
        sides,
        bends,
        vertices: Queue::new(),
        windows: Buckets {
            width: (BUCKET * sum / f64::max(edges, 1.0)).max(f64::MIN_POSITIVE),
            waiting: BTreeMap::new(),
        },
    };
    for &source in sources {
        propagation.distances[source as usize] = 0.0;
        propagation.bends[source as usize] = true;
        propagation.vertices.push(0.0, source);
    }
    propagation.run();
    propagation.distances
}

impl Propagation<'_> {
    fn run(&mut self) {
        loop {
            let first = self.windows.waiting.first_key_value().map(|(&bucket, _)| bucket);
            let nearest = self.vertices.least().map(|distance| self.windows.of(distance));
            let Some(bucket) = first.into_iter().chain(nearest).min() else { break };
            // Vertices before windows: their distances keep windows back.
            self.bend_up_to(bucket);
            for window in self.windows.waiting.remove(&bucket).unwrap_or_default() {
                self.go_on(&window);
                self.bend_up_to(bucket);
            }
        }
    }

    /// Lets ways bend at the vertices that wait no farther than a bucket.
    fn bend_up_to(&mut self, bucket: u64) {
        while self.vertices.least().is_some_and(|distance| self.windows.of(distance) <= bucket) {
            if let Some((distance, vertex)) = self.vertices.pop() {
                self.bend(vertex, distance);
            }
        }
    }

    fn improve(&mut self, vertex: u32, distance: f64) {
        let known = &mut self.distances[vertex as usize];
        if distance < *known {
            *known = distance;
            self.vertices.push(distance, vertex);
        }
    }

    fn add(&mut self, window: Option<Window>) {
        if let Some(window) = window.filter(|window| !window.is_dominated(&self.sides, &self.distances)) {
            self.windows.push(window);
        }
    }

    /// The ways from a vertex: along its edges, and over the opposite edges where they may bend here.
    fn bend(&mut self, vertex: u32, distance: f64) {
        if distance > self.distances[vertex as usize] {
            return;
        }
        let mesh = self.mesh;
        for spoke in mesh.spokes(vertex) {
            self.improve(mesh.connectivity.target(spoke), distance + mesh.length(spoke));
            let back = spoke.previous();
            self.improve(mesh.connectivity.origin(back), distance + mesh.length(back));
        }
        if !self.bends[vertex as usize] {
            return;
        }
        for spoke in mesh.spokes(vertex) {
            let across = number_of(spoke.next());
            let Some(edge) = self.sides.twin(across) else { continue };
            let side = self.sides.get(across);
            let (length, [x, y]) = (side.length, side.apex);
            if length > 0.0 {
                let window = Window { edge, span: [0.0, length], source: [length - x, y], offset: distance };
                self.add(Some(window));
            }
        }
    }

    /// A window into the triangle before it.
    fn go_on(&mut self, window: &Window) {
        if window.is_dominated(&self.sides, &self.distances) {
            return;
        }
        let side = *self.sides.get(window.edge);
        let crossing = window.crossing(side.apex);
        let [start, end] = window.span;
        let [x, y] = side.apex;
        let [u, v] = window.source;
        let distance = window.offset + length_of(x - u, y + v);
        let miss = MISS * side.length;
        if (start - miss..=end + miss).contains(&crossing) {
            self.improve(self.sides.opposite(window.edge), distance);
        }
        if crossing <= start {
            return self.add(window.right(&self.sides, window.span, crossing));
        }
        if crossing >= end {
            return self.add(window.left(&self.sides, window.span, crossing));
        }
        // Only the best of the windows that see a vertex goes on to both of its sides.
        let occupant = &mut self.occupants[window.edge as usize];
        let (mut to_left, mut to_right) = (true, true);
        if distance <= occupant.distance * (1.0 + EQUAL) {
            // Ways of equal length, as over vertices on a straight line, reach different parts of the sides.
            if distance < occupant.distance {
                *occupant = Occupant { distance, crossing };
            }
        } else if crossing < occupant.crossing {
            to_right = false;
        } else {
            to_left = false;
        }
        if to_left {
            self.add(window.left(&self.sides, [start, crossing], crossing));
        }
        if to_right {
            self.add(window.right(&self.sides, [crossing, end], crossing));
        }
    }
}
