//! Sums of doubles and of their squares without rounding.
//!
//! A sum that is rounded at every step depends on the order of its terms, so that tiles of a cloud, summed apart, would
//! give other bits than the whole. Here the sum is one integer, in units of the square of the smallest double, with one
//! carry-save digit per 32 bits (\[Ne15\]). Any order of additions and merges gives the same integer.

use crate::Error;

/// Bits per digit.
const DIGIT: u32 = 32;
/// Exponent of two that the lowest digit counts: the square of the smallest double.
const LOWEST: i32 = -2148;
/// Digits: up to the square of the largest double times 2⁶⁴ terms.
const DIGITS: usize = 134;
/// Additions after which carries are passed on, so that no digit overflows.
const PENDING_LIMIT: u32 = 1 << 28;

/// An exact sum of finite doubles and of products of two of them.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(into = "Digits", try_from = "Digits")
)]
pub struct ExactSum {
    digits: Box<[i64; DIGITS]>,
    pending: u32,
}

/// The digits that are not zero, as they are written to files.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Digits {
    /// Number of zero digits below.
    first: usize,
    /// Digits, lowest first; the last one carries the sign.
    digits: Vec<i64>,
}

impl Default for ExactSum {
    fn default() -> Self {
        Self { digits: Box::new([0; DIGITS]), pending: 0 }
    }
}

impl ExactSum {
    /// Adds a value. NaN and infinities are ignored.
    pub fn add(&mut self, value: f64) {
        if let Some((mantissa, exponent, negative)) = split(value) {
            self.add_scaled(u128::from(mantissa), exponent, negative);
        }
    }

    /// Adds the square of a value. NaN and infinities are ignored.
    pub fn add_square(&mut self, value: f64) {
        if let Some((mantissa, exponent, _)) = split(value) {
            self.add_scaled(u128::from(mantissa) * u128::from(mantissa), 2 * exponent, false);
        }
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: &Self) {
        self.carry();
        for (digit, term) in self.digits.iter_mut().zip(other.digits.iter()) {
            *digit += term;
        }
        self.carry();
    }

    /// The sum, rounded to the nearest double (beyond the largest: infinite).
    #[must_use]
    pub fn value(&self) -> f64 {
        let (mantissa, exponent) = self.rounded();
        scale(mantissa, exponent)
    }

    /// The root of the sum divided by `count`, without overflow on the way; 0 for a negative sum.
    #[must_use]
    pub fn root_mean(&self, count: u64) -> f64 {
        let (mantissa, exponent) = self.rounded();
        let odd = exponent.rem_euclid(2);
        let mean = mantissa * f64::from(1 + odd) / count.max(1) as f64;
        scale(mean.max(0.0).sqrt(), (exponent - odd) / 2)
    }

    /// `Σ (xᵢ − centre)²` from `self = Σ xᵢ²`, `sum = Σ xᵢ` and the number of terms; exact.
    #[must_use]
    pub(crate) fn about(&self, sum: &Self, centre: f64, count: u64) -> Self {
        let mut out = self.clone();
        let Some((mantissa, exponent, negative)) = split(centre) else { return out };
        let (sum, sum_negative) = sum.magnitude();
        for (place, &digit) in sum.digits.iter().enumerate() {
            let size = u128::from(mantissa) * u128::from(digit.unsigned_abs());
            let shift = LOWEST + place_exponent(place);
            out.add_scaled(size, shift + exponent + 1, negative == sum_negative);
        }
        let square = u128::from(mantissa) * u128::from(mantissa);
        for (half, shift) in [(square & u128::from(u64::MAX), 0), (square >> 64, 64)] {
            out.add_scaled(half * u128::from(count), 2 * exponent + shift, false);
        }
        out
    }

    /// Adds `± size · 2^exponent`.
    fn add_scaled(&mut self, size: u128, exponent: i32, negative: bool) {
        // Terms of lower exponents come from products of digits only, and then the bits shifted out are zero.
        let deficit = u32::try_from(LOWEST - exponent).unwrap_or(0);
        let size = size.checked_shr(deficit).unwrap_or(0);
        let offset = u32::try_from(exponent - LOWEST).unwrap_or(0);
        let (place, shift) = ((offset / DIGIT) as usize, offset % DIGIT);
        let mut add = |place: usize, bits: u128| {
            if let (Some(digit), Ok(bits)) =
                (self.digits.get_mut(place), i64::try_from(bits & u128::from(u32::MAX)))
            {
                *digit += if negative { -bits } else { bits };
            }
        };
        // Up to 128 bits, shifted by up to 31: the lowest digit apart, so that nothing is lost at the top.
        add(place, (size << shift) & u128::from(u32::MAX));
        let mut rest = size >> (DIGIT - shift);
        let mut next = place + 1;
        while rest != 0 {
            add(next, rest);
            rest >>= DIGIT;
            next += 1;
        }
        self.pending += 1;
        if self.pending >= PENDING_LIMIT {
            self.carry();
        }
    }

    /// Passes carries on; then all digits but the last are between 0 and 2³² − 1, and equal sums have equal digits.
    fn carry(&mut self) {
        for place in 0..DIGITS - 1 {
            let carry = self.digits[place] >> DIGIT;
            self.digits[place] -= carry << DIGIT;
            self.digits[place + 1] += carry;
        }
        self.pending = 0;
    }

    fn normalised(&self) -> Self {
        let mut out = self.clone();
        out.carry();
        out
    }

    /// The absolute value, normalised, and whether the sum is negative.
    fn magnitude(&self) -> (Self, bool) {
        let mut sum = self.normalised();
        let negative = sum.digits[DIGITS - 1] < 0;
        if negative {
            sum.digits.iter_mut().for_each(|digit| *digit = -*digit);
            sum.carry();
        }
        (sum, negative)
    }

    /// Mantissa of 53 bits with its sign, and exponent.
    fn rounded(&self) -> (f64, i32) {
        let (sum, negative) = self.magnitude();
        let Some(top) = (0..DIGITS).rev().find(|&place| sum.digits[place] != 0) else { return (0.0, 0) };
        // Four digits hold at least 97 significant bits; what lies below only tells whether a tie is one.
        let bottom = top.saturating_sub(3);
        let mut bits = (bottom..=top)
            .rev()
            .fold(0u128, |bits, place| (bits << DIGIT) | u128::from(sum.digits[place].unsigned_abs()));
        let rest = sum.digits[..bottom].iter().any(|&digit| digit != 0);
        let mut exponent = LOWEST + place_exponent(bottom);
        let spare = (128 - bits.leading_zeros()).saturating_sub(53);
        if spare > 0 {
            let (cut, half) = (bits & ((1 << spare) - 1), 1u128 << (spare - 1));
            bits >>= spare;
            exponent += i32::try_from(spare).unwrap_or(0);
            let up = cut > half || cut == half && (rest || bits & 1 == 1);
            bits += u128::from(up);
        }
        let mantissa = bits as f64;
        (if negative { -mantissa } else { mantissa }, exponent)
    }
}

impl PartialEq for ExactSum {
    fn eq(&self, other: &Self) -> bool {
        self.normalised().digits == other.normalised().digits
    }
}

impl From<ExactSum> for Digits {
    fn from(sum: ExactSum) -> Self {
        let sum = sum.normalised();
        let first = sum.digits.iter().position(|&digit| digit != 0).unwrap_or(0);
        let end = sum.digits.iter().rposition(|&digit| digit != 0).map_or(first, |last| last + 1);
        Self { first, digits: sum.digits[first..end].to_vec() }
    }
}

impl TryFrom<Digits> for ExactSum {
    type Error = Error;
    fn try_from(digits: Digits) -> Result<Self, Error> {
        let end = digits.first.checked_add(digits.digits.len()).filter(|&end| end <= DIGITS);
        let end = end.ok_or(Error::Damaged { what: "a sum has too many digits" })?;
        let mut sum = Self::default();
        sum.digits[digits.first..end].copy_from_slice(&digits.digits);
        if sum.digits.iter().any(|digit| digit.unsigned_abs() > 1 << 48) {
            return Err(Error::Damaged { what: "a digit of a sum is too large" });
        }
        sum.carry();
        Ok(sum)
    }
}

fn place_exponent(place: usize) -> i32 {
    i32::try_from(place).unwrap_or(0) * 32
}

/// Mantissa, exponent and sign of a finite double: `± mantissa · 2^exponent`.
fn split(value: f64) -> Option<(u64, i32, bool)> {
    if !value.is_finite() {
        return None;
    }
    let bits = value.to_bits();
    let fraction = bits & ((1 << 52) - 1);
    let biased = i32::try_from((bits >> 52) & 0x7ff).unwrap_or(0);
    let (mantissa, exponent) =
        if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    Some((mantissa, exponent, value.is_sign_negative()))
}

/// `value · 2^exponent`; the steps on the way are exact unless the result underflows.
fn scale(mut value: f64, mut exponent: i32) -> f64 {
    while exponent > 1000 && value != 0.0 && value.is_finite() {
        value *= power(1000);
        exponent -= 1000;
    }
    while exponent < -1000 && value != 0.0 {
        value *= power(-1000);
        exponent += 1000;
    }
    value * power(exponent.clamp(-1000, 1000))
}

/// `2^exponent` for exponents of normal numbers.
fn power(exponent: i32) -> f64 {
    f64::from_bits(u64::try_from(exponent + 1023).unwrap_or(0) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(values: &[f64]) -> ExactSum {
        let mut sum = ExactSum::default();
        values.iter().for_each(|&value| sum.add(value));
        sum
    }

    #[test]
    fn nothing_is_lost() {
        assert_eq!(sum(&[1e308, 1.0, -1e308, 1e-308, -1.0]).value(), 1e-308);
        assert_eq!(sum(&[0.1; 10]).value(), 1.0);
        assert_eq!(sum(&[-3.5, 1.25]).value(), -2.25);
        assert_eq!(sum(&[]).value(), 0.0);
        assert_eq!(sum(&[f64::MAX, f64::MAX]).value(), f64::INFINITY);
        assert_eq!(sum(&[5e-324; 3]).value(), 1.5e-323);
        assert_eq!(sum(&[f64::NAN, f64::INFINITY, 2.0]).value(), 2.0);
        // Ties go to the even neighbour, unless a bit far below says otherwise.
        let tie = 2f64.powi(-53);
        assert_eq!(sum(&[1.0, tie]).value(), 1.0);
        let odd = 1.0 + f64::EPSILON;
        assert_eq!(sum(&[odd, tie]).value(), odd + f64::EPSILON);
        assert_eq!(sum(&[-odd, -tie]).value(), -odd - f64::EPSILON);
        assert_eq!(sum(&[odd, tie, -1e-300]).value(), odd);
        assert_eq!(sum(&[1.0, tie, 1e-300]).value(), 1.0 + f64::EPSILON);
        assert_eq!(sum(&[1.0, tie, -1e-300]).value(), 1.0);
        assert_eq!(sum(&[-1.0, -tie, -1e-300]).value(), -1.0 - f64::EPSILON);
    }

    #[test]
    fn squares_and_moments() {
        let values = [3e200, -4e200];
        let mut squares = ExactSum::default();
        values.iter().for_each(|&value| squares.add_square(value));
        assert_eq!(squares.value(), f64::INFINITY);
        assert!((squares.root_mean(2) / 12.5f64.sqrt() / 1e200 - 1.0).abs() < 1e-15);

        // A spread of 1 about 1e15: textbook formulas in doubles lose it altogether.
        let values: Vec<f64> = (0..1000).map(|i| 1e15 + f64::from(i % 3)).collect();
        let mut squares = ExactSum::default();
        values.iter().for_each(|&value| squares.add_square(value));
        let total = sum(&values);
        let about = squares.about(&total, 1e15 + 1.0, 1000).value();
        assert_eq!(about, 667.0);
        let negated: Vec<f64> = values.iter().map(|value| -value).collect();
        assert_eq!(squares.about(&sum(&negated), -1e15 - 1.0, 1000).value(), 667.0);
    }

    #[test]
    fn order_and_merging_do_not_matter() {
        let values: Vec<f64> =
            (0..500i32).map(|i| (f64::from(i) * 12.9898).sin() * 10f64.powi(i % 40 - 20)).collect();
        let mut merged = sum(&values[300..]);
        merged.merge(&sum(&values[..100]));
        merged.merge(&sum(&values[100..300]));
        assert_eq!(merged, sum(&values));
        let reversed: Vec<f64> = values.iter().rev().copied().collect();
        assert_eq!(sum(&reversed).value().to_bits(), merged.value().to_bits());
        let mut copy = merged.clone();
        copy.add(5e-324);
        assert_ne!(copy, merged);
        let digits = Digits::from(merged.clone());
        assert_eq!(ExactSum::try_from(digits.clone()), Ok(merged));
        assert!(ExactSum::try_from(Digits { first: DIGITS, ..digits }).is_err());
        // Digits of files may hold carries, but none that sums of many of them could overflow.
        for (digit, is_read) in [(1i64 << 48, true), ((1 << 48) + 1, false), (i64::MIN, false)] {
            for digit in [digit, digit.saturating_neg()] {
                let read = ExactSum::try_from(Digits { first: 70, digits: vec![digit] });
                assert_eq!(read.is_ok(), is_read && digit != i64::MAX, "{digit}");
            }
        }
    }
}
