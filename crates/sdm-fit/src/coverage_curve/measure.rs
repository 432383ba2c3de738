//! Curves seen from their data.

use super::gaps::SEVERAL;
use super::spread::spreads;
use super::stop::Stop;
use super::{CurveCoverage, Stretch, gap_limits, gap_limits_of, usual_gap};
use crate::parallel;
use distance_field::quantile_in_place;
use footpoint::CurveFootpoint;
use mesh_core::CloudIndex;
use nalgebra::{Point, SVector};
use nurbs_core::{BsplineCurve, ParametricCurve};

/// Chords per span at least, chords per point, and chords at most.
const CHORDS: usize = 32;
const PER_POINT: usize = 4;
const MOST: usize = 200_000;
/// How far a point may be: in spacings, and in units of the noise, besides half the logarithm of the number of points.
const SPACINGS: f64 = 2.5;
const NOISES: f64 = 5.0;
/// Neighbours whose mean place is compared with the curve, and how far that may be in units of the noise.
const WINDOW: usize = 16;
const TOGETHER: f64 = 1.5;
/// Length along the curve that noise adds to the gap between neighbours, in units of the noise; to each of several long ones.
const SLACK: f64 = 4.0;
const SLACK_OF_SEVERAL: f64 = 1.5;
/// Length of the curve between neighbours over their distance from which on it is a detour.
const DETOUR: f64 = 1.5;
/// The same for the way to a single point that may be an outlier and on.
const LONE: f64 = 3.5;
/// Length of a stretch in spacings, besides what noise adds, from which on it may not turn further than this, in radians: it leaves the data and
/// comes back elsewhere.
const SHARP: f64 = 3.0;
const TURN: f64 = 2.2;
/// How much longer than the largest gap of random points two, three, … gaps in a row are.
const ROW: [f64; 4] = [1.2, 1.4, 1.55, 1.7];
/// And than even ones.
const EVEN: f64 = 1.5;
/// Root mean square distance in spacings, and in units of the noise, beyond which the points are not on the curve; less if neighbours are off alike: their
/// mean squared difference in units of twice the mean square, 1 for noise.
const LOOSE: f64 = 0.25;
const NOISY: [f64; 2] = [2.0, 1.5];
const ALIKE: f64 = 0.6;
/// Share of the length below which gaps are repetitions of points.
const REPEATED: f64 = 1e-12;

/// What is asked of a curve and its points.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Limits {
    /// Distance of points that is allowed in any case.
    pub(crate) distance: f64,
    /// Length without points that is allowed; by the points if none is given.
    pub(crate) gap: Option<f64>,
    /// Whether a single point may be an outlier, so that it supports no excursion of the curve.
    pub(crate) outliers: bool,
    /// Whether an open curve will be cut at its first and last point, so that what goes on beyond them does not matter.
    pub(crate) free_ends: bool,
}

/// The curve by chords.
struct Chords<const D: usize> {
    parameters: Vec<f64>,
    lengths: Vec<f64>,
    points: Vec<SVector<f64, D>>,
    /// Sum of the angles between chords up to each, and over the seam of a closed curve.
    turns: Vec<f64>,
    seam: f64,
}

impl<const D: usize> Chords<D> {
    fn new(curve: &BsplineCurve<D>, data: usize) -> Self {
        let knots = curve.knots();
        let spans: Vec<usize> = knots.spans().collect();
        let each =
            (PER_POINT * data / spans.len().max(1)).clamp(CHORDS, (MOST / spans.len().max(1)).max(CHORDS));
        let mut parameters = Vec::with_capacity(spans.len() * each + 1);
        for &span in &spans {
            let interval = knots.span_interval(span);
            parameters.extend((0..each).map(|k| interval.lerp(k as f64 / each as f64)));
        }
        parameters.push(knots.domain().end());
        let points = parallel::map(parameters.len(), |k| curve.point(parameters[k]));
        let mut lengths = vec![0.0];
        for (k, pair) in points.windows(2).enumerate() {
            lengths.push(lengths[k] + (pair[1] - pair[0]).norm());
        }
        let mut turns = vec![0.0; points.len()];
        let (mut first, mut last): (Option<SVector<f64, D>>, Option<SVector<f64, D>>) = (None, None);
        for (k, pair) in points.windows(2).enumerate() {
            let chord = pair[1] - pair[0];
            turns[k] += if k > 0 { turns[k - 1] } else { 0.0 };
            if chord.norm_squared() > 0.0 {
                turns[k] += last.map_or(0.0, |before| before.angle(&chord));
                first = first.or(Some(chord));
                last = Some(chord);
            }
        }
        let count = points.len();
        if count > 1 {
            turns[count - 1] = turns[count - 2];
        }
        let seam = first.zip(last).map_or(0.0, |(a, b)| b.angle(&a));
        Self { parameters, lengths, points, turns, seam }
    }

    /// The sum of the angles by which the curve turns on a stretch, which may go through its seam.
    fn turn(&self, from: f64, length: f64) -> f64 {
        let at =
            |length: f64| self.turns[self.lengths.partition_point(|l| *l < length).min(self.turns.len() - 1)];
        let end = from + length - self.total();
        if end <= 0.0 {
            return at(from + length) - at(from);
        }
        at(self.total()) - at(from) + self.seam + at(end)
    }

    fn total(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Length up to a parameter.
    fn length_at(&self, t: f64) -> f64 {
        let k = self.parameters.partition_point(|p| *p <= t).clamp(1, self.parameters.len() - 1);
        let (a, b) = (self.parameters[k - 1], self.parameters[k]);
        let share = if b > a { ((t - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        self.lengths[k - 1] + (self.lengths[k] - self.lengths[k - 1]) * share
    }

    /// Parameter and place at a length.
    fn at(&self, length: f64) -> (f64, SVector<f64, D>) {
        let k = self.lengths.partition_point(|l| *l <= length).clamp(1, self.lengths.len() - 1);
        let (a, b) = (self.lengths[k - 1], self.lengths[k]);
        let share = if b > a { ((length - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        let parameter = self.parameters[k - 1] + (self.parameters[k] - self.parameters[k - 1]) * share;
        (parameter, self.points[k - 1] + (self.points[k] - self.points[k - 1]) * share)
    }
}

/// A curve and the points that count, with their feet.
pub(crate) fn of_curve<const D: usize>(
    curve: &BsplineCurve<D>,
    points: &[SVector<f64, D>],
    feet: &[CurveFootpoint<D>],
    limits: Limits,
) -> CurveCoverage {
    let closed = curve.knots().is_periodic();
    let chords = Chords::new(curve, points.len());
    let total = chords.total();
    let stop = |(index, (point, foot)): (usize, (&SVector<f64, D>, &CurveFootpoint<D>))| Stop {
        at: chords.length_at(curve.knots().normalize(foot.parameter)),
        foot: foot.point,
        residual: point - foot.point,
        index,
    };
    let mut stops: Vec<Stop<D>> = points.iter().zip(feet).enumerate().map(stop).collect();
    stops.sort_by(|a, b| a.at.total_cmp(&b.at).then(a.index.cmp(&b.index)));
    let mut found = CurveCoverage { length: total, noise: noise(&stops), ..CurveCoverage::default() };
    if stops.is_empty() || total.is_nan() || total <= 0.0 {
        return found;
    }
    // Gaps between the feet of all points tell the spacing, those of near ones what is without data.
    let gaps: Vec<f64> = between(&stops, total, closed).into_iter().map(|g| g.length).collect();
    let gaps: Vec<f64> = gaps.into_iter().filter(|g| *g > REPEATED * total).collect();
    found.limit = limits.gap.unwrap_or_else(|| {
        let [single, several] = gap_limits_of(&gaps, SEVERAL);
        (single + SLACK * found.noise).min(several + SLACK_OF_SEVERAL * found.noise)
    });
    let supported: Vec<f64> = gaps.iter().copied().filter(|g| *g <= found.limit).collect();
    found.spacing = supported.iter().sum::<f64>() / supported.len().max(1) as f64;
    let of_noise = found.noise * (NOISES + 0.5 * (points.len() as f64).ln());
    found.distance_limit = limits.distance.max(SPACINGS * found.spacing).max(of_noise);
    found.points_far =
        feet.iter().filter(|foot| foot.distance.is_nan() || foot.distance > found.distance_limit).count();
    let usual = limits.distance.max(SPACINGS * found.spacing).max(TOGETHER * found.noise);
    found.points_far = found.points_far.max(aside(&stops, usual));
    found.unresolved = is_loose(&stops, &found, limits.distance);
    let near: Vec<Stop<D>> =
        stops.iter().copied().filter(|s| s.residual.norm() <= found.distance_limit).collect();
    let hook = 2.0 * usual_gap(&gaps) + SLACK * found.noise;
    let stretch = |from: f64, length: f64, place: SVector<f64, D>| {
        let to = (from + length).rem_euclid(total);
        let to = if to == 0.0 { total } else { to };
        Stretch {
            from: chords.at(from.rem_euclid(total)).0,
            to: chords.at(to).0,
            length,
            place: place.iter().copied().collect(),
        }
    };
    let mut polygon = 0.0;
    let stretches = between(&near, total, closed);
    let lengths: Vec<f64> = stretches.iter().map(|s| s.length).collect();
    let local = if limits.gap.is_some() { Vec::new() } else { gap_limits(&lengths, closed) };
    for (k, gap) in stretches.iter().enumerate() {
        let is_end = !closed && (k == 0 || k + 1 == stretches.len());
        if is_end && limits.free_ends {
            continue;
        }
        let detour = gap.length - gap.chord > hook && gap.length > DETOUR * gap.chord && limits.gap.is_none();
        let turn = chords.turn(gap.from, gap.length);
        let own = gap.length - SLACK * found.noise;
        let bends = limits.gap.is_none()
            && own > SHARP * found.spacing
            && (turn > TURN || undetermined(own, turn) > usual);
        if gap.length <= local.get(k).map_or(found.limit, |l| l.max(found.limit)) && !detour && !bends {
            polygon += gap.chord;
            continue;
        }
        let middle = (gap.from + 0.5 * gap.length).rem_euclid(total);
        found.without_data.push(stretch(gap.from, gap.length, chords.at(middle).1));
    }
    if limits.outliers {
        for three in near.windows(3) {
            let (length, chord) = (three[2].at - three[0].at, (three[2].foot - three[0].foot).norm());
            let bends = length > 2.0 * (SHARP * found.spacing + SLACK * found.noise)
                && chords.turn(three[0].at, length) > TURN;
            if length > LONE * chord && length - chord > 2.0 * hook || bends {
                found.without_data.push(stretch(three[0].at, length, three[1].foot));
            }
        }
    }
    if limits.outliers && limits.gap.is_none() {
        // Neither do a few in a row that are nearly as far apart as gaps are.
        for count in 2..=ROW.len() + 1 {
            let even = EVEN * (count + 1) as f64 * usual_gap(&gaps);
            let limit = (ROW[count - 2] * found.limit).max(even);
            for row in near.windows(count + 1) {
                let length = row[count].at - row[0].at;
                if length > limit {
                    found.without_data.push(stretch(row[0].at, length, row[count / 2].foot));
                }
            }
        }
    }
    found.without_data.sort_by(|a, b| b.length.total_cmp(&a.length));
    let without = found.without_data.iter().map(|s| s.length).fold(0.0, |sum, length| sum + length);
    found.length_without_data = without.min(total);
    found.length_ratio = if polygon > 0.0 { total / polygon } else { 0.0 };
    measure(&chords, points, &mut found);
    if found.spacing > 0.0 {
        found.max_in_spacings = found.max / found.spacing;
        found.length_without_data_in_spacings = found.length_without_data / found.spacing;
    }
    found.spread_out = spreads(&stops, points, total, closed);
    found
}

/// How far the true curve may be from a stretch without points of this length on which the curve turns by this angle: up to the corner of the tangents
/// at its ends.
fn undetermined(length: f64, turn: f64) -> f64 {
    0.5 * length.max(0.0) * (0.5 * turn.min(std::f64::consts::PI)).tan().abs()
}

/// A stretch between the feet of neighbours, or between an end and the first or last foot.
struct Between {
    from: f64,
    length: f64,
    chord: f64,
}

/// The stretches in their order: of a closed curve the one through its seam last, of an open one those at its ends first and last.
fn between<const D: usize>(stops: &[Stop<D>], total: f64, closed: bool) -> Vec<Between> {
    let (Some(first), Some(last)) = (stops.first(), stops.last()) else {
        return vec![Between { from: 0.0, length: total, chord: 0.0 }];
    };
    let inner = stops.windows(2).map(|p| Between {
        from: p[0].at,
        length: p[1].at - p[0].at,
        chord: (p[1].foot - p[0].foot).norm(),
    });
    if closed {
        let length = first.at + total - last.at;
        let seam = Between { from: last.at, length, chord: (first.foot - last.foot).norm() };
        return inner.chain(std::iter::once(seam)).collect();
    }
    // Beyond the ends there is nothing to go to: the whole stretch is as far as it reaches.
    let before = Between { from: 0.0, length: first.at, chord: first.at };
    let behind = Between { from: last.at, length: total - last.at, chord: total - last.at };
    std::iter::once(before).chain(inner).chain(std::iter::once(behind)).collect()
}

/// Standard deviation across the curve of the noise, from the second differences of neighbours: what bends slowly is no noise.
fn noise<const D: usize>(stops: &[Stop<D>]) -> f64 {
    let mut sizes: Vec<f64> =
        stops.windows(3).map(|s| (s[0].residual - s[1].residual * 2.0 + s[2].residual).norm()).collect();
    // Medians of the absolute value of one, or the length of two or more normal variables.
    let unit = if D <= 2 { 0.6745 } else { 1.1774 };
    quantile_in_place(&mut sizes, 0.5) / (6f64.sqrt() * unit)
}

/// Whether the points are further from the curve than a distance, noise and a share of the spacing explain: it does not follow them.
fn is_loose<const D: usize>(stops: &[Stop<D>], found: &CurveCoverage, distance: f64) -> bool {
    let squares: f64 = stops.iter().map(|s| s.residual.norm_squared()).sum();
    let rms = (squares / stops.len() as f64).sqrt();
    let changes: f64 = stops.windows(2).map(|s| (s[1].residual - s[0].residual).norm_squared()).sum();
    let alike = changes < ALIKE * 2.0 * squares;
    rms > distance.max(LOOSE * found.spacing).max(NOISY[usize::from(alike)] * found.noise)
}

/// Number of points that lie to one side of the curve together with their neighbours, further than noise explains.
fn aside<const D: usize>(stops: &[Stop<D>], limit: f64) -> usize {
    let width = WINDOW.min(stops.len() / 8);
    if width < WINDOW / 2 {
        return 0;
    }
    let mut sum: SVector<f64, D> = stops[..width].iter().map(|s| s.residual).sum();
    let (mut count, mut until) = (0, 0);
    for first in 0..=stops.len() - width {
        if first > 0 {
            sum += stops[first + width - 1].residual - stops[first - 1].residual;
        }
        if sum.norm() > limit * width as f64 {
            count += first + width - until.max(first);
            until = first + width;
        }
    }
    count
}

/// Distances of the curve from the points.
fn measure<const D: usize>(chords: &Chords<D>, points: &[SVector<f64, D>], found: &mut CurveCoverage) {
    let places: Vec<Point<f64, D>> = points.iter().copied().map(Point::from).collect();
    let Ok(index) = CloudIndex::new(&places) else { return };
    let distances = parallel::map(chords.points.len(), |k| {
        index.nearest(&Point::from(chords.points[k])).map_or(f64::INFINITY, |near| near.distance())
    });
    let (mut sum, mut at) = (0.0, 0);
    for k in 0..distances.len() {
        if distances[k] > distances[at] {
            at = k;
        }
        if k > 0 {
            let mean = 0.5 * (distances[k - 1].powi(2) + distances[k].powi(2));
            sum += mean * (chords.lengths[k] - chords.lengths[k - 1]);
        }
    }
    found.rms = (sum / chords.total()).sqrt();
    found.max = distances[at];
    found.max_parameter = chords.parameters[at];
    found.samples = distances.len();
    found.resolution = chords.lengths.windows(2).map(|l| l[1] - l[0]).fold(0.0, f64::max);
}

#[cfg(test)]
mod tests {
    use super::*;
    use footpoint::CurveProjector;
    use nalgebra::Vector2;
    use nurbs_core::KnotVector;

    #[test]
    fn waves_about_a_line_are_no_noise() {
        let knots = KnotVector::uniform_clamped(1, 2).unwrap();
        let line =
            BsplineCurve::new(knots, vec![Vector2::new(-1.0, 0.0), Vector2::new(120.0, 0.0)], None).unwrap();
        let seen = |height: &dyn Fn(f64) -> f64| {
            let points: Vec<_> = (0..120).map(f64::from).map(|x| Vector2::new(x, height(x))).collect();
            let feet = CurveProjector::new(&line).project_all(&points);
            of_curve(&line, &points, &feet, Limits { free_ends: true, ..Limits::default() })
        };
        let wave = seen(&|x| 0.8 * (0.25 * x).sin());
        assert!(wave.unresolved && wave.points_far == 0 && !wave.holds(), "{wave:?}");
        // Smaller than the spacing resolves, or as different from point to point as noise.
        assert!(seen(&|x| 0.3 * (0.25 * x).sin()).holds());
        let noise = seen(&|x| 2.0 * ((x * 0.618_034).fract() - 0.5));
        assert!(!noise.unresolved, "{noise:?}");
    }

    #[test]
    fn long_gaps_may_be_where_the_curve_is_straight_but_not_at_a_corner() {
        let knots = KnotVector::uniform_clamped(1, 3).unwrap();
        let corners = vec![Vector2::new(0.0, 0.0), Vector2::new(80.0, 0.0), Vector2::new(80.0, 80.0)];
        let curve = BsplineCurve::new(knots, corners, None).unwrap();
        let mut state = 7u64;
        let mut gap = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            -(((state >> 33) as f64 + 0.5) / 2f64.powi(31)).ln()
        };
        let lengths: Vec<f64> = (0..400)
            .scan(0.0, |sum, _| {
                *sum += gap().min(4.0);
                Some(*sum)
            })
            .take_while(|length| *length < 160.0)
            .collect();
        // Eight spacings without points around some place.
        let seen = |middle: f64| {
            let kept = lengths.iter().filter(|length| (**length - middle).abs() > 4.0);
            let points: Vec<_> = kept.map(|&s| Vector2::new(s.min(80.0), (s - 80.0).max(0.0))).collect();
            let feet = CurveProjector::new(&curve).project_all(&points);
            of_curve(&curve, &points, &feet, Limits { free_ends: true, ..Limits::default() })
        };
        let straight = seen(40.0);
        assert!(straight.holds() && straight.max > 3.5 * straight.spacing, "{straight:?}");
        let corner = seen(80.0);
        assert_eq!(corner.without_data.len(), 1, "{corner:?}");
        assert!(
            (corner.without_data[0].from..corner.without_data[0].to)
                .contains(&curve.knots().domain().lerp(0.5))
        );
    }
}
