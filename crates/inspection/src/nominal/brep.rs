//! Deviations from CAD models with trimmed faces.

use super::signed;
use crate::{Deviation, Error, Outcome, Place};
use brep_core::{Foot, Model, On};
use footpoint::Facing;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;

/// Difference of distances, as a share of them and of the size, up to which a foot is as near as the nearest of all.
const SAME: f64 = 1e-9;

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

    /// The deviation along the shortest line, to a face that agrees with the normal of the point where that is asked for.
    pub(super) fn shortest(&self, point: &Point3<f64>, facing: Option<&Facing>) -> Deviation {
        // The point is finite: its distance is no number.
        let Some(nearest) = self.model.nearest(&point.coords) else {
            return Deviation::none(Outcome::NotConverged);
        };
        match facing {
            // A face that agrees and is the nearest of all needs no other search.
            Some(facing) if !(matches!(nearest.on, On::Face { .. }) && facing.agrees(&nearest.normal)) => {
                match self.model.nearest_facing(&point.coords, facing) {
                    Some(foot) => {
                        let is_restricted =
                            foot.distance > nearest.distance * (1.0 + SAME) + SAME * self.size();
                        Deviation { is_restricted, ..self.deviation(&foot) }
                    }
                    None => Deviation::none(Outcome::NoMatchingFoot),
                }
            }
            _ => self.deviation(&nearest),
        }
    }

    /// The deviation along a line in a direction of length 1, followed up to `reach` in both senses.
    pub(super) fn along(
        &self,
        point: &Point3<f64>,
        direction: &Vector3<f64>,
        reach: f64,
        facing: Option<&Facing>,
    ) -> Deviation {
        let Some(found) = self.model.nearest_on_line(&point.coords, direction, reach, facing) else {
            return Deviation::none(Outcome::NotConverged);
        };
        let Some(hit) = found.nearest else {
            return match (found.free < f64::INFINITY, found.refused < f64::INFINITY) {
                (true, _) => Deviation::none(Outcome::NotConverged),
                (false, false) => Deviation::none(Outcome::NoHit),
                // Whether there is another crossing, too far away, makes a difference.
                (false, true) if reach < f64::INFINITY => self.along(point, direction, f64::INFINITY, facing),
                (false, true) => Deviation::none(Outcome::NoMatchingFoot),
            };
        };
        let size = hit.offset.abs();
        Deviation {
            outcome: if found.free < size { Outcome::Undecided } else { Outcome::Measured },
            foot: hit.point.into(),
            normal: hit.normal,
            distance: signed(size, &(direction * -hit.offset), &hit.normal),
            gap: size - found.free,
            parameter: hit.uv,
            shape: u32::try_from(self.first[hit.instance] + hit.face).unwrap_or(u32::MAX),
            triangle: u32::MAX,
            place: if hit.is_at_edge { Place::Edge } else { Place::Interior },
            corner: 0,
            is_restricted: found.refused < size,
            on_boundary: false,
        }
    }

    /// The unit normal of a face, by its number among those of all instances.
    pub(super) fn face_normal(&self, shape: usize, parameter: [f64; 2]) -> Vector3<f64> {
        let index = self.first.partition_point(|first| *first <= shape).saturating_sub(1);
        let Some(instance) = self.model.instances().get(index) else { return Vector3::zeros() };
        let face = self.model.parts()[instance.part].faces().get(shape - self.first[index]);
        face.map_or_else(Vector3::zeros, |face| instance.placement.direction(&face.normal(parameter)))
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

    /// The unit normal at the foot of a point, on a face that agrees with a direction if one is given.
    pub(super) fn normal(&self, point: &Point3<f64>, facing: Option<&Facing>) -> Vector3<f64> {
        let foot = match facing {
            Some(facing) => self.model.nearest_facing(&point.coords, facing),
            None => self.model.nearest(&point.coords),
        };
        foot.map_or_else(Vector3::zeros, |foot| foot.normal)
    }
}
