//! Meshes in smooth shading, with isolines, curves and points.

use crate::canvas::{Canvas, Colour, FINE, Raster, cover, from_segment, range, to_f32};
use crate::colour::{of_label, of_share};
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Rotation3, Vector3};

/// Room around, as a share of the larger side.
const MARGIN: f64 = 0.03;
/// Cosine of the angle between triangles from which on their edge is sharp.
const SHARP: f64 = 0.77;
/// Half the width of isolines, in pixels of the picture.
const LINE: f64 = 0.5;
/// How far curves and points are drawn in front of the surface, as a share of the size.
const BEFORE: f64 = 0.012;

/// What gives a mesh its colours.
#[derive(Clone, Copy, Debug)]
pub enum Paint<'a> {
    /// One colour.
    Plain([f32; 3]),
    /// One value per vertex, over a range, and the number of isolines.
    Values {
        /// The values; what is not finite is grey.
        values: &'a [f64],
        /// What has the first and the last colour.
        range: [f64; 2],
        /// Steps between isolines; 0 draws none.
        lines: usize,
    },
    /// One label per vertex; triangles between labels are divided.
    Labels(&'a [i64]),
    /// Zebra stripes: the reflection of so many parallel lines of light, which bends where the curvature jumps and breaks where the normal does.
    Zebra(u8),
}

/// A polyline on a mesh.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its vertices.
    pub points: Vec<Point3<f64>>,
    /// Its colour.
    pub colour: [f32; 3],
    /// Its width in pixels.
    pub width: f64,
}

/// From where a mesh is seen: turned about z, then towards the eye, in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Angle about z.
    pub turn: f64,
    /// Angle of the eye above the plane z = 0.
    pub height: f64,
}

impl Default for View {
    fn default() -> Self {
        Self { turn: -0.6, height: 0.47 }
    }
}

impl View {
    /// To the right, up, and towards the eye.
    fn rotation(self) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&Vector3::x_axis(), self.height - std::f64::consts::FRAC_PI_2)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), self.turn)
    }
}

/// A mesh with what is drawn on it.
#[derive(Clone, Debug)]
pub struct MeshScene<'a> {
    /// The mesh.
    pub mesh: &'a TriangleMesh,
    /// Unit normals of the vertices; without them those of the triangles around, up to sharp edges.
    pub normals: Option<&'a [Vector3<f64>]>,
    /// Its colours.
    pub paint: Paint<'a>,
    /// Curves on it.
    pub curves: Vec<Curve>,
    /// Points with their colour and radius in pixels.
    pub points: Vec<(Point3<f64>, [f32; 3], f64)>,
    /// From where it is seen.
    pub view: View,
    /// Points that fill the picture, drawn or not; by default those of the mesh and those that are drawn.
    pub frame: Option<&'a [Point3<f64>]>,
}

impl<'a> MeshScene<'a> {
    /// A mesh in one colour.
    #[must_use]
    pub fn new(mesh: &'a TriangleMesh, paint: Paint<'a>) -> Self {
        Self {
            mesh,
            normals: None,
            paint,
            curves: Vec::new(),
            points: Vec::new(),
            view: View::default(),
            frame: None,
        }
    }

    /// Draws it, the longer side of the picture with `size` pixels at most.
    #[must_use]
    pub fn draw(&self, size: usize) -> Raster {
        let eye = self.eye(size);
        let mut target = Target {
            canvas: Canvas::new(eye.size[0], eye.size[1]),
            depth: vec![f64::NEG_INFINITY; eye.size[0] * eye.size[1] * FINE * FINE],
        };
        let corners = self.corner_normals();
        for (triangle, normals) in self.mesh.triangles().iter().zip(&corners) {
            self.triangle(&mut target, &eye, triangle, normals);
        }
        for curve in &self.curves {
            for pair in curve.points.windows(2) {
                target.stroke(&eye, [pair[0], pair[1]], curve.colour, curve.width);
            }
        }
        for (point, colour, radius) in &self.points {
            target.stroke(&eye, [*point, *point], *colour, 2.0 * radius);
        }
        target.canvas.finished()
    }

    /// The unit normals of the vertices as they are seen: to the right, up, and towards the eye. As [`normals`](Self::normals) of another
    /// mesh that is seen from above they shade it like this one.
    #[must_use]
    pub fn seen_normals(&self) -> Vec<Vector3<f64>> {
        let turn = self.view.rotation();
        let mut sums = vec![Vector3::zeros(); self.mesh.vertices().len()];
        for (triangle, normals) in self.mesh.triangles().iter().zip(self.corner_normals()) {
            for (&vertex, normal) in triangle.iter().zip(&normals) {
                sums[vertex as usize] += normal;
            }
        }
        sums.into_iter().map(|sum| turn * sum.try_normalize(0.0).unwrap_or_else(Vector3::z)).collect()
    }

    fn eye(&self, size: usize) -> Eye {
        let turn = self.view.rotation();
        let own = || self.mesh.vertices().iter().copied().chain(self.points.iter().map(|p| p.0));
        let shown: Vec<Point3<f64>> = self.frame.map_or_else(|| own().collect(), <[_]>::to_vec);
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for point in shown.iter().filter(|p| p.iter().all(|c| c.is_finite())) {
            let seen = turn * point.coords;
            (low, high) = (low.inf(&seen), high.sup(&seen));
        }
        let sides = (high - low).map(|side| if side.is_finite() && side > 0.0 { side } else { 1.0 });
        let longest = sides.x.max(sides.y);
        let zoom = size as f64 * FINE as f64 / (longest * (1.0 + 2.0 * MARGIN));
        let margin = MARGIN * longest;
        let count =
            |side: f64| range(0.0, (side + 2.0 * margin) * zoom / FINE as f64 - 1.0, size).len().max(1);
        Eye {
            turn,
            low: low - Vector3::repeat(margin),
            high: high + Vector3::repeat(margin),
            zoom,
            size: [count(sides.x), count(sides.y)],
            before: BEFORE * longest,
        }
    }

    /// A unit normal for each corner of each triangle, as the means over the triangles around a vertex between sharp edges.
    fn corner_normals(&self) -> Vec<[Vector3<f64>; 3]> {
        let (vertices, triangles) = (self.mesh.vertices(), self.mesh.triangles());
        if let Some(normals) = self.normals.filter(|n| n.len() == vertices.len()) {
            return triangles.iter().map(|t| t.map(|k| normals[k as usize])).collect();
        }
        let corners = |t: &[u32; 3]| t.map(|k| vertices[k as usize]);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = corners(t);
            (b - a).cross(&(c - a))
        };
        let areas: Vec<Vector3<f64>> = triangles.iter().map(area).collect();
        let flat: Vec<Vector3<f64>> =
            areas.iter().map(|n| n.try_normalize(0.0).unwrap_or_else(Vector3::zeros)).collect();
        let mut around: Vec<Vec<(usize, f64)>> = vec![Vec::new(); vertices.len()];
        for (index, t) in triangles.iter().enumerate() {
            let p = corners(t);
            for k in 0..3 {
                let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                around[t[k] as usize].push((index, u.cross(&v).norm().atan2(u.dot(&v))));
            }
        }
        let normal = |index: usize, vertex: u32| {
            let near =
                around[vertex as usize].iter().filter(|(other, _)| flat[*other].dot(&flat[index]) > SHARP);
            let sum = near.fold(Vector3::zeros(), |sum, (other, angle)| sum + flat[*other] * *angle);
            sum.try_normalize(0.0).unwrap_or(flat[index])
        };
        triangles.iter().enumerate().map(|(index, t)| t.map(|vertex| normal(index, vertex))).collect()
    }

    fn triangle(&self, target: &mut Target, eye: &Eye, triangle: &[u32; 3], normals: &[Vector3<f64>; 3]) {
        let seen = triangle.map(|k| eye.place(&self.mesh.vertices()[k as usize]));
        if seen.iter().flatten().any(|c| !c.is_finite()) {
            return;
        }
        let [a, b, c] = seen;
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 {
            return;
        }
        let normals = normals.map(|n| eye.turn * n);
        let values = match self.paint {
            Paint::Values { values, .. } => {
                triangle.map(|k| values.get(k as usize).copied().unwrap_or(f64::NAN))
            }
            _ => [0.0; 3],
        };
        // Change of the value by one pixel of the canvas: what the distance from an isoline is measured by.
        let (u, v) = (values[1] - values[0], values[2] - values[0]);
        let slope = {
            let x = (u * (c[1] - a[1]) - v * (b[1] - a[1])) / area;
            let y = (v * (b[0] - a[0]) - u * (c[0] - a[0])) / area;
            x.hypot(y)
        };
        let min = [0, 1].map(|k: usize| a[k].min(b[k]).min(c[k]));
        let max = [0, 1].map(|k: usize| a[k].max(b[k]).max(c[k]));
        for y in range(min[1], max[1], target.canvas.height) {
            for x in range(min[0], max[0], target.canvas.width) {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let w1 = ((px - a[0]) * (c[1] - a[1]) - (py - a[1]) * (c[0] - a[0])) / area;
                let w2 = ((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0])) / area;
                let w = [1.0 - w1 - w2, w1, w2];
                if w.iter().any(|w| *w < -1e-9) {
                    continue;
                }
                let depth = w[0] * a[2] + w[1] * b[2] + w[2] * c[2];
                let place = y * target.canvas.width + x;
                if depth <= target.depth[place] {
                    continue;
                }
                target.depth[place] = depth;
                let normal = normals[0] * w[0] + normals[1] * w[1] + normals[2] * w[2];
                let base = match self.paint {
                    Paint::Plain(colour) => colour,
                    Paint::Zebra(lines) => reflected(&normal, lines),
                    Paint::Labels(labels) => {
                        let most = (0..3).fold(0, |best, k| if w[k] > w[best] { k } else { best });
                        of_label(labels.get(triangle[most] as usize).copied().unwrap_or(-1))
                    }
                    Paint::Values { range, lines, .. } => {
                        let value = w[0] * values[0] + w[1] * values[1] + w[2] * values[2];
                        lined(value, slope, range, lines)
                    }
                };
                target.canvas.pixels[place] = shaded(base, &normal);
            }
        }
    }
}

/// White where a line of light is seen in a mirror with a normal, black between them.
fn reflected(normal: &Vector3<f64>, lines: u8) -> Colour {
    let normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
    let normal = if normal.z < 0.0 { -normal } else { normal };
    // The direction that the eye, along z, sees in the mirror.
    let seen = normal * (2.0 * normal.z) - Vector3::z();
    let turn = seen.y.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
    if (turn * f64::from(lines)).fract() < 0.5 { [0.97; 3] } else { [0.10, 0.12, 0.15] }
}

/// The colour of a value, darker on isolines.
pub(crate) fn lined(value: f64, slope: f64, [low, high]: [f64; 2], lines: usize) -> Colour {
    let share = (value - low) / (high - low);
    let base = of_share(share);
    if lines == 0 || !share.is_finite() || slope == 0.0 {
        return base;
    }
    let step = (high - low) / lines as f64;
    let place = (value - low) / step;
    let away = (place - place.round()).abs() * step / slope;
    // Where lines would lie closer than a few pixels they would fill the picture.
    let dense = (step / slope / (6.0 * FINE as f64)).min(1.0);
    let share = 0.75 * cover(away, LINE * FINE as f64) * to_f32(dense);
    base.map(|c| c * (1.0 - share))
}

/// A colour in the light from the left above, and some from the right below.
fn shaded(base: Colour, normal: &Vector3<f64>) -> Colour {
    let normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
    // Surfaces are seen from both sides.
    let normal = if normal.z < 0.0 { -normal } else { normal };
    let main = Vector3::new(-0.45, 0.55, 0.70).normalize();
    let other = Vector3::new(0.75, -0.2, 0.4).normalize();
    let light = 0.42 + 0.56 * normal.dot(&main).max(0.0) + 0.16 * normal.dot(&other).max(0.0);
    let half = (main + Vector3::z()).normalize();
    let shine = 0.16 * normal.dot(&half).max(0.0).powi(40);
    base.map(|c| (c * to_f32(light) + to_f32(shine)).min(1.0))
}

/// How points become places on the canvas.
struct Eye {
    turn: Rotation3<f64>,
    low: Vector3<f64>,
    high: Vector3<f64>,
    zoom: f64,
    /// Width and height of the picture.
    size: [usize; 2],
    before: f64,
}

impl Eye {
    /// To the right and down in pixels of the canvas, and towards the eye.
    fn place(&self, point: &Point3<f64>) -> [f64; 3] {
        let p = self.turn * point.coords;
        [(p.x - self.low.x) * self.zoom, (self.high.y - p.y) * self.zoom, p.z]
    }
}

/// Colours and depths.
struct Target {
    canvas: Canvas,
    depth: Vec<f64>,
}

impl Target {
    /// A thick segment, where no surface is clearly before it.
    fn stroke(&mut self, eye: &Eye, ends: [Point3<f64>; 2], colour: Colour, width: f64) {
        let [a, b] = ends.map(|end| eye.place(&end));
        if a.iter().chain(&b).any(|c| !c.is_finite()) {
            return;
        }
        let half = 0.5 * width * FINE as f64;
        let (flat, other) = ([a[0], a[1]], [b[0], b[1]]);
        for y in range(a[1].min(b[1]) - half - 1.0, a[1].max(b[1]) + half + 1.0, self.canvas.height) {
            for x in range(a[0].min(b[0]) - half - 1.0, a[0].max(b[0]) + half + 1.0, self.canvas.width) {
                let (distance, t) = from_segment([x as f64 + 0.5, y as f64 + 0.5], flat, other);
                let depth = a[2] + (b[2] - a[2]) * t + eye.before;
                if depth >= self.depth[y * self.canvas.width + x] {
                    self.canvas.blend(x, y, colour, cover(distance, half));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stripes_are_the_same_from_both_sides_and_follow_the_normal() {
        let at = |angle: f64| reflected(&Vector3::new(0.0, angle.sin(), angle.cos()), 8);
        for k in 0..40 {
            let normal = Vector3::new(0.3, 0.04 * f64::from(k) - 0.8, 0.5);
            assert_eq!(reflected(&normal, 8), reflected(&-normal, 8));
        }
        // A turn of the normal by half the distance of two lines goes from the middle of one to the middle of the next.
        let step = std::f64::consts::PI / 16.0;
        assert_eq!(at(0.25 * step), at(1.25 * step));
        assert_ne!(at(0.25 * step), at(0.75 * step));
    }
}
