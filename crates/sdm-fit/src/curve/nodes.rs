//! Neighbourhoods of points about a curve: whether they are long, and points drawn to their lines.

use crate::parallel;
use distance_field::quantile_in_place;
use mesh_core::CloudIndex;
use nalgebra::{DMatrix, Point, SVector};

/// Passes that draw points to the local line.
const PASSES: usize = 4;
/// Width of a neighbourhood as a share of its length up to which its direction is that of its main axis.
const NARROW: f64 = 0.3;
/// Directions tried where branches cross, and width of the band about them as a share of the neighbourhood.
const DIRECTIONS: usize = 24;
const BAND: f64 = 0.2;
/// Neighbours in whose reach a point must have others in line with it, fewest points for that, and share of those that may have none.
const SUPPORT: usize = 8;
const FEW: usize = 60;
const OFF: f64 = 0.12;
/// How many others are in line with a point at least, as a share of the median.
const IN_LINE: f64 = 0.35;
/// Points that a node stands for at least, as a share of the median.
const SPARSE: f64 = 0.25;
/// Neighbourhoods that are looked at, at most.
const LOOKED_AT: usize = 500;

/// The points but for those through which there is no line along which as many neighbours lie as for others, if these are few.
pub(super) fn supported<const D: usize>(sample: Vec<SVector<f64, D>>) -> Vec<SVector<f64, D>> {
    let places: Vec<Point<f64, D>> = sample.iter().copied().map(Point::from).collect();
    let Ok(index) = CloudIndex::new(&places) else { return sample };
    let mut reach =
        index.map_nearest_n(&places, SUPPORT + 1, |_, near| near.last().map_or(0.0, |n| n.distance()));
    let radius = quantile_in_place(&mut reach, 0.5);
    if sample.len() < FEW || radius.is_nan() || radius <= 0.0 {
        return sample;
    }
    let band = BAND * radius;
    let counts = parallel::tasks(sample.len(), |i| {
        let near = index.within(&places[i], radius);
        let others: Vec<SVector<f64, D>> =
            near.iter().filter(|n| n.index != i).map(|n| sample[n.index] - sample[i]).collect();
        let stride = others.len().div_ceil(DIRECTIONS).max(1);
        let along = others.iter().step_by(stride).filter_map(|p| p.try_normalize(0.0)).map(|way| {
            others.iter().filter(|p| (*p - way * way.dot(p)).norm_squared() < band * band).count()
        });
        (along.max().unwrap_or(0), others.len())
    });
    let mut sorted: Vec<f64> = counts.iter().map(|c| c.0 as f64).collect();
    let few = IN_LINE * quantile_in_place(&mut sorted, 0.5);
    let stands = |&(along, all): &(usize, usize)| all > 1 && (along as f64 >= few || 2 * along >= all);
    let kept: Vec<SVector<f64, D>> =
        sample.iter().zip(&counts).filter(|(_, count)| stands(count)).map(|(p, _)| *p).collect();
    if (sample.len() - kept.len()) as f64 <= OFF * sample.len() as f64 { kept } else { sample }
}

/// Median of the widths of neighbourhoods as shares of their lengths.
pub(super) fn roundness<const D: usize>(
    index: &CloudIndex<D>,
    sample: &[SVector<f64, D>],
    radius: f64,
) -> f64 {
    let stride = sample.len().div_ceil(LOOKED_AT).max(1);
    let some: Vec<&SVector<f64, D>> = sample.iter().step_by(stride).collect();
    let mut shares = parallel::tasks(some.len(), |i| {
        let near = index.within(&Point::from(*some[i]), radius);
        local_line(sample, &near, radius).map_or(1.0, |line| line.2)
    });
    quantile_in_place(&mut shares, 0.5)
}

/// Nodes that stand for about as many points as others.
pub(super) fn dense<const D: usize>(
    drawn: &[SVector<f64, D>],
    nodes: Vec<SVector<f64, D>>,
    radius: f64,
) -> Vec<SVector<f64, D>> {
    let places: Vec<Point<f64, D>> = drawn.iter().copied().map(Point::from).collect();
    let Ok(index) = CloudIndex::new(&places) else { return nodes };
    let counts = parallel::map(nodes.len(), |i| index.within(&Point::from(nodes[i]), radius).len());
    let mut sorted: Vec<f64> = counts.iter().map(|c| *c as f64).collect();
    let median = quantile_in_place(&mut sorted, 0.5);
    nodes.into_iter().zip(counts).filter(|(_, count)| *count as f64 >= SPARSE * median).map(|n| n.0).collect()
}

/// Points drawn to the line through their neighbourhoods, a few times; where branches cross, to the line of the branch they are on.
pub(super) fn draw<const D: usize>(
    index: &CloudIndex<D>,
    sample: &[SVector<f64, D>],
    radius: f64,
) -> Vec<SVector<f64, D>> {
    parallel::tasks(sample.len(), |i| {
        let mut x = sample[i];
        for _ in 0..PASSES {
            let near = index.within(&Point::from(x), radius);
            let Some((mut centre, mut direction, width)) = local_line(sample, &near, radius) else { break };
            if width > NARROW {
                (centre, direction) = branch(sample, &near, &x, radius);
            }
            x = centre + direction * direction.dot(&(x - centre));
        }
        x
    })
}

/// The line through a point along which most neighbours lie, moved to where they do.
fn branch<const D: usize>(
    sample: &[SVector<f64, D>],
    near: &[mesh_core::Neighbour],
    x: &SVector<f64, D>,
    radius: f64,
) -> (SVector<f64, D>, SVector<f64, D>) {
    let band = BAND * radius;
    let weight = |p: &SVector<f64, D>, origin: &SVector<f64, D>, way: &SVector<f64, D>| {
        let away = p - origin;
        let across = (away - way * way.dot(&away)).norm_squared() / (band * band);
        if across < 1.0 { (1.0 - across).powi(2) } else { 0.0 }
    };
    let outer: Vec<&SVector<f64, D>> =
        near.iter().map(|n| &sample[n.index]).filter(|p| (*p - x).norm() > 0.4 * radius).collect();
    let stride = outer.len().div_ceil(DIRECTIONS).max(1);
    let mut best = (0.0, SVector::zeros());
    for p in outer.iter().step_by(stride) {
        let Some(way) = (*p - x).try_normalize(0.0) else { continue };
        let sum: f64 = near.iter().map(|n| weight(&sample[n.index], x, &way)).sum();
        if sum > best.0 {
            best = (sum, way);
        }
    }
    let (mut origin, mut way) = (*x, best.1);
    for _ in 0..2 {
        let weights: Vec<f64> = near.iter().map(|n| weight(&sample[n.index], &origin, &way)).collect();
        let Some((centre, direction, _)) = moments(sample, near, &weights) else { break };
        (origin, way) = (centre, direction);
    }
    (origin, way)
}

/// The line of least squares through a neighbourhood: its centre, its direction, and its width as a share of its length.
fn local_line<const D: usize>(
    sample: &[SVector<f64, D>],
    near: &[mesh_core::Neighbour],
    radius: f64,
) -> Option<(SVector<f64, D>, SVector<f64, D>, f64)> {
    let weight = |n: &mesh_core::Neighbour| (1.0 - n.distance_sq / (radius * radius)).max(0.0).powi(2);
    let weights: Vec<f64> = near.iter().map(weight).collect();
    moments(sample, near, &weights)
}

fn moments<const D: usize>(
    sample: &[SVector<f64, D>],
    near: &[mesh_core::Neighbour],
    weights: &[f64],
) -> Option<(SVector<f64, D>, SVector<f64, D>, f64)> {
    let total: f64 = weights.iter().sum();
    if near.len() < 3 || total <= 0.0 {
        return None;
    }
    let pairs = || near.iter().zip(weights);
    let centre = pairs().map(|(n, w)| sample[n.index] * *w).sum::<SVector<f64, D>>() / total;
    let mut moments = DMatrix::zeros(D, D);
    for (n, weight) in pairs() {
        let r = sample[n.index] - centre;
        for a in 0..D {
            for b in 0..D {
                moments[(a, b)] += weight * r[a] * r[b];
            }
        }
    }
    let (direction, values) = principal(moments)?;
    let [first, second] = [0, 1].map(|k| values.get(k).copied().unwrap_or(0.0).max(0.0));
    Some((centre, direction, if first > 0.0 { (second / first).sqrt() } else { 1.0 }))
}

/// The eigenvector of the largest eigenvalue of a symmetric matrix, and all eigenvalues in decreasing order.
pub(crate) fn principal<const D: usize>(moments: DMatrix<f64>) -> Option<(SVector<f64, D>, Vec<f64>)> {
    if moments.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let eigen = moments.symmetric_eigen();
    let direction = SVector::from_fn(|i, _| eigen.eigenvectors[(i, eigen.eigenvalues.imax())]);
    let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    Some((direction, values))
}

/// Points of which no two are nearer than `spacing`, by first come.
pub(super) fn thin<const D: usize>(points: &[SVector<f64, D>], spacing: f64) -> Vec<SVector<f64, D>> {
    let mut out: Vec<SVector<f64, D>> = Vec::new();
    for p in points {
        if out.iter().all(|q| (p - q).norm() >= spacing) {
            out.push(*p);
        }
    }
    out
}
