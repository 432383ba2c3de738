//! Where a surface folds back on itself.

use crate::parallel;
use nurbs_core::{BsplineSurface, ParametricSurface};

/// Places per direction in each cell at which normals are compared.
const PLACES: usize = 4;

/// Cells of a surface, and those in which its normal flips.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Folds {
    /// Number of cells (products of knot spans).
    pub cells: usize,
    /// The folded ones, by the index of their span in u and in v.
    pub folded: Vec<[usize; 2]>,
}

impl Folds {
    /// Looks for cells in which normals at neighbouring places enclose more than a right angle.
    ///
    /// Places are a grid of 4 × 4 in each cell that has the first and last place on its edges, so that cells are compared
    /// with their neighbours, too. A surface with edges sharper than a right angle is reported as folded there.
    #[must_use]
    pub fn of(surface: &BsplineSurface) -> Self {
        let spans = [surface.knots_u(), surface.knots_v()].map(|knots| {
            let spans: Vec<_> = knots.spans().map(|span| knots.span_interval(span)).collect();
            spans
        });
        let columns = spans[1].len();
        let cells = spans[0].len() * columns;
        let is_folded = parallel::map(cells, |cell| {
            let (a, b) = (spans[0][cell / columns], spans[1][cell % columns]);
            // A little beyond each end: into the neighbouring cells where there are any.
            let share = |k: usize| (k as f64 * 1.04) / (PLACES - 1) as f64 - 0.02;
            let normal = |i: usize, j: usize| {
                let jet = surface.jet(a.lerp(share(i)), b.lerp(share(j)));
                let [u, v] = [surface.knots_u(), surface.knots_v()].map(|knots| knots.domain());
                let inside = |t: f64, d: nurbs_core::Interval, closed: bool| closed || d.contains(t);
                let usable = inside(a.lerp(share(i)), u, surface.knots_u().is_periodic())
                    && inside(b.lerp(share(j)), v, surface.knots_v().is_periodic());
                if usable { jet.du.cross(&jet.dv).try_normalize(0.0) } else { None }
            };
            let normals: Vec<_> = (0..PLACES * PLACES).map(|k| normal(k / PLACES, k % PLACES)).collect();
            let flips = |k: usize, l: usize| match (normals[k], normals[l]) {
                (Some(m), Some(n)) => m.dot(&n) < 0.0,
                _ => false,
            };
            (0..PLACES * PLACES).any(|k| {
                (k % PLACES + 1 < PLACES && flips(k, k + 1))
                    || (k / PLACES + 1 < PLACES && flips(k, k + PLACES))
            })
        });
        let folded = (0..cells).filter(|&c| is_folded[c]).map(|c| [c / columns, c % columns]).collect();
        Self { cells, folded }
    }

    /// Number of folded cells.
    #[must_use]
    pub fn count(&self) -> usize {
        self.folded.len()
    }
}
