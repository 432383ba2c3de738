//! The frame of self-contained HTML pages: heading, verdict, two columns, and the report as JSON.
//!
//! Pages have the style of that of an inspection. Their pictures are SVG, and their policy forbids scripts and the network.

use industrial_geometry::inspection::html::{CSS, escape, json_in_script};
use std::fmt::Write as _;
use std::io::{self, Write};

/// A page.
#[derive(Debug, Default)]
pub(crate) struct HtmlPage {
    pub(crate) title: String,
    /// Whether all is well, and the word for it.
    pub(crate) verdict: (bool, String),
    /// The most important numbers.
    pub(crate) headline: String,
    /// What was done to what.
    pub(crate) sentence: String,
    /// Sections of the left column, as markup.
    pub(crate) left: String,
    /// Sections of the right column.
    pub(crate) right: String,
    /// The report.
    pub(crate) json: String,
}

impl HtmlPage {
    /// Writes it.
    pub(crate) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let title = escape(&self.title);
        let class = if self.verdict.0 { "pass" } else { "fail" };
        let mark = if self.verdict.0 { '✓' } else { '✗' };
        write!(
            out,
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:\">\n\
             <meta name=\"generator\" content=\"indgeo {}\">\n<title>{title}</title>\n<style>\n{CSS}\n\
             .views {{ display: flex; flex-wrap: wrap; gap: 12px; }} .views svg {{ border: 1px solid var(--line); background: #fff; }}\n\
             </style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n<span class=\"verdict {class}\">{mark} {}</span>\n\
             <span>{}</span>\n<p>{}</p>\n</header>\n<main>\n<div>\n{}</div>\n<div>\n{}</div>\n</main>\n\
             <script type=\"application/json\" id=\"report\">{}</script>\n</body>\n</html>\n",
            env!("CARGO_PKG_VERSION"),
            escape(&self.verdict.1),
            escape(&self.headline),
            escape(&self.sentence),
            self.left,
            self.right,
            json_in_script(&self.json)
        )
    }
}

/// A section with a heading; the content is markup.
pub(crate) fn section(heading: &str, content: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{content}</section>\n", escape(heading))
}

/// A small remark.
pub(crate) fn note(text: &str) -> String {
    format!("<p class=\"note\">{}</p>\n", escape(text))
}

/// Names and values.
pub(crate) fn table(rows: &[(String, String)]) -> String {
    let mut out = "<table>\n<tbody>\n".to_owned();
    for (name, value) in rows {
        // Writing to memory cannot fail.
        let _ = writeln!(out, "<tr><th scope=\"row\">{}</th><td>{}</td></tr>", escape(name), escape(value));
    }
    out.push_str("</tbody>\n</table>\n");
    out
}

/// A square of a colour with what it stands for.
pub(crate) fn swatch(colour: &str, text: &str) -> String {
    format!("<span class=\"swatch\" style=\"background:{colour}\"></span>{} &nbsp; ", escape(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_no_markup() {
        let page = HtmlPage {
            title: "Fit of <b>.xyz".to_owned(),
            right: table(&[("<i>".to_owned(), "1 & 2".to_owned())]),
            json: "{\"name\":\"</script>\"}".to_owned(),
            ..HtmlPage::default()
        };
        let mut out = Vec::new();
        page.write(&mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.contains("<h1>Fit of &lt;b&gt;.xyz</h1>") && text.contains("&lt;i&gt;"));
        assert_eq!(text.matches("</script>").count(), 1);
        assert!(text.contains("class=\"verdict fail\""));
    }
}
