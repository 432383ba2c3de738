//! B-spline and NURBS curves and surfaces: knots, bases, jets, refinement, interpolation, least squares, construction.
