//! Discrete shapes: point clouds and triangle meshes, their normals and closest points.
