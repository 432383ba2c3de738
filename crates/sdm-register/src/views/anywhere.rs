//! Views about whose poses nothing is known.

use super::ViewsOptions;
use super::chain::PairSearch;
use super::register::register_views;
use super::report::ViewsReport;
use super::view::View;
use crate::Error;
use footpoint::Progress;

/// Registers views about whose poses nothing is known.
///
/// All pairs are registered coarsely ([`crate::start`]); a tree of the pairs that fit best gives the initial poses for
/// [`register_views`]. The first view keeps its frame. Views that fit about as well elsewhere end as [`Ambiguous`](super::ViewsStatus::Ambiguous).
///
/// # Errors
/// As for [`register_views`].
pub fn register_views_from(
    views: &[View],
    options: &ViewsOptions,
    progress: Progress<'_>,
) -> Result<ViewsReport, Error> {
    let search = PairSearch::new(views, options, progress)?;
    let report = register_views(views, &search.poses(), options, progress)?;
    Ok(search.judged(views, report))
}
