//! Numbers of cells for each span so that every patch keeps the tolerance.

use super::TessellationOptions;
use super::bounds::SecondBounds;
use crate::{BsplineSurface, Error, KnotVector};

/// Parameters of the grid lines in `u` and `v`, ends included.
pub(super) fn grid_lines(
    surface: &BsplineSurface,
    options: &TessellationOptions,
) -> Result<[Vec<f64>; 2], Error> {
    let bounds: Vec<SecondBounds> = surface.bezier_patches().iter().map(SecondBounds::of).collect();
    let columns = surface.knots_v().spans().count();
    let mut cells = [vec![1.0_f64; surface.knots_u().spans().count()], vec![1.0_f64; columns]];
    loop {
        let vertices: f64 = cells.iter().map(|c| c.iter().sum::<f64>() + 1.0).product();
        if vertices > options.max_vertices as f64 {
            return Err(options.too_many());
        }
        let mut settled = true;
        for (k, bound) in bounds.iter().enumerate() {
            let (i, j) = (k / columns, k % columns);
            let (n, m) = (cells[0][i], cells[1][j]);
            let excess = bound.deviation(n, m) / options.abs_tolerance;
            if excess <= 1.0 {
                continue;
            }
            settled = false;
            // Finer in the direction that contributes more; at most doubled, then looked at again. Excess
            // may be infinite, and NaN has been taken for "fine" above, since no grid mends it.
            let grow = |count: f64| (count * excess.sqrt().min(2.0)).ceil().max(count + 1.0);
            let (along_u, along_v) = (bound.uu / (n * n), bound.vv / (m * m));
            if along_u > along_v || (along_u == along_v && n <= m) {
                cells[0][i] = grow(n);
            } else {
                cells[1][j] = grow(m);
            }
        }
        if settled {
            return Ok([lines(surface.knots_u(), &cells[0]), lines(surface.knots_v(), &cells[1])]);
        }
    }
}

fn lines(knots: &KnotVector, cells: &[f64]) -> Vec<f64> {
    let mut out = vec![knots.domain().start()];
    for (span, &count) in knots.spans().zip(cells) {
        let interval = knots.span_interval(span);
        let mut k = 1.0;
        while k <= count {
            out.push(interval.lerp(k / count));
            k += 1.0;
        }
    }
    out
}
