//! The squared distance form close to the model.
//!
//! There the terms of [`form`](PatchSet::form) cancel, and their rounding errors hide the answer. Here differences
//! are taken before products, on a part of the patch at a time.

use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::arithmetic::lanes::{Row, add_scaled, zero_row};
use crate::global::arithmetic::products::restrict;
use crate::global::proof::box_tests::largest;
use crate::global::proof::region::Region;
use crate::global::surface::geometry::Patch;
use crate::global::surface::patch::PatchSet;
use nalgebra::Vector3;

/// Rounding errors of coefficients as a share of the largest.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

impl<const K: usize> PatchSet<K> {
    /// Bernstein coefficients of `w² (|S − x|² − limit_sq)` on a box of the patch; returns their rounding errors.
    #[inline(always)]
    pub(crate) fn fine_form(
        &self,
        patch: &Patch,
        y: &Vector3<f64>,
        region: &Region,
        limit_sq: f64,
        net: &mut Vec<Homogeneous>,
        out: &mut [Row<K>],
    ) -> f64 {
        let [p, q] = patch.degrees();
        net.clear();
        let shifted = |c: &Homogeneous| [c[0] - c[3] * y.x, c[1] - c[3] * y.y, c[2] - c[3] * y.z, c[3]];
        net.extend(self.net(patch).iter().map(shifted));
        for j in 0..=q {
            restrict(net, j, q + 1, p, region.low[0], region.high[0]);
        }
        for i in 0..=p {
            restrict(net, i * (q + 1), 1, q, region.low[1], region.high[1]);
        }
        let (shares, rows) = (&self.products.shares[p], &self.products.rows[q]);
        out.fill(zero_row());
        let multiply = |a: &Homogeneous, b: &Homogeneous| {
            (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] - limit_sq * (a[3] * b[3]))
        };
        for i in 0..=p {
            for k in i..=p {
                let (a, b) = (&net[i * (q + 1)..][..=q], &net[k * (q + 1)..][..=q]);
                let mut row = zero_row::<K>();
                for j in 0..=q {
                    add_scaled(&mut row, &rows[j * (q + 2)], multiply(&a[j], &b[j]));
                    for l in j + 1..=q {
                        let both = multiply(&a[j], &b[l]) + multiply(&a[l], &b[j]);
                        add_scaled(&mut row, &rows[j * (q + 1) + l], both);
                    }
                }
                let share = shares[i * (p + 1) + k];
                add_scaled(&mut out[i + k], &row, if i == k { share } else { 2.0 * share });
            }
        }
        // The points themselves are as exact as their coordinates in the patch.
        let most = largest(out);
        let points = (most * patch.max_weight_sq).sqrt() * (patch.radius + y.norm());
        ROUNDING * (most + points)
    }
}
