//! The distance from the zero set of a function that is known on a grid.

use super::contour;
use super::grid::Grid;
use super::spline::{GridSpline, Taylor};
use crate::local_geometry::{of_plane_normal, of_tensor};
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search};
use footpoint::Status;
use mesh_core::{CloudIndex, Polyline};
use nalgebra::{Point, SMatrix, SVector, Vector2, Vector3};
use nurbs_core::Aabb;

/// Limit of the iteration to a foot.
const MAX_STEPS: usize = 40;
/// Longest step, in cells: seeds are at most one cell from the feet that they lead to.
const LONGEST: f64 = 1.0;
/// A residual, as a share of the size of the grid, that counts as none.
const SETTLED: f64 = 1e-13;
/// Gradient, as a share of the largest value per cell, below which a point of the zero set is singular.
const SINGULAR: f64 = 1e-9;

/// The distance from the level set `f = 0` of a function on a grid, positive where `f` is.
///
/// `f` is the cubic spline through the values (fourth order in the spacing), so that the zero set is a smooth curve in the
/// plane or a smooth surface in space, sharper than the cells. It need not be a distance: any function whose gradient does
/// not vanish on its zero set will do. A foot is the point of the zero set that the method of Lagrange and Newton reaches
/// from the nearest crossing of the grid lines; its curvatures are those of the spline,
/// `κ = −tᵀ (∇²f) t / |∇f|`, so that `d²` is known to second order and the model `f² ≈ fᵀf` of a level set is not needed.
///
/// ```
/// use distance_field::{DistanceField, Grid, Hint, LevelSetField, Search};
/// use nalgebra::Vector2;
///
/// // An ellipse, by its equation.
/// let f = |p: &Vector2<f64>| (p.x / 2.0).powi(2) + p.y.powi(2) - 1.0;
/// let grid = Grid::sample(Vector2::new(-3.0, -2.0), Vector2::repeat(0.05), [121, 81], f)?;
/// let ellipse = LevelSetField::<2>::new(&grid)?;
/// let frame = ellipse.frame(&Vector2::new(2.5, 0.0), Search::Global, &Hint::NONE);
/// assert!((frame.distance - 0.5).abs() < 1e-9 && (frame.curvatures[0] + 2.0).abs() < 1e-6);
/// assert_eq!(ellipse.contours().len(), 1);
/// # Ok::<(), distance_field::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct LevelSetField<const D: usize> {
    grid: Grid<D>,
    spline: GridSpline<D>,
    /// Crossings of the grid lines with the zero set, in units of the spacing, and an index of their positions.
    crossings: Vec<SVector<f64, D>>,
    index: CloudIndex<D>,
    contours: Vec<Polyline<D>>,
    bounds: Aabb<D>,
    /// Largest jump of the values between neighbouring nodes.
    jump: f64,
}

/// A place on the zero set.
struct Foot<const D: usize> {
    place: SVector<f64, D>,
    taylor: Taylor<D>,
    status: Status,
}

impl LevelSetField<2> {
    /// The zero set of a function in the plane.
    ///
    /// # Errors
    /// [`Error::NoPoints`] when the values do not change their sign.
    pub fn new(grid: &Grid<2>) -> Result<Self, Error> {
        let mut field = Self::prepare(grid)?;
        let traced = contour::trace(grid, &field.spline);
        let polyline = |(places, closed): (Vec<SVector<f64, 2>>, bool)| {
            let vertices = places.iter().map(|place| Point::from(grid.point(place))).collect();
            Polyline::new(vertices, closed)
        };
        field.contours = traced.into_iter().map(polyline).collect::<Result<_, _>>()?;
        field.contours.sort_by(|a, b| b.length().total_cmp(&a.length()));
        Ok(field)
    }

    /// The curves of the zero set as polylines with a vertex on each grid line that they cross, the longest first. Those
    /// that end do so at the border of the grid. The function is negative on their left.
    #[must_use]
    pub fn contours(&self) -> &[Polyline<2>] {
        &self.contours
    }
}

impl LevelSetField<3> {
    /// The zero set of a function in space.
    ///
    /// # Errors
    /// [`Error::NoPoints`] when the values do not change their sign.
    pub fn new(grid: &Grid<3>) -> Result<Self, Error> {
        Self::prepare(grid)
    }
}

impl<const D: usize> LevelSetField<D> {
    fn prepare(grid: &Grid<D>) -> Result<Self, Error> {
        let spline = GridSpline::new(grid);
        let (crossings, jump) = contour::crossings(grid, &spline);
        let points: Vec<_> = crossings.iter().map(|place| grid.point(place)).collect();
        let bounds = Aabb::of_points(points.iter()).ok_or(Error::NoPoints { count: grid.values().len() })?;
        let centre = *grid.origin();
        let index = CloudIndex::new(&points.iter().map(|p| Point::from(p - centre)).collect::<Vec<_>>())?;
        let (grid, contours) = (grid.clone(), Vec::new());
        Ok(Self { grid, spline, crossings, index, contours, bounds, jump })
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// The value of the spline at a point; outside the grid that of the nearest point inside.
    #[must_use]
    pub fn value(&self, x: &SVector<f64, D>) -> f64 {
        self.spline.taylor(&self.grid.place(x)).value
    }

    /// Points of the zero set, one on each grid line between nodes where the sign changes: what the feet start from.
    pub fn crossings(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        self.crossings.iter().map(|place| self.grid.point(place))
    }

    /// Value and derivatives by the coordinates.
    fn taylor(&self, place: &SVector<f64, D>) -> Taylor<D> {
        let mut t = self.spline.taylor(place);
        let h = self.grid.spacing();
        t.gradient.component_div_assign(h);
        for i in 0..D {
            for j in 0..D {
                t.hessian[(i, j)] /= h[i] * h[j];
            }
        }
        t
    }

    /// Solves `min |x − y|²` subject to `f(y) = 0` by Newton's method on the equations of Lagrange, from a place nearby.
    fn foot(&self, x: &SVector<f64, D>, start: &SVector<f64, D>) -> Foot<D> {
        let mut place = *start;
        let counts = self.grid.counts();
        let longest = LONGEST * self.grid.spacing().min();
        let size = self.bounds.sides().amax() + longest;
        let mut taylor = self.taylor(&place);
        for _ in 0..MAX_STEPS {
            let slope = taylor.gradient.norm();
            // False for NaN too.
            let steep = slope * longest > SINGULAR * self.jump;
            if !steep {
                return Foot { place, taylor, status: Status::Stalled };
            }
            let normal = taylor.gradient / slope;
            let residual = x - self.grid.point(&place);
            let height = residual.dot(&normal);
            let across = -taylor.value / slope;
            let along = residual - normal * height;
            if along.norm().max(across.abs()) <= SETTLED * (size + residual.norm()) {
                return Foot { place, taylor, status: Status::Converged };
            }
            // Of the Hessian of the Lagrangian I + μ ∇²f, μ = height / |∇f|, only the tangent part counts; the normal part
            // of the step is that to the tangent plane of the level set.
            let tangent = SMatrix::<f64, D, D>::identity() - normal * normal.transpose();
            let bend = taylor.hessian * (height / slope);
            let matrix = tangent * (SMatrix::identity() + bend) * tangent + normal * normal.transpose();
            let right = along - tangent * (bend * normal) * across;
            // Beyond a centre of curvature there is no minimum to go to: then as on a plane.
            let step = matrix.cholesky().map_or(along, |factor| tangent * factor.solve(&right));
            let mut step = step + normal * across;
            let length = step.norm();
            if !length.is_finite() {
                return Foot { place, taylor, status: Status::Diverged };
            }
            if length > longest {
                step *= longest / length;
            }
            let target = place + step.component_div(self.grid.spacing());
            let next = SVector::from_fn(|d, _| target[d].clamp(0.0, (counts[d] - 1) as f64));
            if next == place {
                let on_border = next != target;
                let status = if on_border { Status::OnBoundary } else { Status::Converged };
                return Foot { place, taylor, status };
            }
            place = next;
            taylor = self.taylor(&place);
        }
        // At the border of the grid the iteration slides along it: the zero set ends there.
        let border = (0..D).any(|d| place[d] == 0.0 || place[d] == (counts[d] - 1) as f64);
        Foot { place, taylor, status: if border { Status::OnBoundary } else { Status::MaxIterations } }
    }

    fn frame_with(
        &self,
        x: &SVector<f64, D>,
        geometry: impl Fn(&SMatrix<f64, D, D>, &SVector<f64, D>, f64) -> (SMatrix<f64, D, D>, SVector<f64, D>),
    ) -> PrincipalFrame<D> {
        if !x.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(Status::InvalidPoint);
        }
        let Some(nearest) = self.index.nearest(&Point::from(x - self.grid.origin())) else {
            return PrincipalFrame::invalid(Status::Diverged);
        };
        let seed = &self.crossings[nearest.index];
        let mut foot = self.foot(x, seed);
        let mut point = self.grid.point(&foot.place);
        let known = self.grid.point(seed);
        if !foot.status.is_converged() || (x - point).norm() > nearest.distance() * (1.0 + 1e-12) {
            // Led astray: the crossing itself is on the zero set, and nearer.
            let status = if foot.status == Status::OnBoundary { foot.status } else { Status::Stalled };
            (foot, point) = (Foot { place: *seed, taylor: self.taylor(seed), status }, known);
        }
        let slope = foot.taylor.gradient.norm();
        let normal = foot.taylor.gradient / slope;
        if !normal.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(Status::Stalled);
        }
        let residual = x - point;
        let (axes, curvatures) =
            geometry(&(foot.taylor.hessian * (-1.0 / slope)), &normal, residual.dot(&normal));
        PrincipalFrame {
            foot: point,
            axes,
            curvatures,
            tangent_dimension: D - 1,
            distance: residual.dot(&normal),
            on_boundary: foot.status == Status::OnBoundary,
            hint: Hint::new(nearest.index, [0.0; 2]),
            status: foot.status,
        }
    }
}

impl DistanceField<2> for LevelSetField<2> {
    fn frame(&self, x: &Vector2<f64>, _search: Search, _hint: &Hint) -> PrincipalFrame<2> {
        self.frame_with(x, |tensor, normal, distance| {
            let geometry = of_plane_normal(tensor, normal, distance);
            (geometry.axes, geometry.curvatures)
        })
    }

    fn bounding_box(&self) -> Aabb<2> {
        self.bounds
    }
}

impl DistanceField<3> for LevelSetField<3> {
    fn frame(&self, x: &Vector3<f64>, _search: Search, _hint: &Hint) -> PrincipalFrame<3> {
        self.frame_with(x, |tensor, normal, distance| {
            let geometry = of_tensor(tensor, normal, distance);
            (geometry.axes, geometry.curvatures)
        })
    }

    fn bounding_box(&self) -> Aabb<3> {
        self.bounds
    }
}
