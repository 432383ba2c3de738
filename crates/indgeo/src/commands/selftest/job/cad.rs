//! CAD models: files that come back, and distances from trimmed faces with closed forms.

use super::shapes::{in_cube, wavy};
use super::{Checks, Failure, largest};
use industrial_geometry::brep::Model;
use industrial_geometry::cad::description::{Carrier, LengthUnit, ModelDescription};
use industrial_geometry::cad::{ModelBuilder, read_iges, to_iges};
#[cfg(feature = "step")]
use industrial_geometry::cad::{read_step, to_step};
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::nurbs::{BsplineSurface, Cylinder, Frame, Interval};

/// Radius and ends of a piece of a cylinder.
const RADIUS: f64 = 0.7;
const ENDS: [f64; 2] = [-0.3, 0.4];

pub(super) fn add(checks: &mut Checks) {
    const SAME: &str = "number of coordinates whose bits changed: 0";
    const PIECE: &str = "hypot(distance from the axis - radius, height beyond the ends)";
    checks.add("surface as IGES", SAME, 0.0, || changed(back_iges));
    checks.add("distance from a trimmed cylinder of an IGES file", PIECE, 1e-9, || from_cylinder(back_iges));
    #[cfg(feature = "step")]
    checks.add("surface as STEP", SAME, 0.0, || changed(back_step));
    #[cfg(feature = "step")]
    checks.add("distance from a trimmed cylinder of a STEP file", PIECE, 1e-12, || from_cylinder(back_step));
}

type Back = fn(&ModelDescription) -> Result<ModelDescription, Failure>;

fn back_iges(model: &ModelDescription) -> Result<ModelDescription, Failure> {
    Ok(read_iges(&to_iges(model)?)?)
}

#[cfg(feature = "step")]
fn back_step(model: &ModelDescription) -> Result<ModelDescription, Failure> {
    Ok(read_step(&to_step(model)?)?)
}

fn builder() -> ModelBuilder {
    ModelBuilder::new("selftest", Some(LengthUnit::millimetre()))
}

fn changed(back: Back) -> Result<f64, Failure> {
    let surface = wavy()?.scaled(1.0 / 3.0, &Vector3::new(0.1, 0.2, 0.3))?;
    let mut model = builder();
    model.surface("wavy", surface.clone());
    let read = back(&model.finish())?;
    let face = read.parts.first().and_then(|part| part.faces.first()).ok_or("the face is missing")?;
    let Carrier::Nurbs(found) = &face.carrier else { return Err("the surface is no B-spline".into()) };
    let bits = |surface: &BsplineSurface| -> Vec<u64> {
        surface.control_points().iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits).collect()
    };
    let (written, read) = (bits(&surface), bits(found));
    if written.len() != read.len() {
        return Err("the number of control points changed".into());
    }
    Ok(written.iter().zip(&read).filter(|(a, b)| a != b).count() as f64)
}

fn from_cylinder(back: Back) -> Result<f64, Failure> {
    let piece = Cylinder::new(Frame::WORLD, RADIUS, Interval::new(ENDS[0], ENDS[1])?)?;
    let mut model = builder();
    model.analytic("piece", &piece.into())?;
    let model = Model::new(&back(&model.finish())?)?;
    let off = (0..300).map(|i| {
        let x = in_cube(i) * 1.5;
        let beyond = (ENDS[0] - x.z).max(x.z - ENDS[1]).max(0.0);
        let known = (x.x.hypot(x.y) - RADIUS).hypot(beyond);
        model.nearest(&x).map_or(f64::NAN, |foot| (foot.distance - known).abs().max(foot.gap()))
    });
    Ok(largest(off))
}
