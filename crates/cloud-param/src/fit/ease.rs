//! Part of the way from one surface to another: as far as there are no folds.

use crate::Error;
use nurbs_core::BsplineSurface;
use sdm_fit::Folds;

/// How often control points around folds are moved back.
const ROUNDS: usize = 40;
/// Share of the way that they are moved back each time.
const BACK: f64 = 0.34;

/// The surface `to` with control points moved back towards those of `from`, which has the same knots, around the cells in
/// which it folds, and the share of the way that they were moved on average; `None` if that leaves more folds than are allowed.
pub(super) fn eased(
    from: &BsplineSurface,
    to: &BsplineSurface,
    allowed: usize,
) -> Result<Option<(BsplineSurface, f64)>, Error> {
    let (m, n) = (to.knots_u().distinct_count(), to.knots_v().distinct_count());
    let (n_u, n_v) = (to.n_u(), to.n_v());
    let closed = [to.knots_u().is_periodic(), to.knots_v().is_periodic()];
    let mut back = vec![0.0f64; m * n];
    let mut surface = to.clone();
    for round in 0..=ROUNDS {
        let folded = Folds::of(&surface).folded;
        if folded.len() <= allowed {
            return Ok(Some((surface, back.iter().sum::<f64>() / back.len().max(1) as f64)));
        }
        if round == ROUNDS {
            break;
        }
        let mut touched = vec![false; m * n];
        for [i, j] in folded {
            // Spans are numbered as the first control points that they depend on, where no knots are repeated.
            for k in 0..=to.degree_u() {
                for l in 0..=to.degree_v() {
                    touched[((i + k) % m) * n + (j + l) % n] = true;
                }
            }
        }
        for (slot, _) in back.iter_mut().zip(touched).filter(|(_, t)| *t) {
            *slot = (*slot + BACK).min(1.0);
        }
        // Others go along with their neighbours, so that the change is gradual.
        let share = |i: usize, j: usize| {
            let around = (0..9).filter_map(|k| {
                let (a, b) = (i + m + k / 3 - 1, j + n + k % 3 - 1);
                let inside = (closed[0] || (m..2 * m).contains(&a)) && (closed[1] || (n..2 * n).contains(&b));
                inside.then_some(back[(a % m) * n + b % n])
            });
            let (sum, count) = around.fold((0.0, 0.0), |(s, c), x| (s + x, c + 1.0));
            (sum / count).max(back[i * n + j])
        };
        let net = (0..n_u * n_v).map(|k| {
            let (i, j) = (k / n_v, k % n_v);
            to.control_point(i, j).lerp(&from.control_point(i, j), share(i % m, j % n))
        });
        surface = BsplineSurface::new(to.knots_u().clone(), to.knots_v().clone(), net.collect(), None)?;
    }
    Ok(None)
}
