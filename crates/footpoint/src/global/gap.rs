//! How close the lower bound must come to the distance.

/// Share of the allowed gap that a search aims at; the rest is for the rounding errors of the proof.
const AIM: f64 = 0.75;

/// Thresholds of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap {
    /// Gap aimed at, as a share of the distance.
    pub(crate) relative: f64,
    /// Gap aimed at, as a length.
    pub(crate) absolute: f64,
    /// Squared distances whose relative difference is below this are equal.
    pub(crate) tie: f64,
    /// Boxes examined per patch before the rest is left unresolved.
    pub(crate) max_boxes: u32,
}

impl Gap {
    /// The thresholds that the options mean for a model of the given size.
    pub(crate) fn new(options: &crate::ProjectionOptions, size: f64) -> Self {
        Self {
            relative: AIM * options.relative_gap,
            absolute: AIM * options.size_gap * size,
            tie: options.tie_tolerance,
            max_boxes: options.max_boxes,
        }
    }

    /// Whether a lower bound is as close to the distance as the options ask for.
    #[inline(always)]
    pub(crate) fn is_closed(&self, distance: f64, bound: f64) -> bool {
        let allowed = (self.relative * distance + self.absolute) / AIM;
        distance - bound <= allowed + 4.0 * f64::EPSILON * distance
    }

    /// Whether a distance equals the one found.
    pub(crate) fn is_tie(&self, distance_sq: f64, distance: f64) -> bool {
        (distance_sq.sqrt() - distance).abs() <= self.tie * distance + 1e-3 * self.absolute
    }

    /// The squared distance up to which other points count as equally near.
    #[inline(always)]
    pub(crate) fn reach_sq(&self, distance_sq: f64) -> f64 {
        distance_sq * (1.0 + 4.0 * self.tie)
    }

    /// A squared lower bound below this is weaker than what rounding errors explain: the proof has not ended.
    #[inline(always)]
    pub(crate) fn open_sq(&self, distance_sq: f64) -> f64 {
        let limit = distance_sq.sqrt() * (1.0 - 2.0 * self.relative) - 2.0 * self.absolute;
        if limit > 0.0 { limit * limit } else { 0.0 }
    }

    /// The squared distance below which nothing may be found once the footpoint is `distance_sq` away.
    #[inline(always)]
    pub(crate) fn limit_sq(&self, distance_sq: f64) -> f64 {
        let limit = distance_sq.sqrt() * (1.0 - self.relative) - self.absolute;
        // An infinite distance must stay one, and limits below zero have nothing below them.
        if limit > 0.0 { limit * limit } else { 0.0 }
    }
}
