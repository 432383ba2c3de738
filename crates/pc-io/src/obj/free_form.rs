//! Free-form curves and surfaces of OBJ: `cstype`, `deg`, `curv`, `surf`, `parm`, `end`.

use nalgebra::{Point3, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, Direction, Interval, KnotVector, MAX_DEGREE};

use super::index_of;
use crate::model::{Model, Shape};
use crate::number;
use crate::source::{Source, decode_name, quoted, words};
use crate::{Error, Place};

const EXPORT: &str = "correct the line or export the file again";

/// The basis that `cstype` names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Basis {
    Bspline,
    Bezier,
    /// Cardinal splines, Taylor polynomials, a matrix: not read.
    Other,
}

/// A curve or surface as its lines give it.
#[derive(Debug)]
struct Element {
    at: usize,
    is_surface: bool,
    basis: Basis,
    rational: bool,
    degrees: [usize; 2],
    /// The part that counts, `u` and, of a surface, `v`.
    domain: [[f64; 2]; 2],
    points: Vec<u32>,
    /// The numbers of `parm u` and `parm v`.
    parameters: [Vec<f64>; 2],
    name: Option<String>,
}

/// What has been read so far.
#[derive(Debug, Default)]
pub(super) struct FreeForm {
    basis: Option<(Basis, bool)>,
    degrees: [usize; 2],
    elements: Vec<Element>,
    /// Whether the lines that follow belong to the last element.
    open: bool,
    name: Option<String>,
    /// Surfaces with `trim` or `hole`, and what is on curves of parameters.
    trimmed: usize,
    superseded: usize,
}

impl FreeForm {
    pub(super) const fn any(&self) -> bool {
        !self.elements.is_empty()
    }

    pub(super) const fn count(&self) -> usize {
        self.elements.len()
    }

    /// Takes a statement of free-form shapes, or the name of what follows; tells whether it was one.
    pub(super) fn statement(
        &mut self,
        source: Source<'_>,
        at: usize,
        keyword: &[u8],
        line: &[u8],
        vertices: usize,
    ) -> Result<bool, Error> {
        let mut rest = words(line).skip(1).take_while(|word| !word.starts_with(b"#"));
        match keyword {
            b"o" | b"g" => {
                let name = rest.map(|word| decode_name(word).into_owned()).collect::<Vec<_>>().join(" ");
                self.name = Some(name).filter(|name| !name.is_empty());
            }
            b"cstype" => {
                let mut word = rest.next().unwrap_or_default().to_ascii_lowercase();
                let rational = word == b"rat";
                if rational {
                    word = rest.next().unwrap_or_default().to_ascii_lowercase();
                }
                let basis = match word.as_slice() {
                    b"bspline" => Basis::Bspline,
                    b"bezier" => Basis::Bezier,
                    b"cardinal" | b"taylor" | b"bmatrix" => Basis::Other,
                    _ => return Err(bad(source, at, line, "\"cstype [rat] bspline, bezier, …\"")),
                };
                self.basis = Some((basis, rational));
            }
            b"deg" => {
                let mut degree = || {
                    let word = rest.next()?;
                    Some(number::parse_count(word).and_then(|degree| usize::try_from(degree).ok()))
                };
                let (first, second) = (degree(), degree());
                match (first, second) {
                    (Some(Some(u)), None) => self.degrees = [u, u],
                    (Some(Some(u)), Some(Some(v))) => self.degrees = [u, v],
                    _ => return Err(bad(source, at, line, "\"deg U [V]\"")),
                }
            }
            b"curv" | b"surf" => self.begin(source, at, line, keyword == b"surf", vertices)?,
            b"parm" => {
                let place = match rest.next() {
                    Some(b"u" | b"U") => 0,
                    Some(b"v" | b"V") => 1,
                    _ => return Err(bad(source, at, line, "\"parm u …\" or \"parm v …\"")),
                };
                let numbers: Option<Vec<f64>> = rest.map(number::parse).collect();
                let numbers = numbers.ok_or_else(|| bad(source, at, line, "a line of numbers"))?;
                if let Some(element) = self.elements.last_mut().filter(|_| self.open) {
                    element.parameters[place].extend(numbers);
                }
            }
            b"trim" | b"hole" => {
                if self.open && self.elements.last().is_some_and(|element| element.is_surface) {
                    self.trimmed += 1;
                }
            }
            b"curv2" | b"end" => self.open = false,
            b"bsp" | b"bzp" | b"cdc" | b"cdp" => self.superseded += 1,
            b"step" | b"bmat" | b"scrv" | b"sp" => {}
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn begin(
        &mut self,
        source: Source<'_>,
        at: usize,
        line: &[u8],
        is_surface: bool,
        vertices: usize,
    ) -> Result<(), Error> {
        let (basis, rational) = self
            .basis
            .ok_or_else(|| source.line_error(at, "no line \"cstype\" comes before this", EXPORT))?;
        let mut rest = words(line).skip(1).take_while(|word| !word.starts_with(b"#"));
        let mut domain = [[0.0; 2]; 2];
        for value in domain.iter_mut().take(if is_surface { 2 } else { 1 }).flatten() {
            *value = rest
                .next()
                .and_then(number::parse)
                .ok_or_else(|| bad(source, at, line, "the ends of the parameters and vertices"))?;
        }
        let mut points = Vec::new();
        for word in rest {
            let vertex = word.split(|&byte| byte == b'/').next().unwrap_or_default();
            let index = index_of(source, at, vertex, vertices, "vertex")?;
            points.push(index);
        }
        let name = self.name.clone();
        let (degrees, parameters) = (self.degrees, [Vec::new(), Vec::new()]);
        self.elements.push(Element {
            at,
            is_surface,
            basis,
            rational,
            degrees,
            domain,
            points,
            parameters,
            name,
        });
        self.open = true;
        Ok(())
    }

    /// The shapes; those of other bases are left out.
    pub(super) fn into_model(
        self,
        source: Source<'_>,
        positions: &[Point3<f64>],
        weights: &[f64],
        warnings: &mut Vec<String>,
    ) -> Result<Model, Error> {
        let mut model = Model::default();
        let mut others = self.superseded;
        for mut element in self.elements {
            if element.basis == Basis::Other {
                others += 1;
                continue;
            }
            let name = element.name.take();
            let place = Place::Line(source.line_at(element.at));
            let shape = element.build(positions, weights).map_err(|what| {
                Error::malformed(place, what, "correct the curve or surface or export the file again")
            })?;
            model.push(shape, name);
        }
        if others > 0 {
            warnings
                .push(format!("not read: {others} curves and surfaces that are neither bspline nor bezier"));
        }
        if self.trimmed > 0 {
            warnings.push(format!(
                "not read: {} trimming loops and holes; surfaces are taken as a whole",
                self.trimmed
            ));
        }
        Ok(model)
    }
}

fn bad(source: Source<'_>, at: usize, line: &[u8], wanted: &str) -> Error {
    source.line_error(at, format!("{} is not {wanted}", quoted(line.trim_ascii())), EXPORT)
}

impl Element {
    fn build(self, positions: &[Point3<f64>], weights: &[f64]) -> Result<Shape, String> {
        let failed = |error: nurbs_core::Error| error.to_string();
        let missing = |&index: &u32| {
            format!("vertex {} does not exist, there are {}", u64::from(index) + 1, positions.len())
        };
        let points: Vec<Vector3<f64>> = (self.points.iter())
            .map(|index| {
                positions.get(*index as usize).map(|point| point.coords).ok_or_else(|| missing(index))
            })
            .collect::<Result<_, _>>()?;
        let of = |index: &u32| weights.get(*index as usize).copied().unwrap_or(1.0);
        let weights: Vec<f64> = self.points.iter().map(of).collect();
        let weights =
            Some(weights).filter(|weights| self.rational && weights.iter().any(|&weight| weight != 1.0));
        let u = self.knots(0)?;
        let interval = |[from, to]: [f64; 2]| Interval::new(from, to).map_err(failed);
        if !self.is_surface {
            let curve = BsplineCurve::new(u, points, weights).map_err(failed)?;
            let whole = is_whole(curve.knots(), self.domain[0]);
            let curve =
                if whole { curve } else { curve.trimmed(interval(self.domain[0])?).map_err(failed)? };
            return Ok(Shape::Curve3(curve));
        }
        let v = self.knots(1)?;
        let (n, m) = (u.basis_count(), v.basis_count());
        if points.len() != n.saturating_mul(m) {
            return Err(format!(
                "{} control points do not fit {n} × {m} of the degrees and parm lines",
                points.len()
            ));
        }
        // The first direction runs fastest in the file, the second here.
        let order = || (0..n).flat_map(|i| (0..m).map(move |j| j * n + i));
        let points: Vec<Vector3<f64>> = order().map(|place| points[place]).collect();
        let weights = weights.map(|weights| order().map(|place| weights[place]).collect());
        let mut surface = BsplineSurface::new(u, v, points, weights).map_err(failed)?;
        for (direction, domain) in [(Direction::U, self.domain[0]), (Direction::V, self.domain[1])] {
            let knots = if direction == Direction::U { surface.knots_u() } else { surface.knots_v() };
            if !is_whole(knots, domain) {
                surface = surface.trimmed(direction, interval(domain)?).map_err(failed)?;
            }
        }
        Ok(Shape::Surface(surface))
    }

    /// The knots of a direction. Bézier pieces join at the numbers of `parm`.
    fn knots(&self, direction: usize) -> Result<KnotVector, String> {
        let name = ["u", "v"][direction];
        let (degree, given) = (self.degrees[direction], &self.parameters[direction]);
        if degree == 0 {
            return Err("no line \"deg\" with a degree of 1 or more comes before".to_owned());
        }
        if degree > MAX_DEGREE {
            return Err(format!("the degree is {degree}, above {MAX_DEGREE}"));
        }
        let knots = match self.basis {
            Basis::Bezier => {
                let [first, inner @ .., last] = given.as_slice() else {
                    return Err(format!("a line \"parm {name}\" with two numbers or more is missing"));
                };
                let mut knots = vec![*first; degree + 1];
                inner.iter().for_each(|&knot| knots.extend(std::iter::repeat_n(knot, degree)));
                knots.extend(std::iter::repeat_n(*last, degree + 1));
                knots
            }
            _ if given.is_empty() => return Err(format!("a line \"parm {name}\" with the knots is missing")),
            _ => given.clone(),
        };
        KnotVector::new(degree, knots).map_err(|error| format!("parm {name}: {error}"))
    }
}

/// Whether the ends are those of the knots, but for rounding.
fn is_whole(knots: &KnotVector, [from, to]: [f64; 2]) -> bool {
    let (start, end) = (knots.domain().start(), knots.domain().end());
    let small = 1e-9 * (end - start);
    (from - start).abs() <= small && (to - end).abs() <= small
}
