//! The result of an inspection.

use crate::{Deviations, InspectionOptions, Rounding, ShapeInfo, WorstPoint, percent};
use std::collections::BTreeMap;
use std::fmt;

/// Whether the cloud keeps to the tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Verdict {
    /// Whether `share ≥ min_share`, and at least one point was measured.
    pub pass: bool,
    /// Points within the tolerance.
    pub within: u64,
    /// Points that were judged: those measured, and those that are undecided, have no matching foot, or whose search did not
    /// converge.
    pub judged: u64,
    /// `within / judged`; 0 without points.
    pub share: f64,
    /// The share that was asked for.
    pub min_share: f64,
}

impl Verdict {
    pub(crate) fn new(within: u64, judged: u64, min_share: f64) -> Self {
        let share = if judged > 0 { within as f64 / judged as f64 } else { 0.0 };
        Self { pass: judged > 0 && share >= min_share, within, judged, share, min_share }
    }
}

/// Deviations of the points that belong to one surface.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ShapeDeviations {
    /// Index of the surface in the model.
    pub index: u32,
    /// What it is called.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub info: ShapeInfo,
    /// How its points deviate.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub deviations: Deviations,
}

/// Deviations of the points that belong to the faces of one part of a CAD model.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PartDeviations {
    /// Index of the instance of the part.
    pub index: u32,
    /// Name of the instance, or of the part; may be empty.
    pub name: String,
    /// How its points deviate.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub deviations: Deviations,
}

/// What an inspection found.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Inspection {
    /// Pass or fail.
    pub verdict: Verdict,
    /// How deviations were measured and judged.
    pub options: InspectionOptions,
    /// Number of points.
    pub points: u64,
    /// Number of points per outcome, zeros included.
    pub outcomes: BTreeMap<&'static str, u64>,
    /// All measured points.
    pub total: Deviations,
    /// The surfaces that at least one measured point belongs to.
    pub shapes: Vec<ShapeDeviations>,
    /// The parts of a CAD model that at least one measured point belongs to; empty for other models.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Vec::is_empty"))]
    pub parts: Vec<PartDeviations>,
    /// The points with the largest absolute deviations, the largest first.
    pub worst: Vec<WorstPoint>,
    /// Number of measured points to which a point of the shape that does not count, because its normal does not agree, is nearer.
    pub restricted: u64,
    /// No other point of the shape that counts was nearer to a measured point by more than this. A length.
    pub largest_gap: f64,
}

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = if self.verdict.pass { "pass" } else { "fail" };
        let Verdict { within, judged, .. } = self.verdict;
        let share = percent(within, judged, Rounding::Down);
        write!(f, "{verdict}: {within} of {judged} points within the tolerance ({share})")?;
        if let Some(distance) = &self.total.distance {
            let (min, max) = (distance.min, distance.max);
            write!(
                f,
                ", from {min} to {max}, mean {}, sigma {}",
                distance.mean, distance.standard_deviation
            )?;
        }
        Ok(())
    }
}
