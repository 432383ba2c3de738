//! Random shapes against brute force.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use crate::projector_support::answer::{Answer, Judge};
use crate::projector_support::config;
use crate::projector_support::oracle::{curve_distance, surface_distance};
use crate::projector_support::shapes::{plane_curve, query, space_curve, surface};
use footpoint::{CurveProjector, Multiplicity, SurfaceProjector};
use nalgebra::{SVector, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface};
use proptest::prelude::*;

/// All that holds for a certified answer, given a distance that is not below the true one.
fn check<const D: usize, J: Judge<D>>(
    shapes: &[J],
    x: &SVector<f64, D>,
    found: &Answer<D>,
    oracle: f64,
) -> Result<(), TestCaseError> {
    let size = shapes.iter().map(Judge::size).fold(0.0, f64::max);
    prop_assert_eq!(shapes[found.shape].inconsistency(x, found), None, "{:?}", found);
    prop_assert!(
        found.distance <= oracle * (1.0 + 1e-9) + 1e-12 * size,
        "brute force is nearer: {} and {:?}",
        oracle,
        found
    );
    prop_assert!(found.lower_bound <= found.distance, "{:?}", found);
    prop_assert!(
        found.lower_bound <= oracle * (1.0 + 1e-12),
        "brute force {} is below the bound of {:?}",
        oracle,
        found
    );
    let gap = found.distance - found.lower_bound;
    prop_assert!(gap <= 1e-6 * found.distance + 1e-9 * size, "gap {} of {:?}", gap, found);
    prop_assert!(found.status.is_converged(), "{:?}", found);
    prop_assert_ne!(found.multiplicity, Multiplicity::Unknown);
    Ok(())
}

fn check_surfaces(surfaces: &[BsplineSurface], points: &[Vector3<f64>]) -> Result<(), TestCaseError> {
    let projector = SurfaceProjector::for_model(surfaces).unwrap();
    for x in points {
        let oracle = surfaces.iter().map(|s| surface_distance(s, x)).fold(f64::INFINITY, f64::min);
        check(surfaces, x, &projector.project(x).into(), oracle)?;
    }
    Ok(())
}

fn check_curves<const D: usize>(
    curves: &[BsplineCurve<D>],
    points: &[SVector<f64, D>],
) -> Result<(), TestCaseError> {
    let projector = CurveProjector::for_model(curves).unwrap();
    for x in points {
        let oracle = curves.iter().map(|c| curve_distance(c, x)).fold(f64::INFINITY, f64::min);
        check(curves, x, &projector.project(x).into(), oracle)?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn one_surface(surface in surface(), points in prop::collection::vec(query::<3>(), 6)) {
        check_surfaces(&[surface], &points)?;
    }

    #[test]
    fn several_surfaces(
        surfaces in prop::collection::vec(surface(), 2..4),
        points in prop::collection::vec(query::<3>(), 3),
    ) {
        check_surfaces(&surfaces, &points)?;
    }

    #[test]
    fn plane_curves(
        curves in prop::collection::vec(plane_curve(), 1..4),
        points in prop::collection::vec(query::<2>(), 12),
    ) {
        check_curves(&curves, &points)?;
    }

    #[test]
    fn space_curves(
        curves in prop::collection::vec(space_curve(), 1..4),
        points in prop::collection::vec(query::<3>(), 12),
    ) {
        check_curves(&curves, &points)?;
    }
}
