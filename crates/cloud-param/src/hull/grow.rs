//! Growing a hull point by point.

use super::faces::{Face, NONE};
use super::predicates::Scaled;
use nalgebra::Vector3;

/// The faces of the hull that grows from a tetrahedron.
///
/// Why a point beyond a face that is removed lies beyond one of those that take its place, or inside: the way to it from the
/// removed face leaves the new hull through a face; it runs beyond the plane of the removed face, where no old face
/// that stayed can be.
pub(super) fn faces(scaled: &Scaled, corners: [u32; 4]) -> Vec<[u32; 3]> {
    let mut hull = Hull::new(scaled, corners);
    while let Some(face) = hull.waiting.pop() {
        if hull.faces[face as usize].alive && hull.faces[face as usize].first != NONE {
            hull.insert(face);
        }
    }
    hull.faces.into_iter().filter(|face| face.alive).map(|face| face.corners).collect()
}

struct Hull<'a> {
    scaled: &'a Scaled,
    faces: Vec<Face>,
    /// Places in `faces` to be used again.
    free: Vec<u32>,
    /// The point after each in the list of its face.
    next: Vec<u32>,
    /// Faces that may have points beyond.
    waiting: Vec<u32>,
    /// The new face that begins at a vertex of the horizon.
    at_vertex: Vec<u32>,
    visible: Vec<u32>,
    created: Vec<u32>,
}

impl<'a> Hull<'a> {
    fn new(scaled: &'a Scaled, [a, b, c, d]: [u32; 4]) -> Self {
        let count = scaled.points.len();
        let triangles =
            [([a, b, c], [1, 2, 3]), ([b, a, d], [0, 3, 2]), ([c, b, d], [0, 1, 3]), ([a, c, d], [0, 2, 1])];
        let faces = triangles.map(|(corners, neighbours)| Face::new(scaled, corners, neighbours)).to_vec();
        let mut hull = Self {
            scaled,
            faces,
            free: Vec::new(),
            next: vec![NONE; count],
            waiting: vec![0, 1, 2, 3],
            at_vertex: vec![NONE; count],
            visible: Vec::new(),
            created: vec![0, 1, 2, 3],
        };
        // In an order in which neighbours follow each other, they meet again in the lists.
        for point in spatial_order(&scaled.points) {
            hull.assign(point);
        }
        hull
    }

    /// Puts a point into the list of the first new face that it lies beyond.
    #[inline]
    fn assign(&mut self, point: u32) {
        for &face in &self.created {
            let face = &mut self.faces[face as usize];
            if let Some(distance) = face.beyond(self.scaled, point) {
                face.push(point, distance, &mut self.next);
                return;
            }
        }
    }

    /// Adds the farthest point of a face to the hull.
    fn insert(&mut self, face: u32) {
        let apex = self.faces[face as usize].farthest.0;
        self.find_visible(face, apex);
        self.cover(apex);
        let visible = std::mem::take(&mut self.visible);
        for &face in &visible {
            let mut point = self.faces[face as usize].first;
            while point != NONE {
                let after = self.next[point as usize];
                if point != apex {
                    self.assign(point);
                }
                point = after;
            }
        }
        self.free.extend_from_slice(&visible);
        self.visible = visible;
        let faces = &self.faces;
        self.waiting.extend(self.created.iter().filter(|&&face| faces[face as usize].first != NONE));
    }

    /// The faces that the apex lies beyond; they are connected.
    fn find_visible(&mut self, face: u32, apex: u32) {
        self.visible.clear();
        self.visible.push(face);
        self.faces[face as usize].alive = false;
        let mut done = 0;
        while let Some(&face) = self.visible.get(done) {
            done += 1;
            for neighbour in self.faces[face as usize].neighbours {
                let near = &mut self.faces[neighbour as usize];
                if near.alive && near.beyond(self.scaled, apex).is_some() {
                    near.alive = false;
                    self.visible.push(neighbour);
                }
            }
        }
    }

    /// Joins the apex with the border of the visible faces.
    fn cover(&mut self, apex: u32) {
        self.created.clear();
        for k in 0..self.visible.len() {
            let face = self.visible[k];
            for edge in 0..3 {
                let (start, end, outer) = self.faces[face as usize].edge(edge);
                if !self.faces[outer as usize].alive {
                    continue;
                }
                let new = Face::new(self.scaled, [start, end, apex], [outer, NONE, NONE]);
                let place = self.place(new);
                let outer = &mut self.faces[outer as usize];
                for back in 0..3 {
                    if outer.corners[back] == end && outer.corners[(back + 1) % 3] == start {
                        outer.neighbours[back] = place;
                    }
                }
                self.at_vertex[start as usize] = place;
                self.created.push(place);
            }
        }
        // The border is one closed polygon, so that each of its vertices begins one new face.
        for k in 0..self.created.len() {
            let place = self.created[k];
            let after = self.at_vertex[self.faces[place as usize].corners[1] as usize];
            self.faces[place as usize].neighbours[1] = after;
            self.faces[after as usize].neighbours[2] = place;
        }
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "a hull has fewer than twice as many faces as vertices"
    )]
    fn place(&mut self, face: Face) -> u32 {
        match self.free.pop() {
            Some(place) => {
                self.faces[place as usize] = face;
                place
            }
            None => {
                self.faces.push(face);
                (self.faces.len() - 1) as u32
            }
        }
    }
}

/// Indices of the points along Morton's curve.
fn spatial_order(points: &[Vector3<f64>]) -> Vec<u32> {
    let (mut low, mut high) = (points[0], points[0]);
    for p in points {
        low = low.inf(p);
        high = high.sup(p);
    }
    let scale = 1023.0 / (high - low).max();
    let spread = |value: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 1023")]
        let cell = value as u32;
        (0..10).fold(0u32, |code, bit| code | ((cell >> bit & 1) << (3 * bit)))
    };
    let code = |p: &Vector3<f64>| {
        let cell = (p - low) * scale;
        spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
    };
    let mut order: Vec<(u32, u32)> = points.iter().zip(0u32..).map(|(p, i)| (code(p), i)).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, index)| index).collect()
}
