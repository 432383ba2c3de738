//! Files in and out: point clouds, meshes and NURBS.
