//! The best placements met so far.

use super::{StartMethod, placement::Placement};

/// Placements nearer than this, in diagonals of the model, are one.
pub(crate) const SAME: f64 = 0.02;

/// Never more placements than this are kept.
const CAPACITY: usize = 32;

#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) placement: Placement,
    pub(crate) score: f64,
    pub(crate) votes: usize,
    pub(crate) method: StartMethod,
    last_round: usize,
}

/// Placements that differ, by descending score.
#[derive(Debug)]
pub(crate) struct Pool {
    pub(crate) entries: Vec<Entry>,
    radius: f64,
}

impl Pool {
    /// An empty pool for a cloud with the given radius of inertia.
    pub(crate) fn new(radius: f64) -> Self {
        Self { entries: Vec::new(), radius }
    }

    /// Adds a placement, or a vote to the one that is the same.
    pub(crate) fn add(&mut self, placement: Placement, score: f64, method: StartMethod, round: usize) {
        let radius = self.radius;
        let same = self.entries.iter_mut().find(|entry| entry.placement.distance(&placement, radius) < SAME);
        match same {
            Some(entry) => {
                if entry.last_round != round {
                    entry.votes += 1;
                    entry.last_round = round;
                }
                if score > entry.score {
                    (entry.placement, entry.score, entry.method) = (placement, score, method);
                }
            }
            None => self.entries.push(Entry { placement, score, votes: 1, method, last_round: round }),
        }
        self.entries.sort_by(|a, b| b.score.total_cmp(&a.score));
        self.entries.truncate(CAPACITY);
    }
}

/// The best of scored placements, each farther than `apart` from all better ones.
pub(crate) fn distinct(
    mut scored: Vec<(f64, Placement)>,
    apart: f64,
    radius: f64,
    count: usize,
) -> Vec<(f64, Placement)> {
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut out: Vec<(f64, Placement)> = Vec::new();
    for (score, placement) in scored {
        if out.len() == count {
            break;
        }
        if out.iter().all(|(_, other)| other.distance(&placement, radius) > apart) {
            out.push((score, placement));
        }
    }
    out
}
