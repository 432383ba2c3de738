//! Borders of carriers that touch: the curve along which their normals agree.
//!
//! Next to such a border both carriers lie within the noise of a point, so that distances cannot tell on which side it is. The
//! difference of the two normals can: it vanishes on the curve of contact, changes sign there, and depends on the carriers alone, not on
//! the noise of the point.

use nalgebra::Vector3;

use crate::carrier::Carrier;
use crate::graph::as_index;
use crate::grow::{Cloud, NONE, Region};

/// Points that are looked at around one.
const AROUND: usize = 80;
/// Distance in standard deviations within which a carrier may own a point, and beyond which it does not.
const POSSIBLE: f64 = 3.0;
const CERTAIN: f64 = 4.0;
/// Cosine of the largest angle between carriers that touch.
const TOUCHING: f64 = 0.9;

/// Gives points between two carriers that touch to the side on which they lie.
pub(crate) fn cut(cloud: &Cloud<'_>, regions: &[Region], labels: &mut [u32]) {
    let before = labels.to_vec();
    for i in 0..labels.len() {
        let own = before[i];
        if own == NONE {
            continue;
        }
        let Some(carrier) = regions[own as usize].carrier else { continue };
        let mut others: Vec<u32> = Vec::new();
        for &j in cloud.graph.near(i).iter().take(16) {
            let label = before[j as usize];
            if label != own && label != NONE && !others.contains(&label) {
                others.push(label);
            }
        }
        for other in others {
            let Some(second) = regions[other as usize].carrier else { continue };
            if second.at(&cloud.points[i]).0.abs() > POSSIBLE * cloud.sigma
                || carrier.at(&cloud.points[i]).0.abs() > POSSIBLE * cloud.sigma
            {
                continue;
            }
            if is_beyond(cloud, &before, i, (own, &carrier), (other, &second)) {
                labels[i] = other;
                break;
            }
        }
    }
}

/// Difference of the normals of two carriers at a point; `None` where they do not touch.
fn difference(cloud: &Cloud<'_>, i: usize, one: &Carrier, other: &Carrier) -> Option<Vector3<f64>> {
    let (n, m) = (one.at(&cloud.points[i]).1, other.at(&cloud.points[i]).1);
    let dot = n.dot(&m);
    (dot.abs() > TOUCHING).then(|| n - m * dot.signum())
}

/// Whether a point lies on the other side of the curve of contact.
fn is_beyond(
    cloud: &Cloud<'_>,
    labels: &[u32],
    i: usize,
    (own, carrier): (u32, &Carrier),
    (other, second): (u32, &Carrier),
) -> bool {
    let Some(here) = difference(cloud, i, carrier, second) else { return false };
    let (mut mine, mut theirs) = ((Vector3::zeros(), 0), (Vector3::zeros(), 0));
    let mut seen = vec![as_index(i)];
    let mut k = 0;
    while k < seen.len() && seen.len() < AROUND {
        for &j in cloud.graph.around(seen[k] as usize) {
            let label = labels[j as usize];
            if (label == own || label == other) && !seen.contains(&j) {
                seen.push(j);
                let x = &cloud.points[j as usize];
                let far = if label == own { second } else { carrier };
                if far.at(x).0.abs() < CERTAIN * cloud.sigma {
                    continue;
                }
                let Some(u) = difference(cloud, j as usize, carrier, second) else { continue };
                let side = if label == own { &mut mine } else { &mut theirs };
                side.0 += u;
                side.1 += 1;
            }
        }
        k += 1;
    }
    if mine.1 < 3 || theirs.1 < 3 {
        return false;
    }
    let (a, b) = (mine.0 / f64::from(mine.1), theirs.0 / f64::from(theirs.1));
    // The sides must lie opposite to each other, else the carriers cross or share no curve here.
    a.dot(&b) < 0.0 && here.dot(&(a - b)) < 0.0
}
