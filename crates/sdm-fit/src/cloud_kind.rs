//! What a cloud is before anything is fitted to it: points of a curve, a surface or a volume, and points that are none of them.

use crate::spacing::{LocalSpacing, distinct};
use crate::{Error, parallel};
use nalgebra::{Matrix3, SymmetricEigen, Vector2, Vector3};

/// Fewest points of which it is said what they fill, and how many of them are asked at most.
const LEAST: usize = 60;
const ASKED: usize = 400;
/// Neighbours of the smallest scale, and most of the largest; share of the points that the largest holds.
const NEIGHBOURS: [usize; 2] = [12, 1500];
const LARGEST: usize = 6;
/// Variances across a plane, and across a line, as a share of the next larger one, up to which neighbours lie in it. Half a ball has
/// .3, so that the border of a volume is not taken for a surface.
const FLAT: f64 = 0.12;
const STRAIGHT: f64 = 0.04;
/// Share of the points whose neighbours lie in planes, at some scale, of a surface; and in lines, at all scales, of a curve.
const SURFACE: f64 = 0.5;
const CURVE: f64 = 0.9;

/// Distance from the middle, as a multiple of that of nine tenths of the points, beyond which a point cannot belong to the same shape;
/// share of the points of which this is said at most.
const BEYOND: f64 = 1e6;
const FEW: f64 = 0.05;
/// Sizes whose squares and their squares can be computed with.
const SIZES: [f64; 2] = [1e-60, 1e60];

/// What points fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CloudKind {
    /// At all scales points lie along lines.
    Curve,
    /// Most points lie in a sheet, at some scale.
    Surface,
    /// Most points have others on all sides, at all scales.
    Volume,
}

/// What the points of a cloud fill, by the principal variances of neighbours at several scales: of a few points up to a sixth of all,
/// so that noise, which fills a volume at small scales, does not matter. `Surface` for fewer than 60 points.
///
/// # Errors
/// [`Error::Field`] for more points than can be numbered.
pub fn cloud_kind(points: &[Vector3<f64>]) -> Result<CloudKind, Error> {
    let finite: Vec<Vector3<f64>> =
        points.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
    let points = distinct(&finite);
    if points.len() < LEAST {
        return Ok(CloudKind::Surface);
    }
    let spacing = LocalSpacing::new(&points)?;
    let largest = (points.len() / LARGEST).min(NEIGHBOURS[1]);
    let step = points.len().div_ceil(ASKED).max(1);
    let asked: Vec<usize> = (0..points.len()).step_by(step).collect();
    let answers = parallel::tasks(asked.len(), |k| {
        let near = spacing.index().nearest_n(&points[asked[k]].into(), largest + 1);
        let (mut flat, mut straight) = (false, true);
        let mut count = NEIGHBOURS[0].min(largest);
        loop {
            let [first, second, third] =
                variances(near[..near.len().min(count + 1)].iter().map(|n| points[n.index]));
            flat |= third <= FLAT * second;
            straight &= second <= STRAIGHT * first;
            if count >= largest {
                break;
            }
            count = (2 * count).min(largest);
        }
        (flat, straight)
    });
    let share = |count: usize| count as f64 / answers.len() as f64;
    Ok(if share(answers.iter().filter(|a| a.1).count()) >= CURVE {
        CloudKind::Curve
    } else if share(answers.iter().filter(|a| a.0).count()) >= SURFACE {
        CloudKind::Surface
    } else {
        CloudKind::Volume
    })
}

/// Principal variances of points, the largest first.
fn variances(points: impl Iterator<Item = Vector3<f64>> + Clone) -> [f64; 3] {
    let count = points.clone().count().max(1) as f64;
    let mean = points.clone().sum::<Vector3<f64>>() / count;
    let size = points.clone().map(|p| (p - mean).amax()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let scatter: Matrix3<f64> = points.map(|p| (p - mean) / size).map(|d| d * d.transpose()).sum();
    let mut values: [f64; 3] = SymmetricEigen::new(scatter / count).eigenvalues.into();
    values.sort_unstable_by(|a, b| b.total_cmp(a));
    values.map(|v| v.max(0.0))
}

/// Which points of a cloud can belong to one shape: those that are finite, and not a million times farther from the middle than nine
/// tenths of the points. A few wild coordinates would otherwise decide the scale of everything.
///
/// # Errors
/// [`Error::Magnitude`] for clouds so small or large that squares of lengths cannot be computed with.
pub fn measurable(points: &[Vector3<f64>]) -> Result<Vec<bool>, Error> {
    let finite = |p: &Vector3<f64>| p.iter().all(|c| c.is_finite());
    let mut belongs: Vec<bool> = points.iter().map(finite).collect();
    let count = belongs.iter().filter(|b| **b).count();
    if count == 0 {
        return Ok(belongs);
    }
    let quantile = |mut values: Vec<f64>, share: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
        let k = (share * (values.len() - 1) as f64) as usize;
        *values.select_nth_unstable_by(k, f64::total_cmp).1
    };
    let middle =
        Vector3::from_fn(|c, _| quantile(points.iter().filter(|p| finite(p)).map(|p| p[c]).collect(), 0.5));
    // Halves, so that no difference overflows.
    let distance = |p: &Vector3<f64>| (0.5 * p - 0.5 * middle).amax();
    let distances: Vec<f64> = points.iter().filter(|p| finite(p)).map(distance).collect();
    let usual = quantile(distances.clone(), 0.9);
    let beyond = distances.iter().filter(|d| **d > BEYOND * usual).count();
    if usual > 0.0 && beyond as f64 <= FEW * count as f64 {
        for (belongs, point) in belongs.iter_mut().zip(points) {
            *belongs &= distance(point) <= BEYOND * usual;
        }
    }
    let size =
        points.iter().zip(&belongs).filter(|(_, b)| **b).map(|(p, _)| 4.0 * distance(p)).fold(0.0, f64::max);
    if size > 0.0 && !(SIZES[0]..=SIZES[1]).contains(&size) {
        return Err(Error::Magnitude { size, least: SIZES[0], most: SIZES[1] });
    }
    Ok(belongs)
}

/// Distance of two points without the squares of coordinates, which overflow for large ones.
pub(crate) fn distance_of_far(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let half = 0.5 * a - 0.5 * b;
    let size = half.amax();
    if size > 0.0 { ((half / size).norm() * size * 2.0).min(f64::MAX) } else { 0.0 }
}

/// Share of the area of the rectangle along the principal axes below which the smallest rectangle around points is taken.
const TIGHTER: f64 = 0.95;

/// Two unit vectors across a normal, along the sides of the smallest rectangle around points seen along it; the first is the longer
/// side. Where that rectangle is hardly smaller than the one along `first` (a unit vector across the normal), this one is kept.
#[must_use]
pub fn tight_axes(points: &[Vector3<f64>], normal: &Vector3<f64>, first: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let second = normal.cross(first);
    let flat: Vec<Vector2<f64>> = points.iter().map(|p| Vector2::new(p.dot(first), p.dot(&second))).collect();
    let hull = convex_hull(flat);
    let sides = |direction: &Vector2<f64>| {
        let across = Vector2::new(-direction.y, direction.x);
        let width = |d: &Vector2<f64>| {
            let range = hull
                .iter()
                .map(|p| p.dot(d))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            range.1 - range.0
        };
        [width(direction), width(&across)]
    };
    let area = |direction: &Vector2<f64>| sides(direction).iter().product::<f64>();
    let given = Vector2::x();
    let edges = (0..hull.len()).filter_map(|k| (hull[(k + 1) % hull.len()] - hull[k]).try_normalize(0.0));
    let best =
        edges.min_by(|a, b| area(a).total_cmp(&area(b))).filter(|best| area(best) < TIGHTER * area(&given));
    let Some(best) = best else { return [*first, second] };
    let [along, across] = sides(&best);
    let best = if along >= across { best } else { Vector2::new(-best.y, best.x) };
    // Of the two directions the one nearer to the first axis.
    let best = if best.x < 0.0 { -best } else { best };
    let x = first * best.x + second * best.y;
    [x, normal.cross(&x)]
}

/// Corners of the convex hull in order (Andrew's monotone chain).
fn convex_hull(mut points: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let chain = |points: &mut dyn Iterator<Item = &Vector2<f64>>| {
        let mut out: Vec<Vector2<f64>> = Vec::new();
        for p in points {
            while let [.., a, b] = out[..]
                && (b - a).perp(&(p - b)) <= 0.0
            {
                out.pop();
            }
            out.push(*p);
        }
        out.pop();
        out
    };
    let mut hull = chain(&mut points.iter());
    hull.extend(chain(&mut points.iter().rev()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from 0 to 1 that look like chance.
    fn share(k: usize, step: f64) -> f64 {
        ((k as f64 * step * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0)
    }

    #[test]
    fn curves_surfaces_and_volumes_are_told_apart() {
        let cloud = |place: &dyn Fn(f64, f64, f64) -> Vector3<f64>| -> Vec<Vector3<f64>> {
            let at =
                |k: usize| place(share(k, 0.754_877_666), share(k, 0.569_840_291), share(k, 0.438_579_021));
            (1..=2000).map(at).collect()
        };
        let turn = std::f64::consts::TAU;
        let kind = |place: &dyn Fn(f64, f64, f64) -> Vector3<f64>| cloud_kind(&cloud(place)).unwrap();
        assert_eq!(kind(&|a, b, c| Vector3::new(a, b, c)), CloudKind::Volume);
        assert_eq!(kind(&|a, b, c| Vector3::new(4.0 * a, 2.0 * b, c)), CloudKind::Volume);
        assert_eq!(
            kind(&|a, b, _| Vector3::new((turn * a).cos(), (turn * a).sin(), 4.0 * b)),
            CloudKind::Surface
        );
        // Noise of two spacings.
        assert_eq!(kind(&|a, b, c| Vector3::new(10.0 * a, 10.0 * b, c)), CloudKind::Surface);
        assert_eq!(kind(&|a, _, _| Vector3::new(a, 2.0 * a, 3.0 * a)), CloudKind::Curve);
        assert_eq!(kind(&|a, b, _| Vector3::new(100.0 * a, 0.001 * b, 0.0)), CloudKind::Curve);
        assert_eq!(kind(&|a, b, _| Vector3::new(30.0 * a, b, 0.0)), CloudKind::Surface);
    }

    #[test]
    fn wild_points_do_not_belong() {
        let mut points: Vec<Vector3<f64>> =
            (0..100).map(|k| Vector3::new(share(k, 0.7), share(k, 0.3), 1.0)).collect();
        points.push(Vector3::new(1e300, 0.0, 0.0));
        points.push(Vector3::new(f64::NAN, 0.0, 0.0));
        points.push(Vector3::new(0.0, -f64::MAX, f64::MAX));
        let belongs = measurable(&points).unwrap();
        assert_eq!(belongs.iter().filter(|b| **b).count(), 100);
        assert!(!belongs[100] && !belongs[101] && !belongs[102]);
        assert!(distance_of_far(&points[100], &points[0]) > 0.99e300);
        assert!(distance_of_far(&points[102], &points[0]).is_finite());
        let tiny: Vec<_> = points[..100].iter().map(|p| p * 1e-160).collect();
        assert!(matches!(measurable(&tiny), Err(Error::Magnitude { .. })));
        let huge: Vec<_> = points[..100].iter().map(|p| p * 1e160).collect();
        assert!(matches!(measurable(&huge), Err(Error::Magnitude { .. })));
    }

    #[test]
    fn a_square_is_seen_along_its_sides() {
        let turned = |a: f64, b: f64| Vector3::new(a - b, a + b, 0.0);
        let points: Vec<_> = (0..100).map(|k| turned((k / 10) as f64, (k % 10) as f64)).collect();
        let [x, y] = tight_axes(&points, &Vector3::z(), &Vector3::x());
        assert!((x.x.abs() - x.y.abs()).abs() < 1e-12 && x.dot(&y).abs() < 1e-12, "{x}");
        // A rectangle that is along the axis already stays so.
        let along: Vec<_> = (0..100).map(|k| Vector3::new((k / 10) as f64, (k % 10) as f64, 0.0)).collect();
        assert_eq!(tight_axes(&along, &Vector3::z(), &Vector3::x()), [Vector3::x(), Vector3::y()]);
    }
}
