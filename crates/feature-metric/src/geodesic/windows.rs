//! Exact distances: windows in the order of their distances (Chen and Han's method with Xin and Wang's filter and queue).

use super::queue::Queue;
use super::window::Window;
use crate::MetricMesh;
use mesh_core::HalfEdge;
use std::f64::consts::TAU;

/// Angle around a vertex, less a whole turn, above which shortest ways bend at it, radians. At flat vertices they need not.
const SADDLE: f64 = 1e-9;
/// Share of an edge by which a line may miss a window and still count: lines through a vertex are the ends of windows.
const MISS: f64 = 1e-9;

/// Share by which distances may differ and still count as equal.
const EQUAL: f64 = 1e-12;

#[derive(Clone, Copy, Debug)]
enum Event {
    /// The distance of a vertex became shorter.
    Vertex(u32),
    Window(Window),
}

/// For each half-edge: of the windows on it that see the opposite vertex, the distance of the best and where its line crosses.
#[derive(Clone, Copy, Debug)]
struct Occupant {
    distance: f64,
    crossing: f64,
}

struct Propagation<'a> {
    mesh: &'a MetricMesh,
    distances: Vec<f64>,
    occupants: Vec<Occupant>,
    /// Whether shortest ways may bend at a vertex.
    bends: Vec<bool>,
    queue: Queue<Event>,
}

/// Distances of all vertices from the nearest source.
pub(super) fn distances(mesh: &MetricMesh, sources: &[u32]) -> Vec<f64> {
    let connectivity = &mesh.connectivity;
    let count = connectivity.vertex_count();
    let mut angles = vec![0.0; count];
    for half_edge in connectivity.half_edges() {
        angles[connectivity.origin(half_edge) as usize] += mesh.angle(half_edge);
    }
    let vertices = u32::try_from(count).unwrap_or(u32::MAX);
    let bends = (0..vertices)
        .map(|vertex| angles[vertex as usize] - TAU > SADDLE || mesh.is_border(vertex))
        .collect();
    let none = Occupant { distance: f64::INFINITY, crossing: 0.0 };
    let mut propagation = Propagation {
        mesh,
        distances: vec![f64::INFINITY; count],
        occupants: vec![none; 3 * connectivity.triangles().len()],
        bends,
        queue: Queue::new(),
    };
    for &source in sources {
        propagation.distances[source as usize] = 0.0;
        propagation.bends[source as usize] = true;
        propagation.queue.push(0.0, Event::Vertex(source));
    }
    while let Some((distance, event)) = propagation.queue.pop() {
        match event {
            Event::Vertex(vertex) => propagation.bend(vertex, distance),
            Event::Window(window) => propagation.go_on(&window),
        }
    }
    propagation.distances
}

impl Propagation<'_> {
    fn improve(&mut self, vertex: u32, distance: f64) {
        let known = &mut self.distances[vertex as usize];
        if distance < *known {
            *known = distance;
            self.queue.push(distance, Event::Vertex(vertex));
        }
    }

    fn add(&mut self, window: Option<Window>) {
        if let Some(window) = window.filter(|window| !window.is_dominated(self.mesh, &self.distances)) {
            self.queue.push(window.least(), Event::Window(window));
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
            let across = spoke.next();
            let Some(edge) = mesh.connectivity.twin(across) else { continue };
            let (length, [x, y]) = (mesh.length(across), mesh.apex(across));
            if length > 0.0 {
                let window = Window { edge, span: [0.0, length], source: [length - x, y], offset: distance };
                self.add(Some(window));
            }
        }
    }

    /// A window into the triangle before it.
    fn go_on(&mut self, window: &Window) {
        let mesh = self.mesh;
        if window.is_dominated(mesh, &self.distances) {
            return;
        }
        let apex = mesh.apex(window.edge);
        let crossing = window.crossing(apex);
        let [start, end] = window.span;
        let [x, y] = apex;
        let [u, v] = window.source;
        let distance = window.offset + (x - u).hypot(y + v);
        let vertex = mesh.connectivity.origin(window.edge.previous());
        let miss = MISS * mesh.length(window.edge);
        if (start - miss..=end + miss).contains(&crossing) {
            self.improve(vertex, distance);
        }
        if crossing <= start {
            return self.add(window.right(mesh, apex, window.span));
        }
        if crossing >= end {
            return self.add(window.left(mesh, apex, window.span));
        }
        // Only the best of the windows that see a vertex goes on to both of its sides.
        let occupant = &mut self.occupants[number(window.edge)];
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
            self.add(window.left(mesh, apex, [start, crossing]));
        }
        if to_right {
            self.add(window.right(mesh, apex, [crossing, end]));
        }
    }
}

fn number(half_edge: HalfEdge) -> usize {
    3 * half_edge.triangle() + half_edge.edge()
}
