//! Lists what STEP files hold: `cargo run -p cad-io --features step --example list_faces -- FILE…`

use brep_core::description::Carrier;
use std::time::Instant;

fn main() {
    for path in std::env::args().skip(1) {
        let start = Instant::now();
        match cad_io::read_step_file(path.as_ref()) {
            Err(error) => println!("{error}"),
            Ok(model) => {
                let count = |f: &dyn Fn(&Carrier) -> bool| -> usize {
                    model
                        .instances
                        .iter()
                        .map(|i| model.parts[i.part].faces.iter().filter(|x| f(&x.carrier)).count())
                        .sum()
                };
                println!(
                    "{path}: {:.3} s, unit {:?}, uncertainty {:?}, {} parts, {} instances, {} faces distinct, {} placed, {} nurbs, {} rational",
                    start.elapsed().as_secs_f64(),
                    model.unit,
                    model.uncertainty,
                    model.parts.len(),
                    model.instances.len(),
                    model.parts.iter().map(|p| p.faces.len()).sum::<usize>(),
                    count(&|_| true),
                    count(&|c| matches!(c, Carrier::Nurbs(_))),
                    count(&|c| matches!(c, Carrier::Nurbs(s) if s.weights().is_some())),
                );
                for unread in &model.unread {
                    println!("    #{} {}: {}", unread.source, unread.kind, unread.why);
                }
            }
        }
    }
}
