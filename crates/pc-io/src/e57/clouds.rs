//! E57 that is read piece by piece with all that points carry.

use super::layout::{Layout, Role};
use super::points::Points;
use super::{Opened, Seen, nothing};
use crate::foreign::Input;
use crate::parsed::Parsed;
use crate::scans::Scan;
use crate::{Error, Format, ReadOptions};

/// What the points of a scan carry, in order; `None` where two scalars are called the same.
fn carried(layout: &Layout) -> Option<(bool, bool, Vec<&str>)> {
    let mut names: Vec<&str> = Vec::new();
    for role in &layout.roles {
        let Role::Scalar(name) = role else { continue };
        if names.contains(&name.as_str()) {
            return None;
        }
        names.push(name);
    }
    Some((layout.has_normals, layout.has_colours, names))
}

/// Hands over the points of the chosen scans in pieces of at most `limit`, then what is left for the report; `None`, before the
/// first piece, where scans carry different things and have to be put together in memory.
pub(crate) fn read_clouds(
    input: Input,
    options: &ReadOptions,
    limit: usize,
    take: &mut dyn FnMut(Parsed) -> Result<bool, Error>,
) -> Result<Option<Parsed>, Error> {
    let mut opened = Opened::open(input, options)?;
    let layouts = opened.scans.iter().map(|scan| Layout::of(scan, opened.length)).collect::<Vec<_>>();
    let mut chosen = Vec::new();
    for &number in &opened.chosen {
        // What is wrong is said as always.
        let Some(Ok(layout)) = layouts.get(number) else { return Ok(None) };
        chosen.push(layout);
    }
    let first = chosen.first().map(|layout| carried(layout));
    if first.as_ref().is_none_or(Option::is_none)
        || chosen.iter().any(|layout| Some(carried(layout)) != first)
    {
        return Ok(None);
    }
    let is_one_of_several = opened.scans.len() > 1;
    let names: Vec<Option<String>> = opened.scans.iter().map(|scan| scan.name.clone()).collect();
    let (mut warnings, mut of_names) = (Vec::new(), None);
    let mut seen = Seen::default();
    let mut doubts = Points::default();
    let mut failed = None;
    opened.visit(limit, &mut warnings, |number, pose, points| {
        seen.add(number, names[number].as_ref(), pose, points.len());
        doubts.take_doubts(points);
        let Some(Ok(layout)) = layouts.get(number) else { return false };
        let piece = std::mem::replace(points, Points::new(layout));
        if piece.len() == 0 {
            return true;
        }
        let scan = Scan { number, name: None, points: piece.len(), pose: None };
        let mut told = Vec::new();
        let cloud = piece.into_cloud(&[scan], is_one_of_several, &mut told);
        of_names.get_or_insert(told);
        match cloud.and_then(|cloud| take(Parsed::cloud(Format::E57, cloud, Vec::new()))) {
            Ok(goes_on) => goes_on,
            Err(error) => {
                failed = Some(error);
                false
            }
        }
    })?;
    if let Some(error) = failed {
        return Err(error);
    }
    doubts.warn(&mut warnings);
    warnings.extend(of_names.unwrap_or_default());
    seen.warn(&mut warnings);
    Ok(Some(Parsed { scans: seen.0, ..Parsed::cloud(Format::E57, nothing(), warnings) }))
}
