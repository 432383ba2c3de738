//! Deviations from CAD models with trimmed faces.

use crate::{Deviation, Error, Outcome, Place};
use brep_core::{Foot, Model, On};
use nalgebra::{Point3, Vector3};
use std::sync::Arc;

/// A model, and the number of the first face of each instance among the faces of all.
#[derive(Debug)]
pub(super) struct BrepNominal {
    model: Arc<Model>,
    first: Vec<usize>,
    count: usize,
}

impl BrepNominal {
    pub(super) fn new(model: Arc<Model>) -> Result<Self, Error> {
        let mut count = 0;
        let first = model
            .instances()
            .iter()
            .map(|i| {
                let own = count;
                count += model.parts()[i.part].faces().len();
                own
            })
            .collect();
        if count == 0 {
            return Err(Error::EmptyModel);
        }
        Ok(Self { model, first, count })
    }

    pub(super) fn model(&self) -> &Model {
        &self.model
    }

    pub(super) fn face_count(&self) -> usize {
        self.count
    }

    /// The largest side of a box around the model.
    pub(super) fn size(&self) -> f64 {
        self.model.bounds().sides().max()
    }

    /// The deviation along the shortest line.
    pub(super) fn shortest(&self, point: &Point3<f64>) -> Deviation {
        match self.model.nearest(&point.coords) {
            Some(foot) => self.deviation(&foot),
            None => Deviation::none(Outcome::InvalidPoint),
        }
    }

    fn deviation(&self, foot: &Foot) -> Deviation {
        // Where the side is not known, nothing is proven about the deviation but its size.
        let signed = foot.signed_distance();
        let distance = signed.unwrap_or(foot.distance);
        let shape = foot.face.map(|face| self.first[foot.instance] + face);
        Deviation {
            outcome: if signed.is_some() { Outcome::Measured } else { Outcome::Undecided },
            foot: foot.point.into(),
            normal: foot.normal,
            distance,
            gap: if signed.is_some() { foot.gap() } else { foot.distance },
            parameter: match foot.on {
                On::Face { uv, .. } => uv,
                _ => [f64::NAN; 2],
            },
            shape: shape.and_then(|s| u32::try_from(s).ok()).unwrap_or(u32::MAX),
            triangle: u32::MAX,
            place: match foot.on {
                On::Face { .. } => Place::Interior,
                On::Edge { .. } => Place::Edge,
                On::Vertex { .. } => Place::Corner,
                On::Apex { .. } => Place::Pole,
            },
            corner: 0,
            is_restricted: false,
            on_boundary: foot.beyond_boundary,
        }
    }

    /// The unit normal at the foot of a point.
    pub(super) fn normal(&self, point: &Point3<f64>) -> Vector3<f64> {
        self.model.nearest(&point.coords).map_or_else(Vector3::zeros, |foot| foot.normal)
    }
}
