//! Lines, planes, circles, spheres, cylinders, cones and tori fitted by least squares of orthogonal distances.
