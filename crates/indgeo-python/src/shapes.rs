//! Curves and surfaces: points, derivatives and curvatures at many parameters.

use industrial_geometry::io::{self, Content, ReadOptions, Shape};
use industrial_geometry::nurbs::nalgebra::SVector;
use industrial_geometry::nurbs::{BsplineCurve, BsplineSurface, ParametricCurve, ParametricSurface};
use numpy::ndarray::{Array1, Array2, Array3, Array4};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyArray4, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The highest order of derivatives.
const MOST: usize = 8;

/// The first shape of a model in text (NURBS JSON).
fn shape(text: &str) -> PyResult<Shape> {
    let refused = |what: String| PyValueError::new_err(what);
    let read = io::read_from(text.as_bytes(), "model", &ReadOptions::default());
    let Content::Nurbs(model) = read.map_err(|error| refused(error.to_string()))?.content else {
        return Err(refused("the text is not a model of curves and surfaces".to_owned()));
    };
    model.into_shapes().into_iter().next().ok_or_else(|| refused("the model has no shapes".to_owned()))
}

fn check_order(order: usize) -> PyResult<usize> {
    if order > MOST {
        return Err(PyValueError::new_err(format!("order is {order}, it must be 0 to {MOST}")));
    }
    Ok(order)
}

/// A curve in the plane or in space.
#[derive(Debug)]
enum Any {
    Plane(BsplineCurve<2>),
    Space(BsplineCurve<3>),
}

/// A B-spline curve, rational or not.
#[pyclass(frozen, module = "indgeo._indgeo")]
#[derive(Debug)]
pub(crate) struct Curve(Any);

#[pymethods]
impl Curve {
    /// The curve of a model in text.
    #[new]
    fn new(text: &str) -> PyResult<Self> {
        match shape(text)? {
            Shape::Curve2(curve) => Ok(Self(Any::Plane(curve))),
            Shape::Curve3(curve) => Ok(Self(Any::Space(curve))),
            Shape::Surface(_) => Err(PyValueError::new_err("this is a surface, not a curve")),
        }
    }

    /// The interval of parameters.
    fn domain(&self) -> (f64, f64) {
        let domain = match &self.0 {
            Any::Plane(curve) => curve.domain(),
            Any::Space(curve) => curve.domain(),
        };
        (domain.start(), domain.end())
    }

    /// Points and derivatives, (N, order + 1, D).
    fn derivatives<'py>(
        &self,
        python: Python<'py>,
        parameters: PyReadonlyArray1<'py, f64>,
        order: usize,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let order = check_order(order)?;
        let parameters: Vec<f64> = parameters.as_array().to_vec();
        let all = python.detach(|| match &self.0 {
            Any::Plane(curve) => curve_derivatives(curve, &parameters, order),
            Any::Space(curve) => curve_derivatives(curve, &parameters, order),
        });
        Ok(all.into_pyarray(python))
    }

    /// Curvatures (N), with a sign in the plane; NaN where the curve has no tangent.
    fn curvature<'py>(
        &self,
        python: Python<'py>,
        parameters: PyReadonlyArray1<'py, f64>,
    ) -> Bound<'py, PyArray1<f64>> {
        let parameters: Vec<f64> = parameters.as_array().to_vec();
        let all: Array1<f64> = python.detach(|| match &self.0 {
            Any::Plane(curve) => {
                parameters.iter().map(|&t| curve.jet(t).signed_curvature().unwrap_or(f64::NAN)).collect()
            }
            Any::Space(curve) => {
                parameters.iter().map(|&t| curve.jet(t).curvature().unwrap_or(f64::NAN)).collect()
            }
        });
        all.into_pyarray(python)
    }
}

fn curve_derivatives<const D: usize>(
    curve: &BsplineCurve<D>,
    parameters: &[f64],
    order: usize,
) -> Array3<f64> {
    let mut all = Array3::from_elem((parameters.len(), order + 1, D), f64::NAN);
    for (row, &t) in parameters.iter().enumerate().filter(|(_, t)| t.is_finite()) {
        let jet: Vec<SVector<f64, D>> =
            if order == 0 { vec![curve.point(t)] } else { curve.derivatives(t, order) };
        for (k, vector) in jet.iter().enumerate() {
            for axis in 0..D {
                all[[row, k, axis]] = vector[axis];
            }
        }
    }
    all
}

/// A B-spline surface, rational or not.
#[pyclass(frozen, module = "indgeo._indgeo")]
#[derive(Debug)]
pub(crate) struct Surface(BsplineSurface);

#[pymethods]
impl Surface {
    /// The surface of a model in text.
    #[new]
    fn new(text: &str) -> PyResult<Self> {
        match shape(text)? {
            Shape::Surface(surface) => Ok(Self(surface)),
            _ => Err(PyValueError::new_err("this is a curve, not a surface")),
        }
    }

    /// The intervals of the parameters.
    fn domain(&self) -> ((f64, f64), (f64, f64)) {
        let [u, v] = self.0.domain();
        ((u.start(), u.end()), (v.start(), v.end()))
    }

    /// Points and partial derivatives, (N, order + 1, order + 1, 3): `[i, k, l]` is ∂ᵏ⁺ˡs/∂uᵏ∂vˡ; NaN where k + l > order.
    fn derivatives<'py>(
        &self,
        python: Python<'py>,
        parameters: PyReadonlyArray2<'py, f64>,
        order: usize,
    ) -> PyResult<Bound<'py, PyArray4<f64>>> {
        let order = check_order(order)?;
        let parameters = pairs(&parameters)?;
        let all = python.detach(|| surface_derivatives(&self.0, &parameters, order));
        Ok(all.into_pyarray(python))
    }

    /// Points (N, 3).
    fn evaluate<'py>(
        &self,
        python: Python<'py>,
        parameters: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let parameters = pairs(&parameters)?;
        let all = python.detach(|| {
            let mut all = Array2::from_elem((parameters.len(), 3), f64::NAN);
            for (row, &[u, v]) in parameters.iter().enumerate().filter(|(_, uv)| finite(uv)) {
                let point = self.0.point(u, v);
                for axis in 0..3 {
                    all[[row, axis]] = point[axis];
                }
            }
            all
        });
        Ok(all.into_pyarray(python))
    }

    /// Unit normals (N, 3) and principal curvatures (N, 2); NaN where the surface is not regular.
    fn normals_and_curvatures<'py>(
        &self,
        python: Python<'py>,
        parameters: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let parameters = pairs(&parameters)?;
        let (normals, curvatures) = python.detach(|| {
            let mut normals = Array2::from_elem((parameters.len(), 3), f64::NAN);
            let mut curvatures = Array2::from_elem((parameters.len(), 2), f64::NAN);
            for (row, &[u, v]) in parameters.iter().enumerate().filter(|(_, uv)| finite(uv)) {
                let Some(frame) = self.0.jet(u, v).principal_frame() else { continue };
                for axis in 0..3 {
                    normals[[row, axis]] = frame.normal[axis];
                }
                for (which, curvature) in frame.curvatures.into_iter().enumerate() {
                    curvatures[[row, which]] = curvature;
                }
            }
            (normals, curvatures)
        });
        Ok((normals.into_pyarray(python), curvatures.into_pyarray(python)))
    }
}

fn finite(parameters: &[f64; 2]) -> bool {
    parameters.iter().all(|value| value.is_finite())
}

/// Parameters `(u, v)`, one pair a row.
fn pairs(parameters: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; 2]>> {
    let array = parameters.as_array();
    if array.ncols() != 2 {
        let what = format!("parameters have shape ({}, {}), it must be (N, 2)", array.nrows(), array.ncols());
        return Err(PyValueError::new_err(what));
    }
    Ok(array.rows().into_iter().map(|row| [row[0], row[1]]).collect())
}

fn surface_derivatives(surface: &BsplineSurface, parameters: &[[f64; 2]], order: usize) -> Array4<f64> {
    let mut all = Array4::from_elem((parameters.len(), order + 1, order + 1, 3), f64::NAN);
    for (row, &[u, v]) in parameters.iter().enumerate().filter(|(_, uv)| finite(uv)) {
        for (k, line) in surface.derivatives(u, v, order).iter().enumerate() {
            for (l, vector) in line.iter().enumerate().filter(|(l, _)| k + l <= order) {
                for axis in 0..3 {
                    all[[row, k, l, axis]] = vector[axis];
                }
            }
        }
    }
    all
}
