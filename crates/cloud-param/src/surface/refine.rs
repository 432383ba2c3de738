//! Refinement and relaxation of a base surface.

use super::SampleGrid;
use super::unfold::unfolded;
use crate::defects::SurfaceDefects;
use crate::directed::project;
use crate::{AxisFrame, DirectedOptions, Error, Neighbourhood, parallel};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, ParametricSurface};

/// Distance from the cloud, in spacings, beyond which a place has nothing to be drawn to.
const FAR: f64 = 4.0;

/// How a base surface is drawn to its cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RefineOptions {
    /// Directed projection of the places of the grid.
    pub directed: DirectedOptions,
    /// Most iterations; default 6.
    pub max_iterations: usize,
    /// Change of the root mean square distance, as a share of it, below which the iteration ends; default 0.01.
    pub threshold: f64,
    /// Share of the way to the middle of its neighbours that a place is moved, within the tangent plane; default 0.5.
    pub relaxation: f64,
    /// Whether places are moved to equal distances along the parameter lines before each iteration; default yes.
    pub equalise: bool,
    /// Whether places on the boundary of an open grid stay where they are; default not. `equalise` must be off then.
    pub hold_boundary: bool,
}

impl Default for RefineOptions {
    fn default() -> Self {
        Self {
            directed: DirectedOptions::default(),
            max_iterations: 6,
            threshold: 0.01,
            relaxation: 0.5,
            equalise: true,
            hold_boundary: false,
        }
    }
}

/// One iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RefineStep {
    /// Root mean square distance of the places from their nearest points.
    pub rms: f64,
    /// What is wrong with the surface.
    pub defects: SurfaceDefects,
}

/// What refinement achieved.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RefineReport {
    /// The state before the first iteration and after each, and after smoothing around folds if that was needed.
    pub history: Vec<RefineStep>,
    /// The state that was kept: the last of those with fewest defects.
    pub kept: usize,
    /// Whether the change fell below the threshold.
    pub converged: bool,
    /// Share of the places without a point near them: holes, or ends that are not even.
    pub unsupported: f64,
}

/// Draws a grid to a cloud: its places are projected along the normals of the surface through it, relaxed within the tangent
/// planes, and again ([MPK, sec. 3.7], after the dynamic base surfaces of \[Az04\]).
///
/// Places without a point near them are carried by their neighbours. On the first and last row, in `v`, places stay in
/// their layer across the axis if there is one. The state with fewest defects, among these the last, is kept. Where some cells
/// are folded even so, the places around them are smoothed until none is, and that is one state more.
///
/// # Errors
/// [`Error::Option`]; [`Error::Nurbs`] if no surface can be laid through the grid.
pub fn refine(
    grid: &SampleGrid,
    cloud: &Neighbourhood,
    frame: Option<&AxisFrame>,
    options: &RefineOptions,
) -> Result<(SampleGrid, BsplineSurface, RefineReport), Error> {
    options.directed.check()?;
    if !(0.0..=1.0).contains(&options.relaxation) {
        return Err(Error::Option { name: "relaxation", value: options.relaxation, allowed: "in [0, 1]" });
    }
    if options.hold_boundary && options.equalise {
        return Err(Error::Option {
            name: "equalise",
            value: 1.0,
            allowed: "false (0) where the boundary is held",
        });
    }
    let axes = frame.map(|f| &f.axes);
    let state = |grid: &SampleGrid| -> Result<(BsplineSurface, RefineStep), Error> {
        let surface = grid.surface()?;
        let defects = SurfaceDefects::of(&surface, axes);
        let rms = cloud.rms(&supported(grid, cloud));
        Ok((surface, RefineStep { rms, defects }))
    };
    let (surface, step) = state(grid)?;
    let mut current = (grid.clone(), surface);
    let mut best = current.clone();
    let size = grid.size;
    let mut report = RefineReport { history: vec![step], kept: 0, converged: false, unsupported: 0.0 };
    // A later state is preferred, being better relaxed, unless it has more defects.
    let worth = |s: &RefineStep| s.defects.self_loops + s.defects.crossovers;
    for k in 1..=options.max_iterations {
        let mut next = if options.equalise { current.0.equalised(&current.1) } else { current.0.clone() };
        if options.equalise {
            current = (next.clone(), next.surface()?);
        }
        let drawn = draw(&next, &current.1, cloud, frame, &options.directed);
        let held = |i: usize, j: usize| options.hold_boundary && is_boundary(size, i, j);
        relax(&mut next, &drawn, options.relaxation, &held);
        let (surface, step) = state(&next)?;
        current = (next, surface);
        let before = report.history[k - 1].rms;
        report.history.push(step);
        if worth(&step) <= worth(&report.history[report.kept]) {
            report.kept = k;
            best = current.clone();
        }
        if k >= 3 && (before - step.rms).abs() <= options.threshold * before {
            report.converged = true;
            break;
        }
    }
    // To unfold it moves the boundary, too.
    if worth(&report.history[report.kept]) > 0
        && !options.hold_boundary
        && let Some((grid, surface)) = unfolded(&best.0, &best.1, axes)?
    {
        report.kept = report.history.len();
        report.history.push(RefineStep {
            rms: cloud.rms(&supported(&grid, cloud)),
            defects: SurfaceDefects::default(),
        });
        best = (grid, surface);
    }
    report.unsupported = 1.0 - supported(&best.0, cloud).len() as f64 / best.0.points.len() as f64;
    Ok((best.0, best.1, report))
}

fn supported(grid: &SampleGrid, cloud: &Neighbourhood) -> Vec<Vector3<f64>> {
    let limit = FAR * cloud.pitch();
    let near = parallel::map(grid.points.len(), |k| cloud.distance(&grid.points[k]) <= limit);
    grid.points.iter().zip(near).filter(|(_, near)| *near).map(|(p, _)| *p).collect()
}

/// A place after projection, the direction along which it was projected, and whether there was something to be drawn to.
struct Drawn {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    supported: bool,
}

fn draw(
    grid: &SampleGrid,
    surface: &BsplineSurface,
    cloud: &Neighbourhood,
    frame: Option<&AxisFrame>,
    options: &DirectedOptions,
) -> Vec<Drawn> {
    let [u, v] = grid.parameters();
    let [_, n] = grid.size;
    let limit = FAR * cloud.pitch();
    parallel::map(grid.points.len(), |k| {
        let (i, j) = (k / n, k % n);
        let place = grid.points[k];
        let mut normal = surface.jet(u[i], v[j]).normal_direction();
        if let Some(frame) = frame.filter(|_| j == 0 || j + 1 == n) {
            normal -= frame.axes[2] * normal.dot(&frame.axes[2]);
        }
        let Some(normal) = normal.try_normalize(0.0) else {
            return Drawn { point: place, normal: Vector3::zeros(), supported: false };
        };
        if cloud.distance(&place) > limit {
            return Drawn { point: place, normal, supported: false };
        }
        let foot = project(cloud, &place, &normal, options);
        Drawn { point: place + normal * foot.offset.clamp(-limit, limit), normal, supported: true }
    })
}

fn is_boundary([m, n]: [usize; 2], i: usize, j: usize) -> bool {
    i == 0 || j == 0 || i + 1 == m || j + 1 == n
}

/// Moves places towards the middle of their neighbours: within the tangent plane where the cloud holds them, freely elsewhere. Those that are held stay.
fn relax(grid: &mut SampleGrid, drawn: &[Drawn], share: f64, held: &dyn Fn(usize, usize) -> bool) {
    let [m, n] = grid.size;
    for (k, (slot, drawn)) in grid.points.iter_mut().zip(drawn).enumerate() {
        if !held(k / n, k % n) {
            *slot = drawn.point;
        }
    }
    let old = grid.clone();
    for i in 0..m {
        for j in 0..n {
            let k = i * n + j;
            if held(i, j) {
                continue;
            }
            let Some([a, b]) = old.beside(i, j) else { continue };
            let middle = if j == 0 || j + 1 == n {
                (a + b) / 2.0
            } else {
                (a + b + old.at(i, j - 1) + old.at(i, j + 1)) / 4.0
            };
            let move_by = middle - old.points[k];
            let normal = drawn[k].normal;
            grid.points[k] += if drawn[k].supported {
                (move_by - normal * move_by.dot(&normal)) * share
            } else {
                move_by * share
            };
        }
    }
}
