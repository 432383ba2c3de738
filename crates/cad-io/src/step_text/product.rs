//! The product around the geometry: its name, units, accuracy and representation.

use super::Items;
use super::instances::{Instances, Reference, list, real, string};
use brep_core::description::LengthUnit;
use nurbs_core::Frame;

/// Distance below which points are equal, in metres, where the model states none.
const UNCERTAINTY: f64 = 1e-9;

/// The product and its definition; returns the shape of it.
pub(super) fn definition(out: &mut Instances, name: &str) -> Reference {
    let name = string(name);
    let application = out.add("APPLICATION_CONTEXT('managed model based 3d engineering')");
    out.add(&format!(
        "APPLICATION_PROTOCOL_DEFINITION('international standard',\
         'ap242_managed_model_based_3d_engineering',2014,{application})"
    ));
    let context = out.add(&format!("PRODUCT_CONTEXT('',{application},'mechanical')"));
    let product = out.add(&format!("PRODUCT({name},{name},'',({context}))"));
    out.add(&format!("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({product}))"));
    let formation = out.add(&format!("PRODUCT_DEFINITION_FORMATION('','',{product})"));
    let stage = out.add(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')"));
    let definition = out.add(&format!("PRODUCT_DEFINITION('design','',{formation},{stage})"));
    out.add(&format!("PRODUCT_DEFINITION_SHAPE('','',{definition})"))
}

/// Units and accuracy.
pub(super) fn context(out: &mut Instances, unit: &LengthUnit, uncertainty: Option<f64>) -> Reference {
    let length = length_unit(out, unit);
    let angle = out.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    let solid_angle = out.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
    let uncertainty = uncertainty.filter(|value| *value > 0.0).unwrap_or(UNCERTAINTY / unit.metres);
    let uncertainty = out.add(&format!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),{length},'distance_accuracy_value','')",
        real(uncertainty)
    ));
    out.add(&format!(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({uncertainty}))\
         GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))REPRESENTATION_CONTEXT('',''))"
    ))
}

/// SI prefixes by their metres.
const PREFIXES: [(f64, &str); 6] =
    [(1e3, ".KILO."), (1.0, "$"), (1e-1, ".DECI."), (1e-2, ".CENTI."), (1e-3, ".MILLI."), (1e-6, ".MICRO.")];

/// An SI unit, or one by its length in metres.
fn length_unit(out: &mut Instances, unit: &LengthUnit) -> Reference {
    let si = |prefix: &str| format!("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))");
    let same = |metres: f64| (metres / unit.metres - 1.0).abs() < 1e-12;
    if let Some((_, prefix)) = PREFIXES.iter().find(|(metres, _)| same(*metres)) {
        return out.add(&si(prefix));
    }
    // In millimetres as is usual: 25.4 is exact.
    let (base, factor) = if same(0.0254) {
        (".MILLI.", 25.4)
    } else if same(0.3048) {
        (".MILLI.", 304.8)
    } else {
        ("$", unit.metres)
    };
    let dimensions = out.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)");
    let base = out.add(&si(base));
    let measure = out.add(&format!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),{base})", real(factor)));
    let name = if same(0.0254) { "INCH".to_owned() } else { unit.name.to_uppercase() };
    let name = string(&name);
    out.add(&format!("(CONVERSION_BASED_UNIT({name},{measure})LENGTH_UNIT()NAMED_UNIT({dimensions}))"))
}

/// The representation of the shape, by what it holds.
pub(super) fn representation(
    out: &mut Instances,
    shape: Reference,
    context: Reference,
    name: &str,
    items: &Items,
) {
    let place = out.placement(&Frame::WORLD);
    let kinds = [
        (&items.solids, "ADVANCED_BREP_SHAPE_REPRESENTATION"),
        (&items.surfaces, "MANIFOLD_SURFACE_SHAPE_REPRESENTATION"),
        (&items.wires, "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION"),
    ];
    let mut present = kinds.iter().filter(|(items, _)| !items.is_empty());
    let kind = match (present.next(), present.next()) {
        (Some((_, kind)), None) => kind,
        _ => "SHAPE_REPRESENTATION",
    };
    let all: Vec<Reference> = std::iter::once(&place)
        .chain(&items.solids)
        .chain(&items.surfaces)
        .chain(&items.wires)
        .copied()
        .collect();
    let representation = out.add(&format!("{kind}({},{},{context})", string(name), list(&all)));
    out.add(&format!("SHAPE_DEFINITION_REPRESENTATION({shape},{representation})"));
}
