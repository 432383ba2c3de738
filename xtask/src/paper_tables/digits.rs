//! Numbers in the form in which the paper prints them, and how a printed one relates to what is computed.

/// Decimals to which the paper rounds a step before it rounds to significant digits.
const DECIMALS: i32 = 10;

/// How a printed number relates to the computed one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    /// The computed value rounded to the digits of the printed one, or to 10 decimals first.
    Equal,
    /// The computed value cut off after the digits of the printed one.
    CutOff,
    /// Neither: other digits, another sign or another exponent.
    Misprint,
}

impl Relation {
    /// The mark in the tables.
    pub(crate) fn mark(self) -> &'static str {
        match self {
            Self::Equal => "=",
            Self::CutOff => "cut off",
            Self::Misprint => "misprint",
        }
    }
}

/// How a printed step (`2.3e-08`, or `0.0` for zero) relates to the computed one.
pub(crate) fn of_step(computed: f64, printed: &str) -> Relation {
    if two_digits(computed) == printed || two_digits_of_decimals(computed) == printed {
        Relation::Equal
    } else if cut_off(computed) == printed {
        Relation::CutOff
    } else {
        Relation::Misprint
    }
}

/// How a printed number with decimals and without an exponent relates to the computed one.
pub(crate) fn of_decimals(computed: f64, printed: &str) -> Relation {
    let decimals = decimals(printed);
    if format!("{computed:.decimals$}") == printed {
        return Relation::Equal;
    }
    // One decimal is one byte.
    let exact = format!("{computed:.60}");
    let cut = exact.len() - 60 + decimals;
    if exact.get(..cut) == Some(printed) { Relation::CutOff } else { Relation::Misprint }
}

/// The number of decimals.
pub(crate) fn decimals(printed: &str) -> usize {
    printed.split_once('.').map_or(0, |(_, decimals)| decimals.len())
}

/// A step rounded to 2 significant digits; `0.0` for zero.
pub(crate) fn two_digits(step: f64) -> String {
    if step == 0.0 { "0.0".into() } else { scientific(&format!("{step:.1e}")) }
}

/// A step rounded to 10 decimals, then to 2 significant digits, halves away from zero; `0.0` for zero.
///
/// Both roundings work on the decimal digits, so that the last one does not depend on how a binary number
/// happens to lie.
fn two_digits_of_decimals(step: f64) -> String {
    let sign = if step < 0.0 { "-" } else { "" };
    let digits = format!("{:.0}", (step.abs() * 1e10).round());
    if digits == "0" || !step.is_finite() {
        return if step.is_finite() { "0.0".into() } else { step.to_string() };
    }
    let digit = |i: usize| digits.as_bytes().get(i).map_or(0, |b| b - b'0');
    let mut mantissa = digit(0) * 10 + digit(1) + u8::from(digit(2) >= 5);
    let mut exponent = i32::try_from(digits.len()).unwrap_or(i32::MAX) - 1 - DECIMALS;
    if mantissa == 100 {
        mantissa = 10;
        exponent += 1;
    }
    scientific(&format!("{sign}{}.{}e{exponent}", mantissa / 10, mantissa % 10))
}

/// A step cut off after 2 significant digits; `0.0` where nothing is left at 10 decimals.
fn cut_off(step: f64) -> String {
    if step.abs() < 0.1f64.powi(DECIMALS) {
        return "0.0".into();
    }
    let exact = format!("{step:.40e}");
    let (mantissa, exponent) = exact.split_once('e').unwrap_or((&exact, "0"));
    let length = if step < 0.0 { 4 } else { 3 };
    scientific(&format!("{}e{exponent}", mantissa.get(..length).unwrap_or(mantissa)))
}

/// `2.3e-8` with an exponent of two digits and a sign, as in the paper.
fn scientific(text: &str) -> String {
    let Some((mantissa, exponent)) = text.split_once('e') else { return text.to_owned() };
    let (sign, digits) = exponent.strip_prefix('-').map_or(('+', exponent), |digits| ('-', digits));
    format!("{mantissa}e{sign}{digits:0>2}")
}

/// Four significant digits, to show what a number that is not as printed should have been.
pub(crate) fn four_digits(step: f64) -> String {
    format!("{step:.3e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_rounded_once_or_after_ten_decimals() {
        for (computed, printed, relation) in [
            (0.0815113, "8.2e-02", Relation::Equal),
            (0.0815113, "8.1e-02", Relation::CutOff),
            (0.0815113, "-8.2e-02", Relation::Misprint),
            (-0.02378, "-2.3e-02", Relation::CutOff),
            (0.01875, "-1.8e-02", Relation::Misprint),
            (2.3493e-8, "2.3e-08", Relation::Equal),
            (2.3493e-8, "2.4e-08", Relation::Equal), // to 10 decimals 2.35e-8, and then to 2 digits
            (2.3493e-8, "2.3e-07", Relation::Misprint),
            (4.9e-11, "0.0", Relation::Equal),
            (4.9e-11, "4.9e-11", Relation::Equal),
            (6.2e-11, "1.0e-10", Relation::Equal),
            (6.2e-11, "0.0", Relation::CutOff),
            (-6.2e-11, "1.0e-10", Relation::Misprint),
            (4.751e-10, "0.0", Relation::Misprint),
            (0.0999, "1.0e-01", Relation::Equal),
            (12.34, "1.2e+01", Relation::Equal),
            (0.0, "0.0", Relation::Equal),
            (f64::NAN, "0.0", Relation::Misprint),
        ] {
            assert_eq!(of_step(computed, printed), relation, "{computed} and {printed}");
        }
    }

    #[test]
    fn parameters_are_rounded_or_cut_off() {
        for (computed, printed, relation) in [
            (0.9823472932, "0.982347", Relation::Equal),
            (1.7838126561, "1.783813", Relation::Equal),
            (1.7838126561, "1.783812", Relation::CutOff),
            (1.7838126561, "1.783811", Relation::Misprint),
            (-0.75, "-0.7", Relation::CutOff),
            (f64::NAN, "0.0", Relation::Misprint),
        ] {
            assert_eq!(of_decimals(computed, printed), relation, "{computed} and {printed}");
        }
    }
}
