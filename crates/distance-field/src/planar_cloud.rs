//! The distance from the curve that a cloud of points in the plane samples.

use crate::local_geometry::of_point;
use crate::osculating::frame_nearby;
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search, parallel};
use footpoint::Status;
use mesh_core::{CloudIndex, Neighbour};
use nalgebra::{Matrix2, Matrix3, Point2, Vector2, Vector3};
use nurbs_core::Aabb;

/// Points to which a parabola is fitted, beside the one it belongs to.
const NEIGHBOURS: usize = 8;
/// Squared thickness of a neighbourhood over its squared width above which it is no piece of a curve.
const FLAT: f64 = 0.1;
/// How far a foot may lie from the nearest point, in multiples of the spacing there, and at an end of the points.
const REACH: [f64; 2] = [2.0, 0.5];
/// Spacings on one side of a point without another point that make it an end.
const END_GAP: f64 = 4.0;

/// The distance from the curve that a cloud in the plane samples, such as a scan line of a two-dimensional laser scanner.
///
/// The nearest point stands for the curve around it: a parabola fitted to its neighbours, on which the foot lies. Where
/// the neighbours do not lie along a line, as at crossings and in scattered points, the point itself is the foot. Ends of
/// open curves and of gaps are recognised by a side without neighbours; feet there are
/// [`on_boundary`](PrincipalFrame::on_boundary). Normals, where given, tell the positive side; without them the sign of
/// a distance has no meaning. The error is that of the fitted parabolas, and of the noise of the cloud.
///
/// ```
/// use distance_field::{DistanceField, Hint, PlanarCloudField, Search};
/// use nalgebra::{Point2, Vector2};
///
/// let circle: Vec<_> = (0..200).map(|i| f64::from(i) * std::f64::consts::TAU / 200.0)
///     .map(|a| Point2::new(3.0 * a.cos(), 3.0 * a.sin())).collect();
/// let field = PlanarCloudField::new(&circle, None)?;
/// let frame = field.frame(&Vector2::new(1.0, 1.0), Search::Global, &Hint::NONE);
/// assert!((frame.distance.abs() - (3.0 - 2.0f64.sqrt())).abs() < 1e-6 && !frame.on_boundary);
/// # Ok::<(), distance_field::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct PlanarCloudField {
    /// Of the points relative to `centre`.
    index: CloudIndex<2>,
    centre: Vector2<f64>,
    points: Vec<Point2<f64>>,
    /// One per point.
    sites: Vec<Site>,
    bounds: Aabb<2>,
}

/// The curve around a point.
#[derive(Clone, Copy, Debug)]
struct Site {
    /// Unit normal; `None` where the neighbours do not lie along a line.
    normal: Option<Vector2<f64>>,
    /// Positive where the curve bends towards the normal.
    curvature: f64,
    /// Distance to the second nearest other point.
    spacing: f64,
    is_end: bool,
}

impl PlanarCloudField {
    /// The distance from a cloud; normals tell the positive side.
    ///
    /// # Errors
    /// [`Error::Mesh`] if there is not one normal per point; [`Error::NoPoints`] if no point is finite.
    pub fn new(points: &[Point2<f64>], normals: Option<&[Vector2<f64>]>) -> Result<Self, Error> {
        let finite = points.iter().map(|p| &p.coords).filter(|p| p.iter().all(|c| c.is_finite()));
        let bounds = Aabb::of_points(finite).ok_or(Error::NoPoints { count: points.len() })?;
        if let Some(found) = normals.map(<[_]>::len).filter(|found| *found != points.len()) {
            let (name, expected) = ("normals".to_owned(), points.len());
            return Err(mesh_core::Error::AttributeLength { name, found, expected }.into());
        }
        let centre = bounds.centre();
        let points: Vec<Point2<f64>> = points.iter().map(|p| p - centre).collect();
        let index = CloudIndex::new(&points)?;
        let sites = parallel::map(points.len(), |i| {
            let side = normals.map(|normals| &normals[i]);
            Site::new(&points, i, &index.nearest_n(&points[i], NEIGHBOURS + 1), side)
        });
        Ok(Self { index, centre, points, sites, bounds })
    }

    /// Number of points at which the cloud ends, or whose neighbours do not lie along a line.
    #[must_use]
    pub fn end_count(&self) -> usize {
        self.sites.iter().filter(|site| site.is_end).count()
    }
}

impl Site {
    fn new(points: &[Point2<f64>], i: usize, near: &[Neighbour], side: Option<&Vector2<f64>>) -> Self {
        let offsets: Vec<Vector2<f64>> =
            near.iter().filter(|n| n.distance_sq > 0.0).map(|n| points[n.index] - points[i]).collect();
        let spacing = offsets.get(1).or(offsets.first()).map_or(0.0, Vector2::norm);
        let alone = Self { normal: None, curvature: 0.0, spacing, is_end: true };
        let Some(tangent) = direction(&offsets) else { return alone };
        let across = Vector2::new(-tangent.y, tangent.x);
        let along: Vec<[f64; 2]> = offsets.iter().map(|d| [d.dot(&tangent), d.dot(&across)]).collect();
        let Some([slope, bend]) = parabola(&along) else { return alone };
        let length = slope.hypot(1.0);
        let normal = (across - tangent * slope) / length;
        let curvature = bend / length.powi(3);
        // An end has no neighbour on one side that is about as near as those on the other.
        let nearest = |sign: f64| {
            let side = along.iter().map(|d| sign * d[0]).filter(|s| *s > 0.0);
            side.fold(f64::INFINITY, f64::min)
        };
        let (one, other) = (nearest(1.0), nearest(-1.0));
        let is_end = one.max(other) > END_GAP * one.min(other).max(0.5 * spacing);
        let flip = side.is_some_and(|side| side.dot(&normal) < 0.0);
        let sign = if flip { -1.0 } else { 1.0 };
        Self { normal: Some(normal * sign), curvature: curvature * sign, spacing, is_end }
    }
}

/// The direction along which points around the origin lie, if they lie along one.
fn direction(offsets: &[Vector2<f64>]) -> Option<Vector2<f64>> {
    if offsets.len() < 2 {
        return None;
    }
    let size = offsets.iter().map(Vector2::norm).fold(0.0, f64::max);
    // With the origin itself, which is one of the points.
    let count = offsets.len() as f64 + 1.0;
    let mean = offsets.iter().sum::<Vector2<f64>>() / count / size;
    let mut spread = -mean * mean.transpose() * count;
    for offset in offsets {
        let offset = offset / size;
        spread += offset * offset.transpose();
    }
    let [xx, xy, yy] = [spread[(0, 0)], spread[(0, 1)], spread[(1, 1)]];
    let (half, radius) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    let (thin, wide) = ((half - radius).max(0.0), half + radius);
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    (thin <= FLAT * wide).then(|| Vector2::new(angle.cos(), angle.sin()))
}

/// Slope at 0 and second derivative of the parabola `h = a + b s + ½ c s²` of least squares through points and the origin;
/// of a line where three different places are too few for a parabola.
fn parabola(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let size = points.iter().map(|p| p[0].abs()).fold(0.0, f64::max);
    if size.is_nan() || size <= 0.0 {
        return None;
    }
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [s, h] in points.iter().map(|[s, h]| [s / size, h / size]).chain([[0.0, 0.0]]) {
        let row = Vector3::new(1.0, s, 0.5 * s * s);
        normal += row * row.transpose();
        right += row * h;
    }
    let solution = (points.len() > 2)
        .then(|| normal.cholesky().map(|factor| factor.solve(&right)))
        .flatten()
        .filter(|x| x.iter().all(|c| c.is_finite()));
    let solution = solution.or_else(|| {
        let line: Matrix2<f64> = normal.fixed_view::<2, 2>(0, 0).into_owned();
        line.cholesky().map(|factor| factor.solve(&right.xy())).map(|x| Vector3::new(x[0], x[1], 0.0))
    })?;
    Some([solution[1], solution[2] / size])
}

impl DistanceField<2> for PlanarCloudField {
    fn frame(&self, x: &Vector2<f64>, _: Search, _: &Hint) -> PrincipalFrame<2> {
        if !x.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(Status::InvalidPoint);
        }
        let x = x - self.centre;
        let Some(nearest) = self.index.nearest(&Point2::from(x)) else {
            return PrincipalFrame::invalid(Status::Diverged);
        };
        let (site, point) = (&self.sites[nearest.index], self.points[nearest.index].coords);
        let status = if site.is_end { Status::OnBoundary } else { Status::Converged };
        let at_point = PrincipalFrame {
            foot: point,
            on_boundary: site.is_end,
            hint: Hint::new(nearest.index, [0.0; 2]),
            ..PrincipalFrame::invalid(status)
        };
        let mut frame = if let Some(normal) = site.normal {
            let axes = Matrix2::from_columns(&[Vector2::new(normal.y, -normal.x), normal]);
            let curvatures = Vector2::new(site.curvature, 0.0);
            let smooth = PrincipalFrame { axes, curvatures, tangent_dimension: 1, distance: 0.0, ..at_point };
            frame_nearby(&smooth, &x, REACH[usize::from(site.is_end)] * site.spacing)
        } else {
            let geometry = of_point(&(x - point), None);
            PrincipalFrame { axes: geometry.axes, distance: geometry.distance, ..at_point }
        };
        frame.foot += self.centre;
        frame
    }

    fn bounding_box(&self) -> Aabb<2> {
        self.bounds
    }

    fn has_estimated_normals(&self) -> bool {
        true
    }
}
