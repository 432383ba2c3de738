//! Self-loops and crossovers: what a base curve or surface must not have.

use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineSurface, ParametricSurface};

/// Number of places where a closed polygon crosses itself.
#[must_use]
pub fn self_loops(polygon: &[Vector2<f64>]) -> usize {
    let n = polygon.len();
    let edge = |i: usize| (polygon[i], polygon[(i + 1) % n]);
    // Edges by their left ends; each is compared with those that begin before it ends.
    let mut order: Vec<usize> = (0..n).collect();
    let left = |i: usize| edge(i).0.x.min(edge(i).1.x);
    order.sort_by(|&i, &j| left(i).total_cmp(&left(j)));
    let mut found = 0;
    for (k, &i) in order.iter().enumerate() {
        let (a, b) = edge(i);
        let right = a.x.max(b.x);
        for &j in order[k + 1..].iter().take_while(|&&j| left(j) <= right) {
            if (i + 1) % n != j && (j + 1) % n != i && cross(a, b, edge(j).0, edge(j).1) {
                found += 1;
            }
        }
    }
    found
}

/// Whether two segments cross in their interiors.
fn cross(a: Vector2<f64>, b: Vector2<f64>, c: Vector2<f64>, d: Vector2<f64>) -> bool {
    let side = |p: Vector2<f64>, q: Vector2<f64>, r: Vector2<f64>| (q - p).perp(&(r - p));
    let (low, high) = (a.y.min(b.y), a.y.max(b.y));
    c.y.max(d.y) >= low
        && c.y.min(d.y) <= high
        && side(a, b, c) * side(a, b, d) < 0.0
        && side(c, d, a) * side(c, d, b) < 0.0
}

/// What is wrong with a surface that should be a deformed cylinder, sphere or plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SurfaceDefects {
    /// Number of places where curves `v = const` cross themselves, seen along the axis; 0 where there is none.
    pub self_loops: usize,
    /// Number of cells of a grid on the surface, two for each knot span in both directions, at whose corners the normals
    /// point to different sides: the surface folds over and parameter lines cross.
    pub crossovers: usize,
}

impl SurfaceDefects {
    /// Examines a surface; self-loops are looked for along `axis`, if `u` is closed and one is given.
    #[must_use]
    pub fn of(surface: &BsplineSurface, axis: Option<&[Vector3<f64>; 3]>) -> Self {
        let [knots_u, knots_v] = [surface.knots_u(), surface.knots_v()];
        let (n_u, n_v) = (2 * knots_u.spans().count(), 2 * knots_v.spans().count());
        let [u, v] = surface.domain();
        let jets = crate::parallel::map(n_v + 1, |j| {
            (0..=n_u)
                .map(|i| surface.jet(u.lerp(i as f64 / n_u as f64), v.lerp(j as f64 / n_v as f64)))
                .collect::<Vec<_>>()
        });
        // At a pole normals vanish and their directions mean nothing.
        let largest =
            jets.iter().flatten().map(|jet| jet.normal_direction().norm_squared()).fold(0.0, f64::max);
        let mut found = Self::default();
        for rows in jets.windows(2) {
            for i in 0..n_u {
                let normals = [&rows[0][i], &rows[0][i + 1], &rows[1][i + 1], &rows[1][i]]
                    .map(|jet| jet.normal_direction());
                let folded = (0..4).any(|k| normals[k].dot(&normals[(k + 1) % 4]) < -1e-12 * largest);
                found.crossovers += usize::from(folded);
            }
        }
        if let (Some([a, b, _]), true) = (axis, knots_u.is_periodic()) {
            let loops = crate::parallel::map(n_v + 1, |j| {
                let polygon: Vec<Vector2<f64>> = jets[j][..n_u]
                    .iter()
                    .map(|jet| Vector2::new(jet.point.dot(a), jet.point.dot(b)))
                    .collect();
                self_loops(&polygon)
            });
            found.self_loops = loops.iter().sum();
        }
        found
    }

    /// Whether nothing is wrong.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn counts_crossings() {
        let figure = |f: &dyn Fn(f64) -> Vector2<f64>| -> Vec<Vector2<f64>> {
            (0..101).map(|i| f(TAU * f64::from(i) / 101.0)).collect()
        };
        assert_eq!(self_loops(&figure(&|t| Vector2::new(t.cos(), t.sin()))), 0);
        assert_eq!(self_loops(&figure(&|t| Vector2::new((t + 0.01).sin(), (2.0 * t + 0.02).sin()))), 1);
        // A circle with three small loops.
        assert!(self_loops(&figure(&|t| Vector2::new(t.cos(), t.sin()) * (1.0 - 1.6 * (3.0 * t).cos()))) > 0);
        assert_eq!(self_loops(&[]), 0);
    }
}
