//! Surfaces to triangles.

use super::TessellationOptions;
use super::grid::grid_lines;
use crate::{BsplineSurface, Error, ParametricSurface};
use nalgebra::Vector3;

/// Part of the size within which grid points on seams and at poles count as one.
const SAME: f64 = 1e-12;

/// Triangles on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Tessellation {
    /// Vertices, points of the surface.
    pub vertices: Vec<Vector3<f64>>,
    /// Unit normals of the surface; where it has none (poles) the mean of the triangles around, and zero
    /// when these vanish too.
    pub normals: Vec<Vector3<f64>>,
    /// Parameters `(u, v)` of the vertices. A shared vertex has those of its first occurrence: at a seam
    /// the start of the domain.
    pub parameters: Vec<[f64; 2]>,
    /// Indices of the corners, counter-clockwise seen from the side of the normal.
    pub triangles: Vec<[u32; 3]>,
}

impl BsplineSurface {
    /// Triangles with vertices on the surface that are within the tolerance of it.
    ///
    /// The vertices form a grid whose lines are spaced so that a bound on the second derivatives of each
    /// patch keeps the distance below the tolerance (\[FMM86\]); so there are no cracks. At poles and
    /// collapsed edges there is one vertex and no degenerate triangle.
    ///
    /// # Errors
    /// [`Error::Argument`] when the tolerance is not positive or takes more vertices than allowed.
    pub fn tessellate(&self, options: &TessellationOptions) -> Result<Tessellation, Error> {
        options.check()?;
        let lines = grid_lines(self, options)?;
        let grid = Grid::new(self, lines);
        grid.build(options)
    }
}

struct Grid {
    lines: [Vec<f64>; 2],
    points: Vec<Vector3<f64>>,
    normals: Vec<Option<Vector3<f64>>>,
    /// Whether the grid closes in `u` and in `v`.
    closed: [bool; 2],
    /// Whether the edges `u` first, `u` last, `v` first, `v` last are single points.
    collapsed: [bool; 4],
}

impl Grid {
    fn new(surface: &BsplineSurface, lines: [Vec<f64>; 2]) -> Self {
        let (n, m) = (lines[0].len(), lines[1].len());
        let mut points = Vec::with_capacity(n * m);
        let mut normals = Vec::with_capacity(n * m);
        for &u in &lines[0] {
            for &v in &lines[1] {
                let jet = surface.jet(u, v);
                points.push(jet.point);
                normals.push(jet.unit_normal());
            }
        }
        let hull = surface.control_box();
        let near = SAME * (hull.diagonal() + hull.centre().amax() * f64::EPSILON / SAME);
        let same = |a: usize, b: usize| (points[a] - points[b]).norm() <= near;
        let closed = [(0..m).all(|j| same(j, (n - 1) * m + j)), (0..n).all(|i| same(i * m, i * m + m - 1))];
        let collapsed = [
            (0..m).all(|j| same(0, j)),
            (0..m).all(|j| same((n - 1) * m, (n - 1) * m + j)),
            (0..n).all(|i| same(0, i * m)),
            (0..n).all(|i| same(m - 1, i * m + m - 1)),
        ];
        Self { lines, points, normals, closed, collapsed }
    }

    /// The first grid point at the same place as `(i, j)`.
    fn canonical(&self, i: usize, j: usize) -> usize {
        let (n, m) = (self.lines[0].len(), self.lines[1].len());
        let (mut i, mut j) = (i, j);
        if self.closed[0] && i == n - 1 {
            i = 0;
        }
        if self.closed[1] && j == m - 1 {
            j = 0;
        }
        if (self.collapsed[2] && j == 0) || (self.collapsed[3] && j == m - 1) {
            i = 0;
        }
        if (self.collapsed[0] && i == 0) || (self.collapsed[1] && i == n - 1) {
            j = 0;
        }
        i * m + j
    }

    fn build(&self, options: &TessellationOptions) -> Result<Tessellation, Error> {
        let (n, m) = (self.lines[0].len(), self.lines[1].len());
        let places: Vec<usize> = (0..n * m).map(|k| self.canonical(k / m, k % m)).collect();
        // Grid point → vertex.
        let mut index = vec![0_u32; n * m];
        let mut out = Tessellation {
            vertices: Vec::new(),
            normals: Vec::new(),
            parameters: Vec::new(),
            triangles: Vec::with_capacity(2 * n * m),
        };
        let mut missing = Vec::new();
        for k in 0..n * m {
            if options.weld && places[k] < k {
                index[k] = index[places[k]];
                continue;
            }
            index[k] = u32::try_from(out.vertices.len()).map_err(|_| options.too_many())?;
            out.vertices.push(self.points[places[k]]);
            out.parameters.push([self.lines[0][k / m], self.lines[1][k % m]]);
            match self.normals[k] {
                Some(normal) => out.normals.push(normal),
                None => {
                    missing.push(places[k]);
                    out.normals.push(Vector3::zeros());
                }
            }
        }
        let mut around = vec![Vector3::zeros(); if missing.is_empty() { 0 } else { n * m }];
        for i in 0..n - 1 {
            for j in 0..m - 1 {
                for corners in self.cell(i, j) {
                    let [a, b, c] = corners.map(|k| places[k]);
                    if a == b || b == c || c == a {
                        continue;
                    }
                    out.triangles.push(corners.map(|k| index[k]));
                    if !around.is_empty() {
                        let [p, q, r] = [a, b, c].map(|k| self.points[k]);
                        let normal = (q - p).cross(&(r - p));
                        [a, b, c].into_iter().for_each(|k| around[k] += normal);
                    }
                }
            }
        }
        for k in (0..n * m).filter(|&k| self.normals[k].is_none() && !missing.is_empty()) {
            let place = places[k];
            if !options.weld || place == k {
                out.normals[index[k] as usize] = around[place].try_normalize(0.0).unwrap_or_default();
            }
        }
        Ok(out)
    }

    /// The two triangles of a cell, cut along the shorter diagonal.
    fn cell(&self, i: usize, j: usize) -> [[usize; 3]; 2] {
        let m = self.lines[1].len();
        let [a, b, c, d] = [i * m + j, (i + 1) * m + j, (i + 1) * m + j + 1, i * m + j + 1];
        let length = |k: usize, l: usize| (self.points[k] - self.points[l]).norm_squared();
        if length(a, c) <= length(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    }
}
