//! Instances `#n = …;` and the frame of the file around them.

use crate::write::number;
use nalgebra::Vector3;
use std::fmt;
use std::fmt::Write as _;

/// The name `#n` of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Reference(usize);

impl fmt::Display for Reference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{}", self.0)
    }
}

/// All instances so far.
#[derive(Debug, Default)]
pub(super) struct Instances {
    text: String,
    count: usize,
}

impl Instances {
    /// Adds an instance.
    pub(super) fn add(&mut self, what: &str) -> Reference {
        self.count += 1;
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "#{}={what};", self.count);
        Reference(self.count)
    }

    /// Adds a point.
    pub(super) fn point(&mut self, point: &Vector3<f64>) -> Reference {
        self.add(&format!("CARTESIAN_POINT('',{})", reals(point.as_slice())))
    }

    /// Adds a direction.
    pub(super) fn direction(&mut self, direction: &Vector3<f64>) -> Reference {
        self.add(&format!("DIRECTION('',{})", reals(direction.as_slice())))
    }

    /// Adds a position: origin, `z` and `x`.
    pub(super) fn placement(&mut self, frame: &nurbs_core::Frame) -> Reference {
        let origin = self.point(&frame.origin());
        let (z, x) = (self.direction(&frame.z()), self.direction(&frame.x()));
        self.add(&format!("AXIS2_PLACEMENT_3D('',{origin},{z},{x})"))
    }

    /// The whole file.
    pub(super) fn file(self, name: &str) -> Vec<u8> {
        // No time: the same model gives the same bytes.
        let time = "1970-01-01T00:00:00";
        let version = env!("CARGO_PKG_VERSION");
        let schema = "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }";
        let name = string(name);
        format!(
            "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n\
             FILE_NAME({name},'{time}',(''),(''),'Industrial Geometry {version}','Industrial Geometry','');\n\
             FILE_SCHEMA(('{schema}'));\nENDSEC;\nDATA;\n{}ENDSEC;\nEND-ISO-10303-21;\n",
            self.text
        )
        .into_bytes()
    }
}

/// A real number.
pub(super) fn real(value: f64) -> String {
    number::real(value, 'E')
}

/// A list of real numbers in parentheses.
pub(super) fn reals(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|&value| real(value)).collect();
    format!("({})", texts.join(","))
}

/// A list of references in parentheses.
pub(super) fn list(references: &[Reference]) -> String {
    let texts: Vec<String> = references.iter().map(Reference::to_string).collect();
    format!("({})", texts.join(","))
}

/// A string: quotes and backslashes doubled, what is not ASCII as UTF-16 between `\X2\` and `\X0\`.
pub(super) fn string(text: &str) -> String {
    let mut out = String::from("'");
    let mut wide = false;
    for c in text.chars() {
        let plain = (' '..='~').contains(&c);
        if plain == wide {
            out.push_str(if wide { r"\X0\" } else { r"\X2\" });
            wide = !wide;
        }
        match c {
            '\'' => out.push_str("''"),
            '\\' => out.push_str(r"\\"),
            _ if plain => out.push(c),
            _ => {
                let mut units = [0; 2];
                for unit in c.encode_utf16(&mut units) {
                    // Writing to a string cannot fail.
                    let _ = write!(out, "{unit:04X}");
                }
            }
        }
    }
    if wide {
        out.push_str(r"\X0\");
    }
    out.push('\'');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_with_all_characters() {
        assert_eq!(string(""), "''");
        assert_eq!(string("it's \\ here"), r"'it''s \\ here'");
        assert_eq!(string("Flügel 3"), r"'Fl\X2\00FC\X0\gel 3'");
        assert_eq!(string("αβ"), r"'\X2\03B103B2\X0\'");
    }
}
