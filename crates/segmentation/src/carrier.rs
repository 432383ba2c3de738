//! The unbounded surfaces that carry regions, and orthogonal distances from them.

use nalgebra::{Point3, SVector, Vector3};

/// Most unknowns of a carrier.
pub(crate) const UNKNOWNS: usize = 7;
pub(crate) type Row = SVector<f64, UNKNOWNS>;

/// A surface of revolution or a plane, given by its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Carrier {
    Plane {
        point: Point3<f64>,
        normal: Vector3<f64>,
    },
    Sphere {
        centre: Point3<f64>,
        radius: f64,
    },
    Cylinder {
        point: Point3<f64>,
        axis: Vector3<f64>,
        radius: f64,
    },
    /// `radius` is that at `point`; it grows along the axis by the tangent of `angle`, which may be negative.
    Cone {
        point: Point3<f64>,
        axis: Vector3<f64>,
        radius: f64,
        angle: f64,
    },
    Torus {
        centre: Point3<f64>,
        axis: Vector3<f64>,
        radius: f64,
        minor: f64,
    },
}

/// Two unit vectors that make a right handed frame with a unit vector.
pub(crate) fn across(axis: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let k = axis.iamin();
    let one = axis.cross(&Vector3::ith(k, 1.0)).normalize();
    (one, axis.cross(&one))
}

/// Height along an axis, distance from it, and the direction away from it.
#[inline]
pub(crate) fn cylindrical(
    x: &Point3<f64>,
    point: &Point3<f64>,
    axis: &Vector3<f64>,
) -> (f64, f64, Vector3<f64>) {
    let d = x - point;
    let h = d.dot(axis);
    let radial = d - axis * h;
    let r = radial.norm();
    let u = if r > 0.0 { radial / r } else { across(axis).0 };
    (h, r, u)
}

impl Carrier {
    /// Number of unknowns.
    pub(crate) fn unknowns(&self) -> usize {
        match self {
            Self::Plane { .. } => 3,
            Self::Sphere { .. } => 4,
            Self::Cylinder { .. } => 5,
            Self::Cone { .. } => 6,
            Self::Torus { .. } => 7,
        }
    }

    /// Signed distance of a point and the unit normal at its foot (the gradient of the distance).
    pub(crate) fn at(&self, x: &Point3<f64>) -> (f64, Vector3<f64>) {
        match self {
            Self::Plane { point, normal } => ((x - point).dot(normal), *normal),
            Self::Sphere { centre, radius } => {
                let d = x - centre;
                let r = d.norm();
                (r - radius, if r > 0.0 { d / r } else { Vector3::x() })
            }
            Self::Cylinder { point, axis, radius } => {
                let (_, r, u) = cylindrical(x, point, axis);
                (r - radius, u)
            }
            Self::Cone { point, axis, radius, angle } => {
                let (h, r, u) = cylindrical(x, point, axis);
                let (s, c) = angle.sin_cos();
                // Beyond the apex the foot is the apex itself.
                let along = (r - radius) * s + h * c;
                let apex = -radius / s;
                if s != 0.0 && (along - apex) * s < 0.0 {
                    let q = u * r + axis * (h + radius * c / s);
                    let d = q.norm();
                    if d > 0.0 {
                        return (d, q / d);
                    }
                }
                ((r - radius) * c - h * s, u * c - axis * s)
            }
            Self::Torus { centre, axis, radius, minor } => {
                let (h, r, u) = cylindrical(x, centre, axis);
                let q = r - radius;
                let l = (q * q + h * h).sqrt();
                let n = if l > 0.0 { (u * q + axis * h) / l } else { u };
                (l - minor, n)
            }
        }
    }

    /// Signed distance and its derivatives by the unknowns of [`Carrier::moved`].
    pub(crate) fn linear(&self, x: &Point3<f64>) -> (f64, Row) {
        self.linearisation().at(x)
    }

    /// What the derivatives at all points have in common.
    pub(crate) fn linearisation(&self) -> Linearisation<'_> {
        let (axis, angle) = match self {
            Self::Sphere { .. } => (None, 0.0),
            Self::Plane { normal, .. } => (Some(normal), 0.0),
            Self::Cone { axis, angle, .. } => (Some(axis), *angle),
            Self::Cylinder { axis, .. } | Self::Torus { axis, .. } => (Some(axis), 0.0),
        };
        let across = axis.map_or_else(|| (Vector3::x(), Vector3::y()), across);
        Linearisation { carrier: self, across, turn: angle.sin_cos() }
    }

    /// The carrier after a step in its unknowns, its reference point moved along the axis next to a given point (where the
    /// unknowns depend on each other least). `None` if it is no proper carrier any more.
    pub(crate) fn moved(&self, step: &Row, near: &Point3<f64>) -> Option<Self> {
        let tilt = |axis: &Vector3<f64>, a: f64, b: f64| {
            let (e, f) = across(axis);
            (axis + e * a + f * b).normalize()
        };
        let new = match self {
            Self::Plane { point, normal } => {
                let turned = tilt(normal, step[1], step[2]);
                let point = point + normal * step[0];
                Self::Plane { point: near - turned * (near - point).dot(&turned), normal: turned }
            }
            Self::Sphere { centre, radius } => {
                Self::Sphere { centre: centre + step.fixed_rows::<3>(0), radius: radius + step[3] }
            }
            Self::Cylinder { point, axis, radius } => {
                let (e, f) = across(axis);
                let point = point + e * step[0] + f * step[1];
                let axis = tilt(axis, step[2], step[3]);
                let point = point + axis * (near - point).dot(&axis);
                Self::Cylinder { point, axis, radius: radius + step[4] }
            }
            Self::Cone { point, axis, radius, angle } => {
                let (e, f) = across(axis);
                let point = point + e * step[0] + f * step[1];
                let axis = tilt(axis, step[2], step[3]);
                let (radius, angle) = (radius + step[4], angle + step[5]);
                let h = (near - point).dot(&axis);
                Self::Cone { point: point + axis * h, axis, radius: radius + h * angle.tan(), angle }
            }
            Self::Torus { centre, axis, radius, minor } => Self::Torus {
                centre: centre + step.fixed_rows::<3>(0),
                axis: tilt(axis, step[3], step[4]),
                radius: radius + step[5],
                minor: minor + step[6],
            },
        };
        new.is_proper().then_some(new)
    }

    fn is_proper(&self) -> bool {
        match *self {
            Self::Plane { point, normal } => point.coords.sum().is_finite() && normal.sum().is_finite(),
            Self::Sphere { centre, radius } => centre.coords.sum().is_finite() && radius > 0.0,
            Self::Cylinder { point, axis, radius } => {
                (point.coords + axis).sum().is_finite() && radius > 0.0 && radius.is_finite()
            }
            Self::Cone { point, axis, radius, angle } => {
                (point.coords + axis).sum().is_finite()
                    && radius >= 0.0
                    && radius.is_finite()
                    && angle.abs() < STEEPEST
            }
            Self::Torus { centre, axis, radius, minor } => {
                (centre.coords + axis).sum().is_finite() && radius > 0.0 && minor > 0.0 && radius.is_finite()
            }
        }
    }

    /// Largest radius, infinite for a plane.
    pub(crate) fn size(&self) -> f64 {
        match *self {
            Self::Plane { .. } => f64::INFINITY,
            Self::Sphere { radius, .. } | Self::Cylinder { radius, .. } | Self::Cone { radius, .. } => radius,
            Self::Torus { radius, minor, .. } => radius.max(minor),
        }
    }
}

/// Half angle in radians beyond which a cone is a plane.
const STEEPEST: f64 = 1.553;

/// A carrier with what the derivatives of its distance have in common at all points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linearisation<'a> {
    carrier: &'a Carrier,
    /// Directions across the axis or normal.
    across: (Vector3<f64>, Vector3<f64>),
    /// Sine and cosine of the angle of a cone.
    turn: (f64, f64),
}

impl Linearisation<'_> {
    /// Signed distance and its derivatives by the unknowns of [`Carrier::moved`].
    #[inline(always)]
    pub(crate) fn at(&self, x: &Point3<f64>) -> (f64, Row) {
        let mut row = Row::zeros();
        let (e, f) = &self.across;
        match self.carrier {
            Carrier::Plane { point, normal } => {
                let d = x - point;
                row[0] = -1.0;
                row[1] = d.dot(e);
                row[2] = d.dot(f);
                (d.dot(normal), row)
            }
            Carrier::Sphere { .. } => {
                let (d, n) = self.carrier.at(x);
                row.fixed_rows_mut::<3>(0).copy_from(&-n);
                row[3] = -1.0;
                (d, row)
            }
            Carrier::Cylinder { point, axis, radius } => {
                let (h, r, u) = cylindrical(x, point, axis);
                row[0] = -u.dot(e);
                row[1] = -u.dot(f);
                row[2] = h * row[0];
                row[3] = h * row[1];
                row[4] = -1.0;
                (r - radius, row)
            }
            Carrier::Cone { point, axis, radius, .. } => {
                let (h, r, u) = cylindrical(x, point, axis);
                let (s, c) = self.turn;
                let (ue, uf) = (u.dot(e), u.dot(f));
                row[0] = -ue * c;
                row[1] = -uf * c;
                row[2] = -(h * c + r * s) * ue;
                row[3] = -(h * c + r * s) * uf;
                row[4] = -c;
                row[5] = -(r - radius) * s - h * c;
                ((r - radius) * c - h * s, row)
            }
            Carrier::Torus { centre, axis, radius, minor } => {
                let (h, r, u) = cylindrical(x, centre, axis);
                let q = r - radius;
                let l = (q * q + h * h).sqrt().max(f64::MIN_POSITIVE);
                let n = (u * q + axis * h) / l;
                let tilt = (h * r - q * h) / l;
                row.fixed_rows_mut::<3>(0).copy_from(&-n);
                row[3] = tilt * u.dot(e);
                row[4] = tilt * u.dot(f);
                row[5] = -q / l;
                row[6] = -1.0;
                (l - minor, row)
            }
        }
    }
}
