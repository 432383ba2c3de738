//! The residual `x − c` taken apart along tangent and normal directions.

use nalgebra::{SVector, Vector3};
use nurbs_core::{CurveJet, SurfaceJet};

/// Sine of the angle between `s_u` and `s_v` below which a surface point counts as singular: from here
/// on the tangent plane is mostly rounding error.
const SINGULAR_SINE: f64 = 1e-10;

/// The residual of a curve point, measured in its Frenet terms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurveResidual {
    /// `|c'|`.
    pub(crate) speed: f64,
    /// `L = ⟨w, c'⟩ / |c'|`: signed length of the tangential part of `w = x − c`.
    pub(crate) tangential: f64,
    /// Curvature `κ`.
    pub(crate) curvature: f64,
    /// `κν = ⟨w, c''_⊥⟩ / |c'|²`: offset in the direction of the curvature centre, in units of the radius.
    pub(crate) offset: f64,
    /// `⟨c', c''⟩ / |c'|²`.
    pub(crate) stretch: f64,
}

impl CurveResidual {
    /// `None` where `c' = 0`.
    pub(crate) fn new<const D: usize>(jet: &CurveJet<D>, x: &SVector<f64, D>) -> Option<Self> {
        let speed_sq = jet.d1.norm_squared();
        if !speed_sq.is_normal() {
            return None;
        }
        let w = x - jet.point;
        let speed = speed_sq.sqrt();
        let stretch = jet.d1.dot(&jet.d2) / speed_sq;
        let perpendicular = jet.d2 - jet.d1 * stretch;
        Some(Self {
            speed,
            tangential: w.dot(&jet.d1) / speed,
            curvature: perpendicular.norm() / speed_sq,
            offset: w.dot(&perpendicular) / speed_sq,
            stretch,
        })
    }
}

/// First and second fundamental form and unit normal of a regular surface point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentPlane {
    /// `g_11, g_12, g_22`.
    pub(crate) first: [f64; 3],
    /// `h_11, h_12, h_22`.
    pub(crate) second: [f64; 3],
    /// `|s_u × s_v| = √det g`.
    pub(crate) area: f64,
    /// Unit normal.
    pub(crate) normal: Vector3<f64>,
}

/// What a surface point offers to move along.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tangent {
    /// A tangent plane.
    Plane(TangentPlane),
    /// The curve of the one parameter (0 or 1) whose derivative is not degenerate.
    Line(usize),
    /// Nothing: both first derivatives vanish.
    None,
}

/// Classifies the point of a jet.
pub(crate) fn surface_tangent(jet: &SurfaceJet) -> Tangent {
    let first = [jet.du.norm_squared(), jet.du.dot(&jet.dv), jet.dv.norm_squared()];
    let cross = jet.normal_direction();
    let area = cross.norm();
    if area.is_normal() && area > SINGULAR_SINE * (first[0] * first[2]).sqrt() {
        let normal = cross / area;
        let second = [jet.duu.dot(&normal), jet.duv.dot(&normal), jet.dvv.dot(&normal)];
        return Tangent::Plane(TangentPlane { first, second, area, normal });
    }
    let longer = if first[0] >= first[2] { 0 } else { 1 };
    if first[2 * longer].is_normal() { Tangent::Line(longer) } else { Tangent::None }
}

/// The jet of the parameter line `u ↦ s(u, v)` (`direction` 0) or `v ↦ s(u, v)` (1).
pub(crate) fn parameter_line(jet: &SurfaceJet, direction: usize) -> CurveJet<3> {
    let (d1, d2) = if direction == 0 { (jet.du, jet.duu) } else { (jet.dv, jet.dvv) };
    CurveJet { point: jet.point, d1, d2 }
}

/// An increment of the parameter `direction` as a pair.
pub(crate) fn along(direction: usize, delta: f64) -> [f64; 2] {
    if direction == 0 { [delta, 0.0] } else { [0.0, delta] }
}

impl TangentPlane {
    /// `(λ¹, λ²)` with `λ¹ s_u + λ² s_v` = tangential part of `w` ([HW05, eqs. (10)-(11)]).
    ///
    /// By cross products instead of the normal equations, which square the condition.
    pub(crate) fn coordinates(&self, jet: &SurfaceJet, w: &Vector3<f64>) -> [f64; 2] {
        [w.cross(&jet.dv).dot(&self.normal) / self.area, jet.du.cross(w).dot(&self.normal) / self.area]
    }
}

/// Principal curvatures and the parameter increments of unit length in the principal directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PrincipalTangents {
    /// `κ₁ ≥ κ₂` with respect to the normal `s_u × s_v`.
    pub(crate) curvatures: [f64; 2],
    /// Unit vectors in the tangent plane.
    pub(crate) axes: [Vector3<f64>; 2],
    /// `(Δu, Δv)` such that `Δu s_u + Δv s_v` is the axis.
    pub(crate) increments: [[f64; 2]; 2],
}

impl PrincipalTangents {
    pub(crate) fn new(plane: &TangentPlane, jet: &SurfaceJet) -> Self {
        // Orthonormal tangents a = s_u / √E and b = (s_v − (F/E) s_u) √E / area.
        let [e, f, _] = plane.first;
        let [l, m, n] = plane.second;
        let root = e.sqrt();
        let shear = f / e;
        let (a, b) = ([1.0 / root, 0.0], [-shear * root / plane.area, root / plane.area]);
        let s11 = l / e;
        let s12 = (m - shear * l) / plane.area;
        let s22 = (n - 2.0 * shear * m + shear * shear * l) * e / (plane.area * plane.area);
        // Eigenvectors of the symmetric [[s11, s12], [s12, s22]] by the half angle.
        let angle = 0.5 * (2.0 * s12).atan2(s11 - s22);
        let (sin, cos) = angle.sin_cos();
        let mean = 0.5 * (s11 + s22);
        let spread = f64::hypot(0.5 * (s11 - s22), s12);
        let mix = |p: f64, q: f64| {
            let increment = [p * a[0] + q * b[0], q * b[1]];
            (increment, jet.du * increment[0] + jet.dv * increment[1])
        };
        let (first, axis_1) = mix(cos, sin);
        let (second, axis_2) = mix(-sin, cos);
        Self {
            curvatures: [mean + spread, mean - spread],
            axes: [axis_1, axis_2],
            increments: [first, second],
        }
    }
}
