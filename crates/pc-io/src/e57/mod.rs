//! E57 (ASTM E2807), decoded by the crate `e57`: several scans with their poses.

mod clouds;
mod layout;
mod points;
mod write;

use std::io::{Read, Seek, SeekFrom};

use ::e57::{E57Reader, PointCloud as Description};
use mesh_core::PointCloud;
use nalgebra::{Matrix3, Matrix4, Vector3};

use self::layout::Layout;
use self::points::Points;
use crate::foreign::{DAMAGED, Input, ReadSeek, guarded};
use crate::parsed::Parsed;
use crate::piece::Taker;
use crate::scans::{Scan, chosen};
use crate::wording::counted;
use crate::{Error, Format, Location, Place, ReadOptions};

pub(crate) use self::clouds::read_clouds;
pub(crate) use self::write::write;

/// An error of the decoder. It names the page of a checksum that is wrong.
fn refused(error: &::e57::Error) -> Error {
    Error::malformed(Place::Whole, format!("the E57 decoder refuses the file: {error}"), DAMAGED)
}

/// The pose of a scan.
#[derive(Debug, Clone, Copy)]
struct Pose {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Pose {
    /// The pose that a file gives; its quaternion is taken as one of length 1, which a warning says where it is not.
    fn of(scan: &Description, number: usize, warnings: &mut Vec<String>) -> Result<Option<Self>, Error> {
        let Some(given) = &scan.transform else { return Ok(None) };
        let (turn, shift) = (&given.rotation, &given.translation);
        let [w, x, y, z] = [turn.w, turn.x, turn.y, turn.z];
        let length = (w * w + x * x + y * y + z * z).sqrt();
        let translation = Vector3::new(shift.x, shift.y, shift.z);
        if !(length > 0.0 && length.is_finite() && translation.iter().all(|value| value.is_finite())) {
            let what = format!("the pose of scan {number} is not a motion");
            return Err(Error::malformed(Place::Whole, what, DAMAGED));
        }
        if (length - 1.0).abs() > 1e-6 {
            warnings.push(format!(
                "the quaternion of scan {number} has length {length}; it was made one of length 1"
            ));
        }
        // A quaternion that is 1 up to its last digits is left as it is.
        let unit = if (length - 1.0).abs() > 1e-6 { 1.0 / length } else { 1.0 };
        let [w, x, y, z] = [w * unit, x * unit, y * unit, z * unit];
        let rotation = Matrix3::new(
            w * w + x * x - y * y - z * z,
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
            2.0 * (x * y + w * z),
            w * w + y * y - x * x - z * z,
            2.0 * (y * z - w * x),
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            w * w + z * z - x * x - y * y,
        );
        Ok(Some(Self { rotation, translation }))
    }

    fn rows(&self) -> [[f64; 4]; 4] {
        let mut matrix = Matrix4::identity();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.rotation);
        matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation);
        [0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| matrix[(row, column)]))
    }
}

/// An open file and the scans that are to be read of it.
struct Opened {
    reader: E57Reader<Box<dyn ReadSeek>>,
    scans: Vec<Description>,
    chosen: Vec<usize>,
    length: u64,
}

impl Opened {
    fn open(input: Input, options: &ReadOptions) -> Result<Self, Error> {
        let (length, mut input) = (input.length, input);
        check_header(&mut input)?;
        let reader = guarded("E57", || E57Reader::new(input.reader).map_err(|error| refused(&error)))?;
        let scans = reader.pointclouds();
        let names: Vec<Option<String>> = scans.iter().map(|scan| scan.name.clone()).collect();
        let chosen = chosen(options.scan.as_deref(), &names)?;
        Ok(Self { reader, scans, chosen, length })
    }

    /// Whether points of a chosen scan have normals.
    fn has_normals(&self) -> Result<bool, Error> {
        let mut scans = self.chosen.iter().map(|&number| Layout::of(&self.scans[number], self.length));
        scans.try_fold(false, |has, layout| Ok(has || layout?.has_normals))
    }

    /// Reads the chosen scans until `take` says that it is enough, and hands over the points in pieces of at most `limit`, with the number of the scan.
    fn visit(
        &mut self,
        limit: usize,
        warnings: &mut Vec<String>,
        mut take: impl FnMut(usize, Option<&Pose>, &mut Points) -> bool,
    ) -> Result<(), Error> {
        for &number in &self.chosen {
            let scan = &self.scans[number];
            let layout = Layout::of(scan, self.length)?;
            let pose = Pose::of(scan, number, warnings)?;
            let reader = &mut self.reader;
            let mut points = Points::new(&layout);
            if scan.records == 0 {
                take(number, pose.as_ref(), &mut points);
                continue;
            }
            let raw = guarded("E57", || reader.pointcloud_raw(scan).map_err(|error| refused(&error)))?;
            let mut raw = raw.fuse();
            let mut left = scan.records;
            while left > 0 {
                let count = usize::try_from(left).unwrap_or(usize::MAX).min(limit);
                guarded("E57", || {
                    for _ in 0..count {
                        let values = match raw.next() {
                            Some(values) => values.map_err(|error| refused(&error))?,
                            None => {
                                return Err(Error::malformed(Place::Whole, "the points end early", DAMAGED));
                            }
                        };
                        points.push(&values, scan, &layout, pose.as_ref())?;
                    }
                    Ok(())
                })?;
                left -= count as u64;
                if !take(number, pose.as_ref(), &mut points) {
                    return Ok(());
                }
            }
        }
        Ok(())
    }
}

/// Checks that the description fits the file: the decoder allocates what the header says.
fn check_header(input: &mut Input) -> Result<(), Error> {
    let mut head = [0; 48];
    let ended = |_| Error::malformed(Place::Byte(0), "the file ends within its header", DAMAGED);
    input.reader.read_exact(&mut head).map_err(ended)?;
    input.reader.seek(SeekFrom::Start(0)).map_err(ended)?;
    let number = |at: usize| (0..8).fold(0, |number, byte| number | u64::from(head[at + byte]) << (8 * byte));
    let (offset, length) = (number(24), number(32));
    let left = input.length.saturating_sub(offset);
    if length > left {
        return Err(Error::Truncated {
            location: Location { file: None, place: Place::Byte(24) },
            what: "bytes of the description".to_owned(),
            promised: length,
            needed: length,
            left,
        });
    }
    Ok(())
}

/// Points that are read at a time.
const CHUNK: usize = 1 << 16;

/// The scans that were read so far.
#[derive(Default)]
struct Seen(Vec<Scan>);

impl Seen {
    fn add(&mut self, number: usize, name: Option<&String>, pose: Option<&Pose>, points: usize) {
        if self.0.last().is_none_or(|last| last.number != number) {
            self.0.push(Scan { number, name: name.cloned(), points: 0, pose: pose.map(Pose::rows) });
        }
        if let Some(scan) = self.0.last_mut() {
            scan.points += points;
        }
    }

    /// Says that scans were put together.
    fn warn(&self, warnings: &mut Vec<String>) {
        if self.0.len() > 1 {
            let is_posed = self.0.iter().any(|scan| scan.pose.is_some());
            let how = if is_posed { "moved by their poses" } else { "which have no poses" };
            warnings.push(format!("{} were put together, {how}", counted(self.0.len(), "scan")));
        }
    }
}

/// Says that points were left out.
fn warn_of_invalid(invalid: usize, warnings: &mut Vec<String>) {
    if invalid > 0 {
        warnings
            .push(format!("left out: {} that the scanner marks as not measured", counted(invalid, "point")));
    }
}

/// Reads the chosen scans together, moved by their poses; which scan a point belongs to is a scalar where there are several.
pub(crate) fn read(input: Input, options: &ReadOptions) -> Result<Parsed, Error> {
    let mut opened = Opened::open(input, options)?;
    let mut warnings = Vec::new();
    let mut all = Points::default();
    let mut seen = Seen::default();
    let names: Vec<Option<String>> = opened.scans.iter().map(|scan| scan.name.clone()).collect();
    opened.visit(CHUNK, &mut warnings, |number, pose, points| {
        seen.add(number, names[number].as_ref(), pose, points.len());
        all.append(points);
        true
    })?;
    let cloud = all.into_cloud(&seen.0, names.len() > 1, &mut warnings)?;
    seen.warn(&mut warnings);
    Ok(Parsed { scans: seen.0, ..Parsed::cloud(Format::E57, cloud, warnings) })
}

/// Hands over the positions and normals of the chosen scans in pieces of at most `limit` points.
pub(crate) fn read_pieces<E>(
    input: Input,
    options: &ReadOptions,
    limit: usize,
    taker: &mut Taker<'_, E>,
) -> Result<Parsed, Error> {
    let mut opened = Opened::open(input, options)?;
    let has_normals = opened.has_normals()?;
    let mut warnings = Vec::new();
    let mut seen = Seen::default();
    let mut invalid = 0;
    let names: Vec<Option<String>> = opened.scans.iter().map(|scan| scan.name.clone()).collect();
    opened.visit(limit, &mut warnings, |number, pose, points| {
        seen.add(number, names[number].as_ref(), pose, points.len());
        let piece = points.take_piece(has_normals);
        invalid += points.take_invalid();
        taker.give(piece)
    })?;
    warn_of_invalid(invalid, &mut warnings);
    seen.warn(&mut warnings);
    Ok(Parsed { scans: seen.0, ..Parsed::cloud(Format::E57, nothing(), warnings) })
}

/// A cloud without points.
fn nothing() -> PointCloud {
    PointCloud::new(Vec::new())
}
