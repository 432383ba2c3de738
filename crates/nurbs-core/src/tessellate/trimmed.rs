//! Pieces of surfaces to triangles.

use super::grid::grid_lines;
use super::{Tessellation, TessellationOptions};
use crate::{BsplineSurface, Error, ParametricSurface, TrimLoops};
use nalgebra::Vector3;
use std::collections::HashMap;

/// Cells in each direction, at least, of the box around the loops.
const CELLS: f64 = 200.0;
/// Share of an edge of the grid by which a loop that crosses it keeps away from its ends.
const AWAY: f64 = 1e-9;

impl BsplineSurface {
    /// Triangles on the piece of the surface that loops in its parameters bound, as [`tessellate`](Self::tessellate).
    ///
    /// The grid has 200 cells in each direction of the box around the loops, at least. Vertices on the outline are where the loops cross its lines and
    /// diagonals, so that it cuts corners of the loops by less than a cell. Seams are not closed, and the normals at poles are zero.
    ///
    /// # Errors
    /// [`Error::Argument`] when the tolerance is not positive or takes more vertices than allowed, or when the loops bound less than a cell.
    pub fn tessellate_trimmed(
        &self,
        trim: &TrimLoops,
        options: &TessellationOptions,
    ) -> Result<Tessellation, Error> {
        options.check()?;
        let lines = grid_lines(self, options)?;
        let lines = [0, 1].map(|d| refined(&lines[d], bounds(trim, d)));
        if lines[0].len() as f64 * lines[1].len() as f64 > options.max_vertices as f64 {
            return Err(options.too_many());
        }
        let inside = trim.contains_grid(&lines[0], &lines[1]);
        let out = Tessellation {
            vertices: Vec::new(),
            normals: Vec::new(),
            parameters: Vec::new(),
            triangles: Vec::new(),
        };
        let count = inside.len();
        let mut piece =
            Piece { surface: self, trim, lines, inside, own: vec![None; count], cut: HashMap::new(), out };
        piece.build();
        if piece.out.triangles.is_empty() {
            return Err(Error::argument("the trimming loops bound less than a cell of the tessellation"));
        }
        Ok(piece.out)
    }
}

/// Smallest and largest parameter of the loops in a direction.
fn bounds(trim: &TrimLoops, d: usize) -> [f64; 2] {
    let all = trim.loops().iter().flatten().map(|vertex| vertex[d]);
    all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// The lines about an interval, closer than a share of it.
fn refined(lines: &[f64], [low, high]: [f64; 2]) -> Vec<f64> {
    let step = (high - low) / CELLS;
    let mut out = Vec::new();
    for pair in lines.windows(2) {
        let (from, to) = (pair[0].max(low - step), pair[1].min(high + step));
        if from >= to {
            continue;
        }
        if out.last() != Some(&from) {
            out.push(from);
        }
        let parts = ((to - from) / step).ceil().max(1.0);
        let mut k = 1.0;
        while k <= parts {
            out.push(if k == parts { to } else { from + (to - from) * (k / parts) });
            k += 1.0;
        }
    }
    out
}

struct Piece<'a> {
    surface: &'a BsplineSurface,
    trim: &'a TrimLoops,
    lines: [Vec<f64>; 2],
    inside: Vec<bool>,
    /// Vertices at places of the grid, and on its edges.
    own: Vec<Option<u32>>,
    cut: HashMap<[usize; 2], u32>,
    out: Tessellation,
}

impl Piece<'_> {
    fn build(&mut self) {
        let (rows, columns) = (self.lines[0].len(), self.lines[1].len());
        for i in 0..rows.saturating_sub(1) {
            for j in 0..columns.saturating_sub(1) {
                let a = i * columns + j;
                let (b, c, d) = (a + columns, a + columns + 1, a + 1);
                if ![a, b, c, d].iter().any(|&k| self.inside[k]) {
                    continue;
                }
                self.triangle([a, b, c]);
                self.triangle([a, c, d]);
            }
        }
    }

    /// What of a triangle of the grid is inside.
    fn triangle(&mut self, corners: [usize; 3]) {
        let inside = corners.map(|k| self.inside[k]);
        match inside.iter().filter(|x| **x).count() {
            3 => {
                let made = corners.map(|k| self.vertex(k));
                self.out.triangles.push(made);
            }
            1 => {
                let first = inside.iter().position(|x| *x).unwrap_or(0);
                let [a, b, c] = [0, 1, 2].map(|k| corners[(first + k) % 3]);
                let made = [self.vertex(a), self.crossing(a, b), self.crossing(a, c)];
                self.out.triangles.push(made);
            }
            2 => {
                let last = inside.iter().position(|x| !*x).unwrap_or(0);
                let [c, a, b] = [0, 1, 2].map(|k| corners[(last + k) % 3]);
                let (va, vb) = (self.vertex(a), self.vertex(b));
                let (bc, ca) = (self.crossing(b, c), self.crossing(a, c));
                self.out.triangles.push([va, vb, bc]);
                self.out.triangles.push([va, bc, ca]);
            }
            _ => {}
        }
    }

    fn place(&self, k: usize) -> [f64; 2] {
        let columns = self.lines[1].len();
        [self.lines[0][k / columns], self.lines[1][k % columns]]
    }

    fn vertex(&mut self, k: usize) -> u32 {
        if let Some(known) = self.own[k] {
            return known;
        }
        let made = self.add(self.place(k));
        self.own[k] = Some(made);
        made
    }

    /// The vertex where the loops cross an edge of the grid from inside to outside.
    fn crossing(&mut self, inner: usize, outer: usize) -> u32 {
        let key = [inner.min(outer), inner.max(outer)];
        if let Some(&known) = self.cut.get(&key) {
            return known;
        }
        let [a, b] = key.map(|k| self.place(k));
        let mut shares: Vec<f64> = self
            .trim
            .loops()
            .iter()
            .flat_map(|vertices| vertices.iter().zip(vertices.iter().cycle().skip(1)))
            .filter_map(|(p, q)| share(a, b, *p, *q))
            .collect();
        shares.sort_unstable_by(f64::total_cmp);
        let at = shares.get(shares.len() / 2).copied().unwrap_or(0.5).clamp(AWAY, 1.0 - AWAY);
        let made = self.add([a[0] + (b[0] - a[0]) * at, a[1] + (b[1] - a[1]) * at]);
        self.cut.insert(key, made);
        made
    }

    fn add(&mut self, [u, v]: [f64; 2]) -> u32 {
        let jet = self.surface.jet(u, v);
        // The number of vertices is limited far below what is left out here.
        let number = u32::try_from(self.out.vertices.len()).unwrap_or(u32::MAX);
        self.out.vertices.push(jet.point);
        self.out.normals.push(jet.unit_normal().unwrap_or_else(Vector3::zeros));
        self.out.parameters.push([u, v]);
        number
    }
}

/// The share of the segment from `a` to `b` at which that from `p` to `q` crosses it.
fn share(a: [f64; 2], b: [f64; 2], p: [f64; 2], q: [f64; 2]) -> Option<f64> {
    let (along, other, between) =
        ([b[0] - a[0], b[1] - a[1]], [q[0] - p[0], q[1] - p[1]], [p[0] - a[0], p[1] - a[1]]);
    let perp = |x: [f64; 2], y: [f64; 2]| x[0] * y[1] - x[1] * y[0];
    let determinant = perp(along, other);
    let (s, t) = (perp(between, other) / determinant, perp(between, along) / determinant);
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then_some(s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::KnotVector;

    #[test]
    fn a_disc_with_a_hole_has_its_area_and_two_boundaries() {
        let knots = KnotVector::uniform_clamped(1, 2).unwrap();
        let net = [[0., 0.], [0., 2.], [2., 0.], [2., 2.]].map(|[x, y]| Vector3::new(x, y, 0.5 * x)).to_vec();
        let surface = BsplineSurface::new(knots.clone(), knots, net, None).unwrap();
        let ring = |r: f64| {
            let at = |k: u32| std::f64::consts::TAU * f64::from(k) / 90.0;
            (0..90).map(|k| [0.5 + r * at(k).cos(), 0.5 + r * at(k).sin()]).collect::<Vec<_>>()
        };
        let trim = TrimLoops::new(vec![ring(0.45), ring(0.2)]).unwrap();
        let found = surface.tessellate_trimmed(&trim, &TessellationOptions::new(0.01)).unwrap();
        let area: f64 = found
            .triangles
            .iter()
            .map(|t| t.map(|k| found.vertices[k as usize]))
            .map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm())
            .sum();
        let expected = 4.0 * 1.25f64.sqrt() * trim.area();
        assert!((area - expected).abs() < 1e-3 * expected, "{area} {expected}");
        // Every edge belongs to two triangles, or to one on one of the outlines.
        let mut edges: HashMap<[u32; 2], usize> = HashMap::new();
        for t in &found.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        let radius = |k: u32| {
            let [u, v] = found.parameters[k as usize];
            (u - 0.5).hypot(v - 0.5)
        };
        for (edge, count) in edges {
            let on = |k: u32| (radius(k) - 0.45).abs().min((radius(k) - 0.2).abs()) < 2e-3;
            assert!(count == 2 || count == 1 && edge.iter().all(|k| on(*k)), "{edge:?} {count}");
        }
        // A loop that is smaller than a cell of the whole surface has cells of its own.
        let small = TrimLoops::new(vec![ring(1e-5)]).unwrap();
        assert!(surface.tessellate_trimmed(&small, &TessellationOptions::new(0.01)).is_ok());
    }
}
