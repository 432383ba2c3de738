//! Pictures of fitted surfaces: with the points by their distance and iso-curves, and with zebra stripes.

use super::bands::{Shown, parts, picked};
use crate::output::html::{note, section};
use industrial_geometry::fit::{Robust, SurfaceDistances};
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::mesh::{Attributes, PointCloud, TriangleMesh};
use industrial_geometry::nurbs::{
    BsplineSurface, Interval, ParametricSurface, TessellationOptions, TrimLoops,
};
use industrial_geometry::picture::{Curve, MeshScene, Paint, Sheet, View};
use std::f64::consts::PI;

/// Pixels of the longer side of a picture.
const SIDE: usize = 460;
/// Distance of the triangles from the surface as a share of its size.
const CHORD: f64 = 5e-4;
/// Iso-curves in each direction, their chords, colour and width.
const ISO: usize = 11;
const CHORDS: usize = 160;
const ISO_COLOUR: [f32; 3] = [0.25, 0.29, 0.34];
const ISO_WIDTH: f64 = 0.7;
/// Colour of the surface, radius of points, and lines of the zebra.
const PLAIN: [f32; 3] = [0.82, 0.85, 0.88];
const RADIUS: f64 = 1.5;
const LINES: u8 = 14;

/// The directions in which a surface has iso-curves that are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum IsoCurves {
    Both,
    /// Lines of constant u, as the rulings of a ruled surface.
    OfU,
}

/// The points that are drawn with a surface.
pub(crate) struct SurfaceSections<'a> {
    pub(crate) points: &'a [Vector3<f64>],
    pub(crate) tolerance: Option<f64>,
    /// The largest distance of a point that counts.
    pub(crate) max: f64,
}

/// The sections of a page about a B-spline surface, as markup.
pub(crate) fn surface_sections(
    scene: &SurfaceSections<'_>,
    surface: &BsplineSurface,
    trim: Option<&TrimLoops>,
    iso: IsoCurves,
) -> String {
    let some: Vec<Vector3<f64>> = scene.picked().map(|i| scene.points[i]).collect();
    let distances = match SurfaceDistances::of(surface, &some, Robust::None) {
        Ok(found) => found.distances,
        // A few points that no surface is near to have no distances.
        Err(_) => vec![f64::NAN; some.len()],
    };
    let size = surface.control_box().diagonal();
    let options = TessellationOptions::new(CHORD * size);
    let found = match trim {
        Some(trim) => surface.tessellate_trimmed(trim, &options),
        None => surface.tessellate(&options),
    };
    let mesh = found.map_err(|error| error.to_string()).and_then(|found| {
        let mut attributes = Attributes::default();
        attributes.set_normals(Some(found.normals));
        let vertices = found.vertices.into_iter().map(Point3::from).collect();
        let cloud = PointCloud::new(vertices).with_attributes(attributes);
        let mesh = cloud.and_then(|cloud| TriangleMesh::from_cloud(cloud, found.triangles));
        mesh.map_err(|error| error.to_string())
    });
    match mesh {
        Ok(mesh) => {
            drawn(scene, &mesh, iso_curves(surface, trim, iso), some.into_iter().zip(distances).collect())
        }
        Err(error) => note(&format!("The surface cannot be drawn: {error}")),
    }
}

/// The sections of a page about a surface that is known as a mesh, with the distances of the points.
pub(crate) fn mesh_sections(scene: &SurfaceSections<'_>, mesh: &TriangleMesh, distances: &[f64]) -> String {
    let distance = |i: usize| distances.get(i).copied().unwrap_or(f64::NAN);
    let points = scene.picked().map(|i| (scene.points[i], distance(i))).collect();
    drawn(scene, mesh, Vec::new(), points)
}

impl SurfaceSections<'_> {
    /// Indices of the points that are shown.
    fn picked(&self) -> impl Iterator<Item = usize> + '_ {
        picked(self.points.len()).filter(|&i| self.points[i].iter().all(|c| c.is_finite()))
    }
}

fn drawn(
    scene: &SurfaceSections<'_>,
    mesh: &TriangleMesh,
    curves: Vec<Vec<Point3<f64>>>,
    points: Vec<(Vector3<f64>, f64)>,
) -> String {
    let shown = Shown::new(points, scene.points.len(), scene.tolerance, scene.max);
    let normals: Option<Vec<Vector3<f64>>> = mesh.attributes().normals().map(<[_]>::to_vec);
    let curves: Vec<Curve> =
        curves.into_iter().map(|points| Curve { points, colour: ISO_COLOUR, width: ISO_WIDTH }).collect();
    let views = [View::default(), View { turn: View::default().turn + PI, ..View::default() }];
    let pictures = |paint: Paint<'_>, is_first: bool| {
        let mut sheet = Sheet::new();
        for (view, title) in views.into_iter().zip(["from the front", "from behind"]) {
            let mut picture = MeshScene::new(mesh, paint);
            picture.view = view;
            picture.normals = normals.as_deref();
            // Points far away must not make the surface small.
            picture.frame = Some(mesh.vertices());
            if is_first {
                picture.curves.clone_from(&curves);
                let dot = |(p, d): &(Vector3<f64>, f64)| (Point3::from(*p), parts(shown.colour(*d)), RADIUS);
                picture.points = shown.points.iter().map(dot).collect();
            }
            sheet = sheet.with(title, picture.draw(SIDE));
        }
        let svg = sheet.to_svg().unwrap_or_else(|error| note(&format!("There is no picture: {error}")));
        format!("<div class=\"views\">\n{svg}</div>\n")
    };
    let first = pictures(Paint::Plain(PLAIN), true) + &shown.legend();
    let stripes = pictures(Paint::Zebra(LINES), false)
        + &note(
            "The reflection of parallel lines of light: a break is an edge, a bend in the stripes is a jump of the curvature.",
        );
    section("The surface, its iso-curves, and the points by their distance", &first)
        + &section("Zebra stripes", &stripes)
}

/// Iso-curves, as far as the surface goes.
fn iso_curves(surface: &BsplineSurface, trim: Option<&TrimLoops>, iso: IsoCurves) -> Vec<Vec<Point3<f64>>> {
    let [u, v] = surface.domain();
    let mut out = Vec::new();
    let mut along = |fixed: Interval, free: Interval, place: &dyn Fn(f64, f64) -> [f64; 2]| {
        for k in 0..ISO {
            let at = fixed.lerp(k as f64 / (ISO - 1) as f64);
            let mut piece = Vec::new();
            for i in 0..=CHORDS {
                let [u, v] = place(at, free.lerp(i as f64 / CHORDS as f64));
                if trim.is_none_or(|trim| trim.contains(u, v)) {
                    piece.push(Point3::from(surface.point(u, v)));
                } else if !piece.is_empty() {
                    out.push(std::mem::take(&mut piece));
                }
            }
            if piece.len() > 1 {
                out.push(piece);
            }
        }
    };
    along(u, v, &|u, v| [u, v]);
    if iso == IsoCurves::Both {
        along(v, u, &|v, u| [u, v]);
    }
    out
}
