//! Loop subdivision surfaces as active shapes.

use crate::Error;
use crate::shape::{ActiveShape, CellGram, CellTable};
use distance_field::{DistanceField, Hint, LoopField, PrincipalFrame, Search};
use mesh_core::{LoopSurface, TriangleMesh};
use nalgebra::{Point3, Vector3};

/// Nodes and weights of a quadrature on the triangle that is exact to the fourth degree (Dunavant), by two barycentric
/// coordinates; the weights sum to 1.
const NODES: [([f64; 2], f64); 6] = {
    const A: f64 = 0.445_948_490_915_965;
    const B: f64 = 0.091_576_213_509_771;
    const WA: f64 = 0.223_381_589_678_011;
    const WB: f64 = 0.109_951_743_655_322;
    [
        ([A, A], WA),
        ([A, 1.0 - 2.0 * A], WA),
        ([1.0 - 2.0 * A, A], WA),
        ([B, B], WB),
        ([B, 1.0 - 2.0 * B], WB),
        ([1.0 - 2.0 * B, B], WB),
    ]
};

/// The limit surface of Loop's scheme, whose control points are unknown (\[P05, sec. 4.2\], Fig. 5).
///
/// The parameter of a place is `[2 f + v, w]` with the barycentric coordinates `v` and `w` on control triangle `f`; control
/// points that act on no triangle stay where they are.
#[derive(Clone, Debug)]
pub struct ActiveLoop {
    surface: LoopSurface,
    coefficients: Vec<Vector3<f64>>,
    /// The control point that each coefficient is.
    vertices: Vec<u32>,
    cells: CellTable,
}

impl ActiveLoop {
    /// A control mesh to start from.
    ///
    /// # Errors
    /// [`Error::Field`] when it is not an oriented manifold or has no triangles.
    pub fn new(mesh: &TriangleMesh) -> Result<Self, Error> {
        let surface = LoopSurface::new(mesh)?;
        let acting = |triangle: usize| surface.acting(triangle).unwrap_or(&[]);
        let mut vertices: Vec<u32> =
            (0..surface.triangles().len()).flat_map(|triangle| acting(triangle).iter().copied()).collect();
        vertices.sort_unstable();
        vertices.dedup();
        if vertices.is_empty() {
            return Err(Error::Field { reason: "the control mesh has no triangles".to_owned() });
        }
        let mut place = vec![0; surface.positions().len()];
        vertices.iter().enumerate().for_each(|(k, &vertex)| place[vertex as usize] = k);
        let cells = CellTable::new((0..surface.triangles().len()).map(|triangle| {
            acting(triangle).iter().map(|&vertex| place[vertex as usize]).collect::<Vec<_>>()
        }));
        let coefficients = vertices.iter().map(|&v| surface.positions()[v as usize].coords).collect();
        Ok(Self { surface, coefficients, vertices, cells })
    }

    /// The limit surface.
    #[must_use]
    pub fn surface(&self) -> &LoopSurface {
        &self.surface
    }

    /// The control mesh.
    ///
    /// # Errors
    /// [`Error::Field`] never, but that a mesh is checked when it is made.
    pub fn mesh(&self) -> Result<TriangleMesh, Error> {
        Ok(TriangleMesh::new(self.surface.positions().to_vec(), self.surface.triangles().to_vec())?)
    }

    /// Triangle and barycentric coordinates of a parameter.
    fn place(&self, parameter: [f64; 2]) -> (usize, [f64; 2]) {
        let last = self.cells.len() - 1;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative; NaN becomes 0"
        )]
        let triangle = ((0.5 * parameter[0]).max(0.0) as usize).min(last);
        (triangle, [parameter[0] - 2.0 * triangle as f64, parameter[1]])
    }

    fn parameter(triangle: usize, [v, w]: [f64; 2]) -> [f64; 2] {
        [2.0 * triangle as f64 + v, w]
    }
}

impl ActiveShape<3> for ActiveLoop {
    fn coefficients(&self) -> &[Vector3<f64>] {
        &self.coefficients
    }

    fn set_coefficients(&mut self, coefficients: &[Vector3<f64>]) -> Result<(), Error> {
        if coefficients.len() != self.coefficients.len() {
            let found = coefficients.len();
            return Err(Error::Length { what: "coefficients", found, points: self.coefficients.len() });
        }
        if let Some(index) = coefficients.iter().position(|d| !d.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { index, count: 1 });
        }
        let mut positions: Vec<Point3<f64>> = self.surface.positions().to_vec();
        for (&vertex, d) in self.vertices.iter().zip(coefficients) {
            positions[vertex as usize] = Point3::from(*d);
        }
        self.surface.set_positions(&positions)?;
        self.coefficients.copy_from_slice(coefficients);
        Ok(())
    }

    fn cells(&self) -> &CellTable {
        &self.cells
    }

    fn cell(&self, parameter: [f64; 2]) -> usize {
        self.place(parameter).0
    }

    fn basis(&self, parameter: [f64; 2], cell: usize, values: &mut [f64]) {
        let mut weights = Vec::with_capacity(values.len());
        let at = [parameter[0] - 2.0 * cell as f64, parameter[1]];
        self.surface.weights(cell, at, &mut weights);
        values.iter_mut().zip(&weights).for_each(|(value, weight)| *value = weight[0]);
    }

    /// By quadrature on each control triangle, as if it were equilateral with edges of length 1; divided by their number. Limit
    /// surfaces have no third derivatives: the third weight does nothing.
    fn energy(&self, weights: [f64; 3]) -> Vec<CellGram> {
        let of_cell = |cell: usize| {
            let n = self.cells.columns(cell).len();
            let mut gram = vec![0.0; n * n];
            let mut values = Vec::new();
            for (at, share) in NODES {
                self.surface.weights(cell, at, &mut values);
                let root = 3f64.sqrt();
                // Derivatives in orthonormal directions, the first along the edge on which v grows; mixed ones twice.
                let forms: [(usize, f64, Vec<f64>); 5] = [
                    (0, 1.0, values.iter().map(|d| d[1]).collect()),
                    (0, 1.0, values.iter().map(|d| (2.0 * d[2] - d[1]) / root).collect()),
                    (1, 1.0, values.iter().map(|d| d[3]).collect()),
                    (1, 2.0, values.iter().map(|d| (2.0 * d[4] - d[3]) / root).collect()),
                    (1, 1.0, values.iter().map(|d| (4.0 * d[5] - 4.0 * d[4] + d[3]) / 3.0).collect()),
                ];
                for (order, times, form) in forms {
                    let factor = weights[order] * times * share / self.cells.len() as f64;
                    if factor == 0.0 {
                        continue;
                    }
                    for (line, a) in gram.chunks_exact_mut(n).zip(&form) {
                        line.iter_mut().zip(&form).for_each(|(slot, b)| *slot += factor * a * b);
                    }
                }
            }
            CellGram { cell, gram }
        };
        crate::parallel::map(self.cells.len(), of_cell)
    }

    fn tangent_planes(&self) -> Vec<(Vector3<f64>, f64)> {
        let normal = |triangle: usize| {
            let jet = self.surface.jet(triangle, [1.0 / 3.0; 2]);
            let normal = jet.and_then(|jet| jet.first[0].cross(&jet.first[1]).try_normalize(0.0));
            (normal.unwrap_or_else(Vector3::zeros), 1.0)
        };
        crate::parallel::map(self.cells.len(), normal)
    }

    fn frames(
        &self,
        points: &[Vector3<f64>],
        search: Search,
        previous: &[PrincipalFrame<3>],
    ) -> Result<Vec<PrincipalFrame<3>>, Error> {
        let hints: Vec<Hint> = if search == Search::Global {
            Vec::new()
        } else {
            let hint = |frame: &PrincipalFrame<3>| {
                let (_, parameter) = self.place(frame.hint.parameter);
                Hint { parameter, ..frame.hint }
            };
            previous.iter().map(hint).collect()
        };
        let mut frames = LoopField::new(&self.surface)?.frames(points, search, &hints);
        for frame in frames.iter_mut().filter(|frame| frame.is_finite()) {
            frame.hint.parameter = Self::parameter(frame.hint.element as usize, frame.hint.parameter);
        }
        Ok(frames)
    }

    fn sensors(&self, per_cell: usize) -> Vec<[f64; 2]> {
        // The middles of equal parts of each triangle.
        let share = |k: usize, third: f64| (k as f64 + third) / per_cell as f64;
        let mut places = Vec::with_capacity(per_cell * per_cell);
        for i in 0..per_cell {
            for j in 0..per_cell - i {
                places.push([share(i, 1.0 / 3.0), share(j, 1.0 / 3.0)]);
                if i + j + 1 < per_cell {
                    places.push([share(i, 2.0 / 3.0), share(j, 2.0 / 3.0)]);
                }
            }
        }
        let of = |triangle: usize| places.iter().map(move |&at| Self::parameter(triangle, at));
        (0..self.cells.len()).flat_map(of).collect()
    }
}
