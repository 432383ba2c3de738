//! The surface that moving least squares make of a cloud, and the distance from it.

mod jet;
mod reach;
mod sphere;

use crate::implicit::LagrangeStep;
use crate::local_geometry::{of_point, of_tensor};
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search};
use footpoint::Status;
use mesh_core::{CloudIndex, NormalOptions, estimate_normals};
use nalgebra::{Point3, Vector3};
use nurbs_core::Aabb;
use sphere::{Fit, Sample};

/// Limit of the iteration to a foot.
const MAX_STEPS: usize = 40;
/// Longest step, as a share of the reach of the nearest point.
const LONGEST: f64 = 0.5;
/// A residual, as a share of the reach and the distance, that counts as none.
const SETTLED: f64 = 1e-10;
/// How far the mean of the points may lie to the side, as a share of their reach. That of a half plane seen from its edge, with these
/// weights, lies at 0.2352: what lies further out is beyond the edge of the cloud.
const EDGE: f64 = 0.2352;

/// How a cloud is made a surface by moving least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MlsOptions {
    /// How far a point has weight, in multiples of the distance to its sixth neighbour; default 3, at least 1.5. The larger,
    /// the less is left of noise, and of details.
    pub reach: f64,
}

impl Default for MlsOptions {
    fn default() -> Self {
        Self { reach: 3.0 }
    }
}

impl MlsOptions {
    /// Sets how far a point has weight.
    #[must_use]
    pub fn with_reach(self, reach: f64) -> Self {
        Self { reach }
    }
}

/// The distance from the moving least squares surface of a cloud (algebraic point set surface, \[GG07\]), positive where the
/// normals point to.
///
/// At each place an algebraic sphere is fitted to the points around and their normals; the surface is where the place lies on its own
/// sphere. Noise is averaged over the points within [`reach`](MlsOptions::reach), spheres and planes are reproduced
/// exactly. A foot is the point of the surface that the method of Lagrange and Newton reaches from the nearest point of the cloud, with
/// exact first and second derivatives of the moving fit; it is not certified to be the nearest one. Beyond the edge of an open cloud
/// there is no surface: feet there are those of the nearest point of the cloud, [`on_boundary`](PrincipalFrame::on_boundary).
///
/// ```
/// use distance_field::{DistanceField, Hint, MlsField, Search};
/// use nalgebra::{Point3, Vector3};
///
/// // 2,000 points of a unit sphere, one percent off it.
/// let points: Vec<_> = (0..2000u32).map(|i| {
///     let (z, angle) = (1.0 - f64::from(2 * i + 1) / 2000.0, 2.399_963 * f64::from(i));
///     let (ring, size) = ((1.0 - z * z).sqrt(), 1.0 + 0.01 * (f64::from(i) * 1.7).sin());
///     Point3::from(Vector3::new(ring * angle.cos(), ring * angle.sin(), z) * size)
/// }).collect();
/// let field = MlsField::new(&points, None)?;
/// let frame = field.frame(&Vector3::new(0.0, 1.2, 0.9), Search::Global, &Hint::NONE);
/// assert!((frame.distance.abs() - 0.5).abs() < 3e-3);
/// # Ok::<(), distance_field::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct MlsField {
    /// Of the points relative to `centre`.
    index: CloudIndex<3>,
    centre: Vector3<f64>,
    points: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    /// One per point.
    reach: Vec<f64>,
    bounds: Aabb<3>,
}

/// A place on the surface.
struct Foot {
    place: Vector3<f64>,
    fit: Fit,
    status: Status,
}

impl MlsField {
    /// The surface of a cloud with the default options; normals that are not given are estimated and turned to one side.
    ///
    /// # Errors
    /// [`Error::Mesh`] if there is not one normal per point; [`Error::NoNormals`] if no normal has a direction and none can be
    /// estimated; [`Error::NoPoints`] if no point is finite.
    pub fn new(points: &[Point3<f64>], normals: Option<&[Vector3<f64>]>) -> Result<Self, Error> {
        Self::with_options(points, normals, &MlsOptions::default())
    }

    /// The surface of a cloud.
    ///
    /// # Errors
    /// As [`MlsField::new`], and [`Error::Option`] if the reach is below 1.5 or not finite.
    pub fn with_options(
        points: &[Point3<f64>],
        normals: Option<&[Vector3<f64>]>,
        options: &MlsOptions,
    ) -> Result<Self, Error> {
        if !(options.reach >= 1.5 && options.reach.is_finite()) {
            let what = "points have weight over at least 1.5 times the distance to their sixth neighbour";
            return Err(Error::Option { option: "reach", value: options.reach, what });
        }
        if let Some(normals) = normals.filter(|normals| normals.len() != points.len()) {
            let (name, found, expected) = ("normals".to_owned(), normals.len(), points.len());
            return Err(mesh_core::Error::AttributeLength { name, found, expected }.into());
        }
        let estimated;
        let normals = match normals {
            Some(normals) => normals,
            None => {
                estimated = estimate_normals(points, &NormalOptions::default())?.normals;
                &estimated[..]
            }
        };
        // Points without a direction take no part.
        let usable = |p: &Point3<f64>, n: &Vector3<f64>| {
            let length = n.norm();
            p.iter().all(|c| c.is_finite()) && length > 0.0 && length.is_finite()
        };
        let (kept, normals): (Vec<_>, Vec<_>) = points
            .iter()
            .zip(normals)
            .filter(|(p, n)| usable(p, n))
            .map(|(p, n)| (*p, n.normalize()))
            .unzip();
        if kept.is_empty() && points.iter().any(|p| p.iter().all(|c| c.is_finite())) {
            return Err(Error::NoNormals { count: points.len() });
        }
        let bounds =
            Aabb::of_points(kept.iter().map(|p| &p.coords)).ok_or(Error::NoPoints { count: points.len() })?;
        let centre = bounds.centre();
        let points: Vec<Point3<f64>> = kept.iter().map(|p| p - centre).collect();
        let index = CloudIndex::new(&points)?;
        let reach = reach::reaches(&index, &points, options.reach);
        Ok(Self { index, centre, points, normals, reach, bounds })
    }

    /// The function whose zero set is the surface, and its gradient: near the surface the distance from it to first order, positive
    /// where the normals point to. `None` where no points have weight.
    #[must_use]
    pub fn value(&self, x: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let place = x - self.centre;
        let nearest = self.index.nearest(&Point3::from(place))?;
        let Fit { taylor, .. } = self.fit(&place, nearest.index)?;
        Some((taylor.value, taylor.gradient))
    }

    /// On which side of the surface a point lies, as a number: [`value`](Self::value) where points have weight, elsewhere the distance
    /// of the nearest point with the sign of its normal. `None` for points that are not finite.
    #[must_use]
    pub fn side(&self, x: &Vector3<f64>) -> Option<f64> {
        let place = x - self.centre;
        let nearest = self.index.nearest(&Point3::from(place))?;
        if let Some(fit) = self.fit(&place, nearest.index) {
            return Some(fit.taylor.value);
        }
        let height = (place - self.points[nearest.index].coords).dot(&self.normals[nearest.index]);
        Some(nearest.distance().copysign(height))
    }

    /// Whether a point near the surface lies above it, and not beyond the edge of the cloud.
    #[must_use]
    pub fn covers(&self, x: &Vector3<f64>) -> bool {
        let place = x - self.centre;
        let nearest = self.index.nearest(&Point3::from(place));
        nearest.and_then(|near| self.fit(&place, near.index)).is_some_and(|fit| !Self::is_beyond(&fit))
    }

    /// The fit at a place, relative to the centre, with a point nearby.
    fn fit(&self, place: &Vector3<f64>, nearby: usize) -> Option<Fit> {
        let origin = self.points[nearby].coords;
        let away = (place - origin).norm();
        // The reach of no point that has weight here is larger, as it grows slowly.
        let growth = 2.0 * reach::GROWTH;
        let most = (self.reach[nearby] + growth * away) / (1.0 - growth);
        let samples = self.index.within(&Point3::from(*place), most);
        // Relative to a point of the surface: the fit takes differences of squares.
        sphere::fit(
            &(place - origin),
            samples.iter().map(|near| Sample {
                point: self.points[near.index].coords - origin,
                normal: self.normals[near.index],
                reach: self.reach[near.index],
            }),
        )
    }

    /// The foot to which Newton's method leads from a point of the cloud.
    fn foot(&self, x: &Vector3<f64>, start: usize) -> Option<Foot> {
        let longest = LONGEST * self.reach[start];
        let mut place = self.points[start].coords;
        let mut fit = self.fit(&place, start)?;
        for _ in 0..MAX_STEPS {
            let residual = x - place;
            let LagrangeStep { along, across, mut step, .. } = fit.taylor.lagrange_step(&residual);
            let length = step.norm();
            if !length.is_finite() {
                return Some(Foot { place, fit, status: Status::Stalled });
            }
            if along.norm().max(across.abs()) <= SETTLED * (self.reach[start] + residual.norm()) {
                return Some(Foot { place, fit, status: Status::Converged });
            }
            if length > longest {
                step *= longest / length;
            }
            let next = place + step;
            let nearby = self.index.nearest_near(&Point3::from(next), Some(start))?;
            let Some(found) = self.fit(&next, nearby.index) else {
                return Some(Foot { place, fit, status: Status::OnBoundary });
            };
            (place, fit) = (next, found);
        }
        Some(Foot { place, fit, status: Status::MaxIterations })
    }

    /// Whether a place lies beyond the edge of the cloud.
    fn is_beyond(fit: &Fit) -> bool {
        let normal = fit.taylor.gradient.normalize();
        (fit.offset - normal * normal.dot(&fit.offset)).norm() > EDGE
    }
}

impl DistanceField<3> for MlsField {
    fn frame(&self, x: &Vector3<f64>, _search: Search, hint: &Hint) -> PrincipalFrame<3> {
        if !x.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(Status::InvalidPoint);
        }
        let x = x - self.centre;
        let guess = hint.element_below(self.points.len());
        let Some(nearest) = self.index.nearest_near(&Point3::from(x), guess) else {
            return PrincipalFrame::invalid(Status::Diverged);
        };
        let start = nearest.index;
        let Some(mut foot) = self.foot(&x, start) else {
            return PrincipalFrame::invalid(Status::Stalled);
        };
        // Further away than the nearest point and what noise does to it: not the foot that was looked for.
        let is_astray = (x - foot.place).norm() > nearest.distance() + self.reach[start];
        if is_astray || Self::is_beyond(&foot.fit) || foot.status == Status::OnBoundary {
            let edge = self.points[start].coords;
            let Some(mut at_edge) = self.foot(&edge, start) else {
                return PrincipalFrame::invalid(Status::Stalled);
            };
            at_edge.status = if is_astray { Status::Stalled } else { Status::OnBoundary };
            foot = at_edge;
        }
        let normal = foot.fit.taylor.gradient.normalize();
        let residual = x - foot.place;
        let on_boundary = foot.status == Status::OnBoundary;
        let geometry = if on_boundary {
            of_point(&residual, Some(&normal))
        } else {
            of_tensor(&foot.fit.taylor.tensor(), &normal, residual.dot(&normal))
        };
        PrincipalFrame {
            foot: foot.place + self.centre,
            axes: geometry.axes,
            curvatures: geometry.curvatures,
            tangent_dimension: geometry.tangent_dimension,
            distance: geometry.distance,
            on_boundary,
            hint: Hint::new(start, [0.0; 2]),
            status: foot.status,
        }
    }

    fn bounding_box(&self) -> Aabb<3> {
        self.bounds
    }
}
