//! How well a placement lays the cloud on the model.

use nalgebra::Vector3;

use super::{OrientedPoints, grid::SampleGrid, placement::Placement};

/// Cells of the grid of nearest samples per diagonal of the model.
const CELLS: f64 = 80.0;

/// Distances beyond this share of the diagonal are infinite.
pub(crate) const REACH: f64 = 0.06;

/// Normals that differ by more do not belong together.
const NORMAL_COSINE: f64 = 0.7;

/// What a point of the cloud meets on the model.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact {
    /// Distance along the normal of the model, signed.
    pub(crate) height: f64,
    /// Square of the distance: of the height, and of the way along the surface beyond what the samples explain.
    pub(crate) distance_sq: f64,
    pub(crate) foot: Vector3<f64>,
    pub(crate) normal: Vector3<f64>,
}

/// The model, ready for many placements. All lengths are shares of its diagonal.
#[derive(Debug)]
pub(crate) struct Scorer {
    samples: OrientedPoints,
    grid: SampleGrid,
    lateral_sq: f64,
    oriented: bool,
}

impl Scorer {
    pub(crate) fn new(samples: OrientedPoints, oriented: bool) -> Self {
        let cell = 1.0 / CELLS;
        let grid = SampleGrid::new(&samples, cell, REACH);
        // The sample of a cell may lie at the other end of its diagonal.
        Self { samples, grid, lateral_sq: 3.0 * cell * cell, oriented }
    }

    /// The nearest sample to `x`, if it is near and its normal fits.
    #[inline]
    pub(crate) fn contact(&self, x: &Vector3<f64>, normal: &Vector3<f64>) -> Option<Contact> {
        let index = self.grid.nearest(x)?;
        let foot = self.samples.points()[index];
        let offset = x - foot;
        let found = self.samples.normals()[index];
        let cosine = found.dot(normal);
        if (if self.oriented { cosine } else { cosine.abs() }) < NORMAL_COSINE {
            return None;
        }
        let height = found.dot(&offset);
        let beyond = (offset.norm_squared() - height * height - self.lateral_sq).max(0.0);
        Some(Contact { height, distance_sq: height * height + beyond, foot, normal: found })
    }

    /// `Σ max(0, 1 − d²/τ²)` over the points of the given range, `τ` being the `limit`.
    #[inline]
    pub(crate) fn sum(
        &self,
        placement: &Placement,
        cloud: &OrientedPoints,
        range: std::ops::Range<usize>,
        limit: f64,
    ) -> f64 {
        let per_limit_sq = 1.0 / (limit * limit);
        let mut sum = 0.0;
        for index in range {
            let x = placement.apply(&cloud.points()[index]);
            let normal = placement.rotation * cloud.normals()[index];
            if let Some(contact) = self.contact(&x, &normal) {
                sum += (1.0 - contact.distance_sq * per_limit_sq).max(0.0);
            }
        }
        sum
    }

    /// Spread of the distances of the first `count` points that are near the model: 1.48 times the median.
    pub(crate) fn spread(&self, placement: &Placement, cloud: &OrientedPoints, count: usize) -> f64 {
        let mut distances = Vec::with_capacity(count);
        for index in 0..count {
            let x = placement.apply(&cloud.points()[index]);
            let normal = placement.rotation * cloud.normals()[index];
            distances.extend(self.contact(&x, &normal).map(|contact| contact.distance_sq));
        }
        if distances.is_empty() {
            return REACH;
        }
        let middle = distances.len() / 2;
        1.4826 * distances.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt()
    }

    /// Share of the first `count` points within `limit`, and the root mean square of their distances.
    pub(crate) fn share_and_rms(
        &self,
        placement: &Placement,
        cloud: &OrientedPoints,
        count: usize,
        limit: f64,
    ) -> (f64, f64) {
        let (mut near, mut sum) = (0usize, 0.0);
        for index in 0..count {
            let x = placement.apply(&cloud.points()[index]);
            let normal = placement.rotation * cloud.normals()[index];
            if let Some(contact) = self.contact(&x, &normal).filter(|c| c.distance_sq <= limit * limit) {
                near += 1;
                sum += contact.distance_sq;
            }
        }
        (near as f64 / count.max(1) as f64, (sum / near.max(1) as f64).sqrt())
    }
}
