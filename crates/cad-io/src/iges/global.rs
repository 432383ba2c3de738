//! The global section: delimiters, name, unit, accuracy.

use super::fault::Fault;
use super::records::Line;
use super::tokens::{Delimiters, Tokens, Value, decoded, integer, real};
use brep_core::description::LengthUnit;

/// What the global section says that matters here.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Global {
    /// Delimiters of all parameter data.
    pub(crate) delimiters: Delimiters,
    /// Product or, without one, file name.
    pub(crate) name: String,
    /// Unit of length, if one is given.
    pub(crate) unit: Option<LengthUnit>,
    /// Length in the model over length of the real thing; 1 as a rule.
    pub(crate) scale: f64,
    /// Smallest distance between points that are to be told apart.
    pub(crate) resolution: Option<f64>,
}

impl Global {
    /// Reads the section.
    pub(crate) fn new(lines: &[Line<'_>]) -> Result<Self, Fault> {
        let Some(first) = lines.first() else {
            return Err(Fault::at_line(1, "the file has no global section (G)"));
        };
        let mut tokens = Tokens::new(lines.iter(), 72, None);
        let value = delimiter(&mut tokens, b',', None)?;
        let record = delimiter(&mut tokens, b';', Some(value))?;
        let delimiters = Delimiters { value, record };
        let allowed =
            |byte: u8| byte.is_ascii_graphic() && !byte.is_ascii_alphanumeric() && !b"+-.".contains(&byte);
        if value == record || !allowed(value) || !allowed(record) {
            let what = format!(
                "the delimiters `{}` and `{}` make no sense",
                value.escape_ascii(),
                record.escape_ascii()
            );
            return Err(Fault::at_line(first.number, what));
        }
        let mut fields = Fields { tokens, delimiters };
        let mut global = Self { delimiters, name: String::new(), unit: None, scale: 1.0, resolution: None };
        let product = fields.text()?;
        let file = fields.text()?;
        global.name = if product.is_empty() { file } else { product };
        for _ in 5..13 {
            fields.skip()?;
        }
        global.scale = fields.real(13)?.unwrap_or(1.0);
        if global.scale <= 0.0 {
            let what = format!("the model space scale (global parameter 13) is {}", global.scale);
            return Err(fields.tokens.fault(what));
        }
        let flag = fields.integer(14)?;
        let line = fields.tokens.line();
        let name = fields.text()?;
        global.unit = unit(flag, &name).map_err(|what| Fault::at_line(line, what))?;
        for _ in 16..19 {
            fields.skip()?;
        }
        global.resolution = fields.real(19)?.filter(|&resolution| resolution > 0.0);
        Ok(global)
    }
}

/// One of the first two parameters, which say what parts and ends the rest.
fn delimiter(tokens: &mut Tokens, usual: u8, value: Option<u8>) -> Result<u8, Fault> {
    let next = tokens.peek();
    let after = value.unwrap_or(usual);
    // Empty: the usual character, then the delimiter itself.
    if next == Some(after) || next.is_none() {
        tokens.skip();
        return Ok(usual);
    }
    let found = tokens.text()?.map(<[u8]>::to_vec);
    let delimiter = match found.as_deref() {
        Some(&[one]) => one,
        _ => {
            let name = if value.is_none() { "parameter delimiter" } else { "record delimiter" };
            return Err(tokens.fault(format!("the {name} is no string of one character (`1H,`)")));
        }
    };
    // The first parameter ends with the very character that it names; the second may end the section.
    let end = value.unwrap_or(delimiter);
    match tokens.peek() {
        Some(byte) if byte == end => tokens.skip(),
        Some(byte) if value.is_some() && byte == delimiter => {}
        _ => return Err(tokens.fault(format!("`{}` is missing after a delimiter", end.escape_ascii()))),
    }
    Ok(delimiter)
}

/// Parameters 3 and later, by their number.
struct Fields {
    tokens: Tokens,
    delimiters: Delimiters,
}

impl Fields {
    fn next(&mut self) -> Result<Value<'_>, Fault> {
        // Writers that leave out the end of the section: all that is missing has its default.
        if self.tokens.peek().is_none() {
            return Ok(Value::Empty);
        }
        self.tokens.next(self.delimiters)
    }

    fn skip(&mut self) -> Result<(), Fault> {
        self.next().map(|_| ())
    }

    fn text(&mut self) -> Result<String, Fault> {
        Ok(match self.next()? {
            Value::Empty => String::new(),
            Value::Text(text) | Value::Plain(text) => decoded(text),
        })
    }

    fn real(&mut self, place: usize) -> Result<Option<f64>, Fault> {
        self.number(place, real)
    }

    fn integer(&mut self, place: usize) -> Result<Option<i64>, Fault> {
        self.number(place, integer)
    }

    fn number<T>(&mut self, place: usize, parse: impl Fn(&[u8]) -> Option<T>) -> Result<Option<T>, Fault> {
        let (text, found) = match self.next()? {
            Value::Empty => return Ok(None),
            Value::Text(text) | Value::Plain(text) => (decoded(text), parse(text)),
        };
        match found {
            Some(found) => Ok(Some(found)),
            None => Err(self.tokens.fault(format!("global parameter {place} is `{text}`, not a number"))),
        }
    }
}

/// Names of the standard, their flags and metres.
const UNITS: [(i64, &[&str], &str, f64); 10] = [
    (1, &["IN", "INCH", "INCHES"], "inch", 0.0254),
    (2, &["MM", "MILLIMETER", "MILLIMETRE", "MILLIMETERS"], "mm", 1e-3),
    (4, &["FT", "FEET", "FOOT"], "ft", 0.3048),
    (5, &["MI", "MILE", "MILES"], "mile", 1609.344),
    (6, &["M", "METER", "METRE", "METERS"], "m", 1.0),
    (7, &["KM", "KILOMETER"], "km", 1e3),
    (8, &["MIL", "MILS"], "mil", 2.54e-5),
    (9, &["UM", "MICRON", "MICRONS"], "µm", 1e-6),
    (10, &["CM", "CENTIMETER", "CENTIMETRE"], "cm", 1e-2),
    (11, &["UIN", "MICROINCH"], "µin", 2.54e-8),
];

/// The unit by its flag, or by its name where the flag is 3 or missing.
fn unit(flag: Option<i64>, name: &str) -> Result<Option<LengthUnit>, String> {
    let name = name.to_ascii_uppercase();
    let row = match flag {
        None | Some(3) if name.is_empty() => return Ok(None),
        None | Some(3) => UNITS.iter().find(|(_, names, ..)| names.contains(&name.as_str())),
        Some(flag) => UNITS.iter().find(|(number, ..)| *number == flag),
    };
    match (row, flag) {
        (Some(&(_, _, name, metres)), _) => Ok(Some(LengthUnit { name: name.to_owned(), metres })),
        (None, None | Some(3)) => Err(format!("the unit `{name}` (global parameter 15) is not known")),
        (None, Some(flag)) => Err(format!("the unit flag (global parameter 14) is {flag}; it is 1 to 11")),
    }
}

/// Flag and name of a unit for a file that is written; flag 3 for one that the standard has no number for.
pub(crate) fn flag_of(unit: &LengthUnit) -> Option<(i64, &'static str)> {
    let same = |metres: f64| (metres / unit.metres - 1.0).abs() < 1e-12;
    UNITS.iter().find(|(.., metres)| same(*metres)).map(|(flag, names, ..)| (*flag, names[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn global(texts: &[&str]) -> Result<Global, Fault> {
        let lines: Vec<Line<'_>> =
            (2..).zip(texts).map(|(number, text)| Line { number, text: text.as_bytes() }).collect();
        Global::new(&lines)
    }

    #[test]
    fn usual_and_other_delimiters() {
        let usual =
            global(&["1H,,1H;,4Hpart,6Hx.iges,1HS,1HP,32,308,15,308,15,,1.,2,2HMM,50,", "0.125,,1D-5,99.;"]);
        let usual = usual.unwrap();
        assert_eq!((usual.name.as_str(), usual.unit), ("part", Some(LengthUnit::millimetre())));
        assert_eq!((usual.scale, usual.resolution), (1.0, Some(1e-5)));
        let by_default = global(&[",,,6Hx.iges,,,,,,,,,1.,6;"]).unwrap();
        assert_eq!((by_default.name.as_str(), by_default.unit), ("x.iges", Some(LengthUnit::metre())));
        assert_eq!(by_default.delimiters, Delimiters { value: b',', record: b';' });
        let other = global(&["1H/,1H#,4Hpart,", "#"]).unwrap_err();
        assert!(other.what.contains("missing"), "{other:?}");
        let other = global(&["1H//1H#/4Hpart///////////3/4HINCH#"]).unwrap();
        assert_eq!(other.delimiters, Delimiters { value: b'/', record: b'#' });
        assert_eq!((other.name.as_str(), other.unit), ("part", Some(LengthUnit::inch())));
        let short = global(&["1H,,1H;;"]).unwrap();
        assert_eq!((short.name.as_str(), short.unit), ("", None));
    }

    #[test]
    fn units_by_flag_and_by_name() {
        assert_eq!(unit(Some(1), "").unwrap(), Some(LengthUnit::inch()));
        assert_eq!(unit(None, "MM").unwrap(), Some(LengthUnit::millimetre()));
        assert_eq!(unit(Some(3), "cm").unwrap().unwrap().metres, 0.01);
        assert_eq!(unit(None, "").unwrap(), None);
        assert!(unit(Some(3), "parsec").is_err() && unit(Some(12), "").is_err());
        assert_eq!(flag_of(&LengthUnit::inch()), Some((1, "IN")));
        let fault = global(&["1H,,1H;,,,,,,,,,,,one,2;"]).unwrap_err();
        assert!(fault.what.contains("parameter 13 is `one`"), "{fault:?}");
    }
}
