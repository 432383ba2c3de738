//! The distance from Loop subdivision surfaces.

use crate::local_geometry::{LocalGeometry, of_curve, of_point, of_principal, of_surface, tangents};
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search, parallel};
use footpoint::Status;
use footpoint::local::{newton_curve, newton_surface};
use mesh_core::{HalfEdgeMesh, LoopSurface, MeshProjector, TriangleMesh};
use nalgebra::{Point3, Vector3};
use nurbs_core::{Aabb, CurveJet, SurfaceJet};

/// Parts of an edge of a control triangle at which the limit surface is sampled for starts.
const PARTS: usize = 3;
/// Steps at most, halvings of one, triangles that one may cross, and its largest length in triangles.
const STEPS: usize = 40;
const HALVINGS: usize = 12;
const CROSSINGS: usize = 24;
const LONGEST: f64 = 1.0;
/// Sine of the angle between residual and normal up to which a foot counts as found, and the same as a share of the size where
/// there is no residual.
const ORTHOGONAL: (f64, f64) = (1e-9, 1e-13);
/// Way in barycentric coordinates that is kept from corners, where derivatives may vanish, have no limit, or lose their digits: a
/// foot this near is the corner. Of starts, too.
const CLEAR: f64 = 1e-8;
const CLEAR_START: f64 = 0.02;
/// Way to an irregular vertex, where derivatives have no limit, up to which the normal is taken from beside it.
const BESIDE: f64 = 1e-4;

/// The distance from the limit surface of Loop's scheme, signed by its normal (\[P05, sec. 4.2\], Fig. 5).
///
/// The start of a global search is the nearest point of a mesh that samples the limit surface, several triangles for each
/// control triangle; from there, or from a hint, Newton's method goes on across the edges of control triangles. Feet are exact
/// to rounding, but not certified to be the nearest where two parts of the surface are equally near up to the error of the
/// sampling mesh. Where an open surface ends, the foot moves along the boundary curve only.
#[derive(Clone, Debug)]
pub struct LoopField<'a> {
    surface: &'a LoopSurface,
    /// Across each edge, from corner `e` to `e + 1`, the triangle and the number of the edge there.
    across: Vec<[Option<(usize, usize)>; 3]>,
    projector: MeshProjector,
    size: f64,
    bounds: Aabb<3>,
}

/// A place on a control triangle in barycentric coordinates.
#[derive(Clone, Copy, Debug)]
struct Place {
    triangle: usize,
    at: [f64; 3],
}

impl Place {
    fn parameter(&self) -> [f64; 2] {
        [self.at[1], self.at[2]]
    }

    fn from(triangle: usize, [v, w]: [f64; 2]) -> Self {
        let (v, w) = (v.clamp(0.0, 1.0), w.clamp(0.0, 1.0));
        let sum = (v + w).max(1.0);
        let (v, w) = (v / sum, w / sum);
        Self { triangle, at: [(1.0 - v - w).max(0.0), v, w] }
    }
}

/// Where an iteration stands.
struct State {
    place: Place,
    jet: SurfaceJet,
    distance_sq: f64,
}

/// A step: in the parameters `v` and `w`, or along an edge at which the surface ends.
#[derive(Clone, Copy, Debug)]
enum Step {
    Free([f64; 2]),
    Border(usize, f64),
}

impl<'a> LoopField<'a> {
    /// The distance from a limit surface as it is now.
    ///
    /// # Errors
    /// [`Error::Mesh`] when no triangle has finite coordinates.
    pub fn new(surface: &'a LoopSurface) -> Result<Self, Error> {
        let triangles = surface.triangles();
        let mesh = HalfEdgeMesh::of(surface.positions().len(), triangles);
        let mut across = vec![[None; 3]; triangles.len()];
        for half_edge in mesh.half_edges() {
            across[half_edge.triangle()][half_edge.edge()] =
                mesh.twin(half_edge).map(|twin| (twin.triangle(), twin.edge()));
        }
        let places = sample_places();
        let corners = small_triangles();
        let points: Vec<Point3<f64>> = parallel::map(triangles.len() * places.len(), |k| {
            let jet = surface.jet(k / places.len(), places[k % places.len()]);
            jet.map_or(Point3::new(f64::NAN, f64::NAN, f64::NAN), |jet| jet.position)
        });
        let bounds =
            Aabb::of_points(points.iter().map(|p| &p.coords).filter(|p| p.iter().all(|c| c.is_finite())));
        let bounds = bounds.unwrap_or_else(|| Aabb::of_point(Vector3::zeros()));
        let mut small = Vec::with_capacity(triangles.len() * corners.len());
        for triangle in 0..triangles.len() {
            for corner in &corners {
                small.push(corner.map(|c| u32::try_from(triangle * places.len() + c).unwrap_or(u32::MAX)));
            }
        }
        let projector = MeshProjector::new(&TriangleMesh::new(points, small)?)?;
        let size = 0.5 * bounds.sides().amax();
        Ok(Self { surface, across, projector, size, bounds })
    }

    fn state(&self, place: Place, x: &Vector3<f64>) -> Option<State> {
        let jet = self.surface.jet(place.triangle, place.parameter())?;
        let ([du, dv], [duu, duv, dvv]) = (jet.first, jet.second);
        let jet = SurfaceJet { point: jet.position.coords, du, dv, duu, duv, dvv };
        let distance_sq = (x - jet.point).norm_squared();
        distance_sq.is_finite().then_some(State { place, jet, distance_sq })
    }

    /// The start of a global search.
    fn nearest_sample(&self, x: &Vector3<f64>) -> Option<Place> {
        let foot = self.projector.project(&Point3::from(*x)).ok()?;
        let (places, corners) = (sample_places(), small_triangles());
        let corner = corners[foot.triangle % corners.len()].map(|c| places[c]);
        let parameter = [0, 1].map(|k| (0..3).map(|c| foot.barycentric[c] * corner[c][k]).sum::<f64>());
        Some(self.clear(Place::from(foot.triangle / corners.len(), parameter), CLEAR_START))
    }

    /// The place, or one beside the corner at which it lies: along the border if the surface ends there.
    fn clear(&self, mut place: Place, way: f64) -> Place {
        let Some(corner) = (0..3).find(|&k| place.at[k] > 1.0 - way) else { return place };
        let (next, last) = ((corner + 1) % 3, (corner + 2) % 3);
        let ends = self.across[place.triangle].map(|other| other.is_none());
        let rest = place.at[next] + place.at[last];
        let share = if rest > 0.0 {
            place.at[next] / rest
        } else if ends[corner] {
            1.0
        } else if ends[last] {
            0.0
        } else {
            0.5
        };
        place.at[corner] = 1.0 - way;
        (place.at[next], place.at[last]) = (way * share, way * (1.0 - share));
        place
    }

    /// The edge at which the surface ends and a place lies, if there is one.
    fn border(&self, place: &Place) -> Option<usize> {
        (0..3).find(|&e| place.at[(e + 2) % 3] <= 0.0 && self.across[place.triangle][e].is_none())
    }

    /// A place moved by a step, across edges, up to where the surface ends.
    fn moved(&self, place: &Place, step: [f64; 2]) -> Place {
        let Place { mut triangle, mut at } = *place;
        let mut way = [-step[0] - step[1], step[0], step[1]];
        for _ in 0..CROSSINGS {
            let share = |k: usize| if way[k] < 0.0 { at[k] / -way[k] } else { f64::INFINITY };
            let out = (0..3).min_by(|&a, &b| share(a).total_cmp(&share(b))).unwrap_or(0);
            let part = share(out);
            if part >= 1.0 {
                (0..3).for_each(|k| at[k] = (at[k] + way[k]).max(0.0));
                break;
            }
            (0..3).for_each(|k| at[k] = (at[k] + part * way[k]).max(0.0));
            at[out] = 0.0;
            let edge = (out + 1) % 3;
            let Some((next, other)) = self.across[triangle][edge] else { break };
            // The neighbour continues the parameters of this triangle as its mirror image does.
            let rest = way.map(|c| c * (1.0 - part));
            let (mut there, mut further) = ([0.0; 3], [0.0; 3]);
            there[(other + 1) % 3] = at[edge];
            there[other] = at[(edge + 1) % 3];
            further[(other + 1) % 3] = rest[edge] + rest[out];
            further[other] = rest[(edge + 1) % 3] + rest[out];
            further[(other + 2) % 3] = -rest[out];
            (triangle, at, way) = (next, there, further);
        }
        let sum: f64 = at.iter().sum();
        self.clear(Place { triangle, at: at.map(|c| c / sum) }, CLEAR)
    }

    /// A place on the border moved along it, around the next corner at most.
    fn slid(&self, place: &Place, edge: usize, length: f64) -> Place {
        let (mut triangle, mut edge) = (place.triangle, edge);
        let mut share = place.at[(edge + 1) % 3] + length;
        // Around the corner into which the edge leads, or out of which it comes, to the other border there.
        if share > 1.0 {
            edge = (edge + 1) % 3;
            while let Some((next, other)) = self.across[triangle][edge] {
                (triangle, edge) = (next, (other + 1) % 3);
            }
            share = (share - 1.0).min(1.0);
        } else if share < 0.0 {
            edge = (edge + 2) % 3;
            while let Some((next, other)) = self.across[triangle][edge] {
                (triangle, edge) = (next, (other + 2) % 3);
            }
            share = (share + 1.0).max(0.0);
        }
        let mut at = [0.0; 3];
        (at[edge], at[(edge + 1) % 3]) = (1.0 - share, share);
        self.clear(Place { triangle, at }, CLEAR)
    }

    /// The step from a state, and whether its place satisfies the conditions of a foot.
    fn step(&self, state: &State, x: &Vector3<f64>) -> (Step, bool) {
        let residual = x - state.jet.point;
        let allowed = ORTHOGONAL.0 * residual.norm() + ORTHOGONAL.1 * self.size;
        let step = newton_surface(&state.jet, x).unwrap_or([0.0; 2]);
        if let Some(edge) = self.border(&state.place) {
            let way = [-step[0] - step[1], step[0], step[1]];
            if way[(edge + 2) % 3] < 0.0 {
                let curve = along(&state.jet, edge);
                let found = curve.unit_tangent().is_none_or(|t| t.dot(&residual).abs() <= allowed);
                return (Step::Border(edge, newton_curve(&curve, x).unwrap_or(0.0)), found);
            }
        }
        let across = match state.jet.unit_normal() {
            Some(normal) => (residual - normal * normal.dot(&residual)).norm(),
            None => f64::INFINITY,
        };
        (Step::Free(step), across <= allowed)
    }

    /// The foot to which the iteration leads.
    fn foot(&self, start: Place, x: &Vector3<f64>) -> Option<(State, Status)> {
        let mut state = self.state(start, x)?;
        let noise = (ORTHOGONAL.1 * self.size).powi(2);
        for _ in 0..STEPS {
            let (step, found) = self.step(&state, x);
            let length = match step {
                Step::Free([v, w]) => v.abs().max(w.abs()),
                Step::Border(_, length) => length.abs(),
            };
            let at_corner = state.place.at.iter().any(|c| *c > 1.0 - 10.0 * CLEAR);
            if found || at_corner && length <= 10.0 * CLEAR {
                return Some((state, Status::Converged));
            }
            let mut factor = if length > LONGEST { LONGEST / length } else { 1.0 };
            // Near a foot the distance no longer tells which of two places is better.
            let bound = state.distance_sq * (1.0 + 8.0 * f64::EPSILON) + noise;
            let mut next = None;
            for _ in 0..HALVINGS {
                let place = match step {
                    Step::Free(step) => self.moved(&state.place, step.map(|c| c * factor)),
                    Step::Border(edge, length) => self.slid(&state.place, edge, length * factor),
                };
                let trial = self.state(place, x);
                // Not so either when a number is NaN.
                if let Some(trial) = trial.filter(|t| t.distance_sq <= bound) {
                    next = Some(trial);
                    break;
                }
                factor *= 0.5;
            }
            let Some(trial) = next else { return Some((state, Status::Stalled)) };
            state = trial;
        }
        Some((state, Status::MaxIterations))
    }

    /// The frame at a foot.
    fn frame_at(&self, state: &State, status: Status, x: &Vector3<f64>) -> PrincipalFrame<3> {
        let State { place, jet, .. } = state;
        let residual = x - jet.point;
        let beyond = self.border(place).filter(|edge| {
            let step = newton_surface(jet, x).unwrap_or([0.0; 2]);
            [-step[0] - step[1], step[0], step[1]][(edge + 2) % 3] < 0.0
        });
        let geometry: LocalGeometry<3> = match beyond {
            Some(edge) => {
                let side = jet.unit_normal();
                of_curve(&along(jet, edge), &residual, side.as_ref())
                    .unwrap_or_else(|| of_point(&residual, side.as_ref()))
            }
            None => of_surface(jet, &residual)
                .filter(|g| g.curvatures.iter().all(|c| c.is_finite()))
                .or_else(|| self.beside(place, &residual))
                .unwrap_or_else(|| of_point(&residual, None)),
        };
        let status = match status {
            Status::Converged if beyond.is_some() => Status::OnBoundary,
            other => other,
        };
        PrincipalFrame {
            foot: jet.point,
            axes: geometry.axes,
            curvatures: geometry.curvatures,
            tangent_dimension: geometry.tangent_dimension,
            distance: geometry.distance,
            on_boundary: beyond.is_some(),
            hint: Hint::new(place.triangle, place.parameter()),
            status,
        }
    }

    /// The tangent plane at an irregular vertex, without curvatures, from a place beside it.
    fn beside(&self, place: &Place, residual: &Vector3<f64>) -> Option<LocalGeometry<3>> {
        let at = place.at.map(|c| (1.0 - BESIDE) * c + BESIDE / 3.0);
        let jet = self.surface.jet(place.triangle, [at[1], at[2]])?;
        let normal = jet.first[0].cross(&jet.first[1]).try_normalize(0.0)?;
        Some(of_principal(&tangents(&normal), &normal, [0.0; 2], residual.dot(&normal)))
    }
}

impl DistanceField<3> for LoopField<'_> {
    fn frame(&self, x: &Vector3<f64>, search: Search, hint: &Hint) -> PrincipalFrame<3> {
        if !x.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(Status::InvalidPoint);
        }
        let start = match hint.element_below(self.across.len()) {
            Some(triangle) if search != Search::Global => {
                Some(self.clear(Place::from(triangle, hint.parameter), CLEAR))
            }
            _ => self.nearest_sample(x),
        };
        match start.and_then(|start| self.foot(start, x)) {
            Some((state, status)) => self.frame_at(&state, status, x),
            None => PrincipalFrame::invalid(Status::Diverged),
        }
    }

    fn bounding_box(&self) -> Aabb<3> {
        self.bounds
    }
}

/// Derivatives along an edge from corner `e` to `e + 1`.
fn along(jet: &SurfaceJet, edge: usize) -> CurveJet<3> {
    let [v, w] = [[1.0, 0.0], [-1.0, 1.0], [0.0, -1.0]][edge];
    let d1 = jet.du * v + jet.dv * w;
    let d2 = jet.duu * (v * v) + jet.duv * (2.0 * v * w) + jet.dvv * (w * w);
    CurveJet { point: jet.point, d1, d2 }
}

/// Parameters of the samples of a control triangle, row after row of equal `w`.
fn sample_places() -> Vec<[f64; 2]> {
    let share = |k: usize| k as f64 / PARTS as f64;
    (0..=PARTS).flat_map(|j| (0..=PARTS - j).map(move |i| [share(i), share(j)])).collect()
}

/// The corners of the small triangles between the samples of a control triangle.
fn small_triangles() -> Vec<[usize; 3]> {
    // Row `j` begins behind rows of `PARTS + 1`, `PARTS`, … samples.
    let at = |i: usize, j: usize| j * (PARTS + 1) - j * j.saturating_sub(1) / 2 + i;
    let mut out = Vec::with_capacity(PARTS * PARTS);
    for j in 0..PARTS {
        for i in 0..PARTS - j {
            out.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 1 < PARTS {
                out.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of eight triangles: all vertices have four neighbours.
    fn octahedron() -> TriangleMesh {
        let corners = [[1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
        let triangles =
            [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]];
        TriangleMesh::new(corners.map(Point3::from).to_vec(), triangles.to_vec()).unwrap()
    }

    #[test]
    fn samples_cover_the_triangle() {
        let places = sample_places();
        let area = |c: [usize; 3]| {
            let [a, b, c] = c.map(|k| places[k]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        };
        let areas: Vec<f64> = small_triangles().into_iter().map(area).collect();
        assert_eq!(areas.len(), PARTS * PARTS);
        assert!(areas.iter().all(|a| (a - 0.5 / areas.len() as f64).abs() < 1e-15));
    }

    #[test]
    fn feet_are_orthogonal_and_as_near_as_any_sample() {
        let surface = LoopSurface::new(&octahedron()).unwrap();
        let field = LoopField::new(&surface).unwrap();
        let samples: Vec<Vector3<f64>> = (0..8 * 861)
            .map(|k| {
                let (i, j) = ((k % 861) / 41, (k % 861) % 41);
                let (v, w) = (f64::from(i) / 41.0, f64::from(j) / 41.0);
                let (v, w) = if v + w > 1.0 { (1.0 - v, 1.0 - w) } else { (v, w) };
                surface.jet(k as usize / 861, [v, w]).unwrap().position.coords
            })
            .collect();
        for k in 1..300 {
            let a = f64::from(k) * 2.399_963;
            let z = f64::from(k) / 150.0 - 1.0;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let x = Vector3::new(r * a.cos(), r * a.sin(), z) * (0.5 + 0.005 * f64::from(k));
            let frame = field.frame(&x, Search::Global, &Hint::NONE);
            assert!(frame.status.is_converged(), "{k} {}", frame.status);
            assert!((frame.foot + frame.normal() * frame.distance - x).norm() < 1e-8);
            let nearest = samples.iter().map(|s| (s - x).norm()).fold(f64::INFINITY, f64::min);
            assert!(frame.distance.abs() <= nearest + 1e-12, "{k}: {} {nearest}", frame.distance);
            // From a hint on the other side of an edge the same foot.
            let near = field.frame(&(x * 1.05), Search::Global, &Hint::NONE);
            let again = field.frame(&x, Search::Local, &near.hint);
            assert!((again.foot - frame.foot).norm() < 1e-7, "{k}");
        }
    }

    #[test]
    fn an_open_surface_ends() {
        // A flat hexagon: its limit is flat, its boundary a curve.
        let ring = (0..6).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_3);
        let mut corners = vec![Point3::origin()];
        corners.extend(ring.map(|a| Point3::new(a.cos(), a.sin(), 0.0)));
        let triangles = (0..6).map(|k| [0, k + 1, (k + 1) % 6 + 1]).collect();
        let surface = LoopSurface::new(&TriangleMesh::new(corners, triangles).unwrap()).unwrap();
        let field = LoopField::new(&surface).unwrap();
        let inside = field.frame(&Vector3::new(0.2, 0.1, -0.5), Search::Global, &Hint::NONE);
        assert_eq!((inside.on_boundary, inside.tangent_dimension), (false, 2));
        assert!((inside.distance + 0.5).abs() < 1e-12);
        for k in 0..40 {
            let a = f64::from(k) * 0.157;
            let x = Vector3::new(2.0 * a.cos(), 2.0 * a.sin(), 0.3);
            let frame = field.frame(&x, Search::Global, &Hint::NONE);
            assert_eq!(
                (frame.on_boundary, frame.tangent_dimension, frame.status),
                (true, 1, Status::OnBoundary)
            );
            assert!(frame.axes.column(0).dot(&(x - frame.foot)).abs() < 1e-6);
        }
        let nan = field.frame(&Vector3::new(f64::NAN, 0.0, 0.0), Search::Global, &Hint::NONE);
        assert_eq!(nan.status, Status::InvalidPoint);
    }
}
