//! One scan among several.

use std::collections::BTreeSet;

use mesh_core::{CloudIndex, PointCloud, TriangleMesh};
use nalgebra::{Point3, Vector3};
use nurbs_core::Aabb;

use super::surface::{Degree, LocalSurface};
use crate::start::random::Random;
use crate::{Error, parallel};

/// Points of a scan in a frame of its own, with normals or without.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct View {
    points: Vec<Vector3<f64>>,
    normals: Option<Vec<Vector3<f64>>>,
    dropped: usize,
}

impl View {
    /// A scan without normals. Points that are not finite are left out.
    #[must_use]
    pub fn new(points: &[Vector3<f64>]) -> Self {
        let finite: Vec<_> = points.iter().copied().filter(|x| x.iter().all(|c| c.is_finite())).collect();
        Self { dropped: points.len() - finite.len(), points: finite, normals: None }
    }

    /// A scan with normals of any length. Points or normals that are not finite are left out.
    ///
    /// # Errors
    /// [`Error::Length`] if there is not one normal per point.
    pub fn with_normals(points: &[Vector3<f64>], normals: &[Vector3<f64>]) -> Result<Self, Error> {
        if points.len() != normals.len() {
            return Err(Error::Length { what: "normals", found: normals.len(), points: points.len() });
        }
        let finite = |x: &Vector3<f64>| x.iter().all(|c| c.is_finite());
        let (kept, normals): (Vec<_>, Vec<_>) =
            points.iter().zip(normals).filter(|(x, n)| finite(x) && finite(n)).map(|(x, n)| (*x, *n)).unzip();
        Ok(Self { dropped: points.len() - kept.len(), points: kept, normals: Some(normals) })
    }

    /// The points of a cloud, with its normals if it has some.
    ///
    /// # Errors
    /// [`Error::Length`] if there is not one normal per point.
    pub fn from_cloud(cloud: &PointCloud) -> Result<Self, Error> {
        let points: Vec<_> = cloud.positions().iter().map(|x| x.coords).collect();
        match cloud.attributes().normals() {
            Some(normals) => Self::with_normals(&points, normals),
            None => Ok(Self::new(&points)),
        }
    }

    /// The vertices of a mesh, such as a triangulated scan, with the mean normals of the faces around them. Vertices of no
    /// triangle are left out.
    ///
    /// Faces between far vertices count for nothing: a mesh of a construction is to be sampled first.
    #[must_use]
    pub fn from_mesh(mesh: &TriangleMesh) -> Self {
        let mut sums = vec![Vector3::zeros(); mesh.vertices().len()];
        for (index, triangle) in mesh.triangles().iter().enumerate() {
            let Some([a, b, c]) = mesh.corners(index) else { continue };
            let area = (b - a).cross(&(c - a));
            if area.iter().all(|value| value.is_finite()) {
                for &vertex in triangle {
                    sums[vertex as usize] += area;
                }
            }
        }
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        for (vertex, sum) in mesh.vertices().iter().zip(&sums) {
            if sum.norm_squared() > 0.0 && vertex.iter().all(|c| c.is_finite()) {
                points.push(vertex.coords);
                normals.push(*sum);
            }
        }
        Self { dropped: mesh.vertices().len() - points.len(), points, normals: Some(normals) }
    }

    /// The points that are used.
    #[must_use]
    pub fn points(&self) -> &[Vector3<f64>] {
        &self.points
    }

    /// The normals, if there are some.
    #[must_use]
    pub fn normals(&self) -> Option<&[Vector3<f64>]> {
        self.normals.as_deref()
    }

    /// Number of points that were left out.
    #[must_use]
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// The box around the points; `None` if there are none.
    #[must_use]
    pub fn bounding_box(&self) -> Option<Aabb<3>> {
        Aabb::of_points(&self.points)
    }
}

/// Points of a view that are asked for the degree of its surfaces.
const ASKED: usize = 100;

/// A view in its centred and scaled frame, with a search tree and the surfaces that were asked for.
#[derive(Debug)]
pub(crate) struct Prepared {
    pub(crate) points: Vec<Point3<f64>>,
    normals: Option<Vec<Vector3<f64>>>,
    index: CloudIndex<3>,
    neighbours: usize,
    degree: Degree,
    surfaces: Vec<Option<LocalSurface>>,
    fitted: Vec<bool>,
    /// Indices of the points that are matched with other views, in random order: a part of them is a fair choice.
    pub(crate) sample: Vec<usize>,
    pub(crate) radius: f64,
    pub(crate) bounds: Aabb<3>,
}

impl Prepared {
    pub(crate) fn new(
        view: &View,
        centre: &Vector3<f64>,
        scale: f64,
        neighbours: usize,
        sample: usize,
        seed: u64,
    ) -> Result<Self, Error> {
        let points: Vec<Point3<f64>> =
            view.points.iter().map(|x| Point3::from((x - centre) / scale)).collect();
        let index = CloudIndex::new(&points).map_err(|_| Error::Length {
            what: "indices",
            found: u32::MAX as usize,
            points: points.len(),
        })?;
        let mut order: Vec<usize> = (0..points.len()).collect();
        Random::new(seed).shuffle_front(&mut order, sample);
        order.truncate(sample);
        let bounds =
            points.iter().fold(Aabb::of_point(Vector3::zeros()), |bounds, x| bounds.with_point(&x.coords));
        let radius = points.iter().map(|x| x.coords.norm()).fold(0.0, f64::max);
        let mut prepared = Self {
            normals: view.normals.clone(),
            index,
            neighbours,
            degree: Degree::Four,
            surfaces: vec![None; points.len()],
            fitted: vec![false; points.len()],
            points,
            sample: order,
            radius,
            bounds,
        };
        prepared.degree = prepared.degree_of_points();
        Ok(prepared)
    }

    /// Degree four if most of some points ask for it: one for the whole view, since where noise decides, surfaces next to each
    /// other do not agree.
    fn degree_of_points(&self) -> Degree {
        let asked = &self.sample[..self.sample.len().min(ASKED)];
        let surfaces = parallel::tasks(asked.len(), |k| self.fit_one(asked[k]));
        let quartic = surfaces.iter().flatten().filter(|surface| surface.is_quartic()).count();
        if 2 * quartic > asked.len() { Degree::Four } else { Degree::Three }
    }

    /// Index of the point nearest to `x`.
    pub(crate) fn nearest(&self, x: &Vector3<f64>) -> Option<usize> {
        self.index.nearest(&Point3::from(*x)).map(|found| found.index)
    }

    /// The surface around a point, if it was asked for and there is one.
    pub(crate) fn surface(&self, index: usize) -> Option<&LocalSurface> {
        self.surfaces[index].as_ref()
    }

    /// Fits the surfaces around points where this was not done before.
    pub(crate) fn fit(&mut self, wanted: impl Iterator<Item = usize>) {
        let missing: BTreeSet<usize> = wanted.filter(|&index| !self.fitted[index]).collect();
        let missing: Vec<usize> = missing.into_iter().collect();
        let surfaces = parallel::tasks(missing.len(), |k| self.fit_one(missing[k]));
        for (index, surface) in missing.into_iter().zip(surfaces) {
            self.surfaces[index] = surface;
            self.fitted[index] = true;
        }
    }

    fn fit_one(&self, index: usize) -> Option<LocalSurface> {
        let centre = self.points[index];
        let near = self.index.nearest_n(&centre, self.neighbours);
        let neighbours: Vec<_> = near.iter().map(|found| self.points[found.index].coords).collect();
        let surface = LocalSurface::fit(&centre.coords, &neighbours, self.degree)?;
        Some(match &self.normals {
            Some(normals) => surface.oriented(&normals[index]),
            None => surface,
        })
    }
}
