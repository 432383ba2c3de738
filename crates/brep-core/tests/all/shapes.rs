//! Descriptions of solids whose distance is known in closed form.

use brep_core::Model;
use brep_core::description::{
    Carrier, EdgeCurve, EdgeDescription, EdgeUse, FaceDescription, InstanceDescription, LengthUnit,
    LoopDescription, ModelDescription, PartDescription, Placement, ShellDescription, VertexDescription,
};
use nalgebra::{Matrix3, Rotation3, Vector3};
use nurbs_core::Frame;
use std::f64::consts::TAU;

/// Builds descriptions edge by edge.
#[derive(Default)]
pub(crate) struct Builder {
    pub(crate) part: PartDescription,
}

impl Builder {
    pub(crate) fn vertex(&mut self, point: Vector3<f64>) -> usize {
        self.part.vertices.push(VertexDescription { source: self.part.vertices.len() as u64 + 1000, point });
        self.part.vertices.len() - 1
    }

    pub(crate) fn edge(&mut self, curve: EdgeCurve, range: [f64; 2], ends: [usize; 2]) -> usize {
        let source = self.part.edges.len() as u64 + 100;
        self.part.edges.push(EdgeDescription {
            source,
            curve,
            range,
            start: Some(ends[0]),
            end: Some(ends[1]),
        });
        self.part.edges.len() - 1
    }

    pub(crate) fn line(&mut self, a: usize, b: usize) -> usize {
        let [p, q] = [a, b].map(|i| self.part.vertices[i].point);
        let direction = q - p;
        self.edge(EdgeCurve::Line { origin: p, direction }, [0.0, 1.0], [a, b])
    }

    /// A whole circle around `z` at height `z`, counterclockwise seen from above.
    pub(crate) fn circle(&mut self, radius: f64, z: f64, start: f64) -> usize {
        let frame = Frame::new(Vector3::new(0.0, 0.0, z), Vector3::z(), Vector3::x()).unwrap();
        let curve = EdgeCurve::Circle { frame, radius };
        let vertex = self.vertex(curve.point(start));
        self.edge(curve, [start, start + TAU], [vertex, vertex])
    }

    pub(crate) fn face(&mut self, carrier: Carrier, same_sense: bool, loops: &[&[(usize, bool)]]) {
        let loops = loops
            .iter()
            .map(|uses| {
                let uses = uses.iter().map(|&(edge, forward)| EdgeUse { edge, forward, pcurve: None });
                LoopDescription::Edges(uses.collect())
            })
            .collect();
        let source = self.part.faces.len() as u64 + 1;
        let name = format!("face {source}");
        self.part.faces.push(FaceDescription { name, source, carrier, same_sense, loops });
    }

    pub(crate) fn description(mut self, closed: bool) -> ModelDescription {
        let faces = (0..self.part.faces.len()).collect();
        self.part.shells.push(ShellDescription { name: "shell".to_owned(), source: 99, faces, closed });
        ModelDescription {
            unit: Some(LengthUnit::millimetre()),
            parts: vec![self.part],
            instances: vec![InstanceDescription {
                part: 0,
                name: String::new(),
                placement: Placement::IDENTITY,
            }],
            ..ModelDescription::default()
        }
    }

    pub(crate) fn model(self) -> Model {
        Model::new(&self.description(true)).unwrap()
    }
}

/// A frame at `(0, 0, z)` whose axis is `sign · z`, turned about it.
pub(crate) fn frame(z: f64, sign: f64, turn: f64) -> Frame {
    let x = Vector3::new(turn.cos(), turn.sin(), 0.0);
    Frame::new(Vector3::new(0.0, 0.0, z), Vector3::z() * sign, x).unwrap()
}

/// A disc at height `z` whose normal points along `sign · z`.
pub(crate) fn disc(b: &mut Builder, circle: usize, z: f64, sign: f64) {
    let plane = Carrier::Plane { frame: frame(z, 1.0, 0.3) };
    b.face(plane, sign > 0.0, &[&[(circle, sign > 0.0)]]);
}

/// The box `[0, a] × [0, b] × [0, c]`.
pub(crate) fn cuboid(size: [f64; 3]) -> Builder {
    let mut b = Builder::default();
    let corner = |k: usize| Vector3::from_fn(|i, _| if k >> i & 1 == 1 { size[i] } else { 0.0 });
    for k in 0..8 {
        b.vertex(corner(k));
    }
    let mut edges = std::collections::HashMap::new();
    for k in 0..8usize {
        for i in 0..3 {
            if k >> i & 1 == 0 {
                let e = b.line(k, k | 1 << i);
                edges.insert((k, k | 1 << i), e);
            }
        }
    }
    for i in 0..3usize {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        for side in 0..2usize {
            let base = side << i;
            let mut ring = [base, base | 1 << j, base | 1 << j | 1 << k, base | 1 << k];
            if side == 0 {
                ring.reverse();
            }
            let uses: Vec<_> = (0..4)
                .map(|n| {
                    let (p, q) = (ring[n], ring[(n + 1) % 4]);
                    edges.get(&(p, q)).map_or_else(|| (edges[&(q, p)], false), |e| (*e, true))
                })
                .collect();
            let normal = Vector3::ith(i, 1.0);
            let plane = Frame::new(corner(base), normal, Vector3::ith(j, 1.0)).unwrap();
            b.face(Carrier::Plane { frame: plane }, side == 1, &[&uses]);
        }
    }
    b
}

/// Points in a box around the origin, always the same.
pub(crate) fn points(count: usize, size: f64) -> Vec<Vector3<f64>> {
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
    };
    (0..count).map(|_| Vector3::new(next(), next(), next()) * size).collect()
}

/// A placement that moves and turns.
pub(crate) fn moved(scale: f64) -> Placement {
    let rotation: Matrix3<f64> = Rotation3::from_euler_angles(0.3, -0.8, 1.9).into_inner();
    Placement { rotation, translation: Vector3::new(10.0, -3.0, 5.0), scale }
}
