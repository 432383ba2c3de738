//! What an IGES file holds: `cargo run -p cad-io --example iges_summary -- FILE`.

use brep_core::description::{Carrier, LoopDescription};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for file in std::env::args().skip(1) {
        let clock = Instant::now();
        let model = cad_io::read_iges_file(Path::new(&file))?;
        println!("{file}: `{}`, unit {:?}, {:?}", model.name, model.unit, clock.elapsed());
        for part in &model.parts {
            let mut kinds = BTreeMap::new();
            for face in &part.faces {
                let kind = match &face.carrier {
                    Carrier::Plane { .. } => "plane",
                    Carrier::Cylinder { .. } => "cylinder",
                    Carrier::Cone { .. } => "cone",
                    Carrier::Sphere { .. } => "sphere",
                    Carrier::Torus { .. } => "torus",
                    Carrier::Nurbs(surface) if surface.weights().is_some() => "rational B-spline",
                    Carrier::Nurbs(_) => "B-spline",
                };
                *kinds.entry(kind).or_insert(0) += 1;
            }
            let loops = part.faces.iter().flat_map(|face| &face.loops);
            let vertex_loops = loops.clone().filter(|l| matches!(l, LoopDescription::Vertex(_))).count();
            println!("  {} faces {kinds:?}, {} loops ({vertex_loops} points)", part.faces.len(), loops.count());
            println!("  {} edges, {} vertices, {} free curves", part.edges.len(), part.vertices.len(), part.curves.len());
        }
        for unread in &model.unread {
            println!("  left out: {} {}: {}", unread.source, unread.kind, unread.why);
        }
    }
    Ok(())
}
