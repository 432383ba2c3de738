//! Skinning, or lofting: surfaces through section curves.

use super::compatible::compatible;
use crate::{BsplineCurve, BsplineSurface, Error, KnotVector};
use nalgebra::{SVector, Vector3, Vector4};

/// The surface through the given sections, in order ([PT97, sec. 10.3]): `u` runs along the sections, `v`
/// across, of degree `degree_v`.
///
/// Sections sit at parameters `v` in `[0, 1]` that follow the distances of their control points,
/// averaged; use [`skin_at`] to choose them. All sections should start at corresponding points and run in
/// the same direction.
///
/// # Errors
/// [`Error::Argument`] when there are fewer than `degree_v + 1` sections or two in a row coincide;
/// [`Error::Weight`] when rational sections differ so much that a weight in between is not positive.
pub fn skin(sections: &[BsplineCurve<3>], degree_v: usize) -> Result<BsplineSurface, Error> {
    let sections = compatible(sections)?;
    let parameters = chord_parameters(&sections)?;
    through(&sections, &parameters, degree_v)
}

/// As [`skin`], with the parameter `v` of each section given.
///
/// # Errors
/// As [`skin`]; and when the number of parameters differs from that of the sections or they do not
/// increase.
pub fn skin_at(
    sections: &[BsplineCurve<3>],
    parameters: &[f64],
    degree_v: usize,
) -> Result<BsplineSurface, Error> {
    through(&compatible(sections)?, parameters, degree_v)
}

fn through(
    sections: &[BsplineCurve<3>],
    parameters: &[f64],
    degree_v: usize,
) -> Result<BsplineSurface, Error> {
    check(sections, parameters, degree_v)?;
    let knots_v = KnotVector::averaged(degree_v, parameters)?;
    let n_u = sections[0].control_points().len();
    let rational = sections.iter().any(|s| s.weights().is_some());
    let mut points = Vec::with_capacity(n_u * sections.len());
    let mut weights = Vec::with_capacity(points.capacity());
    for i in 0..n_u {
        let lift = |s: &BsplineCurve<3>| {
            let (p, w) = (s.control_points()[i], s.weight(i));
            Vector4::new(p.x * w, p.y * w, p.z * w, w)
        };
        let column: Vec<Vector4<f64>> = sections.iter().map(lift).collect();
        let curve = BsplineCurve::interpolate_at(knots_v.clone(), parameters, &column)?;
        for p in curve.control_points() {
            points.push(p.xyz() / if rational { p.w } else { 1.0 });
            weights.push(p.w);
        }
    }
    let weights = rational.then_some(weights);
    BsplineSurface::new(sections[0].knots().clone(), knots_v, points, weights)
}

fn check(sections: &[BsplineCurve<3>], parameters: &[f64], degree_v: usize) -> Result<(), Error> {
    if sections.len() != parameters.len() {
        let (found, needed) = (parameters.len(), sections.len());
        return Err(Error::argument(format!("{found} parameters are given for {needed} sections")));
    }
    if sections.len() <= degree_v {
        return Err(Error::argument(format!(
            "{} sections are too few for degree {degree_v} across; give {} or a lower degree",
            sections.len(),
            degree_v + 1
        )));
    }
    Ok(())
}

/// Chord length parameters, averaged over the rows of control points that move ([PT97, eq. (10.8)]).
fn chord_parameters(sections: &[BsplineCurve<3>]) -> Result<Vec<f64>, Error> {
    let mut parameters = vec![0.0; sections.len()];
    let rows = sections.first().map_or(0, |s| s.control_points().len());
    let mut used = 0.0;
    for i in 0..rows {
        let at = |k: usize| -> SVector<f64, 3> { sections[k].control_points()[i] };
        let lengths: Vec<f64> = (1..sections.len()).map(|k| Vector3::norm(&(at(k) - at(k - 1)))).collect();
        let total: f64 = lengths.iter().sum();
        if total > 0.0 {
            used += 1.0;
            let mut sum = 0.0;
            for (parameter, length) in parameters[1..].iter_mut().zip(&lengths) {
                sum += length / total;
                *parameter += sum;
            }
        }
    }
    parameters.iter_mut().for_each(|v| *v /= used);
    if let Some(last) = parameters.last_mut() {
        *last = 1.0;
    }
    match (1..parameters.len()).find(|&k| parameters[k] <= parameters[k - 1] || parameters[k].is_nan()) {
        Some(k) => {
            Err(Error::argument(format!("sections {} and {k} coincide; leave one of them out", k - 1)))
        }
        None => Ok(parameters),
    }
}
