//! The points that deviate most.

use crate::{Deviation, InspectionOptions, Outcome};
use nalgebra::Point3;
use std::cmp::Ordering;

/// A point with a large deviation.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct WorstPoint {
    /// Index of the point in the whole cloud, from 0.
    pub index: u64,
    /// The point.
    pub point: [f64; 3],
    /// Its footpoint.
    pub foot: [f64; 3],
    /// Its signed distance.
    pub distance: f64,
    /// Index of the surface.
    pub shape: u32,
    /// Its name, if the one who asked for the inspection knows and fills in one.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub name: Option<String>,
}

/// The same in bits, so that files keep each of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Kept {
    index: u64,
    shape: u32,
    /// Coordinates of point and footpoint, and the distance, as bits of doubles.
    bits: [u64; 7],
}

/// A fixed number of points, the largest absolute deviations first; ties go to the smaller index.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct WorstPoints {
    most: usize,
    kept: Vec<Kept>,
}

impl Kept {
    fn distance(&self) -> f64 {
        f64::from_bits(self.bits[6])
    }

    /// Larger deviations come first.
    fn order(&self, other: &Self) -> Ordering {
        (other.distance().abs()).total_cmp(&self.distance().abs()).then(self.index.cmp(&other.index))
    }
}

impl WorstPoints {
    pub(crate) fn new(options: &InspectionOptions) -> Self {
        Self { most: options.worst, kept: Vec::new() }
    }

    /// Looks through points with their indices in the cloud.
    pub(crate) fn extend<'a>(
        &mut self,
        measured: impl Iterator<Item = (u64, &'a Point3<f64>, &'a Deviation)>,
    ) {
        for (index, point, deviation) in measured {
            if deviation.outcome == Outcome::Measured {
                let [p, f] =
                    [point, &deviation.foot].map(|point| [point.x, point.y, point.z].map(f64::to_bits));
                let bits = [p[0], p[1], p[2], f[0], f[1], f[2], deviation.distance.to_bits()];
                self.kept.push(Kept { index, shape: deviation.shape, bits });
            }
            if self.kept.len() >= 4096.max(4 * self.most) {
                self.shorten();
            }
        }
        self.shorten();
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.kept.extend_from_slice(&other.kept);
        self.shorten();
    }

    pub(crate) fn indices(&self) -> Vec<u64> {
        self.kept.iter().map(|kept| kept.index).collect()
    }

    /// Gives the points indices that are larger by `first`, which leaves their order.
    pub(crate) fn shift(&mut self, first: u64) {
        self.kept.iter_mut().for_each(|kept| kept.index = kept.index.saturating_add(first));
    }

    fn shorten(&mut self) {
        self.kept.sort_unstable_by(Kept::order);
        self.kept.truncate(self.most);
    }

    pub(crate) fn list(&self) -> Vec<WorstPoint> {
        let point = |kept: &Kept| {
            let [px, py, pz, fx, fy, fz, distance] = kept.bits.map(f64::from_bits);
            WorstPoint {
                index: kept.index,
                point: [px, py, pz],
                foot: [fx, fy, fz],
                distance,
                shape: kept.shape,
                name: None,
            }
        };
        self.kept.iter().map(point).collect()
    }
}
