//! The distance from the zero set of a function that is known on a grid.

use super::contour::{self, Saddles};
use super::foot::{Foot, ZeroSet};
use super::grid::Grid;
use super::spline::GridSpline;
use crate::local_geometry::{of_plane_normal, of_tensor};
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search};
use footpoint::Status;
use mesh_core::{CloudIndex, Polyline};
use nalgebra::{Point, SMatrix, SVector, Vector2, Vector3};
use nurbs_core::Aabb;

/// Crossings from which a foot is looked for where the nearest one does not lead to it.
const SEEDS: usize = 6;

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

impl LevelSetField<2> {
    /// The zero set of a function in the plane.
    ///
    /// # Errors
    /// [`Error::NoPoints`] when the values do not change their sign.
    pub fn new(grid: &Grid<2>) -> Result<Self, Error> {
        Self::with_saddles(grid, Saddles::Middle)
    }

    /// The same, with a choice of what is connected where the corners of a cell differ crosswise.
    ///
    /// # Errors
    /// As for [`LevelSetField::new`].
    pub fn with_saddles(grid: &Grid<2>, saddles: Saddles) -> Result<Self, Error> {
        Self::with_detail(grid, saddles, 1)
    }

    /// The same, traced on a lattice with `detail` cells along each side of a cell of the grid: parts of the zero set that enter and leave
    /// through one side of a cell are seen from a width of that share of it on. The function is the same.
    ///
    /// # Errors
    /// As for [`LevelSetField::new`]; [`Error::Grid`] for a lattice with more nodes than there are numbers.
    pub fn with_detail(grid: &Grid<2>, saddles: Saddles, detail: usize) -> Result<Self, Error> {
        let spline = GridSpline::new(grid);
        let ratio = detail.max(1) as f64;
        let at = |place: &SVector<f64, 2>| spline.taylor(&(place / ratio)).value;
        let lattice = if detail > 1 {
            let [m, n] = grid.counts().map(|count| (count - 1).saturating_mul(detail).saturating_add(1));
            let (counts, nodes) = ([m, n], m.checked_mul(n));
            let nodes = nodes.ok_or_else(|| Error::Grid { what: format!("{m} x {n} nodes are too many") })?;
            let values =
                crate::parallel::map(nodes, |node| at(&Vector2::new((node / n) as f64, (node % n) as f64)));
            Grid::new(*grid.origin(), grid.spacing() / ratio, counts, values)?
        } else {
            grid.clone()
        };
        let traced = contour::trace(&lattice, &at, saddles);
        let (crossings, jump) = contour::crossings(&lattice, &at);
        let crossings = crossings.iter().map(|place| place / ratio).collect();
        let mut field = Self::prepare(grid, spline, crossings, jump)?;
        let polyline = |(places, closed): (Vec<SVector<f64, 2>>, bool)| {
            let vertices = places.iter().map(|place| Point::from(grid.point(&(place / ratio)))).collect();
            Polyline::new(vertices, closed)
        };
        field.contours = traced.into_iter().map(polyline).collect::<Result<_, _>>()?;
        field.contours.sort_by(|a, b| b.length().total_cmp(&a.length()));
        Ok(field)
    }

    /// The curves of the zero set as polylines with a vertex on each line of the grid (of the lattice on which they are traced) that they
    /// cross, the longest first. Those that end do so at the border of the grid. The function is negative on their left.
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
        let spline = GridSpline::new(grid);
        let (crossings, jump) = contour::crossings(grid, &|place| spline.taylor(place).value);
        Self::prepare(grid, spline, crossings, jump)
    }
}

impl<const D: usize> LevelSetField<D> {
    fn prepare(
        grid: &Grid<D>,
        spline: GridSpline<D>,
        crossings: Vec<SVector<f64, D>>,
        jump: f64,
    ) -> Result<Self, Error> {
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

    /// Value, gradient and Hessian of the spline at a point, by the coordinates; outside the grid those of the nearest point
    /// inside.
    #[must_use]
    pub fn taylor(&self, x: &SVector<f64, D>) -> (f64, SVector<f64, D>, SMatrix<f64, D, D>) {
        let taylor = self.zero_set().taylor(&self.grid.place(x));
        (taylor.value, taylor.gradient, taylor.hessian)
    }

    fn zero_set(&self) -> ZeroSet<'_, D> {
        let longest = self.grid.spacing().min();
        let size = self.bounds.sides().amax() + longest;
        ZeroSet { grid: &self.grid, spline: &self.spline, jump: self.jump, size }
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
        let set = self.zero_set();
        let mut foot = set.foot(x, seed);
        let mut point = self.grid.point(&foot.place);
        let is_astray = |foot: &Foot<D>, point: &SVector<f64, D>| {
            !foot.status.is_converged() || (x - point).norm() > nearest.distance() * (1.0 + 1e-12)
        };
        if is_astray(&foot, &point) {
            // The crossing itself is on the zero set, and nearer; from there, and from those around it, by short steps.
            let on_border = foot.status == Status::OnBoundary;
            let around = self.index.nearest_n(&Point::from(x - self.grid.origin()), SEEDS);
            let places = around.iter().map(|near| set.nearer(x, &self.crossings[near.index]));
            let far = |place: &SVector<f64, D>| (x - self.grid.point(place)).norm();
            let place = places.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(*seed);
            let again = set.foot(x, &place);
            let there = self.grid.point(&again.place);
            if again.status.is_converged() && (x - there).norm() <= far(&place) * (1.0 + 1e-12) {
                (foot, point) = (again, there);
            } else {
                let status = if on_border { Status::OnBoundary } else { Status::Stalled };
                (foot, point) = (Foot { place, taylor: set.taylor(&place), status }, self.grid.point(&place));
            }
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

/// Curvature of a level set at its foot from that at a distance, along the same normal: offsets have a common centre of curvature.
fn at_foot(curvature: f64, distance: f64) -> f64 {
    let factor = 1.0 + distance * curvature;
    // At the centre of curvature the foot is a point.
    if factor.abs() > f64::EPSILON { curvature / factor } else { 0.0 }
}

/// Foot, unit normal, distance, and minus the Hessian as a share of the gradient, of a signed distance function at a point.
type LocalValues<const D: usize> = (SVector<f64, D>, SVector<f64, D>, f64, SMatrix<f64, D, D>);

impl<const D: usize> LevelSetField<D> {
    fn local_values(&self, x: &SVector<f64, D>) -> Option<LocalValues<D>> {
        if !x.iter().all(|c| c.is_finite()) {
            return None;
        }
        let (value, gradient, hessian) = self.taylor(x);
        let slope = gradient.norm();
        let (normal, distance) = (gradient / slope, value / slope);
        let is_regular = distance.is_finite() && normal.iter().all(|c| c.is_finite());
        is_regular.then(|| (x - normal * distance, normal, distance, hessian * (-1.0 / slope)))
    }
}

impl LevelSetField<2> {
    /// The frame at a point from value, gradient and Hessian of the function there alone, without a search for the foot
    /// (\[P05, sec. 4.6\]).
    ///
    /// `foot = x − (f/|∇f|) n`, and `d/(d − ρ)` is the curvature of the level set through `x` times `d`. Exact up to the error of the
    /// spline where `f` is a signed distance; elsewhere of first order in the distance. Unusable
    /// ([`Status::Stalled`]) where the gradient vanishes.
    #[must_use]
    pub fn frame_from_values(&self, x: &Vector2<f64>) -> PrincipalFrame<2> {
        let Some((foot, normal, distance, tensor)) = self.local_values(x) else {
            return PrincipalFrame::invalid(Status::Stalled);
        };
        let geometry = of_plane_normal(&tensor, &normal, distance);
        frame_of(foot, geometry.axes, geometry.curvatures, distance)
    }
}

impl LevelSetField<3> {
    /// As in the plane.
    #[must_use]
    pub fn frame_from_values(&self, x: &Vector3<f64>) -> PrincipalFrame<3> {
        let Some((foot, normal, distance, tensor)) = self.local_values(x) else {
            return PrincipalFrame::invalid(Status::Stalled);
        };
        let geometry = of_tensor(&tensor, &normal, distance);
        frame_of(foot, geometry.axes, geometry.curvatures, distance)
    }
}

fn frame_of<const D: usize>(
    foot: SVector<f64, D>,
    axes: SMatrix<f64, D, D>,
    mut curvatures: SVector<f64, D>,
    distance: f64,
) -> PrincipalFrame<D> {
    for curvature in curvatures.iter_mut().take(D - 1) {
        *curvature = at_foot(*curvature, distance);
    }
    PrincipalFrame {
        foot,
        axes,
        curvatures,
        tangent_dimension: D - 1,
        distance,
        on_boundary: false,
        hint: Hint::NONE,
        status: Status::Converged,
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
