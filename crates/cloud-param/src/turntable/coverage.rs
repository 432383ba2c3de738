//! How far the layers of a cloud close around an axis.

use crate::AxisFrame;
use crate::section::from_middle;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{PI, TAU};

/// Points per cell that are aimed at.
const PER_CELL: f64 = 10.0;

/// Which directions around the axis have points, layer by layer.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Coverage {
    /// Share of the directions that have points, for each layer from the lowest to the highest.
    pub layers: Vec<f64>,
    /// Widest gap between directions that have points, as a share of a whole turn, for each layer.
    pub gaps: Vec<f64>,
    /// Number of directions that are told apart.
    pub directions: usize,
}

impl Coverage {
    /// Counts the cells of layers and directions that points fall into; directions are taken from the middle of each
    /// layer, which is straightened along its mean line first if it is long, thin and closed, as the section of a blade.
    #[must_use]
    pub fn new(points: &[Vector3<f64>], frame: &AxisFrame) -> Self {
        let local: Vec<Vector3<f64>> = points.iter().map(|p| frame.to_local(p)).collect();
        let (low, high) =
            local.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.z), h.max(p.z)));
        let cells = local.len() as f64 / PER_CELL;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let (layers, directions) =
            ((cells.sqrt() * 0.7).clamp(4.0, 24.0) as usize, (cells.sqrt() * 1.4).clamp(8.0, 48.0) as usize);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let layer = |p: &Vector3<f64>| {
            (((p.z - low) / (high - low) * layers as f64).max(0.0) as usize).min(layers - 1)
        };
        let mut sections: Vec<Vec<Vector2<f64>>> = vec![Vec::new(); layers];
        for p in &local {
            sections[layer(p)].push(p.xy());
        }
        let mut occupied = vec![false; layers * directions];
        for (row, section) in sections.iter().enumerate() {
            for away in from_middle(section).0 {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
                let column =
                    (((away.y.atan2(away.x) + PI) / TAU * directions as f64) as usize).min(directions - 1);
                occupied[row * directions + column] = true;
            }
        }
        let share = |row: &[bool]| row.iter().filter(|&&o| o).count() as f64 / directions as f64;
        let gap = |row: &[bool]| {
            // Twice around, so that a gap across the start is found whole.
            let runs = row.iter().chain(row).scan(0usize, |run, &o| {
                *run = if o { 0 } else { *run + 1 };
                Some(*run)
            });
            runs.max().unwrap_or(0).min(directions) as f64 / directions as f64
        };
        Self {
            layers: occupied.chunks_exact(directions).map(share).collect(),
            gaps: occupied.chunks_exact(directions).map(gap).collect(),
            directions,
        }
    }

    /// Mean over the layers.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.layers.iter().sum::<f64>() / self.layers.len().max(1) as f64
    }

    /// Median over the layers.
    #[must_use]
    pub fn median(&self) -> f64 {
        quantile(&self.layers, 1, 2)
    }

    /// The gap that three of four layers do not exceed, as a share of a whole turn.
    #[must_use]
    pub fn typical_gap(&self) -> f64 {
        quantile(&self.gaps, 3, 4)
    }
}

fn quantile(values: &[f64], part: usize, parts: usize) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() * part / parts).copied().unwrap_or(0.0)
}
