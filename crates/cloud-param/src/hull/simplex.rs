//! The simplex from which a hull grows.

use super::predicates::Scaled;

/// As many points in general position as there are, up to four.
#[derive(Debug)]
pub(super) enum Start {
    Point(u32),
    Segment([u32; 2]),
    Triangle([u32; 3]),
    /// Positive: the last point sees the first three clockwise, so that they are a face from outside.
    Tetrahedron([u32; 4]),
}

impl Start {
    pub(super) fn find(scaled: &Scaled) -> Self {
        let points = &scaled.points;
        let all = || points.iter().zip(0u32..);
        // The index of the largest value, the first of equals.
        let farthest = |value: &dyn Fn(u32) -> f64| {
            all()
                .map(|(_, i)| (value(i), i))
                .fold((f64::NEG_INFINITY, 0), |m, x| if x.0 > m.0 { x } else { m })
                .1
        };
        let at = |i: u32| points[i as usize];
        // An extreme point, and the other end of the cloud along a line.
        let first = points[0];
        let a = farthest(&|i| (at(i) - first).norm_squared());
        let b = farthest(&|i| (at(i) - at(a)).norm_squared());
        if at(a) == at(b) {
            return Self::Point(0);
        }
        let along = at(b) - at(a);
        let mut c = farthest(&|i| along.cross(&(at(i) - at(a))).norm_squared());
        if scaled.is_collinear([a, b, c]) {
            match all().map(|(_, i)| i).find(|&i| !scaled.is_collinear([a, b, i])) {
                Some(other) => c = other,
                None => return Self::Segment(ends(scaled)),
            }
        }
        let normal = along.cross(&(at(c) - at(a)));
        let mut d = farthest(&|i| normal.dot(&(at(i) - at(a))).abs());
        if scaled.side([a, b, c], d) == 0.0 {
            match all().map(|(_, i)| i).find(|&i| scaled.side([a, b, c], i) != 0.0) {
                Some(other) => d = other,
                None => return Self::Triangle([a, b, c]),
            }
        }
        if scaled.side([a, b, c], d) > 0.0 {
            Self::Tetrahedron([a, c, b, d])
        } else {
            Self::Tetrahedron([a, b, c, d])
        }
    }
}

/// The ends of collinear points: the first and last in lexicographic order.
fn ends(scaled: &Scaled) -> [u32; 2] {
    let less = |i: &u32, j: &u32| {
        let (p, q) = (&scaled.points[*i as usize], &scaled.points[*j as usize]);
        p.iter()
            .zip(q.iter())
            .map(|(x, y)| x.total_cmp(y))
            .fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    };
    let indices = || scaled.points.iter().zip(0u32..).map(|(_, i)| i);
    [indices().min_by(less).unwrap_or(0), indices().max_by(less).unwrap_or(0)]
}
