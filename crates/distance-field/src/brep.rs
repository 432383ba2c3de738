//! The distance from CAD models with trimmed faces.

use crate::local_geometry::{LocalGeometry, of_curve, of_point, of_surface};
use crate::{DistanceField, Hint, PrincipalFrame, Search};
use brep_core::{Foot, Model, On, Side};
use footpoint::Status;
use nalgebra::Vector3;
use nurbs_core::Aabb;
use std::sync::Arc;

/// Gap of the certificate, as a share of the diagonal, up to which a foot counts as proven.
const GAP: f64 = 1e-7;

/// The distance from the faces and edges of a CAD model, signed by the normals of the faces.
///
/// Footpoints are exact and, in a global search, certified. On a face the frame is the principal frame of its surface; on
/// an edge the foot moves along the edge, at a vertex it cannot move. Where the side is not decided (at the boundary of an
/// open shell) the distance is positive.
#[derive(Clone, Debug)]
pub struct BrepField {
    model: Arc<Model>,
    /// Number of the first face of each instance, among the faces of all.
    first: Vec<usize>,
    size: f64,
}

impl BrepField {
    /// The distance from a model.
    #[must_use]
    pub fn new(model: Arc<Model>) -> Self {
        let mut total = 0;
        let first = model
            .instances()
            .iter()
            .map(|i| {
                let own = total;
                total += model.parts()[i.part].faces().len();
                own
            })
            .collect();
        let size = model.bounds().diagonal();
        Self { model, first, size }
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Instance and face of a hint.
    fn place(&self, hint: &Hint) -> Option<(usize, usize)> {
        let element = hint.element_below(usize::MAX)?;
        let instance = self.first.partition_point(|f| *f <= element).checked_sub(1)?;
        let face = element - self.first[instance];
        let part = self.model.instances()[instance].part;
        (face < self.model.parts()[part].faces().len()).then_some((instance, face))
    }

    fn frame_of(&self, x: &Vector3<f64>, foot: &Foot, status: Status) -> PrincipalFrame<3> {
        let residual = x - foot.point;
        let sided = foot.side != Side::Undecided || foot.distance <= GAP * self.size;
        let side = (sided && foot.normal != Vector3::zeros()).then_some(&foot.normal);
        let geometry: Option<LocalGeometry<3>> = match foot.on {
            On::Face { .. } => self.model.surface_jet(foot).and_then(|jet| of_surface(&jet, &residual)),
            On::Edge { .. } => self.model.curve_jet(foot).and_then(|jet| of_curve(&jet, &residual, side)),
            On::Vertex { .. } | On::Apex { .. } => None,
        };
        let geometry = geometry.unwrap_or_else(|| of_point(&residual, side));
        let hint = match foot.on {
            On::Face { face, uv } => Hint::new(self.first[foot.instance] + face, uv),
            _ => Hint::NONE,
        };
        PrincipalFrame {
            foot: foot.point,
            axes: geometry.axes,
            curvatures: geometry.curvatures,
            tangent_dimension: geometry.tangent_dimension,
            distance: geometry.distance,
            on_boundary: foot.beyond_boundary,
            hint,
            status,
        }
    }
}

impl DistanceField<3> for BrepField {
    fn frame(&self, x: &Vector3<f64>, search: Search, hint: &Hint) -> PrincipalFrame<3> {
        if search != Search::Global
            && let Some((instance, face)) = self.place(hint)
            && let Some(foot) = self.model.follow(x, instance, face, hint.parameter)
        {
            return self.frame_of(x, &foot, Status::Converged);
        }
        match self.model.nearest(x) {
            None => PrincipalFrame::invalid(Status::InvalidPoint),
            Some(foot) => {
                let status = if foot.gap() > GAP * self.size {
                    Status::Uncertified
                } else if foot.beyond_boundary {
                    Status::OnBoundary
                } else {
                    Status::Converged
                };
                self.frame_of(x, &foot, status)
            }
        }
    }

    fn distance(&self, x: &Vector3<f64>) -> f64 {
        self.model.nearest(x).map_or(f64::NAN, |foot| foot.distance)
    }

    fn bounding_box(&self) -> Aabb<3> {
        *self.model.bounds()
    }
}
