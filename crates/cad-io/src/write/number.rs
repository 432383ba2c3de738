//! Numbers as text that reads back to the same bits.

/// The shortest text of a finite number, with a decimal point as STEP and IGES want it, and `mark` before the exponent.
pub(crate) fn real(value: f64, mark: char) -> String {
    let text = format!("{value:?}");
    let Some((mantissa, exponent)) = text.split_once('e') else {
        return text
            .strip_suffix('0')
            .filter(|short| short.ends_with('.'))
            .map(str::to_owned)
            .unwrap_or(text);
    };
    let point = if mantissa.contains('.') { "" } else { "." };
    format!("{mantissa}{point}{mark}{exponent}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_comes_back() {
        let cases =
            [(0.0, "0."), (-0.0, "-0."), (1.0, "1."), (0.1, "0.1"), (1e-7, "1.E-7"), (1.5e300, "1.5E300")];
        for (value, text) in cases {
            assert_eq!(real(value, 'E'), text);
        }
        let mut state = 1_u64;
        for _ in 0..10_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let value = f64::from_bits(state);
            if value.is_finite() {
                let text = real(value, 'E');
                assert!(text.contains('.'), "{text}");
                assert_eq!(text.parse::<f64>().map(f64::to_bits), Ok(state), "{text}");
            }
        }
    }
}
