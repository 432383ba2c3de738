//! What must not change the answer: motions, scale, parameterisation, representation; and optimality.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use crate::projector_support::answer::Judge;
use crate::projector_support::config;
use crate::projector_support::shapes::{plane_curve, query, space_curve, surface};
use footpoint::{CurveProjector, Location, Mode, ProjectionOptions, SurfaceProjector};
use nalgebra::{Isometry3, Rotation3, SVector, Translation3, UnitQuaternion, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, Direction, Interval, ParametricCurve, ParametricSurface};
use proptest::prelude::*;

/// Lower bound and distance of every point.
fn distances(surface: &BsplineSurface, points: &[Vector3<f64>]) -> Vec<[f64; 2]> {
    let projector = SurfaceProjector::new(surface);
    points.iter().map(|x| projector.project(x)).map(|foot| [foot.lower_bound, foot.distance]).collect()
}

fn curve_distances<const D: usize>(curve: &BsplineCurve<D>, points: &[SVector<f64, D>]) -> Vec<[f64; 2]> {
    let projector = CurveProjector::new(curve);
    points.iter().map(|x| projector.project(x)).map(|foot| [foot.lower_bound, foot.distance]).collect()
}

/// Whether two lists of certified distances agree, and the true one lies between the bounds of both.
fn same(a: &[[f64; 2]], b: &[[f64; 2]], size: f64, tolerance: f64) -> Result<(), TestCaseError> {
    for (a, b) in a.iter().zip(b) {
        let slack = tolerance * (a[1].max(b[1]) + size);
        prop_assert!(a[0] <= b[1] + slack && b[0] <= a[1] + slack, "{:?} and {:?}", a, b);
        prop_assert!((a[1] - b[1]).abs() <= slack, "{:?} and {:?}", a, b);
        // The gap that the options allow, and a little for rounding errors next to the shape.
        prop_assert!(a[1] - a[0] <= 1e-6 * (a[1] + 1e-2 * size), "{:?}", a);
    }
    Ok(())
}

/// Agreement for shapes of the same size: nothing but rounding.
const GAP: f64 = 1e-9;

fn motion() -> impl Strategy<Value = Isometry3<f64>> {
    (query::<3>(), query::<3>()).prop_map(|(axis, offset)| {
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::new(axis));
        Isometry3::from_parts(Translation3::from(offset), rotation)
    })
}

fn points<const D: usize>(count: usize) -> impl Strategy<Value = Vec<SVector<f64, D>>> {
    prop::collection::vec(query::<D>(), count)
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn motions_of_surfaces(surface in surface(), motion in motion(), points in points::<3>(6)) {
        let moved: Vec<_> = points.iter().map(|x| motion.transform_point(&(*x).into()).coords).collect();
        let expected = distances(&surface, &points);
        same(&expected, &distances(&surface.moved(&motion).unwrap(), &moved), surface.size(), GAP)?;
    }

    #[test]
    fn scale_of_surfaces(surface in surface(), exponent in -9_i32..9, points in points::<3>(6)) {
        let factor = 10_f64.powi(exponent);
        let scaled: Vec<_> = points.iter().map(|x| x * factor).collect();
        let big = surface.scaled(factor, &Vector3::zeros()).unwrap();
        let back: Vec<_> = distances(&big, &scaled).iter().map(|d| d.map(|d| d / factor)).collect();
        same(&distances(&surface, &points), &back, surface.size(), GAP)?;
    }

    #[test]
    fn far_from_the_origin(surface in surface(), points in points::<3>(6)) {
        let offset = Vector3::new(1e6, -1e6, 1e6);
        // The control points round to multiples of 2⁻³³: take those as the shape near the origin too.
        let far = surface.translated(&offset).unwrap();
        let near = far.translated(&-offset).unwrap();
        let there: Vec<_> = points.iter().map(|x| x + offset).collect();
        let here: Vec<_> = there.iter().map(|x| x - offset).collect();
        same(&distances(&near, &here), &distances(&far, &there), surface.size(), GAP)?;
    }

    #[test]
    fn parameterisation_of_surfaces(surface in surface(), points in points::<3>(6)) {
        let expected = distances(&surface, &points);
        let size = surface.size();
        let domain = [Interval::new(-3.0, 400.0).unwrap(), Interval::new(10.0, 10.5).unwrap()];
        same(&expected, &distances(&surface.reparameterized(domain).unwrap(), &points), size, GAP)?;
        same(&expected, &distances(&surface.reversed(Direction::U).unwrap(), &points), size, GAP)?;
        same(&expected, &distances(&surface.reversed(Direction::V).unwrap(), &points), size, GAP)?;
        same(&expected, &distances(&surface.transposed().unwrap(), &points), size, GAP)?;
    }

    #[test]
    fn representation_of_surfaces(surface in surface(), at in 0.1..0.9, points in points::<3>(4)) {
        let expected = distances(&surface, &points);
        let size = surface.size();
        same(&expected, &distances(&surface.elevated(Direction::U, 1).unwrap(), &points), size, GAP)?;
        same(&expected, &distances(&surface.elevated(Direction::V, 3).unwrap(), &points), size, GAP)?;
        let [u, v] = surface.domain();
        let refined = surface.insert_knot(Direction::U, u.lerp(at), 1).unwrap();
        let refined = refined.insert_knot(Direction::V, v.lerp(1.0 - at), 1).unwrap();
        same(&expected, &distances(&refined, &points), size, GAP)?;
    }

    #[test]
    fn laws_of_curves(curve in space_curve(), motion in motion(), at in 0.1..0.9, points in points::<3>(12)) {
        let expected = curve_distances(&curve, &points);
        let size = curve.size();
        let moved: Vec<_> = points.iter().map(|x| motion.transform_point(&(*x).into()).coords).collect();
        same(&expected, &curve_distances(&curve.moved(&motion).unwrap(), &moved), size, GAP)?;
        same(&expected, &curve_distances(&curve.reversed().unwrap(), &points), size, GAP)?;
        let domain = Interval::new(1e3, 1.5e3).unwrap();
        same(&expected, &curve_distances(&curve.reparameterized(domain).unwrap(), &points), size, GAP)?;
        same(&expected, &curve_distances(&curve.elevated(2).unwrap(), &points), size, GAP)?;
        let t = curve.domain().lerp(at);
        same(&expected, &curve_distances(&curve.insert_knot(t, 1).unwrap(), &points), size, GAP)?;
    }

    #[test]
    fn scale_of_plane_curves(curve in plane_curve(), exponent in -9_i32..9, points in points::<2>(12)) {
        let factor = 10_f64.powi(exponent);
        let scaled: Vec<_> = points.iter().map(|x| x * factor).collect();
        let big = curve.scaled(factor, &SVector::zeros()).unwrap();
        let back: Vec<_> = curve_distances(&big, &scaled).iter().map(|d| d.map(|d| d / factor)).collect();
        same(&curve_distances(&curve, &points), &back, curve.size(), GAP)?;
    }

    #[test]
    fn feet_inside_are_orthogonal(surface in surface(), points in points::<3>(8)) {
        let projector = SurfaceProjector::new(&surface);
        let breaks = surface.breaks();
        for x in &points {
            let foot = projector.project(x);
            let [u, v] = foot.parameter;
            let domain = surface.domain();
            let inside = |d: usize| {
                let t = foot.parameter[d];
                t > domain[d].start() && t < domain[d].end() && !breaks[d].contains(&t)
            };
            let jet = surface.jet(u, v);
            for (d, tangent) in [jet.du, jet.dv].into_iter().enumerate() {
                let slope = tangent.dot(&(foot.point - x));
                let allowed = tangent.norm() * (2e-6 * foot.distance + 1e-9 * surface.size());
                let pole = foot.location == Location::Pole;
                prop_assert!(pole || !inside(d) || slope.abs() <= allowed, "{} {:?}", slope, foot);
            }
        }
    }

    #[test]
    fn local_modes_do_not_beat_the_certified_one(surface in surface(), points in points::<3>(8), at in [0.0..=1.0, 0.0..=1.0]) {
        let projector = SurfaceProjector::new(&surface);
        let domain = surface.domain();
        let size = surface.size();
        for x in &points {
            let best = projector.project(x);
            let start = [domain[0].lerp(at[0]), domain[1].lerp(at[1])];
            let started = projector.project_from(x, 0, start);
            let options = ProjectionOptions::default();
            let fast = projector.project_with(x, &options.with_mode(Mode::Fast)).unwrap();
            let local = projector.project_with(x, &options.with_mode(Mode::Local)).unwrap();
            for other in [started, fast, local] {
                prop_assert_eq!(surface.inconsistency(x, &other.into()), None, "{:?}", other);
                prop_assert!(other.distance >= best.lower_bound - 1e-12 * size, "{:?} {:?}", best, other);
            }
            // Downhill: never further than the start, and not away from the footpoint.
            let before = (surface.point(start[0], start[1]) - x).norm();
            prop_assert!(started.distance <= before * (1.0 + 1e-12) + 1e-12 * size, "{} {:?}", before, started);
            let again = projector.project_from(x, 0, best.parameter);
            prop_assert!(again.distance <= best.distance * (1.0 + 1e-12) + 1e-12 * size, "{:?} {:?}", best, again);
        }
    }
}
