//! Tables 1 to 5 of \[HW05\], computed with the library.

use super::printed::{self, Printed};
use crate::examples;
use footpoint::local::{
    LocalOptions, Method, iterate_curve, iterate_surface, project_curve, project_surface,
};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{Error, ParametricCurve};

/// One of the paper's tables.
#[derive(Debug)]
pub(crate) struct Table {
    pub(crate) number: usize,
    pub(crate) about: &'static str,
    pub(crate) blocks: Vec<Block>,
}

/// A test point of a table with the rows that belong to it.
#[derive(Debug)]
pub(crate) struct Block {
    pub(crate) title: String,
    /// The numbers of the steps shown.
    pub(crate) steps: Vec<usize>,
    pub(crate) rows: Vec<Row>,
    pub(crate) solutions: Vec<Solution>,
}

/// The increments of one parameter by one method.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) label: String,
    pub(crate) computed: Vec<f64>,
    pub(crate) printed: &'static [Printed],
}

/// A parameter of the footpoint.
#[derive(Debug)]
pub(crate) struct Solution {
    pub(crate) name: &'static str,
    pub(crate) computed: f64,
    /// As printed, if the paper gives it.
    pub(crate) printed: Option<Printed>,
}

/// All tables, in order.
pub(crate) fn tables() -> Result<Vec<Table>, Error> {
    Ok(vec![table_1()?, table_2()?, table_3()?, table_4()?, table_5()?])
}

/// The paper's choice for curves: eq. (5).
const CURVE_METHODS: [Method; 2] = [Method::FirstOrder, Method::SecondOrderTaylor];

/// For surfaces: eqs. (12)-(15) with eq. (7).
const SURFACE_METHODS: [Method; 2] = [Method::FirstOrder, Method::SecondOrder];

/// Exactly `n` steps of a method.
fn fixed_steps(method: Method, n: usize) -> LocalOptions {
    let n = u32::try_from(n).unwrap_or(u32::MAX);
    LocalOptions::default().with_method(method).with_parameter_tolerance(0.0).with_max_iterations(n)
}

fn curve_steps<C: ParametricCurve<2>>(
    curve: &C,
    x: [f64; 2],
    t0: f64,
    method: Method,
    steps: &[usize],
) -> Vec<f64> {
    let last = steps.iter().copied().max().unwrap_or(0);
    let trace = iterate_curve(curve, &Vector2::from(x), t0, &fixed_steps(method, last));
    // An iteration that meets its fixed point exactly ends early: the steps after it are zero.
    steps.iter().map(|&k| trace.steps.get(k - 1).map_or(0.0, |step| step.delta)).collect()
}

fn curve_block<C: ParametricCurve<2>>(
    curve: &C,
    x: [f64; 2],
    t0: f64,
    printed: [&'static [Printed]; 2],
    solution: Printed,
) -> Block {
    let steps: Vec<usize> = (1..=6).collect();
    let rows =
        ["Δt₁", "Δt₂"].into_iter().zip(CURVE_METHODS).zip(printed).map(|((label, method), printed)| Row {
            label: label.into(),
            computed: curve_steps(curve, x, t0, method, &steps[..printed.len()]),
            printed,
        });
    Block {
        title: format!("x = ({}, {}), t₀ = {t0}", x[0], x[1]),
        rows: rows.collect(),
        solutions: vec![curve_solution(curve, x, t0, solution)],
        steps,
    }
}

fn curve_solution<C: ParametricCurve<2>>(curve: &C, x: [f64; 2], t0: f64, printed: Printed) -> Solution {
    let foot = project_curve(curve, &Vector2::from(x), t0, &LocalOptions::default());
    Solution { name: "t", computed: foot.parameter, printed: Some(printed) }
}

fn table_1() -> Result<Table, Error> {
    let sine = examples::sine()?;
    let blocks = vec![
        curve_block(&sine, [1.0, 0.8], 0.898, printed::TABLE_1_A, printed::SOLUTION_1_A),
        curve_block(&sine, [2.0, 2.0], 1.795, printed::TABLE_1_B, printed::SOLUTION_1_B),
    ];
    Ok(Table {
        number: 1,
        about: "first and second order steps on the curve (t, sin t) of Example 1",
        blocks,
    })
}

fn table_2() -> Result<Table, Error> {
    let curve = examples::curve()?;
    let blocks = vec![
        curve_block(&curve, [381.0, 252.0], 0.75, printed::TABLE_2_A, printed::SOLUTION_2_A),
        curve_block(&curve, [332.0, 200.0], 0.5, printed::TABLE_2_B, printed::SOLUTION_2_B),
    ];
    Ok(Table { number: 2, about: "first and second order steps on the B-spline curve of Example 2", blocks })
}

fn table_3() -> Result<Table, Error> {
    let curve = examples::curve()?;
    let x = [332.0, 200.0];
    let steps: Vec<usize> = (1..=6).collect();
    let rows = printed::TABLE_3.iter().map(|&(t0, printed)| Row {
        label: format!("t₀ = {t0:.2}"),
        computed: curve_steps(&curve, x, t0, Method::SecondOrderTaylor, &steps[..printed.len()]),
        printed,
    });
    let block = Block {
        title: "x = (332, 200)".into(),
        rows: rows.collect(),
        solutions: vec![curve_solution(&curve, x, 0.3, printed::SOLUTION_2_B)],
        steps,
    };
    Ok(Table {
        number: 3,
        about: "second order steps in Example 2 from several initial parameters",
        blocks: vec![block],
    })
}

fn surface_block(
    x: [f64; 3],
    start: [f64; 2],
    steps: &[usize],
    printed: [&'static [Printed]; 4],
) -> Result<Block, Error> {
    let surface = examples::surface()?;
    let point = Vector3::from(x);
    let last = steps.iter().copied().max().unwrap_or(0);
    let mut rows = Vec::new();
    for (m, method) in SURFACE_METHODS.into_iter().enumerate() {
        let trace = iterate_surface(&surface, &point, start, &fixed_steps(method, last));
        for k in 0..2 {
            let computed =
                steps.iter().map(|&i| trace.steps.get(i - 1).map_or(0.0, |step| step.delta[k])).collect();
            let order = ["first", "second"][m];
            let label = format!("Δu{}, {order} order", ["¹", "²"][k]);
            rows.push(Row { label, computed, printed: printed[2 * m + k] });
        }
    }
    let foot = project_surface(&surface, &point, start, &LocalOptions::default());
    let solutions = ["u¹", "u²"].into_iter().zip(foot.parameter);
    Ok(Block {
        title: format!("x = ({}, {}, {}), (u¹₀, u²₀) = ({}, {})", x[0], x[1], x[2], start[0], start[1]),
        steps: steps.to_vec(),
        rows,
        solutions: solutions.map(|(name, computed)| Solution { name, computed, printed: None }).collect(),
    })
}

fn table_4() -> Result<Table, Error> {
    let block = surface_block([120.0, 10.0, 100.0], [0.9, 0.6], &[1, 2, 3, 4, 5, 6], printed::TABLE_4)?;
    Ok(Table {
        number: 4,
        about: "first and second order steps on the B-spline surface of Example 3",
        blocks: vec![block],
    })
}

fn table_5() -> Result<Table, Error> {
    let block = surface_block([-120.0, 10.0, 100.0], [0.1, 0.6], &printed::TABLE_5_STEPS, printed::TABLE_5)?;
    Ok(Table {
        number: 5,
        about: "a point in Example 3 for which the first order method fails",
        blocks: vec![block],
    })
}
