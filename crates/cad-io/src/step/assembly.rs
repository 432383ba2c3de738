//! Products of a STEP file, and where they stand.

use super::reader::{PartBuilder, Reader};
use brep_core::description::{InstanceDescription, PartDescription, Placement};
use nalgebra::{Matrix3, Vector3};
use std::collections::{HashMap, HashSet};
use step_io::model::{CharacterizedDefinitionRef, EntityKey, RepresentedDefinitionRef};
use step_io::scene::{MappedInstance, ProductDef, Transform};

/// Depth of assemblies.
const MAX_DEPTH: usize = 64;

/// Instances of parts in a file; assemblies of assemblies multiply.
const MAX_INSTANCES: usize = 100_000;

/// The parts and instances of a file.
#[derive(Default)]
pub(super) struct Assembly {
    pub(super) parts: Vec<PartDescription>,
    pub(super) instances: Vec<InstanceDescription>,
    /// Part of each definition or mapped item that has been built; `None` when it holds no geometry.
    built: HashMap<EntityKey, Option<usize>>,
    /// Solids, surface models and sets that belong to a part.
    reached: HashSet<EntityKey>,
    /// Mapped items of each product definition.
    mapped: HashMap<EntityKey, Vec<EntityKey>>,
}

impl Assembly {
    /// Walks the products from the roots of the assembly.
    pub(super) fn of(reader: &Reader<'_>) -> Result<Self, String> {
        let mut assembly = Self::default();
        assembly.collect_mapped(reader);
        for root in reader.scene.root_definitions() {
            assembly.place_definition(reader, &root, Placement::IDENTITY, &mut Vec::new())?;
        }
        assembly.add_orphans(reader)?;
        Ok(assembly)
    }

    fn instance(&mut self, part: usize, name: &str, placement: Placement) -> Result<(), String> {
        if self.instances.len() >= MAX_INSTANCES {
            return Err(format!("the assembly has more than {MAX_INSTANCES} instances"));
        }
        self.instances.push(InstanceDescription { part, name: name.to_owned(), placement });
        Ok(())
    }

    fn finish(&mut self, builder: PartBuilder, name: &str, source: u64) -> Option<usize> {
        let part = builder.part;
        if part.faces.is_empty() && part.curves.is_empty() {
            return None;
        }
        self.parts.push(PartDescription { name: name.to_owned(), source, ..part });
        Some(self.parts.len() - 1)
    }

    fn place_definition(
        &mut self,
        reader: &Reader<'_>,
        definition: &ProductDef<'_>,
        placement: Placement,
        path: &mut Vec<EntityKey>,
    ) -> Result<(), String> {
        let key = definition.key();
        if path.contains(&key) || path.len() >= MAX_DEPTH {
            reader.leave_out(key, "PRODUCT_DEFINITION", "the assembly contains itself".to_owned());
            return Ok(());
        }
        let product = definition.product().map_or("", |p| p.name());
        let part = match self.built.get(&key) {
            Some(part) => *part,
            None => {
                let mut builder = PartBuilder::default();
                // Handles of the scene borrow it for as long as the reader does.
                let definition = reader.scene.all_product_definitions().find(|d| d.key() == key);
                if let Some(definition) = definition {
                    for solid in definition.solids() {
                        self.reached.insert(solid.key());
                        reader.add_solid(&mut builder, &solid);
                    }
                    for model in definition.surface_models() {
                        self.reached.insert(model.key());
                        reader.add_surface_model(&mut builder, &model);
                    }
                    for set in definition.geometric_sets() {
                        self.reached.insert(set.key());
                        reader.add_set(&mut builder, &set);
                    }
                }
                let part = self.finish(builder, product, reader.number(key));
                self.built.insert(key, part);
                part
            }
        };
        if let Some(part) = part {
            self.instance(part, product, placement)?;
        }
        path.push(key);
        for item in self.mapped.get(&key).cloned().unwrap_or_default() {
            if let Some(item) = reader.scene.all_mapped_instances().find(|m| m.key() == item) {
                self.place_mapped(reader, &item, placement, path)?;
            }
        }
        for occurrence in definition.occurrences() {
            let Some(child) = occurrence.definition() else {
                let why = "the component that it places cannot be resolved".to_owned();
                reader.leave_out(occurrence.key(), "NEXT_ASSEMBLY_USAGE_OCCURRENCE", why);
                continue;
            };
            match occurrence.transform().and_then(|t| similarity(&t)) {
                Some(inner) => self.place_definition(reader, &child, placement.after(&inner), path)?,
                None => {
                    let why = "it has no usable placement".to_owned();
                    reader.leave_out(occurrence.key(), "NEXT_ASSEMBLY_USAGE_OCCURRENCE", why);
                    self.mark_reached(&child, 0);
                }
            }
        }
        path.pop();
        Ok(())
    }

    /// What an unplaced component holds is not placed elsewhere either.
    fn mark_reached(&mut self, definition: &ProductDef<'_>, depth: usize) {
        self.reached.extend(definition.solids().map(|s| s.key()));
        self.reached.extend(definition.surface_models().map(|s| s.key()));
        self.reached.extend(definition.geometric_sets().map(|s| s.key()));
        if depth < MAX_DEPTH {
            definition.children().for_each(|child| self.mark_reached(&child, depth + 1));
        }
    }

    fn place_mapped(
        &mut self,
        reader: &Reader<'_>,
        item: &MappedInstance<'_>,
        placement: Placement,
        path: &mut Vec<EntityKey>,
    ) -> Result<(), String> {
        let key = item.key();
        let Some(inner) = item.transform().and_then(|t| similarity(&t)) else {
            if item.solids().next().is_some() || item.surface_models().next().is_some() {
                reader.leave_out(key, "MAPPED_ITEM", "it has no usable placement".to_owned());
            }
            return Ok(());
        };
        if path.contains(&key) || path.len() >= MAX_DEPTH {
            reader.leave_out(key, "MAPPED_ITEM", "it contains itself".to_owned());
            return Ok(());
        }
        let placement = placement.after(&inner);
        // Items that map the same representation share one part: its first solid or surface model stands for it.
        let first = item.solids().map(|s| s.key()).chain(item.surface_models().map(|s| s.key())).next();
        let owner = first.unwrap_or(key);
        let part = match self.built.get(&owner) {
            Some(part) => *part,
            None => {
                let mut builder = PartBuilder::default();
                if let Some(item) = reader.scene.all_mapped_instances().find(|m| m.key() == key) {
                    for solid in item.solids() {
                        self.reached.insert(solid.key());
                        reader.add_solid(&mut builder, &solid);
                    }
                    for model in item.surface_models() {
                        self.reached.insert(model.key());
                        reader.add_surface_model(&mut builder, &model);
                    }
                    for set in item.geometric_sets() {
                        self.reached.insert(set.key());
                        reader.add_set(&mut builder, &set);
                    }
                }
                let part = self.finish(builder, item.name(), reader.number(owner));
                self.built.insert(owner, part);
                part
            }
        };
        if let Some(part) = part {
            self.instance(part, item.name(), placement)?;
        }
        path.push(key);
        for child in item.mapped_children() {
            self.place_mapped(reader, &child, placement, path)?;
        }
        path.pop();
        Ok(())
    }

    /// Finds the product definitions in whose representations mapped items stand.
    fn collect_mapped(&mut self, reader: &Reader<'_>) {
        let items: Vec<EntityKey> = reader.scene.all_mapped_instances().map(|m| m.key()).collect();
        if items.is_empty() {
            return;
        }
        let graph = reader.model.ref_graph();
        for item in items {
            let (mut open, mut seen) = (vec![item], HashSet::from([item]));
            let mut owners = Vec::new();
            while let Some(key) = open.pop() {
                for &user in graph.referrers(key) {
                    let next = match user {
                        EntityKey::ShapeRepresentation(_)
                        | EntityKey::AdvancedBrepShapeRepresentation(_)
                        | EntityKey::ManifoldSurfaceShapeRepresentation(_)
                        | EntityKey::GeometricallyBoundedSurfaceShapeRepresentation(_)
                        | EntityKey::GeometricallyBoundedWireframeShapeRepresentation(_) => Some(user),
                        EntityKey::ShapeRepresentationRelationship(id) => {
                            let relation = &reader.model[id];
                            let ends = [relation.rep_1.entity_key(), relation.rep_2.entity_key()];
                            ends.into_iter().find(|end| *end != key)
                        }
                        EntityKey::ShapeDefinitionRepresentation(id) => {
                            owners.extend(defined_by(reader, &reader.model[id].definition));
                            None
                        }
                        _ => None,
                    };
                    open.extend(next.filter(|key| seen.insert(*key)));
                }
            }
            for owner in owners {
                let list = self.mapped.entry(owner).or_default();
                if !list.contains(&item) {
                    list.push(item);
                }
            }
        }
    }

    /// Geometry that no product leads to makes a part of its own.
    fn add_orphans(&mut self, reader: &Reader<'_>) -> Result<(), String> {
        let mut builder = PartBuilder::default();
        for solid in reader.scene.all_solids().filter(|s| !self.reached.contains(&s.key())) {
            reader.add_solid(&mut builder, &solid);
        }
        for model in reader.scene.all_surface_models().filter(|s| !self.reached.contains(&s.key())) {
            reader.add_surface_model(&mut builder, &model);
        }
        for set in reader.scene.all_geometric_sets().filter(|s| !self.reached.contains(&s.key())) {
            reader.add_set(&mut builder, &set);
        }
        match self.finish(builder, "", 0) {
            Some(part) => self.instance(part, "", Placement::IDENTITY),
            None => Ok(()),
        }
    }
}

/// The product definition whose shape is meant.
fn defined_by(reader: &Reader<'_>, definition: &RepresentedDefinitionRef) -> Option<EntityKey> {
    let RepresentedDefinitionRef::ProductDefinitionShape(shape) = definition else { return None };
    match reader.model[*shape].definition {
        CharacterizedDefinitionRef::ProductDefinition(id) => Some(EntityKey::ProductDefinition(id)),
        CharacterizedDefinitionRef::ProductDefinitionWithAssociatedDocuments(id) => {
            Some(EntityKey::ProductDefinitionWithAssociatedDocuments(id))
        }
        _ => None,
    }
}

/// The motion from one frame to the other; `None` for frames that are none.
fn similarity(transform: &Transform) -> Option<Placement> {
    let m = transform.matrix()?;
    if !m.iter().flatten().all(|v| v.is_finite()) {
        return None;
    }
    Some(Placement {
        rotation: Matrix3::from_fn(|i, j| m[i][j]),
        translation: Vector3::from_fn(|i, _| m[i][3]),
        scale: 1.0,
    })
}
