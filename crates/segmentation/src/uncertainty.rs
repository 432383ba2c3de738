//! Covariance of the unknowns of a carrier: what noise brings, and what neighbours may bring.
//!
//! Points next to a border belong to the neighbour with some probability: its surface explains them as well. They pull the carrier to
//! their side all together, which the covariance of independent noise does not know.

use nalgebra::DMatrix;

use crate::carrier::{Carrier, Row};
use crate::graph::as_index;
use crate::grow::{Cloud, NONE, Region};
use crate::least_squares::normal_equations;

/// Neighbours of a point among which others with another label tell that it lies next to a border.
const AROUND: usize = 16;
/// Distance in standard deviations up to which a neighbour explains a point, and up to which points of another surface are taken along.
const POSSIBLE: f64 = 3.0;
/// Fewest points for each unknown that a fit without the points of a neighbour needs to tell what they bring.
const ENOUGH: usize = 2;

/// Covariance of the unknowns of the carrier of a region, fitted to some of its points; `None` where these do not determine them.
///
/// The sum of the covariance of the noise (of the residuals, where they are larger) and, for each region beside it, of the squares of two
/// changes: that from leaving out the points which the other explains as well, and that from moving these to where they would lie
/// if they belonged to it.
pub(crate) fn covariance(
    cloud: &Cloud<'_>,
    regions: &[Region],
    labels: &[u32],
    own: usize,
    core: &[u32],
) -> Option<DMatrix<f64>> {
    let region = &regions[own];
    let carrier = region.carrier?;
    let n = carrier.unknowns();
    let points = cloud.positions(core);
    let (_, _, matrix) = normal_equations(&carrier, &points);
    let inverse = matrix.view((0, 0), (n, n)).clone_owned().cholesky()?.inverse();
    let mut sum = &inverse * cloud.sigma.max(region.rms).powi(2);
    let mut add = |step: &Row| {
        let step = step.rows(0, n);
        if step.iter().all(|x| x.is_finite()) {
            sum += step * step.transpose();
        }
    };
    for other in beside(cloud, labels, own, core) {
        let doubtful: Vec<(bool, f64)> = core
            .iter()
            .map(|&i| doubt(cloud, regions, labels, &carrier, other, i).map_or((false, 0.0), |e| (true, e)))
            .collect();
        let mut pull = Row::zeros();
        for (x, (_, offset)) in points.iter().zip(&doubtful).filter(|(_, (is_doubtful, _))| *is_doubtful) {
            pull += carrier.linear(x).1 * *offset;
        }
        let mut moved = Row::zeros();
        moved.rows_mut(0, n).copy_from(&(&inverse * pull.rows(0, n)));
        add(&moved);
        let sure: Vec<_> = points.iter().zip(&doubtful).filter(|(_, d)| !d.0).map(|(x, _)| *x).collect();
        if sure.len() < points.len() && sure.len() >= ENOUGH * n {
            let (_, gradient, matrix) = normal_equations(&carrier, &sure);
            if let Some(factor) = matrix.cholesky() {
                add(&factor.solve(&gradient));
            }
        }
    }
    sum.iter().all(|x| x.is_finite()).then_some(sum)
}

/// Labels of the regions beside some points, ascending, and none.
fn beside(cloud: &Cloud<'_>, labels: &[u32], own: usize, points: &[u32]) -> Vec<u32> {
    let mut found: Vec<u32> = points
        .iter()
        .flat_map(|&i| cloud.graph.near(i as usize).iter().take(AROUND).map(|&j| labels[j as usize]))
        .filter(|&label| label != as_index(own))
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// How far from the carrier a point would lie if it belonged to another region; `None` where it does not.
fn doubt(
    cloud: &Cloud<'_>,
    regions: &[Region],
    labels: &[u32],
    carrier: &Carrier,
    other: u32,
    i: u32,
) -> Option<f64> {
    let near = cloud.graph.near(i as usize).iter().take(AROUND);
    if !near.into_iter().any(|&j| labels[j as usize] == other) {
        return None;
    }
    let most = POSSIBLE * cloud.sigma;
    let second = if other == NONE { None } else { regions[other as usize].carrier };
    match second {
        Some(second) => {
            let x = &cloud.points[i as usize];
            let (away, normal) = second.at(x);
            (away.abs() < most).then(|| carrier.at(&(x - normal * away)).0.clamp(-most, most))
        }
        // Nothing is known of its surface: the middle of what is taken along.
        None => Some(0.5 * most),
    }
}
