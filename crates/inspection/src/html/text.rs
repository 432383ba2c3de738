//! Text for pages.

use std::fmt::Write;

/// Text in which nothing is taken for markup, in elements and in attributes.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Control characters have no place in a page, and some are invisible traps in file names.
            c if c.is_control()
                || ('\u{202a}'..='\u{202e}').contains(&c)
                || ('\u{2066}'..='\u{2069}').contains(&c) =>
            {
                out.push('\u{fffd}');
            }
            c => out.push(c),
        }
    }
    out
}

/// JSON that ends no script element, whatever strings it holds.
#[must_use]
pub fn json_in_script(json: &str) -> String {
    json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

/// A number with six significant digits, as short as they allow.
#[must_use]
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { "–".to_owned() };
    }
    if !(1e-4..1e9).contains(&size) {
        return format!("{value:.5e}").replace('-', "−");
    }
    let digits = (5.0 - size.log10().floor()).clamp(0.0, 9.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 9")]
    let text = format!("{value:.*}", digits as usize);
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "−")
}

/// A table cell that shows a number and carries all its digits.
pub(super) fn cell(value: f64) -> String {
    let mut out = String::new();
    // Writing to memory cannot fail.
    let _ = write!(out, "<td data-value=\"{value:e}\">{}</td>", number(value));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_escapes() {
        assert_eq!(escape("<b a='1'>&\"\n\u{202e}"), "&lt;b a=&#39;1&#39;&gt;&amp;&quot;\u{fffd}\u{fffd}");
        assert_eq!(json_in_script("\"</script><!--\""), "\"\\u003c/script\\u003e\\u003c!--\"");
    }

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 0.1, -12.345_678_9, 1234.0, 123_456_789.0, 1.5e-7, f64::NAN].map(number);
        assert_eq!(shown, ["0", "0.1", "−12.3457", "1234", "123456789", "1.50000e−7", "–"]);
    }
}
