//! From the signs at the nodes to triangles.

use super::vertex::vertex;
use crate::contour::empty;
use crate::measure::larger;
use crate::{Error, parallel};
use distance_field::{DistanceField, Grid, LevelSetField, Search};
use mesh_core::{MeshProjector, TriangleMesh};
use nalgebra::{Point3, Vector3};

/// Steps of the search for a zero on an edge.
const STEPS: usize = 50;
/// Nodes in a row along the three axes from the first corner of a cell: corner `c` is at `(c >> 2, c >> 1 & 1, c & 1)`.
const CORNERS: usize = 8;

/// A point of the level set on an edge of the grid, with the unit normal there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The point.
    pub point: Vector3<f64>,
    /// The normal, towards positive values.
    pub normal: Vector3<f64>,
}

/// Crossings from the cubic spline through the values of a level set, to be used with [`dual_contour`]. Edges sharper than a cell are
/// rounded by the spline; a source that knows them gives better ones.
pub fn of_field(field: &LevelSetField<3>) -> impl Fn(&Vector3<f64>, &Vector3<f64>) -> Crossing + Sync + '_ {
    move |a, b| {
        let point = zero_between(a, b, |x| field.value(x));
        let (_, gradient, _) = field.taylor(&point);
        Crossing { point, normal: gradient.normalize() }
    }
}

/// A zero on the way between two points of different sign.
pub(crate) fn zero_between(
    a: &Vector3<f64>,
    b: &Vector3<f64>,
    value: impl Fn(&Vector3<f64>) -> f64,
) -> Vector3<f64> {
    let (mut low, mut high) = (0.0, 1.0);
    let (mut at_low, mut at_high) = (value(a), value(b));
    for step in 0..STEPS {
        let secant = low - at_low * (high - low) / (at_high - at_low);
        let middle = 0.5 * (low + high);
        let s = if step % 3 == 2 || !(low < secant && secant < high) { middle } else { secant };
        let f = value(&a.lerp(b, s));
        if f == 0.0 || high - low < 1e-15 {
            return a.lerp(b, s);
        }
        if (f < 0.0) == (at_low < 0.0) { (low, at_low) = (s, f) } else { (high, at_high) = (s, f) }
    }
    a.lerp(b, if at_low.abs() < at_high.abs() { low } else { high })
}

/// The edges of a cell: first corner and axis.
const EDGES: [(usize, usize); 12] =
    [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1), (4, 1), (5, 1), (0, 2), (2, 2), (4, 2), (6, 2)];

/// How far apart two corners along an axis are numbered.
const fn corner_step(axis: usize) -> usize {
    4 >> axis
}

/// For each edge of a cell the sheet to which it belongs, and the number of sheets; edges without a change of sign belong to none.
fn sheets(negative: [bool; CORNERS]) -> ([u8; 12], u8) {
    const NONE: u8 = u8::MAX;
    let crosses = |edge: usize| {
        let (corner, axis) = EDGES[edge];
        negative[corner] != negative[corner + corner_step(axis)]
    };
    let mut parent: [usize; 12] = std::array::from_fn(|edge| edge);
    let root = |parent: &[usize; 12], mut edge: usize| {
        while parent[edge] != edge {
            edge = parent[edge];
        }
        edge
    };
    let edge_at = |corner: usize, axis: usize| EDGES.iter().position(|edge| *edge == (corner, axis));
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, corner_step(axis)] {
            let corners =
                [side, side + corner_step(u), side + corner_step(u) + corner_step(v), side + corner_step(v)];
            // The edge after each of these corners, around the face.
            let around = [
                edge_at(corners[0], u),
                edge_at(corners[1], v),
                edge_at(corners[3], u),
                edge_at(corners[0], v),
            ];
            let around = around.map(|edge| edge.unwrap_or(0));
            let crossing: Vec<usize> = (0..4).filter(|&k| crosses(around[k])).collect();
            let mut join = |a: usize, b: usize| {
                let (a, b) = (root(&parent, a), root(&parent, b));
                parent[a.max(b)] = a.min(b);
            };
            match crossing.as_slice() {
                [a, b] => join(around[*a], around[*b]),
                [_, _, _, _] => {
                    // Negative corners are apart: each has a sheet of its own between its two edges.
                    for k in (0..4).filter(|&k| negative[corners[k]]) {
                        join(around[k], around[(k + 3) % 4]);
                    }
                }
                _ => {}
            }
        }
    }
    let mut out = [NONE; 12];
    let mut count = 0;
    for edge in 0..12 {
        if crosses(edge) {
            let first = root(&parent, edge);
            if first == edge {
                out[edge] = count;
                count += 1;
            } else {
                out[edge] = out[first];
            }
        }
    }
    (out, count)
}

/// The vertices of a cell.
struct Cell {
    first: u32,
    sheets: [u8; 12],
}

/// Triangulates the zero set of a level function: the inside is where values are negative, normals point to the outside.
///
/// `crossing` is asked for the point and the normal on each edge between nodes of different sign, see [`of_field`]. The mesh is closed but
/// where the level set leaves the grid. Runs in parallel; the result does not depend on the number of threads.
///
/// # Errors
/// [`Error::Empty`] where the values do not change their sign, [`Error::Mesh`] beyond 32-bit indices.
pub fn dual_contour(
    grid: &Grid<3>,
    crossing: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Crossing + Sync,
) -> Result<TriangleMesh, Error> {
    let [n0, n1, n2] = grid.counts();
    let strides = [n1 * n2, n2, 1];
    let values = grid.values();
    let is_negative = |node: usize| values[node] < 0.0;
    // The edges with a change of sign, and where the level set crosses them.
    let fits = |node: usize, axis: usize| {
        let at = [node / strides[0], node / strides[1] % n1, node % n2];
        at[axis] + 1 < [n0, n1, n2][axis]
    };
    let edges: Vec<(usize, usize)> = (0..values.len())
        .flat_map(|node| (0..3).map(move |axis| (node, axis)))
        .filter(|&(node, axis)| fits(node, axis) && is_negative(node) != is_negative(node + strides[axis]))
        .collect();
    if edges.is_empty() {
        return Err(empty(values));
    }
    let crossings = parallel::map(edges.len(), |k| {
        let (node, axis) = edges[k];
        crossing(&grid.position(node), &grid.position(node + strides[axis]))
    });
    let crossing_at =
        |node: usize, axis: usize| edges.binary_search(&(node, axis)).ok().map(|place| crossings[place]);
    // Cells by their first node, each with its vertices.
    let offset = |corner: usize| (corner >> 2) * strides[0] + (corner >> 1 & 1) * strides[1] + (corner & 1);
    let mut cells = std::collections::BTreeMap::new();
    let mut vertices: Vec<Point3<f64>> = Vec::new();
    for node in 0..values.len() {
        if !(0..3).all(|axis| fits(node, axis)) {
            continue;
        }
        let negative: [bool; CORNERS] = std::array::from_fn(|corner| is_negative(node + offset(corner)));
        if negative.iter().all(|n| *n == negative[0]) {
            continue;
        }
        let (sheets, count) = sheets(negative);
        let (low, high) = (grid.position(node), grid.position(node + offset(7)));
        let too_many = |_| Error::Mesh(mesh_core::Error::TooMany { what: "vertices", count: vertices.len() });
        let first = u32::try_from(vertices.len()).map_err(too_many)?;
        for sheet in 0..count {
            let own: Vec<Crossing> = (0..12)
                .filter(|&edge| sheets[edge] == sheet)
                .filter_map(|edge| {
                    let (corner, axis) = EDGES[edge];
                    crossing_at(node + offset(corner), axis)
                })
                .collect();
            vertices.push(vertex(&own, &low, &high).into());
        }
        cells.insert(node, Cell { first, sheets });
    }
    let mut triangles = Vec::with_capacity(2 * edges.len());
    for &(node, axis) in &edges {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let at = [node / strides[0], node / strides[1] % n1, node % n2];
        if at[u] == 0 || at[v] == 0 {
            continue;
        }
        // The cells around the edge, counter-clockwise as seen from its end.
        let steps = [[1, 1], [0, 1], [0, 0], [1, 0]];
        let around: Option<Vec<u32>> = steps
            .iter()
            .map(|&[su, sv]| {
                let cell = cells.get(&(node - su * strides[u] - sv * strides[v]))?;
                let corner = su * corner_step(u) + sv * corner_step(v);
                let edge = EDGES.iter().position(|edge| *edge == (corner, axis))?;
                Some(cell.first + u32::from(cell.sheets[edge]))
            })
            .collect();
        let Some(mut quad) = around else { continue };
        if !is_negative(node) {
            quad.reverse();
        }
        let length = |i: usize, j: usize| (vertices[quad[i] as usize] - vertices[quad[j] as usize]).norm();
        let [a, b, c, d] = [quad[0], quad[1], quad[2], quad[3]];
        if length(0, 2) <= length(1, 3) {
            triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            triangles.extend([[b, c, d], [b, d, a]]);
        }
    }
    Ok(TriangleMesh::new(vertices, triangles)?)
}

/// How far a mesh and a level set are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceGap {
    /// Largest distance of vertices, middles of edges and middles of triangles of the mesh from the level set.
    pub forth: f64,
    /// Largest distance of the crossings of the level set with edges of the grid from the mesh.
    pub back: f64,
}

/// Measures a mesh against the level set from both sides. Crossings in the outermost cells do not count: the mesh ends in the middle of
/// these.
///
/// # Errors
/// [`Error::Mesh`] for a mesh without area.
pub fn surface_gap(field: &LevelSetField<3>, mesh: &TriangleMesh) -> Result<SurfaceGap, Error> {
    let corner = |k: u32| mesh.vertices()[k as usize].coords;
    let samples = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(corner);
        [a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0]
    };
    let points: Vec<Vector3<f64>> = mesh.triangles().iter().flat_map(samples).collect();
    let frames = field.frames(&points, Search::Global, &[]);
    let far = frames.iter().zip(&points).map(|(frame, x)| (frame.foot - x).norm());
    let forth = far.fold(0.0, larger);
    let grid = field.grid();
    let low = grid.origin() + grid.spacing();
    let last = grid.values().len() - 1;
    let high = grid.position(last) - grid.spacing();
    let within = |x: &Vector3<f64>| (0..3).all(|k| low[k] <= x[k] && x[k] <= high[k]);
    let crossings: Vec<Point3<f64>> = field.crossings().filter(within).map(Point3::from).collect();
    let projector = MeshProjector::new(mesh)?;
    let mut back = 0.0f64;
    for found in projector.project_many(&crossings) {
        back = larger(back, found?.distance);
    }
    Ok(SurfaceGap { forth, back })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sheets of all 256 cells: each crossing belongs to one, and faces that two cells share are cut in the same way, so that the
    /// edges of a face in one sheet come in pairs.
    #[test]
    fn every_cell_has_its_sheets() {
        for bits in 0..256usize {
            let negative: [bool; 8] = std::array::from_fn(|corner| bits >> corner & 1 == 1);
            let (found, count) = sheets(negative);
            let crossing =
                EDGES.iter().filter(|(c, axis)| negative[*c] != negative[c + corner_step(*axis)]).count();
            assert_eq!(found.iter().filter(|sheet| **sheet != u8::MAX).count(), crossing);
            for sheet in 0..count {
                assert!(found.iter().filter(|found| **found == sheet).count() >= 3, "{bits}");
            }
            // Opposite signs have the same crossings.
            assert_eq!(count == 0, bits == 0 || bits == 255);
        }
        // Two corners across the cell are apart.
        assert_eq!(sheets(std::array::from_fn(|corner| corner == 0 || corner == 7)).1, 2);
        assert_eq!(sheets(std::array::from_fn(|corner| corner == 0 || corner == 3)).1, 2);
    }
}
