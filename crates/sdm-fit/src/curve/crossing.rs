//! Where a plane curve crosses itself.

use mesh_core::CloudIndex;
use nalgebra::{Matrix2, SVector, Vector2};
use nurbs_core::{BsplineCurve, ParametricCurve};

/// Chords per span.
const CHORDS: usize = 24;
/// Steps of Newton's method.
const STEPS: usize = 12;

/// Pairs of parameters at which a plane curve crosses itself, the smaller one first; nothing for curves in space.
///
/// Each span is replaced by 24 chords; crossings of these are then improved by Newton's method on the curve. Loops
/// smaller than a chord can be missed.
#[must_use]
pub fn self_crossings<const D: usize>(curve: &BsplineCurve<D>) -> Vec<[f64; 2]> {
    if D != 2 {
        return Vec::new();
    }
    let knots = curve.knots();
    let mut parameters = Vec::new();
    for span in knots.spans() {
        let interval = knots.span_interval(span);
        parameters.extend((0..CHORDS).map(|k| interval.lerp(k as f64 / CHORDS as f64)));
    }
    parameters.push(knots.domain().end());
    let at = |t: f64| plane(&curve.point(t));
    let points: Vec<Vector2<f64>> = parameters.iter().map(|&t| at(t)).collect();
    let last = points.len() - 1;
    let closed = knots.is_periodic() || (points[0] - points[last]).norm() == 0.0;
    let mut order: Vec<usize> = (0..last).collect();
    let low = |i: usize| points[i].x.min(points[i + 1].x);
    order.sort_by(|&a, &b| low(a).total_cmp(&low(b)).then(a.cmp(&b)));
    let mut found: Vec<[f64; 2]> = Vec::new();
    for (rank, &i) in order.iter().enumerate() {
        let end = points[i].x.max(points[i + 1].x);
        for &j in order[rank + 1..].iter().take_while(|&&j| low(j) <= end) {
            let (first, second) = (i.min(j), i.max(j));
            let neighbours = second - first <= 1 || closed && first == 0 && second + 1 == last;
            if neighbours {
                continue;
            }
            if let Some(shares) = chords_cross(&points, first, second) {
                let chord = |k: usize, s: f64| parameters[k] + (parameters[k + 1] - parameters[k]) * s;
                found.push(refine(curve, [chord(first, shares[0]), chord(second, shares[1])]));
            }
        }
    }
    found.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let same = 1e-9 * knots.domain().length();
    found.dedup_by(|a, b| (a[0] - b[0]).abs() <= same && (a[1] - b[1]).abs() <= same);
    found
}

/// Whether two parts of a plane curve that are far from each other along it come nearer to each other than a distance, at an angle: where it
/// may have turned instead of going straight on across itself. The sides of what is thin are parallel.
pub(super) fn meets_itself<const D: usize>(curve: &BsplineCurve<D>, distance: f64) -> bool {
    /// Samples at most, length along the curve from which on parts are far in units of the distance, and sine of the angle.
    const MOST: usize = 4000;
    const APART: f64 = 8.0;
    const ANGLE: f64 = 0.5;
    if D != 2 || distance.is_nan() || distance <= 0.0 {
        return false;
    }
    let (domain, closed) = (curve.domain(), curve.knots().is_periodic());
    let at = |k: usize| plane(&curve.point(domain.lerp(k as f64 / MOST as f64)));
    let places: Vec<Vector2<f64>> = (0..=MOST).map(at).collect();
    let mut lengths = vec![0.0];
    for (k, pair) in places.windows(2).enumerate() {
        lengths.push(lengths[k] + (pair[1] - pair[0]).norm());
    }
    let total = lengths[MOST];
    // Where samples are wider apart they tell no more than that.
    let reach = distance.max(4.0 * total / MOST as f64);
    let mut picked: Vec<(nalgebra::Point2<f64>, Vector2<f64>, f64)> = Vec::new();
    for k in 0..MOST {
        if picked.last().is_none_or(|last| lengths[k] - last.2 >= 0.4 * reach)
            && let Some(way) = (places[k + 1] - places[k]).try_normalize(0.0)
        {
            picked.push((places[k].into(), way, lengths[k]));
        }
    }
    let points: Vec<_> = picked.iter().map(|p| p.0).collect();
    let Ok(index) = CloudIndex::new(&points) else { return false };
    picked.iter().enumerate().any(|(i, (place, way, length))| {
        index.within(place, reach).iter().filter(|n| n.index > i).any(|n| {
            let (_, other, far) = &picked[n.index];
            let apart = if closed { (far - length).min(total - far + length) } else { far - length };
            apart > APART * reach && way.perp(other).abs() > ANGLE
        })
    })
}

pub(super) fn plane<const D: usize>(x: &SVector<f64, D>) -> Vector2<f64> {
    Vector2::new(x[0], x[1])
}

/// The shares of two chords at which they cross.
fn chords_cross(points: &[Vector2<f64>], i: usize, j: usize) -> Option<[f64; 2]> {
    let (a, b) = (points[i + 1] - points[i], points[j + 1] - points[j]);
    let between = points[j] - points[i];
    let determinant = a.perp(&b);
    let shares = [between.perp(&b) / determinant, between.perp(&a) / determinant];
    shares.iter().all(|s| (0.0..1.0).contains(s)).then_some(shares)
}

/// Newton's method for `c(s) = c(t)`; the start where it leads away.
fn refine<const D: usize>(curve: &BsplineCurve<D>, start: [f64; 2]) -> [f64; 2] {
    let domain = curve.domain();
    let bound = domain.length() / CHORDS as f64;
    let [mut s, mut t] = start;
    for _ in 0..STEPS {
        let (first, second) = (curve.jet(s), curve.jet(t));
        let matrix = Matrix2::from_columns(&[plane(&first.d1), -plane(&second.d1)]);
        let Some(step) = matrix.lu().solve(&-plane(&(first.point - second.point))) else { return start };
        (s, t) = (s + step.x, t + step.y);
        let stays = (s - start[0]).abs() <= bound && (t - start[1]).abs() <= bound;
        if !stays || !domain.contains(s) || !domain.contains(t) {
            return start;
        }
        if step.amax() <= 1e-14 * domain.length() {
            break;
        }
    }
    [s, t]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nurbs_core::KnotVector;

    #[test]
    fn a_loop_is_found_and_an_oval_has_none() {
        let points =
            [(0.0, 0.0), (4.0, 2.0), (-3.0, 2.0), (1.0, 0.0)].map(|(x, y)| Vector2::new(x, y)).to_vec();
        let looped = BsplineCurve::bezier(points, None).unwrap();
        let found = self_crossings(&looped);
        assert_eq!(found.len(), 1);
        let [s, t] = found[0];
        assert!(s < t && (looped.point(s) - looped.point(t)).norm() < 1e-12);
        let ring =
            |i: usize| Vector2::new(0.0, 1.0).map(|v| (std::f64::consts::FRAC_PI_4 * i as f64 - v).cos());
        let knots = KnotVector::uniform_periodic(3, 8).unwrap();
        let oval = BsplineCurve::new(knots, (0..11).map(|i| ring(i % 8)).collect(), None).unwrap();
        assert!(self_crossings(&oval).is_empty());
    }
}
