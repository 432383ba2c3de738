//! Where the data end on a surface that goes on beyond them.

use super::SurfaceCoverage;
use super::contour::contours;
use super::samples::{count, span_lengths};
use crate::{Error, parallel};
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};
use nurbs_core::{BsplineSurface, Direction, KnotVector, ParametricSurface, TrimLoops};

/// Radius of balls without data whose centres are on the surface, in units of the distance beyond which a part of the surface is without data.
const BALL: f64 = 0.8;
/// Distance of grid lines in units of the radius, at most that where there would be too many, and most places.
const FINE: f64 = 0.15;
const COARSE: f64 = 0.4;
const MOST: f64 = 4_000_000.0;
/// Share of the area, and of the points, that parts may have which are by themselves where some points may be outliers.
const ISLAND: f64 = 0.02;
const STRAY: f64 = 0.01;
/// Places around a surface where it may be opened.
const SEAMS: usize = 4;
/// Width of the rim that is left around the data, in distances of grid lines: what lies on the outline stays inside.
const RIM: f64 = 0.7;

/// The loops in the parameters of a surface that bound what of it is near data points, if they leave out a part of it.
///
/// It is what no ball without points, its centre on the surface, reaches (the α-hull of \[EKS83\], on a surface): its
/// radius is four fifths of the distance beyond which a part of the surface counts as without data, mostly two spacings of the points. So the piece
/// follows outlines that are concave, and holes; holes that random points may leave are none. The first loop is the outer one, counter-clockwise
/// in (u, v); those of holes run the other way round.
///
/// `points` are those that the surface is to be near to, and `coverage` that of the whole surface by them. `None` where no part is without data,
/// for surfaces that close in a direction, and where what is near the points falls into parts or is too narrow to be bounded. With `outliers` few points
/// may be by themselves, and are not followed.
///
/// # Errors
/// [`Error::Field`] for points that are not finite.
pub fn data_outline(
    surface: &BsplineSurface,
    points: &[Vector3<f64>],
    coverage: &SurfaceCoverage,
    outliers: bool,
) -> Result<Option<TrimLoops>, Error> {
    if [surface.knots_u(), surface.knots_v()].iter().any(|k| k.is_periodic()) {
        return Ok(None);
    }
    outline(surface, points, coverage, outliers, None)
}

/// A surface that closes in one direction, opened, and the loops that bound what of it is near data points, as [`data_outline`] does. The seam is
/// one of a few around the surface that the piece does not cross.
///
/// # Errors
/// As [`data_outline`].
pub(super) fn opened_with_outline(
    surface: &BsplineSurface,
    points: &[Vector3<f64>],
    coverage: &SurfaceCoverage,
    outliers: bool,
) -> Result<Option<(BsplineSurface, TrimLoops)>, Error> {
    let knots = [surface.knots_u(), surface.knots_v()];
    let direction = match knots.map(KnotVector::is_periodic) {
        [true, false] => Direction::U,
        [false, true] => Direction::V,
        _ => return Ok(None),
    };
    let domain = knots[usize::from(direction == Direction::V)].domain();
    for k in 0..SEAMS {
        let opened = surface.opened_at(direction, domain.lerp(k as f64 / SEAMS as f64))?;
        if let Some(trim) = outline(&opened, points, coverage, outliers, Some(direction))? {
            return Ok(Some((opened, trim)));
        }
    }
    Ok(None)
}

/// The loops on a surface without a periodic direction, which may be closed in that of a seam.
fn outline(
    surface: &BsplineSurface,
    points: &[Vector3<f64>],
    coverage: &SurfaceCoverage,
    outliers: bool,
    seam: Option<Direction>,
) -> Result<Option<TrimLoops>, Error> {
    let knots = [surface.knots_u(), surface.knots_v()];
    let radius = BALL * coverage.limit;
    if coverage.is_complete() || !(radius > 0.0 && radius.is_finite()) {
        return Ok(None);
    }
    let Some(lines) = grid_lines(surface, knots, radius) else { return Ok(None) };
    let columns = lines[1].len();
    let places = parallel::map(lines[0].len() * columns, |k| {
        Point3::from(surface.point(lines[0][k / columns], lines[1][k % columns]))
    });
    if is_closed(&places, columns, radius, seam) {
        return Ok(None);
    }
    let data: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
    let nearest = CloudIndex::new(&data)?.nearest_many(&places);
    let away: Vec<f64> = nearest.iter().map(|n| n.map_or(f64::INFINITY, |n| n.distance())).collect();
    let centres: Vec<Point3<f64>> =
        (0..places.len()).filter(|&k| away[k] > radius).map(|k| places[k]).collect();
    if centres.is_empty() || centres.len() == places.len() {
        return Ok(None);
    }
    // Distance from the balls: beyond their centres by more than the radius, but for a rim.
    let step = step_of(&places, columns);
    let reached = CloudIndex::new(&centres)?.nearest_many(&places);
    let clear = radius - RIM * step;
    let field: Vec<f64> = reached.iter().map(|n| n.map_or(f64::INFINITY, |n| n.distance()) - clear).collect();
    let found = contours(&lines, &field);
    let islands = if outliers { ISLAND } else { 0.0 };
    let Some(loops) = with_real_holes(found, &lines, (&away, coverage.limit), islands) else {
        return Ok(None);
    };
    let Ok(trim) = TrimLoops::new(loops) else { return Ok(None) };
    // Nothing that is near the surface may have lost it.
    let inside = trim.contains_grid(&lines[0], &lines[1]);
    let kept: Vec<Point3<f64>> = (0..places.len()).filter(|&k| inside[k]).map(|k| places[k]).collect();
    if kept.is_empty() {
        return Ok(None);
    }
    let back = CloudIndex::new(&kept)?.nearest_many(&data);
    let whole = CloudIndex::new(&places)?.nearest_many(&data);
    let lost = |k: usize| {
        let [now, before] = [back[k], whole[k]].map(|n| n.map_or(f64::INFINITY, |n| n.distance()));
        // What noise takes a point off the surface is no way along it.
        let along = (now * now - before * before).max(0.0).sqrt();
        now > coverage.limit && before <= coverage.limit && (along > radius || now.is_infinite())
    };
    let most = if outliers { STRAY * data.len() as f64 } else { 0.0 };
    let lost = (0..data.len()).filter(|&k| lost(k)).count();
    Ok((lost as f64 <= most).then_some(trim))
}

/// Parameters of the lines of a grid that is fine enough for balls of a radius; `None` if it would have too many places.
fn grid_lines(surface: &BsplineSurface, knots: [&KnotVector; 2], radius: f64) -> Option<[Vec<f64>; 2]> {
    let spans = knots.map(|k| k.spans().collect::<Vec<_>>());
    let lengths = span_lengths(surface, knots, &spans);
    let counts_for =
        |step: f64| lengths.clone().map(|l| l.into_iter().map(|l| count(l, step)).collect::<Vec<usize>>());
    let total =
        |counts: &[Vec<usize>; 2]| counts.iter().map(|c| c.iter().sum::<usize>() as f64).product::<f64>();
    let mut counts = counts_for(FINE * radius);
    if total(&counts) > MOST {
        let coarser = FINE * radius * (total(&counts) / MOST).sqrt();
        if coarser.is_nan() || coarser > COARSE * radius {
            return None;
        }
        counts = counts_for(coarser);
    }
    Some([0, 1].map(|d| {
        let mut lines = vec![knots[d].domain().start()];
        for (&span, &count) in spans[d].iter().zip(&counts[d]) {
            let interval = knots[d].span_interval(span);
            lines.extend((1..=count).map(|k| interval.lerp(k as f64 / count as f64)));
        }
        lines
    }))
}

/// Whether opposite edges of the grid lie on each other, but for those of a seam, or one is a point.
fn is_closed(places: &[Point3<f64>], columns: usize, radius: f64, seam: Option<Direction>) -> bool {
    let rows = places.len() / columns;
    let near = |a: usize, b: usize| (places[a] - places[b]).norm() <= radius;
    let edges = [
        seam != Some(Direction::U) && (0..columns).all(|j| near(j, (rows - 1) * columns + j)),
        seam != Some(Direction::V) && (0..rows).all(|i| near(i * columns, i * columns + columns - 1)),
        (0..columns).all(|j| near(0, j)),
        (0..columns).all(|j| near((rows - 1) * columns, (rows - 1) * columns + j)),
        (0..rows).all(|i| near(0, i * columns)),
        (0..rows).all(|i| near(columns - 1, i * columns + columns - 1)),
    ];
    edges.contains(&true)
}

/// Largest distance of neighbours in the grid.
fn step_of(places: &[Point3<f64>], columns: usize) -> f64 {
    let rows = places.len() / columns;
    let down = (0..(rows - 1) * columns).map(|k| (places[k + columns] - places[k]).norm());
    let across = (0..places.len()).filter(|k| (k + 1) % columns != 0);
    down.chain(across.map(|k| (places[k + 1] - places[k]).norm())).fold(0.0, f64::max)
}

/// The outer loop and those of holes in which a place is without data; `None` unless there is one outer loop but for islands of a share of its area.
fn with_real_holes(
    found: Vec<Vec<[f64; 2]>>,
    lines: &[Vec<f64>; 2],
    (away, limit): (&[f64], f64),
    islands: f64,
) -> Option<Vec<Vec<[f64; 2]>>> {
    let area = |vertices: &[[f64; 2]]| {
        let next = vertices.iter().cycle().skip(1);
        vertices.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>()
    };
    let (mut outer, mut holes): (Vec<_>, Vec<_>) =
        found.into_iter().partition(|vertices| area(vertices) > 0.0);
    let largest = outer.iter().map(|vertices| area(vertices)).fold(0.0, f64::max);
    outer.retain(|vertices| area(vertices) > islands * largest);
    let [outer] = <[Vec<[f64; 2]>; 1]>::try_from(outer).ok()?;
    let around = TrimLoops::new(vec![outer.clone()]).ok()?;
    holes.retain(|vertices| around.contains(vertices[0][0], vertices[0][1]));
    let is_real = |hole: &Vec<[f64; 2]>| {
        let Ok(alone) = TrimLoops::new(vec![hole.clone()]) else { return false };
        let inside = alone.contains_grid(&lines[0], &lines[1]);
        inside.iter().zip(away).any(|(inside, away)| *inside && *away > limit)
    };
    Some(std::iter::once(outer).chain(holes.into_iter().filter(is_real)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The square [0, 10]² in the plane z = 0.
    fn square() -> BsplineSurface {
        let knots = KnotVector::uniform_clamped(1, 3).unwrap();
        let place = |k: usize| Vector3::new(5.0 * (k / 3) as f64, 5.0 * (k % 3) as f64, 0.0);
        BsplineSurface::new(knots.clone(), knots, (0..9).map(place).collect(), None).unwrap()
    }

    fn trimmed(has: impl Fn(f64, f64) -> bool) -> (Option<TrimLoops>, SurfaceCoverage, Vec<Vector3<f64>>) {
        // Points .2 apart, scattered by a third of that.
        let scatter = |k: usize, step: f64| 0.07 * ((k as f64 * step).fract() - 0.5);
        let points: Vec<Vector3<f64>> = (0..51 * 51)
            .map(|k| {
                (0.2 * (k / 51) as f64 + scatter(k, 0.618_034), 0.2 * (k % 51) as f64 + scatter(k, 0.754_878))
            })
            .filter(|(x, y)| has(*x, *y))
            .map(|(x, y)| Vector3::new(x.clamp(0.0, 10.0), y.clamp(0.0, 10.0), 0.0))
            .collect();
        let coverage = SurfaceCoverage::of_surface(&square(), &points, 0.0, None).unwrap();
        (data_outline(&square(), &points, &coverage, false).unwrap(), coverage, points)
    }

    #[test]
    fn discs_and_concave_outlines_are_followed() {
        use std::f64::consts::PI;
        let disc = |x: f64, y: f64| (x - 5.0).hypot(y - 5.0) <= 4.5;
        let ell = |x: f64, y: f64| x <= 4.0 || y <= 4.0;
        let frame = |x: f64, y: f64| (x - 5.0).hypot(y - 4.5) >= 2.0;
        // Loops, and the area: that of the points and half a spacing about them, more or less.
        for (trim, loops, area) in [
            (trimmed(disc), 1, PI * 4.5 * 4.5),
            (trimmed(ell), 1, 64.0),
            (trimmed(frame), 2, 100.0 - PI * 4.0),
        ] {
            let (Some(found), whole, points) = trim else { panic!("no loop") };
            assert_eq!(found.loops().len(), loops);
            let parameters = found.area() * 100.0;
            assert!((parameters - area).abs() < 0.05 * area, "{parameters} {area}");
            let surface = square();
            assert!(!whole.is_complete());
            let own = SurfaceCoverage::of_trimmed(&surface, &found, &points, 0.0, None).unwrap();
            assert!(own.is_complete() && (own.area - parameters).abs() < 0.01 * area, "{own}");
            let outside = points.iter().filter(|p| !found.contains(p.x / 10.0, p.y / 10.0)).count();
            // Those on the last lines of the domain lie on the loop.
            assert!(25 * outside < points.len(), "{outside} of {}", points.len());
        }
    }

    #[test]
    fn a_tube_is_opened_where_its_data_end_at_a_slant() {
        use std::f64::consts::TAU;
        // Radius 2, height 10, cut off between 5 and 9.
        let knots =
            [KnotVector::uniform_periodic(3, 12).unwrap(), KnotVector::uniform_clamped(1, 2).unwrap()];
        let ring = |k: usize| TAU * (k % 12) as f64 / 12.0;
        let factor = 3.0 / (2.0 + (TAU / 12.0).cos());
        let place = |k: usize| {
            let (a, height) = (ring(k / 2), 10.0 * (k % 2) as f64);
            Vector3::new(2.0 * factor * a.cos(), 2.0 * factor * a.sin(), height)
        };
        let [u, v] = knots;
        let tube = BsplineSurface::new(u, v, (0..30).map(place).collect(), None).unwrap();
        let points: Vec<Vector3<f64>> = (0..60 * 50)
            .map(|k| (TAU * (k / 50) as f64 / 60.0, 0.2 * (k % 50) as f64))
            .filter(|(a, height)| *height <= 7.0 + 2.0 * a.cos())
            .map(|(a, height)| Vector3::new(2.0 * a.cos(), 2.0 * a.sin(), height))
            .collect();
        let whole = SurfaceCoverage::of_surface(&tube, &points, 0.0, None).unwrap();
        assert!(!whole.is_complete() && data_outline(&tube, &points, &whole, false).unwrap().is_none());
        let (opened, trim) = opened_with_outline(&tube, &points, &whole, false).unwrap().unwrap();
        assert!(!opened.knots_u().is_periodic() && trim.loops().len() == 1);
        let piece = SurfaceCoverage::of_trimmed(&opened, &trim, &points, 0.0, None).unwrap();
        let area = TAU * 2.0 * 7.0;
        assert!(piece.is_complete() && (piece.area - area).abs() < 0.05 * area, "{piece}");
        // A closed ring that is missing somewhere has a seam beside its gap, if any of a few is there.
        let half: Vec<Vector3<f64>> = points.iter().filter(|p| p.x < 1.0).copied().collect();
        let whole = SurfaceCoverage::of_surface(&tube, &half, 0.0, None).unwrap();
        let (opened, trim) = opened_with_outline(&tube, &half, &whole, false).unwrap().unwrap();
        assert!(SurfaceCoverage::of_trimmed(&opened, &trim, &half, 0.0, None).unwrap().is_complete());
    }

    #[test]
    fn whole_surfaces_and_parts_have_no_loop() {
        assert!(trimmed(|_, _| true).0.is_none());
        assert!(trimmed(|x, _| !(4.0..6.0).contains(&x)).0.is_none());
    }
}
