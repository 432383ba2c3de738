//! Many parameters of one shape at once.
//!
//! The parameters are grouped by span, so that those of a group share their control points, and each group
//! is evaluated in vectors of as many numbers as the processor has (found out at run time). Every result
//! has the same bits as the evaluation one by one: the same operations in the same order, none fused.

mod curve;
mod groups;
mod surface;
mod surface_lanes;

use crate::Error;

/// Fewer parameters than this are evaluated one by one.
const SMALLEST: usize = 16;

/// How many parameters are grouped at a time for a shape with so many control points: several for each
/// patch, but few enough that their results, which are not written in order, stay in the caches.
fn chunk_length(control_points: usize) -> usize {
    (8 * control_points).clamp(1 << 12, 1 << 16)
}

fn check_lengths(parameters: usize, results: usize) -> Result<(), Error> {
    if parameters == results {
        return Ok(());
    }
    Err(Error::argument(format!(
        "{parameters} parameters need as many results, but there is room for {results}"
    )))
}
