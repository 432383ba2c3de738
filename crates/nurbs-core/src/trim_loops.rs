//! Loops in the parameters of a surface, which bound a piece of it.

use crate::{BsplineSurface, Error, ParametricSurface};

/// Share of the domain by which vertices may lie beyond it: rounding.
const ROUNDING: f64 = 1e-9;

/// Closed polygons in the parameters `(u, v)` of a surface: what lies inside an odd number of them belongs to the piece.
///
/// Each loop is the list of its vertices, the last one joined with the first. No loop crosses itself or another one; that is the business of
/// those who make them.
///
/// ```
/// use nurbs_core::TrimLoops;
///
/// let square = |a: f64, b: f64| vec![[a, a], [b, a], [b, b], [a, b]];
/// let frame = TrimLoops::new(vec![square(0.0, 1.0), square(0.4, 0.6)])?;
/// assert!(frame.contains(0.1, 0.5) && !frame.contains(0.5, 0.5));
/// assert!((frame.area() - 0.96).abs() < 1e-15);
/// # Ok::<(), nurbs_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TrimLoops {
    loops: Vec<Vec<[f64; 2]>>,
}

impl TrimLoops {
    /// From the vertices of each loop.
    ///
    /// # Errors
    /// [`Error::Argument`] without a loop, and for loops of fewer than three vertices, with a number that is not finite, or without area.
    pub fn new(loops: Vec<Vec<[f64; 2]>>) -> Result<Self, Error> {
        if loops.is_empty() {
            return Err(Error::argument(
                "there is no trimming loop; leave them out where the surface is whole",
            ));
        }
        for (index, vertices) in loops.iter().enumerate() {
            if vertices.len() < 3 {
                let what =
                    format!("trimming loop {index} has {} vertices; it needs at least 3", vertices.len());
                return Err(Error::argument(what));
            }
            if let Some(k) = vertices.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
                return Err(Error::argument(format!("vertex {k} of trimming loop {index} is not finite")));
            }
            let area = signed_area(vertices);
            if area == 0.0 || !area.is_finite() {
                return Err(Error::argument(format!("trimming loop {index} encloses no area")));
            }
        }
        Ok(Self { loops })
    }

    /// The same, if all vertices lie in the domain of a surface, but for rounding.
    ///
    /// # Errors
    /// [`Error::Argument`] for a vertex that does not.
    pub fn within(self, surface: &BsplineSurface) -> Result<Self, Error> {
        let domain = surface.domain();
        for (index, vertices) in self.loops.iter().enumerate() {
            for (k, vertex) in vertices.iter().enumerate() {
                for d in 0..2 {
                    let slack = ROUNDING * domain[d].length();
                    if vertex[d] < domain[d].start() - slack || vertex[d] > domain[d].end() + slack {
                        let what = format!(
                            "vertex {k} of trimming loop {index} is at {} = {}, beyond the domain [{}, {}]",
                            ["u", "v"][d],
                            vertex[d],
                            domain[d].start(),
                            domain[d].end()
                        );
                        return Err(Error::argument(what));
                    }
                }
            }
        }
        Ok(self)
    }

    /// The vertices of each loop.
    #[must_use]
    pub fn loops(&self) -> &[Vec<[f64; 2]>] {
        &self.loops
    }

    /// Whether a place belongs to the piece; either answer on a loop itself.
    #[must_use]
    pub fn contains(&self, u: f64, v: f64) -> bool {
        self.crossings(v).iter().filter(|x| **x > u).count() % 2 == 1
    }

    /// [`contains`](Self::contains) at all places of a grid; `v` runs faster.
    #[must_use]
    pub fn contains_grid(&self, us: &[f64], vs: &[f64]) -> Vec<bool> {
        let mut out = vec![false; us.len() * vs.len()];
        for (j, &v) in vs.iter().enumerate() {
            let crossings = self.crossings(v);
            for (i, &u) in us.iter().enumerate() {
                let beyond = crossings.len() - crossings.partition_point(|x| *x <= u);
                out[i * vs.len() + j] = beyond % 2 == 1;
            }
        }
        out
    }

    /// Area of the piece in the parameter plane: loops that lie in others count as holes.
    #[must_use]
    pub fn area(&self) -> f64 {
        let own = |k: usize| {
            let [u, v] = self.loops[k][0];
            let others = self.loops.iter().enumerate().filter(|(j, _)| *j != k);
            let around = others.filter(|(_, other)| is_inside(other, u, v)).count();
            let area = signed_area(&self.loops[k]).abs();
            if around % 2 == 0 { area } else { -area }
        };
        (0..self.loops.len()).map(own).sum()
    }

    /// Parameters `u` at which the loops cross a line of constant `v`, increasing.
    fn crossings(&self, v: f64) -> Vec<f64> {
        let mut found: Vec<f64> = self.loops.iter().flat_map(|vertices| crossings_of(vertices, v)).collect();
        found.sort_unstable_by(f64::total_cmp);
        found
    }
}

fn crossings_of(vertices: &[[f64; 2]], v: f64) -> impl Iterator<Item = f64> {
    let edges = vertices.iter().zip(vertices.iter().cycle().skip(1));
    edges
        .filter(move |(a, b)| (a[1] > v) != (b[1] > v))
        .map(move |(a, b)| a[0] + (v - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
}

fn is_inside(vertices: &[[f64; 2]], u: f64, v: f64) -> bool {
    crossings_of(vertices, v).filter(|x| *x > u).count() % 2 == 1
}

/// Area of a polygon, positive if it is counter-clockwise.
fn signed_area(vertices: &[[f64; 2]]) -> f64 {
    let [u, v] = vertices[0];
    let edges = vertices.iter().zip(vertices.iter().cycle().skip(1));
    0.5 * edges.map(|(a, b)| (a[0] - u) * (b[1] - v) - (b[0] - u) * (a[1] - v)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::KnotVector;
    use nalgebra::Vector3;

    fn square(a: f64, b: f64) -> Vec<[f64; 2]> {
        vec![[a, a], [b, a], [b, b], [a, b]]
    }

    #[test]
    fn grids_and_single_places_agree() {
        let star: Vec<[f64; 2]> = (0..10)
            .map(|k| (f64::from(k) * std::f64::consts::PI / 5.0, if k % 2 == 0 { 1.0 } else { 0.4 }))
            .map(|(a, r)| [r * a.cos(), r * a.sin()])
            .collect();
        let trim = TrimLoops::new(vec![star, square(-0.1, 0.2)]).unwrap();
        let at: Vec<f64> = (0..41).map(|k| -1.013 + 0.05 * f64::from(k)).collect();
        let grid = trim.contains_grid(&at, &at);
        let inside = (0..41 * 41).filter(|k| grid[*k]).count();
        assert!((0..41 * 41).all(|k| grid[k] == trim.contains(at[k / 41], at[k % 41])));
        // Ten triangles of the star without the square.
        let area = 10.0 * 0.5 * 0.4 * (std::f64::consts::PI / 5.0).sin() - 0.09;
        assert!((trim.area() - area).abs() < 1e-12 && (inside as f64 * 0.0025 - area).abs() < 0.1);
    }

    #[test]
    fn what_bounds_nothing_is_refused() {
        let nan = vec![[0.0, 0.0], [1.0, f64::NAN], [1.0, 1.0]];
        let flat = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        for loops in [vec![], vec![vec![[0.0, 0.0]; 2]], vec![nan], vec![square(0.0, 1.0), flat]] {
            assert!(matches!(TrimLoops::new(loops), Err(Error::Argument { .. })));
        }
        let knots = KnotVector::uniform_clamped(1, 2).unwrap();
        let net = [[0., 0.], [0., 1.], [1., 0.], [1., 1.]].map(|[x, y]| Vector3::new(x, y, 0.0)).to_vec();
        let surface = BsplineSurface::new(knots.clone(), knots, net, None).unwrap();
        assert!(TrimLoops::new(vec![square(0.0, 1.0 + 1e-12)]).unwrap().within(&surface).is_ok());
        let error = TrimLoops::new(vec![square(0.0, 1.1)]).unwrap().within(&surface).unwrap_err();
        assert!(error.to_string().contains("beyond the domain"), "{error}");
    }
}
