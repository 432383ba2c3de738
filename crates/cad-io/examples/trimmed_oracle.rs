//! Measures distances and areas against tables: `… --example trimmed_oracle -- FILE.step ORACLE.csv|- AREAS.csv|- [RESULT.csv]`
//!
//! The tables are in millimetres.

use brep_core::Model;
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::time::Instant;

fn table(path: &str) -> Result<Vec<Vec<String>>, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(path)?;
    Ok(text.lines().skip(1).map(|l| l.split(',').map(str::to_owned).collect()).collect())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let start = Instant::now();
    let description = cad_io::read_step_file(args[0].as_ref())?;
    let read = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let model = Model::new(&description)?;
    let built = start.elapsed().as_secs_f64();
    let scale = model.unit().map_or(1.0, |unit| unit.metres * 1e3);
    let diagonal = model.bounds().diagonal() * scale;
    let tolerance = model.parts().iter().flat_map(|p| p.edges()).map(|e| e.tolerance()).fold(0.0, f64::max);
    println!(
        "{}: read {read:.3} s, built {built:.3} s, diagonal {diagonal:.4}, largest edge tolerance {:.3e}, unread {}",
        args[0],
        tolerance * scale,
        model.unread().len()
    );
    for unread in model.unread().iter().take(5) {
        println!("    #{} {}: {}", unread.source, unread.kind, unread.why);
    }
    if args[1] != "-" {
        let rows = table(&args[1])?;
        let number = |row: &Vec<String>, i: usize| row[i].parse::<f64>().unwrap_or(f64::NAN);
        let points: Vec<_> =
            rows.iter().map(|r| Vector3::new(number(r, 0), number(r, 1), number(r, 2)) / scale).collect();
        let start = Instant::now();
        let feet: Vec<_> = points.iter().map(|p| model.nearest(p)).collect();
        let each = start.elapsed().as_secs_f64() / points.len() as f64;
        let (mut wrong, mut edges, mut sides, mut undecided, mut sided, mut open) = (0, 0, 0, 0, 0, 0);
        let mut gap = 0f64;
        let mut result = "distance\n".to_owned();
        for (i, (row, foot)) in rows.iter().zip(&feet).enumerate() {
            let foot = foot.as_ref().ok_or("no foot")?;
            let (expected, uncertainty) = (number(row, 3), number(row, 4));
            let allowed = (2.0 * uncertainty).max(1e-7 * diagonal);
            let off = (foot.distance * scale - expected).abs();
            if off > allowed {
                wrong += 1;
                edges += usize::from(row[6] == "edge");
                println!(
                    "    row {i} {} {}: {expected} expected, {} found, off {off:.2e}, {:?}",
                    row[5],
                    row[6],
                    foot.distance * scale,
                    foot.on
                );
            }
            let own = foot.gap() * scale;
            gap = gap.max(own);
            open += usize::from(own > 1e-7 * diagonal);
            if row[10] != "0" && expected > allowed {
                sided += 1;
                match foot.signed_distance() {
                    None => undecided += 1,
                    Some(d) if (d > 0.0) != (row[10] == "1") => {
                        sides += 1;
                        println!("    row {i}: side {} expected, {d} {:?}", row[10], foot.on);
                        for instance in model.instances() {
                            let own = model.parts()[instance.part]
                                .nearest(&instance.placement.inverse_point(&points[i]));
                            println!(
                                "        part {}: {:?}",
                                instance.part,
                                own.map(|f| (f.distance, f.side, f.on))
                            );
                        }
                    }
                    _ => {}
                }
            }
            writeln!(result, "{}", foot.signed_distance().unwrap_or(foot.distance) * scale)?;
        }
        println!(
            "  {} points: {wrong} wrong ({edges} on edges), sides {sides} wrong {undecided} undecided of {sided}, \
             largest gap {gap:.2e}, {open} above 1e-7 of the diagonal, {:.4} ms each",
            rows.len(),
            each * 1e3
        );
        if let Some(path) = args.get(3) {
            std::fs::write(path, result)?;
        }
    }
    if args[2] != "-" {
        let start = Instant::now();
        let mut own: Vec<(f64, u64)> = Vec::new();
        for instance in model.instances() {
            let part = &model.parts()[instance.part];
            own.extend(
                (0..part.faces().len()).map(|f| (part.area(f) * scale * scale, part.faces()[f].source())),
            );
        }
        let seconds = start.elapsed().as_secs_f64();
        let rows = table(&args[2])?;
        let (mut bad, mut worst) = (0, 0f64);
        println!("  areas: {} own, {} expected, {seconds:.2} s", own.len(), rows.len());
        // Each row takes the face whose area is next to its own.
        for row in &rows {
            let number = |i: usize| row[i].parse::<f64>().unwrap_or(f64::NAN);
            let off = |found: &(f64, u64)| (found.0 - number(0)).abs();
            let Some(at) = (0..own.len()).min_by(|a, b| off(&own[*a]).total_cmp(&off(&own[*b]))) else {
                break;
            };
            let (allowed, off) = (1e-6 * number(0) + number(4) * number(3), off(&own[at]));
            if off > allowed {
                bad += 1;
                println!("    #{}: {} ({}) expected, {} found", own[at].1, row[0], row[1], own[at].0);
            } else {
                worst = worst.max(off / number(0));
                own.swap_remove(at);
            }
        }
        for (area, source) in own {
            println!("    #{source}: {area} has no counterpart");
        }
        println!("  areas: {bad} of {} wrong, worst relative {worst:.2e}", rows.len());
    }
    Ok(())
}
