//! The points that the picture of a report shows, chosen so that parts of a cloud can be merged.

use crate::{Deviation, Error, Outcome};
use mesh_core::BoundingBox;
use nalgebra::Point3;
use std::cmp::Ordering;

/// Points beyond the limit that are kept before the list is cut to it again.
const SLACK: usize = 1 << 17;
/// Bytes of a point in files.
#[cfg(feature = "serde")]
const BYTES: usize = 36;

/// A sample of the points of a cloud with their deviations, for a picture.
///
/// All points with finite coordinates up to a limit; of more, those whose coordinates give the smallest values of a hash
/// function, which is as good as a choice by chance. Which points these are depends on the points alone and not on their order
/// or on parts that were merged.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(into = "Stored", try_from = "Stored")
)]
pub struct Picture {
    /// Most points that are kept.
    most: usize,
    /// Points that were offered, those that are not finite among them.
    points: u64,
    /// Points with finite coordinates among them.
    finite: u64,
    /// Box of the measured points.
    bounds: Option<BoundingBox>,
    shown: Vec<Shown>,
    /// Rank of the last point that was kept when the list was cut; none behind it needs to be looked at.
    last: Option<(u64, u64)>,
}

/// A point of the sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shown {
    hash: u64,
    /// Index in the whole cloud.
    pub(crate) index: u64,
    pub(crate) point: Point3<f64>,
    /// The deviation; NaN where none counts.
    pub(crate) deviation: f32,
}

impl Shown {
    fn rank(&self) -> (u64, u64) {
        (self.hash, self.index)
    }

    fn order(&self, other: &Self) -> Ordering {
        self.rank().cmp(&other.rank())
    }
}

impl Picture {
    /// No points yet; at most `most` are kept.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { most: most.max(1), points: 0, finite: 0, bounds: None, shown: Vec::new(), last: None }
    }

    /// Adds some of the points of a tile, with their indices in it, as [`Nominal::measure_each`](crate::Nominal::measure_each)
    /// hands them over; `first` is the index of the first point of the tile in the whole cloud. Indices beyond the tile are
    /// left out.
    pub fn extend_with(&mut self, first: u64, points: &[Point3<f64>], measured: &[(usize, Deviation)]) {
        for (index, deviation) in measured {
            let Some(point) = points.get(*index) else { continue };
            self.points += 1;
            if !point.iter().all(|value| value.is_finite()) {
                continue;
            }
            self.finite += 1;
            let is_measured = deviation.outcome == Outcome::Measured;
            if is_measured {
                self.widen(&BoundingBox { min: *point, max: *point });
            }
            #[expect(clippy::cast_possible_truncation, reason = "single precision is what the picture shows")]
            let deviation = if is_measured { deviation.distance as f32 } else { f32::NAN };
            self.keep(Shown { hash: hash(point), index: first + *index as u64, point: *point, deviation });
        }
    }

    fn keep(&mut self, shown: Shown) {
        if self.last.is_some_and(|last| shown.rank() > last) {
            return;
        }
        self.shown.push(shown);
        if self.shown.len() >= self.most.saturating_add(SLACK) {
            self.cut();
        }
    }

    /// Leaves the first points by their ranks.
    fn cut(&mut self) {
        if self.shown.len() > self.most {
            let (_, last, _) = self.shown.select_nth_unstable_by(self.most - 1, Shown::order);
            self.last = Some(last.rank());
            self.shown.truncate(self.most);
        }
    }

    fn widen(&mut self, bounds: &BoundingBox) {
        let all = self.bounds.get_or_insert(*bounds);
        all.min = all.min.inf(&bounds.min);
        all.max = all.max.sup(&bounds.max);
    }

    /// Adds the sample of another part of the cloud.
    ///
    /// # Errors
    /// [`Error::DifferentOptions`] if it was made with another limit.
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        if self.most != other.most {
            return Err(Error::DifferentOptions);
        }
        self.points = self.points.saturating_add(other.points);
        self.finite = self.finite.saturating_add(other.finite);
        if let Some(bounds) = &other.bounds {
            self.widen(bounds);
        }
        other.shown.iter().for_each(|shown| self.keep(*shown));
        Ok(())
    }

    /// Gives the points indices that are larger by `first`: those in the cloud of which the part begins there.
    pub fn shift(&mut self, first: u64) {
        for shown in &mut self.shown {
            shown.index = shown.index.saturating_add(first);
        }
        self.last = self.last.map(|(hash, index)| (hash, index.saturating_add(first)));
    }

    /// Number of points that were offered.
    #[must_use]
    pub fn points(&self) -> u64 {
        self.points
    }

    /// Box of the measured points.
    #[cfg(any(feature = "html", test))]
    pub(crate) fn bounds(&self) -> Option<&BoundingBox> {
        self.bounds.as_ref()
    }

    /// Points with finite coordinates that were offered.
    #[cfg(any(feature = "html", test))]
    pub(crate) fn finite(&self) -> u64 {
        self.finite
    }

    /// The sample by ascending index.
    #[cfg(any(feature = "html", test))]
    pub(crate) fn sample(&self) -> Vec<&Shown> {
        let mut all: Vec<&Shown> = self.shown.iter().collect();
        if all.len() > self.most {
            all.select_nth_unstable_by(self.most, |a, b| a.order(b));
            all.truncate(self.most);
        }
        all.sort_unstable_by_key(|shown| shown.index);
        all
    }
}

/// A value that spreads points evenly, whatever pattern their coordinates have: the finaliser of `splitmix64`.
fn hash(point: &Point3<f64>) -> u64 {
    point.iter().fold(0, |hash, value| {
        // Zeros of either sign are one place.
        let mut bits = hash ^ (value + 0.0).to_bits();
        bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    })
}

/// A picture as files hold it: numbers in bits, points in base64.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Stored {
    most: usize,
    points: u64,
    finite: u64,
    bounds: Option<[[u64; 3]; 2]>,
    /// Index, coordinates and deviation of each point, little endian.
    shown: String,
}

#[cfg(feature = "serde")]
impl From<Picture> for Stored {
    fn from(mut picture: Picture) -> Self {
        picture.cut();
        picture.shown.sort_unstable_by_key(|shown| shown.index);
        let mut bytes = Vec::with_capacity(picture.shown.len() * BYTES);
        for shown in &picture.shown {
            bytes.extend(shown.index.to_le_bytes());
            shown.point.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
            bytes.extend(shown.deviation.to_le_bytes());
        }
        let bits = |point: &Point3<f64>| [point.x, point.y, point.z].map(f64::to_bits);
        Self {
            most: picture.most,
            points: picture.points,
            finite: picture.finite,
            bounds: picture.bounds.map(|bounds| [bits(&bounds.min), bits(&bounds.max)]),
            shown: crate::base64::encode(&bytes),
        }
    }
}

#[cfg(feature = "serde")]
impl TryFrom<Stored> for Picture {
    type Error = Error;
    fn try_from(stored: Stored) -> Result<Self, Error> {
        let damaged = |what| Error::Damaged { what };
        let bytes =
            crate::base64::decode(&stored.shown).ok_or(damaged("the points of the picture are no base64"))?;
        let number = |bytes: &[u8]| bytes.try_into().map(u64::from_le_bytes).unwrap_or_default();
        let rows = bytes.chunks_exact(BYTES);
        if !rows.remainder().is_empty() || rows.len() > stored.most || (rows.len() as u64) > stored.finite {
            return Err(damaged("the points of the picture do not fit their number"));
        }
        let mut picture = Self::new(stored.most);
        for row in rows {
            let [x, y, z] = [8, 16, 24].map(|at| f64::from_bits(number(&row[at..at + 8])));
            let point = Point3::new(x, y, z);
            if !point.iter().all(|value| value.is_finite()) {
                return Err(damaged("a point of the picture is not finite"));
            }
            let deviation = row[32..36].try_into().map(f32::from_le_bytes).unwrap_or(f32::NAN);
            picture.shown.push(Shown { hash: hash(&point), index: number(&row[..8]), point, deviation });
        }
        (picture.points, picture.finite) = (stored.points, stored.finite);
        let point = |bits: [u64; 3]| Point3::from(bits.map(f64::from_bits));
        picture.bounds = stored.bounds.map(|[min, max]| BoundingBox { min: point(min), max: point(max) });
        // Points were left out behind the last one that was kept.
        if (picture.shown.len() as u64) < picture.finite {
            picture.last = picture.shown.iter().map(Shown::rank).max();
        }
        Ok(picture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offered(count: u32) -> (Vec<Point3<f64>>, Vec<(usize, Deviation)>) {
        let points = (0..count).map(|i| {
            let s = f64::from(i % 700);
            Point3::new(s, (s * 0.7).sin(), if i % 50 == 3 { f64::NAN } else { 0.0 })
        });
        let deviation =
            |i: u32| Deviation { distance: 0.5 * f64::from(i), ..Deviation::none(Outcome::Measured) };
        (points.collect(), (0..count).map(|i| (i as usize, deviation(i))).collect())
    }

    #[test]
    fn parts_in_any_order_give_the_sample_of_the_whole() {
        let (points, measured) = offered(3000);
        for most in [1, 100, 2000, 5000] {
            let mut whole = Picture::new(most);
            whole.extend_with(0, &points, &measured);
            assert_eq!((whole.points(), whole.finite()), (3000, 2940));
            assert_eq!(whole.sample().len(), most.min(2940));
            for size in [333, 1000] {
                let mut merged = Picture::new(most);
                for (number, tile) in points.chunks(size).enumerate().rev() {
                    let mut part = Picture::new(most);
                    let first = number * size;
                    let own: Vec<_> =
                        measured[first..first + tile.len()].iter().map(|m| (m.0 - first, m.1)).collect();
                    part.extend_with(0, tile, &own);
                    part.shift(first as u64);
                    merged.merge(&part).unwrap();
                }
                assert_eq!(merged.sample(), whole.sample(), "{most} {size}");
                assert_eq!(merged.bounds(), whole.bounds());
            }
        }
        assert!(Picture::new(3).merge(&Picture::new(4)).is_err());
    }

    #[cfg(feature = "serde")]
    #[test]
    fn comes_back_from_a_file() {
        let (points, measured) = offered(500);
        for most in [40, 1000] {
            let mut picture = Picture::new(most);
            picture.extend_with(7, &points, &measured);
            let stored = Stored::from(picture.clone());
            let back = Picture::try_from(stored).unwrap();
            assert_eq!(back.sample(), picture.sample());
            assert_eq!((back.points(), back.finite(), back.bounds()), (500, 490, picture.bounds()));
            let mut stored = Stored::from(picture);
            stored.shown.truncate(21);
            assert!(Picture::try_from(stored).is_err());
        }
    }
}
