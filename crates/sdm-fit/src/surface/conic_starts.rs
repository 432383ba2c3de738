//! Surfaces on which quadrics and tori can be exact, to start fits with weights from.

use super::approximate::approximate;
use super::base::choose;
use super::base_shape::BaseShape;
use super::rational::EXACT;
use crate::Error;
use crate::primitive::{PrimitiveOptions, fit_cone, fit_cylinder, fit_torus};
use crate::rational::conic_knots;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Cylinder, Interval, KnotVector};
use std::f64::consts::FRAC_1_SQRT_2;

/// Share of an open direction by which a start reaches beyond the points.
const MARGIN: f64 = 0.05;
/// Arcs of which a full turn is made.
const ARCS: usize = 4;

/// Surfaces to start from on which quadrics and tori can be exact: degree 2 with double knots around, and along them straight
/// lines, one arc, or two.
pub(super) fn conic_starts(points: &[Vector3<f64>], asked: BaseShape) -> Result<Vec<BsplineSurface>, Error> {
    let middle = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let local: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
    let mut base = choose(&local, asked)?;
    // The starts reach beyond the points where they are open: points at an edge that gives way hold up the convergence.
    let open = match base.shape {
        BaseShape::Plane | BaseShape::Auto => [true, true],
        BaseShape::Cylinder => [false, true],
        BaseShape::Sphere | BaseShape::Torus => [false, false],
    };
    for parameter in &mut base.parameters {
        for d in (0..2).filter(|&d| open[d]) {
            parameter[d] = MARGIN + (1.0 - 2.0 * MARGIN) * parameter[d];
        }
    }
    let around = || conic_knots(ARCS, true);
    let candidates = match base.shape {
        BaseShape::Cylinder => {
            vec![[around()?, KnotVector::bezier(1, Interval::UNIT)?], [around()?, conic_knots(1, false)?]]
        }
        BaseShape::Sphere => vec![[around()?, conic_knots(2, false)?]],
        BaseShape::Torus => Vec::new(),
        BaseShape::Plane | BaseShape::Auto => vec![[conic_knots(1, false)?, conic_knots(1, false)?]],
    };
    // From a net with kinks the way to a cylinder or torus can be long, and least squares ones are at hand.
    let mut starts: Vec<BsplineSurface> = Vec::new();
    for primitive in primitives(&local, base.shape) {
        starts.push(primitive.translated(&middle)?);
    }
    let start = |knots: [KnotVector; 2]| -> Result<BsplineSurface, Error> {
        Ok(with_arc_weights(approximate(&local, base.shape, &base.parameters, knots)?)?
            .translated(&middle)?)
    };
    for knots in candidates {
        starts.push(start(knots)?);
    }
    Ok(starts)
}

/// The least squares cylinder (a little longer than the points) and cone, or torus.
fn primitives(points: &[Vector3<f64>], shape: BaseShape) -> Vec<BsplineSurface> {
    let options = PrimitiveOptions::default();
    let cylinder = || {
        let found = fit_cylinder(points, &options).ok()?;
        let cylinder = found.shape;
        let heights = points.iter().map(|p| cylinder.frame().local(p).z);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
        let margin = MARGIN * (high - low);
        let heights = Interval::new(low - margin, high + margin).ok()?;
        let surface = Cylinder::new(*cylinder.frame(), cylinder.radius(), heights).ok()?.to_nurbs().ok()?;
        Some((found.rms, surface))
    };
    let cone = || {
        let found = fit_cone(points, &options).ok()?;
        Some((found.rms, found.shape.to_nurbs().ok()?))
    };
    let torus = || fit_torus(points, &options).ok()?.shape.to_nurbs().ok();
    match shape {
        BaseShape::Torus => torus().into_iter().collect(),
        BaseShape::Cylinder => {
            // A cylinder is a cone, too: only one that is nearer comes first, since its ends are straight.
            let size = points.iter().map(|p| p.amax()).fold(0.0, f64::max);
            let mut found: Vec<(f64, BsplineSurface)> = [cylinder(), cone()].into_iter().flatten().collect();
            if let [(first, _), (second, _)] = found[..]
                && first > EXACT * size
                && second < first
            {
                found.reverse();
            }
            found.into_iter().map(|(_, surface)| surface).collect()
        }
        BaseShape::Plane | BaseShape::Sphere | BaseShape::Auto => Vec::new(),
    }
}

/// The surface with the weights of circles where knots are those of several arcs: every second control point lies between the
/// ends of an arc of a quarter turn.
fn with_arc_weights(surface: BsplineSurface) -> Result<BsplineSurface, Error> {
    let [along_u, along_v] = [surface.knots_u(), surface.knots_v()].map(|knots| {
        let quarters = knots.degree() == 2 && knots.spans().count() > 1;
        let weight = |i: usize| if quarters && i % 2 == 1 { FRAC_1_SQRT_2 } else { 1.0 };
        (0..knots.basis_count()).map(weight).collect::<Vec<_>>()
    });
    let (u, v, net, _) = surface.into_parts();
    let weights = along_u.iter().flat_map(|a| along_v.iter().map(move |b| a * b)).collect();
    Ok(BsplineSurface::new(u, v, net, Some(weights))?)
}
