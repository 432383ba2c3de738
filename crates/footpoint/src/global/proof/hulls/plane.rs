//! Planes that separate a part of a patch from the query, as far as the control net tells.

use super::net::{COMPONENTS, Layout, load};
use crate::global::arithmetic::lanes::{Lanes, WIDTH};

/// The parallelogram that a part resembles, seen from the query.
pub(super) struct Facet {
    /// Its nearest point, and where on the part that would be.
    pub(super) nearest: [f64; 3],
    pub(super) place: [f64; 2],
}

#[inline(always)]
pub(super) fn dot3(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// The nearest point of the parallelogram between the corners of a net.
#[inline(always)]
pub(super) fn facet(layout: Layout, net: &[f64]) -> Facet {
    let (n, columns) = (layout.count(), layout.q + 1);
    let corner = |k: usize| {
        let [x, y, z, w] = layout.point(net, k);
        [x / w, y / w, z / w]
    };
    let corners = [0, columns - 1, n - columns, n - 1].map(corner);
    let mut centre = [0.0; 3];
    let mut sides = [[0.0; 3]; 2];
    for c in 0..3 {
        let [a, b, e, f] = corners.map(|corner| corner[c]);
        centre[c] = 0.25 * ((a + b) + (e + f));
        sides[0][c] = 0.5 * ((e + f) - (a + b));
        sides[1][c] = 0.5 * ((b + f) - (a + e));
    }
    let metric = [dot3(&sides[0], &sides[0]), dot3(&sides[0], &sides[1]), dot3(&sides[1], &sides[1])];
    let slopes = [dot3(&sides[0], &centre), dot3(&sides[1], &centre)];
    let det = metric[0] * metric[2] - metric[1] * metric[1];
    let inside = |s: f64| (-0.5..=0.5).contains(&s);
    let free = [
        (metric[1] * slopes[1] - metric[2] * slopes[0]) / det,
        (metric[1] * slopes[0] - metric[0] * slopes[1]) / det,
    ];
    let point = |at: [f64; 2]| -> [f64; 3] {
        std::array::from_fn(|c| centre[c] + (at[0] * sides[0][c] + at[1] * sides[1][c]))
    };
    let mut at = free;
    if !(inside(free[0]) && inside(free[1])) {
        // On the border: the better of both ways to get there.
        let mut least = f64::INFINITY;
        for d in 0..2 {
            let mut tried = [0.0; 2];
            tried[d] = clamp(free[d]);
            let other = -(slopes[1 - d] + metric[1] * tried[d]) / metric[2 * (1 - d)];
            tried[1 - d] = clamp(other);
            let found = point(tried);
            let distance_sq = dot3(&found, &found);
            if distance_sq < least {
                (at, least) = (tried, distance_sq);
            }
        }
        at = at.map(clamp);
    }
    Facet { nearest: point(at), place: at.map(|s| s + 0.5) }
}

#[inline(always)]
fn clamp(s: f64) -> f64 {
    // NaN, where a side has no length, counts as the middle.
    if s.is_nan() { 0.0 } else { s.clamp(-0.5, 0.5) }
}

/// How far from the query, at least, the hull of a net is in a direction, which need not be a unit vector.
#[inline(always)]
pub(super) fn distance_along(layout: Layout, net: &[f64], direction: &[f64; 3]) -> f64 {
    let length = dot3(direction, direction).sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return 0.0;
    }
    let n = layout.count();
    let unit = direction.map(|c| c / length);
    let net = &net[..layout.length()];
    let rational = layout.components == COMPONENTS;
    let mut least = Lanes::splat(f64::INFINITY);
    let mut k = 0;
    while k + WIDTH <= n {
        let mut along =
            (load(net, k) * unit[0] + load(net, n + k) * unit[1]) + load(net, 2 * n + k) * unit[2];
        if rational {
            along = along / load(net, 3 * n + k);
        }
        least = along.min(least);
        k += WIDTH;
        if k < n && k + WIDTH > n {
            // The last ones, some of them once more.
            k = n - WIDTH;
        }
    }
    while k < n {
        let mut along = (net[k] * unit[0] + net[n + k] * unit[1]) + net[2 * n + k] * unit[2];
        if rational {
            along /= net[3 * n + k];
        }
        let lane = k % WIDTH;
        least.0[lane] = if along < least.0[lane] { along } else { least.0[lane] };
        k += 1;
    }
    let least = least.horizontal_min();
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bilinear net by its corners.
    fn bilinear(corners: [[f64; 3]; 4]) -> Vec<f64> {
        (0..3).flat_map(|c| corners.map(|corner| corner[c])).collect()
    }

    #[test]
    fn the_nearest_point_of_a_rectangle() {
        let layout = Layout::new([1, 1], false);
        let above = bilinear([[-1.0, -1.0, 2.0], [-1.0, 3.0, 2.0], [1.0, -1.0, 2.0], [1.0, 3.0, 2.0]]);
        let found = facet(layout, &above);
        assert_eq!((found.nearest, found.place), ([0.0, 0.0, 2.0], [0.5, 0.25]));
        assert_eq!(distance_along(layout, &above, &[0.0, 0.0, 5.0]), 2.0);
        let beside = bilinear([[1.0, -1.0, 2.0], [1.0, 3.0, 2.0], [4.0, -1.0, 2.0], [4.0, 3.0, 2.0]]);
        let found = facet(layout, &beside);
        assert_eq!((found.nearest, found.place), ([1.0, 0.0, 2.0], [0.0, 0.25]));
        assert!((distance_along(layout, &beside, &found.nearest) - 5f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn a_collapsed_net_has_a_nearest_point() {
        let layout = Layout::new([1, 1], false);
        let found = facet(layout, &bilinear([[1.0, 2.0, 2.0]; 4]));
        assert_eq!(found.nearest, [1.0, 2.0, 2.0]);
        assert_eq!(distance_along(layout, &bilinear([[0.0; 3]; 4]), &[0.0; 3]), 0.0);
    }
}
