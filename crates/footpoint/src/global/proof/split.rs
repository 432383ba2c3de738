//! Boxes of a patch cut in two, and where to cut.

use crate::global::arithmetic::lanes::Row;
use crate::global::arithmetic::products::{part_of_row, splitting_rows};
use crate::global::proof::region::Region;
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::Patch;
use crate::global::surface::patch::PatchSet;

/// Where boxes around what matters end: so many times as far.
const WINDOW: f64 = 4.0;

/// A window must leave out at least half of a box to be better than its half.
const NARROW: f64 = 0.5;

impl<const K: usize> PatchSet<K> {
    /// Where to cut a box next to a pole: at a few times the way of the nearest point from it.
    pub(crate) fn cut_at_pole(&self, patch: &Patch, region: &Region, way: f64) -> Option<(usize, f64)> {
        let pole = patch.pole.filter(|pole| pole.touches(region))?;
        let d = pole.direction();
        let window = WINDOW * way / (pole.speed * (region.high[d] - region.low[d]));
        (window > 0.0 && window < NARROW).then_some((d, if pole.at_end { 1.0 - window } else { window }))
    }

    /// How far from the pole of a patch the footpoint is, or, where it is the pole, the query.
    pub(crate) fn way_from_pole(&self, patch: &Patch, y: &nalgebra::Vector3<f64>, best: &Foot) -> f64 {
        if patch.pole.is_none() || best.patch == usize::MAX {
            return 0.0;
        }
        let other = &self.patches[best.patch];
        let foot = self.point(other, best.local[0], best.local[1]) + (other.centre - patch.centre);
        let (way, far) = (foot.norm(), y.norm());
        if way > 1e-9 * far { way } else { far }
    }

    /// Where to cut a box close to the model: in the middle, unless all that matters happens near one side.
    pub(crate) fn cut_close(&self, region: &Region, d: usize, best: &Foot, patch: &Patch) -> f64 {
        if !(region.low[d]..=region.high[d]).contains(&best.local[d]) {
            return 0.5;
        }
        let at = region.local(best.local)[d];
        let jet = self.jet(patch, best.local[0], best.local[1]);
        let speed = if d == 0 { jet.du } else { jet.dv }.norm() * (region.high[d] - region.low[d]);
        let reach = best.distance_sq.sqrt() / speed.max(f64::MIN_POSITIVE);
        let (below, above) = (WINDOW * at.max(reach), WINDOW * (1.0 - at).max(reach));
        if below < NARROW {
            below
        } else if above < NARROW {
            1.0 - above
        } else {
            0.5
        }
    }

    /// The rows of both parts of a box, one after the other.
    #[inline(always)]
    pub(crate) fn split_rows(
        &self,
        rows: &[Row<K>],
        direction: usize,
        at: f64,
        splitting: &mut [Vec<Row<K>>; 2],
        out: &mut [Row<K>],
    ) {
        if at == 0.5 {
            return self.halve(rows, direction, out);
        }
        let m = rows.len();
        let (low, high) = out.split_at_mut(m);
        if direction == 0 {
            high.copy_from_slice(rows);
            for level in 0..m {
                low[level] = high[0];
                for i in 0..m - 1 - level {
                    for k in 0..K {
                        high[i][k] = high[i][k] * (1.0 - at) + high[i + 1][k] * at;
                    }
                }
            }
        } else {
            splitting_rows(at, splitting);
            for (i, row) in rows.iter().enumerate() {
                low[i] = part_of_row(row, &splitting[0]);
                high[i] = part_of_row(row, &splitting[1]);
            }
        }
    }

    /// The rows of both halves of a box, one after the other.
    #[inline(always)]
    pub(crate) fn halve(&self, rows: &[Row<K>], direction: usize, out: &mut [Row<K>]) {
        let m = rows.len();
        let (low, high) = out.split_at_mut(m);
        if direction == 0 {
            // De Casteljau's scheme on whole rows.
            high.copy_from_slice(rows);
            for level in 0..m {
                low[level] = high[0];
                for i in 0..m - 1 - level {
                    for k in 0..K {
                        high[i][k] = (high[i][k] + high[i + 1][k]) * 0.5;
                    }
                }
            }
        } else {
            for (i, row) in rows.iter().enumerate() {
                low[i] = part_of_row(row, &self.halves[0]);
                high[i] = part_of_row(row, &self.halves[1]);
            }
        }
    }
}
