//! Self-loops and crossovers: what a base curve or surface must not have.

use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineSurface, ParametricSurface};
use sdm_fit::Folds;

/// Number of places where a closed polygon crosses itself.
#[must_use]
pub fn self_loops(polygon: &[Vector2<f64>]) -> usize {
    crossings(polygon).len()
}

/// Pairs of edges of a closed polygon that cross; an edge has the number of its first corner.
fn crossings(polygon: &[Vector2<f64>]) -> Vec<[usize; 2]> {
    let n = polygon.len();
    let edge = |i: usize| (polygon[i], polygon[(i + 1) % n]);
    // Edges by their left ends; each is compared with those that begin before it ends.
    let mut order: Vec<usize> = (0..n).collect();
    let left = |i: usize| edge(i).0.x.min(edge(i).1.x);
    order.sort_by(|&i, &j| left(i).total_cmp(&left(j)));
    let mut found = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        let (a, b) = edge(i);
        let right = a.x.max(b.x);
        for &j in order[k + 1..].iter().take_while(|&&j| left(j) <= right) {
            if (i + 1) % n != j && (j + 1) % n != i && cross(a, b, edge(j).0, edge(j).1) {
                found.push([i.min(j), i.max(j)]);
            }
        }
    }
    found
}

/// The loops of curves `v = const` of a surface that is closed in `u`, seen along the last of three axes: where they begin and end, as
/// shares of the domain in `u` that may exceed 1, and the share in `v`.
pub(crate) fn loops(surface: &BsplineSurface, [a, b, _]: &[Vector3<f64>; 3]) -> Vec<([f64; 2], f64)> {
    // Two places for each span, as evenly as the samples of a base surface.
    let [around, along] = [surface.knots_u(), surface.knots_v()].map(|knots| 2 * knots.spans().count());
    let [u, v] = surface.domain();
    let share = |k: usize, count: usize| k as f64 / count as f64;
    let rows = crate::parallel::map(along + 1, |j| {
        let place = |i: usize| surface.point(u.lerp(share(i, around)), v.lerp(share(j, along)));
        let seen = (0..around).map(place).map(|p| Vector2::new(p.dot(a), p.dot(b)));
        crossings(&seen.collect::<Vec<_>>())
    });
    let numbered = rows.into_iter().enumerate();
    let all = numbered.flat_map(|(j, row)| row.into_iter().map(move |pair| (pair, j)));
    // The loop is the shorter of the two parts into which a crossing divides the curve.
    let shorter = |[i, j]: [usize; 2]| if 2 * (j - i) <= around { [i, j + 1] } else { [j, i + 1 + around] };
    all.map(|(pair, j)| (shorter(pair).map(|k| share(k, around)), share(j, along))).collect()
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
    /// Number of cells (products of knot spans) in which the surface folds over and parameter lines cross; see [`Folds`].
    pub crossovers: usize,
}

impl SurfaceDefects {
    /// Examines a surface; self-loops are looked for along `axis`, if `u` is closed and one is given.
    #[must_use]
    pub fn of(surface: &BsplineSurface, axis: Option<&[Vector3<f64>; 3]>) -> Self {
        let mut found = Self { self_loops: 0, crossovers: Folds::of(surface).count() };
        if let Some(axes) = axis.filter(|_| surface.knots_u().is_periodic()) {
            found.self_loops = loops(surface, axes).len();
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
