//! The triangulation of the parameter plane of a face, and which of its regions belong to the face.

use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, Point2, PositionInTriangulation, Triangulation as _,
};

/// Triangles of a region that are asked for the side on which it lies.
const ASKED: usize = 5;

/// A vertex of the plane, in coordinates in which a step of the tolerance has length 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) at: [f64; 2],
    /// Index of the place that it stands for; `None` where two edges cross and there is none.
    pub(super) place: Option<usize>,
}

impl HasPosition for Corner {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        Point2::new(self.at[0], self.at[1])
    }
}

/// A triangulation with constraints that keep regions apart.
pub(super) struct Regions {
    net: ConstrainedDelaunayTriangulation<Corner>,
    last: Option<FixedVertexHandle>,
}

/// A triangle of the plane: its corners, counter-clockwise.
pub(super) type Triangle = [Corner; 3];

impl Regions {
    pub(super) fn new() -> Self {
        Self { net: ConstrainedDelaunayTriangulation::new(), last: None }
    }

    /// Adds a vertex; `None` for one whose coordinates cannot be used.
    pub(super) fn insert(&mut self, corner: Corner) -> Option<FixedVertexHandle> {
        let found = match self.last {
            Some(hint) => self.net.insert_with_hint(corner, hint),
            None => self.net.insert(corner),
        };
        self.last = found.ok().or(self.last);
        found.ok()
    }

    /// Keeps what is on both sides of a line apart; whether another such line crosses it.
    pub(super) fn constrain(&mut self, from: FixedVertexHandle, to: FixedVertexHandle) -> bool {
        if from == to {
            return false;
        }
        let is_free = self.net.can_add_constraint(from, to);
        if is_free {
            self.net.add_constraint(from, to);
        } else {
            // Chords of edges that touch may cross.
            self.net.add_constraint_and_split(from, to, |at| Corner { at: [at.x, at.y], place: None });
        }
        !is_free
    }

    /// Which triangles lie in regions that `is_inside` says are inside, by index; `None` where it cannot tell.
    pub(super) fn inside(&self, is_inside: impl Fn([f64; 2]) -> Option<bool>) -> Vec<bool> {
        let mut region = vec![usize::MAX; self.net.num_all_faces()];
        let mut kept = vec![false; region.len()];
        for start in self.net.inner_faces() {
            if region[start.fix().index()] != usize::MAX {
                continue;
            }
            let number = start.fix().index();
            region[number] = number;
            let (mut members, mut next) = (vec![start], 0);
            while next < members.len() {
                for edge in members[next].adjacent_edges() {
                    if edge.is_constraint_edge() {
                        continue;
                    }
                    if let Some(other) = edge.rev().face().as_inner()
                        && region[other.fix().index()] == usize::MAX
                    {
                        region[other.fix().index()] = number;
                        members.push(other);
                    }
                }
                next += 1;
            }
            let mut largest: Vec<(f64, usize)> =
                members.iter().enumerate().map(|(k, face)| (face.area(), k)).collect();
            largest.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            let votes = largest.iter().take(ASKED).filter_map(|(area, k)| {
                let centre = members[*k].center();
                is_inside([centre.x, centre.y]).map(|inside| if inside { *area } else { -area })
            });
            if votes.sum::<f64>() > 0.0 {
                members.iter().for_each(|face| kept[face.fix().index()] = true);
            }
        }
        kept
    }

    /// Whether there is a triangle that is kept on each side of a line; `None` where the line was divided.
    pub(super) fn sides(
        &self,
        from: FixedVertexHandle,
        to: FixedVertexHandle,
        kept: &[bool],
    ) -> Option<[bool; 2]> {
        let edge = self.net.get_edge_from_neighbors(from, to)?;
        Some([edge, edge.rev()].map(|e| e.face().as_inner().is_some_and(|face| kept[face.fix().index()])))
    }

    /// Whether a place is inside one of the triangles that are kept, at least `apart` from all vertices.
    pub(super) fn takes(&self, at: [f64; 2], kept: &[bool], apart: f64) -> bool {
        let at = Point2::new(at[0], at[1]);
        let found = match self.last {
            Some(hint) => self.net.locate_with_hint(at, hint),
            None => self.net.locate(at),
        };
        let face: FixedFaceHandle<InnerTag> = match found {
            PositionInTriangulation::OnFace(face) => face,
            PositionInTriangulation::OnEdge(edge) => {
                let edge = self.net.directed_edge(edge);
                match edge.face().as_inner() {
                    Some(face) if !edge.is_constraint_edge() => face.fix(),
                    _ => return false,
                }
            }
            _ => return false,
        };
        let is_far = |p: Point2<f64>| (p.x - at.x).hypot(p.y - at.y) >= apart;
        kept[face.index()] && self.net.face(face).positions().into_iter().all(is_far)
    }

    /// The triangles that are kept, with for each side whether it may be divided.
    pub(super) fn triangles(&self, kept: &[bool]) -> Vec<(Triangle, [bool; 3])> {
        let faces = self.net.inner_faces().filter(|face| kept[face.fix().index()]);
        faces
            .map(|face| {
                let corners = face.vertices().map(|vertex| *vertex.data());
                // Side k runs from corner k to the next.
                let mut free = [true; 3];
                for edge in face.adjacent_edges() {
                    if let Some(k) = face.vertices().iter().position(|v| v.fix() == edge.from().fix()) {
                        free[k] = !edge.is_constraint_edge();
                    }
                }
                (corners, free)
            })
            .collect()
    }
}
