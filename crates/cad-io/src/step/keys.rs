//! Names of the entity types of the STEP library.

use step_io::EntityKey as Key;

/// STEP keyword and place among the entities of its type, for the types that descriptions name.
pub(super) fn place(key: Key) -> Option<(&'static str, u32)> {
    Some(match key {
        Key::AdvancedFace(i) => ("ADVANCED_FACE", i.0),
        Key::FaceSurface(i) => ("FACE_SURFACE", i.0),
        Key::EdgeCurve(i) => ("EDGE_CURVE", i.0),
        Key::VertexPoint(i) => ("VERTEX_POINT", i.0),
        Key::FaceBound(i) => ("FACE_BOUND", i.0),
        Key::FaceOuterBound(i) => ("FACE_OUTER_BOUND", i.0),
        Key::ClosedShell(i) => ("CLOSED_SHELL", i.0),
        Key::OpenShell(i) => ("OPEN_SHELL", i.0),
        Key::ManifoldSolidBrep(i) => ("MANIFOLD_SOLID_BREP", i.0),
        Key::BrepWithVoids(i) => ("BREP_WITH_VOIDS", i.0),
        Key::ShellBasedSurfaceModel(i) => ("SHELL_BASED_SURFACE_MODEL", i.0),
        Key::GeometricSet(i) => ("GEOMETRIC_SET", i.0),
        Key::GeometricCurveSet(i) => ("GEOMETRIC_CURVE_SET", i.0),
        Key::ProductDefinition(i) => ("PRODUCT_DEFINITION", i.0),
        Key::ProductDefinitionWithAssociatedDocuments(i) => {
            ("PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS", i.0)
        }
        Key::NextAssemblyUsageOccurrence(i) => ("NEXT_ASSEMBLY_USAGE_OCCURRENCE", i.0),
        Key::MappedItem(i) => ("MAPPED_ITEM", i.0),
        Key::ComplexEntity(i) => ("", i.0),
        Key::Plane(i) => ("PLANE", i.0),
        Key::CylindricalSurface(i) => ("CYLINDRICAL_SURFACE", i.0),
        Key::ConicalSurface(i) => ("CONICAL_SURFACE", i.0),
        Key::SphericalSurface(i) => ("SPHERICAL_SURFACE", i.0),
        Key::ToroidalSurface(i) => ("TOROIDAL_SURFACE", i.0),
        Key::DegenerateToroidalSurface(i) => ("DEGENERATE_TOROIDAL_SURFACE", i.0),
        Key::BSplineSurfaceWithKnots(i) => ("B_SPLINE_SURFACE_WITH_KNOTS", i.0),
        Key::SurfaceOfLinearExtrusion(i) => ("SURFACE_OF_LINEAR_EXTRUSION", i.0),
        Key::SurfaceOfRevolution(i) => ("SURFACE_OF_REVOLUTION", i.0),
        Key::OffsetSurface(i) => ("OFFSET_SURFACE", i.0),
        Key::Line(i) => ("LINE", i.0),
        Key::Circle(i) => ("CIRCLE", i.0),
        Key::Ellipse(i) => ("ELLIPSE", i.0),
        Key::Parabola(i) => ("PARABOLA", i.0),
        Key::Hyperbola(i) => ("HYPERBOLA", i.0),
        Key::BSplineCurveWithKnots(i) => ("B_SPLINE_CURVE_WITH_KNOTS", i.0),
        Key::TrimmedCurve(i) => ("TRIMMED_CURVE", i.0),
        Key::CompositeCurve(i) => ("COMPOSITE_CURVE", i.0),
        Key::Polyline(i) => ("POLYLINE", i.0),
        Key::SurfaceCurve(i) => ("SURFACE_CURVE", i.0),
        Key::SeamCurve(i) => ("SEAM_CURVE", i.0),
        Key::IntersectionCurve(i) => ("INTERSECTION_CURVE", i.0),
        _ => return None,
    })
}
