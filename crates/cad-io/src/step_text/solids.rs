//! Which closed shells of a part bound solids, and which are voids in them.

use brep_core::Model;
use brep_core::description::{InstanceDescription, ModelDescription, PartDescription, Placement};
use nurbs_core::Aabb;

/// Chord tolerance of the triangles from which volumes are found, as a share of the size.
const CHORD: f64 = 1e-3;

/// A solid by the indices of its shells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Solid {
    pub(super) outer: usize,
    pub(super) voids: Vec<usize>,
}

/// A closed shell: the volume that it bounds, negative where its normals point inwards, and a box.
#[derive(Clone, Copy)]
struct Body {
    shell: usize,
    volume: f64,
    bounds: Aabb<3>,
}

/// The solids that the closed shells of a part make. `None` where that cannot be told: a face is missing, or normals do not agree.
pub(super) fn of(part: &PartDescription) -> Option<Vec<Solid>> {
    let closed: Vec<usize> = (0..part.shells.len()).filter(|k| part.shells[*k].closed).collect();
    if let [only] = closed[..] {
        return Some(vec![Solid { outer: only, voids: Vec::new() }]);
    }
    if closed.is_empty() {
        return Some(Vec::new());
    }
    let bodies = bodies(part, &closed)?;
    let (outer, voids): (Vec<Body>, Vec<Body>) = bodies.into_iter().partition(|body| body.volume > 0.0);
    let mut solids: Vec<Solid> =
        outer.iter().map(|body| Solid { outer: body.shell, voids: Vec::new() }).collect();
    for void in voids {
        // The smallest one around it.
        let around = (0..outer.len()).filter(|k| holds(&outer[*k].bounds, &void.bounds));
        let owner = around.min_by(|a, b| outer[*a].volume.total_cmp(&outer[*b].volume))?;
        solids[owner].voids.push(void.shell);
    }
    Some(solids)
}

fn bodies(part: &PartDescription, closed: &[usize]) -> Option<Vec<Body>> {
    let instance = InstanceDescription { part: 0, name: String::new(), placement: Placement::IDENTITY };
    let description = ModelDescription {
        parts: vec![part.clone()],
        instances: vec![instance],
        ..ModelDescription::default()
    };
    let model = Model::new(&description).ok()?;
    let built = model.parts().first()?;
    if !model.unread().is_empty() || built.faces().len() != part.faces.len() {
        return None;
    }
    let found = model.tessellate(CHORD * model.bounds().diagonal()).ok()?;
    let centre = model.bounds().centre();
    let mut volumes = vec![0.0; part.shells.len()];
    let mut boxes: Vec<Option<Aabb<3>>> = vec![None; part.shells.len()];
    for (corners, [_, face]) in found.triangles.iter().zip(&found.faces) {
        let shell = built.faces()[*face].shell();
        let [a, b, c] = corners.map(|k| found.vertices[k as usize] - centre);
        volumes[shell] += a.dot(&b.cross(&c)) / 6.0;
        for corner in corners.map(|k| found.vertices[k as usize]) {
            boxes[shell] =
                Some(boxes[shell].map_or_else(|| Aabb::of_point(corner), |own| own.with_point(&corner)));
        }
    }
    closed
        .iter()
        .map(|&shell| {
            let volume = volumes[shell];
            let bounds = boxes[shell]?;
            (volume != 0.0 && volume.is_finite()).then_some(Body { shell, volume, bounds })
        })
        .collect()
}

fn holds(outer: &Aabb<3>, inner: &Aabb<3>) -> bool {
    (0..3).all(|i| outer.min[i] <= inner.min[i] && inner.max[i] <= outer.max[i])
}
