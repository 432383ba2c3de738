//! PTX, the gridded scans of Leica: several in a file, each with the pose of its scanner.

use crate::wording::counted;
use mesh_core::{Attributes, Colours, PointCloud};
use nalgebra::{Matrix4, Point3};

use crate::number::{parse, parse_count};
use crate::parsed::Parsed;
use crate::scans::{Scan, chosen};
use crate::source::{Lines, Source, quoted, words};
use crate::{Error, Format, ReadOptions};

const EXPORT: &str = "correct the line or export the file again";
const TRUNCATED: &str = "the file is truncated or its counts are wrong, export it again";
/// How far from a rigid motion a matrix may be that is written with few digits.
const RIGID: f64 = 1e-3;

/// Numbers of the lines of a head after the two counts: position, three axes, and the matrix row by row.
const HEAD: [usize; 8] = [3, 3, 3, 3, 4, 4, 4, 4];

/// Whether a beginning is that of a scan: two counts, three numbers four times, and four numbers four times.
pub(crate) fn looks_like(head: &[u8]) -> bool {
    let mut lines = Lines::new(head).filter(|(_, line)| !line.trim_ascii().is_empty());
    let mut next = || lines.next().map_or(b"".as_slice(), |(_, line)| line);
    let counts = (0..2).all(|_| parse_count(next().trim_ascii()).is_some());
    counts && HEAD.into_iter().all(|length| numbers(next()).is_some_and(|numbers| numbers.len() == length))
}

pub(crate) fn numbers(line: &[u8]) -> Option<Vec<f64>> {
    words(line).take(9).map(parse).collect()
}

/// Points of all scans so far.
#[derive(Default)]
pub(crate) struct Points {
    pub(crate) positions: Vec<Point3<f64>>,
    intensities: Vec<f64>,
    colours: Vec<[u8; 3]>,
    scans: Vec<f64>,
    /// Places of the grids in which nothing was measured.
    missing: usize,
    /// Numbers per line, from the first point on.
    width: Option<usize>,
}

/// Reads the points of all scans, moved by their poses; which scan a point belongs to is a scalar where there are several.
/// Lines 0 0 0 stand for pulses without an answer and are left out.
pub(crate) fn read(source: Source<'_>, options: &ReadOptions) -> Result<Parsed, Error> {
    let choice = options.scan.as_deref();
    let wanted = choice.and_then(|choice| choice.parse::<u32>().ok());
    let mut lines = source.lines_from(0);
    let mut points = Points::default();
    let mut warnings = Vec::new();
    let mut scan = 0u32;
    let mut scans = Vec::new();
    while let Some((at, line)) = lines.find(|(_, line)| !line.trim_ascii().is_empty()) {
        let head = Head::read(source, (at, line), &mut lines)?;
        if !head.is_rigid() {
            warnings.push(not_rigid(scan, source.line_at(at)));
        }
        let (before, missing) = (points.positions.len(), points.missing);
        points.read_scan(source, &mut lines, &head, scan)?;
        if wanted.is_some_and(|wanted| wanted != scan) {
            points.truncate(before);
            points.missing = missing;
        } else {
            let points = points.positions.len() - before;
            scans.push(Scan { number: scan as usize, name: None, points, pose: Some(head.pose()) });
        }
        scan += 1;
    }
    // Scans have no names here, and their number is known only now.
    chosen(choice, &vec![None; scan as usize])?;
    if points.missing > 0 {
        warnings.push(left_out(points.missing));
    }
    let width = points.width;
    let cloud = points.into_cloud(width, scan > 1)?;
    Ok(Parsed { scans, ..Parsed::cloud(Format::Ptx, cloud, warnings) })
}

/// Says that the pose of a scan, from 0 on, is none.
pub(crate) fn not_rigid(scan: u32, line: usize) -> String {
    format!("the matrix of scan {} (line {line}) is no rigid motion; it was applied as it is", scan + 1)
}

/// Says that places of the grids hold no point.
pub(crate) fn left_out(missing: usize) -> String {
    format!("left out: {} of the grids without a point (0 0 0)", counted(missing, "place"))
}

/// What stands before the points of a scan.
pub(crate) struct Head {
    /// Columns times rows.
    pub(crate) count: u64,
    pub(crate) matrix: Matrix4<f64>,
}

impl Head {
    pub(crate) fn read(
        source: Source<'_>,
        (at, line): (usize, &[u8]),
        lines: &mut Lines<'_>,
    ) -> Result<Self, Error> {
        let mut next = |what: &str| {
            lines.next().ok_or_else(|| {
                let what = format!("the file ends where {what} is expected");
                source.line_error(source.data.len(), what, TRUNCATED)
            })
        };
        let count = |(at, line): (usize, &[u8]), what: &str| {
            parse_count(line.trim_ascii()).ok_or_else(|| {
                let what = format!("{} is not the number of {what} of a scan", quoted(line.trim_ascii()));
                source.line_error(at, what, EXPORT)
            })
        };
        let columns = count((at, line), "columns")?;
        let rows = count(next("the number of rows")?, "rows")?;
        let mut matrix = Matrix4::zeros();
        for (place, length) in HEAD.into_iter().enumerate() {
            let (at, line) = next("the pose of the scanner")?;
            let found = numbers(line)
                .filter(|numbers| numbers.len() == length && numbers.iter().all(|number| number.is_finite()));
            let Some(found) = found else {
                let what = format!("{} is not a line of {length} numbers", quoted(line.trim_ascii()));
                return Err(source.line_error(
                    at,
                    what,
                    "the pose of a scan has eight lines; export the file again",
                ));
            };
            if let Some(row) = place.checked_sub(4) {
                found.iter().enumerate().for_each(|(column, &value)| matrix[(row, column)] = value);
                // Points are rows here, so that the last column is fixed and the last row is the shift.
                let last = if row == 3 { 1.0 } else { 0.0 };
                if (matrix[(row, 3)] - last).abs() > 1e-9 {
                    let what = format!(
                        "the matrix of the pose ends a line with {} instead of {last}",
                        matrix[(row, 3)]
                    );
                    return Err(source.line_error(at, what, EXPORT));
                }
            }
        }
        Ok(Self { count: columns.saturating_mul(rows), matrix })
    }

    /// Moves a point of the scanner to where it stood.
    pub(crate) fn place(&self, [x, y, z]: [f64; 3]) -> Point3<f64> {
        let row = nalgebra::RowVector4::new(x, y, z, 1.0) * self.matrix;
        Point3::new(row[0], row[1], row[2])
    }

    /// The pose of the scanner: points are rows in the file, and columns here.
    pub(crate) fn pose(&self) -> [[f64; 4]; 4] {
        [0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| self.matrix[(column, row)]))
    }

    pub(crate) fn is_rigid(&self) -> bool {
        let turn = self.matrix.fixed_view::<3, 3>(0, 0);
        (turn * turn.transpose() - nalgebra::Matrix3::identity()).amax() <= RIGID && turn.determinant() > 0.0
    }
}

impl Points {
    /// Adds a point by the numbers of its line: 3, 4, or 7 with a colour that is one.
    pub(crate) fn push(&mut self, head: &Head, numbers: &[f64], scan: u32) {
        self.positions.push(head.place([numbers[0], numbers[1], numbers[2]]));
        self.scans.push(f64::from(scan));
        self.intensities.extend(numbers.get(3));
        if let Some(&[r, g, b]) = numbers.get(4..7) {
            self.colours.push([r, g, b].map(crate::columns::to_byte));
        }
    }

    /// The points as a cloud, by the numbers per line of the file, and with their scans if there are several.
    pub(crate) fn into_cloud(self, width: Option<usize>, has_several: bool) -> Result<PointCloud, Error> {
        let mut attributes = Attributes::default();
        if width.is_some_and(|width| width > 3) {
            attributes.push_scalar("intensity", self.intensities).map_err(Error::shape)?;
        }
        if width == Some(7) {
            attributes.set_colours(Some(Colours::Rgb(self.colours)));
        }
        if has_several {
            attributes.push_scalar("scan", self.scans).map_err(Error::shape)?;
        }
        PointCloud::new(self.positions).with_attributes(attributes).map_err(Error::shape)
    }

    /// Forgets the points behind the first `count`.
    fn truncate(&mut self, count: usize) {
        self.positions.truncate(count);
        self.intensities.truncate(count);
        self.colours.truncate(count);
        self.scans.truncate(count);
    }

    fn read_scan(
        &mut self,
        source: Source<'_>,
        lines: &mut Lines<'_>,
        head: &Head,
        scan: u32,
    ) -> Result<(), Error> {
        source.check_promise(lines.offset(), "points", head.count, 6, true)?;
        for point in 0..head.count {
            let Some((at, line)) = lines.next() else {
                let what =
                    format!("the file ends after {point} of {} points of scan {}", head.count, scan + 1);
                return Err(source.line_error(source.data.len(), what, TRUNCATED));
            };
            let found = numbers(line).filter(|numbers| matches!(numbers.len(), 3 | 4 | 7));
            let fits = |numbers: &Vec<f64>| self.width.is_none_or(|width| width == numbers.len());
            let Some(numbers) = found.filter(fits) else {
                let what = format!(
                    "{} is not a point: x y z, with intensity or intensity and r g b, as in all other lines",
                    quoted(line.trim_ascii())
                );
                return Err(source.line_error(at, what, EXPORT));
            };
            self.width = Some(numbers.len());
            if numbers[..3].iter().all(|&value| value == 0.0) {
                self.missing += 1;
                continue;
            }
            if let Some(&[r, g, b]) = numbers.get(4..7)
                && ![r, g, b].iter().all(|value| (0.0..=255.0).contains(value))
            {
                let what = format!("{r} {g} {b} is no colour of 0 to 255");
                return Err(source.line_error(at, what, EXPORT));
            }
            self.push(head, &numbers, scan);
        }
        Ok(())
    }
}
