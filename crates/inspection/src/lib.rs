//! Deviations of a cloud from a shape: statistics, tolerance bands, colour maps and reports.
