//! Shares as text that never claims more than is true.
//!
//! A share that is rounded to the nearest hundredth reads 100.00 % while a point is out of tolerance. Here shares are cut or
//! raised to hundredths of a percent by their decimal digits, towards the side that is worse for the part, so that
//! 100.00 % means all and 0.00 % means none where that is the good news.

/// The side to which a share is rounded: the one that is worse for the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// Downwards: for shares that should be large, such as that of the points within a tolerance.
    Down,
    /// Upwards: for shares that should be small, such as that of the points beyond it.
    Up,
}

/// `part` of `whole` in percent, with two decimals; 0.00 % of nothing.
///
/// ```
/// use inspection::{Rounding, percent};
///
/// assert_eq!(percent(9_999_999, 10_000_000, Rounding::Down), "99.99 %");
/// assert_eq!(percent(1, 10_000_000, Rounding::Up), "0.01 %");
/// assert_eq!(percent(3, 3, Rounding::Down), "100.00 %");
/// ```
#[must_use]
pub fn percent(part: u64, whole: u64, rounding: Rounding) -> String {
    let (part, whole) = (u128::from(part) * 10_000, u128::from(whole.max(1)));
    text(match rounding {
        Rounding::Down => part / whole,
        Rounding::Up => part.div_ceil(whole),
    })
}

/// A share, not negative, of which no counts are known, in percent with two decimals; `–` for NaN.
///
/// The digits that are rounded are those of the shortest decimal number that reads back as `share`: 0.57 is 57.00 %.
///
/// ```
/// use inspection::{Rounding, percent_of_share};
///
/// assert_eq!(percent_of_share(0.999_999_9, Rounding::Down), "99.99 %");
/// assert_eq!(percent_of_share(0.57, Rounding::Down), "57.00 %");
/// ```
#[must_use]
pub fn percent_of_share(share: f64, rounding: Rounding) -> String {
    let Some((whole, fraction)) = digits(share) else { return "–".to_owned() };
    let (kept, rest) = fraction.split_at(fraction.len().min(4));
    let kept = format!("{whole}{kept:0<4}").parse::<u128>().unwrap_or(u128::MAX);
    let raised = rounding == Rounding::Up && rest.bytes().any(|digit| digit != b'0');
    text(kept.saturating_add(u128::from(raised)))
}

/// A share that was asked for, in percent with all its digits, as few as they are: 0.99999 is 99.999 %.
#[must_use]
pub fn percent_in_full(share: f64) -> String {
    let Some((whole, fraction)) = digits(share) else { return "–".to_owned() };
    let (shifted, rest) = fraction.split_at(fraction.len().min(2));
    let number = format!("{whole}{shifted:0<2}");
    let number = number.trim_start_matches('0');
    let number = if number.is_empty() { "0" } else { number };
    let rest = rest.trim_end_matches('0');
    if rest.is_empty() { format!("{number} %") } else { format!("{number}.{rest} %") }
}

/// The decimal digits of a share before and after the point.
fn digits(share: f64) -> Option<(String, String)> {
    // Numbers print without an exponent, with the fewest digits that read back to the same bits.
    let printed = (share >= 0.0 && share.is_finite()).then(|| format!("{share}"))?;
    let (whole, fraction) = printed.split_once('.').unwrap_or((&printed, ""));
    Some((whole.to_owned(), fraction.to_owned()))
}

fn text(hundredths: u128) -> String {
    format!("{}.{:02} %", hundredths / 100, hundredths % 100)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nothing_is_rounded_to_all_or_none() {
        let most = u64::MAX - 1;
        assert_eq!(percent(most, u64::MAX, Rounding::Down), "99.99 %");
        assert_eq!(percent(1, u64::MAX, Rounding::Up), "0.01 %");
        assert_eq!(percent(u64::MAX, u64::MAX, Rounding::Up), "100.00 %");
        assert_eq!(percent(0, 7, Rounding::Up), "0.00 %");
        assert_eq!(percent(0, 0, Rounding::Up), "0.00 %");
        assert_eq!([percent(1, 3, Rounding::Down), percent(1, 3, Rounding::Up)], ["33.33 %", "33.34 %"]);
    }

    #[test]
    fn digits_are_those_that_were_typed() {
        for (share, down, up, full) in [
            (0.57, "57.00 %", "57.00 %", "57 %"),
            (0.999_999, "99.99 %", "100.00 %", "99.9999 %"),
            (1e-7, "0.00 %", "0.01 %", "0.00001 %"),
            (0.0, "0.00 %", "0.00 %", "0 %"),
            (1.0, "100.00 %", "100.00 %", "100 %"),
            (0.95, "95.00 %", "95.00 %", "95 %"),
            (0.5, "50.00 %", "50.00 %", "50 %"),
            (f64::NAN, "–", "–", "–"),
        ] {
            let found = [
                percent_of_share(share, Rounding::Down),
                percent_of_share(share, Rounding::Up),
                percent_in_full(share),
            ];
            assert_eq!(found, [down, up, full], "{share}");
        }
    }

    proptest! {
        /// What is printed lies on the bad side of the share, by less than a hundredth of a percent.
        #[test]
        fn texts_bound_the_share(part in 0u64..1 << 40, more in 0u64..1 << 40) {
            let whole = (part + more).max(1);
            let value = |text: String| text.trim_end_matches(" %").replace('.', "").parse::<u128>().unwrap();
            let (down, up) = (value(percent(part, whole, Rounding::Down)), value(percent(part, whole, Rounding::Up)));
            let exact = u128::from(part) * 10_000;
            prop_assert!(down * u128::from(whole) <= exact && exact <= up * u128::from(whole));
            prop_assert!(up - down <= 1);
        }
    }
}
