//! NURBS curves and surfaces as files hold them.

use nurbs_core::{BsplineCurve, BsplineSurface, TrimLoops};

/// A curve in the plane or in space, or a surface.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A curve in the plane.
    Curve2(BsplineCurve<2>),
    /// A curve in space.
    Curve3(BsplineCurve<3>),
    /// A surface.
    Surface(BsplineSurface),
}

impl From<BsplineCurve<2>> for Shape {
    fn from(curve: BsplineCurve<2>) -> Self {
        Self::Curve2(curve)
    }
}

impl From<BsplineCurve<3>> for Shape {
    fn from(curve: BsplineCurve<3>) -> Self {
        Self::Curve3(curve)
    }
}

impl From<BsplineSurface> for Shape {
    fn from(surface: BsplineSurface) -> Self {
        Self::Surface(surface)
    }
}

/// Curves and surfaces in their order, each with a name or without; surfaces whole, or with loops that bound a piece of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Model {
    shapes: Vec<Shape>,
    names: Vec<Option<String>>,
    trims: Vec<Option<TrimLoops>>,
}

impl Model {
    /// A model of whole shapes without names.
    #[must_use]
    pub fn new(shapes: Vec<Shape>) -> Self {
        let (names, trims) = (vec![None; shapes.len()], vec![None; shapes.len()]);
        Self { shapes, names, trims }
    }

    /// Adds a shape.
    pub fn push(&mut self, shape: impl Into<Shape>, name: Option<String>) {
        self.shapes.push(shape.into());
        self.names.push(name);
        self.trims.push(None);
    }

    /// Adds a piece of a surface.
    pub fn push_trimmed(&mut self, surface: BsplineSurface, trim: Option<TrimLoops>, name: Option<String>) {
        self.push(surface, name);
        if let Some(last) = self.trims.last_mut() {
            *last = trim;
        }
    }

    /// The shapes.
    #[must_use]
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The name of the shape at `index`, if it has one.
    #[must_use]
    pub fn name(&self, index: usize) -> Option<&str> {
        self.names.get(index)?.as_deref()
    }

    /// The loops that bound the surface at `index`; `None` where it is whole.
    #[must_use]
    pub fn trim(&self, index: usize) -> Option<&TrimLoops> {
        self.trims.get(index)?.as_ref()
    }

    /// Number of surfaces of which loops bound a piece.
    #[must_use]
    pub fn n_trimmed(&self) -> usize {
        self.trims.iter().flatten().count()
    }

    /// The same shapes under one name.
    #[must_use]
    pub fn renamed(mut self, name: &str) -> Self {
        self.names.fill(Some(name.to_owned()));
        self
    }

    /// The shapes without their names and loops.
    #[must_use]
    pub fn into_shapes(self) -> Vec<Shape> {
        self.shapes
    }
}

impl<S: Into<Shape>> From<S> for Model {
    fn from(shape: S) -> Self {
        Self::new(vec![shape.into()])
    }
}
