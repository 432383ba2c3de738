//! Numbers in the form in which the paper prints them.

/// A step as the paper prints it: rounded to 10 decimals, then to 2 significant digits, halves away from
/// zero; `0.0` for zero.
///
/// Both roundings work on the decimal digits, so that the last one does not depend on how a binary number
/// happens to lie.
pub(crate) fn two_digits(step: f64) -> String {
    let sign = if step < 0.0 { "-" } else { "" };
    let digits = format!("{:.0}", (step.abs() * 1e10).round());
    if digits == "0" || !step.is_finite() {
        return if step.is_finite() { "0.0".into() } else { step.to_string() };
    }
    let digit = |i: usize| digits.as_bytes().get(i).map_or(0, |b| b - b'0');
    let mut mantissa = digit(0) * 10 + digit(1) + u8::from(digit(2) >= 5);
    let mut exponent = i32::try_from(digits.len()).unwrap_or(i32::MAX) - 11;
    if mantissa == 100 {
        mantissa = 10;
        exponent += 1;
    }
    let exponent_sign = if exponent < 0 { '-' } else { '+' };
    format!("{sign}{}.{}e{exponent_sign}{:02}", mantissa / 10, mantissa % 10, exponent.abs())
}

/// Four significant digits, to show what a misprint should have been.
pub(crate) fn four_digits(step: f64) -> String {
    format!("{step:.3e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_decimal_digits() {
        assert_eq!(two_digits(0.0815113), "8.2e-02");
        assert_eq!(two_digits(-2.34931e-8), "-2.4e-08");
        assert_eq!(two_digits(4.9e-11), "0.0");
        assert_eq!(two_digits(6.2e-11), "1.0e-10");
        assert_eq!(two_digits(0.0999), "1.0e-01");
        assert_eq!(two_digits(12.34), "1.2e+01");
        assert_eq!(two_digits(f64::NAN), "NaN");
    }
}
