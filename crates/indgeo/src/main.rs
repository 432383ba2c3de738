//! Industrial Geometry on the command line.
fn main() {}
