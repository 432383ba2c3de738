//! The shapes: steep, of high degree, of unequal weights, creased, collapsed, floating, noisy, round.

use crate::Outcome;
use measurements::random::Random;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Cone, Cylinder, Frame, Interval, KnotVector, Sphere, Torus};

/// A name and its surface.
pub(crate) type Shape = (String, BsplineSurface);

/// A net of `n` control points over the unit square, moved by `change`, with the weights that `weight` tells.
struct Net {
    degrees: [usize; 2],
    n: [usize; 2],
}

impl Net {
    fn new(degrees: [usize; 2], n: [usize; 2]) -> Self {
        Self { degrees, n }
    }

    /// One patch.
    fn patch(degrees: [usize; 2]) -> Self {
        Self { degrees, n: degrees.map(|p| p + 1) }
    }

    fn clamped(&self) -> Outcome<[KnotVector; 2]> {
        let knots = |d: usize| KnotVector::uniform_clamped(self.degrees[d], self.n[d]);
        Ok([knots(0)?, knots(1)?])
    }

    /// Control points by their place in the unit square and their indices.
    fn points(&self, mut point: impl FnMut(f64, f64, [usize; 2]) -> Vector3<f64>) -> Vec<Vector3<f64>> {
        let share = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        (0..self.n[0])
            .flat_map(|i| (0..self.n[1]).map(move |j| [i, j]))
            .map(|[i, j]| point(share(i, self.n[0]), share(j, self.n[1]), [i, j]))
            .collect()
    }

    fn build(&self, point: impl FnMut(f64, f64, [usize; 2]) -> Vector3<f64>) -> Outcome<BsplineSurface> {
        let [u, v] = self.clamped()?;
        Ok(BsplineSurface::new(u, v, self.points(point), None)?)
    }

    /// Heights by chance over the unit square.
    fn noise(&self, seed: u64, height: f64) -> Outcome<BsplineSurface> {
        let mut random = Random(seed);
        self.build(|x, y, _| Vector3::new(x, y, random.between(-height, height)))
    }

    /// The same with weights between `1 / range` and `range`.
    fn weighted(&self, seed: u64, height: f64, range: f64) -> Outcome<BsplineSurface> {
        let mut random = Random(seed);
        let points = self.points(|x, y, _| Vector3::new(x, y, random.between(-height, height)));
        let weights = points.iter().map(|_| range.powf(random.between(-1.0, 1.0))).collect();
        let [u, v] = self.clamped()?;
        Ok(BsplineSurface::new(u, v, points, Some(weights))?)
    }
}

/// One bicubic patch over the unit square whose inner control points are `height` up.
fn bump(height: f64) -> Outcome<BsplineSurface> {
    Net::patch([3, 3]).build(|x, y, [i, j]| {
        let inner = (1..3).contains(&i) && (1..3).contains(&j);
        Vector3::new(x, y, if inner { height } else { 0.0 })
    })
}

/// A surface scaled and shifted.
fn moved(surface: &BsplineSurface, scale: f64, shift: f64) -> Outcome<BsplineSurface> {
    let points = surface.control_points().iter().map(|p| p * scale + Vector3::repeat(shift)).collect();
    let weights = surface.weights().map(<[f64]>::to_vec);
    Ok(BsplineSurface::new(surface.knots_u().clone(), surface.knots_v().clone(), points, weights)?)
}

/// All shapes.
pub(crate) fn all() -> Outcome<Vec<Shape>> {
    let mut shapes = Vec::new();
    let mut add = |name: &str, surface: BsplineSurface| shapes.push((name.to_owned(), surface));
    steep(&mut add)?;
    of_high_degree(&mut add)?;
    of_unequal_weights(&mut add)?;
    broken(&mut add)?;
    collapsed(&mut add)?;
    floating(&mut add)?;
    round(&mut add)?;
    Ok(shapes)
}

fn steep(add: &mut impl FnMut(&str, BsplineSurface)) -> Outcome<()> {
    for height in [1.0, 3.0, 10.0, 30.0, 100.0, 300.0] {
        add(&format!("bump h={height}"), bump(height)?);
    }
    for height in [1.0, 10.0, 100.0] {
        let spike =
            |x: f64, y: f64, at: [usize; 2]| Vector3::new(x, y, if at == [4, 3] { height } else { 0.0 });
        add(&format!("spike 8x8 h={height}"), Net::new([3, 3], [8, 8]).build(spike)?);
        add(&format!("spike degree 7 h={height}"), Net::patch([7, 7]).build(spike)?);
    }
    let ridge = |x: f64, y: f64, [i, _]: [usize; 2]| Vector3::new(x, y, if i == 4 { 20.0 } else { 0.0 });
    add("ridge", Net::new([3, 3], [9, 4]).build(ridge)?);
    let shear = |x: f64, y: f64, _: [usize; 2]| Vector3::new(x + 50.0 * y, y, 0.3 * (5.0 * x).sin());
    add("sheared", Net::new([3, 3], [8, 8]).build(shear)?);
    let strip = |x: f64, y: f64, _: [usize; 2]| Vector3::new(1000.0 * x, y, 5.0 * (9.0 * x).sin() * y);
    add("strip 1000:1", Net::new([3, 3], [12, 5]).build(strip)?);
    let uneven =
        |x: f64, y: f64, _: [usize; 2]| Vector3::new(x.powi(6), y.powi(4), 0.2 * x * (6.0 * y).cos());
    add("uneven speed", Net::new([3, 3], [9, 9]).build(uneven)?);
    let folded =
        |x: f64, y: f64, _: [usize; 2]| Vector3::new((3.0 * x - 1.0) * x * (x - 1.0) * 8.0, y, x * x);
    add("folded", Net::patch([3, 3]).build(folded)?);
    Ok(())
}

fn of_high_degree(add: &mut impl FnMut(&str, BsplineSurface)) -> Outcome<()> {
    for degrees in
        [[2, 2], [4, 4], [5, 5], [6, 6], [7, 7], [9, 5], [5, 9], [15, 3], [1, 9], [9, 9], [12, 12], [15, 15]]
    {
        let [p, q] = degrees;
        add(&format!("degree {p}x{q}"), Net::patch(degrees).noise(7 + p as u64, 0.4)?);
    }
    for degrees in [[4, 4], [6, 6], [11, 11]] {
        let [p, q] = degrees;
        add(&format!("degree {p}x{q}, 4 spans"), Net::new(degrees, degrees.map(|p| p + 2)).noise(3, 0.4)?);
    }
    add("degree 3, noise 30x30", Net::new([3, 3], [30, 30]).noise(30, 0.05)?);
    add("degree 3, noise 30x30, high", Net::new([3, 3], [30, 30]).noise(31, 0.3)?);
    add("degree 2, noise 20x20", Net::new([2, 2], [20, 20]).noise(32, 0.2)?);
    add("degree 5, noise 12x12", Net::new([5, 5], [12, 12]).noise(33, 0.2)?);
    Ok(())
}

fn of_unequal_weights(add: &mut impl FnMut(&str, BsplineSurface)) -> Outcome<()> {
    for range in [10.0, 1e3] {
        add(&format!("weights {range}, patch"), Net::patch([3, 3]).weighted(5, 0.3, range)?);
        add(&format!("weights {range}, 7x7"), Net::new([3, 3], [7, 7]).weighted(6, 0.15, range)?);
        add(&format!("weights {range}, degree 2"), Net::new([2, 2], [6, 6]).weighted(7, 0.2, range)?);
        add(&format!("weights {range}, degree 5"), Net::patch([5, 5]).weighted(8, 0.3, range)?);
        add(&format!("weights {range}, degree 9"), Net::patch([9, 9]).weighted(9, 0.3, range)?);
        add(&format!("weights {range}, degree 15"), Net::patch([15, 15]).weighted(10, 0.3, range)?);
    }
    Ok(())
}

fn broken(add: &mut impl FnMut(&str, BsplineSurface)) -> Outcome<()> {
    let knots = KnotVector::new(3, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3].map(f64::from).to_vec())?;
    let net = Net::new([3, 3], [10, 10]);
    let mut random = Random(40);
    let points = net.points(|x, y, _| Vector3::new(x, y, random.between(-0.15, 0.15)));
    add("creases", BsplineSurface::new(knots.clone(), knots, points, None)?);
    add("degree 1, one cell", Net::patch([1, 1]).noise(41, 0.7)?);
    add("degree 1, 6x6", Net::new([1, 1], [6, 6]).noise(42, 0.2)?);
    add("degree 1x3", Net::new([1, 3], [6, 7]).noise(43, 0.2)?);
    let roof = |x: f64, y: f64, _: [usize; 2]| Vector3::new(x, y, 0.5 - (x - 0.5).abs());
    add("roof", Net::new([1, 1], [3, 2]).build(roof)?);
    add("plane", Net::new([3, 3], [6, 6]).build(|x, y, _| Vector3::new(x, y, 0.0))?);
    Ok(())
}

fn collapsed(add: &mut impl FnMut(&str, BsplineSurface)) -> Outcome<()> {
    let cap = |x: f64, y: f64| {
        let angle = 5.5 * x;
        Vector3::new(y * angle.cos(), y * angle.sin(), 0.3 * (1.0 - y * y))
    };
    add("pole", Net::new([3, 3], [9, 6]).build(|x, y, _| cap(x, y))?);
    add(
        "cusped pole",
        Net::new([3, 3], [9, 6]).build(|x, y, _| cap(x, y) + Vector3::z() * (1.0 - y).powi(2))?,
    );
    let lens =
        |x: f64, y: f64, _: [usize; 2]| Vector3::new(x, (y - 0.5) * x * (1.0 - x), 0.2 * (x * y * 7.0).sin());
    add("two poles", Net::new([3, 3], [7, 7]).build(lens)?);
    let triangle = |x: f64, y: f64, _: [usize; 2]| Vector3::new(x, x * y, 0.1 * (8.0 * x * y).sin());
    add("triangle", Net::patch([3, 3]).build(triangle)?);
    let corner = |x: f64, y: f64, [i, j]: [usize; 2]| {
        if i + j <= 1 { Vector3::zeros() } else { Vector3::new(x, y, 0.3 * (x - y).powi(2)) }
    };
    add("collapsed corner", Net::patch([3, 3]).build(corner)?);
    let clustered = |x: f64, y: f64, _: [usize; 2]| {
        Vector3::new(170.0 * x, 60.0 * (y.max(0.35) - 0.35), 20.0 * (4.0 * x).cos() * (1.0 - y))
    };
    add("clustered", Net::new([3, 3], [8, 8]).build(clustered)?);
    Ok(())
}

fn floating(add: &mut impl FnMut(&str, BsplineSurface)) -> Outcome<()> {
    let knots = KnotVector::new(3, (0..12).map(|i| f64::from(i) + 0.3 * f64::from(i % 3)).collect())?;
    let net = Net::new([3, 3], [8, 8]);
    let mut random = Random(50);
    let points = net.points(|x, y, _| Vector3::new(x, y, random.between(-0.2, 0.2)));
    let surface = BsplineSurface::new(knots.clone(), knots, points, None)?;
    for (scale, shift) in [(1e6, 0.0), (1e-6, 0.0), (1.0, 1e3), (1.0, 1e6), (1e-3, 1.0), (1e3, -1e6)] {
        add(&format!("floating {scale:e}, at {shift:e}"), moved(&surface, scale, shift)?);
    }
    add("floating", surface);
    Ok(())
}

fn round(add: &mut impl FnMut(&str, BsplineSurface)) -> Outcome<()> {
    let sphere = Sphere::new(Frame::WORLD, 1.0)?.to_nurbs()?;
    let squeezed = |factors: [f64; 3]| -> Outcome<BsplineSurface> {
        let points =
            sphere.control_points().iter().map(|p| p.component_mul(&Vector3::from(factors))).collect();
        let weights = sphere.weights().map(<[f64]>::to_vec);
        Ok(BsplineSurface::new(sphere.knots_u().clone(), sphere.knots_v().clone(), points, weights)?)
    };
    add("ellipsoid", squeezed([3.0, 2.0, 1.0])?);
    add("needle", squeezed([1.0, 1.0, 50.0])?);
    add("disc", squeezed([1.0, 1.0, 0.02])?);
    add("torus", Torus::new(Frame::WORLD, 3.0, 1.0)?.to_nurbs()?);
    add("thin torus", Torus::new(Frame::WORLD, 3.0, 0.01)?.to_nurbs()?);
    add("spindle torus", Torus::new(Frame::WORLD, 1.0, 0.9)?.to_nurbs()?);
    add("cylinder", Cylinder::new(Frame::WORLD, 1.0, Interval::new(0.0, 2.0)?)?.to_nurbs()?);
    add("long cylinder", Cylinder::new(Frame::WORLD, 1.0, Interval::new(0.0, 500.0)?)?.to_nurbs()?);
    add("cone", Cone::new(Frame::WORLD, 1.0, 0.4, 2.0)?.to_nurbs()?);
    add("cone with apex", Cone::new(Frame::WORLD, 1.0, 0.0, 2.0)?.to_nurbs()?);
    add("sphere", sphere.clone());
    add("sphere at 1e6", moved(&sphere, 1.0, 1e6)?);
    let bowl = |x: f64, y: f64, _: [usize; 2]| {
        let (x, y) = (2.0 * x - 1.0, 2.0 * y - 1.0);
        Vector3::new(x, y, x * x + y * y)
    };
    add("bowl", Net::patch([3, 3]).build(bowl)?);
    let tube = |x: f64, y: f64, _: [usize; 2]| {
        let (a, b) = (7.0 * x, 6.0 * y);
        Vector3::new(
            2.0 * a.cos() + 0.4 * b.cos() * a.cos(),
            2.0 * a.sin() + 0.4 * b.cos() * a.sin(),
            a + 0.4 * b.sin(),
        )
    };
    add("helical tube", Net::new([3, 3], [20, 12]).build(tube)?);
    Ok(())
}
