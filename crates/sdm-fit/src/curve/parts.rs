//! Nodes put in order: one or more chains, each open or closed.

use super::path::Path;
use super::pieces::{are_apart, between, is_ring, join};
use super::tour::{cost, neighbours, short_tour};
use super::tree::{Groups, shortest_forest};
use crate::coverage_curve::{PRESUMED, gap_limits, gap_limits_of};
use distance_field::quantile_in_place;
use nalgebra::SVector;

/// Difference of the quartiles of exponentially distributed gaps in units of their mean; what isolates a point, in units of that beyond the
/// upper quartile besides the logarithm of the number of points; and at least, in units of what nine tenths of the gaps do not exceed.
const QUARTILES: f64 = 1.0986;
const BEYOND: f64 = 5.0;
const ISOLATED: f64 = 2.5;
/// Points that a part has at least, as a share of all and in number, and the share that isolated points and smaller parts may have.
const PART: f64 = 0.03;
const FEWEST: usize = 3;
const STRAY: f64 = 0.1;
/// How much wider than usual gaps are those between several curves: what is little more is rather a gap of one curve.
const SPLIT: f64 = 1.3;
/// Gap between the ends of a path, in units of its longest step, up to which it is closed.
const RING: f64 = 2.0;
/// Cosine of a turn that is a spike if what it leads to is far away, in units of most steps.
const SPIKE: f64 = -0.3;
const FAR: f64 = 1.5;
/// Most places where a tour is cut: what falls into more pieces is no curve.
const MOST: usize = 64;
/// Steps of a path that branches take to cross each other.
const ACROSS: f64 = 2.0;
/// Nodes that tell whether chains run beside each other; places along a chain that are next to each other; distance of what is beside a node, in
/// steps; share of such nodes; and how far off the line between the next ones they are, as a share of that distance.
const SEEN: usize = 40;
const NEXT: usize = 6;
const BESIDE: f64 = 1.5;
const MANY: f64 = 0.12;
const ROUGH: f64 = 0.15;
/// How much longer than the mean of the edges, besides the logarithm of their number, an edge of one piece is at most.
const RANDOM: f64 = 1.0;
/// What a node costs that is an outlier, in units of most steps, and how often nodes are looked at again when there were some.
const DETOUR: f64 = 8.0;
const DETOURS: usize = 4;
/// Cosine of directions that are the same.
const PARALLEL: f64 = 0.8;
/// Nodes so few that no path says whether they lie on a curve.
const FEW: usize = 24;

/// What was made of nodes.
#[derive(Clone, Debug)]
pub(super) struct Parts<const D: usize> {
    /// The chains, in the order of their first nodes.
    pub(super) paths: Vec<Path<D>>,
    /// Median of the angles by which they turn at a node.
    pub(super) turn: f64,
    /// Whether they run to and fro beside each other, as they do through points that lie about a curve.
    pub(super) lanes: bool,
}

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    /// Whether there is one closed chain, one open one, or what the nodes show.
    pub(super) closed: Option<bool>,
    /// Length without points that is no gap.
    pub(super) gap: Option<f64>,
    /// Whether single points may belong to nothing.
    pub(super) outliers: bool,
}

/// Chains through nodes of which no two are equal, by their distances; `raw` are the points that nodes stand for, if they are not the points
/// themselves. `None` if most nodes belong to no chain.
pub(super) fn chains<const D: usize>(
    nodes: &[SVector<f64, D>],
    raw: Option<&[SVector<f64, D>]>,
    asked: Asked,
) -> Option<Parts<D>> {
    let nodes = connected(nodes)?;
    let near = neighbours(&nodes)?;
    let forest = shortest_forest(&nodes, &near);
    let mean = forest.iter().map(|e| e.2).sum::<f64>() / forest.len().max(1) as f64;
    // As far apart as random points are.
    let cap = asked.gap.unwrap_or(0.0).max(mean * (RANDOM + (nodes.len() as f64).ln()));
    let tour: Vec<SVector<f64, D>> = short_tour(&nodes, &near, cap).into_iter().map(|i| nodes[i]).collect();
    let mut tour = without_spikes(tour, true);
    if asked.outliers {
        for _ in 0..DETOURS {
            let before = tour.len();
            tour = without_detours(tour, cap);
            if tour.len() == before {
                break;
            }
        }
    }
    let steps: Vec<f64> = (0..tour.len()).map(|k| (tour[(k + 1) % tour.len()] - tour[k]).norm()).collect();
    let Some(raw) = raw else { return Some(cut(tour, &steps, 0.0, asked, false)) };
    let gaps = gaps_of(raw, &tour, &steps, cap);
    // Where branches meet, points count for one of them, and the other has none on the way across.
    let step = quantile_in_place(&mut steps.clone(), 0.5);
    let mut parts = cut(tour, &gaps, ACROSS * step, asked, false);
    for path in &mut parts.paths {
        without_overlap(path, BESIDE * step);
    }
    Some(parts)
}

/// Chains through nodes in their order.
pub(super) fn in_order<const D: usize>(nodes: Vec<SVector<f64, D>>, asked: Asked) -> Parts<D> {
    let nodes = without_spikes(nodes, false);
    let gaps: Vec<f64> = (0..nodes.len()).map(|k| (nodes[(k + 1) % nodes.len()] - nodes[k]).norm()).collect();
    cut(nodes, &gaps, 0.0, asked, true)
}

/// The nodes but for isolated ones, if these are few.
fn connected<const D: usize>(nodes: &[SVector<f64, D>]) -> Option<Vec<SVector<f64, D>>> {
    let near = neighbours(nodes)?;
    let forest = shortest_forest(nodes, &near);
    let mut lengths: Vec<f64> = forest.iter().map(|e| e.2).collect();
    let [q25, q75, q90] = [0.25, 0.75, 0.9].map(|share| quantile_in_place(&mut lengths, share));
    let scale = (q75 - q25) / QUARTILES;
    let limit = (ISOLATED * q90).max(q75 + scale * ((nodes.len() as f64).ln() + BEYOND));
    let mut groups = Groups::new(nodes.len());
    for &(i, j, _) in forest.iter().filter(|e| e.2 <= limit) {
        groups.connect(i, j);
    }
    let mut sizes = vec![0; nodes.len()];
    (0..nodes.len()).for_each(|i| sizes[groups.first(i)] += 1);
    let fewest = least(nodes.len());
    let kept: Vec<SVector<f64, D>> =
        (0..nodes.len()).filter(|&i| sizes[groups.first(i)] >= fewest).map(|i| nodes[i]).collect();
    let dropped = nodes.len() - kept.len();
    // Where many are isolated it is not them that are strange.
    let kept = if dropped as f64 <= STRAY * nodes.len() as f64 { kept } else { nodes.to_vec() };
    (kept.len() >= 4).then_some(kept)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a number")]
fn least(count: usize) -> usize {
    FEWEST.max((PART * count as f64) as usize)
}

/// The nodes but for those to which a chain goes far and back: further than most of its steps.
fn without_spikes<const D: usize>(nodes: Vec<SVector<f64, D>>, closed: bool) -> Vec<SVector<f64, D>> {
    let n = nodes.len();
    let mut steps: Vec<f64> = nodes.windows(2).map(|p| (p[1] - p[0]).norm()).collect();
    let far = FAR * quantile_in_place(&mut steps, 0.5);
    let is_spike = |k: usize| {
        if !closed && (k == 0 || k + 1 == n) {
            return false;
        }
        let (a, b) = (nodes[k] - nodes[(k + n - 1) % n], nodes[(k + 1) % n] - nodes[k]);
        let (first, second) = (a.norm(), b.norm());
        first.min(second) > far && a.dot(&b) < SPIKE * first * second
    };
    let kept: Vec<SVector<f64, D>> = (0..n).filter(|&k| !is_spike(k)).map(|k| nodes[k]).collect();
    if n - kept.len() <= n / 10 { kept } else { nodes }
}

/// The nodes of a closed tour but for those that are a long way round, where some may be outliers.
fn without_detours<const D: usize>(nodes: Vec<SVector<f64, D>>, cap: f64) -> Vec<SVector<f64, D>> {
    let n = nodes.len();
    let mut steps: Vec<f64> = nodes.windows(2).map(|p| (p[1] - p[0]).norm()).collect();
    let usual = quantile_in_place(&mut steps, 0.5);
    let at = |k: usize, step: usize| nodes[(k + n + step - 2) % n];
    let mut kept = Vec::with_capacity(n);
    let mut last_kept = true;
    for k in 0..n {
        let way = [0, 1, 2, 3, 4].map(|step| at(k, step));
        let gain = cost(&way, cap) - cost(&[way[0], way[1], way[3], way[4]], cap);
        // One at a time: the next one is judged when this one is gone.
        last_kept = !(last_kept && gain > DETOUR * usual);
        if last_kept {
            kept.push(nodes[k]);
        }
    }
    if n - kept.len() <= n / 10 { kept } else { nodes }
}

/// Takes away the ends of an open path that run along other parts of it, as those of a ring that was not closed.
fn without_overlap<const D: usize>(path: &mut Path<D>, reach: f64) {
    if path.is_closed() {
        return;
    }
    for _ in 0..2 {
        path.nodes.reverse();
        let n = path.nodes.len();
        let doubled = |k: usize| {
            let next =
                if k + 1 < n { path.nodes[k + 1] - path.nodes[k] } else { path.nodes[k] - path.nodes[k - 1] };
            (0..k.saturating_sub(NEXT)).any(|j| {
                let way = path.nodes[j + 1] - path.nodes[j];
                let parallel = way.dot(&next).abs() > PARALLEL * way.norm() * next.norm();
                parallel && (path.nodes[j] - path.nodes[k]).norm() <= reach
            })
        };
        let (mut seen, mut cut) = (0, n);
        for k in (n - n / 3..n).rev() {
            seen += usize::from(doubled(k));
            if seen >= 2 && 5 * seen >= 3 * (n - k) {
                cut = k;
            }
        }
        path.nodes.truncate(cut);
    }
    path.gap = path.nodes.first().zip(path.nodes.last()).map_or(0.0, |(a, b)| (b - a).norm());
}

/// For each step of a closed tour the longest stretch of it on which no point lies; points count for the nearest step that is no
/// longer than `cap`.
fn gaps_of<const D: usize>(
    raw: &[SVector<f64, D>],
    tour: &[SVector<f64, D>],
    steps: &[f64],
    cap: f64,
) -> Vec<f64> {
    let n = tour.len();
    let places = crate::parallel::map(raw.len(), |i| {
        let mut best = (f64::INFINITY, 0, 0.0);
        for k in (0..n).filter(|&k| steps[k] <= cap) {
            let (along, away) = (tour[(k + 1) % n] - tour[k], raw[i] - tour[k]);
            let share = (along.dot(&away) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let distance = (away - along * share).norm_squared();
            if distance < best.0 {
                best = (distance, k, share);
            }
        }
        (best.1, best.2)
    });
    let mut starts = vec![0.0; n + 1];
    for k in 0..n {
        starts[k + 1] = starts[k] + steps[k];
    }
    let mut at: Vec<f64> = places.iter().map(|&(k, share)| starts[k] + share * steps[k]).collect();
    at.sort_by(f64::total_cmp);
    let mut gaps = vec![0.0; n];
    let Some(&last) = at.last() else { return steps.to_vec() };
    let mut before = last - starts[n];
    for here in at {
        let length = here - before;
        // To the step in its middle, or, where a long step is part of it, to that one.
        let middle = (before + 0.5 * length).rem_euclid(starts[n]);
        let mut step = starts[1..].partition_point(|s| *s <= middle).min(n - 1);
        for other in [(step + n - 1) % n, (step + 1) % n] {
            if steps[other] > cap && steps[step] <= cap && length > steps[other] {
                step = other;
            }
        }
        gaps[step] = f64::max(gaps[step], length);
        before = here;
    }
    gaps
}

/// A closed tour cut where its gaps are wider than neighbours may be apart; what is near to each other at the ends is joined again.
fn cut<const D: usize>(
    nodes: Vec<SVector<f64, D>>,
    gaps: &[f64],
    slack: f64,
    asked: Asked,
    ordered: bool,
) -> Parts<D> {
    let n = nodes.len();
    let widest = (0..n).max_by(|&a, &b| gaps[a].total_cmp(&gaps[b]).then(b.cmp(&a))).unwrap_or(0);
    let others = (0..n).filter(|&k| k != widest).map(|k| gaps[k]);
    let second = others.fold(0.0, f64::max);
    let by_gaps = asked
        .gap
        .map_or_else(|| gap_limits_of(gaps, PRESUMED).map(|g| g + slack), |gap| [gap, f64::INFINITY]);
    // Gaps that are too long only together lead from one outline to another if what they leave apart is closed.
    if asked.closed.is_none()
        && let Some(pieces) = rings(&nodes, gaps, by_gaps[1])
    {
        let (turn, lanes) = (median_turn(&pieces), lanes(&pieces));
        let path = |nodes: Vec<SVector<f64, D>>| {
            let gap = nodes.first().zip(nodes.last()).map_or(0.0, |(a, b)| (b - a).norm());
            Path { nodes, gap, gap_limit: by_gaps[1], ordered }
        };
        return Parts { paths: pieces.into_iter().map(path).collect(), turn, lanes };
    }
    let by_gaps = by_gaps[0];
    // Where it is asked for, it is one chain.
    let (limit, local) = match asked {
        Asked { closed: Some(_), .. } => (f64::INFINITY, Vec::new()),
        Asked { gap: Some(gap), .. } => (gap, Vec::new()),
        _ => (SPLIT * by_gaps, gap_limits(gaps, true)),
    };
    let is_cut = |k: usize| gaps[k] > local.get(k).map_or(limit, |l| limit.max(SPLIT * l));
    let mut cuts: Vec<usize> = (0..n).filter(|&k| is_cut(k)).collect();
    if cuts.len() > MOST {
        return Parts { paths: Vec::new(), turn: std::f64::consts::PI, lanes: true };
    }
    let mut pieces = Vec::new();
    if cuts.len() > 1 {
        pieces = between(&nodes, &cuts);
        join(&mut pieces, limit);
        let fewest = least(n);
        pieces.retain(|piece| piece.len() >= fewest.max(4));
        // Parts that are nearer to each other than points on them are no curves of their own: the sides of a thin section, or branches that cross.
        let along = (0..n).filter(|&k| !is_cut(k)).map(|k| gaps[k]).fold(0.0, f64::max);
        if pieces.len() > 1 && !are_apart(&pieces, along) {
            cuts.clear();
        }
    }
    // In the order of the points the way back is no step.
    let ends = if ordered { n - 1 } else { widest };
    let around = gaps[ends];
    let ring = by_gaps.max(if ends == widest { RING * second } else { 0.0 });
    if cuts.is_empty() || cuts == [ends] {
        let mut nodes = nodes;
        if asked.closed != Some(true) || ordered {
            nodes.rotate_left((ends + 1) % n);
        }
        if around == 0.0 && nodes.len() > 3 {
            // The first point is repeated at the end.
            nodes.pop();
        }
        let (turn, lanes) = (median_turn(std::slice::from_ref(&nodes)), lanes(std::slice::from_ref(&nodes)));
        let path = Path { nodes, gap: around, gap_limit: ring, ordered };
        return Parts { paths: vec![path], turn, lanes };
    }
    let (turn, lanes) = (median_turn(&pieces), lanes(&pieces));
    let path = |nodes: Vec<SVector<f64, D>>| {
        let gap = nodes.first().zip(nodes.last()).map_or(0.0, |(a, b)| (b - a).norm());
        Path { nodes, gap, gap_limit: limit, ordered }
    };
    Parts { paths: pieces.into_iter().map(path).collect(), turn, lanes }
}

/// The pieces between gaps longer than a limit, if all of them are closed but for what neighbours are apart, and so apart from each other.
fn rings<const D: usize>(
    nodes: &[SVector<f64, D>],
    gaps: &[f64],
    limit: f64,
) -> Option<Vec<Vec<SVector<f64, D>>>> {
    let cuts: Vec<usize> = (0..nodes.len()).filter(|&k| gaps[k] > limit).collect();
    if !(2..=MOST).contains(&cuts.len()) {
        return None;
    }
    let along = gaps.iter().copied().filter(|g| *g <= limit).fold(0.0, f64::max);
    let pieces = between(nodes, &cuts);
    let fewest = least(nodes.len()).max(4);
    let closed = pieces.iter().all(|piece| piece.len() >= fewest && is_ring(piece, along));
    (closed && are_apart(&pieces, along)).then_some(pieces)
}

/// Median of the angles between consecutive edges.
fn median_turn<const D: usize>(chains: &[Vec<SVector<f64, D>>]) -> f64 {
    let mut turns: Vec<f64> = Vec::new();
    for nodes in chains {
        turns.extend(nodes.windows(3).map(|p| (p[1] - p[0]).angle(&(p[2] - p[1]))));
    }
    if turns.len() < FEW { 0.0 } else { quantile_in_place(&mut turns, 0.5) }
}

/// Whether many nodes are as near to a distant part of the chains as to the next ones, and off the line between these by as much as they are from that
/// part: then it is the same curve.
fn lanes<const D: usize>(chains: &[Vec<SVector<f64, D>>]) -> bool {
    let all: Vec<SVector<f64, D>> = chains.iter().flatten().copied().collect();
    if all.len() < SEEN {
        return false;
    }
    let Some(near) = neighbours(&all) else { return false };
    let mut shares = Vec::new();
    let mut first = 0;
    for nodes in chains {
        let n = nodes.len();
        for k in 1..n.saturating_sub(1) {
            let (before, behind) = (nodes[k] - nodes[k - 1], nodes[k + 1] - nodes[k]);
            let step = before.norm().max(behind.norm());
            let apart = |j: usize| {
                let place = j.wrapping_sub(first);
                let apart = place.abs_diff(k);
                place >= n || apart.min(n - apart) > NEXT
            };
            let i = first + k;
            let Some(other) = near[i].iter().copied().find(|&j| apart(j)) else { continue };
            let distance = (all[other] - all[i]).norm();
            if distance <= BESIDE * step {
                let chord = nodes[k + 1] - nodes[k - 1];
                let along = before.dot(&chord) / chord.norm_squared().max(f64::MIN_POSITIVE);
                shares.push((before - chord * along).norm() / distance.max(f64::MIN_POSITIVE));
            }
        }
        first += n;
    }
    let many = shares.len() as f64 > MANY * all.len() as f64;
    many && quantile_in_place(&mut shares, 0.5) > ROUGH
}
