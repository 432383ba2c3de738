//! The boundary of a patch, on the boundary of the domain.

use super::{NONE, ParameterDomain, ParameterOptions};
use crate::{Error, MetricMesh};
use mesh_core::TriangleMesh;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// Turn of the boundary at a vertex from which on it is a corner: nearer to a right angle than to a straight line.
const CORNER: f64 = FRAC_PI_4;

/// The boundary of the image of a patch.
#[derive(Debug)]
pub(super) struct Boundary {
    /// The parameters of its vertices.
    pub(super) places: BTreeMap<u32, [f64; 2]>,
    /// Its length in the metric.
    pub(super) length: f64,
    /// The vertices of the mesh at the corners of a square.
    pub(super) corners: Option<[usize; 4]>,
    /// The sides of the square on which each of its vertices lies, one bit each.
    sides: BTreeMap<u32, u8>,
}

/// The vertices of the image at one vertex of the mesh, along the boundary.
#[derive(Clone, Copy, Debug)]
struct Stop {
    vertex: u32,
    /// The place in the middle, counted along the boundary.
    middle: usize,
    /// Angle by which the boundary turns here in space, positive where the patch is convex.
    turn: f64,
    /// Way in space from the first place of the boundary.
    way: f64,
}

impl Boundary {
    /// The only boundary of a patch, on that of the domain.
    pub(super) fn of(
        mesh: &TriangleMesh,
        image: &MetricMesh,
        vertices: &[u32],
        options: &ParameterOptions,
    ) -> Result<Self, Error> {
        let cycle = only_boundary(image)?;
        let ways = ways(image, &cycle);
        let length = ways.last().copied().unwrap_or(0.0);
        let stops = stops(mesh, image, &cycle, vertices);
        let (corners, first) = match (options.domain, options.corners) {
            (ParameterDomain::Disc, _) => {
                let first = stops.iter().min_by_key(|stop| stop.vertex).map_or(0, |stop| stop.middle);
                (None, vec![first])
            }
            (ParameterDomain::Square, given) => {
                let chosen = match given {
                    Some(given) => given_corners(given, image, &stops)?,
                    None => sharpest(&stops)?,
                };
                let vertex = |k: usize| stops[chosen[k]].vertex as usize;
                (Some([0, 1, 2, 3].map(vertex)), chosen.iter().map(|&k| stops[k].middle).collect())
            }
        };
        let count = cycle.len();
        let mut places = BTreeMap::new();
        let mut sides: BTreeMap<u32, u8> = BTreeMap::new();
        for (side, &from) in first.iter().enumerate() {
            let to = first[(side + 1) % first.len()];
            let steps = if to > from { to - from } else { to + count - from };
            let way = |k: usize| {
                let place = from + k;
                ways[place % count] + if place >= count { length } else { 0.0 } - ways[from]
            };
            let all = way(steps);
            for k in 0..=steps {
                let place = cycle[(from + k) % count];
                let share = way(k) / all;
                *sides.entry(place).or_insert(0) |= 1 << side;
                if k < steps {
                    let at = if options.domain == ParameterDomain::Disc {
                        let (sine, cosine) = (TAU * share).sin_cos();
                        [0.5 + 0.5 * cosine, 0.5 + 0.5 * sine]
                    } else {
                        [[share, 0.0], [1.0, share], [1.0 - share, 1.0], [0.0, 1.0 - share]][side]
                    };
                    places.insert(place, at);
                }
            }
        }
        Ok(Self { places, length, corners, sides })
    }

    /// Inner edges both ends of which lie on one side of the square: the triangles beside them would have no area.
    pub(super) fn flat_edges(&self, image: &MetricMesh) -> BTreeSet<[u32; 2]> {
        let mesh = &image.connectivity;
        let side = |vertex: u32| self.sides.get(&vertex).copied().unwrap_or(0);
        mesh.half_edges()
            .filter(|half_edge| mesh.twin(*half_edge).is_some())
            .map(|half_edge| [mesh.origin(half_edge), mesh.target(half_edge)])
            .filter(|[a, b]| a < b && side(*a) & side(*b) != 0)
            .collect()
    }
}

/// The boundary of a mesh that has the topology of a disc, the surface on its left.
fn only_boundary(image: &MetricMesh) -> Result<Vec<u32>, Error> {
    let mesh = &image.connectivity;
    let loops = mesh.boundary_loops();
    let mut seen = vec![false; mesh.vertex_count()];
    let mut parts = 0;
    for half_edge in mesh.half_edges() {
        let start = mesh.origin(half_edge);
        if std::mem::replace(&mut seen[start as usize], true) {
            continue;
        }
        parts += 1;
        let mut open = vec![start];
        while let Some(vertex) = open.pop() {
            for other in mesh.neighbours(vertex) {
                if !std::mem::replace(&mut seen[other as usize], true) {
                    open.push(other);
                }
            }
        }
    }
    let euler = mesh.euler_characteristic();
    match <[Vec<u32>; 1]>::try_from(loops) {
        Ok([cycle]) if parts == 1 && euler == 1 && image.is_manifold() => Ok(cycle),
        Ok(_) => Err(Error::NotADisc { parts, boundaries: 1, euler, is_manifold: image.is_manifold() }),
        Err(loops) => {
            Err(Error::NotADisc { parts, boundaries: loops.len(), euler, is_manifold: image.is_manifold() })
        }
    }
}

/// The way along a boundary to each of its vertices, and all around.
fn ways(image: &MetricMesh, cycle: &[u32]) -> Vec<f64> {
    let mesh = &image.connectivity;
    let mut next: BTreeMap<u32, f64> = BTreeMap::new();
    for half_edge in mesh.half_edges().filter(|half_edge| mesh.twin(*half_edge).is_none()) {
        next.insert(mesh.origin(half_edge), image.length(half_edge));
    }
    let mut way = 0.0;
    let mut ways = vec![0.0];
    for vertex in cycle {
        way += next.get(vertex).copied().unwrap_or(0.0);
        ways.push(way);
    }
    ways
}

/// The vertices of the mesh along a boundary of its image.
fn stops(mesh: &TriangleMesh, image: &MetricMesh, cycle: &[u32], vertices: &[u32]) -> Vec<Stop> {
    let points = mesh.vertices();
    let mut angles: BTreeMap<u32, f64> = BTreeMap::new();
    for (triangle, places) in mesh.triangles().iter().zip(&image.corners).filter(|(_, p)| p[0] != NONE) {
        for k in 0..3 {
            let [x, y, z] = [0, 1, 2].map(|i| points[triangle[(k + i) % 3] as usize]);
            let (one, other) = (y - x, z - x);
            *angles.entry(vertices[places[k] as usize]).or_insert(0.0) +=
                one.cross(&other).norm().atan2(one.dot(&other));
        }
    }
    let count = cycle.len();
    let vertex = |k: usize| vertices[cycle[k % count] as usize];
    // From where one vertex of the mesh ends, so that none is divided.
    let start = (0..count).find(|&k| vertex(k) != vertex(k + count - 1)).unwrap_or(0);
    let mut found: Vec<Stop> = Vec::new();
    let mut way = 0.0;
    let mut k = start;
    while k < start + count {
        let own = vertex(k);
        let mut end = k + 1;
        while end < start + count && vertex(end) == own {
            end += 1;
        }
        if own != NONE {
            let turn = PI - angles.get(&own).copied().unwrap_or(PI);
            found.push(Stop { vertex: own, middle: (k + (end - k) / 2) % count, turn, way });
        }
        for place in k..end {
            let [a, b] = [place, place + 1].map(|p| image.points[cycle[p % count] as usize]);
            way += (b - a).norm();
        }
        k = end;
    }
    found
}

/// The stops of given vertices, from the first one on along the boundary.
fn given_corners(given: [usize; 4], image: &MetricMesh, stops: &[Stop]) -> Result<Vec<usize>, Error> {
    let mut chosen = Vec::with_capacity(4);
    for vertex in given {
        // Vertices at one place are one corner.
        let places = image.of_vertex.get(vertex);
        let is_same = |stop: &Stop| places.is_some() && image.of_vertex.get(stop.vertex as usize) == places;
        let found = stops.iter().position(is_same).filter(|place| !chosen.contains(place));
        chosen.push(found.ok_or(Error::Corners { boundary: stops.len(), vertex: Some(vertex) })?);
    }
    let first = chosen[0];
    chosen.sort_unstable();
    let place = chosen.iter().position(|&k| k == first).unwrap_or(0);
    chosen.rotate_left(place);
    Ok(chosen)
}

/// The four sharpest corners; where there are fewer, others halve the longest ways between them.
fn sharpest(stops: &[Stop]) -> Result<Vec<usize>, Error> {
    if stops.len() < 4 {
        return Err(Error::Corners { boundary: stops.len(), vertex: None });
    }
    let mut order: Vec<usize> = (0..stops.len()).filter(|&k| stops[k].turn >= CORNER).collect();
    order.sort_by(|&a, &b| {
        stops[b].turn.total_cmp(&stops[a].turn).then(stops[a].vertex.cmp(&stops[b].vertex))
    });
    order.truncate(4);
    if order.is_empty() {
        order.extend((0..stops.len()).min_by_key(|&k| stops[k].vertex));
    }
    let count = stops.len();
    let all = stops.last().map_or(0.0, |last| last.way) - stops.first().map_or(0.0, |first| first.way);
    let around = all * count as f64 / (count - 1) as f64;
    while order.len() < 4 {
        order.sort_unstable();
        // The longest run with a vertex inside.
        let runs = (0..order.len()).filter_map(|k| {
            let (from, to) = (order[k], order[(k + 1) % order.len()]);
            let steps = if to > from { to - from } else { to + count - from };
            let way = |place: usize| stops[place % count].way + if place >= count { around } else { 0.0 };
            let (low, high) = (way(from), way(from + steps));
            let middle = 0.5 * (low + high);
            let inner = (from + 1..from + steps)
                .min_by(|&a, &b| (way(a) - middle).abs().total_cmp(&(way(b) - middle).abs()))?;
            Some((high - low, inner % count))
        });
        let longest = runs.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((_, inner)) = longest else {
            return Err(Error::Corners { boundary: stops.len(), vertex: None });
        };
        order.push(inner);
    }
    order.sort_unstable();
    let first = (0..4).min_by_key(|&k| stops[order[k]].vertex).unwrap_or(0);
    order.rotate_left(first);
    Ok(order)
}
