//! Entities of a file that is written: their parameter data, and what the directory says of them.

use crate::write::number;
use nurbs_core::{BsplineCurve, BsplineSurface, KnotVector, ParametricCurve, ParametricSurface};

/// How an entity stands to others: the status number of its directory entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    /// A shape of the model.
    Free,
    /// Part of another entity.
    Dependent,
    /// Part of another entity, in the parameters of a surface.
    Parameters,
    /// A property of another entity.
    Property,
}

impl Status {
    /// Columns 65 to 72 of the directory.
    pub(super) const fn number(self) -> &'static str {
        match self {
            Self::Free => "00000000",
            Self::Dependent => "00010000",
            Self::Parameters => "00010500",
            Self::Property => "00010200",
        }
    }
}

/// One entity.
#[derive(Debug)]
pub(super) struct Entity {
    /// Entity type number.
    pub(super) kind: u32,
    /// Form number.
    pub(super) form: u32,
    /// How it stands to others.
    pub(super) status: Status,
    /// Values of its parameter data, the type number first.
    pub(super) values: Vec<Vec<u8>>,
}

/// All entities, each named by its directory number, the odd numbers in order.
#[derive(Debug, Default)]
pub(super) struct Entities {
    list: Vec<Entity>,
}

/// The directory number of an entity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Number(usize);

/// Values of one record.
struct Values(Vec<Vec<u8>>);

impl Values {
    fn new(kind: u32) -> Self {
        Self(vec![kind.to_string().into_bytes()])
    }

    fn integer(&mut self, value: usize) {
        self.0.push(value.to_string().into_bytes());
    }

    fn pointer(&mut self, number: Option<Number>) {
        self.integer(number.map_or(0, |number| number.0));
    }

    fn reals(&mut self, values: impl IntoIterator<Item = f64>) {
        self.0.extend(values.into_iter().map(|value| number::real(value, 'D').into_bytes()));
    }

    fn knots(&mut self, knots: &KnotVector) {
        self.reals(knots.as_slice().iter().copied());
    }

    /// No associativities, one property.
    fn property(&mut self, property: Option<Number>) {
        if property.is_some() {
            self.integer(0);
            self.integer(1);
            self.pointer(property);
        }
    }
}

/// A string with its count of bytes.
pub(super) fn text(text: &str) -> Vec<u8> {
    // A line break within a string would break the columns.
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if plain.is_empty() { Vec::new() } else { format!("{}H{plain}", plain.len()).into_bytes() }
}

impl Entities {
    /// All, in the order of their numbers.
    pub(super) fn list(&self) -> &[Entity] {
        &self.list
    }

    fn add(&mut self, kind: u32, form: u32, status: Status, values: Values) -> Number {
        self.list.push(Entity { kind, form, status, values: values.0 });
        Number(2 * self.list.len() - 1)
    }

    /// A name property (type 406, form 15).
    pub(super) fn name(&mut self, name: &str) -> Option<Number> {
        let name = text(name.trim());
        if name.is_empty() {
            return None;
        }
        let mut values = Values::new(406);
        values.integer(1);
        values.0.push(name);
        Some(self.add(406, 15, Status::Property, values))
    }

    /// A curve in space (type 126).
    pub(super) fn curve(
        &mut self,
        curve: &BsplineCurve<3>,
        status: Status,
        property: Option<Number>,
    ) -> Number {
        let points = curve.control_points().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let [start, end] = [curve.domain().start(), curve.domain().end()].map(|t| curve.point(t));
        self.spline(curve, points, [start == end, false], status, property)
    }

    /// A curve in the parameters of a surface (type 126), in the plane z = 0.
    pub(super) fn parameter_curve(&mut self, curve: &BsplineCurve<2>) -> Number {
        let points = curve.control_points().iter().flat_map(|p| [p.x, p.y, 0.0]).collect();
        self.spline(curve, points, [false, true], Status::Parameters, None)
    }

    fn spline<const D: usize>(
        &mut self,
        curve: &BsplineCurve<D>,
        points: Vec<f64>,
        [closed, planar]: [bool; 2],
        status: Status,
        property: Option<Number>,
    ) -> Number {
        let count = curve.control_points().len();
        let mut values = Values::new(126);
        for value in
            [count - 1, curve.degree(), planar.into(), closed.into(), curve.weights().is_none().into(), 0]
        {
            values.integer(value);
        }
        values.knots(curve.knots());
        values.reals((0..count).map(|i| curve.weight(i)));
        values.reals(points);
        let domain = curve.domain();
        values.reals([domain.start(), domain.end(), 0.0, 0.0, if planar { 1.0 } else { 0.0 }]);
        values.property(property);
        self.add(126, 0, status, values)
    }

    /// A surface (type 128).
    pub(super) fn surface(
        &mut self,
        surface: &BsplineSurface,
        status: Status,
        property: Option<Number>,
    ) -> Number {
        let (n_u, n_v) = (surface.n_u(), surface.n_v());
        let polynomial = surface.weights().is_none();
        let mut values = Values::new(128);
        let sizes = [n_u - 1, n_v - 1, surface.degree_u(), surface.degree_v()];
        for value in sizes.into_iter().chain([0, 0, polynomial.into(), 0, 0]) {
            values.integer(value);
        }
        values.knots(surface.knots_u());
        values.knots(surface.knots_v());
        // `u` runs fastest.
        let indices = || (0..n_v).flat_map(|j| (0..n_u).map(move |i| (i, j)));
        values.reals(indices().map(|(i, j)| surface.weight(i, j)));
        values.reals(indices().flat_map(|(i, j)| {
            let point = surface.control_point(i, j);
            [point.x, point.y, point.z]
        }));
        let [u, v] = surface.domain();
        values.reals([u.start(), u.end(), v.start(), v.end()]);
        values.property(property);
        self.add(128, 0, status, values)
    }

    /// A composite curve (type 102), or its only member.
    pub(super) fn composite(&mut self, members: Vec<Number>, status: Status) -> Number {
        if let [only] = members[..] {
            return only;
        }
        let mut values = Values::new(102);
        values.integer(members.len());
        for member in members {
            values.pointer(Some(member));
        }
        self.add(102, 0, status, values)
    }

    /// A curve on a surface (type 142); the curve in space is the one that counts.
    pub(super) fn boundary(&mut self, surface: Number, flat: Option<Number>, space: Number) -> Number {
        let mut values = Values::new(142);
        values.integer(0);
        values.pointer(Some(surface));
        values.pointer(flat);
        values.pointer(Some(space));
        values.integer(2);
        self.add(142, 0, Status::Dependent, values)
    }

    /// A trimmed surface (type 144).
    pub(super) fn trimmed(
        &mut self,
        surface: Number,
        outer: Number,
        inner: Vec<Number>,
        property: Option<Number>,
    ) {
        let mut values = Values::new(144);
        values.pointer(Some(surface));
        values.integer(1);
        values.integer(inner.len());
        values.pointer(Some(outer));
        for boundary in inner {
            values.pointer(Some(boundary));
        }
        values.property(property);
        self.add(144, 0, Status::Free, values);
    }
}
