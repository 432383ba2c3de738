//! Models: parts in their places.

use crate::Error;
use crate::description::{Converted, LengthUnit, ModelDescription, Placement, PmiTolerance, Unread};
use crate::foot::{Foot, On, Side};
use crate::parallel;
use crate::part::Part;
use nalgebra::Vector3;
use nurbs_core::Aabb;

/// A CAD model that answers queries.
#[derive(Clone, Debug)]
pub struct Model {
    unit: Option<LengthUnit>,
    uncertainty: Option<f64>,
    parts: Vec<Part>,
    instances: Vec<Instance>,
    unread: Vec<Unread>,
    converted: Vec<Converted>,
    tolerances: Vec<PmiTolerance>,
    bounds: Aabb<3>,
}

/// A part in its place.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index of the part.
    pub part: usize,
    /// Name; may be empty.
    pub name: String,
    /// From the coordinates of the part to those of the model.
    pub placement: Placement,
    bounds: Aabb<3>,
}

impl Model {
    /// Builds a model from what a file says.
    ///
    /// Faces that cannot be used are left out and listed by [`unread`](Self::unread); their shells count as open.
    ///
    /// # Errors
    /// [`Error::Empty`] when nothing is left, [`Error::Description`] for indices of things that do not exist.
    pub fn new(description: &ModelDescription) -> Result<Self, Error> {
        let built: Vec<_> = parallel::map(&description.parts, Part::new);
        let mut unread = description.unread.clone();
        let mut parts = Vec::new();
        for part in built {
            let (part, left_out) = part?;
            unread.extend(left_out.into_iter().map(|(source, error)| Unread {
                source,
                kind: "face or edge".to_owned(),
                why: error.to_string(),
            }));
            parts.push(part);
        }
        let mut instances = Vec::new();
        for instance in &description.instances {
            let what = || format!("instance \"{}\"", instance.name);
            let part =
                parts.get(instance.part).ok_or_else(|| Error::of(what(), "its part does not exist"))?;
            let placement = instance.placement;
            check(&placement).map_err(|why| Error::of(what(), why))?;
            let Some(own) = part.bounds() else { continue };
            let corners: Vec<_> =
                (0..8)
                    .map(|k| {
                        placement.point(&Vector3::from_fn(|i, _| {
                            if k >> i & 1 == 0 { own.min[i] } else { own.max[i] }
                        }))
                    })
                    .collect();
            let bounds = Aabb::of_points(&corners).ok_or(Error::Empty)?;
            let bounds = bounds.inflated(1e-12 * bounds.diagonal());
            instances.push(Instance { part: instance.part, name: instance.name.clone(), placement, bounds });
        }
        let bounds = instances.iter().map(|i| i.bounds).reduce(|a, b| a.merged(&b)).ok_or(Error::Empty)?;
        Ok(Self {
            unit: description.unit.clone(),
            uncertainty: description.uncertainty,
            parts,
            instances,
            unread,
            converted: description.converted.clone(),
            tolerances: description.tolerances.clone(),
            bounds,
        })
    }

    /// Unit of all lengths.
    #[must_use]
    pub fn unit(&self) -> Option<&LengthUnit> {
        self.unit.as_ref()
    }

    /// Distance below which the file holds points to be equal.
    #[must_use]
    pub fn uncertainty(&self) -> Option<f64> {
        self.uncertainty
    }

    /// Parts.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Parts in their places.
    #[must_use]
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// What the file holds and the model does not.
    #[must_use]
    pub fn unread(&self) -> &[Unread] {
        &self.unread
    }

    /// Faces on surfaces that the file has in another form.
    #[must_use]
    pub fn converted(&self) -> &[Converted] {
        &self.converted
    }

    /// Tolerances and dimensions that the file states.
    #[must_use]
    pub fn tolerances(&self) -> &[PmiTolerance] {
        &self.tolerances
    }

    /// A box that contains the model.
    #[must_use]
    pub fn bounds(&self) -> &Aabb<3> {
        &self.bounds
    }

    /// The closest point; `None` for a point that is not finite, or whose distance is not.
    #[must_use]
    pub fn nearest(&self, x: &Vector3<f64>) -> Option<Foot> {
        if !x.iter().all(|c| c.is_finite()) {
            return None;
        }
        match self.nearer(x) {
            Some(near) => self.nearest_to(&near)?.of_far(x),
            None => self.nearest_to(x),
        }
    }

    fn nearest_to(&self, x: &Vector3<f64>) -> Option<Foot> {
        let mut order: Vec<(f64, usize)> =
            self.instances.iter().enumerate().map(|(i, instance)| (instance.bounds.distance(x), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<Foot> = None;
        let mut lower = f64::INFINITY;
        for (distance, index) in order {
            let reach = best.as_ref().map_or(f64::INFINITY, |b| b.distance);
            // Parts may touch: a foot as near on another one, inside of which the point is, tells the side.
            let reach = reach + 1e-11 * self.bounds.diagonal();
            if distance > reach {
                break;
            }
            let instance = &self.instances[index];
            let Placement { scale, .. } = instance.placement;
            let local = instance.placement.inverse_point(x);
            let (found, bound) = self.parts[instance.part].nearest_within(&local, reach / scale);
            lower = lower.min(bound * scale);
            let Some(found) = found else { continue };
            let point = instance.placement.point(&found.point);
            let distance = (x - point).norm();
            let inside = found.side == Side::Negative && distance <= reach;
            let replaces = best.as_ref().is_none_or(|b| {
                distance < b.distance
                    || (inside && b.side == Side::Positive && self.is_closed_at(instance.part, &found))
            });
            if replaces {
                best = Some(Foot {
                    instance: index,
                    point,
                    distance,
                    normal: instance.placement.direction(&found.normal),
                    ..found
                });
            }
        }
        let foot = best.map(|foot| Foot { lower_bound: lower.min(foot.distance), ..foot })?;
        let on_face = matches!(foot.on, On::Face { .. });
        if !on_face && foot.side == Side::Positive && self.is_inside_another(x, foot.instance) {
            // An edge inside of another solid: the point is in the material, whatever the faces at the edge say.
            return Some(Foot { side: Side::Negative, normal: -foot.normal, ..foot });
        }
        Some(foot)
    }

    /// Whether a point is inside of a solid of another instance.
    fn is_inside_another(&self, x: &Vector3<f64>, than: usize) -> bool {
        self.instances.iter().enumerate().any(|(index, instance)| {
            index != than && instance.bounds.contains(x) && {
                let part = &self.parts[instance.part];
                let found = part.nearest(&instance.placement.inverse_point(x));
                found.is_some_and(|f| f.side == Side::Negative && self.is_closed_at(instance.part, &f))
            }
        })
    }

    /// Whether the face of a foot belongs to a closed shell.
    fn is_closed_at(&self, part: usize, foot: &Foot) -> bool {
        let part = &self.parts[part];
        foot.face.is_some_and(|face| part.shells[part.faces[face].shell].closed)
    }

    /// The closest points of many, in parallel; `None` for points that are not finite.
    #[must_use]
    pub fn nearest_many(&self, points: &[Vector3<f64>]) -> Vec<Option<Foot>> {
        parallel::map(points, |x| self.nearest(x))
    }
}

/// Checks that a placement is a similarity.
fn check(placement: &Placement) -> Result<(), String> {
    let Placement { rotation, translation, scale } = placement;
    if !(*scale > 0.0 && scale.is_finite() && translation.iter().all(|c| c.is_finite())) {
        return Err("its placement is not finite".to_owned());
    }
    let off = (rotation.transpose() * rotation - nalgebra::Matrix3::identity()).amax();
    if off.is_nan() || off >= 1e-9 {
        return Err("its placement is not a rotation".to_owned());
    }
    Ok(())
}
