//! Ruled surfaces to start from, from the cloud alone.

use crate::surface::{Base, approximate, centred, choose, knots};
use crate::{BaseShape, Error, InitialSurface, NetSize, parallel};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, ParametricSurface};

/// Points that choose a start.
const CHOOSERS: usize = 8000;
/// Shares of a turn by which one end of closed sections is turned against the other, on both sides; and the parts of the step between
/// them that are tried around the best.
const TWISTS: i32 = 6;
const TWIST: f64 = 1.0 / 16.0;
const FINER: [f64; 2] = [0.5, 0.25];
/// How much nearer turned rulings must be than straight ones, and closed sections than open ones.
const TURNED: f64 = 0.8;
const SIMPLER: f64 = 1.3;
/// What distances along the surface count besides those across it: parameters are not final.
const ALONG: f64 = 0.1;

/// A ruled surface near a cloud: the least squares surface of degree 1 in v over a cylinder, or over the principal plane, whichever the
/// cloud is nearer to. Over a cylinder rulings run along its axis or are turned against it, as on a hyperboloid, by the angle with which
/// they are nearest to the points; over a plane they run along one or the other side of it.
///
/// # Errors
/// As for [`initial_surface`](crate::initial_surface).
pub fn initial_ruled(
    points: &[Vector3<f64>],
    base: BaseShape,
    degree: usize,
    [along, sections]: [usize; 2],
) -> Result<InitialSurface, Error> {
    let (local, middle) = centred(points)?;
    let size = NetSize { degrees: [degree, 1], controls: [along, sections] };
    let asked = if matches!(base, BaseShape::Sphere | BaseShape::Torus) { BaseShape::Auto } else { base };
    let mut best: Option<(f64, Base)> = None;
    if asked != BaseShape::Cylinder {
        let plane = choose(&local, BaseShape::Plane)?;
        let turned = Base { parameters: plane.parameters.iter().map(|&[u, v]| [v, u]).collect(), ..plane };
        for candidate in [plane, turned] {
            let found = misfit(&local, &candidate, size)?;
            if best.as_ref().is_none_or(|(least, _)| found < *least) {
                best = Some((found, candidate));
            }
        }
    }
    if asked != BaseShape::Plane {
        match choose(&local, BaseShape::Cylinder) {
            Ok(cylinder) => {
                let (found, cylinder) = twisted(&local, cylinder, size)?;
                if best.as_ref().is_none_or(|(least, _)| SIMPLER * found < *least) {
                    best = Some((found, cylinder));
                }
            }
            Err(error) if best.is_none() => return Err(error),
            Err(_) => {}
        }
    }
    let Some((_, base)) = best else {
        return Err(Error::Degenerate { shape: "a ruled surface", what: "on one side of every axis" });
    };
    let surface =
        approximate(&local, base.shape, &base.parameters, knots(base.shape, size)?)?.translated(&middle)?;
    Ok(InitialSurface { surface, base: base.shape, parameters: base.parameters })
}

/// The cylinder with one end turned against the other so that rulings are nearest to the points.
fn twisted(points: &[Vector3<f64>], cylinder: Base, size: NetSize) -> Result<(f64, Base), Error> {
    let turned = |twist: f64| Base {
        parameters: cylinder
            .parameters
            .iter()
            .map(|&[u, v]| [(u + twist * (v - 0.5)).rem_euclid(1.0), v])
            .collect(),
        ..cylinder.clone()
    };
    let rated = |twists: Vec<f64>| -> Result<Vec<(f64, f64)>, Error> {
        let one = |k: usize| -> Result<(f64, f64), Error> {
            Ok((misfit(points, &turned(twists[k]), size)?, twists[k]))
        };
        parallel::tasks(twists.len(), one).into_iter().collect()
    };
    let straight = misfit(points, &cylinder, size)?;
    let mut all = rated((-TWISTS..=TWISTS).filter(|k| *k != 0).map(|k| f64::from(k) * TWIST).collect())?;
    let least = |all: &[(f64, f64)]| all.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0));
    for part in FINER {
        let Some((_, centre)) = least(&all) else { break };
        all.extend(rated(vec![centre - part * TWIST, centre + part * TWIST])?);
    }
    Ok(match least(&all) {
        Some((found, twist)) if found < TURNED * straight => (found, turned(twist)),
        _ => (straight, cylinder),
    })
}

/// Root mean square distance of points from the least squares surface at their parameters, mostly across it.
fn misfit(points: &[Vector3<f64>], base: &Base, size: NetSize) -> Result<f64, Error> {
    let step = points.len().div_ceil(CHOOSERS).max(1);
    let thin: Vec<Vector3<f64>> = points.iter().copied().step_by(step).collect();
    let base = Base { parameters: base.parameters.iter().copied().step_by(step).collect(), ..base.clone() };
    let surface: BsplineSurface = approximate(&thin, base.shape, &base.parameters, knots(base.shape, size)?)?;
    let square = |(x, [u, v]): (&Vector3<f64>, &[f64; 2])| {
        let jet = surface.jet(*u, *v);
        let residual = x - jet.point;
        let across = jet.du.cross(&jet.dv).try_normalize(0.0).map_or(residual.norm(), |n| residual.dot(&n));
        across * across + (ALONG * ALONG) * (residual.norm_squared() - across * across).max(0.0)
    };
    let sum: f64 = thin.iter().zip(&base.parameters).map(square).sum();
    Ok((sum / thin.len().max(1) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rulings_of_a_hyperboloid_are_turned() {
        // Rulings from z = −1 to z = 1 turn by a quarter.
        let point = |k: i32| {
            let (a, z) = (f64::from(k) * 2.399_963, f64::from(k) / 1000.0 - 1.0);
            Vector3::new(a.cos() - z * a.sin(), a.sin() + z * a.cos(), 2.0 * z)
        };
        let points: Vec<_> = (0..2000).map(point).collect();
        let found = initial_ruled(&points, BaseShape::Auto, 3, [24, 2]).unwrap();
        assert_eq!(found.base, BaseShape::Cylinder);
        let [u, v] = found.surface.domain();
        for k in 0..20 {
            let ends = [0.0, 1.0].map(|t| found.surface.point(u.lerp(f64::from(k) / 20.0), v.lerp(t)));
            let turn = ends[0].xy().angle(&ends[1].xy());
            assert!((turn - std::f64::consts::FRAC_PI_2).abs() < 0.2, "{turn}");
        }
    }

    #[test]
    fn rulings_of_a_cylinder_are_straight() {
        let point = |k: i32| {
            let (a, z) = (f64::from(k) * 2.399_963, f64::from(k) / 500.0);
            Vector3::new(a.cos(), a.sin(), z)
        };
        let points: Vec<_> = (0..1000).map(point).collect();
        let found = initial_ruled(&points, BaseShape::Auto, 3, [16, 2]).unwrap();
        let [u, v] = found.surface.domain();
        let ends = [0.0, 1.0].map(|t| found.surface.point(u.lerp(0.3), v.lerp(t)));
        assert!((ends[0] - ends[1]).xy().norm() < 0.05);
    }
}
