//! Clouds and models to be registered.

use industrial_geometry::io::{self, ReadOptions, Shape};
use industrial_geometry::mesh::nalgebra::{Quaternion, UnitQuaternion, Vector3};
use industrial_geometry::nurbs::ParametricSurface;
use industrial_geometry::register::Pose;
use industrial_geometry::register::start::OrientedPoints;
use std::error::Error;
use std::path::Path;

/// Random numbers for displacements, the same on every run.
pub(crate) struct Generator(u64);

impl Generator {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (mixed >> 11) as f64 / (1u64 << 53) as f64
    }

    fn gauss(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (std::f64::consts::TAU * self.unit()).cos()
    }

    fn gauss_vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.gauss())
    }

    /// A rotation drawn evenly from all, and a shift.
    pub(crate) fn motion(&mut self) -> Pose<3> {
        let turn = Quaternion::new(self.gauss(), self.gauss(), self.gauss(), self.gauss());
        let turn = UnitQuaternion::new_normalize(turn).to_rotation_matrix().into_inner();
        Pose::new(turn, self.gauss_vector() * 5.0)
    }
}

/// What is done to the cloud before it is displaced.
#[derive(Clone, Copy, Default)]
pub(crate) struct Damage {
    /// Percentage of the cloud that is cut off by a random plane.
    pub(crate) missing: usize,
    /// Percentage of outliers in the box around the cloud, in the end.
    pub(crate) outliers: usize,
    /// Noise, in diameters.
    pub(crate) noise: f64,
}

pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) model: OrientedPoints,
    pub(crate) diameter: f64,
    source: OrientedPoints,
    core: usize,
    /// Takes the source to the frame of the model.
    pub(crate) truth: Pose<3>,
    damage: Damage,
}

impl Case {
    /// Points, normals, and how many of the first points belong to the model.
    pub(crate) fn cloud(&self, random: &mut Generator) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>, usize) {
        let Damage { missing, outliers, noise } = self.damage;
        let direction = random.gauss_vector().normalize();
        let mut heights: Vec<f64> =
            self.source.points()[..self.core].iter().map(|x| x.dot(&direction)).collect();
        heights.sort_by(f64::total_cmp);
        let cut = heights[(heights.len() - 1) * missing / 100];
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        let mut core = 0;
        for (i, (x, n)) in self.source.points().iter().zip(self.source.normals()).enumerate() {
            if x.dot(&direction) >= cut {
                points.push(x + random.gauss_vector() * (noise * self.diameter));
                normals.push((n + random.gauss_vector() * (20.0 * noise)).normalize());
                core += usize::from(i < self.core);
            }
        }
        if let Some(bounds) = self.source.bounding_box() {
            let count = points.len() * outliers / (100 - outliers);
            for _ in 0..count {
                let inside = Vector3::from_fn(|_, _| random.unit()).component_mul(&bounds.sides());
                points.push(bounds.min + inside);
                normals.push(random.gauss_vector().normalize());
            }
        }
        (points, normals, core)
    }

    fn damaged(&self, name: &str, damage: Damage) -> Self {
        Self {
            name: format!("{} {name}", self.name),
            model: self.model.clone(),
            source: self.source.clone(),
            damage,
            ..*self
        }
    }

    fn variants(self) -> Vec<Self> {
        let half = Damage { missing: 50, ..Damage::default() };
        let outliers = Damage { outliers: 50, ..Damage::default() };
        let bad = Damage { missing: 50, outliers: 30, noise: 2e-3 };
        let damaged = [("half", half), ("50% outliers", outliers), ("half, 30% out., noise", bad)];
        let mut all: Vec<Self> = damaged.map(|(name, damage)| self.damaged(name, damage)).into();
        all.insert(0, self);
        all
    }
}

/// A case from a folder.
pub(crate) fn read(folder: &Path) -> Result<Case, Box<dyn Error>> {
    let text = std::fs::read_to_string(folder.join("case.json"))?;
    let json: serde_json::Value = serde_json::from_str(&text)?;
    let model_file = json["model"].as_str().ok_or("no model")?;
    let model = io::read_model(folder.join(model_file), &ReadOptions::default())?.content;
    let surfaces: Vec<&dyn ParametricSurface> = model
        .shapes()
        .iter()
        .filter_map(|shape| match shape {
            Shape::Surface(surface) => Some(surface as &dyn ParametricSurface),
            _ => None,
        })
        .collect();
    let source = io::read_cloud(folder.join("source.ply"), &ReadOptions::default())?.content;
    // The best fit, where the cloud deviates from the model.
    let truth = if json["T_ref"].is_array() { &json["T_ref"] } else { &json["T_gt"] };
    let entry = |i: usize, j: usize| truth[i][j].as_f64().unwrap_or(f64::NAN);
    let rows = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| entry(i, j)));
    let whole = usize::try_from(json["core_mask"].as_u64().ok_or("no core_mask")?)?;
    Ok(Case {
        name: json["name"].as_str().unwrap_or("?").into(),
        model: OrientedPoints::from_surfaces(&surfaces, 20_000),
        diameter: json["diam"].as_f64().ok_or("no diam")?,
        core: whole.min(source.len()),
        source: OrientedPoints::from_cloud(&source)?,
        truth: Pose::<3>::from_row_major(&rows)?,
        damage: Damage::default(),
    })
}

/// The bunny and shapes that are made up.
pub(crate) fn built_in() -> Result<Vec<Case>, Box<dyn Error>> {
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/mesh");
    let mut all = Vec::new();
    for name in ["bunny", "teapot"] {
        let mesh = io::read_mesh(mesh.join(name).with_extension("obj"), &ReadOptions::default())?.content;
        let diameter = mesh.bounding_box().ok_or("empty mesh")?.diagonal();
        let source = OrientedPoints::from_mesh(&mesh, 7001);
        let model = OrientedPoints::from_mesh(&mesh, 20_000);
        let case = Case {
            name: name.into(),
            core: source.len(),
            model,
            diameter,
            source,
            truth: Pose::identity(),
            damage: Damage::default(),
        };
        all.extend(case.variants());
    }
    Ok(all)
}
