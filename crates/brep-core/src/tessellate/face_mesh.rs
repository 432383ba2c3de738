//! The triangles of one face.

use super::edge_points::EdgePoints;
use super::outline::{Cuts, cross, loops, middle, pieces};
use super::regions::{Corner, Regions};
use crate::Error;
use crate::boundary::{Inside, flip};
use crate::face::Face;
use crate::part::Part;
use nalgebra::{Vector2, Vector3};
use nurbs_core::ParametricSurface;
use std::collections::BTreeMap;

/// Places at which the bend of a face is looked at, in each parameter.
const LOOKS: usize = 17;
/// Steps in each parameter at most.
const MAX_STEPS: f64 = 2000.0;
/// Share of the chord tolerance that the steps of each parameter take.
const SHARE: f64 = 0.25;
/// Distance from vertices, in steps, that a place inside needs.
const APART: f64 = 0.4;
/// Rounds in which places are added where triangles are too far from the surface.
const ROUNDS: usize = 8;
/// Vertices of a face at most.
const MOST: usize = 400_000;
/// Share of the box of the plane below which two places of one vertex are one.
const SAME: f64 = 1e-9;
/// The same for places that are as near on the surface as its edges are to it.
const NEAR: f64 = 1e-2;
/// Share of the size of a part by which the ends of edges at a vertex may differ.
const MEET: f64 = 1e-7;
/// Share of the size of a part below which a line of the plane is a pole.
const POLE: f64 = 1e-10;

/// A face in triangles.
pub(super) struct FaceMesh {
    /// Corners; those below `shared` are vertices of edges, the others are `own`, from `shared` on.
    pub(super) triangles: Vec<[usize; 3]>,
    pub(super) normals: Vec<[Vector3<f64>; 3]>,
    pub(super) own: Vec<Vector3<f64>>,
    pub(super) shared: usize,
    pub(super) deviation: f64,
    /// Edges whose chords are too coarse for the shape of the face, and parameters at which they are to be divided.
    pub(super) crossed: Vec<(usize, f64)>,
}

/// Triangles of a face, and where they are too far from it.
struct Examined {
    triangles: Vec<([Corner; 3], [bool; 3])>,
    deviation: f64,
    wanted: BTreeMap<[u64; 2], [f64; 2]>,
}

/// A face that is being triangulated.
struct Work<'a> {
    part: &'a Part,
    face: &'a Face,
    points: &'a EdgePoints,
    cuts: &'a Cuts,
    /// Box of the plane of the chords, and the steps in it.
    low: Vector2<f64>,
    high: Vector2<f64>,
    step: Vector2<f64>,
    /// Distance on the surface below which places of one vertex are one.
    slack: f64,
    regions: Regions,
    /// Places of the plane with the numbers of their vertices.
    places: Vec<(Vector2<f64>, usize)>,
    known: BTreeMap<[u64; 2], usize>,
    /// Places of each vertex of an edge.
    of_vertex: BTreeMap<usize, Vec<usize>>,
    /// Vertices of lines that are one point, by parameter and value.
    poles: BTreeMap<(usize, u64), usize>,
    own: Vec<Vector3<f64>>,
}

/// Triangulates a face. `index` is its index in the part.
pub(super) fn mesh(
    part: &Part,
    index: usize,
    cuts: &Cuts,
    points: &EdgePoints,
    chord: f64,
) -> Result<FaceMesh, Error> {
    let face = &part.faces[index];
    let failed = |why: &str| Error::of(format!("face #{}", face.source()), why);
    let loops = loops(part, face, points);
    let pieces = pieces(&loops, cuts);
    let (low, high) = plane_box(face, pieces.iter().flatten().map(|place| place.at), cuts);
    if !(low.iter().chain(high.iter()).all(|x| x.is_finite()) && (0..2).all(|i| high[i] > low[i])) {
        return Err(failed("its boundary has no extent on its surface"));
    }
    let step = steps(face, &low, &high, chord);
    let mut work = Work {
        part,
        face,
        points,
        cuts,
        low,
        high,
        step,
        slack: points.slack().max(MEET * part.size),
        regions: Regions::new(),
        places: Vec::new(),
        known: BTreeMap::new(),
        of_vertex: BTreeMap::new(),
        poles: BTreeMap::new(),
        own: Vec::new(),
    };
    let mut lines = Vec::new();
    for piece in &pieces {
        lines.push(piece.map(|place| work.add(place.at, Some(place.id))));
    }
    work.frame(&mut lines);
    let handles: Vec<_> = work.places.clone().iter().enumerate().map(|(k, _)| work.insert(k)).collect();
    let mut crossed = Vec::new();
    let mut doubtful = vec![false; work.places.len()];
    for (k, &[a, b]) in lines.iter().enumerate() {
        if let (Some(from), Some(to)) = (handles[a], handles[b])
            && work.regions.constrain(from, to)
            && let Some(piece) = pieces.get(k)
        {
            let others = pieces.iter().filter(|other| cross(piece, other));
            crossed.extend(others.chain([piece]).filter_map(|piece| middle(part, face, piece)));
        }
    }
    let kept = work.kept();
    // The face lies on one side of its boundary. Where it does not in the plane, chords cut across it.
    for (piece, &[a, b]) in pieces.iter().zip(&lines) {
        let is_seam = middle(part, face, piece)
            .is_none_or(|(edge, _)| face.boundary.uses.iter().any(|used| used.edge == edge && used.seam));
        if let (false, Some(from), Some(to)) = (is_seam, handles[a], handles[b])
            && let Some([left, right]) = work.regions.sides(from, to, &kept)
            && left == right
        {
            (doubtful[a], doubtful[b]) = (true, true);
        }
    }
    for (piece, [a, b]) in pieces.iter().zip(lines) {
        if doubtful[a] || doubtful[b] {
            crossed.extend(middle(part, face, piece));
        }
    }
    work.fill(&kept);
    Ok(FaceMesh { crossed, ..work.refine(chord) })
}

/// The box of the plane that holds a face: a period where it is cut.
fn plane_box(
    face: &Face,
    places: impl Iterator<Item = Vector2<f64>>,
    cuts: &Cuts,
) -> (Vector2<f64>, Vector2<f64>) {
    let [low, high] = face.parameter_box();
    let (mut low, mut high) = if face.boundary.swap { (flip(low), flip(high)) } else { (low, high) };
    let none = (Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY));
    let (least, most) = places.fold(none, |(low, high), at| (low.inf(&at), high.sup(&at)));
    let ends = face.boundary.ends_inside();
    for axis in 0..2 {
        match cuts[axis] {
            Some(cut) => (low[axis], high[axis]) = (cut.at, cut.end()),
            // Where the face goes on to an end of its surface, or to its apex, the box says how far.
            None if axis == 1 && (ends[0] || ends[1] || face.apex_inside()) => {
                (low[axis], high[axis]) = (low[axis].min(least[axis]), high[axis].max(most[axis]));
            }
            None if least[axis] < most[axis] => (low[axis], high[axis]) = (least[axis], most[axis]),
            None => {}
        }
    }
    (low, high)
}

/// Steps of the parameters in which the surface bends by a share of the tolerance.
fn steps(face: &Face, low: &Vector2<f64>, high: &Vector2<f64>, chord: f64) -> Vector2<f64> {
    let mut bend = Vector2::<f64>::zeros();
    let mut looks: [Vec<f64>; 2] = [0, 1].map(|axis| {
        let share = |k: usize| k as f64 / (LOOKS - 1) as f64;
        (0..LOOKS).map(|k| low[axis] + (high[axis] - low[axis]) * share(k)).collect()
    });
    if let Some(spline) = face.surface.spline() {
        let breaks = spline.surface.breaks();
        for (axis, looks) in looks.iter_mut().enumerate() {
            let of = &breaks[if face.boundary.swap { 1 - axis } else { axis }];
            let middles = of.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            // A few hundred spans are looked at; what bends between shows in the refinement.
            let every = (of.len() / 200).max(1);
            looks.extend(middles.step_by(every).filter(|x| *x > low[axis] && *x < high[axis]));
        }
    }
    for x in &looks[0] {
        for y in &looks[1] {
            let at = Vector2::new(*x, *y);
            let uv = if face.boundary.swap { flip(at) } else { at };
            let (jet, normal) = (face.surface.jet(&uv), face.surface.normal(&uv));
            let second = Vector2::new(jet.duu.dot(&normal).abs(), jet.dvv.dot(&normal).abs());
            let second = if face.boundary.swap { flip(second) } else { second };
            bend = bend.sup(&second.map(|x| if x.is_finite() { x } else { 0.0 }));
        }
    }
    Vector2::from_fn(|axis, _| {
        let range = high[axis] - low[axis];
        let wanted = (8.0 * SHARE * chord / bend[axis]).sqrt();
        let count = (range / wanted).ceil();
        range / if count.is_finite() { count.clamp(1.0, MAX_STEPS) } else { 1.0 }
    })
}

impl Work<'_> {
    fn uv(&self, at: &Vector2<f64>) -> Vector2<f64> {
        if self.face.boundary.swap { flip(*at) } else { *at }
    }

    fn scaled(&self, at: &Vector2<f64>) -> [f64; 2] {
        [0, 1].map(|i| (at[i] - self.low[i]) / self.step[i])
    }

    fn unscaled(&self, at: [f64; 2]) -> Vector2<f64> {
        Vector2::from_fn(|i, _| self.low[i] + at[i] * self.step[i])
    }

    fn is_inside(&self, at: &Vector2<f64>) -> Option<bool> {
        match self.face.inside(&self.part.edges, &self.uv(at)) {
            Inside::In => Some(true),
            Inside::Out => Some(false),
            Inside::Near(_) => None,
        }
    }

    /// Adds a place with a vertex that is known, or one of its own; both sides of a cut have the same vertices.
    fn add(&mut self, at: Vector2<f64>, id: Option<usize>) -> usize {
        let key = [at.x.to_bits(), at.y.to_bits()];
        if let Some(place) = self.known.get(&key) {
            return *place;
        }
        // An edge that a face has on both sides comes twice, up to rounding; the edges at a vertex meet as far as they lie on
        // the surface.
        let is_same = |place: &&usize| {
            let other = self.places[**place].0;
            let apart = (0..2).map(|i| (other[i] - at[i]).abs() / (self.high[i] - self.low[i]));
            let apart = apart.fold(0.0, f64::max);
            let point = |at| self.face.surface.point(&self.uv(at));
            apart <= SAME || apart <= NEAR && (point(&other) - point(&at)).norm() <= self.slack
        };
        if let Some(place) = id.and_then(|id| self.of_vertex.get(&id)?.iter().find(is_same)) {
            return *place;
        }
        let known = id;
        let id = id.unwrap_or_else(|| self.vertex(&at));
        let mut first = None;
        for twin in self.twins(&at) {
            let key = [twin.x.to_bits(), twin.y.to_bits()];
            let place = self.known.get(&key).copied().unwrap_or_else(|| {
                self.places.push((twin, id));
                self.known.insert(key, self.places.len() - 1);
                if known.is_some() {
                    self.of_vertex.entry(id).or_default().push(self.places.len() - 1);
                }
                self.places.len() - 1
            });
            first.get_or_insert(place);
        }
        first.unwrap_or(0)
    }

    /// The place itself and its copies on the other sides of cuts.
    fn twins(&self, at: &Vector2<f64>) -> Vec<Vector2<f64>> {
        let mut out = vec![*at];
        for (axis, cut) in self.cuts.iter().enumerate().filter_map(|(axis, cut)| cut.map(|cut| (axis, cut))) {
            for k in 0..out.len() {
                let other = if out[k][axis] == cut.at {
                    cut.end()
                } else if out[k][axis] == cut.end() {
                    cut.at
                } else {
                    continue;
                };
                let mut twin = out[k];
                twin[axis] = other;
                out.push(twin);
            }
        }
        out
    }

    /// A new vertex on the surface; on a pole the one that is there.
    fn vertex(&mut self, at: &Vector2<f64>) -> usize {
        let jet = self.face.surface.jet(&self.uv(at));
        let tangents = if self.face.boundary.swap { [jet.dv, jet.du] } else { [jet.du, jet.dv] };
        let pole = (0..2).find(|axis| {
            tangents[*axis].norm() * (self.high[*axis] - self.low[*axis]) < POLE * self.part.size
        });
        let key = pole.map(|axis| (axis, at[1 - axis].to_bits()));
        if let Some(id) = key.and_then(|key| self.poles.get(&key)) {
            return *id;
        }
        let id = self.points.count() + self.own.len();
        self.own.push(self.face.surface.point(&self.uv(at)));
        if let Some(key) = key {
            self.poles.insert(key, id);
        }
        id
    }

    fn insert(&mut self, place: usize) -> Option<spade::handles::FixedVertexHandle> {
        let at = self.scaled(&self.places[place].0);
        self.regions.insert(Corner { at, place: Some(place) })
    }

    /// The sides of the box that may bound the face: cuts, ends of the surface, and the apex.
    fn frame(&mut self, lines: &mut Vec<[usize; 2]>) {
        let ends = self.face.boundary.ends_inside();
        let open = self.face.boundary.chords.is_empty();
        for axis in 0..2 {
            let is_end = match self.cuts[axis] {
                Some(_) => [true; 2],
                None if axis == 1 => [0, 1].map(|k| ends[k] || open || self.face.apex_inside()),
                None => [open; 2],
            };
            for (k, value) in [self.low[axis], self.high[axis]].into_iter().enumerate() {
                if is_end[k] {
                    self.side(axis, value, lines);
                }
            }
        }
    }

    /// A side of the box, with a place at every step and at every place that is on it.
    fn side(&mut self, axis: usize, value: f64, lines: &mut Vec<[usize; 2]>) {
        let along = 1 - axis;
        let mut stations: Vec<f64> =
            self.places.iter().filter(|(at, _)| at[axis] == value).map(|(at, _)| at[along]).collect();
        let count = ((self.high[along] - self.low[along]) / self.step[along]).round().max(1.0);
        let own = |k: f64| if k == count { self.high[along] } else { self.low[along] + k * self.step[along] };
        let mut k = 0.0;
        while k <= count {
            let station = own(k);
            let is_free = |other: &f64| (other - station).abs() > 0.3 * self.step[along];
            // The ends of the box are always there, so that its sides meet.
            if k == 0.0 || k == count || stations.iter().all(is_free) {
                stations.push(station);
            }
            k += 1.0;
        }
        stations.sort_by(f64::total_cmp);
        stations.dedup();
        let places: Vec<usize> = stations
            .into_iter()
            .map(|station| {
                let mut at = Vector2::repeat(value);
                at[along] = station;
                self.add(at, None)
            })
            .collect();
        lines.extend(places.windows(2).map(|pair| [pair[0], pair[1]]));
    }

    /// Which triangles belong to the face.
    fn kept(&self) -> Vec<bool> {
        self.regions.inside(|at| self.is_inside(&self.unscaled(at)))
    }

    /// Places at all steps inside of the face.
    fn fill(&mut self, kept: &[bool]) {
        let counts = [0, 1].map(|i| ((self.high[i] - self.low[i]) / self.step[i]).round().max(1.0));
        let mut found = Vec::new();
        let mut i = 1.0;
        while i < counts[0] {
            let mut j = 1.0;
            while j < counts[1] && found.len() < MOST {
                if self.regions.takes([i, j], kept, APART) {
                    found.push([i, j]);
                }
                j += 1.0;
            }
            i += 1.0;
        }
        for at in found {
            self.put(at);
        }
    }

    /// Adds a place inside of the face, in steps.
    fn put(&mut self, at: [f64; 2]) {
        let place = self.unscaled(at);
        let id = self.points.count() + self.own.len();
        self.own.push(self.face.surface.point(&self.uv(&place)));
        self.places.push((place, id));
        self.regions.insert(Corner { at, place: Some(self.places.len() - 1) });
    }

    /// Adds places until the triangles are near enough, and gives them out.
    fn refine(mut self, chord: f64) -> FaceMesh {
        let mut found = self.examine(chord);
        for _ in 0..ROUNDS {
            if found.wanted.is_empty() || self.places.len() + found.wanted.len() > MOST {
                break;
            }
            for place in found.wanted.into_values() {
                self.put(place);
            }
            found = self.examine(chord);
        }
        self.finish(&found.triangles, found.deviation)
    }

    /// The triangles of the face, how far they are from it, and where places would bring them nearer.
    fn examine(&self, chord: f64) -> Examined {
        let kept = self.kept();
        let mut out =
            Examined { triangles: self.regions.triangles(&kept), deviation: 0.0, wanted: BTreeMap::new() };
        for (corners, free) in &out.triangles {
            let ends = corners.map(|corner| self.position(&corner));
            let normal = (ends[1] - ends[0]).cross(&(ends[2] - ends[0])).try_normalize(0.0);
            let Some(normal) = normal else { continue };
            let third = 1.0 / 3.0;
            let looks = [
                ([third, third, third], true),
                ([0.5, 0.5, 0.0], free[0]),
                ([0.0, 0.5, 0.5], free[1]),
                ([0.5, 0.0, 0.5], free[2]),
            ];
            let far = looks.map(|(w, is_free)| {
                let at = [0, 1].map(|i| (0..3).map(|k| w[k] * corners[k].at[i]).sum::<f64>());
                let point = self.face.surface.point(&self.uv(&self.unscaled(at)));
                let flat = ends[0] * w[0] + ends[1] * w[1] + ends[2] * w[2];
                ((point - flat).dot(&normal).abs(), is_free, at)
            });
            out.deviation = far.iter().fold(out.deviation, |most, look| most.max(look.0));
            let free = far.iter().filter(|(distance, is_free, _)| *is_free && *distance > chord);
            if let Some((_, _, at)) = free.max_by(|a, b| a.0.total_cmp(&b.0)) {
                out.wanted.insert(at.map(f64::to_bits), *at);
            }
        }
        out
    }

    fn position(&self, corner: &Corner) -> Vector3<f64> {
        match corner.place.map(|place| self.places[place].1) {
            Some(id) if id < self.points.count() => self.points.point(id),
            Some(id) => self.own[id - self.points.count()],
            None => self.face.surface.point(&self.uv(&self.unscaled(corner.at))),
        }
    }

    /// The vertex of an edge that is as near to a point as edges are to their surfaces: edges that meet there may cross next to
    /// it.
    fn vertex_near(&self, point: &Vector3<f64>) -> Option<usize> {
        let shared = self.places.iter().map(|(_, id)| *id).filter(|id| *id < self.points.count());
        let far = |id: usize| (self.points.point(id) - point).norm();
        let nearest = shared.min_by(|a, b| far(*a).total_cmp(&far(*b)))?;
        (far(nearest) <= self.slack).then_some(nearest)
    }

    fn finish(mut self, triangles: &[([Corner; 3], [bool; 3])], deviation: f64) -> FaceMesh {
        let shared = self.points.count();
        let mut out = FaceMesh {
            triangles: Vec::new(),
            normals: Vec::new(),
            own: Vec::new(),
            shared,
            deviation,
            crossed: Vec::new(),
        };
        let reverse = self.face.boundary.swap == self.face.same_sense;
        let mut crossings: BTreeMap<[u64; 2], usize> = BTreeMap::new();
        for (corners, _) in triangles {
            let mut ids = corners.map(|corner| match corner.place {
                Some(place) => self.places[place].1,
                None => *crossings.entry(corner.at.map(f64::to_bits)).or_insert_with(|| {
                    let point = self.position(&corner);
                    self.vertex_near(&point).unwrap_or_else(|| {
                        self.own.push(point);
                        shared + self.own.len() - 1
                    })
                }),
            });
            // Along a pole the triangles of the plane have no area.
            if ids[0] == ids[1] || ids[1] == ids[2] || ids[2] == ids[0] {
                continue;
            }
            let centre =
                self.unscaled([0, 1].map(|i| (corners[0].at[i] + corners[1].at[i] + corners[2].at[i]) / 3.0));
            let middle = self.face.normal(self.uv(&centre).into());
            let mut normals = corners.map(|corner| {
                let normal = self.face.normal(self.uv(&self.unscaled(corner.at)).into());
                if normal == Vector3::zeros() { middle } else { normal }
            });
            if reverse {
                ids.swap(1, 2);
                normals.swap(1, 2);
            }
            out.triangles.push(ids);
            out.normals.push(normals);
        }
        out.own = self.own;
        out
    }
}
