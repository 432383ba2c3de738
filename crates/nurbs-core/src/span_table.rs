//! What a knot vector works out once so that evaluation neither searches nor divides.

/// Highest degree with compiled paths of its own; above it the general recurrence runs.
pub(crate) const MAX_FIXED_DEGREE: usize = 5;

/// A number so large that the last digit of its mantissa stands for one.
const ROUND: f64 = (1_u64 << 52) as f64;

/// Candidate spans up to this number are walked through, more are bisected.
const WALK: usize = 8;

/// Reciprocals of the knot differences of every span, and a lookup from parameter to span.
#[derive(Clone, PartialEq)]
pub(crate) struct SpanTable {
    /// `p(p+1)/2` numbers for each span, in the order in which the recurrence uses them.
    /// Empty above [`MAX_FIXED_DEGREE`], where they would outgrow the control points.
    reciprocals: Vec<f64>,
    /// Equal parts of the domain, the first and the last one half as long.
    buckets: Vec<Bucket>,
    start: f64,
    /// Buckets per unit of the parameter.
    scale: f64,
    /// Index of the last bucket.
    last: f64,
}

/// The spans that the parameters of one part of the domain lie in.
#[derive(Clone, Copy, PartialEq)]
struct Bucket {
    /// The last non-empty span that starts before this part (the first span, if there is none).
    before: usize,
    /// The last non-empty span that starts before the next part.
    last: usize,
    /// Where `last` starts; infinite if other spans start in this part as well.
    knot: f64,
}

// A knot vector prints its knots; what follows from them would bury them.
impl std::fmt::Debug for SpanTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("SpanTable")
    }
}

impl SpanTable {
    /// The table of validated knots.
    pub(crate) fn new(degree: usize, knots: &[f64]) -> Self {
        let n = knots.len() - degree - 1;
        let mut reciprocals = Vec::new();
        if degree <= MAX_FIXED_DEGREE {
            reciprocals.reserve_exact((n - degree) * per_span(degree));
            for span in degree..n {
                for j in 1..=degree {
                    for r in 0..j {
                        reciprocals.push(reciprocal(knots[span + r + 1] - knots[span + r + 1 - j]));
                    }
                }
            }
        }
        // Twice as many buckets as spans: on uniform knots no bucket has more than one knot.
        let count = 2 * (n - degree);
        let scale = count as f64 / (knots[n] - knots[degree]);
        let last = count as f64;
        let mut table = Self { reciprocals, buckets: Vec::new(), start: knots[degree], scale, last };
        table.buckets = table.sorted_in(count + 1, knots, (degree..n).filter(|&i| knots[i + 1] > knots[i]));
        table
    }

    /// The buckets of the non-empty spans, which come in order.
    fn sorted_in(&self, count: usize, knots: &[f64], spans: impl Iterator<Item = usize>) -> Vec<Bucket> {
        let mut spans = spans.peekable();
        // The first span starts with the first bucket.
        let mut before = spans.peek().copied().unwrap_or_default();
        let mut buckets = Vec::with_capacity(count);
        for index in 0..count {
            let (mut last, mut starts) = (before, 0);
            while let Some(span) = spans.next_if(|&span| self.bucket(knots[span]) == index) {
                last = span;
                starts += usize::from(span != before);
            }
            let knot = if starts <= 1 { knots[last] } else { f64::INFINITY };
            buckets.push(Bucket { before, last, knot });
            before = last;
        }
        buckets
    }

    /// The bucket of a parameter; of the first or last one outside of the domain, of the first one for NaN.
    /// Monotone in `t`, whatever the rounding: what the search relies on.
    #[expect(clippy::cast_possible_truncation, reason = "an index of the buckets")]
    #[inline(always)]
    fn bucket(&self, t: f64) -> usize {
        let x = (t - self.start) * self.scale;
        // A sum of this size ends with the number rounded to an integer: a third of the instructions of a
        // cast, which has to think of numbers that are none.
        let x = if x > 0.0 { x } else { 0.0 };
        let x = if x < self.last { x } else { self.last };
        ((x + ROUND).to_bits() - ROUND.to_bits()) as usize
    }

    /// The span of `t` among the knots that the table was made of; outside of the domain, and for
    /// NaN, the first or last non-empty span of it.
    #[inline(always)]
    pub(crate) fn span(&self, knots: &[f64], t: f64) -> usize {
        self.span_without_search(t).unwrap_or_else(|| {
            let bucket = &self.buckets[self.bucket(t)];
            search(knots, bucket.before, bucket.last, t)
        })
    }

    /// [`span`](Self::span) where the table says it: everywhere but near knots that lie close together.
    #[inline(always)]
    pub(crate) fn span_without_search(&self, t: f64) -> Option<usize> {
        // A knot in an earlier bucket lies before t, one in a later bucket after it.
        let Bucket { before, last, knot } = self.buckets[self.bucket(t)];
        // No branch that a processor could mispredict.
        let span = if knot <= t { last } else { before };
        (knot < f64::INFINITY).then_some(span)
    }

    /// `1 / (t_{s+r+1} − t_{s+r+1−j})` for `j = 1…p`, `r = 0…j−1`, at index `j(j−1)/2 + r`.
    #[inline]
    pub(crate) fn reciprocals(&self, degree: usize, span: usize) -> &[f64] {
        let count = per_span(degree);
        &self.reciprocals[(span - degree) * count..][..count]
    }
}

/// The last of the spans `low..=high` that starts at or before `t`.
#[inline(never)]
fn search(knots: &[f64], mut low: usize, high: usize, t: f64) -> usize {
    if high - low > WALK {
        return low + knots[low + 1..=high].partition_point(|&k| k <= t);
    }
    while low < high && knots[low + 1] <= t {
        low += 1;
    }
    low
}

/// How many reciprocals the recurrence of a degree needs.
pub(crate) const fn per_span(degree: usize) -> usize {
    degree * (degree + 1) / 2
}

/// `1 / h`, next to it where only that gives `h · (1 / h) = 1`: then the shape passes exactly through
/// the end points of a clamped net.
fn reciprocal(h: f64) -> f64 {
    if h <= 0.0 {
        return 0.0; // of an empty span, which nothing is evaluated on
    }
    let nearest = 1.0 / h;
    let candidates = [nearest, nearest.next_up(), nearest.next_down()];
    candidates.into_iter().find(|&x| h * x == 1.0).unwrap_or(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::KnotVector;

    #[test]
    fn the_table_finds_what_a_scan_finds() {
        let clustered: Vec<f64> = (0..40).map(|i| 1e-9 * f64::from(i)).collect();
        let mut inner = vec![0.0; 4];
        inner.extend(&clustered[1..]);
        inner.extend([0.2, 0.2, 0.7, 0.7, 0.7, 1.0, 1.0, 1.0, 1.0]);
        let floating: Vec<f64> = (0..12).map(|i| f64::from(i * i) - 7.0).collect();
        let vectors = [
            KnotVector::new(3, inner).unwrap(),
            KnotVector::new(2, floating).unwrap(),
            KnotVector::uniform_clamped(3, 50).unwrap(),
            KnotVector::uniform_periodic(4, 17).unwrap(),
            KnotVector::new(1, vec![0.0, 0.0, f64::MIN_POSITIVE / 8.0, f64::MIN_POSITIVE / 8.0]).unwrap(),
            KnotVector::new(1, vec![-1e308, -1e308, 0.0, 1e308, 1e308]).unwrap(),
        ];
        for k in &vectors {
            let (p, knots) = (k.degree(), k.as_slice());
            let spans: Vec<usize> = k.spans().collect();
            let mut probes: Vec<f64> = (0..=1000)
                .map(|i| f64::from(i) / 1000.0)
                .map(|s| k.domain().start() * (1.0 - s) + k.domain().end() * s)
                .collect();
            probes.extend(knots.iter().flat_map(|t| [t.next_down(), *t, t.next_up()]));
            probes.extend([f64::NEG_INFINITY, f64::INFINITY, f64::NAN]);
            for t in probes {
                let scan = spans.iter().rev().find(|&&s| knots[s] <= t).unwrap_or(&spans[0]);
                assert_eq!(k.span(t), *scan, "degree {p} t {t}");
            }
        }
    }

    #[test]
    fn reciprocals_hit_one_where_a_neighbour_does() {
        assert_eq!(49.0 * reciprocal(49.0), 1.0);
        assert_eq!(reciprocal(0.0), 0.0);
        for i in 1..2000 {
            let h = f64::from(i) * 0.1;
            assert!((h * reciprocal(h) - 1.0).abs() <= f64::EPSILON);
        }
    }
}
