//! Numbers as typed, with messages that say what would do; the option is named by the parser of the command line.

/// A positive length.
pub(super) fn length(text: &str) -> Result<f64, String> {
    number(text).filter(|length| *length > 0.0).ok_or_else(|| "it must be a positive length".to_owned())
}

/// A positive number.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    number(text).filter(|number| *number > 0.0).ok_or_else(|| "it must be a positive number".to_owned())
}

/// A positive length, or `inf` for no limit.
pub(super) fn limit(text: &str) -> Result<f64, String> {
    let limit = text.trim().parse::<f64>().ok().filter(|limit| *limit > 0.0);
    limit.ok_or_else(|| "it must be a positive length, or inf for no limit".to_owned())
}

/// A number of any sign.
pub(super) fn signed(text: &str) -> Result<f64, String> {
    number(text).ok_or_else(|| "it must be a finite number".to_owned())
}

/// A number that is not negative.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    number(text).filter(|number| *number >= 0.0).ok_or_else(|| "it must be a number of at least 0".to_owned())
}

/// A share above 0, at most 1.
pub(super) fn share(text: &str) -> Result<f64, String> {
    let share = number(text).filter(|share| *share > 0.0 && *share <= 1.0);
    share.ok_or_else(|| "it must be a share above 0, at most 1".to_owned())
}

/// A share from 0 to 1.
pub(super) fn share_or_none(text: &str) -> Result<f64, String> {
    let share = number(text).filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "it must be a share from 0 to 1".to_owned())
}

/// A number of things, at least 1.
pub(super) fn count(text: &str) -> Result<usize, String> {
    let count = text.trim().parse::<usize>().ok().filter(|count| *count >= 1);
    count.ok_or_else(|| "it must be a whole number of at least 1".to_owned())
}

/// The degree of a curve or surface.
pub(super) fn degree(text: &str) -> Result<usize, String> {
    let degree = text.trim().parse::<usize>().ok().filter(|degree| (1..=DEGREE).contains(degree));
    degree.ok_or_else(|| format!("it must be a whole number from 1 to {DEGREE}"))
}

/// Largest degree that curves and surfaces can have.
const DEGREE: usize = 25;

/// A finite number.
fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|number| number.is_finite())
}

/// Three finite numbers separated by commas.
pub(super) fn triple(text: &str) -> Option<[f64; 3]> {
    let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let triple: [f64; 3] = parts.ok()?.try_into().ok()?;
    triple.iter().all(|value| value.is_finite()).then_some(triple)
}

/// A largest angle in degrees.
pub(super) fn angle(text: &str) -> Result<f64, String> {
    let angle: Option<f64> = text.trim().parse().ok();
    angle
        .filter(|angle| *angle > 0.0 && *angle <= 180.0)
        .ok_or_else(|| "an angle is a number of degrees above 0, at most 180".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_do_is_said() {
        assert_eq!((length("0.05"), positive("45")), (Ok(0.05), Ok(45.0)));
        for bad in ["-0.1", "0", "nan", "inf", "1e999", "", "1,5"] {
            assert!(length(bad).is_err_and(|message| message.contains("positive length")), "{bad}");
        }
        assert_eq!((limit("inf"), signed("-2.5"), not_negative("0")), (Ok(f64::INFINITY), Ok(-2.5), Ok(0.0)));
        assert!(
            limit("-1").is_err()
                && positive("0").is_err()
                && signed("inf").is_err()
                && not_negative("-0.1").is_err()
        );
        assert_eq!((share("1"), share_or_none("0")), (Ok(1.0), Ok(0.0)));
        assert!(share("0").is_err() && share("1.5").is_err() && share_or_none("-0.5").is_err());
        assert_eq!((count("12"), degree("3")), (Ok(12), Ok(3)));
        assert!(
            count("0").is_err() && count("-3").is_err() && count("2.5").is_err() && degree("26").is_err()
        );
    }
}
