//! Derivatives at feet, in the coordinates of the model.

use crate::boundary::Inside;
use crate::description::Placement;
use crate::foot::{Foot, On};
use crate::model::Model;
use crate::sign::side;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{CurveJet, SurfaceJet};

/// A vector of a part in the coordinates of the model.
fn carried(placement: &Placement, v: &Vector3<f64>) -> Vector3<f64> {
    placement.rotation * v * placement.scale
}

impl Model {
    /// Derivatives of the carrier at a foot inside a face; `S_u × S_v` has the direction of the normal of the face.
    #[must_use]
    pub fn surface_jet(&self, foot: &Foot) -> Option<SurfaceJet> {
        let On::Face { face, uv } = foot.on else { return None };
        let instance = self.instances().get(foot.instance)?;
        let face = self.parts()[instance.part].faces.get(face)?;
        let jet = face.surface.jet(&Vector2::from(uv));
        let placement = &instance.placement;
        let of = |v: &Vector3<f64>| carried(placement, v);
        let mirrored = placement.rotation.determinant() < 0.0;
        let out = SurfaceJet {
            point: placement.point(&jet.point),
            du: of(&jet.du),
            dv: of(&jet.dv),
            duu: of(&jet.duu),
            duv: of(&jet.duv),
            dvv: of(&jet.dvv),
        };
        // Exchanged parameters turn the normal over.
        Some(if face.same_sense == mirrored {
            SurfaceJet { du: out.dv, dv: out.du, duu: out.dvv, dvv: out.duu, ..out }
        } else {
            out
        })
    }

    /// Derivatives of the curve at a foot on an edge.
    #[must_use]
    pub fn curve_jet(&self, foot: &Foot) -> Option<CurveJet<3>> {
        let On::Edge { edge, t } = foot.on else { return None };
        let instance = self.instances().get(foot.instance)?;
        let jet = self.parts()[instance.part].edges.get(edge)?.curve.jet(t);
        let placement = &instance.placement;
        Some(CurveJet {
            point: placement.point(&jet.point),
            d1: carried(placement, &jet.d1),
            d2: carried(placement, &jet.d2),
        })
    }

    /// The foot on a face near known parameters, where the point is nearest to that face alone; `None` where that foot
    /// is not inside the face. Nothing is proven: another face may be nearer.
    #[must_use]
    pub fn follow(&self, x: &Vector3<f64>, instance: usize, face: usize, uv: [f64; 2]) -> Option<Foot> {
        let placement = &self.instances().get(instance)?.placement;
        let part = &self.parts()[self.instances()[instance].part];
        let f = part.faces.get(face)?;
        let local = placement.inverse_point(x);
        if !local.iter().all(|c| c.is_finite()) {
            return None;
        }
        let uv = match f.surface.spline() {
            Some(spline) => {
                let found = spline.projector.project_from(&local, 0, spline.inside(uv, f.surface.period));
                if !found.status.is_converged() {
                    return None;
                }
                Vector2::from(found.parameter)
            }
            None => {
                let off = |p: &Vector2<f64>| (local - f.surface.point(p)).norm();
                f.surface.near_feet(&local).into_iter().min_by(|a, b| off(a).total_cmp(&off(b)))?
            }
        };
        if f.inside(&part.edges, &uv) != Inside::In {
            return None;
        }
        let own = f.surface.point(&uv);
        let point = placement.point(&own);
        let normal = f.normal([uv.x, uv.y]);
        Some(Foot {
            instance,
            face: Some(face),
            on: On::Face { face, uv: [uv.x, uv.y] },
            point,
            distance: (x - point).norm(),
            lower_bound: 0.0,
            side: side(&(local - own), &normal),
            normal: placement.direction(&normal),
            beyond_boundary: false,
        })
    }
}
