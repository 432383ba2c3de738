//! Colours of values and of labels.

use crate::canvas::{Colour, to_f32};

/// Dark blue over green to yellow, of even steps of lightness.
const STOPS: [[f32; 3]; 7] = [
    [0.267, 0.005, 0.329],
    [0.268, 0.224, 0.512],
    [0.191, 0.407, 0.556],
    [0.128, 0.567, 0.551],
    [0.267, 0.749, 0.441],
    [0.636, 0.856, 0.216],
    [0.993, 0.906, 0.144],
];
/// Of a value that is none.
pub(crate) const NOTHING: Colour = [0.78, 0.78, 0.78];

/// The colour of a share between 0 and 1.
pub(crate) fn of_share(share: f64) -> Colour {
    if share.is_nan() {
        return NOTHING;
    }
    let at = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between the stops")]
    let k = (at.floor() as usize).min(STOPS.len() - 2);
    let t = to_f32(at - k as f64);
    [0, 1, 2].map(|c| STOPS[k][c] + (STOPS[k + 1][c] - STOPS[k][c]) * t)
}

/// The colour of a label: hues a golden angle apart, in three lightnesses. Negative labels are grey.
#[must_use]
pub fn of_label(label: i64) -> [f32; 3] {
    if label < 0 {
        return NOTHING;
    }
    let k = label as f64;
    let hue = (0.58 + 0.618_033_988_749_895 * k).fract() * 6.0;
    let light = [0.86, 0.70, 0.95][usize::try_from(label % 3).unwrap_or(0)];
    let saturation = 0.52;
    let part = |offset: f64| {
        let k = (offset + hue) % 6.0;
        to_f32(light * (1.0 - saturation * k.min(4.0 - k).clamp(0.0, 1.0)))
    };
    [part(5.0), part(3.0), part(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_labels_have_colours_of_their_own() {
        assert_eq!(of_share(0.0), STOPS[0]);
        assert_eq!(of_share(2.0), STOPS[6]);
        assert_eq!(of_share(f64::NAN), NOTHING);
        let all: Vec<[f32; 3]> = (0..40).map(of_label).collect();
        for (k, one) in all.iter().enumerate() {
            assert!(one.iter().all(|c| (0.0..=1.0).contains(c)));
            assert!(all[..k].iter().all(|other| other != one));
        }
    }
}
