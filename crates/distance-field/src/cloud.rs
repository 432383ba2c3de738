//! The distance from the surface that a dense cloud of points samples.

use crate::cloud_site::{Around, Site};
use crate::osculating::frame_nearby;
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search, parallel};
use footpoint::Status;
use mesh_core::{CloudIndex, CurvatureFrame, FrameOptions, Neighbour, estimate_frames, spatial_order};
use nalgebra::{Point3, Vector2, Vector3};
use nurbs_core::Aabb;

/// Points around one that tell whether the cloud goes on in all directions.
const RING: usize = 16;
/// Angle in radians without a neighbour that makes a point one of the border.
const BORDER_GAP: f64 = 2.2;
/// How far from a point, in multiples of the spacing there, a query may be for the point to bound the search.
const CLOSE: f64 = 2.0;
/// How far a foot may lie from the nearest point, in multiples of the spacing there.
const REACH: f64 = 2.0;

/// How the surface of a cloud is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CloudOptions {
    /// Number of points to which a quadric, or a plane, is fitted; default 24, at least 6.
    pub neighbours: usize,
    /// Whether curvatures are estimated (default) or tangent planes alone, which takes less time.
    pub curvature: bool,
}

impl Default for CloudOptions {
    fn default() -> Self {
        Self { neighbours: 24, curvature: true }
    }
}

impl CloudOptions {
    /// Sets the number of points to which a quadric is fitted.
    #[must_use]
    pub fn with_neighbours(self, neighbours: usize) -> Self {
        Self { neighbours, ..self }
    }

    /// Sets whether curvatures are estimated.
    #[must_use]
    pub fn with_curvature(self, curvature: bool) -> Self {
        Self { curvature, ..self }
    }
}

/// The distance from the surface that a dense cloud samples, signed by the normals.
///
/// The nearest point of the cloud stands for the surface around it: a quadric that is estimated once, on which the foot
/// lies. Meant for queries that are far from the surface compared with nothing but the spacing of the points; the error
/// is that of the estimated normals and curvatures, and of the noise of the cloud. Points at the border of an open cloud
/// are recognised by the largest angle without neighbours, and feet on them have
/// [`on_boundary`](PrincipalFrame::on_boundary). Hints shorten the search for the nearest point and do not change it.
///
/// ```
/// use distance_field::{CloudField, DistanceField, Hint, Search};
/// use nalgebra::{Point3, Vector3};
///
/// let grid: Vec<_> = (0..400u16).map(|i| Point3::new(f64::from(i % 20), f64::from(i / 20), 1.0)).collect();
/// let field = CloudField::new(&grid, None)?;
/// let frame = field.frame(&Vector3::new(7.3, 8.4, 3.0), Search::Global, &Hint::NONE);
/// assert!((frame.foot - Vector3::new(7.3, 8.4, 1.0)).norm() < 1e-9 && !frame.on_boundary);
/// assert!(field.frame(&Vector3::new(-3.0, 8.4, 1.0), Search::Global, &Hint::NONE).on_boundary);
/// # Ok::<(), distance_field::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct CloudField {
    /// Of the points relative to `centre`, as are the patches, in an order in which neighbours follow each other.
    index: CloudIndex<3>,
    centre: Vector3<f64>,
    /// The points; apart from the rest, since most that are looked at are not the nearest.
    points: Vec<Point3<f64>>,
    /// One per point.
    sites: Vec<Site>,
    bounds: Aabb<3>,
}

impl CloudField {
    /// The distance from a cloud, whose normals are estimated if not given, with the default options.
    ///
    /// # Errors
    /// [`Error::Mesh`] if there is not one normal per point; [`Error::NoPoints`] if no point is finite.
    pub fn new(points: &[Point3<f64>], normals: Option<&[Vector3<f64>]>) -> Result<Self, Error> {
        Self::with_options(points, normals, &CloudOptions::default())
    }

    /// The distance from a cloud. Given normals tell the positive side, and are used as they are if no curvature is
    /// estimated.
    ///
    /// # Errors
    /// As [`CloudField::new`], and [`Error::Mesh`] if `neighbours` is below 6.
    pub fn with_options(
        points: &[Point3<f64>],
        normals: Option<&[Vector3<f64>]>,
        options: &CloudOptions,
    ) -> Result<Self, Error> {
        let finite = points.iter().map(|p| &p.coords).filter(|p| p.iter().all(|c| c.is_finite()));
        let bounds = Aabb::of_points(finite).ok_or(Error::NoPoints { count: points.len() })?;
        // Relative to the centre: estimates square the coordinates.
        let centre = bounds.centre();
        let local: Vec<Point3<f64>> = points.iter().map(|p| p - centre).collect();
        let order = spatial_order(&local).unwrap_or_else(|| (0u32..).zip(&local).map(|(i, _)| i).collect());
        let local: Vec<Point3<f64>> = order.iter().map(|&i| local[i as usize]).collect();
        let normals = normals.map(|normals| sorted(normals, &order)).transpose()?;
        let index = CloudIndex::new(&local)?;
        let frames =
            FrameOptions { neighbours: options.neighbours, looked_at: RING, curvature: options.curvature };
        let (frames, around) =
            estimate_frames(&index, &local, normals.as_deref(), &frames, |i, near, frame| {
                let near = &near[..near.len().min(RING)];
                let border = frame.is_none_or(|frame| is_border(&local, i, near, frame));
                Around::new(near, border, frame.is_some())
            })?;
        let sites =
            frames.iter().zip(around).map(|(frame, around)| Site::new(around, frame.as_ref())).collect();
        Ok(Self { index, centre, points: local, sites, bounds })
    }

    /// Number of points at the border of the cloud, or where the neighbours span no surface.
    #[must_use]
    pub fn border_count(&self) -> usize {
        self.sites.iter().filter(|site| site.around.border).count()
    }
}

/// Values, one for each point, in the order of the points.
fn sorted(normals: &[Vector3<f64>], order: &[u32]) -> Result<Vec<Vector3<f64>>, Error> {
    if normals.len() != order.len() {
        let (name, found, expected) = ("normals".to_owned(), normals.len(), order.len());
        return Err(mesh_core::Error::AttributeLength { name, found, expected }.into());
    }
    Ok(order.iter().map(|&i| normals[i as usize]).collect())
}

/// Whether the neighbours leave a large angle of the tangent plane free.
fn is_border(points: &[Point3<f64>], i: usize, near: &[Neighbour], frame: &CurvatureFrame) -> bool {
    let [x, y] = frame.directions;
    let around = || {
        let others = near.iter().filter(|n| n.distance_sq > 0.0);
        others.map(|n| points[n.index] - points[i]).map(|d| Vector2::new(d.dot(&x), d.dot(&y)))
    };
    !surrounds(around()) && has_gap(around().map(|d| (turn(&d), d)).collect())
}

/// Whether vectors are so close to each other in direction that there is surely no gap; this takes no sorting.
fn surrounds(around: impl Iterator<Item = Vector2<f64>>) -> bool {
    let taken = around.fold(0u16, |taken, d| taken | 1 << sector(turn(&d)));
    // Five sectors one after the other take less than 2.04: if no four of them are empty, no gap is as wide as that of a border.
    (1..4).fold(taken, |filled, by| filled | taken.rotate_left(by)) == u16::MAX
}

/// One of 16 sectors of the plane, four per quadrant, by [`turn`].
fn sector(turn: f64) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the sector is the integer part of a number from 0 to 16"
    )]
    (((turn + 2.0) * 4.0) as u32).min(15)
}

/// Whether vectors, with their [`turn`], leave an angle of [`BORDER_GAP`] free.
fn has_gap(mut around: Vec<(f64, Vector2<f64>)>) -> bool {
    around.sort_by(|one, other| one.0.total_cmp(&other.0));
    let (Some(first), Some(last)) = (around.first(), around.last()) else { return true };
    let widest = BORDER_GAP.cos();
    // Up to half a turn the cosine tells the angle; `ahead` is 2 there.
    let wide = |ahead: f64, from: &Vector2<f64>, to: &Vector2<f64>| {
        ahead > 2.0 || from.dot(to) < widest * (from.norm_squared() * to.norm_squared()).sqrt()
    };
    around.len() == 1
        || wide(first.0 + 4.0 - last.0, &last.1, &first.1)
        || around.windows(2).any(|pair| wide(pair[1].0 - pair[0].0, &pair[0].1, &pair[1].1))
}

/// A number that grows with the angle of a vector from −2 to 2, by 2 in every half turn.
fn turn(d: &Vector2<f64>) -> f64 {
    let share = d.x / (d.x.abs() + d.y.abs());
    if d.y < 0.0 { share - 1.0 } else { 1.0 - share }
}

impl CloudField {
    /// The point nearest to `x`, which is relative to the centre; the search is shorter if one of the guesses is near.
    fn nearest(&self, x: &Vector3<f64>, guesses: [Option<usize>; 2]) -> Option<usize> {
        let away = |i: usize| (x - self.points[i].coords).norm();
        let mut near = guesses.into_iter().flatten().map(|i| (away(i), i));
        let near = near.next().map(|first| near.fold(first, |a, b| if b.0 < a.0 { b } else { a }));
        let close = near.and_then(|(distance, i)| {
            let around = &self.sites[i].around;
            let is_close = distance <= CLOSE * around.spacing;
            is_close.then(|| around.nearest(&self.points, x, distance)).flatten()
        });
        let guess = near.map(|(_, i)| i);
        close.or_else(|| self.index.nearest_near(&Point3::from(*x), guess).map(|near| near.index))
    }

    /// The frame of a query; which points may be near it does not change the frame.
    fn frame_from(&self, x: &Vector3<f64>, guesses: [Option<usize>; 2]) -> PrincipalFrame<3> {
        if !x.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(Status::InvalidPoint);
        }
        let x = x - self.centre;
        let Some(nearest) = self.nearest(&x, guesses) else {
            return PrincipalFrame::invalid(Status::Diverged);
        };
        let (site, point) = (&self.sites[nearest], self.points[nearest].coords);
        let (around, geometry) = (&site.around, site.geometry(&(x - point)));
        let at_point = PrincipalFrame {
            foot: point,
            axes: geometry.axes,
            curvatures: geometry.curvatures,
            tangent_dimension: geometry.tangent_dimension,
            distance: 0.0,
            on_boundary: around.border,
            hint: Hint::new(nearest, [0.0; 2]),
            status: if around.border { Status::OnBoundary } else { Status::Converged },
        };
        // At the border the foot does not leave the cloud.
        let reach = if around.border { 0.5 } else { REACH } * around.spacing;
        let mut frame = frame_nearby(&at_point, &x, reach);
        frame.foot += self.centre;
        frame
    }

    /// The point that a hint names, unless the search is global.
    fn hinted(&self, search: Search, hint: &Hint) -> Option<usize> {
        hint.element_below(self.sites.len()).filter(|_| search != Search::Global)
    }
}

impl DistanceField<3> for CloudField {
    fn frame(&self, x: &Vector3<f64>, search: Search, hint: &Hint) -> PrincipalFrame<3> {
        self.frame_from(x, [self.hinted(search, hint), None])
    }

    fn frames(&self, points: &[Vector3<f64>], search: Search, hints: &[Hint]) -> Vec<PrincipalFrame<3>> {
        // Queries that follow each other often are neighbours.
        parallel::map_with(
            points.len(),
            || None,
            |before, i| {
                let hinted = hints.get(i).and_then(|hint| self.hinted(search, hint));
                let frame = self.frame_from(&points[i], [hinted, *before]);
                *before = frame.hint.element_below(self.sites.len());
                frame
            },
        )
    }

    fn bounding_box(&self) -> Aabb<3> {
        self.bounds
    }

    fn has_estimated_normals(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sectors_and_sorted_angles_agree_on_gaps() {
        // Directions with a gap of known width after the last one, at every place of the circle.
        let (mut quick, mut sorted) = (0, 0);
        for step in 0..720u16 {
            let width = 0.51 + 3.0 * f64::from(step % 90) / 90.0;
            let first = f64::from(step) * 0.174_53;
            let covered = std::f64::consts::TAU - width;
            let around: Vec<Vector2<f64>> = (0..15u8)
                .map(|i| first + covered * f64::from(i) / 14.0)
                .map(|angle| Vector2::new(angle.cos(), angle.sin()) * (1.0 + angle.fract()))
                .collect();
            let gap = has_gap(around.iter().map(|d| (turn(d), *d)).collect());
            assert_eq!(gap, width > BORDER_GAP, "{width}");
            if surrounds(around.into_iter()) {
                assert!(!gap, "{width}");
                quick += 1;
            } else {
                sorted += 1;
            }
        }
        assert!(quick > 200 && sorted > 200, "{quick} {sorted}");
    }

    #[test]
    fn one_neighbour_or_none_leaves_a_gap() {
        assert!(!surrounds(std::iter::empty()) && has_gap(Vec::new()));
        let one = Vector2::new(1.0, 0.0);
        assert!(!surrounds(std::iter::once(one)) && has_gap(vec![(turn(&one), one)]));
    }
}
