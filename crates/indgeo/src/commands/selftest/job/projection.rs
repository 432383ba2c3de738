//! Footpoints, distances and their quadratic models.

use super::shapes::{in_cube, scattered, tilted, wavy};
use super::{Checks, Failure, largest};
use industrial_geometry::distance_field::{DistanceField, ErrorTerm, SurfaceField};
use industrial_geometry::footpoint::{CurveProjector, SurfaceProjector};
use industrial_geometry::mesh::nalgebra::{Point3, Vector2, Vector3};
use industrial_geometry::mesh::{MeshProjector, TriangleMesh};
use industrial_geometry::nurbs::{Circle, Frame, ParametricCurve, ParametricSurface, Sphere, Torus};

pub(super) fn add(checks: &mut Checks) {
    checks.add("circle as rational curve", "|c(t) − m| = r for every t", 4e-15, circle);
    checks.add("sphere as NURBS surface", "d(x) = |x − m| − R", 1e-13, sphere);
    checks.add("torus as NURBS surface", "d(x) = |(|p| − R, z)| − r, p across the axis", 1e-13, torus);
    checks.add("feet on a free-form surface", "x = s(u,v) + r n has the foot s(u,v)", 1e-12, free_form_feet);
    checks.add("inversion", "x = s(u,v) has the parameters (u,v)", 1e-12, inversion);
    checks.add("circle in the plane", "d(x) = ||x − m| − r|", 1e-14, plane_circle);
    checks.add("cube as mesh", "signed distances of faces, edges, corners", 1e-15, cube);
    checks.add("curvatures of a sphere", "κ₁ = κ₂ = −1/R towards the outside", 1e-12, curvatures);
    checks.add(
        "quadratic model of d²",
        "its error is of order 3: 8 times smaller at half the distance",
        0.05,
        taylor_order,
    );
    checks.add(
        "tangent plane at d = 0",
        "the model is ⟨x − f, n⟩² on the surface itself",
        1e-9,
        on_the_surface,
    );
}

fn circle() -> Result<f64, Failure> {
    let (centre, radius) = (Vector2::new(0.3, -0.2), 1.7);
    let curve = Circle::<2>::new(centre, radius)?.to_nurbs()?;
    let domain = curve.domain();
    let at = |i: usize| curve.point(domain.start() + domain.length() * scattered(i, 0));
    Ok(largest((0..1000).map(|i| ((at(i) - centre).norm() - radius).abs())))
}

fn sphere() -> Result<f64, Failure> {
    let frame = tilted()?;
    let projector = SurfaceProjector::new(&Sphere::new(frame, 2.0)?.to_nurbs()?);
    let error = |i: usize| {
        let x = frame.origin() + in_cube(i) * 3.0;
        (projector.project(&x).signed_distance - ((x - frame.origin()).norm() - 2.0)).abs()
    };
    Ok(largest((0..300).map(error)))
}

fn torus() -> Result<f64, Failure> {
    let frame = tilted()?;
    let projector = SurfaceProjector::new(&Torus::new(frame, 2.0, 0.7)?.to_nurbs()?);
    let error = |i: usize| {
        let local = in_cube(i).component_mul(&Vector3::new(3.0, 3.0, 1.0));
        let exact = (local.xy().norm() - 2.0).hypot(local.z) - 0.7;
        (projector.project(&frame.point(&local)).signed_distance - exact).abs()
    };
    Ok(largest((0..300).map(error)))
}

/// Points within the reach of the surface: both normals, up to 0.3 (its curvatures are below 1).
fn free_form_feet() -> Result<f64, Failure> {
    let surface = wavy()?;
    let projector = SurfaceProjector::new(&surface);
    let error = |i: usize| {
        let jet = surface.jet(0.1 + 0.8 * scattered(i, 0), 0.1 + 0.8 * scattered(i, 1));
        let normal = jet.unit_normal().unwrap_or_default();
        let distance = 0.6 * (scattered(i, 2) - 0.5);
        let foot = projector.project(&(jet.point + normal * distance));
        (foot.point - jet.point).norm().max((foot.signed_distance - distance).abs())
    };
    Ok(largest((0..300).map(error)))
}

fn inversion() -> Result<f64, Failure> {
    let surface = wavy()?;
    let projector = SurfaceProjector::new(&surface);
    let mut most = 0.0f64;
    for i in 0..300 {
        let (u, v) = (scattered(i, 0), scattered(i, 1));
        let found = projector.invert(&surface.point(u, v), 1e-9)?.parameter;
        most = largest([most, (found[0] - u).abs(), (found[1] - v).abs()]);
    }
    Ok(most)
}

fn plane_circle() -> Result<f64, Failure> {
    let (centre, radius) = (Vector2::new(0.3, -0.2), 1.0);
    let projector = CurveProjector::new(&Circle::<2>::new(centre, radius)?.to_nurbs()?);
    let error = |i: usize| {
        let x = in_cube(i).xy() * 2.0;
        (projector.project(&x).distance - ((x - centre).norm() - radius).abs()).abs()
    };
    Ok(largest((0..300).map(error)))
}

/// The unit cube, its normals outwards.
fn cube() -> Result<f64, Failure> {
    let corner = |k: u8| Point3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2 & 1));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = MeshProjector::new(&TriangleMesh::new((0..8).map(corner).collect(), triangles)?)?;
    let mut most = 0.0f64;
    for (point, distance) in [
        ([0.5, 0.5, 0.875], -0.125),
        ([0.25, 0.5, 1.5], 0.5),
        ([4.0, 0.75, -4.0], 5.0),
        ([2.0, 3.0, 3.0], 3.0),
        ([0.5, 0.5, 0.5], -0.5),
        ([1.0, 1.0, 1.0], 0.0),
    ] {
        let found = mesh.project(&Point3::from(point))?;
        most = largest([most, (found.signed_distance.unwrap_or(f64::NAN) - distance).abs()]);
    }
    Ok(most)
}

fn curvatures() -> Result<f64, Failure> {
    let frame = tilted()?;
    let field = SurfaceField::new(&Sphere::new(frame, 2.0)?.to_nurbs()?)?;
    let error = |i: usize| {
        let x = frame.origin() + in_cube(i).normalize() * 3.0;
        let found = field.frame(&x, Default::default(), &Default::default()).curvatures;
        largest([(found[0] + 0.5).abs(), (found[1] + 0.5).abs()])
    };
    Ok(largest((0..100).map(error)))
}

fn taylor_order() -> Result<f64, Failure> {
    let field = SurfaceField::new(&Sphere::new(Frame::WORLD, 1.0)?.to_nurbs()?)?;
    let x = Vector3::new(0.9, 1.1, 0.7);
    let model = field.quadratic(&x, ErrorTerm::Taylor);
    let step = Vector3::new(0.48, -0.6, 0.64);
    let error = |h: f64| {
        let y = x + step * h;
        (model.value(&y) - (y.norm() - 1.0).powi(2)).abs()
    };
    Ok(((error(2e-3) / error(1e-3)).log2() - 3.0).abs())
}

fn on_the_surface() -> Result<f64, Failure> {
    let surface = wavy()?;
    let field = SurfaceField::new(&surface)?;
    let error = |i: usize| {
        let jet = surface.jet(0.1 + 0.8 * scattered(i, 0), 0.1 + 0.8 * scattered(i, 1));
        let normal = jet.unit_normal().unwrap_or_default();
        let offset = in_cube(i);
        let exact = offset.dot(&normal).powi(2);
        (field.quadratic(&jet.point, ErrorTerm::SquaredDistance).value(&(jet.point + offset)) - exact).abs()
    };
    Ok(largest((0..100).map(error)))
}
