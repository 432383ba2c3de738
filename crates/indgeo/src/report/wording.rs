//! Words for numbers of things.

use std::fmt::Display;
use std::path::Path;

/// A number of things: `1 point`, `2 points`, `1 change of the knots`, `3 vertices`.
pub(crate) fn counted(count: impl Display, thing: &str) -> String {
    let count = count.to_string();
    let (word, rest) = match thing.split_once(" of ") {
        Some((word, rest)) => (word, format!(" of {rest}")),
        None => (thing, String::new()),
    };
    match (count.as_str(), word.strip_suffix("ex")) {
        ("1", _) => format!("{count} {word}{rest}"),
        (_, Some(stem)) => format!("{count} {stem}ices{rest}"),
        (_, None) => format!("{count} {word}s{rest}"),
    }
}

/// Says that points of a file are not finite, and what becomes of them.
pub(crate) fn not_finite(path: &Path, count: usize, points: usize, fate: &str) -> String {
    let have = if count == 1 { "has" } else { "have" };
    format!(
        "{}: {count} of {} {have} a coordinate that is NaN or infinite: {fate}",
        path.display(),
        counted(points, "point")
    )
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_is_not_many() {
        assert_eq!(
            [counted(0, "point"), counted(1, "point"), counted(2, "point")],
            ["0 points", "1 point", "2 points"]
        );
        assert_eq!(counted(2, "change of the knots"), "2 changes of the knots");
        assert_eq!([counted(1, "vertex"), counted(8, "vertex")], ["1 vertex", "8 vertices"]);
    }
}
