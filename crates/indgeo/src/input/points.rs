//! The points to be projected.

use crate::error::Error;
use crate::files;
use crate::report::wording::counted;
use industrial_geometry::io::{Content, Piece, ReadOptions, ReadReport};
use industrial_geometry::mesh::nalgebra::{Point3, Vector2, Vector3};
use industrial_geometry::mesh::{BoundingBox, TextField};
use std::ops::Range;
use std::path::Path;

/// Makes sure that a file held a point that is finite.
pub(crate) fn check_counts(path: &Path, report: &ReadReport) -> Result<(), Error> {
    check_numbers(path, report.points, report.non_finite)
}

/// The same with the numbers of points, and of those that are not finite.
pub(crate) fn check_numbers(path: &Path, points: usize, non_finite: usize) -> Result<(), Error> {
    if points == 0 {
        return Err(Error::content(path, "there are no points in this file", "export it again"));
    }
    if non_finite == points {
        let what = format!("no point has finite coordinates ({})", counted(points, "point"));
        return Err(Error::content(path, what, "export the file again"));
    }
    Ok(())
}

/// Points with the triangles over them, as read.
#[derive(Debug)]
pub(crate) struct Points {
    /// Positions; z = 0 where the file has two columns.
    pub(crate) positions: Vec<Point3<f64>>,
    /// Normals, if the file has them.
    pub(crate) normals: Option<Vec<Vector3<f64>>>,
    /// Names, if the file has them.
    pub(crate) names: Option<TextField>,
    /// Whether the file has two columns.
    pub(crate) is_planar: bool,
    /// Triangles over the points, if the file is a mesh.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// How reading went.
    pub(crate) report: ReadReport,
}

impl Points {
    /// Reads a cloud, or the vertices of a mesh, of a file of several scans all or the one that is named; there must be at least
    /// one finite point.
    pub(crate) fn read(path: &Path, drop_non_finite: bool, scan: Option<&str>) -> Result<Self, Error> {
        let options = ReadOptions::default().with_drop_non_finite(drop_non_finite);
        let loaded = files::read(path, &options.with_scan(scan.map(str::to_owned)))?;
        let report = loaded.report;
        let (cloud, triangles) = match loaded.content {
            Content::Cloud(cloud) => (cloud, Vec::new()),
            Content::Mesh(mesh) => mesh.into_parts(),
            Content::Nurbs(_) => {
                let what = "points are needed, but this file holds NURBS shapes";
                return Err(Error::content(path, what, "the order is MODEL POINTS"));
            }
        };
        check_counts(path, &report)?;
        let is_planar = cloud.dimension() == 2;
        let (positions, mut attributes) = cloud.into_parts();
        let normals = attributes.take_normals();
        let names = attributes.names().cloned();
        Ok(Self { positions, normals, names, is_planar, triangles, report })
    }

    /// Some points of a file, with normals if they are needed.
    pub(crate) fn of_piece(piece: Piece, with_normals: bool, report: &ReadReport) -> Self {
        Self {
            positions: piece.positions,
            normals: piece.normals.filter(|_| with_normals),
            names: None,
            is_planar: false,
            triangles: Vec::new(),
            report: report.clone(),
        }
    }

    /// Leaves the points whose places are in `range`, without those that are not finite if `drop` says so, and without triangles.
    pub(crate) fn cut(&mut self, range: &Range<u64>, drop: bool) {
        let place = |number: u64| usize::try_from(number).unwrap_or(usize::MAX).min(self.positions.len());
        let wanted = place(range.start)..place(range.end);
        let is_finite = |index: &usize| self.positions[*index].iter().all(|value| value.is_finite());
        let finite = wanted.clone().filter(is_finite).count();
        self.report.points = wanted.len();
        self.report.non_finite = wanted.len() - finite;
        self.report.dropped = if drop { self.report.non_finite } else { 0 };
        let kept: Vec<usize> = wanted.filter(|index| !drop || is_finite(index)).collect();
        if let Some(normals) = &self.normals {
            self.normals = Some(kept.iter().map(|&index| normals[index]).collect());
        }
        if let Some(names) = &self.names {
            let mut own = TextField::new(names.name());
            kept.iter().for_each(|&index| own.push(names.get(index).unwrap_or_default()));
            self.names = Some(own);
        }
        self.positions = kept.iter().map(|&index| self.positions[index]).collect();
        self.triangles.clear();
    }

    /// Diagonal of the box of the finite points.
    pub(crate) fn diagonal(&self) -> f64 {
        BoundingBox::of(&self.positions).map_or(0.0, |bounds| bounds.diagonal())
    }

    /// The name of the point at `index`, if it has one.
    pub(crate) fn name(&self, index: usize) -> Option<&str> {
        self.names.as_ref()?.get(index).filter(|name| !name.is_empty())
    }

    /// The points in the plane, for a model in the plane.
    pub(crate) fn in_plane(&self, path: &Path) -> Result<Vec<Vector2<f64>>, Error> {
        self.check_plane(path)?;
        Ok(self.positions.iter().map(|point| point.coords.xy()).collect())
    }

    /// Makes sure that the points fit a model in the plane.
    pub(crate) fn check_plane(&self, path: &Path) -> Result<(), Error> {
        let off_plane = self.positions.iter().position(|point| point.z != 0.0);
        if let Some(index) = off_plane.filter(|_| !self.is_planar) {
            let what = format!(
                "the model lies in the plane, but point {index} (from 0) has z = {}",
                self.positions[index].z
            );
            return Err(Error::content(path, what, "give points of two columns, x and y, or with z = 0"));
        }
        Ok(())
    }

    /// The points in space, for a model in space.
    pub(crate) fn in_space(&self, path: &Path) -> Result<Vec<Vector3<f64>>, Error> {
        self.check_space(path)?;
        Ok(self.positions.iter().map(|point| point.coords).collect())
    }

    /// Makes sure that the points fit a model in space.
    pub(crate) fn check_space(&self, path: &Path) -> Result<(), Error> {
        if self.is_planar {
            let what = "the model lies in space, but the points have two columns only";
            return Err(Error::content(path, what, "give points of three columns, x, y and z"));
        }
        Ok(())
    }
}
