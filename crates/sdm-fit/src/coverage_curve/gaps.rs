//! What distances between neighbours are usual, and from where on there is a gap.

use distance_field::quantile_in_place;

/// Gaps that may stand out: at least so many, at most this share of all, and by which factor from the next.
const FEW: usize = 8;
const RARE: usize = 50;
const STANDS_OUT: f64 = 3.0;
/// Difference of the upper and the lower quartile of exponentially distributed gaps, as random points leave them, in units of their mean.
const QUARTILES: f64 = 1.0986;
/// Beyond the upper quartile, in units of that mean, besides the logarithm of the number of gaps: random points leave a larger gap
/// once in two hundred times.
const BEYOND: f64 = 5.0;
/// The same for the second largest gap, the third and the fourth: that several of random points are as long happens as rarely only if they are shorter.
/// And where more than their length speaks for a gap.
pub(crate) const SEVERAL: [f64; 3] = [1.8, 0.6, 0.0];
pub(crate) const PRESUMED: [f64; 3] = [1.2, -0.1, -0.8];
/// And in units of what nine of ten gaps do not exceed.
const EVEN: f64 = 2.0;
/// Neighbouring gaps on either side that tell how far apart points are there, and in units of their median what belongs to them.
const BESIDE: usize = 6;
const LOCAL: f64 = 3.0;
/// Share of the mean up to which gaps are added up, but for rounding.
const TOGETHER: f64 = 0.999;

/// The gap up to which the next ones on a line count as neighbours, judged by all gaps in their order: evenly spaced points may be twice as far apart
/// as most of them, random ones by as much as random points are. And the one up to which each of several does, infinite unless several are longer: two
/// long gaps, as where a curve passes from one outline to another and back, may each be shorter than a single one.
///
/// Gaps are added up until they reach their mean, so that points which come in clusters are judged by the distances of these. Few gaps that
/// are much longer than all others do not count. Infinite for fewer than three gaps.
pub(crate) fn gap_limits_of(gaps: &[f64], several: [f64; 3]) -> [f64; 2] {
    let Some(sorted) = without_those_that_stand_out(gaps) else { return [f64::INFINITY; 2] };
    let largest = sorted.first().copied().unwrap_or(0.0);
    let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
    let (mut sums, mut sum) = (Vec::new(), 0.0);
    for gap in gaps.iter().copied().filter(|g| *g > 0.0 && *g <= largest) {
        sum += gap;
        if sum >= TOGETHER * mean {
            sums.push(sum);
            sum = 0.0;
        }
    }
    let [q25, q75, q90] = [0.25, 0.75, 0.9].map(|share| quantile_in_place(&mut sums, share));
    let scale = (q75 - q25) / QUARTILES;
    // Nor by more than what would stand out.
    let count = (gaps.len() as f64).ln();
    let limit = |beyond: f64| (EVEN * q90).max((q75 + scale * (count + beyond)).min(STANDS_OUT * largest));
    let mut longest: Vec<f64> = gaps.iter().copied().filter(|g| *g > 0.0).collect();
    longest.sort_by(|a, b| b.total_cmp(a));
    let exceeded = longest.iter().skip(1).zip(several.map(limit)).filter(|(gap, limit)| *gap > limit);
    [limit(BEYOND), exceeded.map(|(_, limit)| limit).fold(f64::INFINITY, f64::min)]
}

/// For each gap in its order the length up to which it is like those beside it, before it or behind it: points may be dense in one part of a curve and
/// wide apart in another. 0 where too few are beside it.
pub(crate) fn gap_limits(gaps: &[f64], closed: bool) -> Vec<f64> {
    let n = gaps.len();
    let median = |beside: &mut Vec<f64>| {
        if beside.len() < BESIDE { 0.0 } else { quantile_in_place(beside, 0.5) }
    };
    let limit = |k: usize| {
        let (mut before, mut behind) = (Vec::with_capacity(BESIDE), Vec::with_capacity(BESIDE));
        for step in 1..=BESIDE.min(n.saturating_sub(1)) {
            if closed || k >= step {
                before.push(gaps[(k + n - step) % n]);
            }
            if closed || k + step < n {
                behind.push(gaps[(k + step) % n]);
            }
        }
        LOCAL * median(&mut before).max(median(&mut behind))
    };
    (0..n).map(limit).collect()
}

/// The gap that half of the length does not exceed.
pub(crate) fn usual_gap(gaps: &[f64]) -> f64 {
    without_those_that_stand_out(gaps).map_or(0.0, |sorted| by_length(&sorted, 0.5))
}

/// Positive gaps in decreasing order without the largest one and others that are much longer than the rest.
fn without_those_that_stand_out(gaps: &[f64]) -> Option<Vec<f64>> {
    let mut sorted: Vec<f64> = gaps.iter().copied().filter(|g| *g > 0.0 && g.is_finite()).collect();
    if sorted.len() < 3 {
        return None;
    }
    sorted.sort_by(|a, b| b.total_cmp(a));
    let most = (sorted.len() / RARE).max(FEW).min(sorted.len() / 3);
    let out = (1..=most).rev().find(|&j| sorted[j - 1] > STANDS_OUT * sorted[j]).unwrap_or(1);
    Some(sorted.split_off(out))
}

/// The gap that a share of the length of all does not exceed.
fn by_length(decreasing: &[f64], share: f64) -> f64 {
    let total: f64 = decreasing.iter().sum();
    let mut sum = 0.0;
    for gap in decreasing.iter().rev() {
        sum += gap;
        if sum >= share * total {
            return *gap;
        }
    }
    decreasing.first().copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap_limit(gaps: &[f64]) -> f64 {
        let [single, several] = gap_limits_of(gaps, SEVERAL);
        single.min(several)
    }

    fn random_gaps(count: usize, seed: u64) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut uniform = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            ((state >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0
        };
        (0..count).map(|_| -uniform().ln()).collect()
    }

    #[test]
    fn even_points_may_be_twice_as_far_apart() {
        let mut gaps = vec![1.0; 40];
        assert!((gap_limit(&gaps) - 2.0).abs() < 1e-12 && usual_gap(&gaps) == 1.0);
        gaps[7] = 8.0;
        gaps[19] = 7.0;
        assert!((gap_limit(&gaps) - 2.0).abs() < 1e-12);
        assert!(gap_limit(&gaps[..2]).is_infinite());
    }

    #[test]
    fn gaps_are_compared_with_those_beside_them() {
        // Dense, then wide apart, then dense again; and a hole where they are dense.
        let mut gaps = vec![0.1; 40];
        gaps[10..25].fill(2.0);
        gaps[33] = 2.0;
        for closed in [false, true] {
            let limits = gap_limits(&gaps, closed);
            assert!(
                gaps.iter().zip(&limits).enumerate().all(|(k, (gap, limit))| (gap <= limit) == (k != 33))
            );
        }
        assert_eq!(gap_limits(&[1.0, 2.0], true), [0.0, 0.0]);
    }

    #[test]
    fn two_long_gaps_are_rarer_than_one() {
        let bridged = |lengths: &[f64]| {
            let mut gaps = random_gaps(150, 5).into_iter().map(|g| g.min(4.0)).collect::<Vec<_>>();
            lengths.iter().enumerate().for_each(|(k, length)| gaps[40 + 50 * k] = *length);
            gap_limit(&gaps)
        };
        assert!(bridged(&[9.3]) > 9.3 && bridged(&[9.3, 9.3]) < 9.3);
    }

    #[test]
    fn random_points_have_no_gaps_and_clusters_neither() {
        let mut beyond = 0;
        for seed in 1..400 {
            let gaps = random_gaps(150, seed);
            let largest = gaps.iter().copied().fold(0.0, f64::max);
            let limit = gap_limit(&gaps);
            assert!(limit > 4.0 && limit < 20.0, "{seed}: {limit}");
            beyond += usize::from(largest > limit);
        }
        assert!(beyond <= 8, "{beyond} of 399");
        // Ten points at each of a hundred places.
        let clusters: Vec<f64> = (0..1000).map(|i| if i % 10 == 0 { 1.0 } else { 1e-3 }).collect();
        assert!(gap_limit(&clusters) >= 2.0);
    }
}
