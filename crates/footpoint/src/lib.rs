//! Orthogonal projection of points onto parametric curves and surfaces: local iterations and a certified global search.
