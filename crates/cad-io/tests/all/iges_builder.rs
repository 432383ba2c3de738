//! Small IGES files, entity by entity.

/// A file that is put together.
#[derive(Default)]
pub(crate) struct Iges {
    /// Entity type, form, status and matrix, and parameter data after the type.
    entities: Vec<(u32, i32, &'static str, usize, String)>,
}

impl Iges {
    /// Adds an entity and returns its directory number.
    pub(crate) fn add(&mut self, kind: u32, values: &str) -> usize {
        self.add_with(kind, 0, "00000000", 0, values)
    }

    /// Adds an entity with its form, status number and matrix.
    pub(crate) fn add_with(
        &mut self,
        kind: u32,
        form: i32,
        status: &'static str,
        matrix: usize,
        values: &str,
    ) -> usize {
        self.entities.push((kind, form, status, matrix, values.to_owned()));
        2 * self.entities.len() - 1
    }

    /// The text of the file, in millimetres.
    pub(crate) fn text(&self) -> String {
        let line = |text: &str, letter: char, number: usize| format!("{text:<72}{letter}{number:>7}\n");
        let mut text = line("made for a test", 'S', 1);
        text += &line("1H,,1H;,4Hpart,8Hpart.igs,,,32,38,6,38,15,,1.,2,2HMM,1,0.01,,1.D-6,100.;", 'G', 1);
        let (mut directory, mut data) = (String::new(), String::new());
        let (mut d, mut p) = (0, 0);
        for (kind, form, status, matrix, values) in &self.entities {
            let first = p + 1;
            let record = format!("{kind},{values};");
            for piece in record.as_bytes().chunks(64) {
                p += 1;
                let piece = std::str::from_utf8(piece).unwrap();
                data += &line(&format!("{piece:<64}{:>8}", d + 1), 'P', p);
            }
            let count = p + 1 - first;
            directory += &line(
                &format!("{kind:8}{first:8}{:8}{:8}{:8}{:8}{matrix:8}{:8}{status}", 0, 0, 0, 0, 0),
                'D',
                d + 1,
            );
            directory += &line(&format!("{kind:8}{:8}{:8}{count:8}{form:8}", 0, 0), 'D', d + 2);
            d += 2;
        }
        text + &directory + &data + &line(&format!("S{:7}G{:7}D{d:7}P{p:7}", 1, 1), 'T', 1)
    }
}

/// A file with one of everything that is read.
pub(crate) fn everything() -> String {
    let mut f = Iges::default();
    let dependent = "00010000";
    // A square face, its boundary in space by lines, with a circular hole in parameters only.
    let square = f.add_with(
        128,
        0,
        dependent,
        0,
        "1,1,1,1,0,0,1,0,0,0.,0.,10.,10.,0.,0.,10.,10.,1.,1.,1.,1.,0.,0.,0.,10.,0.,0.,0.,10.,0.,10.,10.,0.,0.,10.,0.,10.",
    );
    let corners = ["0.,0.,0.", "10.,0.,0.", "10.,10.,0.", "0.,10.,0."];
    let lines: Vec<usize> = (0..4)
        .map(|i| f.add_with(110, 0, dependent, 0, &format!("{},{}", corners[i], corners[(i + 1) % 4])))
        .collect();
    let list = |numbers: &[usize]| numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
    let outer = f.add_with(102, 0, dependent, 0, &format!("4,{}", list(&lines)));
    let outer = f.add_with(142, 0, dependent, 0, &format!("0,{square},0,{outer},2"));
    let circle = f.add_with(100, 0, "00010500", 0, "0.,5.,5.,7.,5.,7.,5.");
    let hole = f.add_with(142, 0, dependent, 0, &format!("0,{square},{circle},0,1"));
    let name = f.add_with(406, 15, "00010200", 0, "1,10Hsquare one");
    f.add(144, &format!("{square},1,1,{outer},{hole},0,1,{name}"));
    // Half a cylinder by revolution, moved.
    let matrix = f.add(124, "0.,-1.,0.,20.,1.,0.,0.,0.,0.,0.,1.,5.");
    let axis = f.add_with(110, 0, dependent, 0, "0.,0.,0.,0.,0.,1.");
    let side = f.add_with(110, 0, dependent, 0, "2.,0.,0.,2.,0.,3.");
    let half = f.add_with(120, 0, dependent, 0, &format!("{axis},{side},0.,3.141592653589793"));
    let bottom = f.add_with(100, 0, dependent, 0, "0.,0.,0.,2.,0.,-2.,0.");
    let top = f.add_with(100, 0, dependent, 0, "3.,0.,0.,2.,0.,-2.,0.");
    let left = f.add_with(110, 0, dependent, 0, "-2.,0.,0.,-2.,0.,3.");
    let right = f.add_with(110, 0, dependent, 0, "2.,0.,3.,2.,0.,0.");
    // The top is written against the direction of the loop.
    let ring = f.add_with(102, 0, dependent, 0, &format!("4,{bottom},{left},{top},{right}"));
    let ring = f.add_with(142, 0, dependent, 0, &format!("1,{half},0,{ring},2"));
    f.add_with(144, 0, "00000000", matrix, &format!("{half},1,0,{ring}"));
    // Bounded surface, bare surfaces, a plane with a boundary.
    let upper = f.add_with(110, 0, dependent, 0, "0.,0.,9.,4.,0.,9.");
    let lower = f.add_with(110, 0, dependent, 0, "0.,3.,8.,4.,3.,8.");
    let ruled = f.add_with(118, 1, dependent, 0, &format!("{upper},{lower},0,1"));
    let ends = f.add_with(110, 0, dependent, 0, "4.,0.,9.,4.,3.,8.");
    let start = f.add_with(110, 0, dependent, 0, "0.,3.,8.,0.,0.,9.");
    let boundary = f.add_with(
        141,
        0,
        dependent,
        0,
        &format!("0,0,{ruled},4,{upper},1,0,{ends},1,0,{lower},2,0,{start},1,0"),
    );
    f.add(143, &format!("0,{ruled},1,{boundary}"));
    f.add(118, &format!("{upper},{lower},1,1"));
    f.add(122, &format!("{upper},0.,0.,12."));
    let loop_curve = f.add_with(106, 63, dependent, 0, "1,4,2.,0.,0.,5.,0.,5.,5.,0.,0.");
    f.add_with(108, 1, "00000000", 0, &format!("0.,0.,1.,2.,{loop_curve},0.,0.,0.,0."));
    let zeros = |n: usize| vec!["0."; n].join(",");
    // x = s, y = t, z = s t over [0, 2] x [0, 1].
    let x = format!("0.,1.,{}", zeros(14));
    let y = format!("0.,0.,0.,0.,1.,{}", zeros(11));
    let z = format!("0.,0.,0.,0.,0.,1.,{}", zeros(10));
    f.add(114, &format!("3,1,1,1,0.,2.,0.,1.,{x},{y},{z},{}", vec![zeros(48); 3].join(",")));
    // Free curves.
    f.add(100, "1.,0.,0.,3.,0.,0.,3.");
    f.add_with(104, 1, "00000000", 0, "0.25,0.,1.,0.,0.,-1.,0.,2.,0.,0.,1.");
    f.add_with(104, 2, "00000000", 0, "1.,0.,-1.,0.,0.,-1.,0.,1.25,-0.75,1.25,0.75");
    f.add_with(104, 3, "00000000", 0, "1.,0.,0.,0.,-1.,0.,2.,-1.,1.,2.,4.");
    f.add_with(106, 12, "00000000", 0, "2,3,0.,0.,0.,1.,1.,1.,2.,0.,1.");
    f.add(112, &format!("3,1,3,1,0.,1.,0.,1.,0.,0.,0.,0.,1.,0.,0.,0.,0.,1.,{}", zeros(12)));
    f.add(126, "2,2,0,0,0,0,0.,0.,0.,1.,1.,1.,1.,0.5,1.,0.,0.,0.,1.,1.,0.,2.,0.,0.,0.,1.,0.,0.,1.");
    // What is not read: a point, a note, a hidden line.
    f.add(116, "1.,2.,3.,0");
    f.add(212, "1,1,1.,1.,1,1.5,0.,0,0,0.,0.,0.,1HA");
    f.add_with(110, 0, "01000000", 0, "0.,0.,0.,1.,1.,1.");
    f.add_with(402, 7, "00000000", 0, &format!("1,{square}"));
    tetrahedron(&mut f);
    f.text()
}

/// A tetrahedron as a solid: planes by three kinds of entities, shared edges.
pub(crate) fn tetrahedron(f: &mut Iges) -> usize {
    let dependent = "00010001";
    let points = [[30.0, 0.0, 0.0], [31.0, 0.0, 0.0], [30.0, 1.0, 0.0], [30.0, 0.0, 1.0]];
    let text = |p: [f64; 3]| format!("{:?},{:?},{:?}", p[0], p[1], p[2]);
    let all: Vec<String> = points.iter().map(|&p| text(p)).collect();
    let vertices = f.add_with(502, 1, dependent, 0, &format!("4,{}", all.join(",")));
    let ends = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    let rows: Vec<String> = ends
        .iter()
        .map(|&[a, b]| {
            let line = f.add_with(110, 0, dependent, 0, &format!("{},{}", all[a], all[b]));
            format!("{line},{vertices},{},{vertices},{}", a + 1, b + 1)
        })
        .collect();
    let edges = f.add_with(504, 1, dependent, 0, &format!("6,{}", rows.join(",")));
    // Each face: corners counter-clockwise from outside, and the outward normal.
    let faces = [
        ([0, 2, 1], [0.0, 0.0, -1.0]),
        ([0, 1, 3], [0.0, -1.0, 0.0]),
        ([0, 3, 2], [-1.0, 0.0, 0.0]),
        ([1, 2, 3], [1.0, 1.0, 1.0]),
    ];
    let mut shell = Vec::new();
    for (corners, normal) in faces {
        let origin = f.add_with(116, 0, dependent, 0, &format!("{},0", all[corners[0]]));
        // The last plane is given upside down, and its face turned over.
        let sense = if normal[0] > 0.0 { -1.0 } else { 1.0 };
        let axis = f.add_with(123, 0, dependent, 0, &text(normal.map(|c| sense * c)));
        let plane = f.add_with(190, 0, dependent, 0, &format!("{origin},{axis}"));
        let uses: Vec<String> = (0..3)
            .map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let forward = ends.iter().position(|&pair| pair == [a, b]);
                let index = forward.or_else(|| ends.iter().position(|&pair| pair == [b, a])).unwrap();
                format!("0,{edges},{},{},0", index + 1, u8::from(forward.is_some()))
            })
            .collect();
        let boundary = f.add_with(508, 1, dependent, 0, &format!("3,{}", uses.join(",")));
        let face = f.add_with(510, 1, dependent, 0, &format!("{plane},1,1,{boundary}"));
        shell.push(format!("{face},{}", u8::from(sense > 0.0)));
    }
    let shell = f.add_with(514, 1, dependent, 0, &format!("4,{}", shell.join(",")));
    f.add(186, &format!("{shell},1,0"))
}
