//! From scans to CAD: one door to the crates of Industrial Geometry.
