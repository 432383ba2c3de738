//! A piece of a file that is read in parts, and what takes it.

use std::ops::Range;

use nalgebra::{Point3, Vector3};

/// Some of the points of a file, in their order, with nothing but normals.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Piece {
    /// Positions, in the unit of the file.
    pub positions: Vec<Point3<f64>>,
    /// Normals, if the points of the file have them: as many as positions.
    pub normals: Option<Vec<Vector3<f64>>>,
}

impl Piece {
    /// Leaves the points with these places in the piece.
    pub(crate) fn cut(&mut self, range: Range<usize>) {
        self.positions.truncate(range.end);
        self.positions.drain(..range.start.min(self.positions.len()));
        if let Some(normals) = &mut self.normals {
            normals.truncate(range.end);
            normals.drain(..range.start.min(normals.len()));
        }
    }

    /// Drops the points that are not finite if `drop` says so; returns how many there were.
    pub(crate) fn sift(&mut self, drop: bool) -> usize {
        let is_finite = |point: &Point3<f64>| point.iter().all(|value| value.is_finite());
        let keep: Vec<bool> = self.positions.iter().map(is_finite).collect();
        let count = keep.iter().filter(|keep| !**keep).count();
        if drop && count > 0 {
            let mut flags = keep.iter();
            self.positions.retain(|_| flags.next().copied().unwrap_or(false));
            if let Some(normals) = &mut self.normals {
                let mut flags = keep.iter();
                normals.retain(|_| flags.next().copied().unwrap_or(false));
            }
        }
        count
    }
}

/// What the readers of single formats need to hand pieces over.
pub(crate) struct Taker<'a, E> {
    pub(crate) take: &'a mut dyn FnMut(Piece) -> Result<(), E>,
    pub(crate) failed: Option<E>,
    pub(crate) drop_non_finite: bool,
    /// The numbers of the points that are wanted.
    pub(crate) range: Range<u64>,
    /// The number of the point that is read next.
    pub(crate) next: u64,
    /// Number of the points in the file, where that is known before they are read.
    pub(crate) total: Option<u64>,
    pub(crate) points: usize,
    pub(crate) non_finite: usize,
}

impl<E> Taker<'_, E> {
    /// The numbers of the points to be read of a file that holds `total` and is read from any of them on.
    pub(crate) fn begin(&mut self, total: u64) -> Range<u64> {
        self.total = Some(total);
        let start = self.range.start.min(total);
        self.next = start;
        start..self.range.end.clamp(start, total)
    }

    /// Hands a piece over, or what is wanted of it; false if reading failed.
    pub(crate) fn give(&mut self, mut piece: Piece) -> bool {
        let count = piece.positions.len();
        let place = |number: u64| {
            usize::try_from(number.saturating_sub(self.next)).map_or(count, |place| place.min(count))
        };
        let wanted = place(self.range.start)..place(self.range.end);
        self.next += count as u64;
        if wanted != (0..count) {
            piece.cut(wanted);
        }
        self.points += piece.positions.len();
        self.non_finite += piece.sift(self.drop_non_finite);
        if piece.positions.is_empty() {
            return true;
        }
        self.failed = (self.take)(piece).err();
        self.failed.is_none()
    }
}
