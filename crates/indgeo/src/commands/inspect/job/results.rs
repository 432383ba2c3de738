//! What an inspection found, as the report has it.

use industrial_geometry::inspection::Inspection;
use serde::Serialize;

/// What an inspection found, with the names that all commands share.
#[derive(Debug, Serialize)]
pub(crate) struct InspectionResults {
    /// Points that do not count because they are not finite.
    pub(crate) points_dropped: usize,
    /// Points that were measured.
    pub(crate) points_used: usize,
    /// Root mean square deviation.
    pub(crate) rms: Option<f64>,
    /// Largest deviation, without its sign.
    pub(crate) max: Option<f64>,
    /// The point that has it, from 0; `null` if no worst points were asked for.
    pub(crate) max_index: Option<u64>,
    /// Share of the judged points within the tolerance.
    pub(crate) share_within: f64,
    /// Whether that is enough.
    pub(crate) within_tolerance: bool,
    /// What the library reports.
    #[serde(flatten)]
    pub(crate) found: Inspection,
}

impl InspectionResults {
    pub(super) fn new(found: Inspection, dropped: usize) -> Self {
        let distance = found.total.distance.as_ref();
        Self {
            points_dropped: dropped,
            points_used: usize::try_from(found.total.count).unwrap_or(usize::MAX),
            rms: distance.map(|distance| distance.rms),
            max: distance.map(|distance| distance.max.max(-distance.min)),
            max_index: found.worst.first().map(|worst| worst.index),
            share_within: found.verdict.share,
            within_tolerance: found.verdict.pass,
            found,
        }
    }
}
