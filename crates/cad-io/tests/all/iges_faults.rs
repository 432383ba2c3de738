//! Faults are told with line and entity, and never end in a panic.

use crate::iges_builder::Iges;

fn fault(text: &str) -> String {
    cad_io::read_iges(text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn faults_name_line_entity_and_cure() {
    let single = |kind: u32, values: &str| {
        let mut f = Iges::default();
        f.add(kind, values);
        fault(&f.text())
    };
    let cases = [
        (126, "2,2,0,0,0,0,0.,0.,0.,1.,1.", "the record ends before"),
        (126, "2,2,0,0,0,0,0.,0.,0.,1.,1.,x,1.,1.,1.,0.,0.,0.,1.,1.,1.,2.,2.,2.,0.,1.", "(knots) is `x`"),
        (126, "2,2,0,0,0,0,0.,0.,0.,2.,1.,1.,1.,1.,1.,0.,0.,0.,1.,1.,1.,2.,2.,2.,0.,1.", "knot 4"),
        (126, "2,2,0,0,0,0,0.,0.,0.,1.,1.,1.,1.,-1.,1.,0.,0.,0.,1.,1.,1.,2.,2.,2.,0.,1.", "weight 1 is -1"),
        (126, "999999999,2,0,0,0,0", "too short"),
        (128, "99999,99999,3,3,0,0,1,0,0,0.", "too short"),
        (110, "0.,0.,0.,1E999,0.,0.", "which is no finite number"),
        (100, "0.,0.,0.,0.,0.,1.,1.", "radius of the arc is 0"),
        (102, "1,1", "circle"),
        (102, "2,7,9", "directory entries are the odd numbers up to 1"),
        (186, "1,1,0", "must be of type 514"),
    ];
    for (kind, values, what) in cases {
        let found = single(kind, values);
        assert!(found.contains(what) && found.contains("entity 1"), "{kind},{values}: {found}");
        assert!(found.contains("line ") && found.contains("export"), "{found}");
    }
}

#[test]
fn unread_types_are_listed_and_do_not_spoil_the_rest() {
    let mut f = Iges::default();
    f.add(110, "0.,0.,0.,1.,0.,0.");
    let offset = f.add_with(140, 0, "00010000", 0, "0.,0.,1.,1.,1");
    let line = f.add_with(110, 0, "00010000", 0, "0.,0.,0.,1.,0.,0.");
    let boundary = f.add_with(142, 0, "00010000", 0, &format!("0,{offset},0,{line},2"));
    let face = f.add(144, &format!("{offset},1,0,{boundary}"));
    let instance = f.add(408, "1,0.,0.,0.,1.");
    let model = cad_io::read_iges(f.text().as_bytes()).unwrap();
    assert_eq!(
        (model.parts[0].curves.len(), model.parts[0].faces.len(), model.parts[0].edges.len()),
        (1, 0, 0)
    );
    let found: Vec<(u64, &str)> = model.unread.iter().map(|u| (u.source, u.kind.as_str())).collect();
    assert_eq!(found, [(face as u64, "type 144"), (instance as u64, "type 408")]);
    assert!(model.unread[0].why.contains("type 140"), "{:?}", model.unread);
}

#[test]
fn the_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.igs");
    let error = cad_io::read_iges_file(&path).unwrap_err().to_string();
    assert!(error.contains("bad.igs: cannot read"), "{error}");
    let mut f = Iges::default();
    f.add(110, "0.,0.,0.,1.,0.,q");
    std::fs::write(&path, f.text()).unwrap();
    let error = cad_io::read_iges_file(&path).unwrap_err().to_string();
    assert!(error.contains("bad.igs:5: entity 1: type 110: parameter 6"), "{error}");
}
