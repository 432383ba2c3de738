//! Pairs of oriented points, found again by what a motion does not change.
//!
//! The distance of two points, the angles of their normals with the line that joins them, and the angle between the
//! normals stay the same under every motion. One pair of the cloud with the same four numbers as a pair of the model
//! determines a pose (\[DUNI10\], \[PB10\]).

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Vector3};

use super::{OrientedPoints, placement::Placement};

/// Range of the distances, in diagonals of the model: shorter pairs tell too little of the rotation, longer ones are rarely
/// seen together in a scan of one side.
pub(crate) const SHORTEST: f64 = 0.12;
const LONGEST: f64 = 0.72;
const DISTANCE_BINS: usize = 24;
const ANGLE_BINS: usize = 12;
const BINS: usize = DISTANCE_BINS * ANGLE_BINS * ANGLE_BINS * ANGLE_BINS;

/// Two oriented points seen from each other.
#[derive(Debug, Clone, Copy)]
struct Pair {
    middle: Vector3<f64>,
    direction: Vector3<f64>,
    normals: [Vector3<f64>; 2],
    /// Distance and angles, in widths of a bin. The angles are 0 before they are measured.
    feature: [f64; 4],
}

impl Pair {
    fn new(points: [&Vector3<f64>; 2], normals: [&Vector3<f64>; 2], oriented: bool) -> Option<Self> {
        let joining = points[1] - points[0];
        let distance = joining.norm();
        if !(SHORTEST..LONGEST).contains(&distance) {
            return None;
        }
        let direction = joining / distance;
        let mut normals = normals.map(|n| *n);
        if !oriented {
            for normal in &mut normals {
                if normal.dot(&direction) < 0.0 {
                    *normal = -*normal;
                }
            }
        }
        let length = (distance - SHORTEST) / (LONGEST - SHORTEST) * DISTANCE_BINS as f64;
        Some(Self {
            middle: (points[0] + points[1]) * 0.5,
            direction,
            normals,
            feature: [length, 0.0, 0.0, 0.0],
        })
    }

    /// The pair with its angles.
    fn measured(mut self) -> Self {
        self.measure();
        self
    }

    fn measure(&mut self) {
        let [first, second] = &self.normals;
        for (angle, cosine) in self.feature[1..].iter_mut().zip([
            first.dot(&self.direction),
            second.dot(&self.direction),
            first.dot(second),
        ]) {
            *angle = cosine.clamp(-1.0, 1.0).acos() / PI * ANGLE_BINS as f64;
        }
    }

    /// The same pair with a normal turned over.
    fn flipped(mut self, which: usize) -> Self {
        self.normals[which] = -self.normals[which];
        self.measure();
        self
    }

    /// `+1` or `−1`: how the normals add up to the longer vector across the joining line.
    fn sign(&self) -> f64 {
        let [first, second] = &self.normals;
        let across = first.dot(second) - first.dot(&self.direction) * second.dot(&self.direction);
        if across < 0.0 { -1.0 } else { 1.0 }
    }

    /// Axes along the joining line and towards the (signed) sum of the normals; `None` if that is along the line.
    fn axes(&self, sign: f64) -> Option<Matrix3<f64>> {
        let sum = self.normals[0] + self.normals[1] * sign;
        let across = sum - self.direction * sum.dot(&self.direction);
        let second = across.try_normalize(0.25)?;
        Some(Matrix3::from_columns(&[self.direction, second, self.direction.cross(&second)]))
    }
}

/// The pairs of a model by their features.
#[derive(Debug)]
pub(crate) struct PairTable {
    samples: OrientedPoints,
    oriented: bool,
    /// `members[start[key]..start[key + 1]]` are the pairs with that key.
    start: Vec<u32>,
    members: Vec<[u16; 2]>,
}

impl PairTable {
    /// All ordered pairs of the first 65536 samples.
    pub(crate) fn new(samples: OrientedPoints, oriented: bool) -> Self {
        let count = u16::try_from(samples.len()).unwrap_or(u16::MAX);
        let rows = crate::parallel::tasks(usize::from(count), |i| {
            let mut row = Vec::new();
            for j in 0..count {
                if let Some(pair) = pair_of(&samples, i, usize::from(j), oriented).map(Pair::measured) {
                    let key = pair.feature.map(|value| value.floor());
                    if let Some(key) = key_of(key) {
                        row.push((key, j));
                    }
                }
            }
            row
        });
        let mut start = vec![0u32; BINS + 1];
        for (key, _) in rows.iter().flatten() {
            start[key + 1] += 1;
        }
        for key in 0..BINS {
            start[key + 1] += start[key];
        }
        let mut next = start.clone();
        let mut members = vec![[0; 2]; rows.iter().map(Vec::len).sum()];
        for (i, row) in (0u16..).zip(&rows) {
            for &(key, j) in row {
                members[next[key] as usize] = [i, j];
                next[key] += 1;
            }
        }
        Self { samples, oriented, start, members }
    }

    /// Calls `visit` with poses that lay the pair `(i, j)` of the cloud on pairs of the model: all, or evenly chosen `most`.
    pub(crate) fn matches(
        &self,
        cloud: &OrientedPoints,
        [i, j]: [usize; 2],
        most: usize,
        mut visit: impl FnMut(Placement),
    ) {
        let Some(pair) = pair_of(cloud, i, j, self.oriented).map(Pair::measured) else { return };
        let mut variants = vec![pair];
        if !self.oriented {
            // A normal across the joining line may have been turned to either side.
            for which in 0..2 {
                if variants[0].feature[1 + which] / ANGLE_BINS as f64 * PI > FRAC_PI_2 - 0.26 {
                    let flipped: Vec<_> = variants.iter().map(|pair| pair.flipped(which)).collect();
                    variants.extend(flipped);
                }
            }
        }
        let buckets: Vec<Vec<&[[u16; 2]]>> =
            variants.iter().map(|variant| self.buckets_around(&variant.feature)).collect();
        let total: usize = buckets.iter().flatten().map(|bucket| bucket.len()).sum();
        let stride = total.div_ceil(most.max(1)).max(1);
        let mut skip = 0;
        for (variant, buckets) in variants.iter().zip(&buckets) {
            let sign = variant.sign();
            let Some(axes) = variant.axes(sign) else { continue };
            for bucket in buckets {
                let mut at = skip;
                while at < bucket.len() {
                    let [a, b] = bucket[at].map(usize::from);
                    at += stride;
                    let Some(found) = pair_of(&self.samples, a, b, self.oriented) else { continue };
                    let Some(target) = found.axes(sign) else { continue };
                    let rotation = target * axes.transpose();
                    visit(Placement { rotation, shift: found.middle - rotation * variant.middle });
                }
                skip = at - bucket.len();
            }
        }
    }

    /// The two nearest bins in each of the four directions.
    fn buckets_around(&self, feature: &[f64; 4]) -> Vec<&[[u16; 2]]> {
        let mut out = Vec::with_capacity(16);
        for corner in 0..16u8 {
            let mut bin = [0.0; 4];
            for (axis, bin) in bin.iter_mut().enumerate() {
                *bin = (feature[axis] - 0.5).floor() + f64::from(corner >> axis & 1);
            }
            if let Some(key) = key_of(bin) {
                out.push(&self.members[self.start[key] as usize..self.start[key + 1] as usize]);
            }
        }
        out
    }
}

fn pair_of(samples: &OrientedPoints, i: usize, j: usize, oriented: bool) -> Option<Pair> {
    let (points, normals) = (samples.points(), samples.normals());
    Pair::new([&points[i], &points[j]], [&normals[i], &normals[j]], oriented)
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "tested for the range before")]
fn key_of(bin: [f64; 4]) -> Option<usize> {
    let ends = [DISTANCE_BINS, ANGLE_BINS, ANGLE_BINS, ANGLE_BINS];
    let mut key = 0;
    for (value, end) in bin.into_iter().zip(ends) {
        if !(0.0..end as f64).contains(&value) {
            return None;
        }
        key = key * end + value as usize;
    }
    Some(key)
}
