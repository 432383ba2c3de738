//! STEP files out, as text: AP242, faces with their loops, free curves.

mod curves;
mod faces;
mod instances;
mod product;
mod solids;

use crate::Error;
use crate::write::flat::{placed, unwritable};
use brep_core::description::{LengthUnit, ModelDescription, PartDescription};
use faces::Faces;
use instances::{Instances, Reference, list};

/// The bytes of a STEP file (ISO 10303-21, AP242) of a model.
///
/// Faces become advanced faces with their names, on elementary surfaces where the carrier is one; edges and vertices are shared
/// as in the description. A face without loops gets those that its surface has by itself: its sides, with seams where it
/// is closed. Closed shells become solids, those inside of others whose normals point into them voids; other shells become surface
/// models, free curves a geometric set. Instances are
/// put in their places in one product. Numbers keep every bit; B-splines that are not clamped are clamped first. A file
/// without a unit is in millimetres. The same model always gives the same bytes, so the file bears no time.
///
/// # Errors
/// [`Error::Unwritable`] names the face or curve that cannot be written: an unbounded carrier without loops, a loop
/// without edges, an index that leads nowhere; or says that there is nothing to write.
pub fn to_step(model: &ModelDescription) -> Result<Vec<u8>, Error> {
    let parts = placed(model)?;
    if parts.iter().all(|part| part.faces.is_empty() && part.curves.is_empty()) {
        return Err(unwritable("model", "it has no faces and no curves"));
    }
    let unit = model.unit.clone().unwrap_or_else(LengthUnit::millimetre);
    let mut out = Instances::default();
    let first_name = parts.iter().map(|part| part.name.as_str()).find(|name| !name.is_empty());
    let name = if model.name.is_empty() { first_name.unwrap_or("model") } else { &model.name };
    let definition = product::definition(&mut out, name);
    let context = product::context(&mut out, &unit, model.uncertainty);
    let mut items = Items::default();
    let is_single = parts.len() == 1;
    for part in &parts {
        write_part(&mut out, part, is_single, name, &mut items)?;
    }
    product::representation(&mut out, definition, context, name, &items);
    Ok(out.file(name))
}

/// What the representation of the product holds.
#[derive(Debug, Default)]
struct Items {
    solids: Vec<Reference>,
    surfaces: Vec<Reference>,
    wires: Vec<Reference>,
}

fn write_part(
    out: &mut Instances,
    part: &PartDescription,
    is_single: bool,
    product: &str,
    items: &mut Items,
) -> Result<(), Error> {
    let mut faces = Faces::new(part);
    let mut in_shell = vec![false; part.faces.len()];
    let (mut open, mut closed) = (Vec::new(), Vec::new());
    for (place, shell) in part.shells.iter().enumerate() {
        let mut members = Vec::with_capacity(shell.faces.len());
        for &index in &shell.faces {
            let Some(face) = part.faces.get(index) else {
                let why = format!("it names face {index}, of which there is none");
                return Err(unwritable(&format!("shell \"{}\"", shell.name), why));
            };
            in_shell[index] = true;
            members.push(faces.write(out, face)?);
        }
        if !members.is_empty() {
            let kind = if shell.closed { "CLOSED_SHELL" } else { "OPEN_SHELL" };
            let shell_item =
                out.add(&format!("{kind}({},{})", instances::string(&shell.name), list(&members)));
            if shell.closed { closed.push((place, shell_item)) } else { open.push(shell_item) }
        }
    }
    // Faces that the shells forget.
    let mut rest = Vec::new();
    for (face, _) in part.faces.iter().zip(&in_shell).filter(|(_, known)| !**known) {
        rest.push(faces.write(out, face)?);
    }
    if !rest.is_empty() {
        open.push(out.add(&format!("OPEN_SHELL('',{})", list(&rest))));
    }
    let name = if is_single || part.name.is_empty() { product } else { &part.name };
    match solids::of(part) {
        Some(solids) => {
            let written =
                |shell: usize| closed.iter().find(|(place, _)| *place == shell).map(|(_, item)| *item);
            for solid in solids {
                let Some(outer) = written(solid.outer) else { continue };
                let own = &part.shells[solid.outer].name;
                let name = instances::string(if own.is_empty() { name } else { own });
                let mut voids = Vec::with_capacity(solid.voids.len());
                for shell in solid.voids.into_iter().filter_map(written) {
                    voids.push(out.add(&format!("ORIENTED_CLOSED_SHELL('',*,{shell},.T.)")));
                }
                items.solids.push(out.add(&if voids.is_empty() {
                    format!("MANIFOLD_SOLID_BREP({name},{outer})")
                } else {
                    format!("BREP_WITH_VOIDS({name},{outer},{})", list(&voids))
                }));
            }
        }
        // Where it is not known what they bound, they are surfaces.
        None => open.extend(closed.iter().map(|(_, shell)| *shell)),
    }
    if !open.is_empty() {
        let model = format!("SHELL_BASED_SURFACE_MODEL({},{})", instances::string(name), list(&open));
        items.surfaces.push(out.add(&model));
    }
    // Readers take the name of a curve from its set.
    for same_name in part.curves.chunk_by(|a, b| a.name == b.name) {
        let mut wires = Vec::with_capacity(same_name.len());
        for free in same_name {
            let what = format!("curve \"{}\" (entity {})", free.name, free.source);
            let written = curves::bounded(out, &free.name, &free.curve, free.range);
            wires.push(written.map_err(|error| unwritable(&what, error.to_string()))?);
        }
        let set_name = same_name.first().map_or("", |free| &free.name);
        let set_name = instances::string(if set_name.is_empty() { name } else { set_name });
        items.wires.push(out.add(&format!("GEOMETRIC_CURVE_SET({set_name},{})", list(&wires))));
    }
    Ok(())
}
