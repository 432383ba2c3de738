//! Files of several scans: which of them are read, and where each stood.

use serde::Serialize;

use crate::{Error, Place};

/// A scan of a file that can hold several, such as E57 and PTX.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scan {
    /// Its place in the file, from 0 on.
    pub number: usize,
    /// Its name, if the file gives one.
    pub name: Option<String>,
    /// Points that were read of it.
    pub points: usize,
    /// Its pose, if the file gives one: rows of the matrix that takes points of the scanner to those of the file. It was
    /// applied to the points.
    pub pose: Option<[[f64; 4]; 4]>,
}

/// The places of the scans that are read: of all, or of the one that `choice` names or numbers, from 0 on.
///
/// # Errors
/// If no scan, or more than one, is called so; the message lists the scans.
pub(crate) fn chosen(choice: Option<&str>, names: &[Option<String>]) -> Result<Vec<usize>, Error> {
    let Some(choice) = choice.filter(|choice| !choice.eq_ignore_ascii_case("all")) else {
        return Ok((0..names.len()).collect());
    };
    let called: Vec<usize> =
        (0..names.len()).filter(|&place| names[place].as_deref() == Some(choice)).collect();
    match (called.as_slice(), choice.parse::<usize>()) {
        ([place], _) => return Ok(vec![*place]),
        ([], Ok(place)) if place < names.len() => return Ok(vec![place]),
        _ => {}
    }
    const SHOWN: usize = 20;
    let name = |place: usize| match &names[place] {
        Some(name) => format!("{place} {name:?}"),
        None => place.to_string(),
    };
    let mut list: Vec<String> = (0..names.len()).take(SHOWN).map(name).collect();
    if names.len() > SHOWN {
        list.push(format!("{} more", names.len() - SHOWN));
    }
    let found =
        if called.len() > 1 { format!("{} scans are", called.len()) } else { "no scan is".to_owned() };
    let list = if list.is_empty() { "there are none".to_owned() } else { list.join(", ") };
    Err(Error::malformed(
        Place::Whole,
        format!("{found} called {choice:?}; the scans are: {list}"),
        "give the number of a scan, or all",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chooses_by_name_before_number() {
        let names = ["front", "2", "rear", "rear"].map(|name| Some(name.to_owned()));
        assert_eq!(chosen(None, &names).unwrap(), [0, 1, 2, 3]);
        assert_eq!(chosen(Some("all"), &names).unwrap(), [0, 1, 2, 3]);
        assert_eq!(chosen(Some("front"), &names).unwrap(), [0]);
        assert_eq!(chosen(Some("2"), &names).unwrap(), [1]);
        assert_eq!(chosen(Some("3"), &names).unwrap(), [3]);
        for wrong in ["rear", "4", "-1", "side"] {
            let error = chosen(Some(wrong), &names).unwrap_err().to_string();
            assert!(error.contains("0 \"front\", 1 \"2\""), "{error}");
        }
    }
}
