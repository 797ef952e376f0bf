"""Geometry on plain arrays: cameras, Lie groups, curvature, meshes, silhouettes, ray casting, distances."""
