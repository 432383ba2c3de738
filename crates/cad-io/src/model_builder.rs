//! Descriptions of shapes that come from fits and from files without loops.

use crate::{Error, natural, trimmed};
use brep_core::description::{
    Carrier, EdgeCurve, FaceDescription, FreeCurve, InstanceDescription, LengthUnit, LoopDescription,
    ModelDescription, PartDescription, Placement, ShellDescription,
};
use nurbs_core::{AnalyticSurface, BsplineCurve, BsplineSurface, ParametricCurve, TrimLoops};
use std::sync::Arc;

/// Surfaces and curves as the faces and free curves of one part.
///
/// ```
/// use cad_io::ModelBuilder;
/// use cad_io::description::LengthUnit;
/// use nurbs_core::{AnalyticSurface, Frame, Sphere};
///
/// let sphere: AnalyticSurface = Sphere::new(Frame::WORLD, 2.0)?.into();
/// let mut model = ModelBuilder::new("ball", Some(LengthUnit::millimetre()));
/// model.analytic("skin", &sphere)?;
/// let step = String::from_utf8(cad_io::to_step(&model.finish())?)?;
/// assert!(step.contains("SPHERICAL_SURFACE") && step.contains("ADVANCED_FACE('skin'"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ModelBuilder {
    name: String,
    unit: Option<LengthUnit>,
    part: PartDescription,
}

impl ModelBuilder {
    /// An empty model with a name and the unit of its coordinates.
    #[must_use]
    pub fn new(name: impl Into<String>, unit: Option<LengthUnit>) -> Self {
        Self { name: name.into(), unit, part: PartDescription::default() }
    }

    /// Adds a B-spline surface as a face over its whole domain.
    pub fn surface(&mut self, name: impl Into<String>, surface: BsplineSurface) {
        let carrier = Carrier::Nurbs(Arc::new(surface));
        self.face(name.into(), carrier, Vec::new());
    }

    /// Adds the piece of a B-spline surface that loops in its parameters bound, as a face with one edge for each loop.
    ///
    /// The edges are polygons with vertices on the surface, so many that they leave it by no more than 1e-5 of its size.
    ///
    /// # Errors
    /// [`Error::Unwritable`] for loops that cannot be made edges.
    pub fn trimmed_surface(
        &mut self,
        name: impl Into<String>,
        surface: BsplineSurface,
        trim: &TrimLoops,
    ) -> Result<(), Error> {
        let name = name.into();
        let loops = trimmed::loops(&surface, trim, &mut self.part);
        let loops = loops.map_err(|error| Error::Unwritable {
            what: format!("face \"{name}\""),
            why: error.to_string(),
        })?;
        self.face(name, Carrier::Nurbs(Arc::new(surface)), loops);
        Ok(())
    }

    /// Adds a piece of a plane, cylinder, cone, sphere or torus as a face with the boundary that its domain gives.
    ///
    /// # Errors
    /// [`Error::Unwritable`] for coordinates that are not finite.
    pub fn analytic(&mut self, name: impl Into<String>, surface: &AnalyticSurface) -> Result<(), Error> {
        let name = name.into();
        let failed = |why: String| Error::Unwritable { what: format!("face \"{name}\""), why };
        let carrier = natural::carrier(surface).ok_or_else(|| failed("its kind is not known".to_owned()))?;
        let boundary = natural::of_analytic(surface).map_err(|error| failed(error.to_string()))?;
        let loops = boundary.add_to(&mut self.part, 0).into_iter().collect();
        self.face(name, carrier, loops);
        Ok(())
    }

    fn face(&mut self, name: String, carrier: Carrier, loops: Vec<LoopDescription>) {
        self.part.faces.push(FaceDescription { name, source: 0, carrier, same_sense: true, loops });
    }

    /// Adds a curve that bounds nothing.
    pub fn curve(&mut self, name: impl Into<String>, curve: BsplineCurve<3>) {
        let domain = curve.domain();
        self.part.curves.push(FreeCurve {
            name: name.into(),
            source: 0,
            range: [domain.start(), domain.end()],
            curve: EdgeCurve::Nurbs(Arc::new(curve)),
        });
    }

    /// The model: one open shell of all faces.
    #[must_use]
    pub fn finish(mut self) -> ModelDescription {
        if !self.part.faces.is_empty() {
            let faces = (0..self.part.faces.len()).collect();
            self.part.shells.push(ShellDescription { faces, ..ShellDescription::default() });
        }
        self.part.name.clone_from(&self.name);
        let instance = InstanceDescription { part: 0, name: String::new(), placement: Placement::IDENTITY };
        ModelDescription {
            name: self.name,
            unit: self.unit,
            parts: vec![self.part],
            instances: vec![instance],
            ..ModelDescription::default()
        }
    }
}
