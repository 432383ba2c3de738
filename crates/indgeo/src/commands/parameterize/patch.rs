//! Parameters of a patch of a mesh: read, compute, write.

use crate::error::Error;
use crate::files;
use crate::on_surface::picture::{self, write_sheet};
use crate::on_surface::{MetricChoice, mesh_of, read, refused};
use crate::report::wording::counted;
use crate::report::{Output, Report, Timings};
use industrial_geometry::feature_metric::{
    Metric, ParameterDomain, ParameterOptions, PatchParameters, parameterize_patch,
};
use industrial_geometry::io::{Content, WriteOptions};
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::mesh::{Attributes, TriangleMesh};
use industrial_geometry::picture::{Curve, MeshScene, Paint, Sheet, View};
use serde::Serialize;
use std::io::Write;
use std::path::Path;

const HELP: &str = "see `indgeo parameterize --help`";
/// Pixels of the longer side of each of the two pictures.
const SIZE: usize = 700;
/// Parameter lines in each direction, and their colours and width.
const LINES: u32 = 20;
const COLOURS: [[f32; 3]; 2] = [[0.11, 0.32, 0.65], [0.80, 0.16, 0.24]];
const WIDTH: f64 = 2.0;
/// Colour of the mesh.
const PLAIN: [f32; 3] = [0.80, 0.82, 0.84];

/// Where the boundary of a patch goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum DomainChoice {
    /// The unit square, with four corners
    Square,
    /// The circle of radius 1/2 about (1/2, 1/2)
    Disc,
}

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the mesh.
    pub(crate) mesh: &'a Path,
    pub(crate) choice: MetricChoice,
    pub(crate) metric: Metric,
    pub(crate) domain: DomainChoice,
    /// Vertices at the corners of the square.
    pub(crate) corners: Option<[usize; 4]>,
    /// File of the parameters.
    pub(crate) out: Option<&'a Path>,
    /// File of the picture.
    pub(crate) picture: Option<&'a Path>,
}

/// What was found.
#[derive(Debug, Serialize)]
pub(crate) struct PatchResults {
    pub(crate) metric: &'static str,
    /// The width `w`, 0 in the Euclidean metric.
    pub(crate) w: f64,
    /// `square` or `disc`.
    pub(crate) domain: &'static str,
    /// Vertices of the mesh at the corners of the square.
    pub(crate) corners: Option<[usize; 4]>,
    /// Vertices of the mesh, and those among them that belong to no triangle.
    pub(crate) vertices: usize,
    pub(crate) unused: usize,
    /// Rows of the table: vertices of sharp edges have one for each side.
    pub(crate) rows: usize,
    /// Triangles over the domain, and those without positive area there.
    pub(crate) triangles: usize,
    pub(crate) folded: usize,
    /// Length of the boundary in the metric.
    pub(crate) boundary_length: f64,
}

/// Does the job and fills in the report; returns whether no triangle folds.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<bool, Error> {
    for path in [job.out, job.picture].into_iter().flatten() {
        files::check_writable(path, &[job.mesh])?;
    }
    if let Some(path) = job.out
        && !matches!(files::extension(path).as_str(), "csv" | "ply")
        && !files::is_stream(path)
    {
        return Err(Error::content(path, "parameters of a patch are CSV or PLY", "choose .csv or .ply"));
    }
    if let Some(path) = job.picture {
        picture::check(path)?;
    }
    let mut timings = Timings::default();
    let mesh = mesh_of(read(job.mesh, report, &mut timings)?, job.mesh)?;
    let domain = match job.domain {
        DomainChoice::Square => ParameterDomain::Square,
        DomainChoice::Disc => ParameterDomain::Disc,
    };
    let options = ParameterOptions::default().with_domain(domain).with_corners(job.corners);
    let found = Timings::measure(&mut timings.compute, || parameterize_patch(&mesh, job.metric, &options))
        .map_err(|error| refused(job.mesh, &error, HELP))?;
    let mut seconds = timings.write;
    Timings::measure(&mut seconds, || write(job, &mesh, &found, report))?;
    timings.write = seconds;
    report.timings = timings;
    if found.folded > 0 {
        let what = counted(found.folded, "triangle");
        report.warnings.push(format!(
            "{}: {what} of {} without positive area in the parameters; a disc (--domain disc) or a finer mesh has more room",
            job.mesh.display(),
            found.triangles.len()
        ));
    }
    let mut used = vec![false; mesh.vertices().len()];
    for place in &found.places {
        used[place.vertex] = true;
    }
    let unused = used.iter().filter(|used| !**used).count();
    if unused > 0 {
        report.warnings.push(format!(
            "{}: {} without a row, since no triangle uses it",
            job.mesh.display(),
            counted(unused, "vertex")
        ));
    }
    report.results = Some(Box::new(PatchResults {
        metric: job.choice.name(),
        w: job.metric.width(),
        domain: if job.domain == DomainChoice::Square { "square" } else { "disc" },
        corners: found.corners,
        vertices: used.len(),
        unused,
        rows: found.places.len(),
        triangles: found.triangles.len(),
        folded: found.folded,
        boundary_length: found.boundary_length,
    }));
    Ok(found.folded == 0)
}

/// The mesh with one vertex for each place.
fn unfolded(mesh: &TriangleMesh, found: &PatchParameters, path: &Path) -> Result<TriangleMesh, Error> {
    let points = found.places.iter().map(|place| mesh.vertices()[place.vertex]).collect();
    TriangleMesh::new(points, found.triangles.clone())
        .map_err(|error| Error::content(path, error.to_string(), HELP))
}

fn write(
    job: &Job<'_>,
    mesh: &TriangleMesh,
    found: &PatchParameters,
    report: &mut Report,
) -> Result<(), Error> {
    if let Some(path) = job.out {
        let bytes = if files::extension(path) == "ply" {
            let failed =
                |error: industrial_geometry::mesh::Error| Error::content(path, error.to_string(), HELP);
            let mut attributes = Attributes::default();
            for (k, name) in ["u", "v"].into_iter().enumerate() {
                let values = found.places.iter().map(|place| place.parameters[k]).collect();
                attributes.push_scalar(name, values).map_err(failed)?;
            }
            let content = unfolded(mesh, found, path)?.with_attributes(attributes).map_err(failed)?;
            files::write_content(path, &Content::Mesh(content), &WriteOptions::default())?.bytes
        } else {
            files::write(path, |out| {
                let mut out = std::io::BufWriter::new(out);
                writeln!(out, "vertex,x,y,z,u,v")?;
                for place in &found.places {
                    let ([u, v], x) = (place.parameters, mesh.vertices()[place.vertex]);
                    writeln!(out, "{},{},{},{},{u},{v}", place.vertex, x.x, x.y, x.z)?;
                }
                out.flush()
            })?
        };
        let content = format!("{}: vertex,x,y,z,u,v", counted(found.places.len(), "row"));
        report.add_output(Output { path: path.to_path_buf(), bytes, content });
    }
    if let Some(path) = job.picture {
        draw(path, mesh, found, report)?;
    }
    Ok(())
}

/// Draws the patch with its parameter lines, and beside it the domain, shaded as the patch is.
fn draw(path: &Path, mesh: &TriangleMesh, found: &PatchParameters, report: &mut Report) -> Result<(), Error> {
    let own = unfolded(mesh, found, path)?;
    let mut scene = MeshScene::new(&own, Paint::Plain(PLAIN));
    scene.view = facing(&own);
    for (direction, colour) in COLOURS.into_iter().enumerate() {
        let lines = found.lines(mesh, direction, LINES);
        scene.curves.extend(lines.into_iter().map(|ends| Curve {
            points: ends.to_vec(),
            colour,
            width: WIDTH,
        }));
    }
    let flat: Vec<Point3<f64>> =
        found.places.iter().map(|place| Point3::new(place.parameters[0], place.parameters[1], 0.0)).collect();
    let domain = TriangleMesh::new(flat.clone(), found.triangles.clone())
        .map_err(|error| Error::content(path, error.to_string(), HELP))?;
    let mut plane = MeshScene::new(&domain, Paint::Plain(PLAIN));
    plane.view = View { turn: 0.0, height: std::f64::consts::FRAC_PI_2 };
    // Places, not vertices, have a normal each: those at sharp edges differ.
    let normals = scene.seen_normals();
    plane.normals = Some(&normals);
    plane.curves = found
        .triangles
        .iter()
        .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
        .map(|side| Curve {
            points: side.map(|k| flat[k as usize]).to_vec(),
            colour: [0.45, 0.48, 0.52],
            width: 0.7,
        })
        .collect();
    let sheet = Sheet::new()
        .with("lines of equal u (blue) and v (red)", scene.draw(SIZE))
        .with("the mesh over the parameters", plane.draw(SIZE));
    write_sheet(path, &sheet, "picture: parameter lines, and the mesh in the plane", report)
}

/// From where a patch is seen from its outer side.
fn facing(mesh: &TriangleMesh) -> View {
    let mut sum = Vector3::zeros();
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|k| mesh.vertices()[k as usize]);
        sum += (b - a).cross(&(c - a));
    }
    let default = View::default();
    let flat = sum.x.hypot(sum.y);
    if flat.is_nan() || flat <= 1e-3 * sum.norm() {
        return default;
    }
    // The eye looks along y after the turn about z; a little from the side shows the relief.
    let turn = -std::f64::consts::FRAC_PI_2 - sum.y.atan2(sum.x);
    let height = sum.z.atan2(flat).clamp(-1.2, 1.2);
    View { turn: turn + 0.35, height: height + if height > 0.9 { -0.3 } else { 0.3 } }
}
