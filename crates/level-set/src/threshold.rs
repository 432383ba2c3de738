//! A level that parts dark from bright (Otsu, *A threshold selection method from gray-level histograms*, 1979).

use crate::{Error, Image};

/// Classes of the histogram: those of 8 bits, which other images are divided into as well.
const BINS: usize = 256;

/// The level in the middle between the medians of the two classes of values whose variance is least.
///
/// The classes are those of Otsu. Pixels on the edges belong to both; medians do not see them, so that an image of two values has its
/// level in the very middle.
///
/// # Errors
/// [`Error::NoContrast`] for an image whose values are all the same.
pub fn otsu(image: &Image) -> Result<f64, Error> {
    image.check_contrast()?;
    let [least, most] = image.range();
    let mut values: Vec<f64> = image.values().to_vec();
    values.sort_by(f64::total_cmp);
    let width = (most - least) / BINS as f64;
    let total: f64 = values.iter().map(|value| (value - least) / width).sum();
    let count = values.len() as f64;
    let (mut best, mut cut) = (-1.0, 0);
    let (mut below, mut sum) = (0usize, 0.0);
    for bin in 1..BINS {
        let limit = least + width * bin as f64;
        while below < values.len() && values[below] < limit {
            sum += (values[below] - least) / width;
            below += 1;
        }
        if below == 0 || below == values.len() {
            continue;
        }
        let (low, high) = (below as f64, count - below as f64);
        let between = low * high * (sum / low - (total - sum) / high).powi(2);
        // Over a gap between the classes the variance stays the same: the first cut counts.
        if between > best * (1.0 + 1e-12) {
            (best, cut) = (between, below);
        }
    }
    if cut == 0 {
        return Err(Error::NoContrast { value: least });
    }
    let median = |part: &[f64]| part[part.len() / 2];
    Ok(0.5 * (median(&values[..cut]) + median(&values[cut..])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_values_are_parted_in_the_middle() {
        for (low, high) in [(0.0, 255.0), (-3.0, 5.0), (1e300, 2e300), (0.1, 0.2)] {
            let values = (0..100).map(|k| if k % 7 == 0 { high } else { low }).collect();
            let level = otsu(&Image::new(10, 10, values).unwrap()).unwrap();
            assert!((level / 2.0 + level / 2.0 - (low / 2.0 + high / 2.0)).abs() <= 1e-12 * high, "{level}");
        }
        assert!(matches!(otsu(&Image::new(4, 4, vec![3.0; 16]).unwrap()), Err(Error::NoContrast { .. })));
    }

    #[test]
    fn two_humps_are_parted_between_them() {
        // Triangles about 60 and 180.
        let values: Vec<f64> = (0..400)
            .map(|k| if k < 300 { 60.0 + f64::from(k % 41) - 20.0 } else { 180.0 + f64::from(k % 31) - 15.0 })
            .collect();
        let level = otsu(&Image::new(20, 20, values).unwrap()).unwrap();
        assert!((level - 120.0).abs() < 3.0, "{level}");
    }
}
