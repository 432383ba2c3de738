//! What a data point is worth whose foot is on the edge of an open surface.

use distance_field::ErrorTerm;
use nalgebra::{Matrix3, Vector3};
use nurbs_core::SurfaceJet;

/// The blend `w = cos θ + (1 − cos θ) w_term` in the tangent plane, `θ` the angle between the residual and its tangential
/// part; weight 1 along the normal ([WPL06, sec. 3], for surfaces).
///
/// Across the tangential part of the residual the term has its say. `None` where the surface has no normal.
pub(super) fn edge_model(jet: &SurfaceJet, residual: &Vector3<f64>, term: ErrorTerm) -> Option<Matrix3<f64>> {
    let normal = jet.du.cross(&jet.dv).try_normalize(0.0)?;
    let height = residual.dot(&normal);
    let tangential = residual - normal * height;
    let length = residual.norm();
    let out = match tangential.try_normalize(1e-9 * length) {
        Some(out) if length > 0.0 => out,
        _ => jet.du.try_normalize(0.0)?,
    };
    let along = normal.cross(&out);
    let cosine = if length > 0.0 { (tangential.norm() / length).min(1.0) } else { 0.0 };
    let curvature = |direction: &Vector3<f64>| normal_curvature(jet, &normal, direction).unwrap_or(0.0);
    let weight = |direction: &Vector3<f64>| {
        // The sign of the normal is that of the residual.
        let bend = curvature(direction) * height.signum();
        let weight = term.tangent_weight(height.abs(), bend);
        if weight.is_finite() { weight } else { 1.0 }
    };
    let outward = cosine + (1.0 - cosine) * weight(&out);
    Some(
        normal * normal.transpose()
            + out * out.transpose() * outward
            + along * along.transpose() * weight(&along),
    )
}

/// Curvature of the normal section in a tangent direction, positive towards the normal.
fn normal_curvature(jet: &SurfaceJet, normal: &Vector3<f64>, direction: &Vector3<f64>) -> Option<f64> {
    let (e, f, g) = (jet.du.dot(&jet.du), jet.du.dot(&jet.dv), jet.dv.dot(&jet.dv));
    let determinant = e * g - f * f;
    let (a, b) = (direction.dot(&jet.du), direction.dot(&jet.dv));
    let (u, v) = ((g * a - f * b) / determinant, (e * b - f * a) / determinant);
    let bend = u * u * jet.duu.dot(normal) + 2.0 * u * v * jet.duv.dot(normal) + v * v * jet.dvv.dot(normal);
    bend.is_finite().then_some(bend)
}
