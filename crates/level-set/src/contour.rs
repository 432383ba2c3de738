//! Contours: the curves of a level set in the plane.

use crate::Error;
use distance_field::{Grid, LevelSetField, Saddles};
use mesh_core::Polyline;

/// Cells of the lattice on which contours are traced, along a side of a cell of the grid: as many as the number of its nodes allows.
const DETAIL: [usize; 3] = [4, 3, 2];
const MOST_NODES: usize = 30_000_000;

/// The zero set of a level function in the plane: a field with its contours, the longest first.
///
/// # Errors
/// [`Error::Empty`] where the function does not change its sign.
pub fn contours(grid: &Grid<2>, saddles: Saddles) -> Result<LevelSetField<2>, Error> {
    // Where nodes decide what is connected, parts that no node sees are none.
    let detail = match saddles {
        Saddles::Middle => DETAIL.iter().copied().find(|d| grid.values().len() * d * d <= MOST_NODES),
        Saddles::Separate => None,
    };
    match LevelSetField::<2>::with_detail(grid, saddles, detail.unwrap_or(1)) {
        Err(distance_field::Error::NoPoints { .. }) => Err(empty(grid.values())),
        other => Ok(other?),
    }
}

/// What is said about a level function without a zero.
pub(crate) fn empty(values: &[f64]) -> Error {
    let side = if values.first().is_some_and(|value| *value < 0.0) { "inside" } else { "outside" };
    Error::Empty { what: format!("all {} nodes lie {side}; give another level or start", values.len()) }
}

/// The area on the left of a polygon: positive where it runs counter-clockwise, as outer contours do, negative for holes. Open polylines
/// are closed by a chord.
#[must_use]
pub fn signed_area(polygon: &Polyline<2>) -> f64 {
    let vertices = polygon.vertices();
    let Some(origin) = vertices.first() else { return 0.0 };
    let cross = |pair: &[nalgebra::Point2<f64>]| {
        let (a, b) = (pair[0] - origin, pair[1] - origin);
        a.x * b.y - a.y * b.x
    };
    0.5 * vertices.windows(2).map(cross).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn outer_contours_and_holes_have_their_signs() {
        let ring = |p: &Vector2<f64>| (p.norm() - 1.5).abs() - 0.5;
        let grid = Grid::sample(Vector2::repeat(-3.0), Vector2::repeat(0.05), [121, 121], ring).unwrap();
        let field = contours(&grid, Saddles::Middle).unwrap();
        let areas: Vec<f64> = field.contours().iter().map(signed_area).collect();
        let pi = std::f64::consts::PI;
        assert!((areas[0] - 4.0 * pi).abs() < 0.01 && (areas[1] + pi).abs() < 0.01, "{areas:?}");
        let none = Grid::sample(Vector2::zeros(), Vector2::repeat(1.0), [5, 5], |_| 1.0).unwrap();
        let error = contours(&none, Saddles::Middle).unwrap_err().to_string();
        assert!(error.contains("all 25 nodes lie outside"), "{error}");
    }
}
