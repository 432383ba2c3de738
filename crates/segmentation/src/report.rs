//! What a segmentation found.

use nalgebra::{Point3, Vector3};

/// The surface that carries a region, in the coordinates of the input; directions have length 1, angles are in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// A plane through a point.
    Plane {
        /// Middle of the region's points, moved onto the plane.
        point: Point3<f64>,
        /// Unit normal, its largest component positive.
        normal: Vector3<f64>,
    },
    /// A circular cylinder.
    Cylinder {
        /// Point of the axis next to the middle of the region.
        point: Point3<f64>,
        /// Direction of the axis.
        axis: Vector3<f64>,
        /// Radius.
        radius: f64,
    },
    /// A circular cone.
    Cone {
        /// The apex.
        point: Point3<f64>,
        /// Direction of the axis from the apex into the region.
        axis: Vector3<f64>,
        /// Angle between axis and generators.
        half_angle: f64,
    },
    /// A sphere.
    Sphere {
        /// Centre.
        point: Point3<f64>,
        /// Radius.
        radius: f64,
    },
    /// A torus.
    Torus {
        /// Centre.
        point: Point3<f64>,
        /// Direction of the axis.
        axis: Vector3<f64>,
        /// Radius of the circle of the tube's centres.
        radius: f64,
        /// Radius of the tube.
        minor_radius: f64,
    },
    /// A curve moved along a direction.
    Extrusion {
        /// The direction.
        axis: Vector3<f64>,
    },
    /// A curve turned about an axis.
    Revolution {
        /// Point of the axis next to the middle of the region.
        point: Point3<f64>,
        /// Direction of the axis.
        axis: Vector3<f64>,
    },
    /// A curve moved by a helical motion.
    Helix {
        /// Point of the axis next to the middle of the region.
        point: Point3<f64>,
        /// Direction of the axis.
        axis: Vector3<f64>,
        /// Advance per turn, positive for right-handed motions.
        pitch: f64,
    },
    /// A smooth surface of none of the other types.
    Freeform,
}

impl Shape {
    /// Name of the type, in lower case.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Plane { .. } => "plane",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Sphere { .. } => "sphere",
            Self::Torus { .. } => "torus",
            Self::Extrusion { .. } => "extrusion",
            Self::Revolution { .. } => "revolution",
            Self::Helix { .. } => "helix",
            Self::Freeform => "freeform",
        }
    }
}

/// The best type that was not taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunnerUp {
    /// Name of the type, as in [`Shape::name`].
    pub name: &'static str,
    /// Its χ² per degree of freedom.
    pub chi2: f64,
}

/// One region.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionReport {
    /// The label of its points.
    pub label: u32,
    /// The surface that carries it.
    pub shape: Shape,
    /// Covariance of the unknowns of the fit, by rows: for the noise of the cloud, and for points next to the borders that belong to the
    /// neighbours as well; empty for swept and free-form regions and where the
    /// points leave an unknown open.
    ///
    /// The unknowns, with `e`, `f` two directions perpendicular to each other and to the axis, and the reference point next to the middle
    /// of the region: plane: shift along the normal, tilts towards `e`, `f`; sphere: centre, radius; cylinder: shifts along `e`, `f`,
    /// tilts, radius; cone: the same with the radius at the reference point, then the half angle; torus: centre, tilts, both radii.
    pub covariance: Vec<Vec<f64>>,
    /// Root mean square of the orthogonal distances over the degrees of freedom, away from the border of the region.
    pub rms: f64,
    /// Number of points.
    pub support: usize,
    /// χ² of the orthogonal distances per degree of freedom, `(rms/σ)²`: near 1 where the carrier explains the points.
    pub chi2: f64,
    /// The best type that was not taken, if another was tried.
    pub runner_up: Option<RunnerUp>,
}

/// A segmented cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmentation {
    /// Label of every point in the order of the input; `None` where no carrier explains the point.
    pub labels: Vec<Option<u32>>,
    /// The regions, that of label `k` at place `k`; the largest first.
    pub regions: Vec<RegionReport>,
    /// Standard deviation of the noise that was found or given. No less than 3e-4 of the spacing, below which nothing is told apart.
    pub sigma: f64,
    /// Median spacing of the points.
    pub spacing: f64,
}

impl Segmentation {
    /// Number of points without a region.
    #[must_use]
    pub fn unlabelled(&self) -> usize {
        self.labels.iter().filter(|label| label.is_none()).count()
    }
}

impl std::fmt::Display for Segmentation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} regions of {} points, {} points without a region, noise {:.4e}",
            self.regions.len(),
            self.labels.len(),
            self.unlabelled(),
            self.sigma
        )
    }
}
