//! Deviations and their statistics.

use super::shapes::scattered;
use super::{Checks, Failure, largest};
use industrial_geometry::inspection::{
    Along, InspectionOptions, Nominal, Partial, Statistics, Tolerance, no_progress,
};
use industrial_geometry::mesh::nalgebra::Point3;
use industrial_geometry::nurbs::{Frame, Interval, Plane, Sphere};

pub(super) fn add(checks: &mut Checks) {
    checks.add("statistics of −5, …, 5", "mean 0, rms √10, σ √11, median 0", 1e-15, statistics);
    checks.add("heights over a plane", "each point has its own z as deviation", 1e-14, plane);
    checks.add("shares in tolerance", "counted by hand: 3 under, 5 within, 3 over", 0.0, shares);
    checks.add("along a direction", "a ray at 60° to the plane is twice as long", 1e-13, slanted);
    checks.add("tiles merged in any order", "the same bits as all at once", 0.0, tiles);
    checks.add("two radii", "points of a sphere 0.01 larger deviate by 0.01", 1e-12, radii);
}

fn nominal() -> Result<Nominal, Failure> {
    let range = Interval::new(-9.0, 9.0)?;
    Ok(Nominal::from_surfaces(vec![Plane::new(Frame::WORLD, range, range).to_nurbs()?])?)
}

/// Eleven points with heights −5, …, 5 hundredths.
fn heights() -> Vec<Point3<f64>> {
    (0..11).map(|i| Point3::new(scattered(i, 0), scattered(i, 1), (i as f64 - 5.0) / 100.0)).collect()
}

fn options(half: f64) -> Result<InspectionOptions, Failure> {
    Ok(InspectionOptions::new(Tolerance::symmetric(half)?))
}

fn statistics() -> Result<f64, Failure> {
    let found = Statistics::of((-5..=5).map(f64::from)).ok_or("there are no statistics")?;
    let median = found.quantile(0.5).unwrap_or(f64::NAN);
    let rms = (found.rms - 10f64.sqrt()).abs();
    Ok(largest([found.mean.abs(), rms, (found.standard_deviation - 11f64.sqrt()).abs(), median.abs()]))
}

fn plane() -> Result<f64, Failure> {
    let found = nominal()?.measure(&heights(), None, &options(1.0)?, &no_progress)?;
    Ok(largest(found.iter().zip(heights()).map(|(deviation, point)| (deviation.distance - point.z).abs())))
}

fn shares() -> Result<f64, Failure> {
    let total = nominal()?.inspect(&heights(), &options(0.025)?)?.total;
    let wrong = total.under.abs_diff(3) + total.within.abs_diff(5) + total.over.abs_diff(3);
    Ok(wrong as f64)
}

fn slanted() -> Result<f64, Failure> {
    let direction = [3f64.sqrt() / 2.0, 0.0, 0.5];
    let options = options(1.0)?.with_along(Along::Direction(direction));
    let found = nominal()?.measure(&heights(), None, &options, &no_progress)?;
    let pairs = found.iter().zip(heights());
    Ok(largest(pairs.map(|(deviation, point)| (deviation.distance - 2.0 * point.z).abs())))
}

fn tiles() -> Result<f64, Failure> {
    let nominal = nominal()?;
    let options = options(0.02)?;
    let points: Vec<_> = (0..3000)
        .map(|i| Point3::new(scattered(i, 0), scattered(i, 1), 0.1 * scattered(i, 2) - 0.05))
        .collect();
    let part = |range: std::ops::Range<usize>| -> Result<Partial, Failure> {
        let tile = &points[range.clone()];
        let deviations = nominal.measure(tile, None, &options, &no_progress)?;
        let mut part = Partial::new(&options)?;
        part.extend(range.start as u64, tile, &deviations);
        Ok(part)
    };
    let whole = part(0..3000)?.finish(&options, nominal.shapes())?;
    let mut merged = part(2100..3000)?;
    merged.merge(&part(0..700)?)?;
    merged.merge(&part(700..2100)?)?;
    Ok(f64::from(u8::from(merged.finish(&options, nominal.shapes())? != whole)))
}

fn radii() -> Result<f64, Failure> {
    let nominal = Nominal::from_analytic(&[Sphere::new(Frame::WORLD, 2.0)?.into()])?;
    let larger = Sphere::new(Frame::WORLD, 2.01)?.to_nurbs()?;
    let [u, v] = industrial_geometry::nurbs::ParametricSurface::domain(&larger);
    let at = |range: &Interval, share: f64| range.start() + range.length() * share;
    let point = |i: usize| {
        let (u, v) = (at(&u, scattered(i, 0)), at(&v, scattered(i, 1)));
        Point3::from(industrial_geometry::nurbs::ParametricSurface::point(&larger, u, v))
    };
    let found = nominal.inspect(&(0..500).map(point).collect::<Vec<_>>(), &options(0.1)?)?.total;
    let statistics = found.distance.ok_or("there are no statistics")?;
    Ok(largest([(statistics.min - 0.01).abs(), (statistics.max - 0.01).abs()]))
}
