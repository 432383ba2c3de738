//! Evaluation, inversion and near feet of carriers.

use crate::Error;
use crate::description::Carrier;
use footpoint::{Mode, ProjectionOptions, SurfaceFootpoint, SurfaceProjector};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BezierPatch, BsplineSurface, Direction, Frame, ParametricSurface, SurfaceJet};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::OnceLock;

/// Share of the size of a B-spline surface below which its sides count as equal or as one point.
const CLOSED: f64 = 1e-7;

/// Share of a radius below which a point counts as one on the axis. Edges that end at a pole miss it by as much.
const ON_AXIS: f64 = 1e-7;

/// Distance from a B-spline surface, as a share of its size, up to which a point next to a known place is not searched for
/// elsewhere.
const FOLLOWED: f64 = 1e-6;

/// A point of the parameter plane; at a pole the first parameter means nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uv {
    pub(crate) at: Vector2<f64>,
    pub(crate) pole: bool,
}

/// A carrier that is ready to be evaluated and inverted.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    kind: Kind,
    /// Period of the parameters; a closed B-spline surface has the length of its domain.
    pub(crate) period: [Option<f64>; 2],
    /// Distance below which a point counts as the apex of a cone.
    small: f64,
}

#[derive(Clone, Debug)]
enum Kind {
    Plane(Frame),
    Cylinder { frame: Frame, radius: f64 },
    Cone { frame: Frame, radius: f64, slope: f64 },
    Sphere { frame: Frame, radius: f64 },
    Torus { frame: Frame, major: f64, minor: f64 },
    Spline(Box<Spline>),
}

/// A B-spline carrier.
#[derive(Clone, Debug)]
pub(crate) struct Spline {
    pub(crate) surface: BsplineSurface,
    pub(crate) projector: SurfaceProjector,
    /// Parameters `v` of the rows that are one point.
    poles_v: Vec<f64>,
    /// Parameters `u` of the columns that are one point.
    poles_u: Vec<f64>,
    /// Its Bézier patches, made when a line asks for them.
    patches: OnceLock<Vec<BezierPatch>>,
}

impl Surface {
    /// `size` is the size of the part.
    pub(crate) fn new(carrier: &Carrier, size: f64) -> Result<Self, Error> {
        let (kind, period) = match carrier {
            Carrier::Plane { frame } => (Kind::Plane(*frame), [None, None]),
            Carrier::Cylinder { frame, radius } => {
                let radius = positive("cylinder", *radius)?;
                (Kind::Cylinder { frame: *frame, radius }, [Some(TAU), None])
            }
            Carrier::Cone { frame, radius, half_angle } => {
                let slope = half_angle.tan();
                let steep = half_angle.abs() < FRAC_PI_2 && slope != 0.0 && slope.is_finite();
                if !(steep && *radius >= 0.0 && radius.is_finite()) {
                    let why = format!("radius {radius} and half angle {half_angle} make no cone");
                    return Err(Error::of("cone", why));
                }
                (Kind::Cone { frame: *frame, radius: *radius, slope }, [Some(TAU), None])
            }
            Carrier::Sphere { frame, radius } => {
                let radius = positive("sphere", *radius)?;
                (Kind::Sphere { frame: *frame, radius }, [Some(TAU), None])
            }
            Carrier::Torus { frame, major_radius, minor_radius } => {
                let minor = positive("torus", *minor_radius)?;
                if !major_radius.is_finite() {
                    return Err(Error::of("torus", format!("its major radius is {major_radius}")));
                }
                (Kind::Torus { frame: *frame, major: *major_radius, minor }, [Some(TAU), Some(TAU)])
            }
            Carrier::Nurbs(surface) => {
                let spline = Spline::new(surface)?;
                let size = spline.surface.control_box().diagonal();
                let [u, v] = spline.surface.domain();
                let closed = |direction| spline.surface.is_closed(direction, CLOSED * size);
                let why = |e: nurbs_core::Error| Error::of("B-spline surface", e);
                let period = [
                    closed(Direction::U).map_err(why)?.then(|| u.length()),
                    closed(Direction::V).map_err(why)?.then(|| v.length()),
                ];
                (Kind::Spline(Box::new(spline)), period)
            }
        };
        Ok(Self { kind, period, small: ON_AXIS * size })
    }

    /// The B-spline surface, if it is one.
    pub(crate) fn spline(&self) -> Option<&Spline> {
        match &self.kind {
            Kind::Spline(spline) => Some(spline),
            _ => None,
        }
    }

    pub(crate) fn is_plane(&self) -> bool {
        matches!(self.kind, Kind::Plane(_))
    }

    /// Parameter `v` of the apex of a cone.
    pub(crate) fn apex(&self) -> Option<f64> {
        match self.kind {
            Kind::Cone { radius, slope, .. } => Some(-radius / slope),
            _ => None,
        }
    }

    /// Whether the direction `v` of the parameter plane ends nowhere: what is far out is no part of a face.
    pub(crate) fn unbounded(&self) -> bool {
        matches!(self.kind, Kind::Plane(_) | Kind::Cylinder { .. } | Kind::Cone { .. })
    }

    /// First and last `v` of the parameter plane.
    pub(crate) fn v_range(&self) -> [f64; 2] {
        match &self.kind {
            Kind::Sphere { .. } => [-FRAC_PI_2, FRAC_PI_2],
            Kind::Torus { .. } => [-PI, PI],
            Kind::Spline(spline) => {
                let v = spline.surface.domain()[1];
                [v.start(), v.end()]
            }
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    pub(crate) fn jet(&self, uv: &Vector2<f64>) -> SurfaceJet {
        let (u, v) = (uv.x, uv.y);
        match &self.kind {
            Kind::Plane(frame) => SurfaceJet {
                point: frame.origin() + frame.x() * u + frame.y() * v,
                du: frame.x(),
                dv: frame.y(),
                duu: Vector3::zeros(),
                duv: Vector3::zeros(),
                dvv: Vector3::zeros(),
            },
            Kind::Cylinder { frame, radius } => revolved(frame, u, [*radius, 0.0, 0.0], [v, 1.0, 0.0]),
            Kind::Cone { frame, radius, slope } => {
                revolved(frame, u, [radius + v * slope, *slope, 0.0], [v, 1.0, 0.0])
            }
            Kind::Sphere { frame, radius: r } => {
                let (s, c) = v.sin_cos();
                revolved(frame, u, [r * c, -r * s, -r * c], [r * s, r * c, -r * s])
            }
            Kind::Torus { frame, major, minor: r } => {
                let (s, c) = v.sin_cos();
                revolved(frame, u, [major + r * c, -r * s, -r * c], [r * s, r * c, -r * s])
            }
            Kind::Spline(spline) => {
                let [u, v] = spline.inside([u, v], self.period);
                spline.surface.jet(u, v)
            }
        }
    }

    pub(crate) fn point(&self, uv: &Vector2<f64>) -> Vector3<f64> {
        match &self.kind {
            Kind::Spline(spline) => {
                let [u, v] = spline.inside([uv.x, uv.y], self.period);
                spline.surface.point(u, v)
            }
            _ => self.jet(uv).point,
        }
    }

    /// Unit normal `S_u × S_v`; zero where there is none.
    pub(crate) fn normal(&self, uv: &Vector2<f64>) -> Vector3<f64> {
        let n = match &self.kind {
            // The direction has a limit at the poles, where S_u vanishes.
            Kind::Sphere { frame, .. } => self.jet(uv).point - frame.origin(),
            _ => self.jet(uv).normal_direction(),
        };
        let length = n.norm();
        if length > 0.0 { n / length } else { Vector3::zeros() }
    }

    /// Parameters of a point on the carrier, or those of the foot of a point next to it; of the copies that periods
    /// make the one next to `hint`.
    pub(crate) fn invert(&self, x: &Vector3<f64>, hint: Option<&Vector2<f64>>) -> Uv {
        let (at, pole) = match &self.kind {
            Kind::Plane(frame) => {
                let d = x - frame.origin();
                (Vector2::new(d.dot(&frame.x()), d.dot(&frame.y())), false)
            }
            Kind::Cylinder { frame, radius } => {
                let p = frame.local(x);
                (Vector2::new(p.y.atan2(p.x), p.z), p.x.hypot(p.y) < ON_AXIS * radius)
            }
            Kind::Cone { frame, radius, slope } => {
                let p = frame.local(x);
                let apex = -radius / slope;
                // The nappe on which the point lies: radii are negative on the one beyond the apex.
                let sign = if (p.z - apex) * slope < 0.0 { -1.0 } else { 1.0 };
                let rho = p.x.hypot(p.y);
                let v = foot_on_generator(sign * rho, p.z, *radius, *slope);
                let near_apex = rho.hypot(p.z - apex) <= self.small || (v - apex) * slope * sign <= 0.0;
                let v = if near_apex { apex } else { v };
                (Vector2::new((sign * p.y).atan2(sign * p.x), v), near_apex)
            }
            Kind::Sphere { frame, radius } => {
                let p = frame.local(x);
                let rho = p.x.hypot(p.y);
                let pole = rho < ON_AXIS * radius;
                // At the pole itself: how far away the point is counts as a distance from the carrier.
                let v = if pole { FRAC_PI_2.copysign(p.z) } else { p.z.atan2(rho) };
                (Vector2::new(p.y.atan2(p.x), v), pole)
            }
            Kind::Torus { frame, major, .. } => {
                let p = frame.local(x);
                let sign = if *major < 0.0 { -1.0 } else { 1.0 };
                let rho = sign * p.x.hypot(p.y);
                let u = (sign * p.y).atan2(sign * p.x);
                (Vector2::new(u, p.z.atan2(rho - major)), false)
            }
            Kind::Spline(spline) => spline.invert(x, hint, self.period),
        };
        let at = hint.map_or(at, |hint| self.next_to(&at, hint));
        Uv { at, pole }
    }

    /// The copy of a parameter pair next to another one.
    pub(crate) fn next_to(&self, uv: &Vector2<f64>, hint: &Vector2<f64>) -> Vector2<f64> {
        Vector2::from_fn(|i, _| match self.period[i] {
            Some(period) => uv[i] + ((hint[i] - uv[i]) / period).round() * period,
            None => uv[i],
        })
    }

    /// Parameters of the feet among which the nearest point of an analytic carrier and all other local minima of
    /// the distance are, but for the apex of a cone. Empty for B-splines.
    pub(crate) fn near_feet(&self, x: &Vector3<f64>) -> Vec<Vector2<f64>> {
        match &self.kind {
            Kind::Spline(_) => Vec::new(),
            Kind::Cone { frame, radius, slope } => {
                let p = frame.local(x);
                let (rho, u) = (p.x.hypot(p.y), p.y.atan2(p.x));
                [(1.0, u), (-1.0, u + PI)]
                    .map(|(sign, u)| Vector2::new(u, foot_on_generator(sign * rho, p.z, *radius, *slope)))
                    .to_vec()
            }
            Kind::Torus { frame, major, minor } if major.abs() <= *minor => {
                // The tube meets itself: both of its sections by the plane through the axis count.
                let p = frame.local(x);
                let (rho, u) = (p.x.hypot(p.y), p.y.atan2(p.x));
                [(rho, u), (-rho, u + PI)].map(|(r, u)| Vector2::new(u, p.z.atan2(r - major))).to_vec()
            }
            _ => vec![self.invert(x, None).at],
        }
    }
}

impl Spline {
    fn new(surface: &BsplineSurface) -> Result<Self, Error> {
        let why = |e: nurbs_core::Error| Error::of("B-spline surface", e);
        let surface = surface.clamped(Direction::U).and_then(|s| s.clamped(Direction::V)).map_err(why)?;
        let size = surface.control_box().diagonal();
        let (n_u, n_v) = (surface.n_u(), surface.n_v());
        let [u, v] = surface.domain();
        let same = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() <= CLOSED * size;
        let row = |j: usize| (1..n_u).all(|i| same(surface.control_point(i, j), surface.control_point(0, j)));
        let column =
            |i: usize| (1..n_v).all(|j| same(surface.control_point(i, j), surface.control_point(i, 0)));
        let poles_v = [(0, v.start()), (n_v - 1, v.end())].into_iter().filter(|(j, _)| row(*j));
        let poles_u = [(0, u.start()), (n_u - 1, u.end())].into_iter().filter(|(i, _)| column(*i));
        let (poles_v, poles_u) = (poles_v.map(|p| p.1).collect(), poles_u.map(|p| p.1).collect());
        let patches = OnceLock::new();
        Ok(Self { projector: SurfaceProjector::on_demand(&surface), surface, poles_v, poles_u, patches })
    }

    /// Parameters inside the domain: wrapped where the surface is closed, else moved to the border.
    pub(crate) fn inside(&self, uv: [f64; 2], period: [Option<f64>; 2]) -> [f64; 2] {
        let domain = self.surface.domain();
        [0, 1].map(|i| {
            let within = domain[i].contains(uv[i]);
            match period[i] {
                Some(_) if !within => domain[i].wrap(uv[i]),
                _ => domain[i].clamp(uv[i]),
            }
        })
    }

    fn invert(
        &self,
        x: &Vector3<f64>,
        hint: Option<&Vector2<f64>>,
        period: [Option<f64>; 2],
    ) -> (Vector2<f64>, bool) {
        let size = self.surface.control_box().diagonal();
        let near = hint.map(|hint| self.projector.project_from(x, 0, self.inside([hint.x, hint.y], period)));
        // A foot that is as good as a search would find needs no search.
        let foot = match near {
            Some(foot) if foot.status.is_converged() && foot.distance <= FOLLOWED * size => foot,
            near => {
                let global = self.global(x, FOLLOWED * size);
                match near {
                    Some(near)
                        if near.status.is_converged()
                            && near.distance <= global.distance * 1.01 + 1e-9 * size =>
                    {
                        near
                    }
                    _ => global,
                }
            }
        };
        let [u, v] = foot.parameter;
        let domain = self.surface.domain();
        let at = |poles: &[f64], t: f64, i: usize| {
            poles.iter().any(|p| (p - t).abs() <= 1e-7 * domain[i].length())
        };
        (Vector2::new(u, v), at(&self.poles_v, v, 1) || at(&self.poles_u, u, 0))
    }
}

impl Spline {
    /// The nearest point; where one is as near as edges are to their surface, no proof that it is.
    fn global(&self, x: &Vector3<f64>, near: f64) -> SurfaceFootpoint {
        match self.projector.project_with(x, &ProjectionOptions::default().with_mode(Mode::Fast)) {
            Ok(foot) if foot.status.is_converged() && foot.distance <= near => foot,
            _ => self.projector.project(x),
        }
    }
}

/// Parameter `v` of the foot on the generator `r + v tan α`, in the half plane of the axis where the point is
/// `(ρ, z)`.
fn foot_on_generator(rho: f64, z: f64, radius: f64, slope: f64) -> f64 {
    ((rho - radius) * slope + z) / (1.0 + slope * slope)
}

/// Jet of `m + f(v) e(u) + g(v) z`, from value and derivatives of `f` and `g`.
fn revolved(frame: &Frame, u: f64, f: [f64; 3], g: [f64; 3]) -> SurfaceJet {
    let (s, c) = u.sin_cos();
    let e = frame.x() * c + frame.y() * s;
    let de = frame.y() * c - frame.x() * s;
    SurfaceJet {
        point: frame.origin() + e * f[0] + frame.z() * g[0],
        du: de * f[0],
        dv: e * f[1] + frame.z() * g[1],
        duu: -e * f[0],
        duv: de * f[1],
        dvv: e * f[2] + frame.z() * g[2],
    }
}

fn positive(what: &str, radius: f64) -> Result<f64, Error> {
    if radius > 0.0 && radius.is_finite() {
        Ok(radius)
    } else {
        Err(Error::of(what, format!("its radius is {radius}; it must be positive and finite")))
    }
}

impl Spline {
    /// Its Bézier patches.
    pub(crate) fn patches(&self) -> &[BezierPatch] {
        self.patches.get_or_init(|| self.surface.bezier_patches())
    }

    /// Whether an end of a parameter (0: `u`, 1: `v`) is one point.
    pub(crate) fn has_pole(&self, parameter: usize) -> bool {
        !(if parameter == 0 { &self.poles_u } else { &self.poles_v }).is_empty()
    }
}

impl Surface {
    /// The integral along `v` of the element of area, in closed form; on spheres from the first pole, on cones from the
    /// apex.
    pub(crate) fn area_primitive(&self, v: f64) -> Option<f64> {
        match &self.kind {
            Kind::Sphere { radius: r, .. } => Some(r * r * (v.sin() + 1.0)),
            Kind::Cone { radius, slope, .. } => {
                let r = radius + v * slope;
                Some(r * r.abs() / (2.0 * slope) * slope.hypot(1.0))
            }
            Kind::Torus { major, minor: r, .. } => Some(r * (major.abs() * v + r * v.sin())),
            _ => None,
        }
    }

    /// Area of a carrier that is finite, in closed form.
    pub(crate) fn whole_area(&self) -> Option<f64> {
        match &self.kind {
            Kind::Sphere { radius: r, .. } => Some(2.0 * TAU * r * r),
            Kind::Torus { major, minor: r, .. } => Some(TAU * TAU * major.abs() * r),
            _ => None,
        }
    }
}
