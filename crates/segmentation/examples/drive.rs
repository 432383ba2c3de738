//! x
use segmentation::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let read = |p: &str| -> Vec<f64> { std::fs::read(p).unwrap().chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect() };
    let p: Vec<_> = read(&a[1]).chunks(3).map(|c| nalgebra::Point3::new(c[0], c[1], c[2])).collect();
    let n: Vec<_> = read(&a[1].replace(".bin", ".nrm")).chunks(3).map(|c| nalgebra::Vector3::new(c[0], c[1], c[2])).collect();
    let n = if std::env::var("NONRM").is_ok() { None } else { Some(&n[..]) };
    let s = segment(&p, n, &SegmentationOptions::default()).unwrap();
    eprintln!("{s}");
    std::fs::write(&a[2], s.labels.iter().flat_map(|x| x.map_or(-1, |l| l as i32).to_le_bytes()).collect::<Vec<u8>>()).unwrap();
    let v = |p: &[f64]| format!("[{},{},{}]", p[0], p[1], p[2]);
    let parts: Vec<String> = s.regions.iter().map(|r| {
        let more = match &r.shape {
            Shape::Plane { point, normal } => format!("\"point\":{},\"normal\":{}", v(point.coords.as_slice()), v(normal.as_slice())),
            Shape::Sphere { point, radius } => format!("\"point\":{},\"radius\":{radius}", v(point.coords.as_slice())),
            Shape::Cylinder { point, axis, radius } => format!("\"point\":{},\"axis\":{},\"radius\":{radius}", v(point.coords.as_slice()), v(axis.as_slice())),
            Shape::Cone { point, axis, half_angle } => format!("\"point\":{},\"axis\":{},\"half_angle\":{half_angle}", v(point.coords.as_slice()), v(axis.as_slice())),
            Shape::Torus { point, axis, radius, minor_radius } => format!("\"point\":{},\"axis\":{},\"radius\":{radius},\"minor_radius\":{minor_radius}", v(point.coords.as_slice()), v(axis.as_slice())),
            Shape::Extrusion { axis } => format!("\"axis\":{}", v(axis.as_slice())),
            Shape::Revolution { point, axis } => format!("\"point\":{},\"axis\":{}", v(point.coords.as_slice()), v(axis.as_slice())),
            Shape::Helix { point, axis, pitch } => format!("\"point\":{},\"axis\":{},\"pitch\":{}", v(point.coords.as_slice()), v(axis.as_slice()), pitch.abs()),
            _ => "\"z\":0".into(),
        };
        format!("{{\"label\":{},\"type\":\"{}\",\"rms\":{},{more}}}", r.label, r.shape.name(), r.rms)
    }).collect();
    std::fs::write(&a[3], format!("{{\"primitives\":[{}]}}", parts.join(","))).unwrap();
}
