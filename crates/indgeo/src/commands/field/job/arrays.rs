//! Values on grids, for other programs: NPY and VTI.

use crate::error::Error;
use crate::files;
use industrial_geometry::distance_field::grid::Lattice;
use std::io::{self, Write};
use std::path::Path;

/// A format of arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// `NumPy`.
    Npy,
    /// Image data of VTK.
    Vti,
}

/// The format that the extension names; NPY on standard output.
pub(super) fn form_of(path: &Path) -> Result<Form, Error> {
    match files::extension(path).as_str() {
        "npy" => Ok(Form::Npy),
        "vti" => Ok(Form::Vti),
        _ if files::is_stream(path) => Ok(Form::Npy),
        _ => Err(Error::content(path, "the extension names no format of arrays", "choose .npy or .vti")),
    }
}

/// Writes values in the order of the nodes.
pub(super) fn write<const D: usize>(
    out: &mut dyn Write,
    form: Form,
    lattice: &Lattice<D>,
    values: &[f64],
) -> io::Result<()> {
    let mut out = io::BufWriter::new(out);
    match form {
        Form::Npy => write_npy(&mut out, &lattice.counts(), values)?,
        Form::Vti => write_vti(&mut out, lattice, values)?,
    }
    out.flush()
}

/// Version 1.0: doubles, little endian, the last index fastest.
fn write_npy(out: &mut impl Write, shape: &[usize], values: &[f64]) -> io::Result<()> {
    let shape: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}), }}", shape.join(", "));
    // Magic, version, length, header and line feed fill a multiple of 64 bytes.
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    let length = u16::try_from(header.len()).map_err(|_| io::ErrorKind::InvalidData)?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    values.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))
}

/// One piece, the values appended as they are; the first index runs fastest there.
fn write_vti<const D: usize>(out: &mut impl Write, lattice: &Lattice<D>, values: &[f64]) -> io::Result<()> {
    let (counts, low, spacing) = (lattice.counts(), lattice.low(), lattice.spacing());
    let of = |k: usize, last: usize| if k < D { counts[k] - 1 } else { last };
    let extent = format!("0 {} 0 {} 0 {}", of(0, 0), of(1, 0), of(2, 0));
    let number = |k: usize, value: &dyn Fn(usize) -> f64, other: f64| if k < D { value(k) } else { other };
    let triple = |value: &dyn Fn(usize) -> f64, other: f64| {
        format!("{} {} {}", number(0, value, other), number(1, value, other), number(2, value, other))
    };
    let origin = triple(&|k| low[k], 0.0);
    let steps = triple(&|k| spacing[k], 1.0);
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(
        out,
        "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">"
    )?;
    writeln!(out, "<ImageData WholeExtent=\"{extent}\" Origin=\"{origin}\" Spacing=\"{steps}\">")?;
    writeln!(out, "<Piece Extent=\"{extent}\"><PointData Scalars=\"distance\">")?;
    writeln!(out, "<DataArray type=\"Float64\" Name=\"distance\" format=\"appended\" offset=\"0\"/>")?;
    writeln!(out, "</PointData></Piece></ImageData>\n<AppendedData encoding=\"raw\">")?;
    out.write_all(b"_")?;
    out.write_all(&(8 * values.len() as u64).to_le_bytes())?;
    for place in 0..values.len() {
        // The place with the first index fastest.
        let mut rest = place;
        let mut node = 0;
        for k in 0..D {
            node += rest % counts[k] * lattice.stride(k);
            rest /= counts[k];
        }
        out.write_all(&values[node].to_le_bytes())?;
    }
    writeln!(out, "\n</AppendedData>\n</VTKFile>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use industrial_geometry::mesh::nalgebra::Vector2;

    #[test]
    fn arrays_have_the_form_that_others_read() {
        let lattice = Lattice::new(Vector2::zeros(), Vector2::new(1.0, 2.0), [2, 3]).unwrap();
        let values: Vec<f64> = (0..6).map(f64::from).collect();
        let mut npy = Vec::new();
        write(&mut npy, Form::Npy, &lattice, &values).unwrap();
        assert_eq!(npy.len(), 128 + 48);
        assert!(npy.starts_with(
            b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }"
        ));
        assert_eq!((npy[127], &npy[136..144]), (b'\n', &1.0f64.to_le_bytes()[..]));
        let mut vti = Vec::new();
        write(&mut vti, Form::Vti, &lattice, &values).unwrap();
        let text = String::from_utf8_lossy(&vti);
        assert!(text.contains("WholeExtent=\"0 1 0 2 0 0\"") && text.contains("Spacing=\"1 1 1\""), "{text}");
        let start = vti.windows(9).position(|w| w == b"_\x30\0\0\0\0\0\0\0").unwrap() + 9;
        let second: [u8; 8] = vti[start + 8..start + 16].try_into().unwrap();
        assert_eq!(f64::from_le_bytes(second), 3.0);
    }
}
