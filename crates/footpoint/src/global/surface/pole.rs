//! Edges of patches that are collapsed into a point.

use crate::global::proof::region::Region;
use crate::global::surface::geometry::Patch;
use crate::global::surface::patch::PatchSet;
use crate::global::surface::pole_edge::Pole;
use nalgebra::Vector3;
use nurbs_core::BezierPatch;

/// Rounding errors of coordinates, as a share of the largest, up to which control points are the same.
const SAME: f64 = 32.0 * f64::EPSILON;

/// Rounding errors of a sum of products, as a share of the products.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

impl Pole {
    /// The collapsed edge of a patch, the first one if there are several.
    pub(crate) fn find(patch: &BezierPatch) -> Option<Self> {
        let largest = patch.control_points.iter().map(|p| p.amax()).fold(0.0, f64::max);
        let ends = [(false, false), (false, true), (true, false), (true, true)];
        let poles = ends.map(|(along_v, at_end)| Self { along_v, at_end, speed: 0.0 });
        poles.into_iter().find_map(|pole| {
            let first = pole.point(patch);
            let off = |i: usize| (patch.control_points[i] - first).amax();
            if pole.edge(patch.degrees).any(|i| off(i) > SAME * largest) {
                return None;
            }
            let farthest = pole.line(patch.degrees, 1).map(off).fold(0.0, f64::max);
            Some(Self { speed: farthest * patch.degrees[pole.direction()] as f64, ..pole })
        })
    }

    /// The direction that leads away from it.
    #[inline(always)]
    pub(crate) fn direction(self) -> usize {
        usize::from(self.along_v)
    }

    /// The end of that direction at which it is.
    #[inline(always)]
    pub(crate) fn end(self) -> usize {
        usize::from(self.at_end)
    }

    /// Indices of the control points of the collapsed edge.
    pub(crate) fn edge(self, degrees: [usize; 2]) -> impl Iterator<Item = usize> {
        self.line(degrees, 0)
    }

    /// Indices of the control points `away` steps from the edge.
    fn line(self, [p, q]: [usize; 2], away: usize) -> impl Iterator<Item = usize> {
        let (last, along) = if self.along_v { (q, p) } else { (p, q) };
        let across = if self.at_end { last - away } else { away };
        (0..=along).map(move |k| if self.along_v { k * (q + 1) + across } else { across * (q + 1) + k })
    }

    /// The point itself.
    pub(crate) fn point(self, patch: &BezierPatch) -> Vector3<f64> {
        self.edge(patch.degrees).next().map_or(Vector3::zeros(), |i| patch.control_points[i])
    }

    /// Whether a box of the patch reaches the collapsed edge.
    pub(crate) fn touches(self, region: &Region) -> bool {
        region.at_border(self.direction(), self.end())
    }
}

impl<const K: usize> PatchSet<K> {
    /// Rounding errors of the coefficients of the form on a box, or infinity where those of the larger box count.
    ///
    /// They are a share of the terms that cancel, not of the small result. Next to a pole these terms are small too:
    /// `|wS|²` grows with the square of the way from the pole, `w · wS` with the way.
    #[inline(always)]
    pub(crate) fn noise(&self, patch: &Patch, y: &Vector3<f64>, region: &Region) -> f64 {
        let (reach, y) = (self.reach(patch, region), y.norm());
        ROUNDING * patch.max_weight_sq * (reach + y) * (reach + y)
    }

    /// As [`noise`](Self::noise), for the form without its constant `|y|²`.
    pub(crate) fn difference_noise(&self, patch: &Patch, y: &Vector3<f64>, region: &Region) -> f64 {
        let reach = self.reach(patch, region);
        2.0 * ROUNDING * patch.max_weight_sq * reach * (reach + 2.0 * y.norm())
    }

    /// How far the control points of a box are from the centre at most, or infinity for boxes inside a patch.
    #[inline(always)]
    fn reach(&self, patch: &Patch, region: &Region) -> f64 {
        if region.depth == 0 {
            return patch.radius;
        }
        let Some(pole) = patch.pole.filter(|pole| pole.touches(region)) else { return f64::INFINITY };
        let d = pole.direction();
        let degree = if d == 0 { patch.rows() - 1 } else { Self::DEGREE };
        patch.radius * ((region.high[d] - region.low[d]) * degree as f64).min(1.0)
    }
}
