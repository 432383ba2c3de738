//! A place to start a local iteration from: next to the query, as far as a few samples tell.

use crate::global::arithmetic::lanes::{Row, WIDTH, zero_row};
use crate::global::curve::piece::PieceSet;
use crate::global::curve::scratch::CurveScratch;
use crate::global::proof::box_tests::argmin;
use crate::global::surface::patch::PatchSet;
use crate::global::surface::scratch::Scratch;
use crate::global::tree::{Content, Visit};
use nalgebra::{SVector, Vector3};

/// Pieces that are sampled at most: more boxes than these around a query come in no order that says anything.
const MOST: usize = 64;

impl<const K: usize> PatchSet<K> {
    /// The lowest of the places that the distance functions of the pieces around `x` single out; `None` where numbers overflow.
    #[inline(always)]
    pub(crate) fn nearest_sample(
        &self,
        x: &Vector3<f64>,
        scratch: &mut Scratch<K>,
    ) -> Option<(usize, [f64; 2])> {
        let (mut best, mut best_sq) = (None, f64::INFINITY);
        let query = [x.x, x.y, x.z];
        let mut sampled = 0;
        scratch.visits.clear();
        scratch.visits.push(Visit::root());
        while let Some(visit) = scratch.visits.pop() {
            if visit.distance_sq >= best_sq {
                continue;
            }
            let index = match visit.content() {
                Content::Node(node) => {
                    self.tree.expand(node, &query, best_sq, &mut scratch.visits);
                    continue;
                }
                Content::Item(index) => index,
            };
            let patch = &self.patches[index];
            let m = patch.rows();
            if scratch.rows.len() < m {
                scratch.rows.resize(m, zero_row());
            }
            let rows = &mut scratch.rows[..m];
            self.form(patch, &(x - patch.centre), 0.0, rows);
            let place = argmin(rows);
            let distance_sq = self.distance_sq(x, index, place);
            if distance_sq < best_sq {
                (best, best_sq) = (Some((index, place)), distance_sq);
            }
            sampled += 1;
            if sampled == MOST {
                break;
            }
        }
        best
    }
}

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// The lowest of the places that the distance functions of the pieces around `x` single out; `None` where numbers overflow.
    #[inline(always)]
    pub(crate) fn nearest_sample(
        &self,
        x: &SVector<f64, D>,
        scratch: &mut CurveScratch<K>,
    ) -> Option<(usize, f64)> {
        let (mut best, mut best_sq) = (None, f64::INFINITY);
        let query: [f64; D] = (*x).into();
        let mut sampled = 0;
        scratch.visits.clear();
        scratch.visits.push(Visit::root());
        while let Some(visit) = scratch.visits.pop() {
            if visit.distance_sq >= best_sq {
                continue;
            }
            let index = match visit.content() {
                Content::Node(node) => {
                    self.tree.expand(node, &query, best_sq, &mut scratch.visits);
                    continue;
                }
                Content::Item(index) => index,
            };
            let piece = &self.pieces[index];
            let place = lowest(&self.form(piece, &(x - piece.centre), 0.0));
            let distance_sq = self.distance_sq(x, index, place);
            if distance_sq < best_sq {
                (best, best_sq) = (Some((index, place)), distance_sq);
            }
            sampled += 1;
            if sampled == MOST {
                break;
            }
        }
        best
    }
}

/// Place of the smallest coefficient.
#[inline(always)]
fn lowest<const K: usize>(row: &Row<K>) -> f64 {
    let mut best = (f64::INFINITY, 0);
    for j in 0..WIDTH * K {
        let value = row[j / WIDTH].0[j % WIDTH];
        if value < best.0 {
            best = (value, j);
        }
    }
    best.1 as f64 / (WIDTH * K - 1) as f64
}
