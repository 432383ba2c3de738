//! The numbers of Tables 1 to 5 as they are printed in \[HW05\], and how each relates to what is computed.

use super::digits::Relation;

/// One printed step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Printed {
    pub(crate) text: &'static str,
    /// How it relates to the result of the iteration that the table describes.
    pub(crate) relation: Relation,
}

const fn ok(text: &'static str) -> Printed {
    Printed { text, relation: Relation::Equal }
}

const fn cut_off(text: &'static str) -> Printed {
    Printed { text, relation: Relation::CutOff }
}

const fn misprint(text: &'static str) -> Printed {
    Printed { text, relation: Relation::Misprint }
}

/// The footpoint's parameter in Table 1, `x = (1, 0.8)`.
pub(crate) const SOLUTION_1_A: Printed = ok("0.982347");

/// The same for `x = (2, 2)`: cut off instead of rounded.
pub(crate) const SOLUTION_1_B: Printed = cut_off("1.783812");

/// The footpoint's parameter in Table 2, `x = (381, 252)`.
pub(crate) const SOLUTION_2_A: Printed = ok("0.7695140103");

/// The footpoint's parameter in Tables 2 and 3, `x = (332, 200)`.
pub(crate) const SOLUTION_2_B: Printed = ok("0.6223419238");

/// Table 1, `x = (1, 0.8)`: first and second order.
pub(crate) const TABLE_1_A: [&[Printed]; 2] = [
    &[cut_off("8.1e-02"), cut_off("2.7e-03"), ok("5.7e-05"), ok("1.2e-06"), ok("2.3e-08"), misprint("0.0")],
    &[ok("8.4e-02"), ok("1.8e-04"), ok("6.0e-10"), ok("0.0")],
];

/// Table 1, `x = (2, 2)`.
pub(crate) const TABLE_1_B: [&[Printed]; 2] = [
    &[ok("-2.2e-02"), ok("2.1e-02"), ok("-2.0e-02"), ok("1.9e-02"), ok("-1.8e-02"), ok("1.7e-02")],
    &[ok("-1.1e-02"), ok("2.5e-05"), ok("1.0e-10"), ok("0.0")],
];

/// Table 2, `x = (381, 252)`.
pub(crate) const TABLE_2_A: [&[Printed]; 2] = [
    &[
        ok("3.2e-02"),
        cut_off("-2.3e-02"),
        misprint("-1.8e-02"),
        ok("-1.4e-02"),
        ok("1.1e-02"),
        ok("-8.8e-03"),
    ],
    &[ok("2.1e-02"), ok("-1.2e-03"), ok("-4.1e-06"), ok("0.0")],
];

/// Table 2, `x = (332, 200)`.
pub(crate) const TABLE_2_B: [&[Printed]; 2] = [
    &[ok("8.5e-02"), ok("2.9e-02"), ok("6.9e-03"), ok("1.3e-03"), ok("2.2e-04"), ok("3.9e-05")],
    &[ok("1.2e-01"), ok("1.2e-03"), ok("-3.8e-06"), ok("0.0")],
];

/// Table 3: initial parameter and steps of the second order iteration for `x = (332, 200)`.
pub(crate) const TABLE_3: [(f64, &[Printed]); 6] = [
    (0.3, &[ok("1.4e-01"), ok("1.7e-01"), ok("1.1e-02"), ok("-2.9e-04"), ok("-2.0e-07"), ok("0.0")]),
    (0.4, &[ok("2.0e-01"), ok("2.0e-02"), ok("-1.1e-03"), misprint("2.7e-06"), ok("0.0")]),
    (0.5, &[ok("1.2e-01"), ok("1.2e-03"), ok("-3.8e-06"), ok("0.0")]),
    (0.6, &[ok("2.4e-02"), ok("-1.4e-03"), ok("-5.1e-06"), misprint("1.0e-10")]),
    (0.7, &[ok("-6.6e-02"), ok("-1.1e-02"), ok("-2.9e-04"), ok("-2.0e-07"), ok("0.0")]),
    (0.8, &[ok("-1.1e-01"), ok("-6.1e-02"), ok("-9.0e-03"), ok("-1.9e-04"), misprint("8.8e-08"), ok("0.0")]),
];

/// Table 4: first order `Δu`, `Δv`, then second order.
pub(crate) const TABLE_4: [&[Printed]; 4] = [
    &[
        ok("-3.8e-02"),
        misprint("-2.4e-06"),
        ok("-3.8e-04"),
        misprint("-1.4e-04"),
        ok("-4.3e-05"),
        ok("1.2e-05"),
    ],
    &[ok("-5.4e-02"), ok("1.4e-02"), ok("-2.6e-03"), misprint("-5.1e-04"), ok("-1.1e-04"), ok("2.5e-05")],
    &[ok("-3.4e-02"), ok("-4.3e-03"), ok("3.8e-05"), ok("-5.1e-06"), ok("9.0e-08"), ok("-1.2e-08")],
    &[ok("-4.8e-02"), ok("6.5e-03"), ok("2.3e-04"), ok("7.3e-08"), ok("5.4e-07"), ok("2.0e-10")],
];

/// The steps that Table 5 shows.
pub(crate) const TABLE_5_STEPS: [usize; 6] = [1, 2, 3, 4, 5, 10];

/// Table 5: first order `Δu`, `Δv`, then second order.
pub(crate) const TABLE_5: [&[Printed]; 4] = [
    &[ok("6.9e-02"), ok("-7.3e-02"), ok("9.6e-02"), ok("-1.0e-01"), ok("1.2e-01"), ok("-1.2e-01")],
    &[ok("6.3e-02"), ok("2.5e-02"), ok("-7.0e-02"), ok("7.6e-02"), ok("-9.7e-02"), ok("1.0e-01")],
    &[ok("3.1e-02"), ok("-9.4e-03"), ok("7.0e-03"), ok("-4.9e-04"), ok("7.8e-04"), ok("-1.5e-07")],
    &[ok("2.9e-02"), ok("3.8e-02"), ok("1.4e-03"), ok("5.5e-03"), ok("5.1e-06"), ok("2.3e-06")],
];
