//! Hidden point removal: which points of a cloud can be seen from a place, without a surface.

use crate::{ConvexHull, Error};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Slope, depth over width, by which a point must lie behind all of its neighbours to be a pit.
const PIT: f64 = 0.2;

/// Where a cloud is looked at from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum View {
    /// From a point.
    From(Vector3<f64>),
    /// From infinitely far away, in a direction of sight.
    Along(Vector3<f64>),
}

/// How far a point may stand back behind its neighbours and yet be visible.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Sharpness {
    /// From the density of the cloud as it is seen: with `s` the spacing of the points as a share of the diagonal of the cloud, a
    /// change of slope by this number over `√s` is still followed within one spacing. The default is `Automatic(0.72)`.
    ///
    /// The radius of the sphere grows with the number of points, as it must: small ones hide the bottom of grooves, large
    /// ones let the eye through the gaps between points. The power of `s` keeps these two errors about equal from thousands of points
    /// to millions. Points seen through gaps are recognised, too.
    Automatic(f64),
    /// The radius of the sphere as a multiple of the largest distance from the view point (\[KTB07\]; \[MPK\] use 10^2.5), and
    /// nothing else: all points of the hull are visible. For a view along a direction this stands for a view from as far away as the cloud is large.
    Radius(f64),
}

impl Default for Sharpness {
    fn default() -> Self {
        Self::Automatic(0.72)
    }
}

/// The points that are visible.
#[derive(Clone, Debug, PartialEq)]
pub struct Visibility {
    /// For each point whether it is visible; points that are not finite are not.
    pub visible: Vec<bool>,
    /// Radius of the sphere as a multiple of the largest distance from the view point; for a view along a direction that
    /// which has the same effect seen from as far away as the cloud is large.
    pub radius: f64,
}

impl Visibility {
    /// Number of visible points.
    #[must_use]
    pub fn count(&self) -> usize {
        self.visible.iter().filter(|&&v| v).count()
    }
}

/// The points of a cloud that can be seen, by the convex hull of the cloud reflected in a sphere (\[KTB07\]).
///
/// With `x` relative to the view point, `x ↦ x + 2 (R − |x|) x/|x|` turns the cloud inside out; what lies on the hull of
/// this and the view point is visible. For a view along a direction the limit of this map is used: up to a motion,
/// `(x, y, depth) ↦ (x, y, depth + K (x² + y²)/2)`, where the visible points are those of the lower hull and `K` is
/// `(2R − r)/r²` for a point at distance `r`.
///
/// Points that lie steeply behind all of their neighbours on the hull are seen through gaps between points of the cloud; they
/// count as hidden where the radius is automatic, so that a large one, which follows grooves, lets less through.
///
/// # Errors
/// [`Error::TooFewPoints`] without a finite point, [`Error::Option`] for a direction, view point or sharpness that is not
/// usable.
///
/// ```
/// use cloud_param::{Sharpness, View, visible_points};
/// use nalgebra::Vector3;
///
/// // Two layers: the upper one hides the lower one.
/// let points: Vec<_> = (0..800).map(|i| Vector3::new(f64::from(i % 20), f64::from(i / 20 % 20), f64::from(i / 400) * 15.0)).collect();
/// let seen = visible_points(&points, View::Along(-Vector3::z()), Sharpness::default())?;
/// assert!(seen.visible[400..].iter().all(|&v| v));
/// assert!(seen.visible[..400].iter().filter(|&&v| v).count() < 80);
/// # Ok::<(), cloud_param::Error>(())
/// ```
pub fn visible_points(
    points: &[Vector3<f64>],
    view: View,
    sharpness: Sharpness,
) -> Result<Visibility, Error> {
    let finite: Vec<usize> = (0..points.len()).filter(|&i| points[i].iter().all(|c| c.is_finite())).collect();
    if finite.is_empty() {
        return Err(Error::TooFewPoints { total: points.len(), usable: 0, needed: 1 });
    }
    let (Sharpness::Automatic(factor) | Sharpness::Radius(factor)) = sharpness;
    if !(factor > 0.0 && factor.is_finite()) {
        return Err(Error::Option { name: "sharpness", value: factor, allowed: "a positive number" });
    }
    let (View::From(vector) | View::Along(vector)) = view;
    if !vector.iter().all(|c| c.is_finite()) {
        return Err(Error::Option { name: "view", value: f64::NAN, allowed: "finite" });
    }
    let relevant: Vec<Vector3<f64>> = finite.iter().map(|&i| points[i]).collect();
    let (seen, radius) = match view {
        View::From(eye) => from_point(&relevant, &eye, sharpness)?,
        View::Along(direction) => along(&relevant, &direction, sharpness)?,
    };
    let mut visible = vec![false; points.len()];
    for index in seen {
        visible[finite[index as usize]] = true;
    }
    Ok(Visibility { visible, radius })
}

fn from_point(
    points: &[Vector3<f64>],
    eye: &Vector3<f64>,
    sharpness: Sharpness,
) -> Result<(Vec<u32>, f64), Error> {
    let mut relative: Vec<Vector3<f64>> = points.iter().map(|p| p - eye).collect();
    let farthest = relative.iter().map(Vector3::norm).fold(0.0, f64::max);
    if farthest == 0.0 {
        return Ok((Vec::new(), 1.0));
    }
    let radius = match sharpness {
        Sharpness::Radius(factor) => factor.max(1.0) * farthest,
        Sharpness::Automatic(change) => {
            // Directions as places on the cylinder of the same area: azimuth, from the middle of the cloud, and height.
            let middle = relative.iter().sum::<Vector3<f64>>() / relative.len() as f64;
            let ahead = middle.try_normalize(0.0).unwrap_or_else(Vector3::x);
            let up = ahead.cross(&Vector3::ith(ahead.iamin(), 1.0)).normalize();
            let left = up.cross(&ahead);
            let map = |p: &Vector3<f64>| {
                let norm = p.norm().max(f64::MIN_POSITIVE);
                [p.dot(&left).atan2(p.dot(&ahead)) / TAU, p.dot(&up) / norm]
            };
            let (low, high) =
                relative.iter().fold((relative[0], relative[0]), |(l, h), p| (l.inf(p), h.sup(p)));
            let angle = spacing(&relative.iter().map(map).collect::<Vec<_>>()) * TAU.sqrt();
            let mut distances: Vec<f64> = relative.iter().map(Vector3::norm).collect();
            let middle = distances.len() / 2;
            let (_, &mut typical, _) = distances.select_nth_unstable_by(middle, f64::total_cmp);
            let change = followed(change, angle * typical / (high - low).norm().max(f64::MIN_POSITIVE));
            (0.5 * typical * (1.0 + change / angle)).max(farthest)
        }
    };
    for p in &mut relative {
        let norm = p.norm();
        if norm > 0.0 {
            *p *= (2.0 * radius - norm) / norm;
        }
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the hull refuses more points than 32 bits can number"
    )]
    let eye = relative.len() as u32;
    relative.push(Vector3::zeros());
    let hull = ConvexHull::new(&relative)?;
    let faces = hull.faces().iter().filter(|face| !face.contains(&eye));
    // Slopes in units of the distance: how much farther from the eye per angle.
    let rise = |i: u32, j: u32| {
        let (p, q) = (relative[i as usize], relative[j as usize]);
        let (a, b) = (2.0 * radius - p.norm(), 2.0 * radius - q.norm());
        (a - b) / (a.min(b).max(f64::MIN_POSITIVE) * p.normalize().cross(&q.normalize()).norm())
    };
    let mut seen = hull.vertices().to_vec();
    seen.retain(|&i| i != eye);
    if matches!(sharpness, Sharpness::Automatic(_)) {
        let pits = pits(faces, &rise, relative.len());
        seen.retain(|&i| !pits[i as usize]);
    }
    Ok((seen, radius / farthest))
}

/// Vertices that lie deep behind all vertices around them: seen through gaps between points, not through openings.
fn pits<'a>(
    faces: impl Iterator<Item = &'a [u32; 3]>,
    rise: &dyn Fn(u32, u32) -> f64,
    count: usize,
) -> Vec<bool> {
    let mut least = vec![f64::INFINITY; count];
    for face in faces {
        for k in 0..3 {
            let (i, j) = (face[k], face[(k + 1) % 3]);
            least[i as usize] = least[i as usize].min(rise(i, j));
        }
    }
    least.into_iter().map(|slope| slope > PIT && slope < f64::INFINITY).collect()
}

fn along(
    points: &[Vector3<f64>],
    direction: &Vector3<f64>,
    sharpness: Sharpness,
) -> Result<(Vec<u32>, f64), Error> {
    let Some(sight) = direction.try_normalize(0.0) else {
        return Err(Error::Option { name: "view", value: 0.0, allowed: "a direction of positive length" });
    };
    let right = sight.cross(&Vector3::ith(sight.iamin(), 1.0)).normalize();
    let up = right.cross(&sight);
    let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let (centre, size) = ((low + high) / 2.0, (high - low).norm());
    if size == 0.0 {
        return Ok(((0u32..).take(points.len()).collect(), 1.0));
    }
    let seen_at: Vec<Vector3<f64>> = points
        .iter()
        .map(|p| p - centre)
        .map(|p| Vector3::new(p.dot(&right), p.dot(&up), p.dot(&sight)) / size)
        .collect();
    let curvature = match sharpness {
        Sharpness::Radius(factor) => 2.0 * factor.max(1.0) - 1.0,
        Sharpness::Automatic(change) => {
            let spacing = spacing(&seen_at.iter().map(|p| [p.x, p.y]).collect::<Vec<_>>());
            followed(change, spacing) / spacing
        }
    };
    // The depth is scaled down instead of the rest up, so that coordinates keep their size.
    let lift = |p: &Vector3<f64>| Vector3::new(p.x, p.y, p.z / curvature + 0.5 * (p.x * p.x + p.y * p.y));
    let mut lifted: Vec<Vector3<f64>> = seen_at.iter().map(lift).collect();
    // A point far behind closes the hull, whose lower side is then all of what is not joined to it.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the hull refuses more points than 32 bits can number"
    )]
    let behind = lifted.len() as u32;
    lifted.push(Vector3::new(0.0, 0.0, 1e6));
    let hull = ConvexHull::new(&lifted)?;
    let mut seen = hull.vertices().to_vec();
    if hull.dimension() == 3 {
        let faces = || hull.faces().iter().filter(|face| !face.contains(&behind));
        let rise = |i: u32, j: u32| {
            let d = seen_at[i as usize] - seen_at[j as usize];
            d.z / d.xy().norm()
        };
        seen = faces().flatten().copied().collect();
        seen.sort_unstable();
        seen.dedup();
        if matches!(sharpness, Sharpness::Automatic(_)) {
            let pits = pits(faces(), &rise, lifted.len());
            seen.retain(|&i| !pits[i as usize]);
        }
    }
    seen.retain(|&i| i != behind);
    Ok((seen, 0.5 * (curvature + 1.0)))
}

/// The change of slope that is followed within one spacing, which is given as a share of the diagonal.
fn followed(change: f64, spacing: f64) -> f64 {
    change / spacing.clamp(1e-6, 1.0).sqrt()
}

/// Side of the square that one of two layers of points has to itself, by counting the cells of a grid that are occupied.
fn spacing(places: &[[f64; 2]]) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in places {
        for axis in 0..2 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    let sides = [high[0] - low[0], high[1] - low[1]];
    let longest = sides[0].max(sides[1]);
    if longest == 0.0 {
        return 1.0;
    }
    // Some 8 points per cell if the rectangle were full.
    let area = sides[0].max(0.01 * longest) * sides[1].max(0.01 * longest);
    let cell = (8.0 * area / places.len() as f64).sqrt().max(longest / 4096.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 4097 cells a side")]
    let index = |p: &[f64; 2], axis: usize| ((p[axis] - low[axis]) / cell) as usize;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 4097 cells a side")]
    let columns = (sides[1] / cell) as usize + 1;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 4097 cells a side")]
    let rows = (sides[0] / cell) as usize + 1;
    let mut occupied = vec![false; rows * columns];
    for p in places {
        occupied[index(p, 0) * columns + index(p, 1)] = true;
    }
    let cells = occupied.iter().filter(|&&o| o).count() as f64;
    (cells * cell * cell / (0.5 * places.len() as f64)).sqrt()
}
