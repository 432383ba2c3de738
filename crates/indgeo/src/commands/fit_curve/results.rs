//! What a fit of curves found.

use super::joins::CurveJoin;
use industrial_geometry::fit::curve::CurveReport;
use serde::Serialize;

/// What a fit of a curve found.
#[derive(Debug, Serialize)]
pub(crate) struct CurveResults {
    /// What the library reports; of several curves together.
    #[serde(flatten)]
    pub(crate) fitted: CurveReport,
    /// Of each curve, if there are several.
    pub(crate) parts: Vec<CurveReport>,
    /// How it continues others.
    pub(crate) joins: Vec<CurveJoin>,
}
