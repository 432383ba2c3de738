//! Pieces of a tour that was cut.

use nalgebra::SVector;

/// Length of a ring in units of the gap between its ends that is none.
const AROUND: f64 = 3.0;
/// Nodes of a ring at least.
const FEWEST: usize = 3;

/// What is between the cuts of a closed tour, the piece behind each.
pub(super) fn between<const D: usize>(
    nodes: &[SVector<f64, D>],
    cuts: &[usize],
) -> Vec<Vec<SVector<f64, D>>> {
    let n = nodes.len();
    let piece = |(k, &cut): (usize, &usize)| {
        let end = cuts[(k + 1) % cuts.len()];
        let count = (end + n - cut - 1) % n + 1;
        (1..=count).map(|i| nodes[(cut + i) % n]).collect()
    };
    cuts.iter().enumerate().map(piece).collect()
}

/// Whether all pieces are further from each other than a distance.
pub(super) fn are_apart<const D: usize>(pieces: &[Vec<SVector<f64, D>>], distance: f64) -> bool {
    pieces.iter().enumerate().all(|(k, piece)| {
        let near = |a: &SVector<f64, D>| {
            pieces[k + 1..].iter().flatten().any(|b| (a - b).norm_squared() <= distance * distance)
        };
        !crate::parallel::map(piece.len(), |i| near(&piece[i])).contains(&true)
    })
}

/// Whether the ends of a piece are near to each other, and the way around is much longer than that.
pub(super) fn is_ring<const D: usize>(piece: &[SVector<f64, D>], limit: f64) -> bool {
    let length: f64 = piece.windows(2).map(|p| (p[1] - p[0]).norm()).sum();
    piece.len() > FEWEST && (piece[0] - piece[piece.len() - 1]).norm() <= limit && length >= AROUND * limit
}

/// Joins pieces whose ends are as near to each other as neighbours, the nearest first, unless a piece is closed itself.
pub(super) fn join<const D: usize>(pieces: &mut Vec<Vec<SVector<f64, D>>>, limit: f64) {
    loop {
        let mut best: Option<(f64, usize, usize, bool, bool)> = None;
        for i in 0..pieces.len() {
            for j in i + 1..pieces.len() {
                if is_ring(&pieces[i], limit) || is_ring(&pieces[j], limit) {
                    continue;
                }
                for (first, second) in [(false, false), (false, true), (true, false), (true, true)] {
                    let end = |k: usize, start: bool| pieces[k][if start { 0 } else { pieces[k].len() - 1 }];
                    let distance = (end(i, first) - end(j, second)).norm();
                    if distance <= limit && best.is_none_or(|b| distance < b.0) {
                        best = Some((distance, i, j, first, second));
                    }
                }
            }
        }
        let Some((_, i, j, first, second)) = best else { return };
        let mut other = pieces.remove(j);
        if first {
            pieces[i].reverse();
        }
        if !second {
            other.reverse();
        }
        pieces[i].append(&mut other);
    }
}
